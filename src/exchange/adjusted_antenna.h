// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/files/result.h"

#include <cstddef>
#include <string>
#include <vector>

#include "model/look_model.h"
#include <Eigen/Core>

namespace sarblock {

/// Position and velocity of an antenna by parameters: rows x, y, z [m] and vx, vy, vz [m/s] per
/// unit of the parameter.
using AntennaInfluence = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// One pass of a result beside the path that its image gave: what the corrections made of the
/// antenna and how well they are known.
///
/// At the measured time t the antenna is where the corrected path is read, at t + b_t with the time
/// bias b_t (docs/theory/flight_path.md). Holds a reference to the result.
class AdjustedAntenna {
 public:
  /// `image_path` is the path of the image before any correction, times as in the result; `file`
  /// names the image in messages. Throws InputError where path and result are of different images:
  /// with the result's corrections it lies more than kOther_m from the result's path.
  AdjustedAntenna(const ResultFile& result,
                  std::size_t pass,
                  const FlightPath& image_path,
                  const std::string& file);

  /// Paths of one image differ by less, however the states were read; those of others by much more.
  static constexpr double kOther_m = 10.0;

  [[nodiscard]] const ResultPass& pass() const { return result_.passes[pass_]; }
  /// Sum of the time biases.
  [[nodiscard]] double time_bias_s() const { return ValueOf(ParameterKind::kTimeBias); }
  /// Sum of the parameters of a kind other than a position, in their unit.
  [[nodiscard]] double ValueOf(ParameterKind kind) const;
  /// Corrected antenna at the measured time path_time_s - time_bias_s(); the first or last piece of
  /// the path is continued beyond its ends.
  [[nodiscard]] Motion MotionAt(double path_time_s) const;

  /// Parameters that correct this pass: their place in the result's list and what they are.
  [[nodiscard]] const std::vector<std::size_t>& parameters() const { return parameters_; }
  [[nodiscard]] const Parameter& parameter(std::size_t k) const {
    return layout_.parameters[parameters_[k]];
  }
  [[nodiscard]] double value(std::size_t k) const {
    return result_.parameters[parameters_[k]].value;
  }
  [[nodiscard]] double sigma(std::size_t k) const {
    return result_.parameters[parameters_[k]].sigma;
  }
  /// By parameters(): of positions and time biases; velocity groups turn the direction of flight
  /// and count where `with_direction`; all others are zero. Of the image's path, which the
  /// corrections depend on linearly.
  enum class Direction { kOfPath, kOfCone };
  [[nodiscard]] AntennaInfluence InfluenceAt(double path_time_s, Direction direction) const;
  /// Covariance by parameters(), in their units; without rows where the result has none.
  [[nodiscard]] const Eigen::MatrixXd& covariance() const { return covariance_; }
  [[nodiscard]] bool HasCovariance() const {
    return covariance_.rows() == static_cast<Eigen::Index>(parameters_.size());
  }

 private:
  void CollectParameters();
  void CollectCovariance();
  void RefuseOtherImage(const std::string& file) const;

  const ResultFile& result_;
  std::size_t pass_;
  Block block_;
  ParameterLayout layout_;
  LookModel model_;
  std::vector<std::size_t> parameters_;
  Eigen::MatrixXd covariance_;
};

/// Velocity direction of the cone as the velocity groups turn it, with the speed of the path:
/// |v| (v/|v| + c_across across + c_up up).
[[nodiscard]] Eigen::Vector3d ConeVelocity(const AdjustedAntenna& antenna,
                                           const Frame& frame,
                                           const Motion& motion);

}  // namespace sarblock
