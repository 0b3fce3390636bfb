// SPDX-License-Identifier: Apache-2.0
#include "variance_components.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <set>
#include <utility>

#include "core/threads.h"
#include "covariance.h"
#include "linear/dense.h"
#include "model/problem.h"
#include "normals/point.h"
#include "point_sweep.h"
#include "solve/rank.h"
#include "verdict_tests.h"

namespace sarblock {
namespace {

constexpr std::size_t kPointsPerPartial = 256;
constexpr std::size_t kMaxPartials = 8;
/// Most bytes of the dense normals by component, all partial sums together.
constexpr std::size_t kMaxBytes = std::size_t{256} << 20;

/// What every range of points needs.
struct Sweep {
  const AdjustmentProblem& problem;
  const BlockState& state;
  const ReducedSystem& system;
  const std::vector<std::array<int, 2>>& component_of;
  std::size_t components;
  std::optional<CorrectionCovariance> inverse;  // C on the pattern of S; empty without corrections
  bool couples = false;                         // points of all the block through C
};

/// What one range of points adds.
struct Partial {
  explicit Partial(const Sweep& sweep) {
    const auto k = static_cast<Eigen::Index>(sweep.components);
    sums.looks.assign(sweep.components, 0);
    sums.square.setZero(k);
    sums.redundancy.setZero(k);
    sums.helmert.setZero(k, k);
    const Eigen::Index n = sweep.couples ? sweep.problem.layout.size() : 0;
    normals.assign(sweep.couples ? sweep.components : 0, Eigen::MatrixXd::Zero(n, n));
  }
  VarianceSums sums;
  std::vector<Eigen::MatrixXd> normals;  // M_k = B' E_k B, over all corrections
};

/// normals += b' b of one row over the blocks of its point.
void AddNormals(const AdjustmentProblem& problem,
                const PointColumns& columns,
                const Eigen::Ref<const Eigen::RowVectorXd>& b,
                Eigen::MatrixXd* normals) {
  for (std::size_t i = 0; i < columns.blocks.size(); ++i) {
    const ParameterBlock& bi = problem.layout.blocks[static_cast<std::size_t>(columns.blocks[i])];
    for (std::size_t j = 0; j < columns.blocks.size(); ++j) {
      const ParameterBlock& bj = problem.layout.blocks[static_cast<std::size_t>(columns.blocks[j])];
      normals->block(bi.offset, bj.offset, bi.size, bj.size).noalias() +=
          b.segment(columns.begin[i], bi.size).transpose() * b.segment(columns.begin[j], bj.size);
    }
  }
}

void AddPoint(const Sweep& sweep, std::size_t point, PointLinearization* at, Partial* out) {
  const PointResiduals residuals = at->At(point).Residuals();
  std::vector<int> component;  // by row, -1 for control
  for (const std::uint64_t look : residuals.looks) {
    for (const int c : sweep.component_of[sweep.problem.block.looks.pass[look]]) {
      component.push_back(c);
    }
  }
  const Eigen::Index m = residuals.size();
  component.resize(static_cast<std::size_t>(m), -1);
  const Eigen::MatrixXd& r = residuals.q_vv;
  const Eigen::MatrixXd& shared = residuals.corrections_share;
  VarianceSums& sums = out->sums;
  for (Eigen::Index i = 0; i < m; ++i) {
    const int k = component[static_cast<std::size_t>(i)];
    if (k < 0) continue;
    ++sums.looks[static_cast<std::size_t>(k)];
    sums.square[k] += residuals.v[i] * residuals.v[i];
    sums.redundancy[k] += r(i, i);
    for (Eigen::Index j = 0; j < m; ++j) {
      const int l = component[static_cast<std::size_t>(j)];
      if (l < 0) continue;
      sums.helmert(k, l) += r(i, j) * r(i, j);
      // This square is a part of the sum over all pairs of points, added at the end.
      if (sweep.couples) sums.helmert(k, l) -= shared(i, j) * shared(i, j);
    }
    if (sweep.couples) {
      AddNormals(sweep.problem,
                 at->columns(),
                 at->Complement().row(i),
                 &out->normals[static_cast<std::size_t>(k)]);
    }
  }
}

/// h += q' j of one row of a look, and normals, where given, += j' j.
void AddRow(const ParameterLayout& layout,
            const WhitenedLook& look,
            std::size_t axis,
            const Eigen::RowVector3d& q,
            Eigen::MatrixXd* h,
            Eigen::MatrixXd* normals) {
  std::vector<std::pair<Eigen::Index, double>> row;
  for (int b = 0, local = 0; b < look.columns.block_count; ++b) {
    const ParameterBlock& block =
        layout.blocks[static_cast<std::size_t>(look.columns.block[static_cast<std::size_t>(b)])];
    for (int c = 0; c < block.size; ++c, ++local) {
      row.emplace_back(block.offset + c, look.row[axis][static_cast<std::size_t>(local)]);
    }
  }
  for (const auto& [i, value] : row) {
    h->col(i) += value * q.transpose();
    if (normals == nullptr) continue;
    for (const auto& [j, other] : row) (*normals)(i, j) += value * other;
  }
}

/// What the rows of one component of a point add: G = sum q' q, H = sum q' j, the sum of |q|^2 and
/// of b C b', with q a row of Q, j of J_c, b = j - q T.
struct ComponentSums {
  int rows = 0;
  Eigen::Matrix3d g = Eigen::Matrix3d::Zero();
  Eigen::MatrixXd h;  // 3 x corrections
  double squares = 0.0, corrections_share = 0.0;
};

/// A point of the border, which has too many rows for pairs of them:
///
///     sum p_ij^2      = [k = l] (n_k - 2 sum |q_i|^2) + tr(G_k G_l),     p_ij = [i = j] - q_i q_j'
///     sum p_ij s_ij   = [k = l] sum s_ii - tr(U_k C U_l'),               s_ij = b_i C b_j'
///     U_k             = H_k - G_k T,   M_k = sum j' j - T' H_k - H_k' T + T' G_k T
///
/// over i of component k and j of l. The square of s within the point is in M where points are
/// coupled; else it is left out with the rest of the coupling.
void AddBorderedPoint(
    const Sweep& sweep, std::size_t point, int row, PointLinearization* at, Partial* out) {
  const AdjustmentProblem& problem = sweep.problem;
  const ParameterLayout& layout = problem.layout;
  const Eigen::Index n = layout.size();
  at->At(point);
  const Eigen::MatrixXd t = sweep.system.matrix().border.Rows(row, 3);
  std::vector<ComponentSums> of(sweep.components);
  for (ComponentSums& component : of) component.h.setZero(3, n);
  VarianceSums& sums = out->sums;
  for (int number = 0; number < at->factor().look_count; ++number) {
    const WhitenedLook& look = at->factor().looks[static_cast<std::size_t>(number)];
    const LookCovariance figures = at->Look(number);
    const std::array<int, 2>& components = sweep.component_of[problem.block.looks.pass[look.look]];
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const int c = components[axis];
      if (c < 0) continue;
      const auto i = static_cast<Eigen::Index>(axis);
      ComponentSums& component = of[static_cast<std::size_t>(c)];
      const Eigen::RowVector3d q = figures.information.row(i);
      const double point_share = q.squaredNorm(),
                   corrections_share = figures.adjusted_covariance(i, i) - point_share;
      ++component.rows;
      ++sums.looks[static_cast<std::size_t>(c)];
      sums.square[c] += look.whitened_error[i] * look.whitened_error[i];
      sums.redundancy[c] += 1.0 - point_share - corrections_share;
      component.g += q.transpose() * q;
      component.squares += point_share;
      component.corrections_share += corrections_share;
      Eigen::MatrixXd* normals =
          sweep.couples ? &out->normals[static_cast<std::size_t>(c)] : nullptr;
      AddRow(layout, look, axis, q, &component.h, normals);
    }
  }
  std::vector<Eigen::MatrixXd> solved;
  for (const ComponentSums& component : of) {
    solved.push_back((component.h - component.g * t).transpose());
  }
  sweep.system.SolveEach(solved);
  for (std::size_t k = 0; k < of.size(); ++k) {
    const auto ki = static_cast<Eigen::Index>(k);
    const Eigen::MatrixXd& c_u = solved[k];
    for (std::size_t l = 0; l < of.size(); ++l) {
      const double of_p = of[k].g.cwiseProduct(of[l].g).sum();
      const double of_s = c_u.transpose().cwiseProduct(of[l].h - of[l].g * t).sum();
      sums.helmert(ki, static_cast<Eigen::Index>(l)) += of_p + 2.0 * of_s;
    }
    sums.helmert(ki, ki) += of[k].rows - 2.0 * of[k].squares - 2.0 * of[k].corrections_share;
    if (sweep.couples) {
      out->normals[k] +=
          -t.transpose() * of[k].h - of[k].h.transpose() * t + t.transpose() * (of[k].g * t);
    }
  }
}

/// Sum over all pairs of rows of (B C B')_ij^2 by component: tr(C M_k C M_l).
void AddCoupling(const ReducedSystem& system,
                 const std::vector<Eigen::MatrixXd>& normals,
                 Eigen::MatrixXd* helmert) {
  std::vector<Eigen::MatrixXd> solved = normals;
  system.SolveEach(solved);
  for (std::size_t k = 0; k < solved.size(); ++k) {
    for (std::size_t l = 0; l < solved.size(); ++l) {
      (*helmert)(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(l)) +=
          solved[k].cwiseProduct(solved[l].transpose()).sum();
    }
  }
}

}  // namespace

