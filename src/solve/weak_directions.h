// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "model/problem.h"
#include "structure.h"
#include <Eigen/Core>

namespace sarblock {

/// Least eigenvalue of the reduced matrix scaled to unit diagonal that still counts as regular; its
/// own rounding is about 1e-15.
inline constexpr double kMinEigenvalue = 1e-13;
/// An eigenvalue below this always gives a warning: six digits of the covariance are not certain.
/// The rounding of S, 1.1e-16 of its diagonal, comes back in S^-1 divided by the eigenvalue; up to
/// twice that is met in covariances (docs/studies/stability.md), which leaves 4.4e-7 here.
inline constexpr double kNearEigenvalue = 5e-10;
/// Limits of the standard deviation of a correction without a prior, as movement at the target over
/// the mean slant range: beyond the first there is a warning, beyond the second the block is
/// refused, since the linear model is not valid there.
inline constexpr double kNearEffectPart = 0.01;
inline constexpr double kOpenEffectPart = 0.5;

/// A parameter that takes part in a weak direction.
struct WeakParameter {
  int index = 0;
  double share = 0.0;  ///< component of the unit direction, parameters in conditional sigmas
  /// Posterior standard deviation in the parameter's unit; infinite where undetermined.
  double sigma = std::numeric_limits<double>::infinity();
};

/// Parameters that move together and change (almost) no observation.
struct WeakDirection {
  double eigenvalue = 0.0;    ///< v'Sv, |v| = 1, S scaled to unit diagonal
  double prior_part = 0.0;    ///< how much of it the priors give, 0 to 1
  bool undetermined = false;  ///< to be refused; else nearly undetermined
  double effect_m = 0.0;      ///< largest movement at the target, parameters without prior, 1 sigma
  double correlation = 0.0;   ///< of the two parameters with the largest shares; 0 if undetermined
  std::vector<WeakParameter> parameters;     ///< the largest share first
  std::string motion;                        ///< "translation of the whole block in y", or empty
  std::optional<std::uint32_t> moved_point;  ///< the tie point it moves most, where known
  double moved_m = 0.0;                      ///< by how much per sigma
  std::string text;                          ///< all of it in words, with what would remove it
};

/// What S does not determine (model.md, section 9; docs/theory/rank.md).
struct RankReport {
  std::vector<WeakDirection> undetermined;
  std::vector<WeakDirection> nearly;
  bool more = false;       ///< there are more weak directions than were looked for
  double condition = 1.0;  ///< ratio of the extreme eigenvalues of the scaled S
  [[nodiscard]] bool regular() const { return undetermined.empty(); }
};

/// By parameter: the pass that it belongs to, -1 for shared ones.
[[nodiscard]] std::vector<int> PassOfParameters(const ParameterLayout& layout);

/// Corrections that move passes as one rigid body (and its size): the directions a block without a
/// datum is free in. Columns are translations east, north, up by 1 m; rotations about these axes
/// through the middle of the passes by 1 rad; a change of size by 1, which only exists where range
/// scales do. Rows are parameters in their own units; what the corrections cannot represent is left
/// out of a column. docs/theory/rank.md, section 4.
inline constexpr int kMotions = 7;
[[nodiscard]] Eigen::MatrixXd RigidMotions(const AdjustmentProblem& problem,
                                           const std::vector<int>& pass_of_parameter,
                                           const std::vector<std::uint32_t>& passes);

/// "translation of the whole block in y", for a mixture of the columns above: `part` in metres,
/// radians and one. `subject` is "the whole block" or a connected component.
[[nodiscard]] std::string NameMotion(const Eigen::Matrix<double, kMotions, 1>& part,
                                     FrameKind frame,
                                     const std::string& subject);

/// Metres at the target that one unit of each parameter moves a look, and the mean slant range.
struct TargetEffects {
  Eigen::VectorXd metres;
  double range_m = 0.0;
};

/// `pass_of_parameter` from PassOfParameters.
[[nodiscard]] TargetEffects TargetEffectsOf(const AdjustmentProblem& problem,
                                            const std::vector<int>& pass_of_parameter);

/// A direction of the scaled parameters, unit length, with its name where it is a rigid motion.
struct NamedDirection {
  Eigen::VectorXd vector;
  std::string motion;
};

/// A basis of a weak subspace (`weak`: orthonormal or nearly so, columns in scaled parameters) that
/// can be put in words. First the rigid motions of the block, or of each connected component, that
/// lie in the subspace; then the rest, each with a parameter in which no other direction has a
/// part, so that local ones stay local. Both depend on the subspace and not on the vectors that
/// span it, which rounding turns. docs/theory/rank.md, section 4.
[[nodiscard]] std::vector<NamedDirection> NameableBasis(const AdjustmentProblem& problem,
                                                        const std::vector<int>& pass_of_parameter,
                                                        const Eigen::VectorXd& scale,
                                                        const Eigen::MatrixXd& weak);

/// What the parameters of a direction are ("across position (constant) of all passes and range bias
/// of A1"), what that means and what would remove it. `pass_of_parameter` from PassOfParameters.
[[nodiscard]] std::string DescribeDirection(const AdjustmentProblem& problem,
                                            const std::vector<int>& pass_of_parameter,
                                            const WeakDirection& direction);

/// Points that would get a solution although their own looks do not determine them, on the paths
/// of a state. Control points, which their coordinates fix, are not examined.
struct PointDefects {
  std::vector<std::size_t> touching;    ///< circles meet tangentially
  std::vector<std::size_t> coinciding;  ///< circles are the same (zero base, single flight)
  std::vector<std::size_t> ambiguous;   ///< a mirror point fits as well; start coordinates decided
};
[[nodiscard]] PointDefects FindPointDefects(const AdjustmentProblem& problem,
                                            const BlockState& state);
/// Leaves touching and coinciding points out by name, and ambiguous ones whose coordinates were not
/// given; true if there were any.
bool LeaveOutOpenPoints(const PointDefects& defects, AdjustmentProblem* problem);
/// In words: points left out with the reason of the first; points whose given coordinates chose
/// between two solutions.
[[nodiscard]] std::vector<Finding> DescribePoints(const AdjustmentProblem& problem,
                                                  const PointDefects& defects);

}  // namespace sarblock
