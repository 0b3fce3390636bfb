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
  /// v'Pv above which a solution is of no use: after three steps, refused ones included, it is
  /// given up where four times
  /// what the next Newton step promises (the equations are bent) would not bring it there.
  double useless_above = std::numeric_limits<double>::infinity();  ///< of SolveReduced
};

/// A tolerance for a block of so many points: few unknowns share what is left among them, and one
/// step more costs nothing. Scaled by points / 1000, within [0.01, 1].
[[nodiscard]] double ToleranceFor(double tolerance, const AdjustmentProblem& problem);

/// Why a solver gave up, in words.
extern const char kStagnates[];
[[nodiscard]] std::string LimitReached(int max_iterations);

/// Whether iterations still get anywhere: of every 50 accepted steps the cost must fall by a part
/// in a thousand, or the Newton decrement to half. Steps that shrink more slowly end nowhere within
/// any limit; those that shrink are let go on to the limit of iterations, which only guards. The
/// two ends, no progress and a limit, are those of Dennis and Schnabel (1996), Numerical Methods
/// for Unconstrained Optimization and Nonlinear Equations, section 7.2.
class ProgressOfSteps {
 public:
  [[nodiscard]] bool Stagnates(int iteration, double cost, double decrement);

 private:
  int iteration_ = 0;  ///< of the figures
  double cost_ = std::numeric_limits<double>::infinity();
  double decrement_ = std::numeric_limits<double>::infinity();
};

/// The choice of `auto`; any other is returned. No other choice is both faster and at
/// least as accurate in the recorded study of speed against accuracy (docs/studies/tradeoff.md); a
/// test compares them with its table.
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
/// they follow the curve to which the equations bend them (BendOfStep): in a direction that is
/// known to some hundred metres only, the line that they begin with leaves it. Ends when the Newton
/// decrement is below options.settle_below sigmas over all unknowns together, or below the rounding
/// of the cost. The solution is that of SolveWithCeres to a small part of a sigma. Updates `state`.
/// Throws Interrupted if the sink was cancelled.
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

/// The state after the whole Gauss-Newton step that belongs to the corrections' step `dx`, nothing
/// damped: every point follows with what its own equations leave of it. Looks without loss.
[[nodiscard]] BlockState AfterNewtonStep(const AdjustmentProblem& problem,
                                         const BlockState& state,
                                         const Eigen::VectorXd& dx);

}  // namespace sarblock