VarianceSums SumVariances(const AdjustmentProblem& problem,
                          const BlockState& state,
                          const ReducedSystem& system,
                          const std::vector<std::array<int, 2>>& component_of,
                          std::size_t component_count) {
  Sweep sweep{problem, state, system, component_of, component_count, std::nullopt};
  const std::size_t points = problem.block.points.size();
  std::size_t partials = std::clamp<std::size_t>(points / kPointsPerPartial, 1, kMaxPartials);
  if (problem.layout.size() > 0) {
    sweep.inverse = system.SelectedInverse();
    const auto n = static_cast<std::size_t>(problem.layout.size());
    const std::size_t bytes = component_count * n * n * sizeof(double);
    sweep.couples = bytes <= kMaxBytes;
    if (sweep.couples) partials = std::clamp<std::size_t>(kMaxBytes / bytes, 1, partials);
  }
  const auto border_row_of = [&](std::size_t point) {
    return sweep.inverse ? sweep.inverse->bordered.RowOf(point) : -1;
  };
  const CorrectionCovariance* const inverse = sweep.inverse ? &*sweep.inverse : nullptr;
  std::vector<std::optional<Partial>> parts(partials);
  const std::size_t per_part = (points + partials - 1) / partials;
  ParallelForChunks(points, per_part, [&](std::size_t part, std::size_t begin, std::size_t end) {
    Partial& out = parts[part].emplace(sweep);
    PointLinearization at(problem, state, inverse);
    for (std::size_t point = begin; point < end; ++point) {
      if (!problem.Solves(point)) continue;
      if (border_row_of(point) < 0) AddPoint(sweep, point, &at, &out);
    }
  });
  Partial total(sweep);
  for (const std::optional<Partial>& part : parts) {
    if (!part) continue;
    for (std::size_t k = 0; k < component_count; ++k) total.sums.looks[k] += part->sums.looks[k];
    total.sums.square += part->sums.square;
    total.sums.redundancy += part->sums.redundancy;
    total.sums.helmert += part->sums.helmert;
    for (std::size_t k = 0; k < total.normals.size(); ++k) total.normals[k] += part->normals[k];
  }
  // A few points with many looks each, which solve: not within a loop (SolveEach).
  PointLinearization at(problem, state, inverse);
  for (std::size_t point = 0; point < points; ++point) {
    const int row = problem.Solves(point) ? border_row_of(point) : -1;
    if (row >= 0) AddBorderedPoint(sweep, point, row, &at, &total);
  }
  if (sweep.couples) AddCoupling(system, total.normals, &total.sums.helmert);
  return total.sums;
}

