// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/geometry/intersection.h"
#include "sarblock/geometry/look_equations.h"
#include "sarblock/model/simplified.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "flight/track_axes.h"
#include "parameters.h"
#include <Eigen/Core>

namespace sarblock {

/// Parameter blocks a look touches, in the order of its local columns.
struct LookColumns {
  std::array<int, ParameterLayout::kMaxLocalColumns> block;  ///< the first block_count are set
  int block_count = 0;
  int column_count = 0;
};

/// One look at one state: errors in metres and partials, not yet weighted. Row 0 is the range
/// sphere e_r, row 1 the Doppler cone e_d.
struct LookEvaluation {
  Eigen::Vector2d error_m = Eigen::Vector2d::Zero();
  Eigen::Matrix<double, 2, 3> by_point = Eigen::Matrix<double, 2, 3>::Zero();
  /// By the look's local columns; only the first column_count are set.
  Eigen::Matrix<double, 2, ParameterLayout::kMaxLocalColumns, Eigen::RowMajor> by_columns;
};

/// Where the partials of a look by its local columns go: column_count numbers each, or nowhere.
struct LookRows {
  double* range = nullptr;
  double* doppler = nullptr;
};

/// A look's azimuth time as adjusted, measured + shift, and the rates of its two errors there,
/// which carry them back to the measured time. The rates scale what the look says of its own time
/// error and nothing else: single precision is enough.
struct AdjustedTime {
  double shift_s = 0.0;
  float range_mps = 0.0F;    ///< d(e_r)/dt
  float doppler_mps = 0.0F;  ///< d(e_d)/dt
  /// What the shift puts into e_r and e_d.
  [[nodiscard]] double range_m() const { return static_cast<double>(range_mps) * shift_s; }
  [[nodiscard]] double doppler_m() const { return static_cast<double>(doppler_mps) * shift_s; }
};

/// Weight and time of a look at one state, held while the unknowns move.
struct LookLinearisation {
  Whitening whitening;
  AdjustedTime time;
  double moved_1 = 0.0;  ///< change of the shift over the standard deviation of the time
};

/// A pass whose looks need little: straight in the local frame or with axes that are held, position
/// corrected by one polynomial of degree 0 or 1 or not at all, range by biases and scales, nothing
/// else.
struct StraightPass {
  bool applies = false;
  bool curved = false;  ///< the nominal path is read for every look
  double start_s = 0.0, end_s = 0.0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< at start_s
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes_1 = Eigen::Matrix3d::Identity();  ///< of the polynomial
};

/// The antenna at a time of a pass under corrections.
struct CorrectedMotion {
  Motion motion;             ///< corrected position, velocity and acceleration (jerk unused)
  double path_time_s = 0.0;  ///< t + b_t
};

/// Observation equations of a block with all corrections (model.md, sections 3 and 4;
/// docs/theory/observations.md).
///
///     e_r = (1 + kappa) rho + b_r + z m(p) - R         d = p - s(t + b_t), rho = |d|
///     e_d = u.d - rho sin(tau + b_tau)                  u = unit(v + |v| (c_across a + c_up n))
///
/// The equations are read at the adjusted time t = measured + shift and carried back to the
/// measured one by their rates, e - (de/dt) shift, so that the partials stand where the point was
/// seen (Gauss-Helmert; docs/theory/adjustment.md, section 1). Shifts are 0 until adjusted_times()
/// are set. s and v are position and velocity of the corrected path, the turning of the track axes
/// included. The piece of a spline is chosen by the measured time t and its polynomial continued
/// to t + b_t: the difference is of third order in b_t / knot spacing, and the look's columns do
/// not depend on the state.
/// Thread-safe; holds references to the block and the layout, which must outlive it.
class LookModel {
 public:
  LookModel(const Block& block, const ParameterLayout& layout, const Simplified& simplified = {});

  [[nodiscard]] const Block& block() const { return block_; }
  [[nodiscard]] const ParameterLayout& layout() const { return layout_; }
  [[nodiscard]] const Simplified& simplified() const { return simplified_; }

  /// Rough work of evaluating a look of a pass, in units of no meaning: counts, not times, decide
  /// whether a simplification is worth taking, so that they decide alike on every machine.
  [[nodiscard]] double WorkOf(std::size_t pass) const;

  /// By pass; of one that the straight route applies to.
  [[nodiscard]] const StraightPass& straight(std::size_t pass) const { return straight_[pass]; }

  /// Standard deviations of a look: the block's times the factors of its pass.
  [[nodiscard]] LookSigma SigmaOf(std::size_t look) const;
  /// Factors on the standard deviations of range and azimuth by pass; empty: 1. The whitening does
  /// not follow by itself (UpdateWhitening).
  void ScaleSigmas(std::vector<std::array<double, 2>> factor_of_pass_1) {
    sigma_factor_1_ = std::move(factor_of_pass_1);
  }
  [[nodiscard]] const std::vector<std::array<double, 2>>& sigma_factors() const {
    return sigma_factor_1_;
  }

