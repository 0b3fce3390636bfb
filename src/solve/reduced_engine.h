// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"

#include <limits>
#include <string>

#include "model/problem.h"
#include "normals/point.h"
#include "normals/reduced_system.h"

namespace sarblock {

/// What a solver reports.
struct SolveReport {
  bool converged = false;
  int iterations = 0;
  int formed = 0;  ///< times the system was formed, its work; of SolveReduced
  double initial_cost_1 = 0.0;
  double final_cost_1 = 0.0;
  /// Newton decrement at the end in sigmas, steps to come included; of least squares.
  double decrement_1 = 0.0;
  std::string message;
};

struct SolveOptions {
  int max_iterations = AdjustOptions{}.max_iterations;
  /// Times the system may be formed, refused steps included: a bound of the work; of SolveReduced.
  int max_formed = std::numeric_limits<int>::max();
  int threads = 1;
  /// Newton decrement, in sigmas over all unknowns, at which the solution is done.
  double settled_1 = AdjustOptions{}.tolerance_1;
  /// Takes the last step, shorter than settled_1, without forming the system again to verify it:
  /// what follows does (NewtonFinish).
  bool take_last_step = false;                    ///< of SolveReduced
  CeresSolver ceres_solver = CeresSolver::kAuto;  ///< of SolveWithCeres
  /// v'Pv above which a solution is of no use: after three steps, refused ones included, it is
  /// given up where four times
  /// what the next Newton step promises (the equations are bent) would not bring it there.
  double useless_above_1 = std::numeric_limits<double>::infinity();  ///< of SolveReduced
};

/// A tolerance for a block of so many points: few unknowns share what is left among them, and one
/// step more costs nothing. Scaled by points / 1000, within [0.01, 1].
[[nodiscard]] double ToleranceFor(double tolerance_1, const AdjustmentProblem& problem);

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
  [[nodiscard]] bool Stagnates(int iteration, double cost_1, double decrement_1);

 private:
  int iteration_ = 0;  ///< of the figures
  double cost_1_ = std::numeric_limits<double>::infinity();
  double decrement_1_ = std::numeric_limits<double>::infinity();
};

/// What `auto` stands for; anything else stands for itself. No other choice is both faster and at
/// least as accurate in the recorded study of speed against accuracy (docs/studies/tradeoff.md); a
/// test holds them against its table.
[[nodiscard]] Engine Resolve(Engine asked);
[[nodiscard]] CovarianceMethod Resolve(CovarianceMethod asked);
/// `corrections` is the number of parameters of the passes, the rows of the reduced matrix.
[[nodiscard]] CeresSolver Resolve(CeresSolver asked, int corrections);

/// Levenberg-Marquardt on the reduced normal equations (ReducedSystem), without Ceres' objects: per
/// iteration one pass over the points that forms S and one that substitutes back. Jacobians are
/// recomputed, not stored; memory beyond the block is 24 bytes a point and S.
///
/// Damping (Marquardt 1963): lambda times the diagonal of J'J on every unknown, a tenth after a
/// step that lowers the cost, tenfold after one that does not. Ends when the step that is left is
/// below options.settled_1 sigmas over all unknowns together, or below what the rounding of the
/// cost can tell. The solution is that of SolveWithCeres to a small part of a sigma. Updates
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

/// The state after the whole Gauss-Newton step that belongs to the corrections' step `dx`, nothing
/// damped: every point follows with what its own equations leave of it. Looks without loss.
[[nodiscard]] BlockState AfterNewtonStep(const AdjustmentProblem& problem,
                                         const BlockState& state,
                                         const Eigen::VectorXd& dx);

}  // namespace sarblock
