// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tables/json.h"
#include <Eigen/Core>

namespace sarblock {

/// Numbers of JSON files; each refuses what is not finite, with file and key.
[[nodiscard]] double FiniteNumber(const JsonValue& value);
[[nodiscard]] double PositiveNumber(const JsonValue& value);
[[nodiscard]] std::vector<double> FiniteNumbers(const JsonValue& list);
/// Refuses another number of numbers.
[[nodiscard]] std::vector<double> FiniteNumbers(const JsonValue& list, std::size_t count);
/// Three numbers.
[[nodiscard]] Eigen::Vector3d FiniteVector(const JsonValue& list);
/// An integer of 1 or more.
[[nodiscard]] std::uint64_t CountOfOne(const JsonValue& value);

}  // namespace sarblock
