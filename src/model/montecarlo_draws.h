// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/statistics.h"

#include <array>
#include <cstdint>
#include <vector>

namespace sarblock {

/// What one run of drawn noise adds to a MonteCarloReport: figures averaged over its points.
struct MonteCarloRun {
  std::uint32_t run = 0;  ///< number, from 0
  bool converged = false;
  std::array<double, 3> variance_ratio_1{};  ///< of e_i^2 / Q_ii, i east, north, up
  double square_1 = 0.0;                     ///< of e' Q^-1 e / 3
  std::array<double, 3> inside_1{};          ///< part of the points inside each ellipsoid
};

/// Sums of one point over the runs that converged, e its error in standard deviations:
/// n_i = e_i / sqrt(Q_ii).
struct MonteCarloPoint {
  std::array<ExactSum, 6> product;        ///< of n_i n_j: ee, nn, uu, en, eu, nu
  ExactSum square;                        ///< of e' Q^-1 e
  std::array<std::uint32_t, 3> inside{};  ///< runs inside each ellipsoid
  std::uint32_t point = 0;                ///< of the block
};

/// Runs of drawn noise about a solution, all or a part of them, as they are before they make a
/// report: sums are exact, so that those of parts may be added in any order.
/// docs/theory/montecarlo.md, "In parts".
struct MonteCarloDraws {
  /// FNV-1a over positions, corrections and covariances of the solution: the draws are about these
  /// bytes.
  std::uint64_t solution = 0;
  std::vector<MonteCarloRun> runs;      ///< those that were drawn, by number
  std::vector<MonteCarloPoint> points;  ///< those that are compared, in the order of the block
};

}  // namespace sarblock
