// SPDX-License-Identifier: Apache-2.0
#include "point_consensus.h"

#include "sarblock/core/statistics.h"
#include "sarblock/geometry/intersection.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <utility>

namespace sarblock {
namespace {

constexpr double kMeet_1 = 0.999;
/// Pairs that are tried, those of looks far apart in the order of passes first.
constexpr std::size_t kMostPairs = 36;

bool Meets(const Frame& frame,
           const std::vector<Sight>& sights,
           double variance_1,
           Intersection* met) {
  *met = Intersect(sights, frame);
  if (met->outcome != IntersectionOutcome::kDetermined &&
      met->outcome != IntersectionOutcome::kCirclesDoNotMeet) {
    return false;
  }
  const double freedom_1 = 2.0 * static_cast<double>(sights.size()) - 3.0;
  return met->weighted_square_sum <= variance_1 * ChiSquareQuantile(kMeet_1, freedom_1) &&
         std::all_of(sights.begin(), sights.end(), [&](const Sight& sight) {
           return LiesWhereItLooks(frame, sight, met->position_m);
         });
}

/// All pairs of `count` looks, those farthest apart first.
std::vector<std::pair<std::size_t, std::size_t>> PairsOf(std::size_t count) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t apart = count - 1; apart > 0; --apart) {
    for (std::size_t i = 0; i + apart < count && pairs.size() < kMostPairs; ++i) {
      pairs.emplace_back(i, i + apart);
    }
  }
  return pairs;
}

}  // namespace

PointConsensus FindPointConsensus(const AdjustmentProblem& problem,
                                  const BlockState& state,
                                  std::size_t point,
                                  double variance_1) {
  const Block& block = problem.block;
  PointConsensus out;
  std::vector<Sight> sights;
  for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
    if (block.looks.rejected(i)) continue;
    if (const auto sight = problem.model.SightOf(i, state.corrections)) {
      sights.push_back(*sight);
      out.looks.push_back(i);
    }
  }
  if (sights.size() < 2) return out;
  Intersection met;
  if (Meets(block.frame, sights, variance_1, &met)) {
    out.outcome = PointConsensus::Outcome::kAgree;
    out.position_m = met.position_m;
    out.weighted_square_sum = met.weighted_square_sum;
    return out;
  }
  out.position_m = met.position_m;
  out.weighted_square_sum = met.weighted_square_sum;
  out.outcome = met.outcome == IntersectionOutcome::kCirclesCoincide ||
                        met.outcome == IntersectionOutcome::kCirclesTouch ||
                        met.outcome == IntersectionOutcome::kAmbiguous
                    ? PointConsensus::Outcome::kOpen
                    : PointConsensus::Outcome::kContradict;
  if (sights.size() == 2) return out;

  std::vector<std::size_t> best;
  Intersection best_met;
  bool alone = true;
  for (const auto& [a, b] : PairsOf(sights.size())) {
    std::vector<Sight> set = {sights[a], sights[b]};
    Intersection at;
    if (!Meets(block.frame, set, variance_1, &at)) continue;
    std::vector<std::size_t> members = {a, b};
    for (std::size_t k = 0; k < sights.size(); ++k) {
      if (k == a || k == b) continue;
      set.push_back(sights[k]);
      Intersection with;
      if (Meets(block.frame, set, variance_1, &with)) {
        members.push_back(k);
        at = with;
      } else {
        set.pop_back();
      }
    }
    std::sort(members.begin(), members.end());
    if (members.size() < best.size() || members == best) continue;
    alone = members.size() > best.size();
    if (!alone) continue;
    best = members;
    best_met = at;
  }
  if (best.empty() || !alone) return out;
  std::vector<std::size_t> kept;
  for (const std::size_t k : best) kept.push_back(out.looks[k]);
  out.outcome = PointConsensus::Outcome::kMajority;
  out.looks = std::move(kept);
  out.position_m = best_met.position_m;
  out.weighted_square_sum = best_met.weighted_square_sum;
  return out;
}

}  // namespace sarblock
