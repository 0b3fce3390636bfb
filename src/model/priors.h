// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/options.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// Names of the kinds of corrections, in the order of Correction.
inline constexpr std::array<const char*, std::variant_size_v<Correction>> kCorrectionKinds = {
    "position", "velocity", "range", "time", "squint", "troposphere"};

/// Why corrections = "auto" refuses joint priors.
inline constexpr const char* kNoAutomaticPriors =
    "stands beside corrections = \"auto\", which chooses among corrections with priors that are "
    "independent; allowed is \"given\", or standard deviations in the correction tables";

/// Value that a prior expects of a parameter, in the unit of the parameter.
using PriorValue = double;

/// What a parameter corrects.
enum class ParameterKind : std::uint8_t {
  kPosition,  ///< of the antenna, along one axis
  kVelocityAcross,
  kVelocityUp,
  kRangeBias,
  kRangeScale,
  kTimeBias,
  kSquintBias,
  kZenithDelay,
};

/// One correction parameter of a block. Its name and unit are for people and files; what it does
/// is its kind.
struct Parameter {
  std::string owner;                   ///< pass id, or the group's name where shared
  std::string name;                    ///< "position.along.0", "range.bias", ...
  std::string unit;                    ///< "m", "s", "rad", "1"
  PriorSigma prior_sigma = kNotGiven;  ///< of a joint prior or a process: of it alone
  PriorValue prior_value = 0.0;  ///< in `unit`; what the prior says, drawn anew in a simulation
  ParameterKind kind = ParameterKind::kPosition;
  // Only for kPosition:
  PositionCorrection::Axes axes = PositionCorrection::Axes::kTrack;
  int axis = 0;         ///< 0 along or x, 1 across or y, 2 up or z
  int degree = 0;       ///< of the polynomial; of a spline the number of its coefficient
  bool spline = false;  ///< coefficient of a spline
  int joint = -1;       ///< index into ParameterLayout::joint_priors; -1: none
  // A coefficient of a process other than the first follows from the one before (eq. (3c)): its
  // prior is that the error of c, less `carried` times that of c_before, has the sigma step_sigma.
  int before = -1;  ///< parameter of the layout; -1: none
  double carried = 0.0;
  PriorSigma step_sigma = kNotGiven;

  [[nodiscard]] bool has_prior() const { return prior_sigma == prior_sigma; }
  /// A prior that is independent of all others.
  [[nodiscard]] bool has_own_prior() const { return has_prior() && joint < 0 && before < 0; }
};

/// Names of position axes: along, across, up or x, y, z.
[[nodiscard]] const std::array<const char*, 3>& AxisNamesOf(PositionCorrection::Axes axes);

/// A coefficient of a position correction; `degree` is that of the polynomial or the number of the
/// spline's coefficient.
[[nodiscard]] Parameter PositionParameter(const PositionCorrection& position,
                                          std::size_t axis,
                                          std::size_t degree);

/// Whether it is a spline whose coefficients have a prior with each other.
[[nodiscard]] bool HasProcess(const CorrectionGroup& group);

/// Sets the priors by a process on coefficient `coefficient` along an axis of a spline with `count`
/// coefficients, `spacing_s` apart; parameter `before` of the layout is the coefficient before it.
/// Does nothing for kWhite and without a standard deviation.
void SetProcess(const PositionCorrection& position,
                double spacing_s,
                std::size_t count,
                int before,
                Parameter* coefficient);

/// Parameters of a group in the order of their columns, without owner; none of a spline, whose
/// number depends on the strip. Throws InputError where the group has no parameter.
[[nodiscard]] std::vector<Parameter> ParametersOf(const CorrectionGroup& group);

/// A joint prior of one pass, in the axes of its corrections (docs/theory/adjustment.md, eq. (3a)).
struct JointPriorTerm {
  std::string name;
  std::string owner;            ///< pass id
  int block = 0;                ///< parameter block that holds all of `parameters`
  std::vector<int> parameters;  ///< of the layout, in the order of the matrices
  Eigen::MatrixXd covariance;   ///< Q
  Eigen::MatrixXd factor;       ///< L, lower, Q = L L'
  Eigen::MatrixXd whitening;    ///< L^-1, lower
  Eigen::MatrixXd information;  ///< Q^-1

