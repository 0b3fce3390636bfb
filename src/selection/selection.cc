// SPDX-License-Identifier: Apache-2.0
#include "selection.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <tuple>
#include <utility>

#include "candidates.h"
#include "normals/reduced_system.h"
#include "quadratic_model.h"
#include "solve/rank.h"
#include "solve/reduced_engine.h"
#include "solve/solve_block.h"
#include "solve/start.h"
#include <glog/logging.h>

namespace sarblock {
namespace {

/// Linearisations after which a selection that still changes its mind is taken as it is.
constexpr int kMaxRounds = 8;
/// Swaps in one selection after which there are no more.
constexpr int kMaxSwaps = 100;
/// Relative difference of information criteria below which two candidates are one.
constexpr double kEqual = 1e-6;
/// Sweeps over the processes of a model, which estimate the variance of each given the others'.
constexpr int kVarianceSweeps = 3;
/// Part of what the observations say of a candidate below which the corrections that are kept say
/// it as well.
constexpr double kMinPartLeft = 1e-5;
/// Relative difference of prior variances that no round is made for: their own standard deviation
/// is many times that.
constexpr double kSameVariance = 0.05;

class Selector {
 public:
  Selector(const Block& block, const AdjustOptions& options, ProgressSink* progress)
      : block_(block), options_(options), progress_(progress) {
    // A redescending loss would take the missing corrections for outliers.
    if (options.robust != RobustLoss::kNone) {
      AdjustOptions convex;
      convex.robust = RobustLoss::kHuber;
      weighting_ = {convex.robust, RobustScale(convex)};
    }
  }

  SelectionReport Run() {
    Start();
    SelectionReport report;
    report.settled = false;
    while (report.rounds < kMaxRounds && !report.settled) {
      ++report.rounds;
      Step(progress_, "select", static_cast<std::size_t>(report.rounds), kMaxRounds);
      candidates_ = MakeCandidates(*problem_, options_, spline_groups_);
      levels_.resize(candidates_.terms.size(), 0);
      variance_m2_.resize(candidates_.terms.size(), 0.0);
      held_.resize(candidates_.terms.size());
      QuadraticModel model = Linearise();
      const bool changed = ChooseSteps(&model);
      const bool wider = WantSplines(model);
      if (changed) static_cast<void>(Refit());
      report.settled = !changed && !wider;
      if (report.settled || report.rounds == kMaxRounds) {
        TestKept(model);
        if (Hold(&model) && !Refit()) {
          report.certain = LetGo();
          static_cast<void>(Refit());
        }
      }
    }
    report.steps = step_;
    report.candidates = rows_.Finish(candidates_, levels_, held_, options_.selection);
    report.groups = GroupsOf(block_, candidates_, levels_, variance_m2_, held_);
    return report;
  }

  [[nodiscard]] const AdjustmentProblem& problem() const { return *problem_; }
  [[nodiscard]] const BlockState& state() const { return state_; }

 private:
  using Levels = std::vector<std::size_t>;
  using Dropped = std::set<std::pair<std::size_t, std::size_t>>;  // term and level

  /// The block without corrections.
  void Start() {
    problem_ = std::make_unique<AdjustmentProblem>(block_, std::vector<CorrectionGroup>{});
    state_ = std::move(ComputeStartValues(problem_.get(), progress_).state);
    RequireSolvable(*problem_);
    static_cast<void>(Solve());
    // The adjustment that follows starts such points again; the choice does without them.
    ReducedSystem system(*problem_);
    system.Form(state_, {}, progress_);
    for (const std::size_t point : MirrorSolutions(*problem_, state_, system)) {
      if (problem_->control_of[point] >= 0) continue;
      problem_->LeaveOut(point, PointStatus::kUndetermined, "lost while corrections were chosen");
    }
    RequireSolvable(*problem_);
  }

