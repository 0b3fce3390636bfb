// SPDX-License-Identifier: Apache-2.0
#include "point_pairs.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "geometry/track_axes.h"
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <boost/geometry.hpp>
#include <boost/geometry/index/rtree.hpp>

namespace sarblock {
namespace {

namespace bg = boost::geometry;
using Place = bg::model::point<double, 3, bg::cs::cartesian>;
using Entry = std::pair<Place, std::uint32_t>;

Place PlaceOf(const Eigen::Vector3d& p_m) { return {p_m.x(), p_m.y(), p_m.z()}; }

std::vector<Entry> SolvedPoints(const AdjustmentProblem& problem, const BlockState& state) {
  std::vector<Entry> out;
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (!problem.Solves(point)) continue;
    out.emplace_back(PlaceOf(state.Position(point)), static_cast<std::uint32_t>(point));
  }
  return out;
}

using Tree = bg::index::rtree<Entry, bg::index::quadratic<16>>;

void AppendPair(std::uint32_t a, std::uint32_t b, PointPairs* pairs) {
  if (a != b) pairs->emplace_back(std::min(a, b), std::max(a, b));
}

PointPairs Sorted(PointPairs pairs) {
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

/// Along and across the track of the first pass at its middle, frame axes.
std::optional<std::array<Eigen::Vector3d, 2>> DirectionsOf(const Block& block) {
  if (block.passes.empty()) return std::nullopt;
  const Pass& pass = block.passes.front();
  const std::optional<Motion> motion = pass.path.At(0.5 * (pass.start_s + pass.end_s));
  if (!motion) return std::nullopt;
  const Eigen::Matrix3d axes = TrackAxesOf(block.frame, *motion).axes;
  return std::array<Eigen::Vector3d, 2>{axes.col(0), axes.col(1)};
}

}  // namespace

PointPairs NeighbourPairs(const AdjustmentProblem& problem, const BlockState& state) {
  const std::vector<Entry> entries = SolvedPoints(problem, state);
  const Tree tree(entries);
  PointPairs pairs;
  std::vector<Entry> nearest;
  for (const Entry& entry : entries) {
    nearest.clear();
    tree.query(bg::index::nearest(entry.first, 2), std::back_inserter(nearest));
    for (const Entry& other : nearest) AppendPair(entry.second, other.second, &pairs);
  }
  return Sorted(std::move(pairs));
}

PointPairs AllPairs(const AdjustmentProblem& problem, std::size_t most) {
  std::vector<std::uint32_t> solved;
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (problem.Solves(point)) solved.push_back(static_cast<std::uint32_t>(point));
  }
  const std::size_t count = solved.size() < 2 ? 0 : solved.size() * (solved.size() - 1) / 2;
  if (count > most) {
    throw InputError("adjust.pairs",
                     "'all' means " + std::to_string(count) + " pairs, at most " +
                         std::to_string(most) + " are allowed; name the pairs in a file");
  }
  PointPairs pairs;
  for (std::size_t i = 0; i < solved.size(); ++i) {
    for (std::size_t j = i + 1; j < solved.size(); ++j) pairs.emplace_back(solved[i], solved[j]);
  }
  return pairs;
}

