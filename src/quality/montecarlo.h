// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <array>
#include <cstdint>
#include <vector>

#include "model/problem.h"

namespace sarblock {

/// Noise-free observations of the solution.
struct ExactReadings {
  // By look in use:
  std::vector<double> range_m;        ///< the range equation's solution
  std::vector<double> azimuth;        ///< the cone equation's: time [s] or measured Doppler [Hz]
  std::vector<double> azimuth_sigma;  ///< of that
};

/// Readings of the solution `state`: points, corrected paths and biases as estimated. Throws
/// InputError where the time of a look leaves its path.
[[nodiscard]] ExactReadings ReadExactly(const AdjustmentProblem& problem, const BlockState& state);

/// Draws everything that an adjustment treats as random, about a solution: the looks' ranges and
/// times or Dopplers, the control coordinates and the priors' values. `block` is a copy of
/// problem.block. One stream of random numbers a look, a control point and a parameter: a function
/// of seed and run.
void ResampleObservations(const AdjustmentProblem& problem,
                          const BlockState& state,
                          const ExactReadings& exact,
                          std::uint64_t seed,
                          std::uint64_t run,
                          Block* block,
                          std::vector<double>* prior_values);

/// What one run of drawn noise adds to a MonteCarloReport: figures averaged over its points.
struct MonteCarloRun {
  bool converged = false;
  std::array<double, 3> variance_ratio{};  ///< of e_i^2 / Q_ii, i east, north, up
  double square = 0.0;                     ///< of e' Q^-1 e / 3
  std::array<double, 3> inside{};          ///< part of the points inside each ellipsoid
};

/// Sums of one point over the runs that converged, e its error in standard deviations:
/// n_i = e_i / sqrt(Q_ii).
struct MonteCarloPoint {
  std::array<double, 6> product{};        ///< of n_i n_j: ee, nn, uu, en, eu, nu
  double square = 0.0;                    ///< of e' Q^-1 e
  std::array<std::uint32_t, 3> inside{};  ///< runs inside each ellipsoid
  std::uint32_t point = 0;                ///< of the block
};

/// Runs of drawn noise about a solution.
struct MonteCarloDraws {
  std::vector<MonteCarloRun> runs;      ///< by number
  std::vector<MonteCarloPoint> points;  ///< those that are compared, in the order of the block
};

/// Repeats the adjustment of a solved block options.montecarlo_runs times, each with noise drawn
/// anew about the solution (ResampleObservations) and started from it, and compares the errors with
/// the rigorous covariance `covariance_m2`, by point in east, north, up. Same weights, looks and
/// groups as the solution's, by least squares; blunders are not simulated. Runs are parallel; what
/// a run adds depends neither on the number of threads nor on the other runs.
/// docs/theory/montecarlo.md.
[[nodiscard]] MonteCarloDraws DrawMonteCarlo(const AdjustmentProblem& problem,
                                             const BlockState& state,
                                             const AdjustOptions& options,
                                             const std::vector<SymmetricEnu>& covariance_m2,
                                             ProgressSink* progress);

/// Report of the runs on `covariance_m2`, by point in east, north, up, with which they were
/// compared. docs/theory/montecarlo.md, Eq. 1 to 4. `seed` is that of the draws.
[[nodiscard]] MonteCarloReport ReportMonteCarlo(const MonteCarloDraws& draws,
                                                std::uint64_t seed,
                                                const std::vector<SymmetricEnu>& covariance_m2);

}  // namespace sarblock
