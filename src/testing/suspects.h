// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/result.h"

#include <cstdint>
#include <string>
#include <vector>

#include "residual_covariance.h"

namespace sarblock {

/// Tests whose correlation is beyond this are one test.
inline constexpr double kSameTest_1 = 0.999;
/// A point is still determined where, in its weakest direction, this part of its information is
/// left: its standard deviation grows a hundredfold at most.
inline constexpr double kLeastInformationPart_1 = 1e-4;

/// The observations of a point any one of which alone may have caused its largest |w|.
struct SuspectSet {
  double largest_w_1 = 0.0;
  bool azimuth = false;              ///< the component of the largest |w|
  std::vector<std::uint64_t> looks;  ///< the one of the largest |w| first
  bool control = false;              ///< the known position too
  bool rest_determines = false;      ///< what is left determines the point
};

/// Were k the blunder, w_i freed of it would be standard normal (docs/theory/quality.md, eq. (14)):
///     w_i.k = (w_i - rho w_k) / sqrt(1 - rho^2)
/// so k may be the cause of the largest, w_i, unless |w_i.k| > N^-1((1 + separation) / 2). Both
/// components of a look count as the look.
[[nodiscard]] SuspectSet FindSuspects(const PointResiduals& residuals, double separation_1);

/// True where the point is determined without the looks (and the known position) of the set.
[[nodiscard]] bool RestDetermines(const PointResiduals& residuals, const SuspectSet& set);

/// How far a removal can reach: the sum of |w| sqrt(h / r) over what is removed, h the part that
/// the corrections take of a residual. Any correlation with a test of another point is at most
/// sqrt(h_i h_k / (r_i r_k)), docs/theory/quality.md, eq. (15).
[[nodiscard]] double ReachOf(const PointResiduals& residuals, const SuspectSet& set);

/// True where the point's largest |w| would stay above `critical_1` whatever removals of that reach
/// in other points explain of it.
[[nodiscard]] bool StandsAlone(const PointResiduals& residuals, double reach_1, double critical_1);

/// "its observations contradict each other and nothing tells which is wrong: A1, A2".
[[nodiscard]] std::string DescribeContradiction(const Block& block, const SuspectSet& set);

/// Observations that have a test.
[[nodiscard]] std::size_t CountTests(const LookQuality& quality,
                                     const std::vector<ControlQuality>& control);

}  // namespace sarblock
