// SPDX-License-Identifier: Apache-2.0
#include "sample.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/intersection.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "block/read_recorded.h"
#include "core/threads.h"
#include "linear/dense.h"
#include "model/look_model.h"
#include "model/parameters.h"

namespace sarblock {
namespace {

/// Known points of either role.
constexpr std::size_t kKnownOfRole = 24;
/// Points that are looked at for suspects in a large block.
constexpr std::size_t kMaxExamined = 20000;
constexpr std::size_t kMaxSuspects = 10;
/// Times the median of all points, from which on a point is suspect.
constexpr double kSuspect = 8.0;

/// Steps of an intersection that only a ratio is made of; circles far from each other creep.
constexpr int kApproximateSteps = 12;

/// More than any contradiction.
constexpr double kNowhere_m = 1e12;

/// Indices 0 .. count-1 in an order whose every beginning is spread evenly.
std::vector<std::uint32_t> SpreadOrder(std::size_t count) {
  std::vector<std::pair<double, std::uint32_t>> keys;
  constexpr double kGolden = 0.6180339887498949;
  for (std::size_t i = 0; i < count; ++i) {
    const double turns = kGolden * static_cast<double>(i);
    keys.emplace_back(turns - std::floor(turns), static_cast<std::uint32_t>(i));
  }
  std::sort(keys.begin(), keys.end());
  std::vector<std::uint32_t> order;
  for (const auto& [key, index] : keys) order.push_back(index);
  return order;
}

bool CanFix(const KnownPosition& known) {
  return known.fixed[0] && known.fixed[1] && known.fixed[2] &&
         dense::LowerFactor(known.covariance_enu_m2).has_value();
}

/// Tie points that a pair of passes is to have: fewer where there are many passes.
std::size_t TiesOfPair(const Block& block) {
  return std::clamp<std::size_t>(64 / std::max<std::size_t>(1, block.passes.size()), 4, 24);
}

std::vector<std::uint32_t> ChoosePoints(const Block& block) {
  const std::size_t ties_wanted = TiesOfPair(block);
  std::vector<std::uint32_t> chosen;
  std::array<std::size_t, 3> known_count{};
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> ties_of_pair;
  for (const std::uint32_t point : SpreadOrder(block.points.size())) {
    const std::size_t begin = block.looks.offsets[point], end = block.looks.offsets[point + 1];
    if (begin == end) continue;
    const PointRole role = block.points.role[point];
    if (role != PointRole::kTie) {
      if (known_count[static_cast<std::size_t>(role)]++ < kKnownOfRole) chosen.push_back(point);
      continue;
    }
    bool wanted = false;
    for (std::size_t i = begin; i < end; ++i) {
      for (std::size_t j = i + 1; j < end; ++j) {
        const std::pair pair{block.looks.pass[i], block.looks.pass[j]};
        wanted = wanted || ties_of_pair[pair] < ties_wanted;
      }
    }
    if (!wanted) continue;
    chosen.push_back(point);
    for (std::size_t i = begin; i < end; ++i) {
      for (std::size_t j = i + 1; j < end; ++j) {
        ++ties_of_pair[{block.looks.pass[i], block.looks.pass[j]}];
      }
    }
  }
  return chosen;
}

double ContradictionOf(const Block& block, const LookModel& model, std::uint32_t point) {
  std::vector<FixedPathLook> observations;
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(model.layout().size());
  double scale_m = 0.0;
  for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
    if (block.looks.rejected(i) || !(block.looks.range_m[i] > 0.0)) continue;
    const auto observation = model.FixPath(i, none);
    if (!observation) return kNowhere_m;  // a time off its path
    observations.push_back(*observation);
    scale_m = std::max(scale_m, observation->range_sigma_m);
  }
  if (observations.empty()) return kNotGiven;
  const KnownPosition* known = block.points.FindKnown(point);
  if (known != nullptr && block.points.role[point] != PointRole::kTie && CanFix(*known)) {
    const Eigen::Vector3d& p_m = block.points.given_m[point];
    std::vector<double> off_m;
    for (const FixedPathLook& observation : observations) {
      const double off = std::abs((p_m - observation.antenna_m).norm() - observation.range_m);
      off_m.push_back(
          off + (LiesWhereItLooks(block.frame, observation, p_m) ? 0.0 : observation.range_m));
      const double ahead_m = observation.velocity_mps.normalized().dot(p_m - observation.antenna_m);
      const double sine = observation.cone.Sine(observation.velocity_mps.norm());
      off_m.push_back(std::abs(ahead_m - observation.range_m * sine));
    }
    return *std::max_element(off_m.begin(), off_m.end());
  }
  if (observations.size() < 2) return kNotGiven;
  const Intersection met =
      Intersect(observations, block.frame, {.max_iterations = kApproximateSteps});
  const bool meets = met.outcome == IntersectionOutcome::kDetermined ||
                     met.outcome == IntersectionOutcome::kCirclesDoNotMeet ||
                     met.outcome == IntersectionOutcome::kNotConverged;
  if (!meets) return kNowhere_m;
  return scale_m *
         std::sqrt(met.weighted_square_sum / (2.0 * static_cast<double>(observations.size())));
}

double SafeContradiction(const Block& block, const LookModel& model, std::uint32_t point) {
  try {
    return ContradictionOf(block, model, point);
  } catch (const InputError&) {  // values of no observation
    return kNowhere_m;
  }
}

/// Points that contradict themselves much more than others of their role, the worst first.
std::vector<std::uint32_t> FindSuspects(const Block& block) {
  std::vector<CorrectionGroup> none;
  const ParameterLayout layout = MakeParameterLayout(block, none);
  const LookModel model(block, layout);
  const std::size_t stride = 1 + block.points.size() / kMaxExamined;
  const std::size_t count = block.points.size() / stride;
  std::vector<double> off_m(count, kNotGiven);
  ParallelForChunks(count, 256, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      off_m[i] = SafeContradiction(block, model, static_cast<std::uint32_t>(i * stride));
    }
  });
  std::array<std::vector<double>, 2> by_role;  // ties, known
  const auto known = [&](std::size_t i) {
    return block.points.role[i * stride] == PointRole::kTie ? 0U : 1U;
  };
  for (std::size_t i = 0; i < count; ++i) {
    if (!std::isnan(off_m[i])) by_role[known(i)].push_back(off_m[i]);
  }
  const std::array<double, 2> median_m{Median(std::move(by_role[0])),
                                       Median(std::move(by_role[1]))};
  std::vector<std::pair<double, std::uint32_t>> found;
  for (std::size_t i = 0; i < count; ++i) {
    const double ratio = off_m[i] / median_m[known(i)];
    if (ratio > kSuspect) found.emplace_back(-ratio, static_cast<std::uint32_t>(i * stride));
  }
  std::sort(found.begin(), found.end());
  std::vector<std::uint32_t> suspects;
  for (std::size_t i = 0; i < std::min(found.size(), kMaxSuspects); ++i) {
    suspects.push_back(found[i].second);
  }
  return suspects;
}

