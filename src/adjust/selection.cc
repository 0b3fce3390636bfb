// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/selection.h"

#include "sarblock/adjust/reduced_engine.h"
#include "sarblock/adjust/reduced_system.h"
#include "sarblock/adjust/simplifications.h"
#include "sarblock/adjust/start_values.h"
#include "sarblock/core/error.h"
#include "sarblock/core/parallel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "quadratic_model.h"
#include "selection_rows.h"
#include "selection_terms.h"
#include "solution.h"
#include <glog/logging.h>

namespace sarblock {
namespace {

/// Linearisations after which a selection that still changes its mind is taken as it is.
constexpr int kMostRounds = 8;
/// Swaps in one selection after which there are no more.
constexpr int kMostSwaps = 100;
/// Relative difference of information criteria below which two candidates are one.
constexpr double kEqual_1 = 1e-6;

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
    while (report.rounds < kMostRounds && !report.settled) {
      ++report.rounds;
      Step(progress_, "select", static_cast<std::size_t>(report.rounds), kMostRounds);
      candidates_ = MakeCandidates(*problem_, options_, spline_groups_);
      levels_.resize(candidates_.terms.size(), 0);
      QuadraticModel model = Linearise();
      const bool changed = ChooseSteps(&model);
      const bool wider = WantSplines();
      if (changed) Refit();
      report.settled = !changed && !wider;
      if (report.settled || report.rounds == kMostRounds) TestKept(model);
    }
    report.steps = step_;
    report.candidates = rows_.Finish(candidates_, levels_, options_.selection);
    report.groups = GroupsOf(block_, candidates_, levels_);
    return report;
  }

 private:
  using Levels = std::vector<std::size_t>;
  using Dropped = std::set<std::pair<std::size_t, std::size_t>>;  // term and level

  /// The block without corrections.
  void Start() {
    problem_ = std::make_unique<AdjustmentProblem>(block_, std::vector<CorrectionGroup>{});
    state_ = std::move(ComputeStartValues(problem_.get(), progress_).state);
    RequireSolvable(*problem_);
    Solve();
    // The adjustment that follows starts such points again; the choice does without them.
    std::optional<ReducedSystem> system;
    for (const std::size_t point : LostPoints(*problem_, state_, &system, progress_)) {
      if (problem_->control_of[point] >= 0) continue;
      problem_->LeaveOut(point, PointStatus::kUndetermined, "lost while corrections were chosen");
    }
    RequireSolvable(*problem_);
  }

  void Solve() {
    SolveOptions solve;
    solve.max_iterations = options_.max_iterations;
    solve.threads = options_.threads;
    static_cast<void>(SolveReduced(*problem_, weighting_, solve, &state_, progress_));
    UpdateWhitening(state_, problem_.get());
  }

  static std::string KeyOf(const Parameter& parameter) {
    return parameter.owner + "\n" + parameter.name;
  }

  /// Carries what takes part, and with which weights, from one problem to another.
  static void Adopt(const AdjustmentProblem& from, AdjustmentProblem* to) {
    to->look_used = from.look_used;
    to->point_status = from.point_status;
    to->point_reason = from.point_reason;
    to->whitening = from.whitening;
  }

  std::vector<int> ActiveColumns() const {
    std::vector<int> active;
    for (std::size_t t = 0; t < levels_.size(); ++t) {
      const std::vector<int> columns = candidates_.terms[t].ColumnsAt(levels_[t]);
      active.insert(active.end(), columns.begin(), columns.end());
    }
    return active;
  }

  /// Logarithm of the number of equations of looks that touch each column.
  static Eigen::VectorXd LogCounts(const AdjustmentProblem& problem) {
    std::vector<double> equations(problem.layout.blocks.size(), 0.0);
    LookColumns columns;
    for (std::size_t i = 0; i < problem.look_used.size(); ++i) {
      if (problem.look_used[i] == 0) continue;
      problem.model.ColumnsOf(i, &columns);
      for (int b = 0; b < columns.block_count; ++b) {
        equations[static_cast<std::size_t>(columns.block[static_cast<std::size_t>(b)])] += 2.0;
      }
    }
    Eigen::VectorXd out(problem.layout.size());
    for (std::size_t b = 0; b < equations.size(); ++b) {
      const ParameterBlock& block = problem.layout.blocks[b];
      out.segment(block.offset, block.size).setConstant(std::log(std::max(2.0, equations[b])));
    }
    return out;
  }

