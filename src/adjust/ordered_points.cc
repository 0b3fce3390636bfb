// SPDX-License-Identifier: Apache-2.0
#include "ordered_points.h"

#include "sarblock/model/result.h"

#include <algorithm>
#include <cstddef>
#include <tuple>
#include <utility>

#include "core/memory.h"

namespace sarblock {
namespace {

void Restore(const PointOrder& back, PointResults* points) {
  Gather(back, &points->status);
  Gather(back, &points->reason);
  Gather(back, &points->looks);
  Gather(back, &points->position_m);
  Gather(back, &points->covariance_m2);
  Gather(back, &points->fixed_path_covariance_m2);
  Gather(back, &points->intersection_rad);
  Gather(back, &points->redundancy);
  Gather(back, &points->sigma_leberl_across_m);
  Gather(back, &points->sigma_leberl_up_m);
  Gather(back, &points->sigma_leberl_path_across_m);
  Gather(back, &points->sigma_leberl_path_up_m);
  Gather(back, &points->leberl_across_azimuth_rad);
}

void Restore(const PointOrder& back, MonteCarloReport* report) {
  Gather(back, &report->sample_m2);
  Gather(back, &report->square_1);
  for (std::vector<std::uint32_t>& inside : report->inside) Gather(back, &inside);
}

/// Names the points of a list as they stood before, and sorts the list by them.
template <typename Listed>
void RestoreListed(const PointOrder& order, std::vector<Listed>* list) {
  for (Listed& listed : *list) listed.point = order[listed.point];
  std::stable_sort(list->begin(), list->end(), [](const Listed& a, const Listed& b) {
    return a.point < b.point;
  });
}

/// A pair the other way round: b - a in the axes at a becomes a - b in those at b.
void TurnRound(const Frame& frame,
               const std::vector<Eigen::Vector3d>& position_m,
               PairResult* pair) {
  const Eigen::Matrix3d turn =
      frame.EnuFromFrame(position_m[pair->b]) * frame.EnuFromFrame(position_m[pair->a]).transpose();
  pair->difference_enu_m = -(turn * pair->difference_enu_m);
  pair->covariance_m2 = SymmetricOf(turn * MatrixOf(pair->covariance_m2) * turn.transpose());
  std::swap(pair->a, pair->b);
}

/// The tests of control change their place in `control_quality`.
void RestoreControl(const PointOrder& order, AdjustResult* result) {
  std::vector<ControlQuality>& tests = result->control_quality;
  if (tests.empty()) return;
  const ControlQuality worst = tests[result->assessment.tests.worst_control];
  RestoreListed(order, &tests);
  const auto found = std::find_if(tests.begin(), tests.end(), [&](const ControlQuality& test) {
    return test.point == order[worst.point] && test.component == worst.component;
  });
  result->assessment.tests.worst_control = static_cast<std::size_t>(found - tests.begin());
}

}  // namespace

OrderedPoints::OrderedPoints(PointOrder order, Block* block)
    : order_(std::move(order)), back_(InverseOf(order_)), block_(block) {
  ReorderPoints(order_, block_);
}

void OrderedPoints::RestoreBlock() const { ReorderPoints(back_, block_); }

PointPairs OrderedPoints::Pairs(PointPairs pairs) const {
  for (auto& [a, b] : pairs) {
    a = back_[a];
    b = back_[b];
  }
  return pairs;
}

void OrderedPoints::RestoreResult(bool sort_pairs, AdjustResult* result) const {
  const std::vector<std::uint64_t>& offsets = block_->looks.offsets;
  const std::vector<std::uint64_t> before = ReorderedOffsets(back_, offsets);
  const auto restore_look = [&](std::uint64_t* look) {
    const std::size_t place = block_->looks.PointOf(*look);
    *look = before[order_[place]] + (*look - offsets[place]);
  };
  const auto by_look = [&](auto* column) { GatherRanges(back_, offsets, before, column); };

  Restore(back_, &result->points);
  if (result->montecarlo) Restore(back_, &*result->montecarlo);
  by_look(&result->looks.range_residual_m);
  by_look(&result->looks.azimuth_residual_m);
  by_look(&result->looks.weight);
  by_look(&result->looks.rejected);
  by_look(&result->looks.reason);
  for (auto* columns :
       {&result->quality.redundancy_1, &result->quality.w_1, &result->quality.shift_m}) {
    for (std::vector<float>& column : *columns) by_look(&column);
  }
  RestoreControl(order_, result);
  RestoreListed(order_, &result->checks);
  if (result->montecarlo_draws) RestoreListed(order_, &result->montecarlo_draws->points);
  for (PairResult& pair : result->pairs) {
    pair.a = order_[pair.a];
    pair.b = order_[pair.b];
    if (sort_pairs && pair.a > pair.b) {
      TurnRound(block_->frame, result->points.position_m, &pair);
    }
  }
  if (sort_pairs) {
    std::sort(
        result->pairs.begin(), result->pairs.end(), [](const PairResult& a, const PairResult& b) {
          return std::tie(a.a, a.b) < std::tie(b.a, b.b);
        });
  }
  for (TestedLook& test : result->assessment.tests.worst) {
    restore_look(&test.look);
    test.point = order_[test.point];
  }
  if (!result->snooping) return;
  for (BlunderFinding& finding : result->snooping->findings) {
    finding.point = order_[finding.point];
    for (std::uint64_t& look : finding.looks) restore_look(&look);
  }
  // What a consensus left out, round 0, stands in the order of the points, all else as it was
  // found.
  std::vector<BlunderFinding>& findings = result->snooping->findings;
  const auto searched =
      std::find_if(findings.begin(), findings.end(), [](const BlunderFinding& finding) {
        return finding.round > 0;
      });
  std::stable_sort(
      findings.begin(), searched, [](const BlunderFinding& a, const BlunderFinding& b) {
        return a.point < b.point;
      });
  for (std::uint64_t& look : result->snooping->robust) restore_look(&look);
  std::sort(result->snooping->robust.begin(), result->snooping->robust.end());
}

}  // namespace sarblock
