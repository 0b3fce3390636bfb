// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "model/problem.h"
#include <Eigen/Core>

namespace sarblock {

/// A sample of a block solved by least squares, as far as it can be.
struct Fit {
  bool solved = false;
  double square_sum_1 = 0.0;  ///< v'Pv of what has a place
  double redundancy_1 = 0.0;
  std::size_t looks = 0;  ///< that have a place
  std::size_t lost = 0;   ///< looks without one, or whose point lies where they do not look to
  /// Sum of ln sigma^2 of the measurements less that of the sample as it was given, times the
  /// redundancy of a measurement.
  double log_sigmas_1 = 0.0;
  int formed = 0;        ///< times that the system was formed
  bool settled = false;  ///< the solution converged
  BlockState state;

  /// v'Pv with a look that has no place counted by kLost_1.
  [[nodiscard]] double SquareSum() const;
  /// -2 log of the restricted likelihood but for a constant (docs/theory/diagnosis.md, eq. (2)).
  [[nodiscard]] double Cost() const { return SquareSum() + log_sigmas_1; }
};

/// What a look without a place counts: residuals of 30 sigma in range and azimuth.
inline constexpr double kLost_1 = 1800.0;

/// How often a solution may form its system. A hypothesis that is right is there after two or three
/// times; the others need not get there.
enum class Effort { kQuick, kFull };

struct FitOptions {
  /// State of another fit of the same points to start from, which leaves out what has no place
  /// there. None: start values of the sample's own.
  const BlockState* warm = nullptr;
  Effort effort = Effort::kFull;
  /// v'Pv above which the fit is of no use: it may be given up (SolveOptions).
  double useless_above_1 = std::numeric_limits<double>::infinity();
};

/// Solves the sample. Never throws but Interrupted: what cannot be solved is a Fit that is not.
[[nodiscard]] Fit SolveSample(const Block& sample,
                              const CorrectionModel& corrections,
                              const FitOptions& options,
                              ProgressSink* progress);

/// Of every look at a fit, NaN where it has none; columns range and azimuth.
struct SampleResiduals {
  Eigen::MatrixX2d whitened_1;    ///< over their standard deviations
  Eigen::MatrixX2d redundancy_1;  ///< part of an error of the measurement that its own residual
                                  ///< shows while corrections stay: 1 less what its point follows
};
[[nodiscard]] SampleResiduals ResidualsOf(const Block& sample,
                                          const CorrectionModel& corrections,
                                          const Fit& fit);

}  // namespace sarblock
