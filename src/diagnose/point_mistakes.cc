// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mistakes.h"
#include "sample.h"

namespace sarblock {
namespace {

enum class Part { kTime, kDoppler, kRange, kBoth };

const char* UnitOf(Part part) {
  return part == Part::kTime      ? "s"
         : part == Part::kDoppler ? "Hz"
         : part == Part::kRange   ? "m"
                                  : "";
}

/// One look: of a point in a pass.
struct LookName {
  std::string pass, point;
  [[nodiscard]] std::string Words() const { return "point " + point + " in pass " + pass; }
  template <typename Edit>
  void Apply(Block* block, const Edit& edit) const {
    const auto p = FindPass(*block, pass);
    const std::uint32_t j = block->points.ids.Find(point);
    if (!p || j == IdTable::kNone) return;
    for (std::size_t i = block->looks.offsets[j]; i < block->looks.offsets[j + 1]; ++i) {
      if (block->looks.pass[i] == *p) edit(i);
    }
  }
};

Hypothesis OneLook(const LookName& look, Part part, double value, double step) {
  Hypothesis out;
  out.kind = part == Part::kTime      ? MistakeKind::kTime
             : part == Part::kDoppler ? MistakeKind::kCone
             : part == Part::kRange   ? MistakeKind::kRange
                                      : MistakeKind::kIds;
  out.cause = part == Part::kTime      ? "time.one"
              : part == Part::kDoppler ? "cone.one"
              : part == Part::kRange   ? "range.one"
                                       : "ids.look";
  out.passes = {look.pass};
  out.points = {look.point};
  out.undo = [look, part](Block* block, double size) {
    look.Apply(block, [&](std::size_t i) {
      if (part == Part::kTime) block->looks.time_s[i] -= size;
      if (part == Part::kDoppler) block->looks.cone[i] -= size;
      if (part == Part::kRange) block->looks.range_m[i] -= size;
      if (part == Part::kBoth) block->looks.flags[i] |= Looks::kRejected;
    });
  };
  out.within_last = part != Part::kBoth;
  out.parameters = part == Part::kBoth ? 0 : 1;  // a look left out takes its equations with it
  out.free = part != Part::kBoth;
  out.value = value;
  out.step = step;
  out.unit = UnitOf(part);
  out.says = [look, part](const Size& size) {
    if (part == Part::kBoth) return "the look of " + look.Words() + " is of something else";
    const bool more = size.value > 0.0;
    const std::string text =
        look.Words() + " is " + SizeOf(std::abs(size.value), size.sigma, UnitOf(part)).text;
    if (part == Part::kTime) return "the time of " + text + (more ? " late" : " early");
    if (part == Part::kDoppler) return "the Doppler of " + text + (more ? " too high" : " too low");
    return "the range of " + text + (more ? " too long" : " too short");
  };
  out.change = [look](const Size&) {
    return "observations.csv: the right values in the row of " + look.Words() +
           ", or rejected = 1 there";
  };
  out.screened = true;
  out.local = true;
  return out;
}

Hypothesis OnePoint(const std::string& point, int looks) {
  Hypothesis out;
  out.kind = MistakeKind::kIds;
  out.cause = "ids.point";
  out.points = {point};
  out.undo = [point](Block* block, double) {
    const std::uint32_t j = block->points.ids.Find(point);
    if (j == IdTable::kNone) return;
    for (std::size_t i = block->looks.offsets[j]; i < block->looks.offsets[j + 1]; ++i) {
      block->looks.flags[i] |= Looks::kRejected;
    }
  };
  out.parameters = 0;
  out.says = [point, looks](const Size&) {
    return "the " + std::to_string(looks) + " looks of point " + point +
           " contradict each other and cannot tell which is wrong";
  };
  out.change = [point](const Size&) {
    return "observations.csv: the right values in the rows of " + point +
           ", or rejected = 1 in them";
  };
  out.screened = true;
  out.local = true;
  return out;
}

/// How late or too high its Doppler and how much too long a look is against the position of the
/// point: the known one, or where its other looks meet on the given paths.
struct LookErrors {
  double late_s = 0.0, higher_hz = 0.0, longer_m = 0.0;
};

LookErrors ErrorsOf(const Block& block, std::uint32_t point, std::size_t look) {
  LookErrors out;
  Eigen::Vector3d p_m = block.points.given_m[point];
  if (block.points.FindKnown(point) == nullptr) {
    Block others = PartOf(block, {point});
    const std::size_t place = look - block.looks.offsets[point];
    others.looks.flags[place] |= Looks::kRejected;
    others.points.given_m[0].setConstant(kNotGiven);
    const Fit fit = SolveSample(others, {}, {.effort = Effort::kQuick}, nullptr);
    if (!fit.solved) return out;
    p_m = fit.state.Position(0);
  }
  const PredictedLook predicted = PredictLook(block, look, p_m);
  if (block.MeasuresDoppler(look)) {
    const Pass& pass = block.passes[block.looks.pass[look]];
    const auto motion = pass.path.At(predicted.time_s);
    if (!motion) return out;
    const Eigen::Vector3d los_m = p_m - motion->position_m;
    const double distance_m = los_m.norm();
    out.higher_hz = block.looks.cone[look] -
                    2.0 * motion->velocity_mps.dot(los_m) / (pass.wavelength_m * distance_m);
    out.longer_m = predicted.range_m - distance_m;
    return out;
  }
  if (std::isnan(predicted.true_time_s)) return out;
  out.late_s = predicted.time_s - predicted.true_time_s;
  out.longer_m = predicted.range_m - predicted.true_range_m;
  return out;
}

/// Points whose residuals are the largest, after the suspects.
std::vector<std::uint32_t> DoubtfulPoints(const Facts& facts, std::size_t most) {
  const Block& block = facts.sample.block;
  std::vector<std::uint32_t> out = facts.sample.suspects;
  std::vector<std::pair<double, std::uint32_t>> sums;
  for (std::uint32_t j = 0; j < block.points.size(); ++j) {
    double sum = 0.0;
    for (std::size_t i = block.looks.offsets[j]; i < block.looks.offsets[j + 1]; ++i) {
      const double square =
          facts.residuals.whitened_errors.row(static_cast<Eigen::Index>(i)).squaredNorm();
      if (std::isfinite(square)) sum += square;
    }
    sums.emplace_back(-sum, j);
  }
  std::sort(sums.begin(), sums.end());
  if (out.size() > most) out.resize(most);
  // To explain the block a point must have a part of v'Pv by itself.
  constexpr double kMinShare = 0.1;
  for (std::size_t k = 0; k < std::min<std::size_t>(2, sums.size()); ++k) {
    if (-sums[k].first < kMinShare * facts.before.square_sum) break;
    if (std::find(out.begin(), out.end(), sums[k].second) == out.end()) {
      out.push_back(sums[k].second);
    }
  }
  return out;
}

}  // namespace

void AddLookMistakes(const Facts& facts, Hypotheses* out) {
  constexpr std::size_t kMaxPoints = 4;
  const Block& block = facts.sample.block;
  const std::vector<std::uint32_t> doubtful = DoubtfulPoints(facts, kMaxPoints);
  if (doubtful.empty() || !facts.may_explain(doubtful)) return;
  for (const std::uint32_t j : doubtful) {
    const std::string point(block.points.ids[j]);
    std::vector<std::size_t> looks;
    for (std::size_t i = block.looks.offsets[j]; i < block.looks.offsets[j + 1]; ++i) {
      if (!block.looks.rejected(i)) looks.push_back(i);
    }
    if (!facts.may_explain({j})) continue;
    const bool known = block.points.FindKnown(j) != nullptr;
    if (!known && looks.size() < 3) {
      if (looks.size() == 2) out->push_back(OnePoint(point, 2));
      continue;
    }
    // Those first without which the others meet best.
    Block part = PartOf(block, {j});
    const auto rest_m = [&](std::size_t i) {
      std::uint8_t& flags = part.looks.flags[i - block.looks.offsets[j]];
      flags |= Looks::kRejected;
      const double off_m = ContradictionOf(part, 0);
      flags &= static_cast<std::uint8_t>(~Looks::kRejected);
      return std::isnan(off_m) ? std::numeric_limits<double>::infinity() : off_m;
    };
    std::vector<std::pair<double, std::size_t>> order;
    for (const std::size_t i : looks) order.emplace_back(rest_m(i), i);
    std::sort(order.begin(), order.end());
    for (const auto& [off_m, i] : order) {
      const std::uint32_t p = block.looks.pass[i];
      const LookName name{block.passes[p].id, point};
      const LookErrors errors = ErrorsOf(block, j, i);
      const LookSigma sigma = block.SigmaOf(i);
      out->push_back(OneLook(name, Part::kBoth, 0.0, 0.0));
      if (block.MeasuresDoppler(i)) {
        out->push_back(OneLook(name, Part::kDoppler, errors.higher_hz, sigma.azimuth));
      } else {
        const double speed_mps = facts.passes[p].speed_mps;
        const double sigma_s = block.ApproximateAzimuthSigma_m(i, speed_mps) / speed_mps;
        out->push_back(OneLook(name, Part::kTime, errors.late_s, sigma_s));
      }
      out->push_back(OneLook(name, Part::kRange, errors.longer_m, sigma.range_m));
    }
  }
}

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
  out.change = [passes, a, b](const Size&) {
    const std::string text =
        "observations.csv: exchange the names " + a + " and " + b + " in the rows of " + passes[0];
    if (passes.size() == 1) return text;
    return text + " or in those of " + passes[1] +
           ", which the looks do not tell: else rejected = 1 in the rows of " + a + " and " + b;
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

Hypothesis Shifted(const std::string& pass,
                   std::shared_ptr<const RowsOfPoint> rows,
                   bool before,
                   bool by_time) {
  Hypothesis out;
  out.kind = MistakeKind::kIds;
  out.cause = "ids.shifted";
  out.parameters = 0;
  out.of_sample = true;
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
  out.change = [pass, before, by_time](const Size&) {
    return "observations.csv: each row of " + pass + " takes what the row " +
           (before ? "before" : "after") + " it measured, in the order of their " +
           (by_time ? "times" : "points") + ", and the " + (before ? "first" : "last") +
           " one what the " + (before ? "last" : "first") + " one did";
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
      const bool by_time = neighbour == Sample::kTimeBefore || neighbour == Sample::kTimeAfter;
      out->push_back(Shifted(block.passes[p].id, std::move(rows), before, by_time));
      out->back().screened = facts.passes[p].predictions.empty();
    }
  }
}

namespace {

/// Differences of a pair of passes at the points that both see.
struct Differences {
  std::vector<double> measured_m, predicted_m;
  double sigma_m = 0.0;  ///< of a measured one
};

double Rms(const std::vector<double>& values, double from) {
  double sum = 0.0;
  for (const double value : values) sum += (value - from) * (value - from);
  return std::sqrt(sum / static_cast<double>(values.size()));
}

}  // namespace

std::optional<Explanation> FindCoregistered(const Facts& facts) {
  constexpr std::size_t kFewest = 8;
  constexpr double kAlike = 10.0;     // standard deviations of a difference
  constexpr double kAskedFor = 20.0;  // times what is measured
  const Block& block = facts.sample.block;
  if (!facts.before.solved) return std::nullopt;
  std::map<std::pair<std::uint32_t, std::uint32_t>, Differences> pairs;
  for (std::uint32_t point = 0; point < block.points.size(); ++point) {
    const Eigen::Vector3d& p_m = facts.before.state.Position(point);
    if (!p_m.allFinite()) continue;
    const std::size_t end = block.looks.offsets[point + 1];
    for (std::size_t i = block.looks.offsets[point]; i < end; ++i) {
      for (std::size_t j = i + 1; j < end; ++j) {
        const std::uint32_t a = block.looks.pass[i], b = block.looks.pass[j];
        const auto at_a = block.passes[a].path.At(block.looks.time_s[i]);
        const auto at_b = block.passes[b].path.At(block.looks.time_s[j]);
        if (a == b || !at_a || !at_b) continue;
        const double sign = a < b ? 1.0 : -1.0;
        Differences& of = pairs[std::minmax(a, b)];
        of.measured_m.push_back(sign * (block.looks.range_m[i] - block.looks.range_m[j]));
        of.predicted_m.push_back(
            sign * ((p_m - at_a->position_m).norm() - (p_m - at_b->position_m).norm()));
        of.sigma_m = std::hypot(block.SigmaOf(i).range_m, block.SigmaOf(j).range_m);
      }
    }
  }
  for (const auto& [pair, of] : pairs) {
    const std::size_t n = of.measured_m.size();
    if (n < kFewest) continue;
    // A crop of the image makes the ranges differ by a constant.
    const double middle_m = Median(of.measured_m), predicted_m = Median(of.predicted_m);
    double alike_m = Rms(of.measured_m, 0.0), asked_m = Rms(of.predicted_m, 0.0);
    if (!(alike_m < kAlike * of.sigma_m)) {
      alike_m = Rms(of.measured_m, middle_m);
      asked_m = Rms(of.predicted_m, predicted_m);
    }
    if (!(alike_m < kAlike * of.sigma_m) || !(asked_m > kAskedFor * alike_m)) continue;
    const std::vector<std::string> passes{block.passes[pair.first].id,
                                          block.passes[pair.second].id};
    Explanation out;
    out.kind = MistakeKind::kRange;
    out.cause = "range.coregistered";
    out.passes = passes;
    out.square_sum_before = out.square_sum_after = facts.before.SquareSum();
    out.redundancy_before = out.redundancy_after = facts.before.redundancy;
    out.looks_lost_before = out.looks_lost_after = facts.before.lost;
    out.change =
        "observations.csv: times and ranges of each in the image as it was taken, before it was "
        "resampled to the other, or the looks of one of them alone";
    out.sentence = "the ranges of " + passes[0] + " are those of " + passes[1] + " within " +
                   Short(alike_m) + " m at " + std::to_string(n) +
                   " points, where their paths ask for differences of " + Short(asked_m) +
                   " m: rows and columns of an image that was coregistered to the other; " +
                   out.change;
    return out;
  }
  return std::nullopt;
}

}  // namespace sarblock