  bool Solve() {
    SolveOptions solve;
    solve.max_iterations = options_.max_iterations;
    solve.threads = options_.threads;
    const SolveReport report = SolveReduced(*problem_, weighting_, solve, &state_, progress_);
    UpdateWeights(state_, problem_.get());
    return report.converged;
  }

  using Key = std::pair<std::string, std::string>;  // owner and name
  static Key KeyOf(const Parameter& parameter) { return {parameter.owner, parameter.name}; }

  /// Carries what takes part, and with which weights, from one problem to another.
  static void Adopt(const AdjustmentProblem& from, AdjustmentProblem* to) {
    to->look_used = from.look_used;
    to->point_status = from.point_status;
    to->point_reason = from.point_reason;
    to->weights = from.weights;
    to->model.AnchorLike(from.model);
  }

  std::vector<int> ActiveColumns() const { return ActiveColumns(levels_); }
  std::vector<int> ActiveColumns(const Levels& levels) const {
    std::vector<int> active;
    for (std::size_t t = 0; t < levels.size(); ++t) {
      const std::vector<int> columns = candidates_.terms[t].ColumnsAt(levels[t]);
      active.insert(active.end(), columns.begin(), columns.end());
    }
    return active;
  }

  /// All candidates in one system at the present solution.
  QuadraticModel Linearise() {
    AdjustmentProblem extended(block_, candidates_.extended);
    if (extended.layout.size() > kMaxCandidateColumns) {
      throw InputError("adjust.selection",
                       std::to_string(extended.layout.size()) + " candidate parameters, at most " +
                           std::to_string(kMaxCandidateColumns) +
                           " are allowed; name fewer candidates, degrees or knots");
    }
    Adopt(*problem_, &extended);
    BlockState state = state_;
    state.corrections = Eigen::VectorXd::Zero(extended.layout.size());
    std::map<Key, double> value_of;
    for (int i = 0; i < problem_->layout.size(); ++i) {
      value_of[KeyOf(problem_->layout.parameters[static_cast<std::size_t>(i)])] =
          state_.corrections[i];
    }
    for (const int column : ActiveColumns()) {
      const auto found =
          value_of.find(KeyOf(candidates_.parameters[static_cast<std::size_t>(column)]));
      CHECK(found != value_of.end()) << "a correction of the model has no value";
      state.corrections[column] = found->second;
    }
    std::optional<ReducedSystem> system;
    FormDetermined(state, weighting_, &extended, &system, progress_);
    Adopt(extended, problem_.get());

    // What only the corrections found so far make determinable is not: the adjustment starts
    // without them. A time bias and a shift along a straight path part where the path is bent.
    std::optional<ReducedSystem> start;
    if (!state.corrections.isZero(0.0)) {
      BlockState uncorrected = state;
      uncorrected.corrections.setZero();
      start.emplace(extended);
      start->Form(uncorrected, weighting_, progress_);
    }
    const ReducedSystem& nominal = start ? *start : *system;
    nominal_s_ = nominal.matrix().ToDense();
    nominal_diagonal_ = nominal.full_diagonal();
    effect_part_ = EffectParts(extended);

    QuadraticModel::Data data = DataAt(*system, state.corrections, candidates_.parameters);
    const ProblemCounts counts = CountProblem(*problem_);
    data.redundancy =
        static_cast<double>(counts.observations) - static_cast<double>(counts.parameters);
    for (const Parameter& parameter : problem_->layout.parameters) {
      if (!parameter.has_prior()) data.redundancy += 1.0;
    }
    QuadraticModel model(std::move(data));
    for (std::size_t t = 0; t < levels_.size(); ++t) {
      if (IsProcess(t, levels_[t])) {
        model.SetPrior(candidates_.terms[t].ColumnsAt(levels_[t]), variance_m2_[t]);
      }
    }
    return model;
  }

  bool IsProcess(std::size_t t, std::size_t level) const {
    return level > 0 && candidates_.terms[t].levels[level - 1].process;
  }

