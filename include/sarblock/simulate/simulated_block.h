// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"

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

}  // namespace sarblock
