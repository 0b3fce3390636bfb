// SPDX-License-Identifier: Apache-2.0
#include "variance_components.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <set>
#include <utility>

#include "global_test.h"
#include "linear/dense.h"
#include "model/problem.h"
#include "solve/rank.h"
#include "variance_sums.h"

namespace sarblock {
namespace {

constexpr int kMostIterations = 200;
/// Iterations after which components that hinder the others from settling are looked for.
constexpr int kPatience = 15;
/// Redundancy a look below which there is none but for rounding.
constexpr double kNoRedundancy_1 = 1e-6;
/// A variance that moves by more than this is running away, to zero or beyond all bounds.
constexpr double kMostFactor_1 = 1e12;
/// Of Helmert's step: where few looks tell a variance the whole step overshoots, nearly to the
/// other side.
constexpr double kDamping_1 = 0.6;
/// Largest factor on a variance in one step.
constexpr double kMostStep_1 = 100.0;
/// Of the standard deviation of a variance: a step this small changes no digit that counts.
constexpr double kStepLeft_1 = 0.01;
/// Helmert's equations take over once no variance changes by more than this part.
constexpr double kNear_1 = 0.5;

std::size_t PassOf(const Block& block, const std::string& id) {
  for (std::size_t i = 0; i < block.passes.size(); ++i) {
    if (block.passes[i].id == id) return i;
  }
  throw InputError("adjust.variance_groups", "no pass '" + id + "' stands in the block");
}

std::string NameOfGroup(const Block& block, const std::vector<std::size_t>& passes) {
  if (passes.size() == block.passes.size() && passes.size() > 1) return "all";
  std::string name;
  for (const std::size_t pass : passes) name += (name.empty() ? "" : "+") + block.passes[pass].id;
  return name;
}

std::vector<std::vector<std::size_t>> GroupsOf(const AdjustOptions& options, const Block& block) {
  std::vector<std::vector<std::size_t>> groups;
  std::vector<std::uint8_t> named(block.passes.size(), 0);
  for (const std::vector<std::string>& ids : options.variance_groups) {
    std::vector<std::size_t> group;
    for (const std::string& id : ids) {
      const std::size_t pass = PassOf(block, id);
      if (named[pass] != 0) {
        throw InputError("adjust.variance_groups",
                         "pass '" + id + "' stands twice, once is allowed");
      }
      named[pass] = 1;
      group.push_back(pass);
    }
    groups.push_back(std::move(group));
  }
  std::vector<std::size_t> rest;
  for (std::size_t pass = 0; pass < named.size(); ++pass) {
    if (named[pass] != 0) continue;
    if (options.variance_components == VarianceComponents::kPerPass) {
      groups.push_back({pass});
    } else {
      rest.push_back(pass);
    }
  }
  if (!rest.empty()) groups.push_back(std::move(rest));
  return groups;
}

const char* UnitText(AzimuthUnit unit) {
  return unit == AzimuthUnit::kSeconds ? "s" : unit == AzimuthUnit::kHertz ? "Hz" : "m";
}

/// Root mean square of what the used looks of a component had, and its unit.
void FillSigmaBefore(const AdjustmentProblem& problem,
                     const std::vector<std::array<int, 2>>& component_of,
                     std::vector<VarianceComponent>* components) {
  std::vector<double> square(components->size(), 0.0);
  std::vector<std::size_t> count(components->size(), 0);
  std::vector<std::set<AzimuthUnit>> units(components->size());
  for (std::size_t i = 0; i < problem.look_used.size(); ++i) {
    if (problem.look_used[i] == 0) continue;
    const LookSigma sigma = problem.block.SigmaOf(i);
    for (std::size_t c = 0; c < 2; ++c) {
      const auto k = static_cast<std::size_t>(component_of[problem.block.looks.pass[i]][c]);
      const double value = c == 0 ? sigma.range_m : sigma.azimuth;
      square[k] += value * value;
      ++count[k];
      units[k].insert(c == 0 ? AzimuthUnit::kMetres : sigma.azimuth_unit);
    }
  }
  for (std::size_t k = 0; k < components->size(); ++k) {
    VarianceComponent& component = (*components)[k];
    const bool mixed = units[k].size() > 1;
    component.unit = mixed ? "" : units[k].empty() ? "m" : UnitText(*units[k].begin());
    component.sigma_before =
        mixed || count[k] == 0 ? kNaN : std::sqrt(square[k] / static_cast<double>(count[k]));
  }
}

/// Indices of the components that are estimated.
std::vector<Eigen::Index> Estimated(const std::vector<VarianceComponent>& components) {
  std::vector<Eigen::Index> out;
  for (std::size_t k = 0; k < components.size(); ++k) {
    if (components[k].estimated) out.push_back(static_cast<Eigen::Index>(k));
  }
  return out;
}

/// Helmert's equations of the components that are estimated, at the variances reached.
struct HelmertStep {
  std::vector<Eigen::Index> index;
  Eigen::VectorXd step_1;       // relative change of the variances
  Eigen::VectorXd deviation_1;  // of the variances, as part of them
  [[nodiscard]] bool Settled() const {
    return (step_1.array().abs() <= kStepLeft_1 * deviation_1.array()).all();
  }
};

HelmertStep SolveHelmert(const VarianceSums& sums,
                         const std::vector<VarianceComponent>& components) {
  HelmertStep out;
  out.index = Estimated(components);
  const auto n = static_cast<Eigen::Index>(out.index.size());
  const Eigen::MatrixXd h = sums.helmert_1(out.index, out.index);
  const Eigen::VectorXd excess = (sums.square_1 - sums.redundancy_1)(out.index);
  const Eigen::VectorXd scale = h.diagonal().cwiseSqrt().cwiseInverse();
  const dense::PivotedCholesky factor(scale.asDiagonal() * h * scale.asDiagonal());
  const Eigen::MatrixXd inverse = scale.asDiagonal() *
                                  factor.Solve(Eigen::MatrixXd::Identity(n, n).eval()) *
                                  scale.asDiagonal();
  out.step_1 = inverse * excess;
  out.deviation_1 = (2.0 * inverse.diagonal()).cwiseSqrt();
  for (double& deviation : out.deviation_1) {
    if (!std::isfinite(deviation)) deviation = HUGE_VAL;
  }
  return out;
}

void Hold(double redundancy, VarianceComponent* component) {
  component->estimated = false;
  std::array<char, 200> text;
  std::snprintf(text.data(),
                text.size(),
                "held: a redundancy of %.3g in %zu looks, shared with the other components, leaves "
                "its variance uncertain by more than half of itself",
                redundancy,
                component->looks);
  component->note = text.data();
}

/// Holds what can have no estimate whatever the weights are, and what runs away.
void HoldHopeless(const VarianceSums& sums, std::vector<VarianceComponent>* components) {
  for (std::size_t k = 0; k < components->size(); ++k) {
    VarianceComponent& component = (*components)[k];
    const double redundancy = sums.redundancy_1[static_cast<Eigen::Index>(k)];
    const bool some = redundancy > kNoRedundancy_1 * static_cast<double>(component.looks);
    const bool bounded =
        component.factor_1 > 1.0 / kMostFactor_1 && component.factor_1 < kMostFactor_1;
    if (component.estimated && !(some && bounded)) Hold(redundancy, &component);
  }
}

/// Holds the component that is told worst, if that is not well enough. One at a time: once it is
/// back at what was given, the others may be told. True if there was one.
bool HoldWorst(const VarianceSums& sums,
               const HelmertStep& helmert,
               std::vector<VarianceComponent>* components) {
  Eigen::Index worst = 0;
  if (helmert.index.empty() || helmert.deviation_1.maxCoeff(&worst) <= kMostVarianceDeviation_1) {
    return false;
  }
  const Eigen::Index k = helmert.index[static_cast<std::size_t>(worst)];
  Hold(sums.redundancy_1[k], &(*components)[static_cast<std::size_t>(k)]);
  return true;
}

/// A component that was held on the way has still to go back to the variance given.
bool HeldAsGiven(const std::vector<VarianceComponent>& components) {
  return std::all_of(components.begin(), components.end(), [](const VarianceComponent& c) {
    return c.estimated || c.factor_1 == 1.0;
  });
}

/// One step of the variances; held ones go back to what was given.
void Advance(const VarianceSums& sums,
             const HelmertStep& helmert,
             std::vector<VarianceComponent>* components) {
  const bool near = helmert.step_1.size() > 0 && helmert.step_1.cwiseAbs().maxCoeff() <= kNear_1;
  for (VarianceComponent& component : *components) {
    if (!component.estimated) component.factor_1 = 1.0;
  }
  for (std::size_t i = 0; i < helmert.index.size(); ++i) {
    const Eigen::Index k = helmert.index[i];
    (*components)[static_cast<std::size_t>(k)].factor_1 *=
        near ? 1.0 + kDamping_1 * helmert.step_1[static_cast<Eigen::Index>(i)]
             : std::clamp(sums.square_1[k] / sums.redundancy_1[k], 1.0 / kMostStep_1, kMostStep_1);
  }
}

void ScaleProblem(const std::vector<VarianceComponent>& components,
                  const BlockState& state,
                  AdjustmentProblem* problem) {
  problem->model.ScaleSigmas(SigmaFactors(components, problem->block.passes.size()));
  UpdateWeights(state, problem);
}

}  // namespace

void WarnOfComponents(const VarianceComponentReport& report, AdjustResult* result) {
  std::size_t held = 0;
  std::string first;
  for (const VarianceComponent& component : report.components) {
    if (component.estimated || held++ > 0) continue;
    first = component.group + (component.component == 0 ? " range" : " azimuth");
  }
  if (held > 0) {
    Warn(result,
         std::to_string(held) + " of " + std::to_string(report.components.size()) +
             " variance components keep the variance given, the first is " + first +
             ": too little redundancy to tell it beside the others; fewer groups tell more");
  }
  if (!report.converged) Warn(result, "the variance components did not settle");
}

std::vector<VarianceComponent> ListVarianceComponents(const AdjustOptions& options,
                                                      const Block& block) {
  if (!options.variance_groups.empty() &&
      options.variance_components != VarianceComponents::kRangeAzimuth) {
    throw InputError("adjust.variance_groups",
                     "needs variance_components = \"range-azimuth\", per-pass has a group a pass");
  }
  std::vector<VarianceComponent> out;
  for (const std::vector<std::size_t>& group : GroupsOf(options, block)) {
    for (int c = 0; c < 2; ++c) {
      VarianceComponent component;
      component.group = NameOfGroup(block, group);
      component.passes = group;
      component.component = c;
      component.estimated = true;
      out.push_back(std::move(component));
    }
  }
  return out;
}

VarianceComponentReport EstimateVarianceComponents(const AdjustOptions& options,
                                                   const VarianceSteps& steps,
                                                   AdjustmentProblem* problem,
                                                   BlockState* state,
                                                   ProgressSink* progress) {
  VarianceComponentReport report;
  std::vector<VarianceComponent>& components = report.components;
  components = ListVarianceComponents(options, problem->block);
  std::vector<std::array<int, 2>> component_of(problem->block.passes.size());
  for (std::size_t k = 0; k < components.size(); ++k) {
    for (const std::size_t pass : components[k].passes) {
      component_of[pass][static_cast<std::size_t>(components[k].component)] = static_cast<int>(k);
    }
  }
  int last_hold = 0;
  for (;; ++report.iterations) {
    Step(progress,
         "variance components",
         static_cast<std::size_t>(report.iterations),
         static_cast<std::size_t>(kMostIterations));
    const Participation before(*problem);
    if (steps.drop_outliers) steps.drop_outliers();
    std::optional<ReducedSystem> system;
    FormDetermined(*state, {}, problem, &system, nullptr);
    FactorRegular(&*system);
    const VarianceSums sums =
        SumVariances(*problem, *state, *system, component_of, components.size());
    if (report.iterations == 0) {
      report.before = TestGlobally(*problem, options.test_level, 2.0 * system->cost());
      FillSigmaBefore(*problem, component_of, &components);
    }
    if (steps.drop_outliers) before.Restore(problem);
    for (std::size_t k = 0; k < components.size(); ++k) {
      components[k].looks = sums.looks[k];
      components[k].redundancy_1 = sums.redundancy_1[static_cast<Eigen::Index>(k)];
    }
    HoldHopeless(sums, &components);
    // The weights given may be wrong by any factor, and with them what they leave of redundancy:
    // only where the iteration ends, or does not, is it known what can be told.
    HelmertStep helmert = SolveHelmert(sums, components);
    bool settled = helmert.Settled();
    if (settled || report.iterations - last_hold >= kPatience) {
      if (HoldWorst(sums, helmert, &components)) {
        last_hold = report.iterations;
        helmert = SolveHelmert(sums, components);
        settled = helmert.Settled();
      }
    }
    for (VarianceComponent& component : components) component.factor_deviation_1 = kNaN;
    for (std::size_t i = 0; i < helmert.index.size(); ++i) {
      VarianceComponent& component = components[static_cast<std::size_t>(helmert.index[i])];
      component.factor_deviation_1 =
          component.factor_1 * helmert.deviation_1[static_cast<Eigen::Index>(i)];
    }
    report.converged = settled && HeldAsGiven(components);
    if (report.converged || report.iterations == kMostIterations) return report;
    Advance(sums, helmert, &components);
    ScaleProblem(components, *state, problem);
    steps.solve();
  }
}

}  // namespace sarblock
