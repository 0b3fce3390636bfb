// SPDX-License-Identifier: Apache-2.0
#include "look_mistakes.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "edits.h"
#include "words.h"

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
    return "observations.csv: the row of " + look.Words() + ", or rejected = 1 there";
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
    return "observations.csv: the rows of " + point + ", or rejected = 1 in them";
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
  const Sighting sighting = SightingAt(block, look, p_m);
  if (block.MeasuresDoppler(look)) {
    const Pass& pass = block.passes[block.looks.pass[look]];
    const auto motion = pass.path.At(sighting.time_s);
    if (!motion) return out;
    const Eigen::Vector3d sight_m = p_m - motion->position_m;
    const double distance_m = sight_m.norm();
    out.higher_hz = block.looks.cone[look] -
                    2.0 * motion->velocity_mps.dot(sight_m) / (pass.wavelength_m * distance_m);
    out.longer_m = sighting.range_m - distance_m;
    return out;
  }
  if (std::isnan(sighting.true_time_s)) return out;
  out.late_s = sighting.time_s - sighting.true_time_s;
  out.longer_m = sighting.range_m - sighting.true_range_m;
  return out;
}

/// Points whose residuals are the largest, after the suspects.
std::vector<std::uint32_t> DoubtfulPoints(const Facts& facts, std::size_t most) {
  const Block& block = facts.sample.block;
  std::vector<std::uint32_t> out = facts.sample.suspects;
  std::vector<std::pair<double, std::uint32_t>> sums;
  for (std::uint32_t j = 0; j < block.points.size(); ++j) {
    double sum_1 = 0.0;
    for (std::size_t i = block.looks.offsets[j]; i < block.looks.offsets[j + 1]; ++i) {
      const double square_1 =
          facts.residuals.whitened_1.row(static_cast<Eigen::Index>(i)).squaredNorm();
      if (std::isfinite(square_1)) sum_1 += square_1;
    }
    sums.emplace_back(-sum_1, j);
  }
  std::sort(sums.begin(), sums.end());
  if (out.size() > most) out.resize(most);
  // To explain the block a point must have a part of v'Pv by itself.
  constexpr double kLeastShare_1 = 0.1;
  for (std::size_t k = 0; k < std::min<std::size_t>(2, sums.size()); ++k) {
    if (-sums[k].first < kLeastShare_1 * facts.before.square_sum_1) break;
    if (std::find(out.begin(), out.end(), sums[k].second) == out.end()) {
      out.push_back(sums[k].second);
    }
  }
  return out;
}

}  // namespace

void AddLookMistakes(const Facts& facts, Hypotheses* out) {
  constexpr std::size_t kMostPoints = 4;
  const Block& block = facts.sample.block;
  const std::vector<std::uint32_t> doubtful = DoubtfulPoints(facts, kMostPoints);
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
    for (const std::size_t i : looks) {
      const std::uint32_t p = block.looks.pass[i];
      const LookName name{block.passes[p].id, point};
      const LookErrors errors = ErrorsOf(block, j, i);
      const LookSigma sigma = block.SigmaOf(i);
      out->push_back(OneLook(name, Part::kBoth, 0.0, 0.0));
      if (block.MeasuresDoppler(i)) {
        out->push_back(OneLook(name, Part::kDoppler, errors.higher_hz, sigma.azimuth));
      } else {
        const double speed_mps = facts.passes[p].speed_mps;
        const double sigma_s = block.RoughAzimuthSigma_m(i, speed_mps) / speed_mps;
        out->push_back(OneLook(name, Part::kTime, errors.late_s, sigma_s));
      }
      out->push_back(OneLook(name, Part::kRange, errors.longer_m, sigma.range_m));
    }
  }
}

}  // namespace sarblock