  /// Solves the block with the model chosen, from the former solution; false where the solution
  /// does not converge.
  bool Refit() {
    auto next = std::make_unique<AdjustmentProblem>(
        block_, GroupsOf(block_, candidates_, levels_, variance_m2_, held_));
    Adopt(*problem_, next.get());
    std::map<Key, double> value_of;
    for (int i = 0; i < problem_->layout.size(); ++i) {
      value_of[KeyOf(problem_->layout.parameters[static_cast<std::size_t>(i)])] =
          state_.corrections[i];
    }
    // Coefficients of other functions have the same names.
    solved_levels_.resize(levels_.size(), 0);
    for (std::size_t t = 0; t < levels_.size(); ++t) {
      if (Functions(t, levels_[t]) == Functions(t, solved_levels_[t])) continue;
      for (const int column : candidates_.terms[t].ColumnsAt(levels_[t])) {
        value_of.erase(KeyOf(candidates_.parameters[static_cast<std::size_t>(column)]));
      }
    }
    solved_levels_ = levels_;
    state_.corrections = Eigen::VectorXd::Zero(next->layout.size());
    for (int i = 0; i < next->layout.size(); ++i) {
      const auto found = value_of.find(KeyOf(next->layout.parameters[static_cast<std::size_t>(i)]));
      if (found != value_of.end()) state_.corrections[i] = found->second;
    }
    problem_ = std::move(next);
    return Solve();
  }

  /// What a level is made of: polynomials (0), or one of the splines.
  std::size_t Functions(std::size_t t, std::size_t level) const {
    return level > 0 && candidates_.terms[t].levels[level - 1].spline ? level : 0;
  }

  struct Move {
    std::size_t term = 0;
    std::size_t level = 0;
    CandidateFigures figures;
    bool found = false;
  };

  /// Tests a term at a higher level; nothing where the level cannot be reached from here.
  std::optional<CandidateFigures> Raise(const QuadraticModel& model,
                                        std::size_t t,
                                        std::size_t level) const {
    const SelectionTerm& term = candidates_.terms[t];
    const std::size_t now = levels_[t];
    if (term.levels[level - 1].columns.empty()) return std::nullopt;
    if (IsProcess(t, level)) {
      const std::size_t below = std::min(now, term.Degrees());
      return model.Process(term.ColumnsAt(level), term.ColumnsAt(now), term.ColumnsAt(below));
    }
    if (term.levels[level - 1].spline) {
      return model.Exchange(term.ColumnsAt(now), term.ColumnsAt(level));
    }
    std::vector<int> columns;
    for (std::size_t l = now; l < level; ++l) {
      const std::vector<int>& add = term.levels[l].columns;
      columns.insert(columns.end(), add.begin(), add.end());
    }
    return model.Score(columns);
  }

  /// Takes a move; to a process with the variance that its figures found.
  void Enter(const Move& move, QuadraticModel* model) {
    if (IsProcess(move.term, move.level)) variance_m2_[move.term] = move.figures.variance;
    Apply(move.term, move.level, model);
  }

  void Apply(std::size_t t, std::size_t level, QuadraticModel* model) {
    const std::size_t before = levels_[t];
    levels_[t] = level;
    ++step_;
    const SelectionTerm& term = candidates_.terms[t];
    if (IsProcess(t, before)) {
      model->SetPrior(term.ColumnsAt(before), std::numeric_limits<double>::infinity());
    }
    if (IsProcess(t, level)) model->SetPrior(term.ColumnsAt(level), variance_m2_[t]);
    if (level > before) {
      const bool spline = term.levels[level - 1].spline;
      for (std::size_t l = spline ? level : before + 1; l <= level; ++l) {
        rows_.NoteStep(t, l, step_);
      }
      if (!spline) {
        for (std::size_t l = before; l < level; ++l) model->Add(term.levels[l].columns);
        return;
      }
    } else {
      rows_.NoteStep(t, before, step_);
    }
    CHECK(model->Reset(ActiveColumns())) << "a model inside a regular one is singular";
  }

