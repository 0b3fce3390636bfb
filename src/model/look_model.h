// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/geometry/intersection.h"
#include "sarblock/geometry/look_equations.h"
#include "sarblock/model/result.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "corrected_paths.h"
#include "parameters.h"
#include <Eigen/Core>

namespace sarblock {

/// Parameter blocks a look touches, in the order of its local columns.
struct LookColumns {
  std::array<int, ParameterLayout::kMaxLocalColumns> block;  ///< the first block_count are set
  int block_count = 0;
  int column_count = 0;
};

/// Weights of the two measurements of a look: one over their standard deviations. The unit of the
/// azimuth measurement is the second of a time, the hertz of a measured Doppler.
struct LookWeights {
  double range_per_m = 1.0;
  double azimuth_per_unit = 1.0;
};

/// Where a look is evaluated: its point at start_m + displacement_m, and its local corrections.
struct LookState {
  std::size_t look = 0;
  const LookColumns& columns;
  const Eigen::Vector3d& start_m;
  const Eigen::Vector3d& displacement_m;
  const double* x = nullptr;  ///< column_count values
};

/// The errors of the two measurements of a look, predicted less measured, and their partials, each
/// times its weight. Row 0 is the range, row 1 the azimuth time or the measured Doppler.
struct LookEvaluation {
  Eigen::Vector2d
      whitened_error;  ///< R_p - R [m] and t_p - t [s] or f_p - f [Hz], times the weights
  Eigen::Matrix<double, 2, 3> d_point;  ///< [1] and [s/m] or [Hz/m], times the weights
  /// By the look's local columns; the first column_count of each row are set.
  std::array<std::array<double, ParameterLayout::kMaxLocalColumns>, 2> row;
  /// Metres at the target that a unit of the azimuth measurement is: |de_d/dt|, on the path without
  /// the noise of its states, or |de_d/df|.
  double azimuth_unit_m = 0.0;
  bool beyond_path = false;  ///< the path was continued beyond its ends

  /// Multiplies both rows by weights; `columns` local ones are set.
  void Scale(const LookWeights& weights, int columns) {
    const Eigen::Vector2d factor(weights.range_per_m, weights.azimuth_per_unit);
    whitened_error.array() *= factor.array();
    d_point.array().colwise() *= factor.array();
    for (std::size_t c = 0; c < static_cast<std::size_t>(columns); ++c) {
      row[0][c] *= factor[0];
      row[1][c] *= factor[1];
    }
  }
};

/// Second derivatives of the two measurements of a look by d = p - s [m] and v [m/s], point and
/// antenna at the crossing: of the implicit function, with the acceleration of the path
/// (docs/theory/adjustment.md, section 4).
struct LookCurvature {
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  Matrix6 range, azimuth;  ///< of R_p [m] and of t_p [s] or f_p [Hz]
  /// Partials of d and v by the look's local columns; the first column_count of each are set.
  std::array<std::array<double, ParameterLayout::kMaxLocalColumns>, 6> row;
};

/// The antenna at a time of a pass under corrections.
struct CorrectedMotion {
  Motion motion;             ///< corrected position, velocity and acceleration, nominal jerk
  double path_time_s = 0.0;  ///< t + b_t
};

/// What a look measures, predicted from its point and all corrections: the explicit model
/// (model.md, sections 3 and 4; docs/theory/observations.md, eqs. (11) to (11d)).
///
///     e_r(p, t) = (1 + kappa) rho + b_r + z m(p)     d = p - s(t), rho = |d|
///     e_d(p, t) = u.d - rho sin(tau + b_tau)          u = unit(v + |v| (c_across a + c_up n))
///
///     t_p: e_d(p, t_p) = 0,     R_p = e_r(p, t_p)
///
/// The two measurements are independent: t_p - t over sigma_t and R_p - R over sigma_R. Their
/// partials follow from those of e_r and e_d by the implicit function, dt_p = -(de_d)/q with
/// q = de_d/dt.
///
/// A look whose Doppler is the measurement (Block::MeasuresDoppler) has an exact time: R_p is e_r
/// at t, f_p the Doppler whose cone holds the point then, e_d(p, t, f_p) = 0; f_p - f over sigma_f.
///
/// s and v are position and velocity of the corrected path, the turning of the track axes included,
/// read at the measured time t, moved by whole steps of a grid to near t + b_t (Anchor). From there
/// the antenna moves on for what is left of b_t and the time error t_p - t with its acceleration
/// and jerk: within a piece of the path that is the path itself, to third order. So the equations
/// of a look are smooth however much the path's acceleration jumps at its states, nothing is read
/// beyond the ends of a path but for a time bias, and a look depends on the same parameters at
/// every state. Where noise of the states makes the cubic's acceleration turn the cone by more than
/// CorrectedPaths::kMaxTurn of the speed at which it passes over the points, the acceleration of
/// the path without that noise takes its place. t_p is found anew at every evaluation (Newton's
/// method on the cone, to 1e-12 of rho). Thread-safe but for Anchor; holds references to the block
/// and the layout, which must outlive it.
class LookModel {
 public:
  LookModel(const Block& block, const ParameterLayout& layout, const Simplified& simplified = {});