  void ColumnsOf(std::size_t look, LookColumns* columns) const;
  /// The columns of a look of `pass` measured at `time_s`.
  void ColumnsAt(std::size_t pass, double time_s, LookColumns* columns) const;

  /// Errors and partials of `look` with its point at start_m + displacement_m, local corrections
  /// `x` (column_count values). False where the model has no value: time outside the path, point at
  /// the antenna, sight line level at the target under a troposphere, overflow.
  [[nodiscard]] bool Evaluate(std::size_t look,
                              const LookColumns& columns,
                              const Eigen::Vector3d& start_m,
                              const Eigen::Vector3d& displacement_m,
                              std::span<const double> x,
                              LookEvaluation* out) const;
  /// The same with both equations' partials whitened by `w` (error_m stays in metres) and those by
  /// columns put into `rows`.
  [[nodiscard]] bool Evaluate(std::size_t look,
                              const LookColumns& columns,
                              const Eigen::Vector3d& start_m,
                              const Eigen::Vector3d& displacement_m,
                              std::span<const double> x,
                              const Whitening& w,
                              Eigen::Vector2d* error_m,
                              Eigen::Matrix<double, 2, 3>* by_point,
                              LookRows rows) const;

  /// Weight of a look at its point and with all corrections `x` of the block, and its time one
  /// Newton step on the Doppler cone further. The shift is 0 within ten standard deviations of the
  /// ends of the path. Nothing where the look has no value.
  [[nodiscard]] std::optional<LookLinearisation> Linearise(std::size_t look,
                                                           const Eigen::Vector3d& start_m,
                                                           const Eigen::Vector3d& displacement_m,
                                                           const Eigen::VectorXd& x) const;
  /// Adjusted times by look; empty: the measured ones (UpdateWhitening fills them).
  [[nodiscard]] const std::vector<AdjustedTime>& adjusted_times() const { return adjusted_times_; }
  [[nodiscard]] std::vector<AdjustedTime>& adjusted_times() { return adjusted_times_; }
  [[nodiscard]] AdjustedTime TimeOf(std::size_t look) const {
    return adjusted_times_.empty() ? AdjustedTime{} : adjusted_times_[look];
  }

  /// Corrected antenna motion of a pass at measured time t with all corrections `x` of the block;
  /// nothing outside the path.
  [[nodiscard]] std::optional<CorrectedMotion> CorrectedMotionAt(std::size_t pass,
                                                                 double time_s,
                                                                 const Eigen::VectorXd& x) const;

  /// The same for a path time given outright, as for the states of the corrected path.
  [[nodiscard]] std::optional<CorrectedMotion> CorrectedMotionAtPathTime(
      std::size_t pass, double measured_s, double path_s, const Eigen::VectorXd& x) const;

  /// A look as a Sight of the geometry module with corrections `x`; nothing outside the path.
  [[nodiscard]] std::optional<Sight> SightOf(std::size_t look, const Eigen::VectorXd& x) const;

  [[nodiscard]] Cone ConeOf(std::size_t look) const;

 private:
  [[nodiscard]] const FlightPath& PathOf(std::size_t pass) const {
    return straightened_.empty() ? block_.passes[pass].path : straightened_[pass];
  }
  [[nodiscard]] const Eigen::Matrix3d* HeldAxesOf(std::size_t pass) const {
    return held_axes_1_.empty() ? nullptr : &held_axes_1_[pass];
  }
  [[nodiscard]] Vertical DelayVerticalAt(const Eigen::Vector3d& p_m) const;
  bool EvaluateStraight(std::size_t look,
                        const StraightPass& straight,
                        const Eigen::Vector3d& start_m,
                        const Eigen::Vector3d& displacement_m,
                        std::span<const double> x,
                        const Whitening& w,
                        Eigen::Vector2d* error_m,
                        Eigen::Matrix<double, 2, 3>* by_point,
                        LookRows rows) const;

  const Block& block_;
  const ParameterLayout& layout_;
  Simplified simplified_;
  std::vector<FlightPath> straightened_;      // by pass; empty: the block's
  std::vector<Eigen::Matrix3d> held_axes_1_;  // by pass; empty: they turn
  Vertical middle_;                           // of a flat frame
  std::vector<StraightPass> straight_;        // by pass
  std::vector<std::array<double, 2>> sigma_factor_1_;
  std::vector<AdjustedTime> adjusted_times_;  // by look; empty: the measured ones
};

/// Local corrections of a look gathered from the block's vector x.
void GatherColumns(const ParameterLayout& layout,
                   const LookColumns& columns,
                   const Eigen::VectorXd& x,
                   double* local);

}  // namespace sarblock
