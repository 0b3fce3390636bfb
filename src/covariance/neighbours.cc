// SPDX-License-Identifier: Apache-2.0
#include "neighbours.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <iterator>

#include <boost/geometry.hpp>
#include <boost/geometry/index/rtree.hpp>

namespace sarblock {

PointPairs NeighbourPairs(const AdjustmentProblem& problem, const BlockState& state) {
  namespace bg = boost::geometry;
  using Place = bg::model::point<double, 3, bg::cs::cartesian>;
  using Entry = std::pair<Place, std::uint32_t>;
  std::vector<Entry> entries;
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (!problem.Solves(point)) continue;
    const Eigen::Vector3d p_m = state.Position(point);
    entries.emplace_back(Place(p_m.x(), p_m.y(), p_m.z()), static_cast<std::uint32_t>(point));
  }
  const bg::index::rtree<Entry, bg::index::quadratic<16>> tree(entries);
  PointPairs pairs;
  std::vector<Entry> nearest;
  for (const Entry& entry : entries) {
    nearest.clear();
    tree.query(bg::index::nearest(entry.first, 2), std::back_inserter(nearest));
    for (const Entry& other : nearest) {
      if (other.second == entry.second) continue;
      pairs.emplace_back(std::min(entry.second, other.second),
                         std::max(entry.second, other.second));
    }
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
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

}  // namespace sarblock
