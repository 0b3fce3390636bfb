// SPDX-License-Identifier: Apache-2.0
#include "sarblock/diagnose/diagnose.h"

#include "sarblock/core/statistics.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <string>
#include <utility>

#include "block/plausibility.h"
#include "core/threads.h"
#include "mistake.h"
#include "mistakes.h"
#include "sample.h"
#include "trials.h"

namespace sarblock {
namespace {

/// Level of the global test of the sample below which nothing is asked.
constexpr double kContradicts_1 = 1e-4;
/// A hypothesis whose known points lie nearer than this part of where they did is solved.
constexpr double kNearer_1 = 0.5;
/// Hypotheses of the screening that are solved, and of those whose size is searched.
constexpr std::size_t kMostScreened = 12, kMostRefined = 6;
/// Parts of the work at which no more hypotheses are tried: what known points or scores show of
/// passes and of the whole control, single rows (made and tried), what is guessed, standard
/// deviations. The rest is
/// left for the sizes of the best, of the first of which more is spent if need be.
constexpr double kForShown_1 = 0.5, kToMakeRows_1 = 0.65, kForRows_1 = 0.75, kForGuessed_1 = 0.85,
                 kForSigmas_1 = 0.95, kForFirst_1 = 1.2;
/// Level of the F tests of all hypotheses together, and part of what v'Pv exceeds its redundancy
/// by that is to be taken.
constexpr double kSignificance_1 = 1e-6, kLeastPart_1 = 0.5;
/// Explanations that are told: those that cost at most this, and this part of the gain, more than
/// the best.
constexpr std::size_t kMostTold = 3;
constexpr double kNearlyAsGood_1 = 1e-4, kAsGood_1 = 30.0;

/// How much of the gain a rough solution may lack, and the part of v'Pv that it is to take.
constexpr double kRough_1 = 0.01, kLeastRough_1 = 0.1;

/// Logarithm of the largest factor by which people mistake standard deviations.
constexpr double kMostLogFactor_1 = 11.5;

/// True where a fit is so good that changes of little can start from it: a gross mistake leads
/// everything else away, and what has no place finds none from there.
bool IsNear(const Fit& fit) {
  constexpr double kNear_1 = 30.0;
  return fit.solved && fit.lost == 0 && fit.square_sum_1 < kNear_1 * fit.redundancy_1;
}

/// Every pass sees known points.
bool AllSeen(const std::vector<PassSightings>& passes) {
  return std::all_of(passes.begin(), passes.end(), [](const PassSightings& pass) {
    return pass.sightings.size() >= 3;
  });
}

/// True where nothing is left to explain.
bool ExplainsAll(const Fit& fit) {
  return fit.solved && fit.lost == 0 && fit.square_sum_1 < 1.5 * fit.redundancy_1;
}

bool Contradicts(const Fit& fit) {
  if (!fit.solved || fit.lost > 0) return true;
  if (!(fit.redundancy_1 >= 1.0)) return false;
  const Interval interval = ChiSquareInterval(1.0 - kContradicts_1, fit.redundancy_1);
  return !interval.Contains(fit.square_sum_1);
}

/// v'Pv above which no change of values is told (docs/theory/diagnosis.md, eq. (7)): never where
/// residuals are smaller than their standard deviations, which has no other cause.
double MostLeft(const Fit& before) {
  if (!before.solved) return std::numeric_limits<double>::infinity();
  const double excess_1 = before.SquareSum() - before.redundancy_1;
  if (excess_1 < 0.0) return -std::numeric_limits<double>::infinity();
  return before.SquareSum() - kLeastPart_1 * excess_1;
}

/// Whether what changes no more than what is left out here may be told. Points that go with that
/// say nothing.
bool MayBeTold(const Fit& before, const Fit& without) {
  return !without.solved || without.lost > before.lost || without.SquareSum() <= MostLeft(before);
}

bool AreSame(const Hypothesis& a, const Hypothesis& b) {
  return a.cause == b.cause && a.passes == b.passes && a.points == b.points;
}

/// Of the passes that a hypothesis concerns the median misfit with it over that without.
double ScreenOf(const Hypothesis& hypothesis, const std::vector<PassSightings>& passes) {
  std::vector<double> ratios;
  for (const PassSightings& pass : passes) {
    const std::string& id = pass.part.passes[0].id;
    const bool concerns = hypothesis.passes.empty() ||
                          std::find(hypothesis.passes.begin(), hypothesis.passes.end(), id) !=
                              hypothesis.passes.end();
    if (!concerns || pass.sightings.empty()) continue;
    Block part = pass.part;
    hypothesis.undo(&part, hypothesis.value);
    ratios.push_back(MisfitOf(part) / pass.misfit_m);
  }
  const double ratio = Median(std::move(ratios));
  return std::isnan(ratio) ? 1.0 : ratio;
}

/// Those that need no screening and the best of the others, in the order of their promise.
Hypotheses Screen(Hypotheses all, const std::vector<PassSightings>& passes) {
  std::vector<std::pair<double, std::size_t>> ratios;
  Hypotheses out;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].screened) continue;
    const double ratio = ScreenOf(all[i], passes);
    // What helps every pass stands before what helps each by itself.
    if (ratio < kNearer_1) ratios.emplace_back(all[i].passes.empty() ? 0.1 * ratio : ratio, i);
  }
  std::sort(ratios.begin(), ratios.end());
  for (std::size_t k = 0; k < std::min(kMostScreened, ratios.size()); ++k) {
    Hypothesis& shown = all[ratios[k].second];
    const double kept_1 = ratios[k].first;
    shown.order_1 = kept_1 < Hypothesis::kTold_1
                        ? kept_1
                        : std::lerp(Hypothesis::kWeak_1, Hypothesis::kGuessed_1, kept_1);
    out.push_back(std::move(shown));
  }
  for (Hypothesis& hypothesis : all) {
    if (hypothesis.screened) out.push_back(std::move(hypothesis));
  }
  return out;
}

