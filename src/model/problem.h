// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "look_model.h"
#include "parameters.h"
#include <Eigen/Core>

namespace sarblock {

/// Unknowns of an adjustment at one moment. A point is a displacement from its own start position,
/// so that no unknown is a number of millions of metres known to a millimetre.
struct BlockState {
  std::vector<Eigen::Vector3d> start_m;         ///< by point, frame axes
  std::vector<Eigen::Vector3d> displacement_m;  ///< by point
  Eigen::VectorXd corrections;                  ///< by parameter

  [[nodiscard]] Eigen::Vector3d Position(std::size_t point) const {
    return start_m[point] + displacement_m[point];
  }
};

/// Weighted equations of one control point: up to three rows L^-1 (E (p - p_c)) of the components
/// fixed (model.md, section 4). Where only the height of a point in a geocentric frame is fixed,
/// the row is the difference of ellipsoidal heights, so that a poor horizontal approximation does
/// not turn the tangent plane into a height error.
struct ControlEquations {
  std::uint32_t point = 0;
  int rows = 0;
  bool height_only = false;
  Eigen::Matrix3d weight = Eigen::Matrix3d::Zero();  ///< first `rows` rows: L^-1 E
  Eigen::Vector3d known_m = Eigen::Vector3d::Zero();
};

/// Throws InputError naming `id` unless the covariance of the fixed components is positive
/// definite.
[[nodiscard]] ControlEquations MakeControl(const Frame& frame,
                                           const KnownPosition& known,
                                           const Eigen::Vector3d& known_m,
                                           const std::string& id);

/// Value and Jacobian of control equations at a position start + displacement.
struct ControlEvaluation {
  Eigen::Vector3d residual = Eigen::Vector3d::Zero();  ///< first `rows` entries [1]
  Eigen::Matrix3d d_point = Eigen::Matrix3d::Zero();   ///< first `rows` rows [1/m]
};
[[nodiscard]] ControlEvaluation EvaluateControl(const Frame& frame,
                                                const ControlEquations& control,
                                                const Eigen::Vector3d& start_m,
                                                const Eigen::Vector3d& displacement_m);

/// A correction fixed at a value, to give a floating block one solution among many: a minimal
/// constraint (inner_datum.h). It is no observation.
struct FixedParameter {
  int parameter = 0;
  double value = 0.0;
};

/// An adjustment before it is solved: the model, what takes part in it and with which weights.
/// The Ceres cost functions, the reduced normals, the covariance and the quality figures all read
/// this one description.
struct AdjustmentProblem {
  AdjustmentProblem(const Block& source,
                    const std::vector<CorrectionGroup>& asked,
                    const Simplified& simplified = {},
                    const std::vector<JointPrior>& joint_priors = {});
  /// The same corrections and priors for a block with the same passes.
  AdjustmentProblem(const Block& source, const AdjustmentProblem& like);

  const Block& block;
  std::vector<CorrectionGroup> groups;
  std::vector<JointPrior> priors;
  ParameterLayout layout;
  LookModel model;                        ///< refers to block and layout
  std::vector<std::uint8_t> look_used;    ///< by look: takes part
  std::vector<PointStatus> point_status;  ///< by point; IsSolved() takes part
  std::vector<std::string> point_reason;  ///< by point; why not, for people
  std::vector<std::uint8_t> mirrored;     ///< by point: left out because its solution lies where no
                                          ///< look can see it
  std::vector<LookWeights> weights;       ///< by look
  std::vector<ControlEquations> control;  ///< of control points, sorted by point
  std::vector<std::int32_t> control_of;   ///< by point: index into control, or -1
  std::vector<FixedParameter> fixed;      ///< of a block without a datum

  AdjustmentProblem(const AdjustmentProblem&) = delete;
  AdjustmentProblem& operator=(const AdjustmentProblem&) = delete;