/// Values of the rows before and after each of these looks in its pass.
std::vector<std::array<RowValues, 4>> NeighboursOf(const Block& block,
                                                   const std::vector<std::size_t>& of_sample) {
  const Looks& looks = block.looks;
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> place(looks.size(), kNone);
  for (std::size_t k = 0; k < of_sample.size(); ++k) {
    place[of_sample[k]] = static_cast<std::uint32_t>(k);
  }
  std::vector<std::array<RowValues, 4>> out(of_sample.size());
  std::vector<std::vector<std::size_t>> of_pass(block.passes.size());
  for (std::size_t i = 0; i < looks.size(); ++i) of_pass[looks.pass[i]].push_back(i);
  const auto values = [&](std::size_t i) {
    return RowValues{looks.time_s[i], looks.range_m[i], looks.cone.empty() ? 0.0 : looks.cone[i]};
  };
  const auto link = [&](const std::vector<std::size_t>& rows, std::size_t before) {
    for (std::size_t k = 0; k < rows.size(); ++k) {
      if (place[rows[k]] == kNone) continue;
      out[place[rows[k]]][before] = values(rows[(k + rows.size() - 1) % rows.size()]);
      out[place[rows[k]]][before + 1] = values(rows[(k + 1) % rows.size()]);
    }
  };
  for (std::vector<std::size_t>& rows : of_pass) {
    link(rows, Sample::kPointBefore);
    std::stable_sort(rows.begin(), rows.end(), [&](std::size_t a, std::size_t b) {
      return looks.time_s[a] < looks.time_s[b];
    });
    link(rows, Sample::kTimeBefore);
  }
  return out;
}

}  // namespace