  [[nodiscard]] const Block& block() const { return block_; }
  [[nodiscard]] const ParameterLayout& layout() const { return layout_; }
  [[nodiscard]] const Simplified& simplified() const { return simplified_; }

  [[nodiscard]] const CorrectedPaths& paths() const { return paths_; }

  /// Approximate work of evaluating a look of a pass, in arbitrary units: counts, not times, decide
  /// whether a simplification is worth taking, so that all machines decide alike.
  [[nodiscard]] double WorkOf(std::size_t pass) const;

  /// Standard deviations of a look: the block's times the factors of its pass.
  [[nodiscard]] LookSigma SigmaOf(std::size_t look) const;
  /// Factors on the standard deviations of range and azimuth by pass; empty: 1. The weights do not
  /// follow by themselves (UpdateWeights).
  void ScaleSigmas(std::vector<std::array<double, 2>> factors) {
    sigma_factors_ = std::move(factors);
  }
  [[nodiscard]] const std::vector<std::array<double, 2>>& sigma_factors() const {
    return sigma_factors_;
  }

  void ColumnsOf(std::size_t look, LookColumns* columns) const;
  /// The columns of a look of `pass` measured at `time_s`.
  void ColumnsAt(std::size_t pass, double time_s, LookColumns* columns) const;

  /// Errors and partials of a look. False where the model has no value: path too far away, point at
  /// the antenna, a cone that the point is never on, line of sight level at the target under a
  /// troposphere, overflow.
  /// `curvature`, where given, is set too.
  [[nodiscard]] bool Evaluate(const LookState& at,
                              const LookWeights& weights,
                              LookEvaluation* out,
                              LookCurvature* curvature = nullptr) const;

  /// Corrected antenna motion of a pass at measured time t with all corrections `x` of the block;
  /// nothing outside the path.
  [[nodiscard]] std::optional<CorrectedMotion> CorrectedMotionAt(std::size_t pass,
                                                                 double time_s,
                                                                 const Eigen::VectorXd& x) const;

  /// The same for a path time given outright, as for the states of the corrected path.
  [[nodiscard]] std::optional<CorrectedMotion> CorrectedMotionAtPathTime(
      std::size_t pass, double measured_s, double path_s, const Eigen::VectorXd& x) const;

  /// A look with fixed path, with corrections `x`, read at its measured time;
  /// nothing outside the path.
  [[nodiscard]] std::optional<FixedPathLook> FixPath(std::size_t look,
                                                     const Eigen::VectorXd& x) const;

  /// Asks the memory for what a look will read of its path.
  void Prefetch(std::size_t look) const {
    paths_.PathOf(block_.looks.pass[look]).Prefetch(block_.looks.time_s[look]);
  }

  /// Reads the paths at the time biases in all corrections `x`; returns whether that changed what a
  /// look reads (CorrectedPaths::Anchor).
  bool Anchor(const Eigen::VectorXd& x, double slack = 0.0) { return paths_.Anchor(x, slack); }
  /// Reads the same passes where another model does.
  void AnchorLike(const LookModel& other) { paths_.AnchorLike(other.paths_); }

 private:
  enum class Beyond { kInside, kNear, kFar };
  [[nodiscard]] Beyond BeyondPath(std::size_t pass, double path_s) const;
  /// The motion read at read_s and continued to path_s.
  [[nodiscard]] std::optional<CorrectedMotion> ReadMotion(std::size_t pass,
                                                          double measured_s,
                                                          double read_s,
                                                          double path_s,
                                                          const Eigen::VectorXd& x) const;
  [[nodiscard]] Vertical DelayVerticalAt(const Eigen::Vector3d& p_m) const;

  const Block& block_;
  const ParameterLayout& layout_;
  Simplified simplified_;
  CorrectedPaths paths_;
  Vertical middle_;  // of a flat frame
  std::vector<std::array<double, 2>> sigma_factors_;
};

/// Local corrections of a look gathered from the block's vector x.
void GatherColumns(const ParameterLayout& layout,
                   const LookColumns& columns,
                   const Eigen::VectorXd& x,
                   double* local);

}  // namespace sarblock
