// SPDX-License-Identifier: Apache-2.0
#include "shifted_group.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "blunder_search.h"
#include "core/threads.h"
#include "model/problem.h"
#include "normals/point.h"
#include "solve/rank.h"
#include "solve/solve_block.h"
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace sarblock {
namespace {

/// Chance that a group is found where there is none, or that of another pass is taken for it.
constexpr double kChanceOfGroup = 1e-4;
/// Points that fit a shift below which there is no group.
constexpr std::size_t kMinGroup = 4;
/// Probability of v'Pv with which the looks of a point fit.
constexpr double kFits = 0.9999;
/// Shifts of single points that are tried for all, and passes that the block is solved for.
constexpr std::size_t kMaxProposals = 200, kMaxHypotheses = 4;
constexpr int kMaxRoundsOfGroup = 8;
/// Factors on the limits in the first rounds, while paths are still bent by what was wrongly kept.
constexpr std::array<double, 2> kSlack{9.0, 3.0};
/// Redundancy below which an error of a look does not show.
constexpr double kShowsNothing = 1e-3;
/// A shift has settled when its step is at most this part of its standard deviation.
constexpr double kShiftSettled = 0.1;
constexpr std::size_t kGroupPointsPerChunk = 256;
constexpr std::size_t kNoLook = std::numeric_limits<std::size_t>::max();

/// Limit of v'Pv of a point by its redundancy; none of a point without.
class Limits {
 public:
  Limits() {
    for (std::size_t f = 1; f < values_.size(); ++f) {
      values_[f] = ChiSquareQuantile(kFits, static_cast<double>(f));
    }
  }
  [[nodiscard]] double Of(int redundancy) const {
    if (redundancy <= 0) return std::numeric_limits<double>::infinity();
    const auto f = static_cast<std::size_t>(redundancy);
    return f < values_.size() ? values_[f]
                              : ChiSquareQuantile(kFits, static_cast<double>(redundancy));
  }

 private:
  std::array<double, 64> values_{};
};

/// v'Pv of one point as a function of a shift s of one of its looks, corrections fixed:
///     cost(s) = cost + 2 g's + s'M s,   g = D'(I - Q Q')e,  M = D'(I - Q Q')D
/// D the look's rows by s: its weights, since e is predicted less measured less the shift.
struct ShiftTerms {
  double cost = 0.0;
  Eigen::Vector2d g = Eigen::Vector2d::Zero();
  Eigen::Matrix2d m = Eigen::Matrix2d::Zero();
  /// What of an error of the look in range and time shows.
  Eigen::Matrix2d redundancy = Eigen::Matrix2d::Zero();
  Eigen::Vector2d weight = Eigen::Vector2d::Zero();

  [[nodiscard]] double CostAt(const Eigen::Vector2d& s) const {
    return cost + 2.0 * g.dot(s) + s.dot(m * s);
  }
  /// The shift that the point alone asks for, along what it shows of one.
  [[nodiscard]] Eigen::Vector2d Own() const {
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen;
    eigen.computeDirect(redundancy);
    Eigen::Vector2d s = Eigen::Vector2d::Zero();
    const Eigen::Vector2d whitened(weight[0] > 0.0 ? g[0] / weight[0] : 0.0,
                                   weight[1] > 0.0 ? g[1] / weight[1] : 0.0);
    for (Eigen::Index k = 0; k < 2; ++k) {
      if (!(eigen.eigenvalues()[k] > kShowsNothing)) continue;
      const Eigen::Vector2d axis = eigen.eigenvectors().col(k);
      s -= axis * (axis.dot(whitened) / eigen.eigenvalues()[k]);
    }
    for (Eigen::Index k = 0; k < 2; ++k) s[k] = weight[k] > 0.0 ? s[k] / weight[k] : 0.0;
    return s;
  }
};

ShiftTerms TermsOf(const AdjustmentProblem& problem, const PointFactor& factor, std::size_t look) {
  ShiftTerms out;
  out.cost = 2.0 * factor.cost;
  const Eigen::Vector3d c = Project(factor, factor.e);
  for (int k = 0; k < factor.look_count; ++k) {
    if (factor.looks[static_cast<std::size_t>(k)].look != look) continue;
    const LookWeights& weight = problem.weights[look];
    // The time of a measured Doppler is exact.
    out.weight = {weight.range_per_m,
                  problem.block.MeasuresDoppler(look) ? 0.0 : weight.azimuth_per_unit};
    Eigen::Matrix<double, 2, 3> q;
    Eigen::Vector2d e;
    for (int row = 0; row < 2; ++row) {
      q.row(row) = factor.RowOfQ(2 * k + row);
      e[row] = factor.e[static_cast<std::size_t>(2 * k + row)];
    }
    out.redundancy = Eigen::Matrix2d::Identity() - q * q.transpose();
    const Eigen::Vector2d rest = e - q * c;
    out.g = out.weight.cwiseProduct(rest);
    out.m = out.weight.asDiagonal() * out.redundancy * out.weight.asDiagonal();
  }
  return out;
}

/// -M^-1 g of sums over points; a component that nothing shows stays.
Eigen::Vector2d StepOf(const Eigen::Vector2d& g, Eigen::Matrix2d m) {
  for (Eigen::Index k = 0; k < 2; ++k) {
    if (!(m(k, k) > 0.0)) m(k, k) = 1.0;
  }
  return -(m.inverse() * g);
}

/// What takes part where nothing was left out: what does now, and the looks that were lost.
struct Everything {
  std::vector<std::uint8_t> look_used;
  std::vector<PointStatus> point_status;
  std::vector<std::string> point_reason;
  std::vector<std::size_t> lost_points;  ///< ascending

  Everything(const AdjustmentProblem& problem, const std::vector<std::uint64_t>& lost)
      : look_used(problem.look_used),
        point_status(problem.point_status),
        point_reason(problem.point_reason) {
    const Looks& looks = problem.block.looks;
    for (const std::uint64_t look : lost) {
      const std::size_t point = looks.PointOf(look);
      if (problem.mirrored[point] == 0) lost_points.push_back(point);
      if (problem.mirrored[point] == 0 && !looks.rejected(look)) look_used[look] = 1;
    }
    for (std::size_t point = 0; point < point_status.size(); ++point) {
      if (point_status[point] == PointStatus::kApart) lost_points.push_back(point);
    }
    std::sort(lost_points.begin(), lost_points.end());
    lost_points.erase(std::unique(lost_points.begin(), lost_points.end()), lost_points.end());
    for (const std::size_t point : lost_points) {
      if (IsSolved(point_status[point])) continue;
      point_status[point] = PointStatus::kAdjusted;
      point_reason[point].clear();
      for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
        look_used[i] = looks.rejected(i) ? 0 : 1;
      }
    }
  }
  void Apply(AdjustmentProblem* problem) const {
    problem->look_used = look_used;
    problem->point_status = point_status;
    problem->point_reason = point_reason;
  }
};

std::size_t LookOfPass(const Block& block, std::size_t point, std::uint32_t pass) {
  for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
    if (block.looks.pass[i] == pass && !block.looks.rejected(i)) return i;
  }
  return kNoLook;
}

