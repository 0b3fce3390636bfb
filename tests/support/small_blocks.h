// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/result.h"

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace sarblock::test {

/// One pass that looks at the middle of the area of a block.
struct PassPlan {
  LookSide side = LookSide::kLeft;
  double heading_deg = 0.0;     ///< of the flight, from x (local) or east towards north
  double ground_range_m = 0.0;  ///< from below the antenna to the middle of the area
  double height_m = 0.0;
  double squint_deg = 0.0;
  bool doppler = false;   ///< the cone is written as a Doppler centroid [Hz]
  bool straight = false;  ///< aircraft: without the swing of some metres
};

struct BlockPlan {
  bool orbit = false;  ///< circular orbits about WGS84; else aircraft in the local frame
  std::vector<PassPlan> passes;
  std::size_t points = 12;
  std::size_t looks_per_point = 0;  ///< consecutive passes that see a point; 0: all
  double extent_m = 0.0;            ///< half the width of the area
  double relief_m = 0.0;
  LookSigma sigma;
  std::uint64_t seed = 1;
};

/// Two passes of one side, one of the other and one across; antennas swing by some metres, so that
/// every derivative of the path is alive.
[[nodiscard]] BlockPlan AircraftPlan(double squint_deg = 0.0, bool doppler = false);
/// Two ascending passes and one descending, 700 km high.
[[nodiscard]] BlockPlan OrbitPlan(double squint_deg = 0.0, bool doppler = false);

/// A block whose looks are exact for `truth_m` and its paths. Points are ties without coordinates.
struct KnownBlock {
  Block block;
  std::vector<Eigen::Vector3d> truth_m;
};

/// Looks by the explicit model: time at which the point lies on the cone, range at that time.
[[nodiscard]] KnownBlock MakeBlock(const BlockPlan& plan);

/// Makes a point control (or check) at its true position; components without a standard deviation
/// (NaN) are free. `correlation_en` couples east and north.
void AddKnownPoint(std::size_t point,
                   const std::array<double, 3>& sigma_enu_m,
                   KnownBlock* known,
                   PointRole role = PointRole::kControl,
                   double correlation_en = 0.0);

/// Adds `factor` times normal noise of the looks' own standard deviations to ranges and times or
/// measured Dopplers, the same draw for the same seed.
void AddNoise(std::uint64_t seed, double factor, KnownBlock* known);

/// Moves the path of a pass by a constant, frame axes.
void ShiftPath(std::size_t pass, const Eigen::Vector3d& shift_m, Block* block);

/// sqrt(d' C^-1 d) of d = b - a, C a covariance in the east-north-up axes at a.
[[nodiscard]] double DistanceInSigmas(const Frame& frame,
                                      const Eigen::Vector3d& a_m,
                                      const Eigen::Vector3d& b_m,
                                      const SymmetricEnu& covariance_m2);

}  // namespace sarblock::test
