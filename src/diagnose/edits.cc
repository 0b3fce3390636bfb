// SPDX-License-Identifier: Apache-2.0
#include "edits.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "block/read_recorded.h"

namespace sarblock {

std::optional<std::uint32_t> FindPass(const Block& block, const std::string& id) {
  for (std::uint32_t i = 0; i < block.passes.size(); ++i) {
    if (block.passes[i].id == id) return i;
  }
  return std::nullopt;
}

std::vector<std::uint32_t> PassesOf(const Block& block, const std::vector<std::string>& ids) {
  std::vector<std::uint32_t> out;
  for (std::uint32_t i = 0; i < block.passes.size(); ++i) {
    const bool named = std::find(ids.begin(), ids.end(), block.passes[i].id) != ids.end();
    if (ids.empty() || named) out.push_back(i);
  }
  return out;
}

void ForLooks(const Block& block,
              const std::vector<std::string>& passes,
              const std::function<void(std::size_t look)>& edit) {
  std::vector<std::uint8_t> named(block.passes.size(), 0);
  for (const std::uint32_t pass : PassesOf(block, passes)) named[pass] = 1;
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    if (named[block.looks.pass[i]] != 0) edit(i);
  }
}

namespace {

/// Changes passes; where no path can be made of what becomes of them they stay as they were.
template <typename Change>
void TryOnPasses(Block* block, const Change& change) {
  std::vector<Pass> before = block->passes;
  try {
    change();
  } catch (const InputError&) {
    block->passes = std::move(before);
  }
}

}  // namespace

void EditStates(const std::function<void(StateVector*)>& edit, std::size_t pass, Block* block) {
  TryOnPasses(block, [&] {
    Pass& edited = block->passes[pass];
    std::vector<StateVector> states = edited.RecordedStates();
    for (StateVector& state : states) edit(&state);
    if (edited.recorded.asked.through == PathThrough::kStates) {
      edited.path = FlightPath(std::move(states));
      edited.recorded.states.clear();
      return;
    }
    edited.path = FlightPath(states);
    edited.recorded.states = std::move(states);
    ReadRecordedFlights({static_cast<std::uint32_t>(pass)}, block);
  });
}

void ReadAsAutoDecides(const std::vector<std::string>& passes, Block* block) {
  TryOnPasses(block, [&] {
    const std::vector<std::uint32_t> asked = PassesOf(*block, passes);
    for (const std::uint32_t p : asked) {
      Pass& pass = block->passes[p];
      if (pass.recorded.states.empty()) pass.recorded.states = pass.path.states();
      pass.recorded.asked.through = PathThrough::kAuto;
    }
    ReadRecordedFlights(asked, block);
  });
}

void FitStrips(Block* block) {
  struct Span {
    double first_s = 0.0, last_s = 0.0;
    bool seen = false;
  };
  std::vector<Span> spans(block->passes.size());
  for (std::size_t i = 0; i < block->looks.size(); ++i) {
    const double time_s = block->looks.time_s[i];
    if (block->looks.rejected(i) || !std::isfinite(time_s)) continue;
    Span& span = spans[block->looks.pass[i]];
    span.first_s = span.seen ? std::min(span.first_s, time_s) : time_s;
    span.last_s = span.seen ? std::max(span.last_s, time_s) : time_s;
    span.seen = true;
  }
  for (std::size_t p = 0; p < spans.size(); ++p) {
    Pass& pass = block->passes[p];
    const Span& span = spans[p];
    const double slack_s = 0.25 * (pass.end_s - pass.start_s);
    const bool inside =
        span.first_s >= pass.start_s - slack_s && span.last_s <= pass.end_s + slack_s;
    if (!span.seen || inside || !(span.last_s > span.first_s)) continue;
    pass.start_s = span.first_s;
    pass.end_s = span.last_s;
  }
}

namespace {

/// Points with those of their looks that `take` takes; passes and the looks' pass are not set.
template <typename Take>
Block PointsOf(const Block& block,
               const std::vector<std::uint32_t>& points,
               const Take& take,
               std::vector<std::size_t>* look_of) {
  Block part;
  part.name = block.name;
  part.frame = block.frame;
  const Looks& from = block.looks;
  Looks& to = part.looks;
  const auto copy = [](const auto& source, std::size_t i, auto* target) {
    if (!source.empty()) target->push_back(source[i]);
  };
  for (const std::uint32_t point : points) {
    const auto index = static_cast<std::uint32_t>(part.points.ids.size());
    part.points.ids.Append(block.points.ids[point]);
    part.points.role.push_back(block.points.role[point]);
    part.points.given_m.push_back(block.points.given_m[point]);
    if (const KnownPosition* known = block.points.FindKnown(point)) {
      part.points.known.push_back(*known);
      part.points.known.back().point = index;
    }
    for (std::size_t i = from.offsets[point]; i < from.offsets[point + 1]; ++i) {
      if (!take(i)) continue;
      to.pass.push_back(from.pass[i]);
      to.flags.push_back(from.flags[i]);
      to.time_s.push_back(from.time_s[i]);
      to.range_m.push_back(from.range_m[i]);
      copy(from.cone, i, &to.cone);
      copy(from.range_sigma_m, i, &to.range_sigma_m);
      copy(from.azimuth_sigma, i, &to.azimuth_sigma);
      if (look_of != nullptr) look_of->push_back(i);
    }
    to.offsets.push_back(to.pass.size());
  }
  return part;
}

}  // namespace

Block PartOf(const Block& block,
             const std::vector<std::uint32_t>& points,
             std::vector<std::size_t>* look_of) {
  Block part = PointsOf(
      block, points, [](std::size_t) { return true; }, look_of);
  part.passes = block.passes;
  return part;
}

Block PartOfPass(const Block& block, std::uint32_t pass, const std::vector<std::uint32_t>& points) {
  const auto of_pass = [&](std::size_t look) { return block.looks.pass[look] == pass; };
  Block part = PointsOf(block, points, of_pass, nullptr);
  part.passes.push_back(block.passes[pass]);
  part.looks.pass.assign(part.looks.size(), 0);
  return part;
}

}  // namespace sarblock