/// 2 ln of the odds against a look's being of a group that has this part of the looks of its pass,
/// half of them at most.
double OddsAgainst(double part) {
  const double p = std::min(part, 0.5);
  return 2.0 * std::log((1.0 - p) / p);
}

/// What the best of so many shifts gains by chance: each was made to fit one point, whose limit it
/// saves.
double GainByChance(std::size_t tried, double limit) {
  return 2.0 * std::log(static_cast<double>(tried) / kChanceOfGroup) + limit;
}

/// A pass that may be the one, with the shift that explains most at the present solution.
struct ShiftProposal {
  std::uint32_t pass = 0;
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  double gain = 0.0;
  std::size_t tried = 0;
  std::size_t members = 0;
};

/// The block under one hypothesis.
class GroupHypothesis {
 public:
  GroupHypothesis(const AdjustmentProblem& problem,
                  const BlockState& state,
                  const Everything& all,
                  double variance,
                  std::optional<ShiftProposal> proposal)
      : all_(all),
        variance_(variance),
        proposal_(std::move(proposal)),
        measured_(problem.block),
        block_(problem.block),
        problem_(block_, problem),
        state_(state),
        fits_(problem.block.points.size()) {
    all.Apply(&problem_);
    problem_.mirrored = problem.mirrored;
    problem_.weights = problem.weights;
    problem_.control_of = problem.control_of;
    problem_.fixed = problem.fixed;
    problem_.model.AnchorLike(problem.model);
    UpdateWeights(state_, &problem_);
    if (proposal_) shift_ = proposal_->shift;
  }

