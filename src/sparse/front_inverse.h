// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

#include "front_division.h"

namespace sarblock::sparse {

/// The blocks of S^-1 on the pattern of S, to `values`, which all ranks have afterwards. `factor`
/// are the own panels. Returns the doubles that the fronts of this rank took at once. Throws
/// OtherRankFailed.
std::size_t InvertFronts(const OwnFronts& own, const double* factor, std::span<double> values);

}  // namespace sarblock::sparse
