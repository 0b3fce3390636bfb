// SPDX-License-Identifier: Apache-2.0
#include "plants_control.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "plants_draw.h"

namespace sarblock::test {
namespace {

template <typename Edit>
Planted EditKnown(Block* block, std::string cause, bool geocentric, const Edit& edit) {
  const bool is_geocentric = block->frame.kind() == FrameKind::kGeocentric;
  if (block->points.known.empty() || (geocentric && !is_geocentric)) return {};
  for (const KnownPosition& known : block->points.known) {
    edit(known.point, &block->points.given_m[known.point]);
  }
  return PlantEverywhere(std::move(cause));
}

/// A longitude that can be read as a latitude.
bool Exchangeable(const Block& block, std::uint32_t point) {
  if (block.frame.kind() != FrameKind::kGeocentric) return false;
  return std::abs(block.frame.GeodeticFromFrame(block.points.given_m[point]).lon_rad) <
         90.0 * kRadOfDeg;
}

Planted LatLon(Block* block, RandomStream*) {
  const Frame frame = block->frame;
  for (const KnownPosition& known : block->points.known) {
    if (!Exchangeable(*block, known.point)) return {};
  }
  return EditKnown(block, "control.lat_lon", true, [&](std::uint32_t, Eigen::Vector3d* p_m) {
    Geodetic at = frame.GeodeticFromFrame(*p_m);
    std::swap(at.lat_rad, at.lon_rad);
    *p_m = frame.FrameFromGeodetic(at);
  });
}

std::uint32_t DrawKnown(const Block& block, RandomStream* random) {
  const auto& known = block.points.known;
  return known[static_cast<std::size_t>(random->Uniform() * static_cast<double>(known.size()))]
      .point;
}

Planted OneLatLon(Block* block, RandomStream* random) {
  if (block->frame.kind() != FrameKind::kGeocentric || block->points.known.empty()) return {};
  const std::uint32_t point = DrawKnown(*block, random);
  if (!Exchangeable(*block, point)) return {};
  Geodetic at = block->frame.GeodeticFromFrame(block->points.given_m[point]);
  std::swap(at.lat_rad, at.lon_rad);
  block->points.given_m[point] = block->frame.FrameFromGeodetic(at);
  return {true, {"control.lat_lon"}, {}, {std::string(block->points.ids[point])}, ""};
}

Planted Radians(Block* block, RandomStream*) {
  const Frame frame = block->frame;
  return EditKnown(block, "control.radians", true, [&](std::uint32_t, Eigen::Vector3d* p_m) {
    Geodetic at = frame.GeodeticFromFrame(*p_m);
    *p_m = frame.FrameFromGeodetic({at.lat_rad * kRadOfDeg, at.lon_rad * kRadOfDeg, at.h_m});
  });
}

Planted Planetocentric(Block* block, RandomStream*) {
  const Frame frame = block->frame;
  if (frame.kind() == FrameKind::kGeocentric && frame.ellipsoid().flattening == 0.0) return {};
  return EditKnown(block, "control.planetocentric", true, [&](std::uint32_t, Eigen::Vector3d* p_m) {
    Geodetic at = frame.GeodeticFromFrame(*p_m);
    at.lat_rad = std::atan(std::pow(1.0 - frame.ellipsoid().flattening, 2) * std::tan(at.lat_rad));
    *p_m = frame.FrameFromGeodetic(at);
  });
}

Planted ControlKilometres(Block* block, RandomStream*) {
  return EditKnown(
      block, "control.km", false, [&](std::uint32_t, Eigen::Vector3d* p_m) { *p_m *= 1e-3; });
}

Planted OtherEllipsoid(Block* block, RandomStream*) {
  const Frame frame = block->frame;
  if (frame.kind() != FrameKind::kGeocentric) return {};
  Ellipsoid other = frame.ellipsoid();
  if (other.a_m > 6.2e6) {
    other = {"sphere", 6371000.0, 0.0};
  } else if (other.a_m > 5e6) {
    other = {"sphere", 6051000.0, 0.0};
  } else if (other.a_m > 3e6) {
    other = {"sphere", 3396190.0, 0.0};
  } else {
    other = {"sphere", 1738000.0, 0.0};
  }
  const Frame of_other = Frame::Geocentric(other);
  return EditKnown(block, "control.ellipsoid", true, [&](std::uint32_t, Eigen::Vector3d* p_m) {
    *p_m = frame.FrameFromGeodetic(of_other.GeodeticFromFrame(*p_m));
  });
}

/// Of the control alone: the check points see it.
Planted ControlHeight(Block* block, RandomStream* random) {
  bool check = false, control = false;
  double sigma_m = 0.0;
  for (const KnownPosition& known : block->points.known) {
    check = check || block->points.role[known.point] == PointRole::kCheck;
    control = control || block->points.role[known.point] == PointRole::kControl;
    sigma_m = std::max(sigma_m, std::sqrt(known.covariance_enu_m2(2, 2)));
  }
  if (!check || !control) return {};
  const double higher_m = DrawSign(random) * std::max(DrawSize(20.0, 60.0, random), 10.0 * sigma_m);
  return EditKnown(block, "control.height", false, [&](std::uint32_t point, Eigen::Vector3d* p_m) {
    if (block->points.role[point] != PointRole::kControl) return;
    *p_m += higher_m * block->frame.VerticalAt(*p_m).up;
  });
}

/// All known points by one vector.
Planted ShiftedControl(Block* block, RandomStream* random) {
  const double length_m = DrawSize(100.0, 400.0, random);
  Eigen::Vector3d shift_m(random->Normal(), random->Normal(), random->Normal());
  shift_m *= length_m / shift_m.norm();
  return EditKnown(
      block, "control.shift", false, [&](std::uint32_t, Eigen::Vector3d* p_m) { *p_m += shift_m; });
}

/// Errors of known points several times what is stated.
Planted ControlSigma(Block* block, RandomStream* random) {
  if (block->points.known.size() < 4) return {};
  const double factor = DrawSize(8.0, 30.0, random);
  for (const KnownPosition& known : block->points.known) {
    Eigen::Vector3d error_m;
    for (int i = 0; i < 3; ++i) {
      error_m[i] = random->Normal() * factor * std::sqrt(known.covariance_enu_m2(i, i));
    }
    Eigen::Vector3d& p_m = block->points.given_m[known.point];
    p_m += block->frame.EnuFromFrame(p_m).transpose() * error_m;
  }
  return {true, {"sigma.control"}, {}, {}, ""};
}

Planted OneControl(Block* block, RandomStream* random) {
  if (block->points.known.empty()) return {};
  const std::uint32_t point = DrawKnown(*block, random);
  const double off_m = DrawSize(0.01, 0.2, random) * MeanRange(*block);
  const Eigen::Vector3d direction(random->Normal(), random->Normal(), random->Normal());
  block->points.given_m[point] += off_m * direction.normalized();
  return {true, {"control.point"}, {}, {std::string(block->points.ids[point])}, ""};
}

Planted ExchangedControl(Block* block, RandomStream* random) {
  if (block->points.known.size() < 2) return {};
  const std::uint32_t a = DrawKnown(*block, random), b = DrawKnown(*block, random);
  if (a == b) return {};
  std::swap(block->points.given_m[a], block->points.given_m[b]);
  const auto [low, high] = std::minmax(a, b);
  return {true,
          {"control.exchanged"},
          {},
          {std::string(block->points.ids[low]), std::string(block->points.ids[high])},
          ""};
}

}  // namespace

std::vector<Plant> ControlPlants() {
  return {{"latitude and longitude exchanged", LatLon},
          {"the same of one point", OneLatLon},
          {"control in radians", Radians},
          {"planetocentric latitudes", Planetocentric},
          {"control in km", ControlKilometres},
          {"another ellipsoid", OtherEllipsoid},
          {"control heights above the geoid", ControlHeight},
          {"control shifted by one vector", ShiftedControl},
          {"sigmas of known points too small", ControlSigma},
          {"one known point wrong", OneControl},
          {"two known points exchanged", ExchangedControl}};
}

}  // namespace sarblock::test
