// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "product/radar_image.h"
#include <Eigen/Core>

namespace sarblock {

/// The times of the states in a model state of USGSCSM, evenly spaced.
struct CsmStateTimes {
  double first_s = 0.0;  ///< ephemeris time, m_t0Ephem
  double step_s = 0.0;   ///< m_dtEphem
  std::size_t count = 0;
  [[nodiscard]] double At(std::size_t k) const { return first_s + static_cast<double>(k) * step_s; }
};

/// What an ISD or a model state of USGSCSM's SAR model says, as much as a model state needs.
struct CsmModel {
  RadarImage image;
  /// Of a model state its own. Of an ISD those of its states, evenly spaced as USGSCSM makes them,
  /// closer where they are more than kLongestStep_s apart, and kBeyond more at both ends: USGSCSM
  /// interpolates with eight states only where four stand on both sides, linearly at the ends.
  CsmStateTimes times;
  double centre_s = 0.0, end_s = 0.0;  ///< ephemeris times of the image
  double least_height_m = 0.0, most_height_m = 0.0;
  std::string image_id, sensor, platform;
  std::vector<double> sun_position_m, sun_velocity_mps;  ///< body-fixed, empty where not given
  Eigen::Vector3d reference_m = Eigen::Vector3d::Zero();

  static constexpr double kLongestStep_s = 0.5;
  static constexpr std::size_t kBeyond = 4;
};

/// The text of an ISD or a model state, 256 MiB at most; throws InputError with the file.
[[nodiscard]] std::string ReadCsmText(const std::string& file);
/// Reads an ISD or a model state, known by how it begins. Throws InputError with file and key.
[[nodiscard]] CsmModel ReadCsmModel(const std::string& file);
[[nodiscard]] CsmModel ParseCsmModel(std::string_view text, const std::string& file);

/// The same of a model state alone: the name of the model, a new line, JSON. Positions take their
/// parameters (m_currentParameterValue); parameters of the velocity, and velocities that contradict
/// the motion of the positions, turn the Doppler cone without moving the path and are refused.
[[nodiscard]] CsmModel ParseCsmState(std::string_view text, const std::string& file);
/// Whether a text begins as a model state.
[[nodiscard]] bool IsCsmState(std::string_view text);

/// What an adjustment made of a model.
struct AdjustedCsmModel {
  double time_shift_s = 0.0;  ///< added to the times of the image and of its polynomials
  std::vector<GroundRangePolynomial> ground_range;  ///< times of the image before the shift
  std::vector<StateVector> states;                  ///< at CsmModel::times
  Eigen::Vector3d reference_m = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Identity();
};

/// The text of a model state, which says that this program wrote it; numbers read back to the same
/// double. The six parameters are zero: all of the adjustment is in states, times and polynomials.
[[nodiscard]] std::string CsmStateText(const CsmModel& model, const AdjustedCsmModel& adjusted);

}  // namespace sarblock