  /// False where both differ by rounding alone: then the first in the list stays.
  static bool PaysMore(const CandidateFigures& a, const CandidateFigures& b) {
    return a.delta_bic < b.delta_bic - kEqual * (1.0 + std::abs(a.delta_bic));
  }

  /// What the model with one term at another level leaves open on the nominal paths.
  Determinacy NominalWith(std::size_t t, std::size_t level, double variance_m2) const {
    Levels levels = levels_;
    levels[t] = level;
    Eigen::VectorXd weight = Eigen::VectorXd::Zero(nominal_diagonal_.size());
    for (std::size_t other = 0; other < levels.size(); ++other) {
      if (!IsProcess(other, levels[other])) continue;
      const double prior_m2 = other == t ? variance_m2 : variance_m2_[other];
      for (const int c : candidates_.terms[other].ColumnsAt(levels[other])) {
        weight[c] = 1.0 / prior_m2;
      }
    }
    return DeterminacyOf(
        nominal_s_, nominal_diagonal_, weight, effect_part_, ActiveColumns(levels));
  }

  /// The best candidate that passes, on the nominal paths too.
  Move BestCandidate(const QuadraticModel& model, const Dropped& dropped) {
    Dropped barred = dropped;
    for (;;) {
      Move best = Sweep(model, barred);
      if (!best.found) return best;
      const Determinacy nominal = NominalWith(best.term, best.level, best.figures.variance);
      if (IsAcceptable(nominal, options_.selection)) return best;
      barred.insert({best.term, best.level});
      best.figures.condition = nominal.condition;
      best.figures.effect_part = nominal.effect_part;
      rows_.Note(best.term, best.level, SelectionTest::kScore, best.figures);
    }
  }

  /// One sweep of score tests. Several degrees at once only where no single one passes: a large
  /// step early takes what smaller ones explain better.
  Move Sweep(const QuadraticModel& model, const Dropped& dropped) {
    Move single, several;
    for (std::size_t t = 0; t < candidates_.terms.size(); ++t) {
      for (std::size_t level = levels_[t] + 1; level <= candidates_.terms[t].levels.size();
           ++level) {
        const std::optional<CandidateFigures> figures = Raise(model, t, level);
        if (!figures) continue;
        if (!dropped.contains({t, level})) rows_.Note(t, level, SelectionTest::kScore, *figures);
        if (dropped.contains({t, level}) || !PassesHere(*figures)) continue;
        const bool spline = candidates_.terms[t].levels[level - 1].spline;
        Move* best = spline || level == levels_[t] + 1 ? &single : &several;
        if (!best->found || PaysMore(*figures, best->figures)) *best = {t, level, *figures, true};
      }
    }
    return single.found ? single : several;
  }

  bool PassesHere(const CandidateFigures& figures) const {
    return Passes(figures, options_.selection, candidates_.terms.size());
  }

  /// The highest degree that a term may have in place of its process, whose prior may be what
  /// holds a shift.
  std::size_t Polynomial(const QuadraticModel& model, std::size_t t) const {
    std::size_t level = candidates_.terms[t].Degrees();
    for (; level > 0; --level) {
      Levels levels = levels_;
      levels[t] = level;
      if (model.Condition(ActiveColumns(levels)) <= MaxCondition(options_.selection) &&
          IsAcceptable(NominalWith(t, level, 0.0), options_.selection)) {
        break;
      }
    }
    return level;
  }

  /// The test of the last step of a term and the level it would fall back to.
  std::pair<CandidateFigures, std::size_t> TestLast(const QuadraticModel& model,
                                                    const Eigen::MatrixXd& covariance,
                                                    std::size_t t) const {
    const SelectionTerm& term = candidates_.terms[t];
    const std::size_t now = levels_[t];
    if (!term.levels[now - 1].spline) {
      return {model.Wald(term.levels[now - 1].columns, covariance), now - 1};
    }
    if (IsProcess(t, now)) {
      const std::size_t below = Polynomial(model, t);
      const std::vector<int> polynomial = term.ColumnsAt(below);
      return {model.Process(term.ColumnsAt(now), polynomial, polynomial), below};
    }
    const std::size_t below = term.Degrees();
    if (below == 0) return {model.Wald(term.levels[now - 1].columns, covariance), 0};
    return {model.Exchange(term.ColumnsAt(below), term.ColumnsAt(now)), below};
  }

