// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "linear/block_matrix.h"
#include "model/problem.h"

namespace sarblock {

/// Points whose three rows each stand in the border of the reduced matrix, ascending.
struct BorderedPoints {
  std::vector<std::uint32_t> points;

  [[nodiscard]] int rows() const { return 3 * static_cast<int>(points.size()); }
  /// First row of a point, or -1 where it is eliminated.
  [[nodiscard]] int RowOf(std::size_t point) const {
    if (points.empty()) return -1;
    const auto at = std::lower_bound(points.begin(), points.end(), point);
    return at == points.end() || *at != point ? -1 : 3 * static_cast<int>(at - points.begin());
  }
};

/// Where the reduced matrix has blocks, which points stand in its border, and how much the looks in
/// use have together.
///
/// A point couples all passes that see it: thousands of them would make the matrix dense. Such
/// points, where they are few, stay out of the pattern; three rows of the border say what each
/// takes (linear/block_cholesky.h; docs/theory/covariance.md, "Points that many passes see").
struct ReducedPattern {
  std::shared_ptr<const BlockPattern> pattern;
  BorderedPoints bordered;
  std::size_t looks = 0, columns = 0;
};

/// From the looks that take part. Without `allow_border` every point is eliminated.
[[nodiscard]] ReducedPattern FindPattern(const AdjustmentProblem& problem, bool allow_border);

}  // namespace sarblock