namespace {

constexpr int kMaxIterations = 200;
/// Iterations after which components that hinder the others from settling are looked for.
constexpr int kPatience = 15;
/// Redundancy per look below which it is nothing but rounding.
constexpr double kNoRedundancy = 1e-6;
/// A variance that changes by more than this factor diverges, to zero or to infinity.
constexpr double kMaxFactor = 1e12;
/// Part of Helmert's step: where few looks determine a variance the whole step overshoots, nearly
/// to the other side.
constexpr double kDamping = 0.6;
/// Largest factor on a variance in one step.
constexpr double kMaxStep = 100.0;
/// Steps of variances end below this part of their standard deviations: they change no digit that
/// counts.
constexpr double kMaxDecrement = 0.01;
/// Helmert's equations take over once no variance changes by more than this part.
constexpr double kNear = 0.5;

std::size_t PassOf(const Block& block, const std::string& id) {
  for (std::size_t i = 0; i < block.passes.size(); ++i) {
    if (block.passes[i].id == id) return i;
  }
  throw InputError("adjust.variance_groups", "the block has no pass '" + id + "'");
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
        throw InputError("adjust.variance_groups", "pass '" + id + "' is given twice");
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
  Eigen::VectorXd step;       // relative change of the variances
  Eigen::VectorXd deviation;  // of the variances, as part of them
  [[nodiscard]] bool Settled() const {
    return (step.array().abs() <= kMaxDecrement * deviation.array()).all();
  }
};

HelmertStep SolveHelmert(const VarianceSums& sums,
                         const std::vector<VarianceComponent>& components) {
  HelmertStep out;
  out.index = Estimated(components);
  const auto n = static_cast<Eigen::Index>(out.index.size());
  const Eigen::MatrixXd h = sums.helmert(out.index, out.index);
  const Eigen::VectorXd excess = (sums.square - sums.redundancy)(out.index);
  const Eigen::VectorXd scale = h.diagonal().cwiseSqrt().cwiseInverse();
  const dense::PivotedCholesky factor(scale.asDiagonal() * h * scale.asDiagonal());
  const Eigen::MatrixXd inverse = scale.asDiagonal() *
                                  factor.Solve(Eigen::MatrixXd::Identity(n, n).eval()) *
                                  scale.asDiagonal();
  out.step = inverse * excess;
  out.deviation = (2.0 * inverse.diagonal()).cwiseSqrt();
  for (double& deviation : out.deviation) {
    if (!std::isfinite(deviation)) deviation = HUGE_VAL;
  }
  return out;
}

void FixComponent(double redundancy, VarianceComponent* component) {
  component->estimated = false;
  std::array<char, 200> text;
  std::snprintf(
      text.data(),
      text.size(),
      "fixed: a redundancy of %.3g in %zu looks, shared with the other components, leaves "
      "its variance uncertain by more than half of itself",
      redundancy,
      component->looks);
  component->note = text.data();
}

/// Fixes components without redundancy and those that diverge.
void FixUndeterminedComponents(const VarianceSums& sums,
                               std::vector<VarianceComponent>* components) {
  for (std::size_t k = 0; k < components->size(); ++k) {
    VarianceComponent& component = (*components)[k];
    const double redundancy = sums.redundancy[static_cast<Eigen::Index>(k)];
    const bool some = redundancy > kNoRedundancy * static_cast<double>(component.looks);
    const bool bounded = component.factor > 1.0 / kMaxFactor && component.factor < kMaxFactor;
    if (component.estimated && !(some && bounded)) FixComponent(redundancy, &component);
  }
}

/// Fixes the component that is determined worst, if its standard deviation is too large. One at a
/// time: with it back at its given value, the others may be determined. True if there was one.
bool FixWorstComponent(const VarianceSums& sums,
                       const HelmertStep& helmert,
                       std::vector<VarianceComponent>* components) {
  Eigen::Index worst = 0;
  if (helmert.index.empty() || helmert.deviation.maxCoeff(&worst) <= kMaxVarianceDeviation) {
    return false;
  }
  const Eigen::Index k = helmert.index[static_cast<std::size_t>(worst)];
  FixComponent(sums.redundancy[k], &(*components)[static_cast<std::size_t>(k)]);
  return true;
}

/// A component that was fixed on the way still has to return to the given variance.
bool FixedAsGiven(const std::vector<VarianceComponent>& components) {
  return std::all_of(components.begin(), components.end(), [](const VarianceComponent& c) {
    return c.estimated || c.factor == 1.0;
  });
}

/// One step of the variances; fixed ones return to the given values.
void Advance(const VarianceSums& sums,
             const HelmertStep& helmert,
             std::vector<VarianceComponent>* components) {
  const bool near = helmert.step.size() > 0 && helmert.step.cwiseAbs().maxCoeff() <= kNear;
  for (VarianceComponent& component : *components) {
    if (!component.estimated) component.factor = 1.0;
  }
  for (std::size_t i = 0; i < helmert.index.size(); ++i) {
    const Eigen::Index k = helmert.index[i];
    (*components)[static_cast<std::size_t>(k)].factor *=
        near ? 1.0 + kDamping * helmert.step[static_cast<Eigen::Index>(i)]
             : std::clamp(sums.square[k] / sums.redundancy[k], 1.0 / kMaxStep, kMaxStep);
  }
}

void ScaleProblem(const std::vector<VarianceComponent>& components,
                  const BlockState& state,
                  AdjustmentProblem* problem) {
  problem->model.ScaleSigmas(SigmaFactors(components, problem->block.passes.size()));
  UpdateWeights(state, problem);
}

/// Covariances of the corrections, where some have priors.
std::vector<ParameterCovariance> CovariancesForPriors(const AdjustmentProblem& problem,
                                                      const ReducedSystem& system) {
  const std::vector<Parameter>& all = problem.layout.parameters;
  const bool any =
      std::any_of(all.begin(), all.end(), [](const Parameter& p) { return p.has_prior(); });
  return any ? ParameterCovariances(system, system.SelectedInverse())
             : std::vector<ParameterCovariance>();
}

}  // namespace

