// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/adjust/elimination.h"
#include "sarblock/adjust/problem.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace sarblock {

/// The factors of all points of one linearisation, kept from the sum of S to the sweep over the
/// points, so that a look is evaluated once for both (BytesFor). Recomputed factors are the same to
/// the bit; large blocks are left to that.
class KeptFactors {
 public:
  /// Memory that may be kept: some 40,000 points of five looks with six parameters.
  static constexpr std::size_t kMostBytes = std::size_t{32} << 20;

  /// `bytes`: what BytesFor says of them, taken at once.
  KeptFactors(std::size_t points, std::size_t parts, std::size_t bytes);

  /// Keeps the undamped factor of a point; one thread a part. A point with a look that has no value
  /// is not kept.
  void Keep(std::size_t part, std::size_t point, const PointFactor& factor);

  /// What FactorPoint would give as far as elimination and sweep read it: Q, R, e and of every look
  /// its index, columns, rows and error_1. False for a point that was not kept or has other looks
  /// now.
  [[nodiscard]] bool Restore(const AdjustmentProblem& problem,
                             std::size_t point,
                             PointFactor* out) const;

  /// Memory for points with so many looks and local columns of looks together.
  [[nodiscard]] static std::size_t BytesFor(std::size_t points,
                                            std::size_t looks,
                                            std::size_t columns) {
    return sizeof(double) * (13 * points + 8 * looks + 2 * columns);
  }

 private:
  static constexpr std::size_t kNone = 0;  // a part's first number is not a point's
  std::vector<std::size_t> begin_;         // by point, in its part
  std::vector<std::uint32_t> part_;
  std::vector<std::vector<double>> parts_;
};

}  // namespace sarblock