  /// The term whose last step pays least, where it no longer passes.
  Move WorstKept(const QuadraticModel& model) const {
    Move worst;
    const Eigen::MatrixXd covariance = model.Covariance();
    for (std::size_t t = 0; t < candidates_.terms.size(); ++t) {
      if (levels_[t] == 0) continue;
      const auto [figures, below] = TestLast(model, covariance, t);
      if (PassesHere(figures)) continue;
      if (!worst.found || figures.delta_bic > worst.figures.delta_bic) {
        worst = {t, below, figures, true};
      }
    }
    return worst;
  }

  /// Forward selection with backward elimination in one linearisation. True where it changed the
  /// model.
  bool ChooseSteps(QuadraticModel* model) {
    const Levels before = levels_;
    Dropped dropped;
    // The model may have become singular where it was linearised anew: leave out what is.
    if (!model->Reset(ActiveColumns())) {
      for (std::size_t t = 0; t < levels_.size(); ++t) {
        if (!IsProcess(t, levels_[t])) continue;
        model->SetPrior(candidates_.terms[t].ColumnsAt(levels_[t]),
                        std::numeric_limits<double>::infinity());
      }
      std::fill(levels_.begin(), levels_.end(), 0);
      CHECK(model->Reset({})) << "an empty model is never singular";
    }
    const bool variances = EstimateVariances(model);
    for (;;) {
      for (Move best = BestCandidate(*model, dropped); best.found;
           best = BestCandidate(*model, dropped)) {
        Enter(best, model);
      }
      bool fewer = false;
      for (Move worst = WorstKept(*model); worst.found; worst = WorstKept(*model)) {
        dropped.insert({worst.term, levels_[worst.term]});
        Apply(worst.term, worst.level, model);
        fewer = true;
      }
      if (fewer) continue;
      if (!SwapOne(dropped, model)) return variances || levels_ != before;
    }
  }

  /// The prior variances of the processes in the model, one after the other; true where one
  /// changed by more than it would matter.
  bool EstimateVariances(QuadraticModel* model) {
    bool changed = false;
    for (int sweep = 0; sweep < kVarianceSweeps; ++sweep) {
      for (std::size_t t = 0; t < levels_.size(); ++t) {
        if (!IsProcess(t, levels_[t])) continue;
        const std::vector<int> columns = candidates_.terms[t].ColumnsAt(levels_[t]);
        const double next_m2 = model->Process(columns, {}, {}).variance;
        if (!(next_m2 > 0.0)) continue;
        if (std::abs(std::log(next_m2 / variance_m2_[t])) > kSameVariance) changed = true;
        variance_m2_[t] = next_m2;
        model->SetPrior(columns, next_m2);
        CHECK(model->Reset(ActiveColumns())) << "a model inside a regular one is singular";
      }
    }
    return changed;
  }

  /// What one step leads to: the next degree and the splines.
  std::vector<std::size_t> NextLevels(std::size_t t) const {
    const SelectionTerm& term = candidates_.terms[t];
    std::vector<std::size_t> out;
    for (std::size_t level = levels_[t] + 1; level <= term.levels.size(); ++level) {
      if (level == levels_[t] + 1 || term.levels[level - 1].spline) out.push_back(level);
    }
    return out;
  }