double ContradictionOf(const Block& block, std::uint32_t point) {
  std::vector<CorrectionGroup> none;
  const ParameterLayout layout = MakeParameterLayout(block, none);
  return SafeContradiction(block, LookModel(block, layout), point);
}

Sample TakeSample(const Block& block, ProgressSink* progress) {
  Step(progress, "diagnose", 0, 0, "sample");
  std::vector<std::uint32_t> points = ChoosePoints(block);
  const std::vector<std::uint32_t> suspects = FindSuspects(block);
  points.insert(points.end(), suspects.begin(), suspects.end());
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());

  Sample sample;
  std::vector<std::size_t> look_of;
  sample.block = PartOf(block, points, &look_of);
  for (const std::uint32_t suspect : suspects) {
    const auto found = std::lower_bound(points.begin(), points.end(), suspect);
    sample.suspects.push_back(static_cast<std::uint32_t>(found - points.begin()));
  }
  sample.neighbours = NeighboursOf(block, look_of);
  return sample;
}

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

void EditPathAsRead(const std::function<void(StateVector*)>& edit, std::size_t pass, Block* block) {
  TryOnPasses(block, [&] {
    std::vector<StateVector> states = block->passes[pass].path.states();
    for (StateVector& state : states) edit(&state);
    block->passes[pass].path = FlightPath(std::move(states));
  });
}

void ReadWithAuto(const std::vector<std::string>& passes, Block* block) {
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
      copy(from.range_delay_m, i, &to.range_delay_m);
      copy(from.time_shift_s, i, &to.time_shift_s);
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

namespace {

constexpr std::size_t kMaxKnown = 60;

PredictedLook See(const Block& block, std::size_t look, const Eigen::Vector3d& p_m) {
  const Pass& pass = block.passes[block.looks.pass[look]];
  PredictedLook out;
  out.look = look;
  out.time_s = block.looks.time_s[look];
  out.range_m = block.looks.range_m[look];
  const Cone cone = block.ConeOf(look);
  Motion motion;
  out.off_m = (p_m - pass.path.states().front().position_m).norm();
  if (!pass.path.Read(out.time_s, Acceleration::kOfCubic, &motion)) return out;
  const Eigen::Vector3d los_m = p_m - motion.position_m;
  const double distance_m = los_m.norm(), speed_mps = motion.velocity_mps.norm();
  const double ahead_m = motion.velocity_mps.dot(los_m) / speed_mps;
  FixedPathLook observation;
  observation.antenna_m = motion.position_m;
  observation.velocity_mps = motion.velocity_mps;
  observation.side = pass.side == LookSide::kLeft ? 1 : -1;
  out.on_its_side = LiesWhereItLooks(block.frame, observation, p_m);
  out.ahead_sine = ahead_m / distance_m;
  out.off_m = std::hypot(distance_m - out.range_m, ahead_m - distance_m * cone.Sine(speed_mps));
  if (!out.on_its_side) out.off_m += distance_m;
  return out;
}

void FindAbeam(const Block& block, const Eigen::Vector3d& p_m, PredictedLook* predicted) {
  const FlightPath& path = block.passes[block.looks.pass[predicted->look]].path;
  const std::optional<double> time_s =
      FindConeTime(path, p_m, block.ConeOf(predicted->look), path.start_s(), path.end_s());
  const std::optional<Motion> motion = time_s ? path.At(*time_s) : std::nullopt;
  if (!motion) return;
  predicted->true_time_s = *time_s;
  predicted->true_range_m = (p_m - motion->position_m).norm();
}

bool WhollyKnown(const Block& block, std::uint32_t point) {
  const KnownPosition* known = block.points.FindKnown(point);
  return known != nullptr && block.points.role[point] != PointRole::kTie && known->fixed[0] &&
         known->fixed[1] && known->fixed[2] && block.points.given_m[point].allFinite();
}

template <typename Use>
void ForKnownLooks(const Block& block, const Use& use) {
  for (std::uint32_t point = 0; point < block.points.size(); ++point) {
    if (!WhollyKnown(block, point)) continue;
    for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      if (!block.looks.rejected(i)) use(point, i);
    }
  }
}

}  // namespace

