// SPDX-License-Identifier: Apache-2.0
#include "copies.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "core/threads.h"

namespace sarblock {
namespace {

/// Equal looks that no chance makes.
constexpr std::size_t kLeastEqual = 3, kLeastEqualOfPoint = 2;

using PassPair = std::pair<std::uint32_t, std::uint32_t>;

/// `sigma` are the standard deviations of look i.
bool AreRangesEqual(const Looks& looks, const LookSigma& sigma, std::size_t i, std::size_t j) {
  return std::abs(looks.range_m[i] - looks.range_m[j]) <= kEqual_1 * sigma.range_m;
}

bool AreAzimuthsEqual(const Block& block, const LookSigma& sigma, std::size_t i, std::size_t j) {
  const Looks& looks = block.looks;
  const double speed_mps = block.passes[looks.pass[i]].path.states().front().velocity_mps.norm();
  const double sigma_s = sigma.azimuth_unit == AzimuthUnit::kSeconds
                             ? sigma.azimuth
                             : block.RoughAzimuthSigma_m(i, speed_mps) / speed_mps;
  if (block.MeasuresDoppler(i) &&
      !(std::abs(looks.cone[i] - looks.cone[j]) <= kEqual_1 * sigma.azimuth)) {
    return false;
  }
  return std::abs(looks.time_s[i] - looks.time_s[j]) <= kEqual_1 * sigma_s;
}

std::string NamesOfPairs(const Block& block,
                         const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs) {
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(5, pairs.size()); ++i) {
    text += (i == 0 ? "" : ", ") + std::string(block.points.ids[pairs[i].first]) + " and " +
            std::string(block.points.ids[pairs[i].second]);
  }
  if (pairs.size() > 5) text += " and " + std::to_string(pairs.size() - 5) + " more";
  return text;
}

/// Looks of the later pass that are those of the earlier one.
using EqualLooks = std::map<PassPair, std::vector<std::size_t>>;

/// Those of the points from `begin` to `end`. `sigma_of_pass` serves blocks whose looks have none
/// of their own.
EqualLooks FindEqualLooks(const Block& block,
                          const std::vector<LookSigma>& sigma_of_pass,
                          std::size_t begin,
                          std::size_t end) {
  const Looks& looks = block.looks;
  const bool own = !looks.range_sigma_m.empty() || !looks.azimuth_sigma.empty();
  EqualLooks equal;
  for (std::size_t point = begin; point < end; ++point) {
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      const std::uint32_t pass = looks.pass[i];
      const LookSigma sigma = own ? block.SigmaOf(i) : sigma_of_pass[pass];
      for (std::size_t j = i + 1; j < looks.offsets[point + 1]; ++j) {
        if (looks.pass[j] == pass || !AreRangesEqual(looks, sigma, i, j) ||
            !AreAzimuthsEqual(block, sigma, i, j)) {
          continue;
        }
        equal[std::minmax(pass, looks.pass[j])].push_back(pass < looks.pass[j] ? j : i);
      }
    }
  }
  return equal;
}

void FindPasses(const Block& block, Copies* copies) {
  constexpr std::size_t kPointsAtOnce = 65536;
  std::vector<LookSigma> sigma_of_pass;
  for (const Pass& pass : block.passes) sigma_of_pass.push_back(pass.sigma);
  const std::size_t points = block.points.size();
  std::vector<EqualLooks> pieces((points + kPointsAtOnce - 1) / kPointsAtOnce);
  ParallelForChunks(
      points, kPointsAtOnce, [&](std::size_t piece, std::size_t begin, std::size_t end) {
        pieces[piece] = FindEqualLooks(block, sigma_of_pass, begin, end);
      });
  EqualLooks equal;
  for (const EqualLooks& piece : pieces) {
    for (const auto& [pair, copied] : piece) {
      equal[pair].insert(equal[pair].end(), copied.begin(), copied.end());
    }
  }
  if (equal.empty()) return;
  std::vector<std::size_t> of_pass(block.passes.size(), 0);
  for (const std::uint32_t pass : block.looks.pass) ++of_pass[pass];
  for (const auto& [pair, copied] : equal) {
    const auto& [a, b] = pair;
    if (copied.size() < kLeastEqual || 2 * copied.size() < std::min(of_pass[a], of_pass[b])) {
      continue;
    }
    if (std::find(copies->passes.begin(), copies->passes.end(), b) != copies->passes.end()) {
      continue;  // of three copies the second and the third are named
    }
    copies->passes.push_back(b);
    copies->looks.insert(copies->looks.end(), copied.begin(), copied.end());
    copies->remarks.push_back("pass " + block.passes[b].id + ": " + std::to_string(copied.size()) +
                              " of its " + std::to_string(of_pass[b]) +
                              " looks equal those of pass " + block.passes[a].id +
                              ": one is a copy; these looks count once, remove one of the passes");
  }
}

void FindPoints(const Block& block, Copies* copies) {
  const Looks& looks = block.looks;
  std::vector<std::uint32_t> point_of(looks.size());
  for (std::uint32_t point = 0; point < block.points.size(); ++point) {
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      point_of[i] = point;
    }
  }
  std::vector<std::size_t> order(looks.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::erase_if(order, [&](std::size_t i) {
    return looks.rejected(i) || std::isnan(looks.time_s[i]) || std::isnan(looks.range_m[i]);
  });
  // Exact times may be one time: ranges and Dopplers then bring copies together.
  const auto key = [&](std::size_t i) {
    const double cone = looks.cone.empty() ? 0.0 : looks.cone[i];
    return std::tuple(looks.pass[i], looks.time_s[i], looks.range_m[i], cone, i);
  };
  std::sort(
      order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> equal;
  for (std::size_t k = 1; k < order.size(); ++k) {
    const std::size_t i = order[k - 1], j = order[k];
    if (looks.pass[i] != looks.pass[j] || point_of[i] == point_of[j]) continue;
    const LookSigma sigma = block.SigmaOf(i);
    if (!AreRangesEqual(looks, sigma, i, j) || !AreAzimuthsEqual(block, sigma, i, j)) continue;
    ++equal[std::minmax(point_of[i], point_of[j])];
  }
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (const auto& [pair, count] : equal) {
    const auto looks_of = [&](std::uint32_t p) { return looks.offsets[p + 1] - looks.offsets[p]; };
    const std::size_t fewer = std::min(looks_of(pair.first), looks_of(pair.second));
    if (count < kLeastEqualOfPoint || count < fewer) continue;
    pairs.push_back(pair);
    copies->points.push_back(pair.second);
  }
  if (pairs.empty()) return;
  copies->remarks.push_back("the same point under two ids, with equal looks: " +
                            NamesOfPairs(block, pairs) + "; its measurements count twice");
}

}  // namespace

Copies FindCopiedPasses(const Block& block) {
  Copies copies;
  FindPasses(block, &copies);
  return copies;
}

Copies FindCopies(const Block& block) {
  Copies copies = FindCopiedPasses(block);
  FindPoints(block, &copies);
  return copies;
}

void CountOnce(const Copies& copies, Block* block) {
  Looks& looks = block->looks;
  for (const std::size_t look : copies.looks) looks.flags[look] |= Looks::kRejected;
  for (const std::uint32_t point : copies.points) {
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      looks.flags[i] |= Looks::kRejected;
    }
  }
}

}  // namespace sarblock
