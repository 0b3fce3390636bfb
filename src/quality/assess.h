// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "verdict_tests.h"

namespace sarblock {

/// Detectable size of an error in one observation; NaN where there is no test.
struct BlunderSize {
  double sigma_m = kNotGiven;       ///< standard deviation that the observation was weighted with
  double detectable_m = kNotGiven;  ///< minimal detectable blunder, delta0 sigma / sqrt(r)
  double influence_m = kNotGiven;   ///< how far one of that size moves the point
};

/// Minimal detectable blunders of a result and their influence (docs/theory/quality.md), with the
/// standard deviations that the result was made with: those of the block, times the square roots of
/// the variance components where they were estimated. `factor` multiplies all variances (the
/// posterior variance factor where covariances are scaled by it).
class BlunderSizes {
 public:
  BlunderSizes(const Block& block,
               const AdjustOptions& options,
               const AdjustResult& result,
               double factor);
  /// Range and azimuth of a look of `point`. The result has quality figures.
  [[nodiscard]] std::array<BlunderSize, 2> LookSizes(std::uint64_t look, std::size_t point) const;
  [[nodiscard]] BlunderSize ControlSize(const ControlQuality& control) const;

 private:
  const Block& block_;
  const AdjustResult& result_;
  double delta0_;
  double scale_;                                      // on standard deviations
  std::vector<std::array<double, 2>> sigma_factors_;  // by pass, range and azimuth
};

/// Multiplies the figures that AdjustResult::posterior_factor names by PosteriorFactor(), once.
/// This is the last step of a result, because all tests use the standard deviations that the
/// observations were given.
void ScaleByPosterior(const AdjustOptions& options, AdjustResult* result);

/// The tests of priors at the level of one observation (ReliabilityOf).
[[nodiscard]] PriorSummary SummarisePriors(const AdjustOptions& options,
                                           const AdjustResult& result);

/// Shares by pass in the order of the block, then of shared groups; empty without redundancy
/// numbers.
[[nodiscard]] std::vector<PassShare> SharesOf(const Block& block, const AdjustResult& result);

/// Levels and critical values of a result's tests; counts those of its quality figures.
[[nodiscard]] ReliabilityFigures ReliabilityOf(const AdjustOptions& options,
                                               const AdjustResult& result);

/// Studentised residual w / s0 (Pope 1976), s0^2 the variance factor; NaN without one.
[[nodiscard]] double TauOf(double w, const AdjustResult& result);

/// Pixels and lines of a shift [m] in range and azimuth of a look whose point is at `p_m`: the
/// azimuth as a time over the line interval, of a measured Doppler how far the cone passes beside
/// the point. On the nominal path: a correction of 10 m changes the rates by a hundred-thousandth.
/// NaN where the pass has no raster, and where the raster or the path does not reach.
/// docs/theory/image_coordinates.md, eq. (5).
[[nodiscard]] std::array<double, 2> InRaster(const Block& block,
                                             std::uint64_t look,
                                             const Eigen::Vector3d& p_m,
                                             const std::array<double, 2>& shift_m);

/// Standard deviation of a look's azimuth in metres at the target; where it is given in seconds by
/// the azimuth rate at `p_m` on the nominal path: to the relative change of the velocity by the
/// corrections.
[[nodiscard]] double AzimuthSigma_m(const Block& block,
                                    std::uint64_t look,
                                    const Eigen::Vector3d& p_m);

[[nodiscard]] QualitySummary SummariseQuality(const Block& block,
                                              const AdjustOptions& options,
                                              const AdjustResult& result);

[[nodiscard]] CheckSummary SummariseChecks(const AdjustResult& result, double level);

/// "The predicted accuracy is realistic: errors of check points are 1.04 times as large as
/// predicted, 0.9 to 1.1 is allowed (95 %)."; empty without check points.
[[nodiscard]] std::string DescribeChecks(const CheckSummary& summary, double level);

/// One line a finding of the search for blunders, with the words of the field.
[[nodiscard]] std::string DescribeFinding(const Block& block, const BlunderFinding& finding);
/// "rejected", "point left out", "control released", "kept", "readmitted".
[[nodiscard]] const char* NameOf(BlunderFinding::Action action);

/// Fills `assessment` of a result that is complete but for it: the figures of its tests and the
/// verdict. Reasons that are there already (`Refuse`) make it `not accepted`; so does, in an
/// adjustment whose standard deviations are not scaled by it, a variance factor above 10. A test
/// that fails makes it `converged, tests failed`: the global test and the check points at
/// `test_level`; the tests of observations and of priors where a block without mistakes would fail
/// once in a thousand (docs/theory/quality.md, section "The verdict").
void Assess(const Block& block, const AdjustOptions& options, AdjustResult* result);

}  // namespace sarblock
