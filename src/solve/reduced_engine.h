// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"

#include <cstddef>
#include <limits>
#include <string>

#include "model/problem.h"
#include "normals/point.h"
#include "normals/reduced_system.h"
#include <Eigen/Core>

namespace sarblock {

/// What a solver reports.
struct SolveReport {
  bool converged = false;
  int iterations = 0;
  int formed = 0;                ///< times the system was formed, its work; of SolveReduced
  bool formed_at_state = false;  ///< the system is that of the state; of SolveReduced
  /// Steps crept until second derivatives were taken into account; of SolveReduced.
  bool curved = false;
  bool creeps = false;   ///< ended where steps creep; of SolveWithCeres
  double damping = 0.0;  ///< at the end; of SolveReduced
  double initial_cost = 0.0;
  double final_cost = 0.0;
  /// Newton decrement at the end in sigmas, steps to come included.
  double decrement = 0.0;
  std::string message;
  /// The look that had no value where a refused step led, in words (WhyNoValue); empty once a
  /// nearly undamped step is taken; of SolveReduced. More iterations do not help.
  std::string held_by;
};

struct SolveOptions {
  int max_iterations = AdjustOptions{}.max_iterations;
  /// Times the system may be formed, refused steps included: a bound of the work; of SolveReduced.
  int max_formed = std::numeric_limits<int>::max();
  int threads = 1;
  /// Whole Newton steps, nothing damped: for the finish, from a state that is near. Ends where they
  /// lower the cost no more.
  bool undamped = false;  ///< of SolveReduced
  /// First damping, where it is more than the least that a solution begins with; of SolveReduced.
  double damping = 0.0;
  /// The system is formed at the state, undamped, as SolveReduced would form it: the first step is
  /// made of it where it determines every point.
  bool formed = false;  ///< of SolveReduced
  /// Each step of the corrections is judged after every point has followed it.
  bool points_follow = true;  ///< of SolveReduced
  /// Takes second derivatives into account (Weighting::curved) wherever the decrement is small
  /// enough; else only where steps creep.
  bool curved = false;  ///< of SolveReduced
  /// Newton decrement, in sigmas over all unknowns, at which the solution is done.
  double settle_below = AdjustOptions{}.tolerance;
  /// Takes the last step, shorter than settle_below, without forming the system again to verify it:
  /// what follows does (NewtonFinish).
  bool take_last_step = false;                    ///< of SolveReduced
  CeresSolver ceres_solver = CeresSolver::kAuto;  ///< of SolveWithCeres
  /// v'Pv above which a solution is of no use: after three steps, refused ones included, the solver
  /// gives up where even four times the decrease predicted for the next Newton step (equations are
  /// nonlinear) would not reach it.
  double useless_above = std::numeric_limits<double>::infinity();  ///< of SolveReduced
};

/// Tolerance for a block of so many points: the tolerance times points / 1000, a factor kept within
/// [0.01, 1]. In a small block few unknowns share the remaining step, and one step more costs
/// nothing.
[[nodiscard]] double ToleranceFor(double tolerance, const AdjustmentProblem& problem);

/// Why a solver gave up, in words.
extern const char kStagnates[];
[[nodiscard]] std::string LimitReached(int max_iterations);

/// Whether iterations still make progress: over every 50 accepted steps the cost must fall by a
/// part in a thousand, or the Newton decrement to half. Slower iterations would not converge within
/// any limit; those that make progress may go on to the limit of iterations, which is only a guard.
/// The two criteria, no progress and a limit, are those of Dennis and Schnabel (1996), Numerical
/// Methods for Unconstrained Optimization and Nonlinear Equations, section 7.2.
class ProgressOfSteps {
 public:
  [[nodiscard]] bool Stagnates(int iteration, double cost, double decrement);

 private:
  int iteration_ = 0;  ///< of the figures
  double cost_ = std::numeric_limits<double>::infinity();
  double decrement_ = std::numeric_limits<double>::infinity();
};

/// The engine that `auto` means; any other is returned unchanged. No other choice is both faster
/// and at least as accurate in the recorded study of speed against accuracy
/// (docs/studies/tradeoff.md); a test compares them with its table.
[[nodiscard]] Engine Resolve(Engine asked);
[[nodiscard]] CovarianceMethod Resolve(CovarianceMethod asked);
/// `corrections` is the number of parameters of the passes, the rows of the reduced matrix.
[[nodiscard]] CeresSolver Resolve(CeresSolver asked, int corrections);

/// Levenberg-Marquardt on the reduced normal equations (ReducedSystem), without Ceres' objects: per
/// iteration one pass over the points that forms S and one that substitutes back. Jacobians are
/// recomputed, not stored; memory beyond the block is 24 bytes per point and S.
///
/// Damping (Marquardt 1963): lambda times the diagonal of J'J on every unknown, a tenth after a
/// step that lowers the cost, tenfold after one that does not. Where steps creep or are refused
/// they follow the curve of the nonlinear equations to second order (BendOfStep): in a direction
/// that is known only to some hundred metres, a straight step deviates from it. Ends when the
/// Newton decrement is below options.settle_below sigmas over all unknowns together, or below the
/// rounding of the cost. The solution is that of SolveWithCeres to a small part of a sigma. Updates
/// `state`. Throws Interrupted if the sink was cancelled.
[[nodiscard]] SolveReport SolveReduced(const AdjustmentProblem& problem,
                                       const Weighting& weighting,
                                       const SolveOptions& options,
                                       BlockState* state,
                                       ProgressSink* progress);

/// The same on a system of the problem that the caller keeps: its pattern is found once.
[[nodiscard]] SolveReport SolveReduced(const AdjustmentProblem& problem,
                                       const Weighting& weighting,
                                       const SolveOptions& options,
                                       ReducedSystem* system,
                                       BlockState* state,
                                       ProgressSink* progress);

/// The state after the whole, undamped Gauss-Newton step that belongs to the step `dx` of the
/// corrections: every point follows by its own equations. Looks without loss.
[[nodiscard]] BlockState AfterNewtonStep(const AdjustmentProblem& problem,
                                         const BlockState& state,
                                         const Eigen::VectorXd& dx);

}  // namespace sarblock
