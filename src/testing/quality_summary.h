// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/result.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "reliability.h"

namespace sarblock {

/// Levels and critical values of a result's tests; counts those of its quality figures.
[[nodiscard]] ReliabilityFigures ReliabilityOf(const AdjustOptions& options,
                                               const AdjustResult& result);

/// Studentised residual w / s0 (Pope 1976), s0^2 the variance factor; NaN without one.
[[nodiscard]] double TauOf(double w_1, const AdjustResult& result);

/// Standard deviation of a look's azimuth in metres at the target; where it is given in seconds by
/// the azimuth rate at `p_m` on the nominal path: to the relative change of the velocity by the
/// corrections.
[[nodiscard]] double AzimuthSigma_m(const Block& block,
                                    std::uint64_t look,
                                    const Eigen::Vector3d& p_m);

/// One observation whose test is among the largest.
struct TestedLook {
  std::uint64_t look = 0;
  std::uint32_t point = 0;
  bool azimuth = false;
  double w_1 = 0.0;
  double redundancy_1 = 0.0;
};

/// The tests of a result in short. Above the critical value counts |w| or, where that is the test,
/// |tau|.
struct QualitySummary {
  ReliabilityFigures figures;
  std::array<std::size_t, 2> looks_tested{};  ///< range, azimuth
  std::array<std::size_t, 2> looks_above{};
  std::size_t control_tested = 0, control_above = 0;
  /// Looks tested whose point has one degree of freedom: all its tests are one.
  std::size_t looks_not_localisable = 0;
  std::array<double, 2> median_redundancy_1{};  ///< NaN without looks
  std::vector<TestedLook> worst;                ///< largest |w| first, at most ten
};
[[nodiscard]] QualitySummary SummariseQuality(const Block& block,
                                              const AdjustOptions& options,
                                              const AdjustResult& result);

/// Check points together. The sum of their chi-squares has the expectation `components` if the
/// predicted accuracy is realistic. The interval is that of a chi-square of `freedom` degrees,
/// scaled to that expectation: errors of check points are correlated by the paths they share.
struct CheckSummary {
  std::size_t points = 0;  ///< compared: solved and, where there are covariances, with one
  /// Check points that have an error but no standard deviation (left out as contradictory): they
  /// count in no figure here.
  std::size_t points_without_sigma = 0;
  std::array<double, 3> rms_m{};  ///< east, north, up of the points compared; NaN: not known
  int components = 0;
  double freedom_1 = 0.0;  ///< independent components they are worth
  double chi_square = 0.0;
  Interval chi_square_interval;    ///< two-sided at test_level
  std::size_t points_outside = 0;  ///< chi-square alone above the quantile at test_level
  /// sqrt(chi_square / components): errors in units of what was predicted, and its interval.
  double error_ratio_1 = kNotGiven;
  Interval error_ratio_interval_1;
  [[nodiscard]] bool realistic() const { return chi_square_interval.Contains(chi_square); }
};
[[nodiscard]] CheckSummary SummariseChecks(const AdjustResult& result, double level);

/// "The predicted accuracy is realistic: errors of check points are 1.04 times as large as
/// predicted, 0.9 to 1.1 is allowed (95 %)."; empty without check points.
[[nodiscard]] std::string DescribeChecks(const CheckSummary& summary, double level);

/// One line a finding of the search for blunders, with the words of the field.
[[nodiscard]] std::string DescribeFinding(const Block& block, const BlunderFinding& finding);
/// "rejected", "point left out", "control released", "kept", "readmitted".
[[nodiscard]] const char* NameOf(BlunderFinding::Action action);

}  // namespace sarblock
