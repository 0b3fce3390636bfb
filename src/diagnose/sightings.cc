// SPDX-License-Identifier: Apache-2.0
#include "sightings.h"

#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "edits.h"

namespace sarblock {
namespace {

constexpr std::size_t kMostKnown = 60;

Sighting See(const Block& block, std::size_t look, const Eigen::Vector3d& p_m) {
  const Pass& pass = block.passes[block.looks.pass[look]];
  Sighting out;
  out.look = look;
  out.time_s = block.looks.time_s[look];
  out.range_m = block.looks.range_m[look];
  const Cone cone = block.ConeOf(look);
  Motion motion;
  out.off_m = (p_m - pass.path.states().front().position_m).norm();
  if (!pass.path.Read(out.time_s, Acceleration::kOfCubic, &motion)) return out;
  const Eigen::Vector3d sight_m = p_m - motion.position_m;
  const double distance_m = sight_m.norm(), speed_mps = motion.velocity_mps.norm();
  const double ahead_m = motion.velocity_mps.dot(sight_m) / speed_mps;
  Sight sight;
  sight.antenna_m = motion.position_m;
  sight.velocity_mps = motion.velocity_mps;
  sight.side = pass.side == LookSide::kLeft ? 1 : -1;
  out.on_its_side = LiesWhereItLooks(block.frame, sight, p_m);
  out.ahead_sine_1 = ahead_m / distance_m;
  out.off_m = std::hypot(distance_m - out.range_m, ahead_m - distance_m * cone.Sine(speed_mps));
  if (!out.on_its_side) out.off_m += distance_m;
  return out;
}

void FindAbeam(const Block& block, const Eigen::Vector3d& p_m, Sighting* sighting) {
  const FlightPath& path = block.passes[block.looks.pass[sighting->look]].path;
  const std::optional<double> time_s =
      FindConeTime(path, p_m, block.ConeOf(sighting->look), path.start_s(), path.end_s());
  const std::optional<Motion> motion = time_s ? path.At(*time_s) : std::nullopt;
  if (!motion) return;
  sighting->true_time_s = *time_s;
  sighting->true_range_m = (p_m - motion->position_m).norm();
}

bool WhollyKnown(const Block& block, std::uint32_t point) {
  const KnownPosition* known = block.points.FindKnown(point);
  return known != nullptr && block.points.role[point] != PointRole::kTie && known->held[0] &&
         known->held[1] && known->held[2] && block.points.given_m[point].allFinite();
}

template <typename Use>
void ForKnownLooks(const Block& block, const Use& use) {
  for (std::uint32_t point = 0; point < block.points.size(); ++point) {
    if (!WhollyKnown(block, point)) continue;
    for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      if (!block.looks.rejected(i)) use(point, i);
    }
  }
}

}  // namespace

double Median(std::vector<double> values) {
  if (values.empty()) return kNotGiven;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Line RobustLine(const std::vector<double>& x, const std::vector<double>& y) {
  std::vector<double> slopes, offsets, distances;
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (std::size_t j = i + 1; j < x.size(); ++j) {
      if (x[i] != x[j]) slopes.push_back((y[j] - y[i]) / (x[j] - x[i]));
    }
  }
  Line line;
  if (slopes.empty()) return line;
  line.slope = Median(std::move(slopes));
  for (std::size_t i = 0; i < x.size(); ++i) offsets.push_back(y[i] - line.slope * x[i]);
  line.offset = Median(offsets);
  for (const double offset : offsets) distances.push_back(std::abs(offset - line.offset));
  line.spread = Median(std::move(distances));
  return line;
}

double MisfitOf(const Block& block) {
  std::vector<double> off_m;
  ForKnownLooks(block, [&](std::uint32_t point, std::size_t look) {
    off_m.push_back(See(block, look, block.points.given_m[point]).off_m);
  });
  return Median(std::move(off_m));
}

Sighting SightingAt(const Block& block, std::size_t look, const Eigen::Vector3d& p_m) {
  Sighting sighting = See(block, look, p_m);
  FindAbeam(block, p_m, &sighting);
  return sighting;
}

std::vector<PassSightings> SightingsOf(const Block& block) {
  std::vector<std::vector<std::uint32_t>> known(block.passes.size());
  ForKnownLooks(block, [&](std::uint32_t point, std::size_t look) {
    std::vector<std::uint32_t>& points = known[block.looks.pass[look]];
    if (points.empty() || points.back() != point) points.push_back(point);
  });
  std::vector<PassSightings> out(block.passes.size());
  for (std::uint32_t p = 0; p < out.size(); ++p) {
    PassSightings& of = out[p];
    of.pass = p;
    of.speed_mps = block.passes[p].path.states().front().velocity_mps.norm();
    std::vector<std::uint32_t>& points = known[p];
    if (points.size() > kMostKnown) {
      std::vector<std::uint32_t> kept;
      for (std::size_t i = 0; i < kMostKnown; ++i) {
        kept.push_back(points[i * points.size() / kMostKnown]);
      }
      points = std::move(kept);
    }
    of.part = PartOfPass(block, p, points);
    // Medians of metres need no smoothed path: other states are tried as they are.
    of.part.passes[0].recorded.asked.through = PathThrough::kStates;
    std::vector<double> off_m;
    ForKnownLooks(of.part, [&](std::uint32_t point, std::size_t look) {
      const Sighting sighting = SightingAt(of.part, look, of.part.points.given_m[point]);
      off_m.push_back(sighting.off_m);
      of.sightings.push_back(sighting);
    });
    of.misfit_m = Median(std::move(off_m));
  }
  return out;
}

}  // namespace sarblock