void SortByPromise(Hypotheses* all) {
  std::stable_sort(all->begin(), all->end(), [](const Hypothesis& a, const Hypothesis& b) {
    return a.order_1 < b.order_1;
  });
}

struct Candidate {
  Hypothesis hypothesis;
  Solved solved;
  double cost_1 = 0.0;  ///< with the penalty of its parameters
};

void SortByCost(std::vector<Candidate>* candidates) {
  std::stable_sort(candidates->begin(), candidates->end(), [](const auto& a, const auto& b) {
    return a.cost_1 < b.cost_1;
  });
}

/// The corrections without passes of which no look takes part: nothing tells of them.
CorrectionModel OfPassesWithLooks(const Block& block, CorrectionModel corrections) {
  std::vector<std::uint8_t> has_looks(block.passes.size(), 0);
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    if (!block.looks.rejected(i)) has_looks[block.looks.pass[i]] = 1;
  }
  const auto narrow = [&](std::vector<std::string>* of) {
    std::vector<std::string> passes;
    for (std::size_t k = 0; k < block.passes.size(); ++k) {
      const std::string& id = block.passes[k].id;
      const bool asked = of->empty() || std::find(of->begin(), of->end(), id) != of->end();
      if (asked && has_looks[k] != 0) passes.push_back(id);
    }
    *of = std::move(passes);
  };
  for (CorrectionGroup& group : corrections.groups) narrow(&group.passes);
  // A joint prior that names no passes is of those that have its parameters, whichever are left.
  std::erase_if(corrections.priors, [&](JointPrior& prior) {
    if (prior.passes.empty()) return false;
    narrow(&prior.passes);
    return prior.passes.empty();
  });
  std::erase_if(corrections.groups, [](const CorrectionGroup& g) { return g.passes.empty(); });
  return corrections;
}

class Diagnosing {
 public:
  Diagnosing(const Block& block,
             const AdjustOptions& options,
             const DiagnosisBounds& bounds,
             ProgressSink* progress)
      : block_(block), bounds_(bounds), progress_(progress) {
    if (options.corrections != CorrectionChoice::kNone) {
      corrections_ = {options.groups, options.priors};
    }
  }

  Diagnosis Run() {
    const Copies copies = FindCopies(block_);
    out_.remarks = copies.remarks;
    Sample sample;
    if (copies.any()) {
      Block once = block_;
      CountOnce(copies, &once);
      sample = TakeSample(once, progress_);
    } else {
      sample = TakeSample(block_, progress_);
    }
    corrections_ = OfPassesWithLooks(sample.block, std::move(corrections_));
    const Work work(block_, sample.block, bounds_);
    Trials trials(sample.block, corrections_, work, progress_);
    const Fit before = trials.AsItIs();
    out_.contradicts = Contradicts(before);
    out_.square_sum = before.SquareSum();
    out_.redundancy = before.redundancy_1;
    out_.points = sample.block.points.size();
    if (out_.contradicts) Explain(sample, before, &trials);
    out_.solutions = trials.solutions();
    out_.work_1 = trials.work().done_looks();
    out_.most_work_1 = trials.work().most_looks();
    return std::move(out_);
  }