double Median(std::vector<double> values) {
  if (values.empty()) return kNotGiven;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Line RobustLine(const std::vector<double>& x, const std::vector<double>& y) {
  std::vector<double> slopes, offsets, distances;
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (std::size_t j = i + 1; j < x.size(); ++j) {
      if (x[i] != x[j]) slopes.push_back((y[j] - y[i]) / (x[j] - x[i]));
    }
  }
  Line line;
  if (slopes.empty()) return line;
  line.slope = Median(std::move(slopes));
  for (std::size_t i = 0; i < x.size(); ++i) offsets.push_back(y[i] - line.slope * x[i]);
  line.offset = Median(offsets);
  for (const double offset : offsets) distances.push_back(std::abs(offset - line.offset));
  line.spread = Median(std::move(distances));
  return line;
}

double MisfitOf(const Block& block) {
  std::vector<double> off_m;
  ForKnownLooks(block, [&](std::uint32_t point, std::size_t look) {
    off_m.push_back(See(block, look, block.points.given_m[point]).off_m);
  });
  return Median(std::move(off_m));
}

PredictedLook PredictLook(const Block& block, std::size_t look, const Eigen::Vector3d& p_m) {
  PredictedLook predicted = See(block, look, p_m);
  FindAbeam(block, p_m, &predicted);
  return predicted;
}

std::vector<PassPredictions> PredictLooks(const Block& block) {
  std::vector<std::vector<std::uint32_t>> known(block.passes.size());
  ForKnownLooks(block, [&](std::uint32_t point, std::size_t look) {
    std::vector<std::uint32_t>& points = known[block.looks.pass[look]];
    if (points.empty() || points.back() != point) points.push_back(point);
  });
  std::vector<PassPredictions> out(block.passes.size());
  for (std::uint32_t p = 0; p < out.size(); ++p) {
    PassPredictions& of = out[p];
    of.pass = p;
    of.speed_mps = block.passes[p].path.states().front().velocity_mps.norm();
    std::vector<std::uint32_t>& points = known[p];
    if (points.size() > kMaxKnown) {
      std::vector<std::uint32_t> kept;
      for (std::size_t i = 0; i < kMaxKnown; ++i) {
        kept.push_back(points[i * points.size() / kMaxKnown]);
      }
      points = std::move(kept);
    }
    of.part = PartOfPass(block, p, points);
    // Medians of metres need no smoothed path: other states are tried as they are.
    of.part.passes[0].recorded.asked.through = PathThrough::kStates;
    std::vector<double> off_m;
    ForKnownLooks(of.part, [&](std::uint32_t point, std::size_t look) {
      const PredictedLook predicted = PredictLook(of.part, look, of.part.points.given_m[point]);
      off_m.push_back(predicted.off_m);
      of.predictions.push_back(predicted);
    });
    of.misfit_m = Median(std::move(off_m));
  }
  return out;
}

}  // namespace sarblock
