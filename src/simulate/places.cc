// SPDX-License-Identifier: Apache-2.0
#include "places.h"

#include "sarblock/core/statistics.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include "geometry/track_axes.h"
#include "scene.h"
#include <boost/math/tools/minima.hpp>

namespace sarblock {

Terrain::Terrain(const SceneTerrain& terrain, std::uint64_t seed) : mean_m_(terrain.height_m) {
  if (terrain.kind == SceneTerrain::Kind::kFlat || !(terrain.relief_m > 0.0)) return;
  relief_m_ = terrain.relief_m;
  const bool rugged = terrain.kind == SceneTerrain::Kind::kRugged;
  const int octaves = rugged ? 4 : 1;
  const int waves_per_octave = rugged ? 32 : 64;
  double square_sum = 0.0;
  for (int octave = 0; octave < octaves; ++octave) square_sum += std::pow(0.25, octave);
  RandomStream random(seed, MixStream(kTerrainStream, 0));
  for (int octave = 0; octave < octaves; ++octave) {
    const double correlation_m = terrain.correlation_m * std::pow(0.5, octave);
    shortest_m_ = correlation_m;
    const double octave_rms_m = terrain.relief_m * std::pow(0.5, octave) / std::sqrt(square_sum);
    for (int i = 0; i < waves_per_octave; ++i) {
      const double kx = random.Normal() * std::numbers::sqrt2 / correlation_m;
      const double ky = random.Normal() * std::numbers::sqrt2 / correlation_m;
      waves_.push_back({{kx, ky},
                        2.0 * std::numbers::pi * random.Uniform(),
                        octave_rms_m * std::sqrt(2.0 / waves_per_octave)});
    }
  }
}

double Terrain::HeightAt(const Eigen::Vector2d& plane_m) const {
  double height_m = mean_m_;
  for (const Wave& wave : waves_) {
    height_m += wave.amplitude_m * std::cos(wave.wave_rad_per_m.dot(plane_m) + wave.phase_rad);
  }
  return height_m;
}

Ground Terrain::AsGround() const {
  constexpr double kSigmas = 6.0;
  double square_slope = 0.0;  // of both directions
  for (const Wave& wave : waves_) {
    square_slope += 0.5 * wave.amplitude_m * wave.amplitude_m * wave.wave_rad_per_m.squaredNorm();
  }
  return {[this](const Eigen::Vector2d& plane_m) { return HeightAt(plane_m); },
          mean_m_ - kSigmas * relief_m_,
          mean_m_ + kSigmas * relief_m_,
          kSigmas * std::sqrt(0.5 * square_slope),
          shortest_m_};
}

namespace {

/// A rectangle of the scene plane.
struct Area {
  Eigen::Vector2d low_m;
  Eigen::Vector2d size_m;
  [[nodiscard]] Eigen::Vector2d At(double x_part, double y_part) const {
    return low_m + Eigen::Vector2d(x_part * size_m.x(), y_part * size_m.y());
  }
};

Area AreaOf(const std::array<double, 2>& east_m,
            const std::array<double, 2>& north_m,
            double inset) {
  const Eigen::Vector2d low_m(east_m[0], north_m[0]);
  const Eigen::Vector2d size_m(east_m[1] - east_m[0], north_m[1] - north_m[0]);
  return {low_m + inset * size_m, (1.0 - 2.0 * inset) * size_m};
}

Eigen::Vector2d Random(const Area& area, RandomStream* random) {
  const double x_part = random->Uniform();
  return area.At(x_part, random->Uniform());
}

/// Place of a point in a grid, row by row.
struct GridPlace {
  std::size_t column = 0, columns = 0;  ///< of its row
  std::size_t row = 0, rows = 0;
};

/// Place of point i of `count` in about square cells. Rows differ by one point at most, and the
/// longer ones are the outer ones, so that the corners are taken whatever the count.
GridPlace PlaceInGrid(std::size_t i, std::size_t count, const Area& area) {
  const double wanted = std::sqrt(static_cast<double>(count) * area.size_m.x() / area.size_m.y());
  const double bounded = std::clamp(std::round(wanted), 1.0, static_cast<double>(count));
  const auto columns = static_cast<std::size_t>(bounded);
  const std::size_t rows = (count + columns - 1) / columns;
  const std::size_t shorter_length = count / rows, longer = count % rows;
  const std::size_t first_longer = (longer + 1) / 2;  // the rest at the other end
  const std::size_t first = first_longer * (shorter_length + 1);
  const std::size_t middle = first + (rows - longer) * shorter_length;
  const auto place = [rows](std::size_t index, std::size_t first_row, std::size_t length) {
    return GridPlace{index % length, length, first_row + index / length, rows};
  };
  if (i < first) return place(i, 0, shorter_length + 1);
  if (i < middle) return place(i - first, first_longer, shorter_length);
  return place(i - middle, rows - longer + first_longer, shorter_length + 1);
}

/// i of n from edge to edge; a single one is in the middle.
double EdgeToEdge(std::size_t i, std::size_t n) {
  return n == 1 ? 0.5 : static_cast<double>(i) / static_cast<double>(n - 1);
}

/// Point at part s (0 <= s < 1) of the way round, anticlockwise from the lower left corner.
Eigen::Vector2d PointOnPerimeter(const Area& area, double s) {
  const double width_m = area.size_m.x();
  const double height_m = area.size_m.y();
  double way_m = s * 2.0 * (width_m + height_m);
  if (way_m < width_m) return area.At(way_m / width_m, 0.0);
  way_m -= width_m;
  if (way_m < height_m) return area.At(1.0, way_m / height_m);
  way_m -= height_m;
  if (way_m < width_m) return area.At(1.0 - way_m / width_m, 1.0);
  return area.At(0.0, 1.0 - (way_m - width_m) / height_m);
}

Eigen::Vector2d KnownPlace(const SceneControl& known,
                           const Area& area,
                           std::size_t i,
                           RandomStream* random) {
  using Layout = SceneControl::Layout;
  switch (known.layout) {
    case Layout::kCorners: {  // diagonal first, so that two or three of them span the area
      constexpr double kX[4] = {0.0, 1.0, 1.0, 0.0};
      constexpr double kY[4] = {0.0, 1.0, 0.0, 1.0};
      return area.At(kX[i % 4], kY[i % 4]);
    }
    case Layout::kPerimeter:
      return PointOnPerimeter(area, static_cast<double>(i) / static_cast<double>(known.count));
    case Layout::kGrid: {
      const GridPlace place = PlaceInGrid(i, known.count, area);
      return area.At(EdgeToEdge(place.column, place.columns), EdgeToEdge(place.row, place.rows));
    }
    case Layout::kChain: {
      const double s = EdgeToEdge(i, known.count);
      return area.size_m.x() >= area.size_m.y() ? area.At(s, 0.5) : area.At(0.5, s);
    }
    case Layout::kPlaces:
      return known.places_m[i];
    case Layout::kRandom:
    case Layout::kNone:
      break;
  }
  return Random(area, random);
}

std::string Numbered(char stem, std::size_t i) {
  std::string id(1, stem);
  id += std::to_string(i + 1);
  return id;
}

void PlaceKnown(const Scene& scene,
                const SceneControl& known,
                PointRole role,
                std::vector<PlacedPoint>* placed) {
  if (known.layout == SceneControl::Layout::kNone) return;
  const Area area = AreaOf(std::isnan(known.east_m[0]) ? scene.points.east_m : known.east_m,
                           std::isnan(known.north_m[0]) ? scene.points.north_m : known.north_m,
                           known.inset);
  const bool control = role == PointRole::kControl;
  const StreamKind stream = control ? kControlPlaceStream : kCheckPlaceStream;
  for (std::size_t i = 0; i < known.count; ++i) {
    RandomStream random(scene.seed, MixStream(stream, i));
    placed->push_back(
        {Numbered(control ? 'C' : 'K', i), role, KnownPlace(known, area, i, &random)});
  }
}

}  // namespace

PointPlan::PointPlan(const Scene& scene) : scene_(scene) {
  PlaceKnown(scene, scene.control, PointRole::kControl, &known_);
  PlaceKnown(scene, scene.check, PointRole::kCheck, &known_);
}

PlacedPoint PointPlan::At(std::size_t index) const {
  if (index < known_.size()) return known_[index];
  const std::size_t i = index - known_.size();
  const Area area = AreaOf(scene_.points.east_m, scene_.points.north_m, 0.0);
  Eigen::Vector2d plane_m;
  if (scene_.points.pattern == ScenePoints::Pattern::kGrid) {  // centres of cells
    const GridPlace place = PlaceInGrid(i, scene_.points.count, area);
    plane_m =
        area.At((static_cast<double>(place.column) + 0.5) / static_cast<double>(place.columns),
                (static_cast<double>(place.row) + 0.5) / static_cast<double>(place.rows));
  } else {
    RandomStream random(scene_.seed, MixStream(kTieStream, i));
    plane_m = Random(area, &random);
  }
  return {Numbered('T', i), PointRole::kTie, plane_m};
}

namespace {

constexpr double kStepsPerDetail = 8.0;
constexpr double kFirstStep = 1.0 / 1024.0;  // of the others; from there they double

/// A clearance somewhere on a line or circle, and whether all that follows is free of ground.
struct Sample {
  double clear_m = 0.0;
  bool last = false;
};

/// Whether a clearance that is zero at the start falls below zero on the way. `clearance(at_m)`
/// falls by at most `fall` per metre.
template <typename Function>
bool FallsBelowZero(const Function& clearance, double length_m, double fall, double step_m) {
  if (!(fall > 0.0)) return false;
  struct Place {
    double at_m = 0.0, clear_m = 0.0;
  };
  // Steps longer than step_m are short enough for the clearance at their start.
  const auto dips_between = [&](const Place& from, const Place& to) {
    if (from.clear_m >= fall * (to.at_m - from.at_m)) return false;
    constexpr int kBits = 11;
    std::uintmax_t iterations = 60;
    const auto least = boost::math::tools::brent_find_minima(
        [&](double since_m) { return clearance(from.at_m + since_m).clear_m; },
        0.0,
        to.at_m - from.at_m,
        kBits,
        iterations);
    return least.second < 0.0;
  };
  Place before, here;
  double at_m = kFirstStep * step_m;
  while (true) {
    at_m = std::min(at_m, length_m);
    const Sample sample = clearance(at_m);
    if (sample.clear_m < 0.0) return true;
    const Place next{at_m, sample.clear_m};
    if (here.clear_m < before.clear_m && here.clear_m <= next.clear_m &&
        (dips_between(before, here) || dips_between(here, next))) {
      return true;
    }
    if (sample.last || at_m == length_m) return dips_between(here, next);
    before = std::exchange(here, next);
    at_m += std::max(std::min(at_m, step_m), sample.clear_m / fall);
  }
}

/// How fast the clearance falls at most along a direction, over the steepest slope.
double FallAlong(const Eigen::Vector3d& direction, const Eigen::Vector3d& up, double steepest) {
  const double rise = direction.dot(up);
  return steepest * std::sqrt(std::max(0.0, 1.0 - rise * rise)) - rise;
}

}  // namespace

TerrainSight::TerrainSight(const Scene& scene, Ground ground)
    : scene_(scene), ground_(std::move(ground)) {
  if (scene.frame.kind() == FrameKind::kLocal) return;
  origin_m_ = FrameFromPlane(scene, Eigen::Vector2d::Zero(), 0.0);
  enu_from_frame_ = scene.frame.EnuFromFrame(origin_m_);
}

TerrainSight::Height TerrainSight::HeightOf(const Eigen::Vector3d& p_m) const {
  // The vertical through p meets the tangent plane at the place from which FrameFromPlane() makes
  // p.
  const Vertical vertical = scene_.frame.VerticalAt(p_m);
  const Eigen::Vector3d up = enu_from_frame_ * vertical.up;
  const Eigen::Vector3d enu_m = enu_from_frame_ * (p_m - origin_m_);
  const Eigen::Vector2d plane_m = enu_m.head<2>() - enu_m.z() / up.z() * up.head<2>();
  return {vertical.height_m, vertical.height_m - ground_.height_m(plane_m)};
}

bool TerrainSight::InShadow(const Eigen::Vector3d& antenna_m, const Eigen::Vector3d& p_m) const {
  const double range_m = (antenna_m - p_m).norm();
  const Eigen::Vector3d direction = (antenna_m - p_m) / range_m;
  const auto clearance = [&](double at_m) {
    const Height height = HeightOf(p_m + at_m * direction);
    return Sample{height.clear_m, height.own_m > ground_.highest_m};
  };
  // The line steepens on its way up: it falls fastest at its start.
  const double fall = FallAlong(direction, scene_.frame.UpAt(p_m), ground_.steepest);
  return FallsBelowZero(clearance, range_m, fall, ground_.detail_m / kStepsPerDetail);
}

bool TerrainSight::InLayover(const Motion& motion,
                             LookSide side,
                             const Eigen::Vector3d& p_m) const {
  const Eigen::Matrix3d axes = TrackAxesOf(scene_.frame, motion).axes;
  const Eigen::Vector3d across = static_cast<double>(side) * axes.col(1), up = axes.col(2);
  const Eigen::Vector3d d = p_m - motion.position_m;
  const double radius_m = std::hypot(d.dot(across), d.dot(up));
  const double look_rad = std::atan2(d.dot(across), -d.dot(up));
  const Eigen::Vector3d centre_m = motion.position_m + d.dot(axes.col(0)) * axes.col(0);
  const auto height_at = [&](double outward_m) {
    const double angle_rad = look_rad + outward_m / radius_m;
    return HeightOf(centre_m +
                    radius_m * (std::sin(angle_rad) * across - std::cos(angle_rad) * up));
  };
  const double step_m = ground_.detail_m / kStepsPerDetail;
  // Outward the circle rises out of the ground, ever more steeply.
  const Eigen::Vector3d outward = std::cos(look_rad) * across + std::sin(look_rad) * up;
  const auto above = [&](double at_m) {
    const Height height = height_at(at_m);
    return Sample{height.clear_m, height.own_m > ground_.highest_m};
  };
  const double fall = FallAlong(outward, scene_.frame.UpAt(p_m), ground_.steepest);
  if (FallsBelowZero(above, radius_m * (std::numbers::pi - look_rad), fall, step_m)) return true;
  // Inward it goes down into it, to R (1 - cos(look)) deep over R sin(look) at the nadir.
  if (ground_.steepest < std::tan(0.5 * look_rad)) return false;
  const auto below = [&](double at_m) {
    const Height height = height_at(-at_m);
    return Sample{-height.clear_m, height.own_m < ground_.lowest_m};
  };
  return FallsBelowZero(below, radius_m * look_rad, ground_.steepest, step_m);
}

std::optional<LookLoss> TerrainSight::Hides(const Motion& motion,
                                            LookSide side,
                                            const Eigen::Vector3d& p_m) const {
  if (InShadow(motion.position_m, p_m)) return LookLoss::kShadow;
  if (InLayover(motion, side, p_m)) return LookLoss::kLayover;
  return std::nullopt;
}

}  // namespace sarblock
