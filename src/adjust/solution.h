// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/adjust/adjust.h"
#include "sarblock/adjust/block_structure.h"
#include "sarblock/adjust/ceres_engine.h"
#include "sarblock/adjust/inner_datum.h"
#include "sarblock/adjust/problem.h"
#include "sarblock/adjust/reduced_system.h"

#include <functional>
#include <optional>
#include <string>

namespace sarblock {

/// Steps that adjustment, prediction and intersection share: from a problem at its final state to
/// the result.

/// What a caller wants of the problem and its state at the solution, before they go.
using AtSolution = std::function<void(const AdjustmentProblem&, const BlockState&, AdjustResult*)>;
/// Adjust() of corrections that are given or none; `at_solution` may be empty.
[[nodiscard]] AdjustResult AdjustGiven(const Block& block,
                                       const AdjustOptions& options,
                                       const Simplified& simplified,
                                       const PointPairs& pairs,
                                       const AtSolution& at_solution,
                                       ProgressSink* progress);

/// The same of a selection, at its last solution.
using AtSelection =
    std::function<void(const AdjustmentProblem&, const BlockState&, SelectionReport*)>;
[[nodiscard]] SelectionReport SelectCorrectionsThen(const Block& block,
                                                    const AdjustOptions& options,
                                                    const AtSelection& at_selection,
                                                    ProgressSink* progress);

/// True where p lies on the side the antenna looks to and below it: a mirror solution does not.
[[nodiscard]] bool LiesWhereItLooks(const Frame& frame,
                                    const Sight& sight,
                                    const Eigen::Vector3d& p_m);

/// Points that a poor start led away: to where their looks leave a direction open, or to the mirror
/// solution, above the antennas or on the side they do not look to. Control points are fixed.
/// `system` is the reduced one, without a loss, at the state.
[[nodiscard]] std::vector<std::size_t> MisplacedPoints(const AdjustmentProblem& problem,
                                                       const BlockState& state,
                                                       const ReducedSystem& system);

/// Solves a problem by the engine that is asked for, the weights formed anew as the solution comes
/// near; least squares end with whole Newton steps, the same for both engines. `solved`, where
/// given, becomes the reduced system, without a loss and undamped, formed at the solution.
[[nodiscard]] SolveReport SolveRounds(const Weighting& weighting,
                                      const AdjustOptions& options,
                                      AdjustmentProblem* problem,
                                      BlockState* state,
                                      ProgressSink* progress,
                                      std::optional<ReducedSystem>* solved = nullptr);

/// A tolerance for a block of so many points: few unknowns share what is left among them, and one
/// step more costs nothing. Scaled by points / 1000, within [0.01, 1].
[[nodiscard]] double ToleranceFor(double tolerance_1, const AdjustmentProblem& problem);

/// Throws UndeterminedError unless something can be solved at all.
void RequireSolvable(const AdjustmentProblem& problem);
/// Forms the reduced system at a state, leaving out the points whose own equations turn out rank
/// deficient, with their reason.
void FormDetermined(const BlockState& state,
                    const Weighting& weighting,
                    AdjustmentProblem* problem,
                    std::optional<ReducedSystem>* system,
                    ProgressSink* progress);
/// Refuses options that this build does not offer, by name.
void RequireOffered(const AdjustOptions& options);
/// Refuses a block too large for the method asked for (ceres_covariance.h).
void RequireCovarianceMethod(const AdjustmentProblem& problem, const AdjustOptions& options);

/// v'Pv against chi-square of the redundancy, two-sided; NaN without redundancy.
[[nodiscard]] GlobalTest TestGlobally(const AdjustmentProblem& problem,
                                      double level,
                                      double square_sum_1);

/// For commands that adjust nothing: refuses `montecarlo` and says that variance components are not
/// estimated.
void RefuseRepetition(const AdjustOptions& options, const char* command, AdjustResult* result);

void Warn(AdjustResult* result, const std::string& text);
/// One warning for each nearly undetermined direction.
void WarnOfWeakDirections(const RankReport& rank, AdjustResult* result);

/// Says which variance components were held and whether the others settled.
void WarnOfComponents(const VarianceComponentReport& report, AdjustResult* result);

/// The last step of all three: counts, global test, points, residuals (unless there already), check
/// points, rejected looks, warnings of points left out. `square_sum_1` is v'Pv,
/// NaN for a prediction, which has no residuals.
void FinishResult(const AdjustmentProblem& problem,
                  const BlockState& state,
                  const AdjustOptions& options,
                  double square_sum_1,
                  const PointDefects& defects,
                  AdjustResult* result);
/// Positions, status, counts of looks and angles.
void FillPoints(const AdjustmentProblem& problem, const BlockState& state, AdjustResult* result);
/// e_r and e_d of every look of a solved point.
void FillResiduals(const AdjustmentProblem& problem,
                   const BlockState& state,
                   const Weighting& weighting,
                   AdjustResult* result);
/// Values, sigmas, covariance of points, corrections and pairs at options.covariance.
/// `datum`: of a floating block, whose covariances are transformed to it.
void FillCovariance(const AdjustmentProblem& problem,
                    const BlockState& state,
                    const ReducedSystem& system,
                    const std::optional<DatumTransform>& datum,
                    const AdjustOptions& options,
                    const PointPairs& pairs,
                    ProgressSink* progress,
                    AdjustResult* result);
void FillParameters(const AdjustmentProblem& problem,
                    const BlockState& state,
                    AdjustResult* result);
/// Corrected paths: states at the nominal times less the time bias, so that reading them at the
/// measured times gives the path the adjustment used; more states where a spline or a polynomial of
/// a high degree needs them.
void FillCorrectedPaths(const AdjustmentProblem& problem,
                        const BlockState& state,
                        AdjustResult* result);
/// Errors of check points against their known positions.
void FillChecks(const Block& block, AdjustResult* result);

}  // namespace sarblock