 private:
  void Explain(const Sample& sample, const Fit& before, Trials* trials) {
    const std::vector<PassSightings> passes = SightingsOf(sample.block);
    const SampleResiduals residuals = ResidualsOf(trials->given(), corrections_, before);
    bool rows_alone = true;  // may be the cause
    const std::function<bool(const std::vector<std::uint32_t>&)> may_explain =
        [&](const std::vector<std::uint32_t>& points) {
          if (!rows_alone || !before.solved) return rows_alone;
          if (!trials->work().Allows(kToMakeRows_1)) {
            ++out_.untried;
            return false;
          }
          const Fit rest = trials->Without(points,
                                           {.warm = IsNear(before) ? &before.state : nullptr,
                                            .effort = Effort::kQuick,
                                            .useless_above_1 = MostLeft(before)});
          return MayBeTold(before, rest);
        };
    const Facts facts{sample, passes, corrections_, before, residuals, may_explain};
    Hypotheses all;
    for (const auto add :
         {AddTimeMistakes, AddRangeMistakes, AddConeMistakes, AddPathMistakes, AddShiftedIds}) {
      add(facts, &all);
    }
    Hypotheses of_control;
    AddControlMistakes(facts, &of_control);
    // Far from a solution a linearisation says nothing, and known points show what it could.
    const bool scored = IsNear(before) || !AllSeen(passes);
    Hypotheses tried = scored ? ScoredMistakes(facts, progress_) : Hypotheses{};
    out_.hypotheses = static_cast<int>(all.size() + of_control.size() + tried.size());
    Hypotheses screened = Screen(std::move(all), passes);
    // Of what known points show too they tell the size.
    std::erase_if(tried, [&](const Hypothesis& of_score) {
      return std::any_of(screened.begin(), screened.end(), [&](const Hypothesis& of_known) {
        return !of_known.screened && AreSame(of_score, of_known);
      });
    });
    std::move(screened.begin(), screened.end(), std::back_inserter(tried));
    of_control = Screen(std::move(of_control), passes);
    std::move(of_control.begin(), of_control.end(), std::back_inserter(tried));
    SortByPromise(&tried);
    std::vector<Candidate> candidates;
    const auto guessed =
        std::partition_point(tried.begin(), tried.end(), [](const Hypothesis& hypothesis) {
          return hypothesis.order_1 < Hypothesis::kWeak_1;
        });
    Hypotheses guesses(std::make_move_iterator(guessed), std::make_move_iterator(tried.end()));
    tried.erase(guessed, tried.end());
    Try(before, std::move(tried), kForShown_1, trials, &candidates);
    // What a mistake of many looks far from a solution explains wholly, no few rows explain.
    rows_alone = IsNear(before) || !AnyExplainsAll(candidates);
    all = {};
    if (rows_alone) AddExchangedPoints(facts, &all);
    AddKnownPointMistakes(facts, &all);
    if (rows_alone) {
      AddLookMistakes(facts, &all);
      AddWanderMistakes(facts, &all);
    }
    out_.hypotheses += static_cast<int>(all.size());
    Try(before, Screen(std::move(all), passes), kForRows_1, trials, &candidates);
    Try(before, std::move(guesses), kForGuessed_1, trials, &candidates);
    all = {};
    AddSigmaMistakes(facts, &all);
    out_.hypotheses += static_cast<int>(all.size());
    Try(before, std::move(all), kForSigmas_1, trials, &candidates);
    Refine(before, trials, &candidates);
    Tell(before, candidates);
  }

  static bool AnyExplainsAll(const std::vector<Candidate>& candidates) {
    return std::any_of(candidates.begin(), candidates.end(), [](const Candidate& candidate) {
      return ExplainsAll(candidate.solved.fit);
    });
  }