  /// False where the block has no solution this way.
  bool Solve(const AdjustOptions& options, ProgressSink* progress) {
    if (proposal_) {
      const auto given = static_cast<double>(CountLooksOfPass());
      part_ = std::clamp(static_cast<double>(proposal_->members) / given, 1.0 / given, 0.5);
    }
    bool settled = false;
    for (int round = 0; round < kMaxRoundsOfGroup && !settled; ++round) {
      const auto k = static_cast<std::size_t>(round);
      const bool changed = Choose(k < kSlack.size() ? kSlack[k] : 1.0);
      RequireSolvable(problem_);
      SolveReport solve;
      std::optional<ReducedSystem> system;
      SolveOnce(options, &problem_, &state_, &solve, &system, progress);
      if (!solve.converged || !system) return false;
      square_sum_ = 2.0 * system->cost() / variance_;
      settled = MoveShift() && !changed && k >= kSlack.size();
    }
    return Judge();
  }

  [[nodiscard]] double score() const { return score_; }
  [[nodiscard]] const std::vector<std::uint64_t>& group() const { return group_; }
  [[nodiscard]] const BlockState& state() const { return state_; }
  /// The shift of a look of the group in its standard deviations, range and time.
  [[nodiscard]] Eigen::Vector2d ShiftInSigmas(std::size_t look) const {
    const LookWeights& weight = problem_.weights[look];
    return {shift_[0] * weight.range_per_m, shift_[1] * weight.azimuth_per_unit};
  }
  /// Points of the pass that fit neither way.
  [[nodiscard]] std::size_t unexplained() const { return unexplained_; }
  [[nodiscard]] std::size_t others() const { return others_; }
  /// Limit of a point with one redundant observation.
  [[nodiscard]] double LimitOfOne() const { return limits_.Of(1); }

 private:
  enum class Choice : std::uint8_t { kNone, kRight, kShifted };
  struct Fit {
    bool known = false;
    std::size_t look = kNoLook;
    double limit = 0.0;
    double right = 0.0, shifted = 0.0;  ///< v'Pv over the variance factor
    Eigen::Vector3d right_m = Eigen::Vector3d::Zero(), shifted_m = Eigen::Vector3d::Zero();
    ShiftTerms terms;  ///< at the shifted look
    Choice choice = Choice::kNone;
    /// -2 ln of the likelihood of the point, its look right or not.
    [[nodiscard]] double Score(double part) const {
      if (look == kNoLook) return right;
      const double least = std::min(right, shifted);
      return least - 2.0 * std::log((1.0 - part) * std::exp(0.5 * (least - right)) +
                                    part * std::exp(0.5 * (least - shifted)));
    }
  };