void WarnOfComponents(const VarianceComponentReport& report, AdjustResult* result) {
  std::size_t fixed = 0;
  std::string first;
  for (const VarianceComponent& component : report.components) {
    if (component.estimated || fixed++ > 0) continue;
    first = component.group + (component.component == 0 ? " range" : " azimuth");
  }
  if (fixed > 0) {
    Warn(result,
         std::to_string(fixed) + " of " + std::to_string(report.components.size()) +
             " variance components keep the variance given, the first is " + first +
             ": too little redundancy to estimate it with the others; fewer groups determine more");
  }
  if (!report.converged) Warn(result, "the variance components did not settle");
}

std::vector<VarianceComponent> ListVarianceComponents(const AdjustOptions& options,
                                                      const Block& block) {
  if (!options.variance_groups.empty() &&
      options.variance_components != VarianceComponents::kRangeAzimuth) {
    throw InputError(
        "adjust.variance_groups",
        "needs variance_components = \"range-azimuth\", per-pass has one group per pass");
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
  int last_fixed = 0;
  for (;; ++report.iterations) {
    Step(progress,
         "variance components",
         static_cast<std::size_t>(report.iterations),
         static_cast<std::size_t>(kMaxIterations));
    const Participation before(*problem);
    if (steps.drop_outliers) steps.drop_outliers();
    std::optional<ReducedSystem> system;
    FormDetermined(*state, {}, problem, &system, nullptr);
    FactorRegular(&*system);
    const VarianceSums sums =
        SumVariances(*problem, *state, *system, component_of, components.size());
    if (report.iterations == 0) {
      const PriorSums priors =
          SumPriors(problem->layout, state->corrections, CovariancesForPriors(*problem, *system));
      report.before = TestMeasurements(
          CountProblem(*problem), priors, {.kept = 2.0 * system->cost()}, options.test_level);
      FillSigmaBefore(*problem, component_of, &components);
    }
    if (steps.drop_outliers) before.Restore(problem);
    for (std::size_t k = 0; k < components.size(); ++k) {
      components[k].looks = sums.looks[k];
      components[k].redundancy = sums.redundancy[static_cast<Eigen::Index>(k)];
    }
    FixUndeterminedComponents(sums, &components);
    // The weights given may be wrong by any factor, and with them what they leave of redundancy:
    // only at the end of the iteration, or without one, is it known what can be determined.
    HelmertStep helmert = SolveHelmert(sums, components);
    bool settled = helmert.Settled();
    if (settled || report.iterations - last_fixed >= kPatience) {
      if (FixWorstComponent(sums, helmert, &components)) {
        last_fixed = report.iterations;
        helmert = SolveHelmert(sums, components);
        settled = helmert.Settled();
      }
    }
    for (VarianceComponent& component : components) component.factor_deviation = kNaN;
    for (std::size_t i = 0; i < helmert.index.size(); ++i) {
      VarianceComponent& component = components[static_cast<std::size_t>(helmert.index[i])];
      component.factor_deviation =
          component.factor * helmert.deviation[static_cast<Eigen::Index>(i)];
    }
    report.converged = settled && FixedAsGiven(components);
    if (report.converged || report.iterations == kMaxIterations) return report;
    Advance(sums, helmert, &components);
    ScaleProblem(components, *state, problem);
    steps.solve();
  }
}

}  // namespace sarblock
