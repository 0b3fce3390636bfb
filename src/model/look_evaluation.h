// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/look_equations.h"

#include <array>
#include <cstddef>
#include <cstdint>

#include "corrected_paths.h"
#include "parameters.h"
#include <Eigen/Core>

namespace sarblock {

/// The two measurements of a look, and which of its numbers they are.
struct MeasuredLook {
  enum class Azimuth : std::uint8_t {
    kTime,     ///< the time; the cone is given
    kDoppler,  ///< the Doppler of the cone, at an exact time
    kNone,     ///< nothing: the range alone, at an exact time
  };
  double time_s = 0.0;
  double range_m = 0.0;
  Cone cone;
  Azimuth azimuth = Azimuth::kTime;
  double wavelength_m = kNotGiven;  ///< kDoppler
};

/// Weights of the two measurements of a look: one over their standard deviations. The unit of the
/// azimuth measurement is the second of a time, the hertz of a measured Doppler.
struct LookWeights {
  double range_per_m = 1.0;
  double azimuth_per_unit = 1.0;
};

/// The errors of the two measurements of a look, predicted less measured, and their partials, each
/// times its weight. Row 0 is the range, row 1 the azimuth time or the measured Doppler.
struct LookEvaluation {
  Eigen::Vector2d
      whitened_error;  ///< R_p - R [m] and t_p - t [s] or f_p - f [Hz], times the weights
  Eigen::Matrix<double, 2, 3> d_point;  ///< [1] and [s/m] or [Hz/m], times the weights
  /// By the look's local columns; the first column_count of each row are set.
  std::array<std::array<double, ParameterLayout::kMaxLocalColumns>, 2> row;
  /// Metres along track at the target per unit of the azimuth measurement: |de_d/df|, or the speed
  /// at which the look passes over it (docs/theory/observations.md, eq. (10b)), by velocity and
  /// acceleration of the given path without its noise. With those of the corrected path weights
  /// would change with every step, and steps with the weights.
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

/// Second derivatives of the two measurements of a look by d = p - s [m], v [m/s] and the part of
/// the antenna's acceleration that turns the cone, f_v.a [m/s], all at the crossing: of the
/// implicit function (docs/theory/adjustment.md, section 4).
struct LookCurvature {
  static constexpr Eigen::Index kSize = 7;
  using Matrix = Eigen::Matrix<double, kSize, kSize>;
  Matrix range, azimuth;  ///< of R_p [m] and of t_p [s] or f_p [Hz]
  /// Partials of the seven by the look's local columns; the first column_count of each are set. An
  /// extra last row makes their number even.
  std::array<std::array<double, ParameterLayout::kMaxLocalColumns>, kSize + 1> row;
  Eigen::Vector3d cone_by_velocity;  ///< f_v, 0 where the time is exact
};

/// Whether the model has a value for a look at a state, or why it has none.
enum class LookValue : std::uint8_t {
  kGiven,
  kBeyondPath,  ///< time plus bias lie beyond an end of the path by more than the path's length
  kNoCrossing,  ///< the cone passes over the point never or too slowly; the antenna is at the point
  kNotAbove,    ///< under a troposphere: the line of sight is level at the target, or rises
  kNotFinite,   ///< overflow
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
/// A look whose Doppler is the measurement (MeasuredLook::Azimuth::kDoppler) has an exact time: R_p
/// is e_r at t, f_p the Doppler whose cone holds the point then, e_d(p, t, f_p) = 0; f_p - f over
/// sigma_f.
///
/// s and v are position and velocity of the corrected path, the turning of the track axes included,
/// read at the measured time t, moved by whole steps of a grid to near t + b_t
/// (CorrectedPath::Anchor). From there the antenna moves on for what is left of b_t and the time
/// error t_p - t with its acceleration and jerk: within a piece of the path that is the path
/// itself, to third order. So the equations of a look are smooth however much the path's
/// acceleration jumps at its states, nothing is read beyond the ends of a path but for a time bias,
/// and a look depends on the same parameters at every state. Where states are noisy the antenna
/// moves on along the path without that noise (CorrectedPath::IsNoisy), which is read at t_p where
/// there is a time bias, the noise that of t (CorrectedPath::ReadsAtCrossing). t_p is found anew at
/// every evaluation (Newton's method on the cone, to 1e-12 of rho). For a range alone R_p is e_r at
/// t, as for a look whose Doppler is measured; row 1 is then 0.
///
/// Evaluates a look of a path at start_m + displacement_m under `columns` local corrections x,
/// where the model has a value. `curvature`, where given, is set too.
[[nodiscard]] LookValue EvaluateMeasuredLook(const CorrectedPath& corrected,
                                             const MeasuredLook& look,
                                             const Eigen::Vector3d& start_m,
                                             const Eigen::Vector3d& displacement_m,
                                             const double* x,
                                             int columns,
                                             const LookWeights& weights,
                                             LookEvaluation* out,
                                             LookCurvature* curvature = nullptr);

/// Where a time lies: within a path, beyond an end by at most its length, or farther.
enum class Beyond { kInside, kNear, kFar };
[[nodiscard]] Beyond BeyondPath(const FlightPath& path, double path_s);

/// Sum of the local corrections with these columns.
[[nodiscard]] inline double SumOf(const std::vector<int>& columns, const double* x) {
  double sum = 0.0;
  for (const int column : columns) sum += x[column];
  return sum;
}

}  // namespace sarblock