  [[nodiscard]] std::size_t CountLooksOfPass() const {
    const std::vector<std::uint32_t>& pass = block_.looks.pass;
    return static_cast<std::size_t>(
        std::max<std::ptrdiff_t>(2, std::count(pass.begin(), pass.end(), proposal_->pass)));
  }
  void SetLook(std::size_t look, bool shifted) {
    const Eigen::Vector2d s = shifted ? shift_ : Eigen::Vector2d::Zero().eval();
    block_.looks.range_m[look] = measured_.looks.range_m[look] - s[0];
    block_.looks.time_s[look] = measured_.looks.time_s[look] - s[1];
  }
  /// v'Pv at the place of the point's own; negative where a look has no value.
  double SettledCost(std::size_t point, PointFactor* factor) {
    FactorPoint(problem_, state_, {}, 0.0, point, factor);
    static_cast<void>(SettlePoint(problem_, {}, 0.0, 1e-3, point, &state_, factor));
    return factor->looks_not_evaluated > 0 ? -1.0 : 2.0 * factor->cost / variance_;
  }
  void EvaluatePoint(std::size_t point, PointFactor* factor) {
    Fit& fit = fits_[point];
    fit = {};
    if (!IsSolved(all_.point_status[point])) return;
    const std::size_t begin = block_.looks.offsets[point], end = block_.looks.offsets[point + 1];
    for (std::size_t i = begin; i < end; ++i) problem_.look_used[i] = all_.look_used[i];
    if (proposal_) {
      const std::size_t look = LookOfPass(block_, point, proposal_->pass);
      if (look != kNoLook && all_.look_used[look] != 0) fit.look = look;
    }
    if (fit.look != kNoLook) {
      SetLook(fit.look, true);
      fit.shifted = SettledCost(point, factor);
      if (fit.shifted < 0.0) return;
      fit.terms = TermsOf(problem_, *factor, fit.look);
      fit.shifted_m = state_.displacement_m[point];
      SetLook(fit.look, false);
    }
    fit.right = SettledCost(point, factor);
    if (fit.right < 0.0) return;
    fit.right_m = state_.displacement_m[point];
    fit.limit = limits_.Of(factor->row_count - 3);
    fit.known = true;
  }
  void Evaluate() {
    const auto work = [&](std::size_t, std::size_t begin, std::size_t end) {
      PointFactor factor;
      for (std::size_t point = begin; point < end; ++point) EvaluatePoint(point, &factor);
    };
    ParallelForChunks(block_.points.size(), kGroupPointsPerChunk, work);
  }
  /// Which looks are of the group and which points take part; whether that changed.
  bool Choose(double slack) {
    std::vector<Choice> before(fits_.size());
    for (std::size_t point = 0; point < fits_.size(); ++point) before[point] = fits_[point].choice;
    Evaluate();
    const double odds = OddsAgainst(part_);
    std::size_t members = 0, others = 0;
    bool changed = false;
    for (std::size_t point = 0; point < fits_.size(); ++point) {
      Fit& fit = fits_[point];
      if (fit.known) {
        const bool shifted = fit.look != kNoLook && fit.shifted + odds < fit.right;
        const double cost = shifted ? fit.shifted : fit.right;
        fit.choice = !(cost <= slack * fit.limit) ? Choice::kNone
                     : shifted                    ? Choice::kShifted
                                                  : Choice::kRight;
        if (fit.look != kNoLook && fit.choice != Choice::kNone) ++(shifted ? members : others);
      }
      Take(point);
      changed = changed || fit.choice != before[point];
    }
    if (proposal_) {
      const double count = static_cast<double>(members + others);
      part_ =
          std::clamp(static_cast<double>(members) / std::max(count, 1.0), 1.0 / (count + 2.0), 0.5);
    }
    return changed;
  }
  void Take(std::size_t point) {
    const Fit& fit = fits_[point];
    const std::size_t begin = block_.looks.offsets[point], end = block_.looks.offsets[point + 1];
    if (fit.choice == Choice::kNone) {
      if (IsSolved(problem_.point_status[point])) {
        problem_.LeaveOut(point, PointStatus::kApart, "fits neither way");
      }
      return;
    }
    for (std::size_t i = begin; i < end; ++i) problem_.look_used[i] = all_.look_used[i];
    problem_.point_status[point] = all_.point_status[point];
    problem_.point_reason[point].clear();
    const bool shifted = fit.choice == Choice::kShifted;
    if (fit.look != kNoLook) SetLook(fit.look, shifted);
    state_.displacement_m[point] = shifted ? fit.shifted_m : fit.right_m;
  }
  /// The shift with the corrections that were found; true where it is settled.
  bool MoveShift() {
    if (!proposal_) return true;
    Eigen::Vector2d g = Eigen::Vector2d::Zero();
    Eigen::Matrix2d m = Eigen::Matrix2d::Zero();
    PointFactor factor;
    for (std::size_t point = 0; point < fits_.size(); ++point) {
      if (fits_[point].choice != Choice::kShifted || !problem_.Solves(point)) continue;
      FactorPoint(problem_, state_, {}, 0.0, point, &factor);
      const ShiftTerms terms = TermsOf(problem_, factor, fits_[point].look);
      g += terms.g;
      m += terms.m;
    }
    const Eigen::Vector2d step = StepOf(g, m);
    shift_ += step;
    return step.dot(m * step) <= kShiftSettled * kShiftSettled;
  }
  /// The score at the solution, and the group.
  bool Judge() {
    double used = 0.0;
    PointFactor factor;
    for (std::size_t point = 0; point < fits_.size(); ++point) {
      if (!problem_.Solves(point)) continue;
      FactorPoint(problem_, state_, {}, 0.0, point, &factor);
      used += 2.0 * factor.cost / variance_;
    }
    score_ = square_sum_ - used;  // what the priors cost
    static_cast<void>(Choose(1.0));
    for (std::size_t point = 0; point < fits_.size(); ++point) {
      const Fit& fit = fits_[point];
      if (!fit.known) continue;
      score_ += std::min(fit.Score(part_), fit.limit);
      if (fit.look == kNoLook) continue;
      if (fit.choice == Choice::kShifted) group_.push_back(fit.look);
      others_ += fit.choice == Choice::kRight ? 1U : 0U;
      unexplained_ += fit.choice == Choice::kNone ? 1U : 0U;
    }
    return std::isfinite(score_);
  }