  /// All candidates in one system at the present solution.
  QuadraticModel Linearise() {
    AdjustmentProblem extended(block_, candidates_.extended);
    if (extended.layout.size() > kMostCandidateColumns) {
      throw InputError("adjust.selection",
                       std::to_string(extended.layout.size()) + " candidate parameters, at most " +
                           std::to_string(kMostCandidateColumns) +
                           " are allowed; name fewer candidates, degrees or knots");
    }
    Adopt(*problem_, &extended);
    BlockState state = state_;
    state.corrections = Eigen::VectorXd::Zero(extended.layout.size());
    std::map<std::string, double> value_of;
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

    QuadraticModel::Data data;
    data.s = system->matrix().ToDense();
    const Eigen::VectorXd& x = state.corrections;
    const Eigen::VectorXd sx = data.s * x;
    data.b = sx - system->right_side();
    data.constant_1 = 2.0 * system->cost() - system->point_step_square() -
                      2.0 * system->right_side().dot(x) + sx.dot(x);
    data.full_diagonal = system->full_diagonal();
    data.prior_weight.setZero(x.size());
    data.log_count = LogCounts(extended);
    const ProblemCounts counts = CountProblem(*problem_);
    data.redundancy_1 =
        static_cast<double>(counts.observations) - static_cast<double>(counts.parameters);
    for (const Parameter& parameter : problem_->layout.parameters) {
      if (!parameter.has_prior()) data.redundancy_1 += 1.0;
    }
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      const Parameter& parameter = candidates_.parameters[static_cast<std::size_t>(i)];
      if (parameter.has_prior()) {
        data.prior_weight[i] = 1.0 / (parameter.prior_sigma * parameter.prior_sigma);
      }
    }
    return QuadraticModel(std::move(data));
  }

  /// Solves the block with the model chosen, from the former solution.
  void Refit() {
    auto next = std::make_unique<AdjustmentProblem>(block_, GroupsOf(block_, candidates_, levels_));
    Adopt(*problem_, next.get());
    std::map<std::string, double> value_of;
    for (int i = 0; i < problem_->layout.size(); ++i) {
      value_of[KeyOf(problem_->layout.parameters[static_cast<std::size_t>(i)])] =
          state_.corrections[i];
    }
    state_.corrections = Eigen::VectorXd::Zero(next->layout.size());
    for (int i = 0; i < next->layout.size(); ++i) {
      const auto found = value_of.find(KeyOf(next->layout.parameters[static_cast<std::size_t>(i)]));
      if (found != value_of.end()) state_.corrections[i] = found->second;
    }
    problem_ = std::move(next);
    Solve();
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

  void Apply(std::size_t t, std::size_t level, QuadraticModel* model) {
    const std::size_t before = levels_[t];
    levels_[t] = level;
    ++step_;
    const SelectionTerm& term = candidates_.terms[t];
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

  /// Of two that say the same the first in the list: the difference is rounding.
  static bool PaysMore(const CandidateFigures& a, const CandidateFigures& b) {
    return a.delta_bic_1 < b.delta_bic_1 - kEqual_1 * (1.0 + std::abs(a.delta_bic_1));
  }

  /// Condition of a model on the nominal paths, scaled as CandidateFigures::condition_1.
  double NominalCondition(const std::vector<int>& active) const {
    if (active.empty()) return 1.0;
    const Eigen::VectorXd scale = nominal_diagonal_(active).cwiseSqrt().cwiseInverse();
    if (!scale.allFinite()) return std::numeric_limits<double>::infinity();
    return ConditionOf(scale.asDiagonal() * Eigen::MatrixXd(nominal_s_(active, active)) *
                       scale.asDiagonal());
  }

  /// The same with one term at another level.
  double NominalConditionWith(std::size_t t, std::size_t level) {
    const std::size_t now = levels_[t];
    levels_[t] = level;
    const double condition_1 = NominalCondition(ActiveColumns());
    levels_[t] = now;
    return condition_1;
  }

  /// The best candidate that passes, on the nominal paths too.
  Move BestCandidate(const QuadraticModel& model, const Dropped& dropped) {
    Dropped barred = dropped;
    for (;;) {
      Move best = Sweep(model, barred);
      if (!best.found) return best;
      const double condition_1 = NominalConditionWith(best.term, best.level);
      if (condition_1 <= options_.selection.max_condition_1) return best;
      barred.insert({best.term, best.level});
      best.figures.condition_1 = condition_1;
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

  /// The test of the last step of a term and the level it would fall back to.
  std::pair<CandidateFigures, std::size_t> TestLast(const QuadraticModel& model,
                                                    const Eigen::MatrixXd& covariance,
                                                    std::size_t t) const {
    const SelectionTerm& term = candidates_.terms[t];
    const std::size_t now = levels_[t];
    if (!term.levels[now - 1].spline) {
      return {model.Wald(term.levels[now - 1].columns, covariance), now - 1};
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
      if (!worst.found || figures.delta_bic_1 > worst.figures.delta_bic_1) {
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
      std::fill(levels_.begin(), levels_.end(), 0);
      CHECK(model->Reset({})) << "an empty model is never singular";
    }
    for (;;) {
      for (Move best = BestCandidate(*model, dropped); best.found;
           best = BestCandidate(*model, dropped)) {
        Apply(best.term, best.level, model);
      }
      bool fewer = false;
      for (Move worst = WorstKept(*model); worst.found; worst = WorstKept(*model)) {
        dropped.insert({worst.term, levels_[worst.term]});
        Apply(worst.term, worst.level, model);
        fewer = true;
      }
      if (fewer) continue;
      if (!SwapOne(dropped, model)) return levels_ != before;
    }
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
    double best_gain_1 = 0.0;
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
          const double gain_1 = now.delta_bic_1 - figures->delta_bic_1;
          if (!PaysMore(*figures, now) || gain_1 <= best_gain_1) continue;
          if (NominalConditionWith(other, level) > options_.selection.max_condition_1) continue;
          best = {other, level, *figures, true};
          best_gain_1 = gain_1;
          out = t;
        }
      }
      levels_ = kept;
    }
    if (!best.found || ++swaps_ > kMostSwaps) return false;
    Apply(out, levels_[out] - 1, model);
    Apply(best.term, best.level, model);
    return true;
  }

  /// Asks for splines where the highest degree was needed; true where that is new.
  bool WantSplines() {
    bool wider = false;
    for (std::size_t t = 0; t < candidates_.terms.size(); ++t) {
      const SelectionTerm& term = candidates_.terms[t];
      const bool has_splines = term.Degrees() > 0 && term.levels.size() > term.Degrees();
      if (!has_splines || levels_[t] < term.Degrees()) continue;
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

  const Block& block_;
  const AdjustOptions& options_;
  ProgressSink* progress_;
  Weighting weighting_;
  std::unique_ptr<AdjustmentProblem> problem_;  // of the model chosen so far
  BlockState state_;                            // its solution
  Candidates candidates_;
  Levels levels_;  // by term
  std::vector<std::size_t> spline_groups_;
  SelectionRows rows_;
  Eigen::MatrixXd nominal_s_;  // of all candidates, paths not corrected
  Eigen::VectorXd nominal_diagonal_;
  int step_ = 0;
  int swaps_ = 0;
};

}  // namespace

SelectionReport SelectCorrections(const Block& block,
                                  const AdjustOptions& options,
                                  ProgressSink* progress) {
  const ThreadLimit limit(options.threads);
  return Selector(block, options, progress).Run();
}

AdjustResult AdjustSelected(const Block& block,
                            const AdjustOptions& options,
                            const PointPairs& pairs,
                            ProgressSink* progress) {
  std::vector<StageCost> stages;
  SelectionReport report;
  {
    const StageTimer timer("select", &stages);
    report = SelectCorrections(block, options, progress);
  }
  AdjustOptions chosen = options;
  chosen.corrections = report.groups.empty() ? CorrectionChoice::kNone : CorrectionChoice::kGiven;
  chosen.groups = report.groups;
  AdjustResult result = Adjust(block, chosen, pairs, progress);
  result.stages.insert(result.stages.begin(), stages.begin(), stages.end());
  for (ParameterResult& parameter : result.parameters) {
    parameter.kept = KeptText(report, parameter.owner, parameter.name);
  }
  if (!report.settled) {
    Warn(&result,
         "the choice of corrections still changed after " + std::to_string(report.rounds) +
             " rounds");
  }
  report.simplifications = BoundSimplifications(block, result, options.selection.simplify_1);
  result.selection = std::move(report);
  return result;
}

}  // namespace sarblock
