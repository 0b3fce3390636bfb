// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace sarblock {

/// A figure of one run, averaged over the runs: the runs are independent, the points of one are
/// not. The interval holds the expectation with 99 percent (normal).
struct RunMean {
  double expected_1 = 0.0;
  double mean_1 = 0.0;
  double standard_error_1 = 0.0;
  [[nodiscard]] double lower() const;
  [[nodiscard]] double upper() const;
  /// True where the interval holds what is expected.
  [[nodiscard]] bool Agrees() const;
};

/// Errors of repeated noise against the rigorous covariance (montecarlo.h,
/// docs/theory/montecarlo.md).
struct MonteCarloReport {
  static constexpr std::array<double, 3> kLevels{0.5, 0.9, 0.99};
  int runs = 0;    ///< that were adjusted; the figures are theirs
  int failed = 0;  ///< that did not converge
  std::uint64_t seed = 0;
  std::size_t points = 0;  ///< compared: solved, with a covariance

  /// By point of the block; NaN or 0 where not compared. Mean of e e' over the runs, e the error
  /// of a run against the solution it was drawn from, in east, north, up: ee, nn, uu, en, eu, nu
  /// [m2].
  std::vector<std::array<double, 6>> sample_m2;
  std::vector<double> square_1;                      ///< mean of e' Q^-1 e / 3
  std::array<std::vector<std::uint32_t>, 3> inside;  ///< runs inside the ellipsoid of kLevels

  /// Mean over points of e_i^2 / Q_ii, i east, north, up; of e' Q^-1 e / 3.
  std::array<RunMean, 3> variance_ratio;
  RunMean square_ratio;
  std::array<RunMean, 3> coverage;  ///< part of the points inside the ellipsoids of kLevels
  /// Points whose sum of e' Q^-1 e lies outside the 99 percent interval of chi-square.
  std::size_t points_outside = 0;
  std::string sentence;  ///< what it says, for people
};

}  // namespace sarblock