PointPairs DistancePairs(const AdjustmentProblem& problem, const BlockState& state) {
  constexpr int kDistances = 8, kTrials = 256;
  constexpr std::size_t kMost = 32;
  constexpr double kLongest = 0.7, kOffPlace = 0.25;
  const std::vector<Entry> entries = SolvedPoints(problem, state);
  const auto directions = DirectionsOf(problem.block);
  if (!directions || entries.size() < 2) return {};
  const Tree tree(entries);
  PointPairs pairs;
  for (const Eigen::Vector3d& direction : *directions) {
    const auto along = [&](const Entry& entry) {
      return direction.dot(state.Position(entry.second));
    };
    const auto [first, last] =
        std::minmax_element(entries.begin(), entries.end(), [&](const Entry& a, const Entry& b) {
          return along(a) < along(b);
        });
    double distance_m = kLongest * (along(*last) - along(*first));
    for (int halved = 0; halved < kDistances; ++halved, distance_m *= 0.5) {
      PointPairs found;
      RandomStream random(static_cast<std::uint64_t>(halved), entries.size());
      for (int trial = 0; trial < kTrials && found.size() < kMost; ++trial) {
        const auto drawn =
            static_cast<std::size_t>(random.Uniform() * static_cast<double>(entries.size()));
        const std::uint32_t from = entries[drawn].second;
        const Eigen::Vector3d aim_m = state.Position(from) + distance_m * direction;
        std::vector<Entry> nearest;
        tree.query(bg::index::nearest(PlaceOf(aim_m), 1), std::back_inserter(nearest));
        const std::uint32_t to = nearest.front().second;
        if ((state.Position(to) - aim_m).norm() > kOffPlace * distance_m) continue;
        AppendPair(from, to, &found);
      }
      pairs.insert(pairs.end(), found.begin(), found.end());
    }
  }
  return Sorted(std::move(pairs));
}

std::array<double, 3> AlongAcrossUp(const SymmetricEnu& covariance_m2,
                                    const Eigen::Vector2d& along) {
  const auto& q = covariance_m2;  // ee, nn, uu, en, eu, nu
  const double e = along.x(), n = along.y();
  const double along_m2 = e * e * q[0] + n * n * q[1] + 2.0 * e * n * q[3];
  return {along_m2, q[0] + q[1] - along_m2, q[2]};
}

std::vector<DifferenceClass> SummariseDifferences(const Block& block, const AdjustResult& result) {
  const auto directions = DirectionsOf(block);
  if (!directions) return {};
  double longest_m = 0.0;
  for (const PairResult& pair : result.pairs) {
    longest_m = std::max(longest_m, pair.difference_enu_m.norm());
  }
  constexpr std::size_t kFewest = 4;  // of which a median is shown
  struct Values {
    std::vector<double> distance_m, along_m, across_m, up_m;
  };
  std::map<std::pair<int, int>, Values> classes;  // direction, then minus the power of two
  const double within = std::cos(20.0 * std::numbers::pi / 180.0);
  for (const PairResult& pair : result.pairs) {
    if (std::isnan(pair.covariance_m2[0])) continue;
    const Eigen::Matrix3d enu = block.frame.EnuFromFrame(result.points.position_m[pair.a]);
    const Eigen::Vector2d along = (enu * (*directions)[0]).head<2>().normalized();
    const Eigen::Vector2d across(-along.y(), along.x());
    const double distance_m = pair.difference_enu_m.norm();
    const Eigen::Vector2d level = pair.difference_enu_m.head<2>() / distance_m;
    const bool is_along = std::abs(level.dot(along)) > within;
    if (!is_along && !(std::abs(level.dot(across)) > within)) continue;
    const auto [along_m2, across_m2, up_m2] = AlongAcrossUp(pair.covariance_m2, along);
    const int power = static_cast<int>(std::lround(std::log2(longest_m / distance_m)));
    Values& values = classes[{is_along ? 0 : 1, -power}];
    values.distance_m.push_back(distance_m);
    values.along_m.push_back(std::sqrt(along_m2));
    values.across_m.push_back(std::sqrt(across_m2));
    values.up_m.push_back(std::sqrt(up_m2));
  }
  std::vector<DifferenceClass> out;
  for (const auto& [key, values] : classes) {
    if (values.up_m.size() < kFewest) continue;
    out.push_back({key.first == 0,
                   values.up_m.size(),
                   Median(values.distance_m),
                   Median(values.along_m),
                   Median(values.across_m),
                   Median(values.up_m)});
  }
  return out;
}

}  // namespace sarblock
