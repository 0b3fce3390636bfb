// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// What ErrorStatistics says of the errors of an image, standard deviations; nothing where an
/// element is left out.
struct SicdErrorStatistics {
  /// Axes of PosVelErr: earth-fixed, or radial, in-track and cross-track of the earth-fixed or of
  /// the inertial velocity.
  enum class Axes : std::uint8_t { kEcf, kRicEcf, kRicEci };
  struct PositionAndVelocity {
    Axes axes = Axes::kEcf;
    /// Of P1, P2, P3 [m] and V1, V2, V3 [m/s] at the aperture of the scene centre.
    std::array<double, 6> sigma{};
    Eigen::Matrix<double, 6, 6> correlation = Eigen::Matrix<double, 6, 6>::Identity();
    bool correlated = false;  ///< CorrCoefs stands in the file
  };
  std::optional<PositionAndVelocity> path;
  std::optional<double> range_bias_m;
  std::optional<double> zenith_delay_m;  ///< TropoRangeVertical
  /// Unmodeled: what is left of rows and columns, in metres of range and azimuth at the target.
  std::optional<double> row_sigma_m, column_sigma_m;
  std::vector<std::string> not_used;  ///< elements that stand there and become nothing
};

}  // namespace sarblock
