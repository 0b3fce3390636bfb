// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "result_folder.h"

namespace sarblock {

/// What changed from one result to another, points matched by name.
struct ResultDifference {
  struct Point {
    std::uint32_t a = 0, b = 0;       ///< indices in the two results
    std::array<double, 3> shift_m{};  ///< b - a in east, north, up (local: x, y, z)
    double shift_length_m = 0.0;
    /// Largest of the three components in units of the larger of the two standard deviations; NaN
    /// where neither result has one.
    double shift_sigmas = kAbsent;
    std::array<double, 3> sigma_ratio{kAbsent, kAbsent, kAbsent};  ///< b over a
  };
  std::vector<Point> common;  ///< solved in both
  std::size_t only_in_a = 0, only_in_b = 0;
  struct Parameter {
    std::uint32_t a = 0, b = 0;
    double change = 0.0;             ///< b - a, in the parameter's unit
    double change_sigmas = kAbsent;  ///< in units of the larger standard deviation
  };
  std::vector<Parameter> parameters;  ///< in both
  std::size_t parameters_only_in_a = 0, parameters_only_in_b = 0;
  /// Keys of the configuration whose values differ: key, value in a, value in b ("" : not there).
  std::vector<std::array<std::string, 3>> settings;
  /// Input files that differ, by name.
  std::vector<std::string> inputs;
};
[[nodiscard]] ResultDifference CompareResults(const ResultFolder& a, const ResultFolder& b);

}  // namespace sarblock