  const Everything& all_;
  double variance_;
  std::optional<ShiftProposal> proposal_;
  const Block& measured_;
  Block block_;
  AdjustmentProblem problem_;
  BlockState state_;
  Limits limits_;
  std::vector<Fit> fits_;
  Eigen::Vector2d shift_ = Eigen::Vector2d::Zero();
  double part_ = 0.5;
  double square_sum_ = 0.0, score_ = 0.0;
  std::vector<std::uint64_t> group_;
  std::size_t unexplained_ = 0, others_ = 0;
};

/// Passes whose looks, shifted, explain points that lost looks, on the paths as they are; the one
/// that explains most first.
std::vector<ShiftProposal> ProposeShifts(const AdjustmentProblem& problem,
                                         const BlockState& state,
                                         const Everything& all,
                                         double variance) {
  struct Known {
    ShiftTerms terms;
    double limit = 0.0;
  };
  std::map<std::uint32_t, std::vector<Known>> by_pass;
  const Limits limits;
  AdjustmentProblem trial(problem.block, problem);
  all.Apply(&trial);
  trial.weights = problem.weights;
  trial.control_of = problem.control_of;
  trial.model.AnchorLike(problem.model);
  BlockState at = state;
  UpdateWeights(at, &trial);
  const Looks& looks = problem.block.looks;
  PointFactor factor;
  for (const std::size_t point : all.lost_points) {
    FactorPoint(trial, at, {}, 0.0, point, &factor);
    static_cast<void>(SettlePoint(trial, {}, 0.0, 1e-3, point, &at, &factor));
    if (factor.looks_not_evaluated > 0) continue;
    const double limit = limits.Of(factor.row_count - 3);
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      if (trial.look_used[i] == 0) continue;
      Known known{TermsOf(trial, factor, i), limit};
      known.terms.cost /= variance;
      known.terms.g /= variance;
      known.terms.m /= variance;
      by_pass[looks.pass[i]].push_back(known);
    }
  }
  std::vector<ShiftProposal> out;
  for (const auto& of_pass : by_pass) {
    const std::uint32_t pass = of_pass.first;
    const std::vector<Known>& points = of_pass.second;
    if (points.size() < kMinGroup) continue;
    // Paths are still bent, so a remaining misfit of a point does not count against the shift.
    const auto gain_of = [&](const Known& known, const Eigen::Vector2d& s) {
      const double left = known.terms.CostAt(s), most = kSlack[0] * known.limit;
      return left > most ? 0.0 : std::max(0.0, std::min(known.terms.cost, most) - left);
    };
    const auto given = static_cast<double>(std::count(looks.pass.begin(), looks.pass.end(), pass));
    ShiftProposal best;
    best.pass = pass;
    const auto try_shift = [&](const Eigen::Vector2d& s) {
      std::size_t members = 0;
      for (const Known& known : points) members += gain_of(known, s) > 0.0 ? 1U : 0U;
      if (members < kMinGroup) return false;
      const double odds = OddsAgainst(static_cast<double>(members) / given);
      double gain = 0.0;
      for (const Known& known : points) gain += std::max(0.0, gain_of(known, s) - odds);
      if (gain <= best.gain) return false;
      best.gain = gain;
      best.shift = s;
      best.members = members;
      return true;
    };
    const std::size_t step = std::max<std::size_t>(1, points.size() / kMaxProposals);
    for (std::size_t k = 0; k < points.size(); k += step, ++best.tried) {
      static_cast<void>(try_shift(points[k].terms.Own()));
    }
    for (int refinement = 0; refinement < 3; ++refinement) {
      Eigen::Vector2d g = Eigen::Vector2d::Zero();
      Eigen::Matrix2d m = Eigen::Matrix2d::Zero();
      for (const Known& known : points) {
        if (!(gain_of(known, best.shift) > 0.0)) continue;
        g += known.terms.g;
        m += known.terms.m;
      }
      if (!try_shift(StepOf(g, m))) break;
    }
    if (best.gain > GainByChance(best.tried, limits.Of(1))) out.push_back(best);
  }
  std::stable_sort(
      out.begin(), out.end(), [](const auto& a, const auto& b) { return a.gain > b.gain; });
  if (out.size() > kMaxHypotheses) out.resize(kMaxHypotheses);
  return out;
}