  /// Replaces the last step of one term by the next one of another where that pays more: the order
  /// of forward steps should not decide between corrections that say nearly the same. True where
  /// it did. For all passes alike only; pass by pass there are too many pairs.
  bool SwapOne(const Dropped& dropped, QuadraticModel* model) {
    if (options_.selection.mode != SelectionOptions::Mode::kCommon) return false;
    const std::size_t terms = candidates_.terms.size();
    std::size_t out = 0;
    Move best;
    double best_gain = 0.0;
    for (std::size_t t = 0; t < terms; ++t) {
      const Levels kept = levels_;
      if (kept[t] == 0 || candidates_.terms[t].levels[kept[t] - 1].spline) continue;
      const std::vector<int>& columns = candidates_.terms[t].levels[kept[t] - 1].columns;
      --levels_[t];
      QuadraticModel less = *model;
      CHECK(less.Reset(ActiveColumns())) << "a model inside a regular one is singular";
      const CandidateFigures now = less.Score(columns);
      for (std::size_t other = 0; other < terms; ++other) {
        if (other == t) continue;
        for (const std::size_t level : NextLevels(other)) {
          const std::optional<CandidateFigures> figures = Raise(less, other, level);
          if (!figures || dropped.contains({other, level}) || !PassesHere(*figures)) continue;
          const double gain = now.delta_bic - figures->delta_bic;
          if (!PaysMore(*figures, now) || gain <= best_gain) continue;
          if (!IsAcceptable(NominalWith(other, level, figures->variance), options_.selection))
            continue;
          best = {other, level, *figures, true};
          best_gain = gain;
          out = t;
        }
      }
      levels_ = kept;
    }
    if (!best.found || ++swaps_ > kMaxSwaps) return false;
    Apply(out, levels_[out] - 1, model);
    Enter(best, model);
    return true;
  }

  /// Asks for splines where the highest degree was needed, or where the model leaves more in the
  /// residuals than the global test allows; true where that is new.
  bool WantSplines(const QuadraticModel& model) {
    bool wider = false;
    const double redundancy = model.redundancy();
    const bool misfit =
        redundancy > 0.0 &&
        model.square_sum() > ChiSquareInterval(options_.test_level, redundancy).upper;
    for (std::size_t t = 0; t < candidates_.terms.size(); ++t) {
      const SelectionTerm& term = candidates_.terms[t];
      const bool has_splines = term.Degrees() > 0 && term.levels.size() > term.Degrees();
      if (!has_splines || (levels_[t] < term.Degrees() && !misfit)) continue;
      const bool formed = std::find(spline_groups_.begin(), spline_groups_.end(), term.group) !=
                          spline_groups_.end();
      if (formed) continue;
      spline_groups_.push_back(term.group);
      wider = true;
    }
    return wider;
  }

  /// Figures of what is kept: Wald's tests at the final model.
  void TestKept(const QuadraticModel& model) {
    const Eigen::MatrixXd covariance = model.Covariance();
    for (std::size_t t = 0; t < candidates_.terms.size(); ++t) {
      if (levels_[t] == 0) continue;
      const SelectionTerm& term = candidates_.terms[t];
      rows_.Note(t, levels_[t], SelectionTest::kWald, TestLast(model, covariance, t).first);
      if (term.levels[levels_[t] - 1].spline) continue;
      for (std::size_t l = 1; l < levels_[t]; ++l) {
        rows_.Note(t, l, SelectionTest::kWald, model.Wald(term.levels[l - 1].columns, covariance));
      }
    }
  }

