// SPDX-License-Identifier: Apache-2.0
#include "score_screen.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <exception>
#include <map>
#include <utility>

#include "cone_mistakes.h"
#include "normals/reduced_system.h"
#include "range_mistakes.h"
#include "selection/quadratic_model.h"
#include "time_mistakes.h"

namespace sarblock {
namespace {

/// Of v'Pv, in squares of sigma, that a constant is to take to be solved for; and how many are.
constexpr double kLeastStatistic_1 = 25.0;
constexpr std::size_t kMostScored = 6;
/// Passes up to which the dense score test of all of them is no matter of time.
constexpr std::size_t kMostPasses = 60;

using Names = std::vector<std::string>;
using ParameterKey = std::pair<std::string, std::string>;  // owner and name

ParameterKey KeyOf(const Parameter& parameter) { return {parameter.owner, parameter.name}; }

/// The constants, each of one pass by itself and of all together.
std::vector<CorrectionGroup> Constants() {
  std::vector<CorrectionGroup> groups;
  for (const bool shared : {false, true}) {
    const std::string all = shared ? "diagnose." : "";
    groups.push_back({all + "range", RangeCorrection{.bias = true}, {}, shared});
    groups.push_back({all + "time", TimeCorrection{}, {}, shared});
    groups.push_back({all + "squint", SquintCorrection{}, {}, shared});
  }
  return groups;
}

Hypothesis HypothesisOf(const Parameter& parameter, const Names& passes, const Facts& facts) {
  const Block& block = facts.sample.block;
  const Pass& pass = block.passes[0];
  const double speed_mps = facts.passes[0].speed_mps;
  const double range_m = block.looks.size() > 0 ? block.looks.range_m[0] : 1.0;
  const double azimuth_m = block.looks.size() > 0 ? block.RoughAzimuthSigma_m(0, speed_mps) : 1.0;
  switch (parameter.kind) {
    case ParameterKind::kRangeBias:
      return RangeBias(passes, 0.0, pass.sigma.range_m);
    case ParameterKind::kTimeBias:
      return ConstantTime(passes, 0.0, azimuth_m / speed_mps);
    default:
      return SquintBias(passes, 0.0, azimuth_m / range_m);
  }
}

}  // namespace

Hypotheses ScoredMistakes(const Facts& facts, ProgressSink* progress) {
  Hypotheses out;
  const Block& block = facts.sample.block;
  if (!facts.before.solved || block.passes.size() > kMostPasses) return out;
  try {
    std::vector<CorrectionGroup> groups = facts.corrections.groups;
    for (const CorrectionGroup& constant : Constants()) {
      const bool stands = std::any_of(groups.begin(), groups.end(), [&](const CorrectionGroup& g) {
        return !constant.shared && !g.shared && Overlap(g, constant);
      });
      if (!stands) groups.push_back(constant);
    }
    const std::vector<JointPrior>& priors = facts.corrections.priors;
    AdjustmentProblem base(block, facts.corrections.groups, {}, priors);
    AdjustmentProblem extended(block, groups, {}, priors);
    std::map<ParameterKey, double> value_of;
    for (int i = 0; i < base.layout.size(); ++i) {
      value_of[KeyOf(base.layout.parameters[static_cast<std::size_t>(i)])] =
          facts.before.state.corrections[i];
    }
    BlockState state = facts.before.state;
    state.corrections = Eigen::VectorXd::Zero(extended.layout.size());
    std::vector<int> active, constants;
    for (int i = 0; i < extended.layout.size(); ++i) {
      const auto found =
          value_of.find(KeyOf(extended.layout.parameters[static_cast<std::size_t>(i)]));
      (found == value_of.end() ? constants : active).push_back(i);
      if (found != value_of.end()) state.corrections[i] = found->second;
    }
    for (std::size_t point = 0; point < block.points.size(); ++point) {
      if (!state.Position(point).allFinite()) {
        extended.LeaveOut(point, PointStatus::kUndetermined, "no place");
      }
    }
    UpdateWeights(state, &extended);
    ReducedSystem system(extended);
    system.Form(state, {}, progress);
    QuadraticModel::Data data = DataAt(system, state.corrections, extended.layout.parameters);
    data.redundancy_1 = facts.before.redundancy_1;
    QuadraticModel model(std::move(data));
    if (!model.Reset(active)) return out;
    std::vector<std::pair<double, int>> scores;
    for (const int column : constants) {
      const double statistic_1 = model.Score({column}).statistic_1;
      if (statistic_1 > kLeastStatistic_1) scores.emplace_back(-statistic_1, column);
    }
    std::sort(scores.begin(), scores.end());
    if (scores.size() > kMostScored) scores.resize(kMostScored);
    for (const auto& [score, column] : scores) {
      const Parameter& parameter = extended.layout.parameters[static_cast<std::size_t>(column)];
      const bool shared = parameter.owner.rfind("diagnose.", 0) == 0;
      if (shared && block.passes.size() < 2) continue;
      out.push_back(HypothesisOf(parameter, shared ? Names{} : Names{parameter.owner}, facts));
      out.back().screened = true;
      // What a constant takes where all is linear is its statistic.
      const double excess_1 = facts.before.SquareSum() - facts.before.redundancy_1;
      if (-2.0 * score > excess_1) out.back().order_1 = Hypothesis::kScored_1;
      out.back().local = true;
    }
  } catch (const Interrupted&) {
    throw;
  } catch (const std::exception&) {  // a block that cannot be linearised has no scores
    out.clear();
  }
  return out;
}

}  // namespace sarblock
