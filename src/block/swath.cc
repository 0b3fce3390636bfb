// SPDX-License-Identifier: Apache-2.0
#include "swath.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "core/text.h"
#include "core/threads.h"
#include "geometry/track_axes.h"

namespace sarblock {

namespace {

/// A position in the track axes of a flight.
struct Sight {
  double across_m = 0.0;  ///< positive on the look side
  double down_m = 0.0;
  double range_m = 0.0;

  Sight(const Frame& frame, const Motion& motion, LookSide side, const Eigen::Vector3d& p_m) {
    const Eigen::Vector3d d = p_m - motion.position_m;
    const Eigen::Matrix3d axes = TrackAxesOf(frame, motion).axes;
    across_m = d.dot(axes.col(1)) * static_cast<double>(side);
    down_m = -d.dot(axes.col(2));
    range_m = d.norm();
  }
  /// What bounds a swath of this kind: [rad] or [m].
  [[nodiscard]] double Quantity(SwathKind kind) const {
    if (kind == SwathKind::kSlantRange) return range_m;
    return kind == SwathKind::kGroundRange ? across_m : std::atan2(across_m, down_m);
  }
};

std::optional<Unseen> FindUnseen(const Frame& frame,
                                 const Pass& pass,
                                 const Motion& motion,
                                 const Eigen::Vector3d& p_m) {
  const Sight sight(frame, motion, pass.side, p_m);
  if (!(sight.across_m > 0.0)) return Unseen::kWrongSide;
  if (!(frame.UpAt(p_m).dot(motion.position_m - p_m) > 0.0)) return Unseen::kBelowHorizon;
  if (!pass.swath) return std::nullopt;
  const double value = sight.Quantity(pass.swath->kind);
  const bool within = pass.swath->limits[0] <= value && value <= pass.swath->limits[1];
  return within ? std::nullopt : std::optional(Unseen::kOutsideSwath);
}

}  // namespace

bool IsSeen(const Frame& frame,
            const Pass& pass,
            const Motion& motion,
            const Eigen::Vector3d& p_m) {
  return !FindUnseen(frame, pass, motion, p_m);
}

double FarRange(const Swath& swath,
                double depth_m,
                double antenna_radius_m,
                double ground_radius_m) {
  const double far = swath.limits[1];
  if (swath.kind == SwathKind::kSlantRange) return far;
  if (swath.kind == SwathKind::kGroundRange) return std::hypot(far, depth_m);
  if (!std::isfinite(ground_radius_m)) return depth_m / std::cos(far);
  const double under =
      ground_radius_m * ground_radius_m - std::pow(antenna_radius_m * std::sin(far), 2);
  return under > 0.0 ? antenna_radius_m * std::cos(far) - std::sqrt(under) : kNotGiven;
}

std::optional<double> TimeSeen(const Frame& frame,
                               const Pass& pass,
                               const Eigen::Vector3d& p_m,
                               Unseen* why) {
  const std::optional<double> time_s = FindConeTime(pass.path,
                                                    p_m,
                                                    Cone{.squint_rad = pass.squint_rad},
                                                    std::max(pass.start_s, pass.path.start_s()),
                                                    std::min(pass.end_s, pass.path.end_s()));
  const std::optional<Motion> motion = time_s ? pass.path.At(*time_s) : std::nullopt;
  const std::optional<Unseen> unseen =
      motion ? FindUnseen(frame, pass, *motion, p_m) : Unseen::kBeyondStrip;
  if (!unseen) return time_s;
  if (why != nullptr) *why = *unseen;
  return std::nullopt;
}

namespace {

/// Calls `look(index, point, sight)` for looks of points [begin, end) with a time on their path and
/// a finite position.
template <typename Function>
void ForPlacedLooks(const Block& block,
                    const std::vector<Eigen::Vector3d>& positions_m,
                    std::size_t begin,
                    std::size_t end,
                    const Function& look) {
  const std::vector<std::uint64_t>& offsets = block.looks.offsets;
  for (std::size_t point = begin; point < end; ++point) {
    if (!positions_m[point].allFinite()) continue;
    for (std::size_t i = offsets[point]; i < offsets[point + 1]; ++i) {
      Motion motion;
      const Pass& pass = block.passes[block.looks.pass[i]];
      if (!block.looks.rejected(i) && pass.path.Evaluate(block.looks.time_s[i], &motion)) {
        look(i, point, Sight(block.frame, motion, pass.side, positions_m[point]));
      }
    }
  }
}

/// Looks outside swaths of one kind.
struct Outside {
  std::size_t looks = 0;
  double by = 0.0;     ///< of the farthest: beyond its limit, in widths of the swath
  double value = 0.0;  ///< its quantity
  std::size_t pass = 0, point = 0;