  /// What is not kept is not zero. Its error has the size that its prior says, or one that is
  /// estimated over all passes in which it is not kept. Left out is what the observations say
  /// nothing of beside the corrections that are kept. True where something is held.
  bool Hold(QuadraticModel* model) {
    struct Candidate {
      std::size_t term, level;
    };
    std::vector<int> active = ActiveColumns();
    std::vector<std::vector<Candidate>> sets;
    std::map<std::tuple<std::size_t, int, std::size_t>, std::size_t> set_of;
    for (std::size_t t = 0; t < candidates_.terms.size(); ++t) {
      const SelectionTerm& term = candidates_.terms[t];
      held_[t].assign(term.levels.size(), kNotGiven);
      if (levels_[t] > 0 && term.levels[levels_[t] - 1].spline) continue;
      for (std::size_t l = levels_[t] + 1; l <= std::max<std::size_t>(1, term.Degrees()); ++l) {
        const std::vector<int>& columns = term.levels[l - 1].columns;
        if (columns.empty()) break;
        const Parameter& parameter =
            candidates_.parameters[static_cast<std::size_t>(columns.front())];
        if (parameter.has_prior()) {
          held_[t][l - 1] = parameter.prior_sigma;
          active.insert(active.end(), columns.begin(), columns.end());
          continue;
        }
        const bool open = model->PartLeft(columns) < kMinPartLeft ||
                          model->Score(columns).condition > MaxCondition(options_.selection);
        if (open) break;
        const auto [at, is_new] = set_of.try_emplace({term.group, term.axis, l}, sets.size());
        if (is_new) sets.emplace_back();
        sets[at->second].push_back({t, l});
      }
    }
    if (!sets.empty()) {
      CHECK(model->Reset(active)) << "priors have made a model singular";
      std::vector<std::vector<int>> columns(sets.size());
      for (std::size_t k = 0; k < sets.size(); ++k) {
        for (const auto& [t, l] : sets[k]) {
          const std::vector<int>& more = candidates_.terms[t].levels[l - 1].columns;
          columns[k].insert(columns[k].end(), more.begin(), more.end());
        }
      }
      const std::vector<double> variance = model->MostLikelyVariances(columns);
      for (std::size_t k = 0; k < sets.size(); ++k) {
        for (const auto& [t, l] : sets[k]) held_[t][l - 1] = std::sqrt(variance[k]);
      }
    }
    bool any = false;
    for (std::size_t t = 0; t < held_.size(); ++t) {
      // A degree above one of which nothing is known has no place either.
      const auto begin =
          held_[t].begin() + static_cast<std::ptrdiff_t>(std::min(levels_[t], held_[t].size()));
      const auto end = std::find_if(begin, held_[t].end(), [](double s) { return std::isnan(s); });
      std::fill(end, held_[t].end(), kNotGiven);
      any = any || end != begin;
    }
    return any;
  }

  /// Leaves out what is held by estimated priors; true where something is.
  bool LetGo() {
    bool any = false;
    for (std::size_t t = 0; t < held_.size(); ++t) {
      for (std::size_t l = 0; l < held_[t].size(); ++l) {
        if (std::isnan(held_[t][l])) continue;
        const int column = candidates_.terms[t].levels[l].columns.front();
        if (candidates_.parameters[static_cast<std::size_t>(column)].has_prior()) continue;
        std::fill(held_[t].begin() + static_cast<std::ptrdiff_t>(l), held_[t].end(), kNotGiven);
        any = true;
      }
    }
    return any;
  }

  const Block& block_;
  const AdjustOptions& options_;
  ProgressSink* progress_;
  Weighting weighting_;
  std::unique_ptr<AdjustmentProblem> problem_;  // of the model chosen so far
  BlockState state_;                            // its solution
  Candidates candidates_;
  Levels levels_;                    // by term
  Levels solved_levels_;             // of the problem
  std::vector<double> variance_m2_;  // of the priors of processes, by term
  HeldSigmas held_;
  std::vector<std::size_t> spline_groups_;
  SelectionRows rows_;
  Eigen::MatrixXd nominal_s_;  // of all candidates, paths not corrected
  Eigen::VectorXd nominal_diagonal_;
  Eigen::VectorXd effect_part_;  // EffectParts() of the candidates
  int step_ = 0;
  int swaps_ = 0;
};

}  // namespace

SelectionReport SelectCorrections(const Block& block,
                                  const AdjustOptions& options,
                                  const AtSelection& at_selection,
                                  ProgressSink* progress) {
  Selector selector(block, options, progress);
  SelectionReport report = selector.Run();
  if (at_selection) at_selection(selector.problem(), selector.state(), &report);
  return report;
}

}  // namespace sarblock