  [[nodiscard]] bool Solves(std::size_t point) const { return IsSolved(point_status[point]); }
  /// Leaves a point and its looks out.
  void LeaveOut(std::size_t point, PointStatus status, const std::string& reason);
  /// Leaves out a point whose solution stays above the antennas or on the wrong side.
  void LeaveOutMirrorSolution(std::size_t point);
  /// Takes a point and these of its looks into the problem again.
  void TakeBack(std::size_t point, const std::vector<std::size_t>& looks);
  /// Looks of a point that take part.
  [[nodiscard]] int CountLooks(std::size_t point) const;
  /// Status of a point that lacks equations: kNotSeen without a look that takes part, kTooFewLooks
  /// where looks and control give fewer equations than unknowns; nothing where there are enough.
  [[nodiscard]] std::optional<PointStatus> LacksEquations(std::size_t point) const;
};

/// Corrections of passes and their joint priors.
struct CorrectionModel {
  CorrectionModel() = default;
  CorrectionModel(std::vector<CorrectionGroup> of_passes,  // NOLINT(google-explicit-constructor)
                  std::vector<JointPrior> of_groups = {})
      : groups(std::move(of_passes)), priors(std::move(of_groups)) {}
  std::vector<CorrectionGroup> groups;
  std::vector<JointPrior> priors;
};
/// The corrections of an adjustment with these options; none unless they are given.
[[nodiscard]] CorrectionModel GivenCorrections(const AdjustOptions& options);

/// Evaluates a look of a point at a state; finds its columns too. False where the model has no
/// value.
[[nodiscard]] bool EvaluateLook(const LookModel& model,
                                const BlockState& state,
                                std::size_t point,
                                std::size_t look,
                                const LookWeights& weights,
                                LookColumns* columns,
                                LookEvaluation* out,
                                LookCurvature* curvature = nullptr);
/// The same without weights and without the partials by corrections.
[[nodiscard]] bool EvaluateErrors(const LookModel& model,
                                  const BlockState& state,
                                  std::size_t point,
                                  std::size_t look,
                                  LookEvaluation* out);
/// The first look of a point for which the model has no value at a state, and why, in words; empty
/// where it has one for all.
[[nodiscard]] std::string WhyNoValue(const AdjustmentProblem& problem,
                                     const BlockState& state,
                                     std::size_t point);

/// Weights of a look with these standard deviations where a unit of its azimuth measurement is so
/// many metres at its target (LookEvaluation::azimuth_unit_m).
[[nodiscard]] LookWeights WeightsAt(const LookSigma& sigma, double azimuth_unit_m);

/// Forms the weights of every look in use at a state: an azimuth given in metres at the target
/// becomes seconds there (LookEvaluation::azimuth_unit_m). A look without a value keeps its former
/// weights, at first those of the speed of its path. Returns the largest relative change of a
/// weight.
double UpdateWeights(const BlockState& state, AdjustmentProblem* problem);

/// Counts of observations and parameters (model.md, section 6).
struct ProblemCounts {
  std::size_t looks = 0;
  std::size_t observations = 0;
  std::size_t parameters = 0;
  std::size_t defects = 0;  ///< parameters fixed because nothing determines them
  [[nodiscard]] double redundancy() const {
    return static_cast<double>(observations + defects) - static_cast<double>(parameters);
  }
};
[[nodiscard]] ProblemCounts CountProblem(const AdjustmentProblem& problem);

/// What takes part in an adjustment, kept so that a trial can be undone: looks and their weights,
/// points, known positions.
class Participation {
 public:
  explicit Participation(const AdjustmentProblem& problem)
      : look_used_(problem.look_used),
        point_status_(problem.point_status),
        point_reason_(problem.point_reason),
        mirrored_(problem.mirrored),
        weights_(problem.weights),
        control_of_(problem.control_of) {}

  /// `problem` is the one that this was made of.
  void Restore(AdjustmentProblem* problem) const {
    problem->look_used = look_used_;
    problem->point_status = point_status_;
    problem->point_reason = point_reason_;
    problem->mirrored = mirrored_;
    problem->weights = weights_;
    problem->control_of = control_of_;
  }

 private:
  std::vector<std::uint8_t> look_used_;
  std::vector<PointStatus> point_status_;
  std::vector<std::string> point_reason_;
  std::vector<std::uint8_t> mirrored_;
  std::vector<LookWeights> weights_;
  std::vector<std::int32_t> control_of_;
};

inline constexpr double kMinRadialCurvature = 0.05;

/// Scale of a loss in sigmas: options.robust_scale, or the loss's own default where that is 0.
[[nodiscard]] double RobustScale(const AdjustOptions& options);

/// Whitened square length beyond which a look is far off in a robust solution: the 99.9 percent
/// point of chi-square with two degrees of freedom.
[[nodiscard]] double FarSquare();

/// Weight rho'(s) of a look whose whitened squared length is s >= 0, and its loss rho(s).
///     huber   rho = s, or 2 a sqrt(s) - a^2 beyond a       (Huber 1964)
///     cauchy  rho = a^2 log(1 + s/a^2)
///     tukey   rho = a^2/3 (1 - (1 - s/a^2)^3), a^2/3 beyond a   (Beaton and Tukey 1974)
struct RobustValue {
  double loss = 0.0;
  double weight = 1.0;
  /// Curvature along the residual over the weight, (rho' + 2 s rho'') / rho', not below
  /// kMinRadialCurvature. Reweighting alone assumes 1 and converges slowly.
  double radial = 1.0;
};
[[nodiscard]] RobustValue EvaluateLoss(RobustLoss loss, double scale, double square);

}  // namespace sarblock