/// The group of the hypothesis that chance does not explain, solved; nothing where there is none.
std::unique_ptr<GroupHypothesis> ChooseGroup(const AdjustOptions& options,
                                             const Everything& all,
                                             const Solution& solution,
                                             ProgressSink* progress) {
  const AdjustmentProblem& problem = *solution.problem;
  const double redundancy = CountProblem(problem).redundancy();
  if (!(redundancy > 0.0) || !*solution.system) return nullptr;
  const double variance = std::max(1.0, 2.0 * (*solution.system)->cost() / redundancy);
  const std::vector<ShiftProposal> proposals =
      ProposeShifts(problem, *solution.state, all, variance);
  if (proposals.empty()) return nullptr;
  const auto solve = [&](const std::optional<ShiftProposal>& proposal) {
    auto out = std::make_unique<GroupHypothesis>(problem, *solution.state, all, variance, proposal);
    try {
      if (!out->Solve(options, progress)) out.reset();
    } catch (const UndeterminedError&) {
      out.reset();
    }
    return out;
  };
  const std::unique_ptr<GroupHypothesis> none = solve(std::nullopt);
  if (!none) return nullptr;
  std::unique_ptr<GroupHypothesis> best;
  double next = std::numeric_limits<double>::infinity();
  std::size_t tried = 0;
  for (const ShiftProposal& proposal : proposals) {
    std::unique_ptr<GroupHypothesis> here = solve(proposal);
    tried += proposal.tried;
    if (!here) return nullptr;  // it might be the one
    if (best && best->score() <= here->score()) {
      next = std::min(next, here->score());
      continue;
    }
    if (best) next = std::min(next, best->score());
    best = std::move(here);
  }
  const auto passes = static_cast<double>(problem.block.passes.size());
  const double of_another = 2.0 * std::log(passes / kChanceOfGroup);
  const double of_none = GainByChance(tried, best->LimitOfOne());
  const bool decided = none->score() - best->score() > of_none &&
                       next - best->score() > of_another && best->group().size() >= kMinGroup &&
                       best->group().size() > best->unexplained() &&
                       best->group().size() < best->others();
  return decided ? std::move(best) : nullptr;
}

