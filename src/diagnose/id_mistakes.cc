// SPDX-License-Identifier: Apache-2.0
#include "id_mistakes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "edits.h"

namespace sarblock {
namespace {

/// Exchanges what two looks of one pass measured.
void ExchangeValues(std::size_t i, std::size_t j, Looks* looks) {
  std::swap(looks->time_s[i], looks->time_s[j]);
  std::swap(looks->range_m[i], looks->range_m[j]);
  if (!looks->cone.empty()) std::swap(looks->cone[i], looks->cone[j]);
}

/// Looks of a point in a pass.
std::vector<std::size_t> LooksOf(const Block& block, std::uint32_t point, std::uint32_t pass) {
  std::vector<std::size_t> out;
  for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
    if (block.looks.pass[i] == pass && !block.looks.rejected(i)) out.push_back(i);
  }
  return out;
}

/// In the first of `passes`; of two, the same as in the other.
Hypothesis ExchangedIn(const std::vector<std::string>& passes,
                       const std::string& a,
                       const std::string& b) {
  const std::string& pass = passes[0];
  Hypothesis out;
  out.kind = MistakeKind::kIds;
  out.cause = "ids.exchanged";
  out.passes = passes;
  out.points = {a, b};
  out.parameters = 0;
  out.undo = [pass, a, b](Block* block, double) {
    const auto p = FindPass(*block, pass);
    const std::uint32_t i = block->points.ids.Find(a), j = block->points.ids.Find(b);
    if (!p || i == IdTable::kNone || j == IdTable::kNone) return;
    const std::vector<std::size_t> of_a = LooksOf(*block, i, *p), of_b = LooksOf(*block, j, *p);
    if (of_a.size() == 1 && of_b.size() == 1) ExchangeValues(of_a[0], of_b[0], &block->looks);
  };
  const std::string where = passes.size() == 1 ? pass : passes[0] + " or in pass " + passes[1];
  out.says = [where, a, b](const Size&) {
    return "points " + a + " and " + b + " are exchanged in pass " + where;
  };
  out.change = [pass, a, b](const Size&) {
    return "observations.csv: exchange the names " + a + " and " + b + " in the rows of " + pass;
  };
  out.screened = true;
  return out;
}

/// The larger contradiction of two points.
double WorstOf(const Block& part, std::uint32_t a, std::uint32_t b) {
  double worst_m = 0.0;
  for (const std::uint32_t point : {a, b}) {
    const double off_m = ContradictionOf(part, point);
    if (!std::isnan(off_m)) worst_m = std::max(worst_m, off_m);
  }
  return worst_m;
}

using RowsOfPoint = std::map<std::string, RowValues, std::less<>>;

Hypothesis Shifted(const std::string& pass, std::shared_ptr<const RowsOfPoint> rows, bool before) {
  Hypothesis out;
  out.kind = MistakeKind::kIds;
  out.cause = "ids.shifted";
  out.parameters = 0;
  out.passes = {pass};
  out.undo = [pass, rows](Block* block, double) {
    const auto p = FindPass(*block, pass);
    if (!p) return;
    Looks& looks = block->looks;
    for (std::uint32_t point = 0; point < block->points.size(); ++point) {
      const auto found = rows->find(block->points.ids[point]);
      if (found == rows->end()) continue;
      for (const std::size_t i : LooksOf(*block, point, *p)) {
        looks.time_s[i] = found->second.time_s;
        looks.range_m[i] = found->second.range_m;
        if (!looks.cone.empty()) looks.cone[i] = found->second.cone;
      }
    }
  };
  const std::string direction = before ? "down" : "up";
  out.says = [pass, direction](const Size&) {
    return "the point ids of pass " + pass + " are shifted " + direction +
           " by one row against its measurements";
  };
  out.change = [pass, direction](const Size&) {
    return "observations.csv: point in the rows of " + pass + ", one row " +
           (direction == "down" ? "up" : "down");
  };
  return out;
}

}  // namespace

void AddExchangedPoints(const Facts& facts, Hypotheses* out) {
  const Block& block = facts.sample.block;
  const std::vector<std::uint32_t>& suspects = facts.sample.suspects;
  std::vector<std::uint32_t> points = suspects;
  std::sort(points.begin(), points.end());
  if (points.size() < 2 || !facts.may_explain(points)) return;
  Block part = PartOf(block, points);
  const auto place = [&](std::uint32_t point) {
    const auto found = std::lower_bound(points.begin(), points.end(), point);
    return static_cast<std::uint32_t>(found - points.begin());
  };
  for (std::size_t i = 0; i < suspects.size(); ++i) {
    for (std::size_t j = i + 1; j < suspects.size(); ++j) {
      const auto [low, high] = std::minmax({place(suspects[i]), place(suspects[j])});
      const double before_m = WorstOf(part, low, high);
      std::vector<std::uint32_t> common;
      for (std::uint32_t p = 0; p < block.passes.size(); ++p) {
        if (LooksOf(part, low, p).size() == 1 && LooksOf(part, high, p).size() == 1) {
          common.push_back(p);
        }
      }
      // Two looks each and no known position: exchanged in one pass or in the other is the same.
      const auto is_tie_of_two = [&](std::uint32_t k) {
        return part.looks.offsets[k + 1] - part.looks.offsets[k] == 2 &&
               part.points.FindKnown(k) == nullptr;
      };
      const bool either = common.size() == 2 && is_tie_of_two(low) && is_tie_of_two(high);
      for (const std::uint32_t p : common) {
        if (either && p != common[0]) break;
        const std::size_t of_low = LooksOf(part, low, p)[0], of_high = LooksOf(part, high, p)[0];
        ExchangeValues(of_low, of_high, &part.looks);
        const double after_m = WorstOf(part, low, high);
        ExchangeValues(of_low, of_high, &part.looks);
        if (!(after_m < 0.3 * before_m)) continue;
        if (!facts.may_explain({points[low], points[high]})) continue;
        std::vector<std::string> passes{block.passes[p].id};
        if (either) passes.push_back(block.passes[common[1]].id);
        out->push_back(ExchangedIn(
            passes, std::string(part.points.ids[low]), std::string(part.points.ids[high])));
      }
    }
  }
}

void AddShiftedIds(const Facts& facts, Hypotheses* out) {
  const Block& block = facts.sample.block;
  for (std::uint32_t p = 0; p < block.passes.size(); ++p) {
    for (std::size_t neighbour = 0; neighbour < 4; ++neighbour) {
      auto rows = std::make_shared<RowsOfPoint>();
      for (std::uint32_t point = 0; point < block.points.size(); ++point) {
        for (const std::size_t i : LooksOf(block, point, p)) {
          (*rows)[std::string(block.points.ids[point])] = facts.sample.neighbours[i][neighbour];
        }
      }
      const bool before = neighbour == Sample::kPointBefore || neighbour == Sample::kTimeBefore;
      out->push_back(Shifted(block.passes[p].id, std::move(rows), before));
      out->back().screened = facts.passes[p].sightings.empty();
    }
  }
}

}  // namespace sarblock