  /// Solves the hypotheses, roughly. One whose cost can no longer come down to what is told is
  /// given up, a part of what is of no use not tried; where this part of the work is done the
  /// others are counted alone.
  void Try(const Fit& before,
           Hypotheses tried,
           double part_of_work_1,
           Trials* trials,
           std::vector<Candidate>* candidates) {
    const bool too_large = before.square_sum_1 < before.redundancy_1;  // of the sigmas
    bool explained = AnyExplainsAll(*candidates);
    double most_1 = MostLeft(before);
    for (const Candidate& candidate : *candidates) {
      if (!Explains(before, candidate)) continue;
      most_1 = std::min(most_1, MostTold(before, candidate.cost_1, kNearlyAsGood_1));
    }
    bool of_use = true;  // the last that changes more than a part of another
    for (std::size_t i = 0; i < tried.size(); ++i) {
      Step(progress_, "diagnose", i, tried.size());
      Hypothesis& hypothesis = tried[i];
      if (hypothesis.within_last && !of_use) continue;
      const bool of_sigma = hypothesis.kind == MistakeKind::kSigma;
      if (!(most_1 > 0.0) && !of_sigma) continue;
      // Other standard deviations, the last of the list, are asked for where no value explains all.
      if (explained && !too_large && of_sigma) continue;
      if (!trials->work().Allows(part_of_work_1)) {
        ++out_.untried;
        continue;
      }
      const double useless_1 = of_sigma ? std::numeric_limits<double>::infinity() : most_1;
      Solved solved{hypothesis.value, kNotGiven, {}};
      if (hypothesis.free && hypothesis.value == 0.0 && before.solved) {
        // From zero on nothing is gained before the size is searched.
        solved =
            SearchSize(hypothesis, before, {Effort::kQuick, useless_1, part_of_work_1}, trials);
      } else {
        const bool near = hypothesis.local && IsNear(before);
        solved.fit = trials->With(hypothesis,
                                  hypothesis.value,
                                  {.warm = near ? &before.state : nullptr,
                                   .effort = Effort::kQuick,
                                   .useless_above_1 = useless_1});
      }
      if (!hypothesis.within_last) of_use = MayBeTold(before, solved.fit);
      if (!solved.fit.solved) continue;
      const double cost_1 = CostOf(hypothesis, solved.fit);
      candidates->push_back({std::move(hypothesis), std::move(solved), cost_1});
      explained = explained || ExplainsAll(candidates->back().solved.fit);
      if (Explains(before, candidates->back())) {
        most_1 = std::min(most_1, MostTold(before, cost_1, kNearlyAsGood_1));
      }
    }
    SortByCost(candidates);
  }

