// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "look_model.h"
#include <Eigen/Core>

namespace sarblock {

/// The corrected path of a pass that stays straight and even under its corrections (StraightPass,
/// not curved), at one state of them: s(t) = position + (t - start) velocity. What EvaluateStraight
/// finds anew for every look is found once for all looks of the pass.
struct StraightMotion {
  bool applies = false;
  double start_s = 0.0, end_s = 0.0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< at start_s
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis_1 = Eigen::Vector3d::Zero();  ///< velocity / speed
  double speed_mps = 0.0, inverse_speed = 0.0;
  double range_bias_m = 0.0, range_scale_1 = 0.0;  ///< b_r and kappa, all groups together
  int only_block = -1;                             ///< where one holds all parameters of the pass
  int columns = 0;                                 ///< of that block
  bool usual = false;                              ///< constant and drift of three axes and no more
  Eigen::Matrix3d axes_1 = Eigen::Matrix3d::Identity();      ///< of constant and drift, as columns
  Eigen::Vector3d axis_by_axes_1 = Eigen::Vector3d::Zero();  ///< axis_1 in them
  double middle_s = 0.0, rate = 0.0;  ///< a drift grows with (t - middle) rate
};

/// What a step of the corrections does to a StraightMotion.
struct StraightStep {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  double range_bias_m = 0.0, range_scale_1 = 0.0;
};

/// The straight motions of a model at one state of the corrections, and the looks of their passes.
/// The values are those of LookModel::Evaluate but for rounding. Refers to the model.
class StraightMotions {
 public:
  StraightMotions(const LookModel& model, const Eigen::VectorXd& corrections);

  [[nodiscard]] bool Apply(std::size_t pass) const { return motions_[pass].applies; }

  /// LookModel::ColumnsOf, of a pass that they apply to.
  void ColumnsOf(std::size_t look, LookColumns* columns) const {
    const StraightMotion& motion = motions_[model_.block().looks.pass[look]];
    if (motion.only_block < 0) {
      model_.ColumnsOf(look, columns);
      return;
    }
    columns->block[0] = motion.only_block;
    columns->block_count = 1;
    columns->column_count = motion.columns;
  }

  /// As LookModel::Evaluate, whitened, for a look of a pass that they apply to.
  [[nodiscard]] bool Evaluate(std::size_t look,
                              const Eigen::Vector3d& start_m,
                              const Eigen::Vector3d& displacement_m,
                              const Whitening& w,
                              Eigen::Vector2d* error_m,
                              Eigen::Matrix<double, 2, 3>* by_point,
                              LookRows rows) const;

  /// By pass; of those that they apply to.
  [[nodiscard]] std::vector<StraightStep> StepsFor(const Eigen::VectorXd& dx) const;

  /// The same with J_c dx, whitened, in place of the partials by the columns: `step` is that of the
  /// look's pass.
  [[nodiscard]] bool EvaluateAlong(std::size_t look,
                                   const Eigen::Vector3d& start_m,
                                   const Eigen::Vector3d& displacement_m,
                                   const StraightStep& step,
                                   const Whitening& w,
                                   Eigen::Vector2d* error_m,
                                   Eigen::Matrix<double, 2, 3>* by_point,
                                   Eigen::Vector2d* along_1) const;

 private:
  bool EvaluateByPoint(std::size_t look,
                       const StraightMotion& motion,
                       const AdjustedTime& adjusted,
                       const Eigen::Vector3d& start_m,
                       const Eigen::Vector3d& displacement_m,
                       const Whitening& w,
                       LookEquations* eq,
                       Eigen::Vector2d* error_m,
                       Eigen::Matrix<double, 2, 3>* by_point) const;

  const LookModel& model_;
  std::vector<StraightMotion> motions_;
};

}  // namespace sarblock
