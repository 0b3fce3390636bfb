// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/corrections.h"

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

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

/// What is wrong with a joint prior, for the message of who knows its file.
struct JointPriorProblem {
  std::size_t prior = 0;
  std::string field;  ///< "passes", "parameters", "covariance", "sigma" or "correlation"
  int entry = -1;     ///< of the field's list; -1: the field as a whole
  std::string problem;
};

/// Which parameters of a pass a joint prior speaks of.
struct JointPriorBinding {
  std::size_t prior = 0, pass = 0;
  /// Among ParametersOf() the groups of the pass that are not shared, one group after the other. A
  /// position parameter in other axes stands for the axis of the correction of the same number.
  std::vector<int> parameters;
  PositionCorrection::Axes axes = PositionCorrection::Axes::kTrack;  ///< of the correction
};

/// Part of the variance of a parameter that the parameters before it must leave: with less, the
/// equations of the prior would lose more digits than the adjustment has to spare.
inline constexpr double kLeastPriorPivot_1 = 1e-10;

/// Empty where there is a problem.
struct JointPriorBindings {
  std::vector<JointPriorBinding> bound;
  std::optional<JointPriorProblem> problem;
};

/// Finds the parameters of all priors, by prior and then by pass of `pass_ids`.
/// Refuses passes and parameters that are not there, parameters of shared groups and of splines,
/// those with a standard deviation of their own or in two joint priors, a matrix of the wrong size,
/// one that is not symmetric to 1e-9 of its diagonal, and one of which a pivot, scaled to unit
/// diagonal, is kLeastPriorPivot_1 or less.
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