  /// Finds the sizes of the best.
  void Refine(const Fit& before, Trials* trials, std::vector<Candidate>* candidates) {
    double most_1 = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < std::min(kMostRefined, candidates->size()); ++i) {
      Candidate& candidate = (*candidates)[i];
      if (candidate.cost_1 > most_1) break;
      Hypothesis& hypothesis = candidate.hypothesis;
      const double taken_1 = before.SquareSum() - candidate.solved.fit.SquareSum();
      const bool of_values = hypothesis.kind != MistakeKind::kSigma && before.solved;
      if (of_values && !(taken_1 > kLeastRough_1 * before.SquareSum())) continue;
      hypothesis.value = candidate.solved.value;
      const double part_1 = i == 0 ? kForFirst_1 : 1.0;
      if (!trials->work().Allows(part_1)) break;
      if (!candidate.solved.fit.settled) {
        candidate.solved.fit =
            trials->With(hypothesis, hypothesis.value, {.warm = &candidate.solved.fit.state});
      }
      candidate.solved =
          SearchSize(hypothesis, candidate.solved.fit, {.part_of_work_1 = part_1}, trials);
      candidate.cost_1 = CostOf(hypothesis, candidate.solved.fit);
      if (Explains(before, candidate)) {
        most_1 = std::min(most_1, MostTold(before, candidate.cost_1, kRough_1));
      }
    }
    SortByCost(candidates);
  }

  /// Cost up to which others are told beside one of this cost.
  static double MostTold(const Fit& before, double cost_1, double part_1) {
    return cost_1 + kAsGood_1 + part_1 * std::max(0.0, before.Cost() - cost_1);
  }

  static double CostOf(const Hypothesis& hypothesis, const Fit& fit) {
    const double equations = 2.0 * static_cast<double>(std::max<std::size_t>(2, fit.looks));
    return fit.Cost() + hypothesis.parameters * std::log(equations);
  }

  /// True where a hypothesis takes enough of the contradiction to be told.
  [[nodiscard]] bool Explains(const Fit& before, const Candidate& candidate) const {
    const Fit& after = candidate.solved.fit;
    if (!after.solved || (before.solved && after.lost > before.lost)) return false;
    if (!before.solved) return after.lost < after.looks;
    const double k = std::max(1, candidate.hypothesis.parameters);
    const double left = after.redundancy_1 - k;
    if (!(left >= 1.0)) return false;
    if (candidate.hypothesis.kind == MistakeKind::kSigma) {
      if (!(std::abs(candidate.solved.value) < kMostLogFactor_1)) return false;
      const bool fits = after.SquareSum() < 2.0 * left && after.square_sum_1 > 0.5 * left;
      return fits && before.Cost() - after.Cost() > 50.0;
    }
    const double taken_1 = before.SquareSum() - after.SquareSum();
    if (!(after.SquareSum() <= MostLeft(before)) || !(taken_1 > 0.0)) return false;
    if (after.SquareSum() > candidate.hypothesis.most_left_1 * left) return false;
    const double f = (taken_1 / k) / std::max(1e-300, after.SquareSum() / left);
    return out_.hypotheses * FisherTailProbability(f, k, left) < kSignificance_1;
  }

  void Tell(const Fit& before, const std::vector<Candidate>& candidates) {
    double most_1 = 0.0;
    std::vector<const Hypothesis*> told;
    for (const Candidate& candidate : candidates) {
      if (out_.explanations.size() >= kMostTold) break;
      if (!Explains(before, candidate)) continue;
      if (told.empty()) most_1 = MostTold(before, candidate.cost_1, kNearlyAsGood_1);
      if (candidate.cost_1 > most_1) break;
      const bool again = std::any_of(told.begin(), told.end(), [&](const Hypothesis* other) {
        return AreSame(*other, candidate.hypothesis);
      });
      if (again) continue;
      told.push_back(&candidate.hypothesis);
      out_.explanations.push_back(Describe(before, candidate));
    }
  }

  static Explanation Describe(const Fit& before, const Candidate& candidate) {
    const Hypothesis& hypothesis = candidate.hypothesis;
    Explanation out;
    out.kind = hypothesis.kind;
    out.cause = hypothesis.cause;
    out.passes = hypothesis.passes;
    out.points = hypothesis.points;
    if (hypothesis.free || hypothesis.unit == "1") {
      out.value = candidate.solved.value;
      out.sigma = candidate.solved.sigma;
      if (hypothesis.logarithm) {
        out.value = std::exp(out.value);
        out.sigma *= out.value;
      }
      out.unit = hypothesis.unit;
    }
    const Size size = SizeOf(out.value, out.sigma, out.unit);
    out.equals = Equals(hypothesis.numbers, out.value, out.sigma);
    out.change = hypothesis.change(size);
    out.square_sum_before_1 = before.SquareSum();
    out.square_sum_after_1 = candidate.solved.fit.SquareSum();
    out.redundancy_before_1 = before.redundancy_1;
    out.redundancy_after_1 = candidate.solved.fit.redundancy_1 - hypothesis.parameters;
    out.looks_lost_before = before.lost;
    out.looks_lost_after = candidate.solved.fit.lost;
    out.part_1 = out.square_sum_before_1 > 0.0
                     ? (out.square_sum_before_1 - out.square_sum_after_1) / out.square_sum_before_1
                     : 0.0;
    out.sentence = SentenceOf(hypothesis, size, out);
    return out;
  }

  const Block& block_;
  CorrectionModel corrections_;
  DiagnosisBounds bounds_;
  ProgressSink* progress_;
  Diagnosis out_;
};

}  // namespace

Diagnosis Diagnose(const Block& block,
                   const AdjustOptions& options,
                   ProgressSink* progress,
                   const DiagnosisBounds& bounds) {
  const ThreadLimit limit(options.threads);
  return Diagnosing(block, options, bounds, progress).Run();
}

std::optional<Diagnosis> ExplainFailure(const Block& block,
                                        const AdjustOptions& options,
                                        const std::vector<std::string>& warnings,
                                        AdjustResult* result,
                                        ProgressSink* progress) {
  if (!options.diagnose || result->assessment.verdict == Verdict::kAccepted) return std::nullopt;
  Diagnosis diagnosis = Diagnose(block, options, progress);
  for (const std::string& remark : RemarksBeside(warnings, diagnosis)) Warn(result, remark);
  const std::vector<std::string> causes = diagnosis.Sentences();
  std::vector<std::string>& reasons = result->assessment.reasons;
  reasons.insert(reasons.begin(), causes.begin(), causes.end());
  return diagnosis;
}

std::vector<std::string> RemarksBeside(const std::vector<std::string>& warnings,
                                       const Diagnosis& diagnosis) {
  std::vector<std::string> out;
  for (const std::string& remark : diagnosis.remarks) {
    if (std::find(warnings.begin(), warnings.end(), remark) == warnings.end()) {
      out.push_back(remark);
    }
  }
  return out;
}

}  // namespace sarblock
