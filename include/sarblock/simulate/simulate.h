// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"
#include "sarblock/simulate/scene.h"

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

class Wander;

/// The errors of one pass as drawn, signs as the corrections of model.md, section 3: adding them to
/// the nominal path and measurements gives the truth.
struct PassError {
  std::array<double, 3> constant_m{};           ///< along, across, up
  std::array<double, 3> drift_m{};              ///< times strip-normalised time x
  std::array<double, 3> curvature_m{};          ///< times (3 x^2 - 1) / 2
  std::array<std::vector<double>, 3> spline_m;  ///< B-spline coefficients; empty: no process
  /// Legendre degrees 0 to 2 along the axes of the frame.
  std::array<Eigen::Vector3d, 3> frame_m{
      Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  double range_bias_m = 0.0;
  double range_scale_1 = 0.0;
  double time_bias_s = 0.0;
  double squint_bias_rad = 0.0;
};

/// What the looks would read without noise, by look index of the block.
struct ExactLooks {
  std::vector<double> nominal_time_s;  ///< cone time on the nominal path: the planned look
  std::vector<double> time_s;   ///< cone time on the true path (model time, bias not removed)
  std::vector<double> range_m;  ///< |p - s| there
  std::vector<double> azimuth_rate_mps;  ///< |de_d/dt| there: metres at the target a second
  std::vector<double> doppler_hz;  ///< Doppler written for it; empty where squints are written
};

/// A block whose truth is known, as reading its files gives it: recorded flights are read in the
/// way that the scene's recorder states. Passes carry explicit start and end times.
struct SimulatedBlock {
  Block block;
  Truth truth;
  /// The passes with their planned paths where the states of the block are recorded on a flight
  /// (IsRecorded); else empty: the block holds the planned paths themselves.
  std::vector<Pass> planned;
  std::shared_ptr<const std::vector<Wander>> wander;  ///< by pass, as drawn; null: none wanders
  std::vector<PassError> errors;                      ///< by pass, as drawn
  std::vector<double> squint_rad;                     ///< nominal squint by pass
  ExactLooks exact;
  std::vector<std::uint8_t> blunder;  ///< by look, 1 where a blunder was added
  std::uint64_t measurement_seed = 0;
  std::uint64_t navigation_seed = 0;
  std::uint64_t control_seed = 0;

  [[nodiscard]] const Pass& Planned(std::size_t pass) const {
    return planned.empty() ? block.passes[pass] : planned[pass];
  }
  /// Null where the pass flies as planned.
  [[nodiscard]] const Wander* WanderOf(std::size_t pass) const;
};

/// Simulates a scene: nominal paths, terrain, points, visibility, then Redraw() of everything with
/// the scene's seed. The same scene gives the same bytes.
///
/// A point is seen by a pass when the cone equation on the nominal path has its solution inside the
/// strip's time and the point then lies inside the swath on the look side (docs/scenes.md). There
/// is no shadow or layover. Times and ranges come from the true path (model.md, section 4):
///
///     e_d(t) = 0 with squint tau + b_tau  ->  t;      t_measured = t - b_t + sigma_t n_1
///     R_measured = (1 + kappa) |p - s(t)| + b_r + sigma_R n_2
///
/// A look whose Doppler is measured has the time t - b_t exactly and sigma_f n_1 on its Doppler.
///
/// Order of points: control (C...), check (K...), tie (T...). Throws InputError (Validate) and
/// Interrupted.
[[nodiscard]] SimulatedBlock Simulate(const Scene& scene, ProgressSink* progress = nullptr);

/// What Redraw() draws anew; the rest stays as it is.
struct RedrawChoice {
  bool measurements = true;  ///< noise and blunders of the looks
  bool navigation = true;  ///< true paths, their recording and biases about the same planned paths
  bool control = true;     ///< errors of control and check coordinates
};

/// Draws random errors anew from `seed`, for seeded statistics: points, nominal paths and the list
/// of looks stay, so that a draw costs one cone solution a look (navigation) or two random numbers.
/// The result depends on scene, seeds and choice alone, not on earlier draws. `scene` must be the
/// one `simulated` was made from. Throws InputError if a true look leaves its nominal path's span.
void Redraw(const Scene& scene,
            std::uint64_t seed,
            const RedrawChoice& choice,
            SimulatedBlock* simulated);

}  // namespace sarblock
