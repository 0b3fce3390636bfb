// SPDX-License-Identifier: Apache-2.0
#include "sample.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/intersection.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/threads.h"
#include "edits.h"
#include "model/look_model.h"
#include "model/parameters.h"
#include "sightings.h"
#include <Eigen/Cholesky>

namespace sarblock {
namespace {

/// Known points of either role.
constexpr std::size_t kKnownOfRole = 24;
/// Points that are looked at for suspects in a large block.
constexpr std::size_t kMostLookedAt = 20000;
constexpr std::size_t kMostSuspects = 10;
/// Times the median of all points, from which on a point is suspect.
constexpr double kSuspect_1 = 8.0;

/// Steps of an intersection that only a ratio is made of; circles far from each other creep.
constexpr int kRoughSteps = 12;

/// More than any contradiction.
constexpr double kNowhere_m = 1e12;

/// Indices 0 .. count-1 in an order whose every beginning is spread evenly.
std::vector<std::uint32_t> SpreadOrder(std::size_t count) {
  std::vector<std::pair<double, std::uint32_t>> keys;
  constexpr double kGolden_1 = 0.6180339887498949;
  for (std::size_t i = 0; i < count; ++i) {
    const double turns = kGolden_1 * static_cast<double>(i);
    keys.emplace_back(turns - std::floor(turns), static_cast<std::uint32_t>(i));
  }
  std::sort(keys.begin(), keys.end());
  std::vector<std::uint32_t> order;
  for (const auto& [key, index] : keys) order.push_back(index);
  return order;
}

bool MayHold(const KnownPosition& known) {
  return known.held[0] && known.held[1] && known.held[2] &&
         Eigen::LLT<Eigen::Matrix3d>(known.covariance_enu_m2).info() == Eigen::Success;
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
  std::vector<Sight> sights;
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(model.layout().size());
  double scale_m = 0.0;
  for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
    if (block.looks.rejected(i) || !(block.looks.range_m[i] > 0.0)) continue;
    const auto sight = model.SightOf(i, none);
    if (!sight) return kNowhere_m;  // a time off its path
    sights.push_back(*sight);
    scale_m = std::max(scale_m, sight->range_sigma_m);
  }
  if (sights.empty()) return kNotGiven;
  const KnownPosition* known = block.points.FindKnown(point);
  if (known != nullptr && block.points.role[point] != PointRole::kTie && MayHold(*known)) {
    const Eigen::Vector3d& p_m = block.points.given_m[point];
    std::vector<double> off_m;
    for (const Sight& sight : sights) {
      const double off = std::abs((p_m - sight.antenna_m).norm() - sight.range_m);
      off_m.push_back(off + (LiesWhereItLooks(block.frame, sight, p_m) ? 0.0 : sight.range_m));
      const double ahead_m = sight.velocity_mps.normalized().dot(p_m - sight.antenna_m);
      const double sine = sight.cone.Sine(sight.velocity_mps.norm());
      off_m.push_back(std::abs(ahead_m - sight.range_m * sine));
    }
    return *std::max_element(off_m.begin(), off_m.end());
  }
  if (sights.size() < 2) return kNotGiven;
  const Intersection met = Intersect(sights, block.frame, {.max_iterations = kRoughSteps});
  const bool meets = met.outcome == IntersectionOutcome::kDetermined ||
                     met.outcome == IntersectionOutcome::kCirclesDoNotMeet ||
                     met.outcome == IntersectionOutcome::kNotConverged;
  if (!meets) return kNowhere_m;
  return scale_m * std::sqrt(met.weighted_square_sum / (2.0 * static_cast<double>(sights.size())));
}

double SafeContradiction(const Block& block, const LookModel& model, std::uint32_t point) {
  try {
    return ContradictionOf(block, model, point);
  } catch (const InputError&) {  // values of which no sight can be made
    return kNowhere_m;
  }
}

/// Points that contradict themselves much more than others of their role, the worst first.
std::vector<std::uint32_t> FindSuspects(const Block& block) {
  std::vector<CorrectionGroup> none;
  const ParameterLayout layout = MakeParameterLayout(block, none);
  const LookModel model(block, layout);
  const std::size_t stride = 1 + block.points.size() / kMostLookedAt;
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
    if (ratio > kSuspect_1) found.emplace_back(-ratio, static_cast<std::uint32_t>(i * stride));
  }
  std::sort(found.begin(), found.end());
  std::vector<std::uint32_t> suspects;
  for (std::size_t i = 0; i < std::min(found.size(), kMostSuspects); ++i) {
    suspects.push_back(found[i].second);
  }
  return suspects;
}

/// Values of the rows before and after each look of its pass.
std::vector<std::array<RowValues, 4>> NeighboursOf(const Block& block) {
  const Looks& looks = block.looks;
  std::vector<std::array<RowValues, 4>> out(looks.size());
  std::vector<std::vector<std::size_t>> of_pass(block.passes.size());
  for (std::size_t i = 0; i < looks.size(); ++i) of_pass[looks.pass[i]].push_back(i);
  const auto values = [&](std::size_t i) {
    return RowValues{looks.time_s[i], looks.range_m[i], looks.cone.empty() ? 0.0 : looks.cone[i]};
  };
  const auto link = [&](const std::vector<std::size_t>& rows, std::size_t before) {
    for (std::size_t k = 0; k < rows.size(); ++k) {
      out[rows[k]][before] = values(rows[(k + rows.size() - 1) % rows.size()]);
      out[rows[k]][before + 1] = values(rows[(k + 1) % rows.size()]);
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
  const std::vector<std::array<RowValues, 4>> neighbours = NeighboursOf(block);
  for (const std::size_t look : look_of) sample.neighbours.push_back(neighbours[look]);
  return sample;
}

}  // namespace sarblock
