// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/geometry/frame.h"

#include <memory>
#include <string>
#include <string_view>

#include <Eigen/Core>

namespace sarblock {

/// Whether a frame is that of the Earth: geocentric, with its ellipsoid to a part in a thousand.
[[nodiscard]] bool IsEarth(const Frame& frame);

/// A point that moves evenly: its position at an epoch and its velocity, Earth-fixed axes.
struct MovingPoint {
  Eigen::Vector3d position_m;
  Eigen::Vector3d velocity_mpy = Eigen::Vector3d::Zero();

  /// Where it is some years later or earlier.
  [[nodiscard]] MovingPoint After(double years) const {
    return {position_m + years * velocity_mpy, velocity_mpy};
  }
};

/// Realizations of terrestrial reference systems ("ITRF2014", "GDA2020", "NAD83(2011)") and
/// geoids, as the installed data of PROJ have them; nothing is downloaded. Keeps what it has looked
/// up. One object per thread.
class ReferenceFrames {
 public:
  ReferenceFrames();
  ~ReferenceFrames();
  ReferenceFrames(const ReferenceFrames&) = delete;
  ReferenceFrames& operator=(const ReferenceFrames&) = delete;

  /// The name as EPSG writes it. Throws InputError ("realization") where there is none of that
  /// name, or one that stands for several realizations metres apart (WGS 84, ETRS89).
  [[nodiscard]] std::string Named(std::string_view name);

  /// Whether the frame moves with a plate, so that a point at rest on it has constant coordinates.
  /// `name` as Named() returns it.
  [[nodiscard]] bool MovesWithPlate(const std::string& name);

  /// A point in another realization at the same epoch, its velocity included. Both names as Named()
  /// returns them. Throws InputError ("frame") where PROJ has no transformation of 0.1 m or better,
  /// and far from where one of the frames is used.
  [[nodiscard]] MovingPoint Transform(const std::string& from,
                                      const std::string& to,
                                      double epoch_year,
                                      const MovingPoint& point);

  /// Height of a geoid ("egm96", "egm2008") above the ellipsoid WGS84 [m], from a grid of 15' or
  /// 2.5'. Throws InputError ("geoid") where PROJ's data have no such grid.
  [[nodiscard]] double GeoidHeight_m(std::string_view geoid, double lat_rad, double lon_rad);

 private:
  class Library;
  std::unique_ptr<Library> library_;
};

/// What plate motion may cost known points of the Earth whose positions have no epoch, or no
/// velocity, between the dates of the images (and that epoch): a sentence where it is more than the
/// standard deviation of one of them, else empty.
[[nodiscard]] std::string DoubtOfPlates(const Block& block);

/// Throws InputError ("epoch") unless the number is a year like 2022.79, from 1980 to 2100.
void RequireEpoch(double epoch_year);

}  // namespace sarblock