  /// Sets Q and what follows from it; Q must be one that FindCovarianceProblem() lets pass.
  void Set(const Eigen::MatrixXd& q);
};

/// What is wrong with a joint prior, for a message by the caller, who knows its file.
struct JointPriorProblem {
  std::size_t prior = 0;
  std::string field;  ///< "passes", "parameters", "covariance", "sigma" or "correlation"
  int entry = -1;     ///< of the field's list; -1: the field as a whole
  std::string problem;
};

/// The parameters of a pass that a joint prior concerns.
struct JointPriorBinding {
  std::size_t prior = 0, pass = 0;
  /// Among ParametersOf() the groups of the pass that are not shared, one group after the other. A
  /// position parameter in other axes means the axis of the correction with the same number.
  std::vector<int> parameters;
  PositionCorrection::Axes axes = PositionCorrection::Axes::kTrack;  ///< of the correction
};

/// Least part of the variance of a parameter that remains when the parameters before it are known:
/// with less, the equations of the prior would lose more digits than the adjustment has to spare.
inline constexpr double kMinPriorPivot = 1e-10;

/// Empty where there is a problem.
struct JointPriorBindings {
  std::vector<JointPriorBinding> bound;
  std::optional<JointPriorProblem> problem;
};

/// Finds the parameters of all priors, by prior and then by pass of `pass_ids`.
/// Refuses passes and parameters that are not there, parameters of shared groups and of splines,
/// those with a standard deviation of their own or in two joint priors, a matrix of the wrong size,
/// one that is not symmetric to 1e-9 of its diagonal, and one of which a pivot, scaled to unit
/// diagonal, is kMinPriorPivot or less.
[[nodiscard]] JointPriorBindings BindJointPriors(const std::vector<std::string>& pass_ids,
                                                 const std::vector<CorrectionGroup>& groups,
                                                 const std::vector<JointPrior>& priors);

/// What is wrong with a prior by itself: its parameters twice, its matrix.
[[nodiscard]] std::optional<JointPriorProblem> FindOwnProblem(const JointPrior& prior);

/// What is wrong with a covariance of these parameters; nothing where it can be a prior's.
[[nodiscard]] std::optional<std::string> FindCovarianceProblem(
    const std::vector<std::string>& parameters, const Eigen::MatrixXd& covariance);

/// Axis and degree of a position parameter's name in these axes.
struct PositionName {
  int axis = 0, degree = 0;
};
[[nodiscard]] std::optional<PositionName> ParsePositionName(const std::string& name,
                                                            JointPrior::Axes axes);

/// Radial, in-track and cross-track as columns at a place seen from the body's centre: radial =
/// r/|r|, cross-track along r x (v + omega x r), omega along z, in-track = cross-track x radial.
/// NaN where the velocity is along r.
[[nodiscard]] Eigen::Matrix3d RicAxes(const Eigen::Vector3d& radial_m,
                                      const Eigen::Vector3d& velocity_mps,
                                      double rotation_rad_per_s);

/// Unit vectors of the axes as columns, frame axes, at the middle of the strip of a pass; `axes` is
/// not kCorrection. Ric axes are RicAxes(), of a `local` frame with radial up; omega is that of the
/// body for kRicInertial, else 0. Throws InputError where the path or the rotation of the body is
/// not known, `field` naming what asked for it.
[[nodiscard]] Eigen::Matrix3d FrameFromAxes(const Frame& frame,
                                            const Pass& pass,
                                            JointPrior::Axes axes,
                                            const std::string& field);

/// The covariance of a prior in the axes of the corrections of a pass: Q' = T Q T', T turning the
/// three parameters of each degree (eq. (3b)).
[[nodiscard]] Eigen::MatrixXd CovarianceOf(const JointPrior& prior,
                                           const Frame& frame,
                                           const Pass& pass,
                                           PositionCorrection::Axes axes);

/// The dotted key of a prior, "prior.NAME".
[[nodiscard]] std::string KeyOf(const JointPrior& prior);

}  // namespace sarblock