/// Points of which too little is left.
void LeaveOutPointsOfGroup(const std::vector<std::uint64_t>& group, AdjustmentProblem* problem) {
  for (const std::uint64_t look : group) {
    const std::size_t point = problem->block.looks.PointOf(look);
    if (!problem->Solves(point)) continue;
    const std::optional<PointStatus> lacks = problem->LacksEquations(point);
    if (!lacks) continue;
    problem->LeaveOut(point,
                      *lacks,
                      "too few looks were left: that of pass " +
                          problem->block.passes[problem->block.looks.pass[look]].id +
                          " is off like others of the pass");
  }
}

}  // namespace

std::vector<std::uint64_t> LooksLeftOut(const SnoopingReport& report) {
  std::vector<std::uint64_t> out = report.robust;
  for (const BlunderFinding& finding : report.findings) {
    if (LeavesOut(finding)) out.insert(out.end(), finding.looks.begin(), finding.looks.end());
  }
  return out;
}

std::optional<SnoopingReport> SearchShiftedGroup(const AdjustOptions& asked,
                                                 const std::vector<std::uint64_t>& lost,
                                                 const Solution& solution,
                                                 ProgressSink* progress) {
  if (lost.size() < kMinGroup) return std::nullopt;
  AdjustmentProblem* problem = solution.problem;
  AdjustOptions options = asked;
  options.robust = RobustLoss::kNone;
  const Everything all(*problem, lost);
  const std::unique_ptr<GroupHypothesis> found = ChooseGroup(options, all, solution, progress);
  if (!found) return std::nullopt;

  const Participation before(*problem);
  const BlockState state_before = *solution.state;
  const SolveReport solve_before = *solution.solve;
  const PointDefects defects_before = *solution.defects;
  const auto form = [&] {
    solution.system->emplace(*problem, KeptFactors::kMaxBytes);
    (*solution.system)->Form(*solution.state, {}, progress);
  };
  const auto adopt = [&]() -> std::optional<SnoopingReport> {
    all.Apply(problem);
    for (const std::uint64_t look : found->group()) problem->look_used[look] = 0;
    LeaveOutPointsOfGroup(found->group(), problem);
    RequireSolvable(*problem);
    *solution.state = found->state();
    const auto again = [&](RobustLoss loss) {
      AdjustOptions with_loss = options;
      with_loss.robust = loss;
      SolveOnce(with_loss, problem, solution.state, solution.solve, nullptr, progress);
    };
    again(RobustLoss::kNone);
    solution.system->reset();
    std::optional<SnoopingReport> report =
        SearchBlunders(options, again, problem, solution.state, progress);
    if (!report) return std::nullopt;
    form();
    RecoverMirrorSolutions(options,
                           problem,
                           solution.state,
                           solution.solve,
                           solution.system,
                           solution.defects,
                           progress);
    if (FindContradiction(options, solution) >= Contradiction::kUnsolved) return std::nullopt;
    for (const std::uint64_t look : found->group()) {
      BlunderFinding finding;
      finding.point = static_cast<std::uint32_t>(problem->block.looks.PointOf(look));
      finding.looks.assign(1, look);
      const Eigen::Vector2d size = found->ShiftInSigmas(look);
      finding.azimuth = std::abs(size[1]) > std::abs(size[0]);
      finding.w = -size[finding.azimuth ? 1 : 0];
      finding.action = problem->Solves(finding.point) ? BlunderFinding::Action::kRejected
                                                      : BlunderFinding::Action::kPointLeftOut;
      finding.note = kOffLikeOthers;
      report->findings.push_back(std::move(finding));
    }
    return report;
  };
  std::optional<SnoopingReport> report;
  try {
    report = adopt();
  } catch (const UndeterminedError&) {
    report.reset();
  }
  if (!report) {
    before.Restore(problem);
    *solution.state = state_before;
    *solution.solve = solve_before;
    *solution.defects = defects_before;
    form();
  }
  return report;
}

}  // namespace sarblock