  void Add(const Outside& other) {
    const std::size_t sum = looks + other.looks;
    if (other.by > by) *this = other;
    looks = sum;
  }
};
using OutsideByKind = std::array<Outside, kSwathKeys.size()>;

OutsideByKind FindOutside(const Block& block,
                          const std::vector<Eigen::Vector3d>& positions_m,
                          const std::vector<std::uint8_t>& look_used,
                          std::size_t begin,
                          std::size_t end) {
  OutsideByKind kinds;
  ForPlacedLooks(
      block, positions_m, begin, end, [&](std::size_t i, std::size_t point, const Sight& sight) {
        const std::size_t pass = block.looks.pass[i];
        const std::optional<Swath>& swath = block.passes[pass].swath;
        if (!swath || look_used[i] == 0) return;
        const auto [near, far] = swath->limits;
        const double value = sight.Quantity(swath->kind);
        const double by = std::max(near - value, value - far) / (far - near);
        if (!(by > kSwathMargin)) return;
        kinds[static_cast<std::size_t>(swath->kind)].Add({1, by, value, pass, point});
      });
  return kinds;
}

std::string Describe(const Block& block, SwathKind kind, const Outside& outside) {
  const SwathKey& key = kSwathKeys[static_cast<std::size_t>(kind)];
  const auto shown = [&key](double value) {  // four digits, never "1.3e+04"
    return NumberText(std::strtod(Digits(value / key.factor, 4).c_str(), nullptr));
  };
  const Pass& pass = block.passes[outside.pass];
  const bool one = outside.looks == 1;
  return std::to_string(outside.looks) + (one ? " look is" : " looks are") +
         " outside the swath of " + (one ? "its" : "their") +
         " pass: " + (one ? "" : "the farthest, ") + "pass " + pass.id + " sees point " +
         std::string(block.points.ids[static_cast<std::uint32_t>(outside.point)]) + " at " +
         shown(outside.value) + ", where " + key.key + " = [" + shown(pass.swath->limits[0]) +
         ", " + shown(pass.swath->limits[1]) + "]; check limits, look side, point and path";
}

}  // namespace

std::vector<std::string> FindLooksOutsideSwath(const Block& block,
                                               const std::vector<Eigen::Vector3d>& positions_m,
                                               const std::vector<std::uint8_t>& look_used) {
  if (std::none_of(block.passes.begin(), block.passes.end(), [](const Pass& pass) {
        return pass.swath.has_value();
      })) {
    return {};
  }
  const std::size_t points = block.points.size();
  std::vector<OutsideByKind> pieces(PiecesOfLooks(points));
  ForPiecesOfLooks(points, [&](std::size_t piece, std::size_t begin, std::size_t end) {
    pieces[piece] = FindOutside(block, positions_m, look_used, begin, end);
  });
  std::vector<std::string> sentences;
  for (std::size_t kind = 0; kind < kSwathKeys.size(); ++kind) {
    Outside all;
    for (const OutsideByKind& piece : pieces) all.Add(piece[kind]);
    if (all.looks > 0) sentences.push_back(Describe(block, static_cast<SwathKind>(kind), all));
  }
  return sentences;
}

Coverage CoverageOf(const Block& block, const std::vector<Eigen::Vector3d>& positions_m) {
  Coverage coverage;
  std::vector<std::size_t> looks(block.points.size(), 0);
  std::size_t all = 0;
  const auto count = [&](std::size_t, std::size_t point, const Sight& sight) {
    const double angle_rad = sight.Quantity(SwathKind::kLookAngle);
    coverage.least_look_rad = std::fmin(coverage.least_look_rad, angle_rad);
    coverage.most_look_rad = std::fmax(coverage.most_look_rad, angle_rad);
    ++looks[point];
    ++all;
  };
  ForPlacedLooks(block, positions_m, 0, looks.size(), count);
  if (looks.empty()) return coverage;
  const auto [fewest, most] = std::minmax_element(looks.begin(), looks.end());
  coverage.looks_per_point = static_cast<double>(all) / static_cast<double>(looks.size());
  coverage.fewest = *fewest;
  coverage.most = *most;
  coverage.points_by_looks.resize(*most + 1, 0);
  for (const std::size_t of_point : looks) ++coverage.points_by_looks[of_point];
  return coverage;
}

std::string Describe(const Coverage& coverage) {
  if (coverage.most == 0) return "no looks";
  return Digits(coverage.looks_per_point, 3) + " looks per point (" +
         std::to_string(coverage.fewest) + " to " + std::to_string(coverage.most) +
         ") at look angles of " + Digits(coverage.least_look_rad / kRadPerDeg, 3) + " to " +
         Digits(coverage.most_look_rad / kRadPerDeg, 3) + " degrees";
}

std::optional<std::string> WarningOfPlan(const Block& planned,
                                         const std::vector<Eigen::Vector3d>& positions_m) {
  if (std::all_of(planned.passes.begin(), planned.passes.end(), [](const Pass& pass) {
        return pass.swath.has_value();
      })) {
    return std::nullopt;
  }
  return "a plan without rows of looks, and not every pass has a swath: each such pass sees all "
         "that is on its look side, " +
         Describe(CoverageOf(planned, positions_m)) +
         "; swath_look_deg, swath_range_m or swath_ground_m of a pass says what it sees";
}

}  // namespace sarblock
