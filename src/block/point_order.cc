// SPDX-License-Identifier: Apache-2.0
#include "point_order.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/memory.h"
#include "core/threads.h"

namespace sarblock {
namespace {

/// Points of a window, whose passes are counted.
constexpr std::size_t kWindow = 1024;
/// What so many passes keep in memory for their looks fits into the cache of a core.
constexpr std::size_t kPassesInCache = 256;

/// Sum over the windows of an order (empty: the present one) of the passes that see a point of it.
std::size_t PassesOfWindows(const Block& block, const PointOrder& order) {
  const Looks& looks = block.looks;
  const std::size_t points = block.points.size();
  constexpr std::size_t kWindowsAtOnce = 64;
  constexpr std::size_t kAtOnce = kWindow * kWindowsAtOnce;
  std::vector<std::size_t> sums((points + kAtOnce - 1) / kAtOnce, 0);
  ParallelForChunks(points, kAtOnce, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> window_of(block.passes.size(), kNone);
    for (std::size_t place = begin; place < end; ++place) {
      const std::size_t point = order.empty() ? place : order[place];
      const auto window = static_cast<std::uint32_t>((place - begin) / kWindow);
      for (std::uint64_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
        if (std::exchange(window_of[looks.pass[i]], window) != window) ++sums[chunk];
      }
    }
  });
  std::size_t sum = 0;
  for (const std::size_t of_chunk : sums) sum += of_chunk;
  return sum;
}

/// Sorts an order by a key below `keys` and keeps that of equal ones.
template <typename Key>
PointOrder SortedBy(const PointOrder& order, std::size_t keys, const Key& key_of) {
  std::vector<std::uint32_t> next(keys + 1, 0);
  for (const std::uint32_t point : order) ++next[key_of(point) + 1];
  for (std::size_t key = 0; key < keys; ++key) next[key + 1] += next[key];
  PointOrder sorted(order.size());
  for (const std::uint32_t point : order) sorted[next[key_of(point)]++] = point;
  return sorted;
}

void Reorder(const PointOrder& order, Points* points) {
  IdTable ids;
  for (const std::uint32_t point : order) ids.Append(points->ids[point]);
  points->ids = std::move(ids);
  Gather(order, &points->role);
  Gather(order, &points->given_m);
  if (points->known.empty()) return;
  const PointOrder new_of_old = InverseOf(order);
  for (KnownPosition& known : points->known) known.point = new_of_old[known.point];
  std::sort(points->known.begin(),
            points->known.end(),
            [](const KnownPosition& a, const KnownPosition& b) { return a.point < b.point; });
}

}  // namespace

PointOrder SortedByPasses(const Block& block) {
  const std::size_t points = block.points.size(), passes = block.passes.size();
  const Looks& looks = block.looks;
  const auto seen_by = [&](std::uint32_t point, bool last) -> std::size_t {
    const std::uint64_t begin = looks.offsets[point], end = looks.offsets[point + 1];
    return begin == end ? passes : looks.pass[last ? end - 1 : begin];
  };
  PointOrder order(points);
  for (std::uint32_t point = 0; point < points; ++point) order[point] = point;
  for (const bool last : {true, false}) {
    const auto key = [&](std::uint32_t point) { return seen_by(point, last); };
    order = SortedBy(order, passes + 1, key);
  }
  return order;
}

PointOrder OrderByPasses(const Block& block) {
  const std::size_t windows = (block.points.size() + kWindow - 1) / kWindow;
  if (block.passes.size() <= kPassesInCache) return {};
  const std::size_t as_given = PassesOfWindows(block, {});
  if (as_given <= kPassesInCache * windows) return {};
  PointOrder order = SortedByPasses(block);
  if (2 * PassesOfWindows(block, order) > as_given) return {};
  return order;
}

PointOrder InverseOf(const PointOrder& order) {
  PointOrder inverse(order.size());
  for (std::uint32_t place = 0; place < order.size(); ++place) inverse[order[place]] = place;
  return inverse;
}

std::vector<std::uint64_t> ReorderedOffsets(const PointOrder& order,
                                            const std::vector<std::uint64_t>& offsets) {
  std::vector<std::uint64_t> reordered;
  reordered.reserve(offsets.size());
  reordered.push_back(0);
  for (const std::uint32_t point : order) {
    reordered.push_back(reordered.back() + offsets[point + 1] - offsets[point]);
  }
  return reordered;
}

void ReorderPoints(const PointOrder& order, Block* block) {
  Reorder(order, &block->points);
  Looks& looks = block->looks;
  const std::vector<std::uint64_t> before =
      std::exchange(looks.offsets, ReorderedOffsets(order, looks.offsets));
  Looks::ForColumns([&](const char*, auto column, auto...) {
    GatherRanges(order, before, looks.offsets, &(looks.*column));
  });
}

}  // namespace sarblock
