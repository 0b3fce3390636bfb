// SPDX-License-Identifier: Apache-2.0
#include "sarblock/diagnose/diagnose.h"

#include "sarblock/core/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <string>
#include <utility>

#include "adjust/adjust.h"
#include "block/plausibility.h"
#include "core/threads.h"
#include "mistakes.h"
#include "reduction/reduction.h"
#include "sample.h"

namespace sarblock {
namespace {

// Where these numbers come from: docs/theory/diagnosis.md, "Numbers".

/// Level of the global test of the sample below which nothing is asked.
constexpr double kContradicts = 1e-4;
/// A hypothesis whose known points lie nearer than this part of where they did is solved.
constexpr double kNearer = 0.5;
/// Hypotheses of the screening that are solved, and of those whose size is searched.
constexpr std::size_t kMaxScreened = 12, kMaxRefined = 6;
/// Constant squints beside which one that changes with range is tried.
constexpr std::size_t kMaxNative = 3;
/// Parts of the work at which no more hypotheses are tried: what known points or scores show of
/// passes and of the whole control, single rows (made and tried), what is guessed, standard
/// deviations. The rest is
/// left for the sizes of the best, of the first of which more is spent if need be.
constexpr double kPartForShown = 0.5, kPartToMakeRows = 0.65, kPartForRows = 0.75,
                 kPartForGuessed = 0.85, kPartForSigmas = 1.1, kPartForFirst = 1.3;
/// Level of the F tests of all hypotheses together, and the part of the excess of v'Pv over its
/// redundancy that must be explained.
constexpr double kSignificance = 1e-6, kMinPart = 0.5;
/// Explanations that are reported: those that cost at most this, odds of kSignificance, and this
/// part of the gain, more than the best.
constexpr std::size_t kMaxReported = 3;
constexpr double kNearlyAsGood = 1e-4, kAsGood = 27.6;
/// Difference of the cost up to which the sample does not decide: odds of a thousand to one.
constexpr double kTied = 13.8;
constexpr const char* kTiedWords = "; the sample does not tell it from the first";

/// How much of the gain an approximate solution may lack, and the part of v'Pv that it is to take.
constexpr double kApproximate = 0.01, kMinApproximate = 0.1;

/// Logarithm of the largest factor by which people mistake standard deviations.
constexpr double kMaxLogFactor = 11.5;
/// Logarithm of a factor of standard deviations that heavy tails do not make.
constexpr double kMuchLarger = 1.6;

/// Every pass sees known points.
bool AllSeen(const std::vector<PassPredictions>& passes) {
  return std::all_of(passes.begin(), passes.end(), [](const PassPredictions& pass) {
    return pass.predictions.size() >= 3;
  });
}

/// True where nothing is left to explain.
bool ExplainsAll(const Fit& fit) {
  return fit.solved && fit.lost == 0 && fit.square_sum < 1.5 * fit.redundancy;
}

bool Contradicts(const Fit& fit) {
  if (!fit.solved || fit.lost > 0) return true;
  if (!(fit.redundancy >= 1.0)) return false;
  const Interval interval = ChiSquareInterval(1.0 - kContradicts, fit.redundancy);
  return !interval.Contains(fit.square_sum);
}

/// v'Pv above which no change of values is reported (docs/theory/diagnosis.md, eq. (7)): never
/// where residuals are smaller than their standard deviations, which has no other cause.
double MaxUnexplained(const Fit& before) {
  if (!before.solved) return std::numeric_limits<double>::infinity();
  const double excess = before.SquareSum() - before.redundancy;
  if (excess < 0.0) return -std::numeric_limits<double>::infinity();
  return before.SquareSum() - kMinPart * excess;
}

/// Whether a change may be reported that affects no more than what is left out here. Points that go
/// with that say nothing.
bool IsReportable(const Fit& before, const Fit& without) {
  return !without.solved || without.lost > before.lost ||
         without.SquareSum() <= MaxUnexplained(before);
}

bool AreSame(const Hypothesis& a, const Hypothesis& b) {
  return a.cause == b.cause && a.passes == b.passes && a.points == b.points;
}

/// Median over the passes that a hypothesis concerns: misfit with it over misfit without it.
double ScreenOf(const Hypothesis& hypothesis, const std::vector<PassPredictions>& passes) {
  std::vector<double> ratios;
  for (const PassPredictions& pass : passes) {
    const std::string& id = pass.part.passes[0].id;
    const bool concerns = hypothesis.passes.empty() ||
                          std::find(hypothesis.passes.begin(), hypothesis.passes.end(), id) !=
                              hypothesis.passes.end();
    if (!concerns || pass.predictions.empty()) continue;
    Block part = pass.part;
    hypothesis.undo(&part, hypothesis.value);
    ratios.push_back(MisfitOf(part) / pass.misfit_m);
  }
  const double ratio = Median(std::move(ratios));
  return std::isnan(ratio) ? 1.0 : ratio;
}

/// Those that need no screening and the best of the others, in the order of their promise.
Hypotheses Screen(Hypotheses all, const std::vector<PassPredictions>& passes) {
  std::vector<std::pair<double, std::size_t>> ratios;
  Hypotheses out;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].screened) continue;
    const double ratio = ScreenOf(all[i], passes);
    // What helps every pass comes before what helps each by itself.
    if (ratio < kNearer) ratios.emplace_back(all[i].passes.empty() ? 0.1 * ratio : ratio, i);
  }
  std::sort(ratios.begin(), ratios.end());
  for (std::size_t k = 0; k < std::min(kMaxScreened, ratios.size()); ++k) {
    Hypothesis& shown = all[ratios[k].second];
    const double kept = ratios[k].first;
    shown.order = kept < Hypothesis::kReported
                      ? kept
                      : std::lerp(Hypothesis::kWeak, Hypothesis::kGuessed, kept);
    out.push_back(std::move(shown));
  }
  for (Hypothesis& hypothesis : all) {
    if (hypothesis.screened) out.push_back(std::move(hypothesis));
  }
  return out;
}

void SortByPromise(Hypotheses* all) {
  std::stable_sort(all->begin(), all->end(), [](const Hypothesis& a, const Hypothesis& b) {
    return a.order < b.order;
  });
}

struct Candidate {
  Hypothesis hypothesis;
  Solved solved;
  double cost = 0.0;  ///< with the penalty of its parameters
};

void SortByCost(std::vector<Candidate>* candidates) {
  std::stable_sort(candidates->begin(), candidates->end(), [](const auto& a, const auto& b) {
    return a.cost < b.cost;
  });
}

/// Drops passes without observations: nothing determines their corrections.
CorrectionModel RestrictToObservedPasses(const Block& block, CorrectionModel corrections) {
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
    given_ = corrections_;
    test_level_ = options.test_level;
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
    corrections_ = RestrictToObservedPasses(sample.block, std::move(corrections_));
    const Work work(block_, sample.block, bounds_.adjustments);
    Trials trials(sample.block, corrections_, work, progress_);
    Fit before = trials.SolveGiven();
    const PriorSums priors = PriorsOf(trials.given(), corrections_, before);
    const double empty = std::max(0.0, priors.redundancy - priors.square_sum);
    before.redundancy -= empty;
    trials.LeaveOutOfRedundancy(empty);
    out_.contradicts = Contradicts(before);
    out_.square_sum = before.SquareSum();
    out_.redundancy = before.redundancy;
    out_.points = sample.block.points.size();
    if (out_.contradicts) Explain(sample, before, &trials);
    out_.solutions = trials.solutions();
    out_.work = trials.work().done_looks();
    out_.max_work = trials.work().most_looks();
    return std::move(out_);
  }

 private:
  void Explain(const Sample& sample, const Fit& before, Trials* trials) {
    const std::vector<PassPredictions> passes = PredictLooks(sample.block);
    const SampleResiduals residuals = ResidualsOf(trials->given(), corrections_, before);
    bool rows_alone = true;  // may be the cause
    const std::function<bool(const std::vector<std::uint32_t>&)> may_explain =
        [&](const std::vector<std::uint32_t>& points) {
          if (!rows_alone || !before.solved) return rows_alone;
          if (!trials->work().Allows(kPartToMakeRows)) {
            ++out_.untried;
            return false;
          }
          const Fit rest = trials->SolveWithout(points,
                                                {.warm = IsNear(before) ? &before.state : nullptr,
                                                 .effort = Effort::kQuick,
                                                 .useless_above = MaxUnexplained(before)});
          return IsReportable(before, rest);
        };
    const Facts facts{sample, passes, corrections_, before, residuals, may_explain};
    Hypotheses all;
    AddModelMistakes(facts, trials, &all);
    for (const auto add : {AddTimeMistakes,
                           AddRangeMistakes,
                           AddDelayMistakes,
                           AddConeMistakes,
                           AddPathMistakes,
                           AddShiftedIds}) {
      add(facts, &all);
    }
    Hypotheses of_control;
    AddControlMistakes(facts, &of_control);
    AddShiftedControl(facts, &of_control);
    // Far from a solution a linearisation says nothing, and known points show what it could.
    const bool scored = IsNear(before) || !AllSeen(passes);
    Hypotheses tried = scored ? ScoredMistakes(facts, progress_) : Hypotheses{};
    out_.hypotheses = static_cast<int>(all.size() + of_control.size() + tried.size());
    Hypotheses screened = Screen(std::move(all), passes);
    // They give the size of what known points show too.
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
          return hypothesis.order < Hypothesis::kWeak;
        });
    Hypotheses guesses(std::make_move_iterator(guessed), std::make_move_iterator(tried.end()));
    tried.erase(guessed, tried.end());
    Try(before, std::move(tried), kPartForShown, trials, &candidates);
    // What a mistake of many looks far from a solution explains wholly, no few rows explain.
    rows_alone = IsNear(before) || !AnyExplainsAll(before, candidates);
    all = {};
    if (rows_alone) AddExchangedPoints(facts, &all);
    AddKnownPointMistakes(facts, &all);
    if (rows_alone) AddLookMistakes(facts, &all);
    out_.hypotheses += static_cast<int>(all.size());
    Try(before, Screen(std::move(all), passes), kPartForRows, trials, &candidates);
    all = {};
    AddTimeCorrelatedMistakes(facts, trials, &all);
    out_.hypotheses += static_cast<int>(all.size());
    Try(before, std::move(all), kPartForGuessed, trials, &candidates);
    Try(before, std::move(guesses), kPartForGuessed, trials, &candidates);
    Try(before, NativeDopplers(facts, trials, &candidates), kPartForSigmas, trials, &candidates);
    all = {};
    if (trials->work().Allows(kPartForSigmas)) {
      AddControlSigma(facts, trials, &all);
      AddSigmaMistakes(facts, trials, &all);
    } else {
      ++out_.untried;
    }
    out_.hypotheses += static_cast<int>(all.size());
    Try(before, std::move(all), kPartForSigmas, trials, &candidates);
    Refine(before, trials, &candidates);
    Report(before, sample, trials->given(), candidates);
    if (AnyCures(out_.explanations) || !whole_block_) return;
    if (auto coregistered = FindCoregistered(facts)) out_.explanations = {std::move(*coregistered)};
  }

  /// Beside the constant squints that help most, at their sizes where they explain the block: what
  /// a size that is not found leaves may be a slope.
  Hypotheses NativeDopplers(const Facts& facts,
                            Trials* trials,
                            std::vector<Candidate>* candidates) const {
    Hypotheses out;
    for (Candidate& candidate : *candidates) {
      if (out.size() == kMaxNative || !(candidate.cost < facts.before.Cost())) break;
      if (candidate.hypothesis.cause == "cone.squint" && std::isnan(candidate.solved.sigma) &&
          Explains(facts.before, candidate)) {
        FindSize(kPartForSigmas, trials, &candidate);
      }
      if (auto native = NativeBeside(facts, candidate.hypothesis, candidate.solved)) {
        out.push_back(std::move(*native));
      }
    }
    return out;
  }

  [[nodiscard]] bool AnyExplainsAll(const Fit& before,
                                    const std::vector<Candidate>& candidates) const {
    return std::any_of(candidates.begin(), candidates.end(), [&](const Candidate& candidate) {
      return ExplainsAll(candidate.solved.fit) && Explains(before, candidate);
    });
  }

  /// Solves the hypotheses approximately. One whose cost can no longer come down to what is
  /// reported is given up, and useless ones are not tried; after this part of the work the others
  /// are only counted.
  void Try(const Fit& before,
           Hypotheses tried,
           double part_of_work,
           Trials* trials,
           std::vector<Candidate>* candidates) {
    const bool too_large = before.square_sum < before.redundancy;  // of the sigmas
    bool explained = AnyExplainsAll(before, *candidates);
    double max_square = MaxUnexplained(before);
    for (const Candidate& candidate : *candidates) {
      if (!Explains(before, candidate)) continue;
      max_square = std::min(max_square, MaxReported(before, candidate.cost, kNearlyAsGood));
    }
    bool of_use = true;  // the last that changes more than a part of another
    for (std::size_t i = 0; i < tried.size(); ++i) {
      Step(progress_, "diagnose", i, tried.size());
      Hypothesis& hypothesis = tried[i];
      if (hypothesis.within_last && !of_use) continue;
      const bool of_sigma = hypothesis.kind == MistakeKind::kSigma;
      if (!(max_square > 0.0) && !of_sigma) continue;
      // Other standard deviations, the last of the list, are asked for where no value explains all.
      if (explained && !too_large && of_sigma) continue;
      if (!trials->work().Allows(part_of_work)) {
        ++out_.untried;
        continue;
      }
      const double useless_above = of_sigma ? std::numeric_limits<double>::infinity() : max_square;
      Solved solved{hypothesis.value, kNotGiven, {}};
      if (hypothesis.free && hypothesis.value == 0.0 && before.solved) {
        // From zero on nothing is gained before the size is searched.
        solved =
            SearchSize(hypothesis, before, {Effort::kQuick, useless_above, part_of_work}, trials);
      } else {
        const bool near = hypothesis.local && IsNear(before);
        solved.fit = trials->With(hypothesis,
                                  hypothesis.value,
                                  {.warm = near ? &before.state : nullptr,
                                   .effort = Effort::kQuick,
                                   .useless_above = useless_above});
      }
      if (!hypothesis.within_last) of_use = IsReportable(before, solved.fit);
      if (!solved.fit.solved) continue;
      const double cost = CostOf(hypothesis, solved.fit);
      candidates->push_back({std::move(hypothesis), std::move(solved), cost});
      if (Explains(before, candidates->back())) {
        explained = explained || (!of_sigma && ExplainsAll(candidates->back().solved.fit));
        max_square = std::min(max_square, MaxReported(before, cost, kNearlyAsGood));
      }
    }
    SortByCost(candidates);
  }

  static void FindSize(double part_of_work, Trials* trials, Candidate* candidate) {
    Hypothesis& hypothesis = candidate->hypothesis;
    hypothesis.value = candidate->solved.value;
    if (!candidate->solved.fit.settled) {
      candidate->solved.fit =
          trials->With(hypothesis, hypothesis.value, {.warm = &candidate->solved.fit.state});
    }
    candidate->solved =
        SearchSize(hypothesis, candidate->solved.fit, {.part_of_work = part_of_work}, trials);
    candidate->cost = CostOf(hypothesis, candidate->solved.fit);
  }

  /// Finds the sizes of the best.
  void Refine(const Fit& before, Trials* trials, std::vector<Candidate>* candidates) {
    double max_square = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < std::min(kMaxRefined, candidates->size()); ++i) {
      Candidate& candidate = (*candidates)[i];
      if (candidate.cost > max_square) break;
      const Hypothesis& hypothesis = candidate.hypothesis;
      const double square_explained = before.SquareSum() - candidate.solved.fit.SquareSum();
      const bool of_values = hypothesis.kind != MistakeKind::kSigma && before.solved;
      if (of_values && !(square_explained > kMinApproximate * before.SquareSum())) continue;
      const double part = i == 0 ? kPartForFirst : 1.0;
      if (!trials->work().Allows(part)) break;
      FindSize(part, trials, &candidate);
      if (Explains(before, candidate)) {
        max_square = std::min(max_square, MaxReported(before, candidate.cost, kApproximate));
      }
    }
    SortByCost(candidates);
  }

  /// Cost up to which others are reported with one of this cost.
  static double MaxReported(const Fit& before, double cost, double part) {
    return cost + kAsGood + part * std::max(0.0, before.Cost() - cost);
  }

  static double CostOf(const Hypothesis& hypothesis, const Fit& fit) {
    const double equations = 2.0 * static_cast<double>(std::max<std::size_t>(2, fit.looks));
    return fit.Cost() + hypothesis.parameters * std::log(equations);
  }

  /// True where a hypothesis explains enough of the contradiction to be reported.
  [[nodiscard]] bool Explains(const Fit& before, const Candidate& candidate) const {
    const Fit& after = candidate.solved.fit;
    if (!after.solved || (before.solved && after.lost > before.lost)) return false;
    if (!before.solved) return after.lost < after.looks;
    const double k = std::max(1, candidate.hypothesis.parameters);
    const double left = after.redundancy - k;
    if (!(left >= 1.0)) return false;
    if (candidate.hypothesis.kind == MistakeKind::kSigma) {
      if (!(std::abs(candidate.solved.value) < kMaxLogFactor)) return false;
      const bool fits = after.SquareSum() < 2.0 * left && after.square_sum > 0.5 * left;
      return fits && before.Cost() - candidate.cost > kAsGood;
    }
    const double square_explained = before.SquareSum() - after.SquareSum();
    if (!(after.SquareSum() <= MaxUnexplained(before)) || !(square_explained > 0.0)) return false;
    if (after.SquareSum() > candidate.hypothesis.max_unexplained * left) return false;
    const double f = (square_explained / k) / std::max(1e-300, after.SquareSum() / left);
    return out_.hypotheses * FisherTailProbability(f, k, left) < kSignificance;
  }

  /// Standard deviations are the cause of noise alone: what the residuals show under those of a
  /// candidate, empty where that is noise.
  std::string PatternUnder(const Candidate& candidate,
                           const Sample& sample,
                           const Block& given) const {
    if (candidate.hypothesis.kind != MistakeKind::kSigma) return "";
    Block block = given;
    candidate.hypothesis.undo(&block, candidate.solved.value);
    const SampleResiduals residuals = ResidualsOf(block, corrections_, candidate.solved.fit);
    const bool much_larger = std::abs(candidate.solved.value) > kMuchLarger;
    return FindPattern(block, sample.suspects, residuals, much_larger);
  }

  struct Described {
    Explanation explanation;
    const Candidate* candidate = nullptr;
    bool priors_hold = true;              ///< in the whole block
    std::array<LookSums, 2> of_passes{};  ///< there, of standard deviations
  };

  /// The logarithm of a factor of standard deviations that the residuals of the whole block ask
  /// for, where it has more of them than the sample or is not good with that of the sample.
  static std::optional<Size> SizeOfSigmas(const Described& of_sample) {
    constexpr double kNarrower = 0.9;
    const Candidate& candidate = *of_sample.candidate;
    const std::string& cause = candidate.hypothesis.cause;
    const bool ranges = cause == "sigma.range" || cause == "sigma.all";
    const bool azimuths = cause == "sigma.azimuth" || cause == "sigma.all";
    const auto& [of_ranges, of_azimuths] = of_sample.of_passes;
    const double square = (ranges ? of_ranges.square : 0.0) + (azimuths ? of_azimuths.square : 0.0);
    const double redundancy =
        (ranges ? of_ranges.redundancy : 0.0) + (azimuths ? of_azimuths.redundancy : 0.0);
    if (!(square > 0.0) || !(redundancy >= 1.0)) return std::nullopt;
    const double sigma = std::sqrt(0.5 / redundancy);
    const bool narrower = !(sigma > kNarrower * candidate.solved.sigma);  // or none is known
    if (of_sample.explanation.cure.cures && !narrower) return std::nullopt;
    return Size{candidate.solved.value - 0.5 * std::log(square / redundancy), sigma, ""};
  }

  /// Standard deviations that leave the whole block, or its priors, contradicted: then it is no
  /// matter of noise. They are known no better than the sample tells.
  static bool FailsAsNoise(const Described& described) {
    const Explanation& reported = described.explanation;
    if (reported.kind != MistakeKind::kSigma || !reported.cure.tried || reported.cure.cures)
      return false;
    constexpr double kSigmas = 8.0;  // four of the size, of which the factor is the square
    if (!described.priors_hold) return true;
    return std::abs(std::log(reported.cure.factor)) > kSigmas * reported.sigma / reported.value;
  }

  static bool AnyCures(const std::vector<Explanation>& explanations) {
    return std::any_of(explanations.begin(), explanations.end(), [](const Explanation& one) {
      return one.cure.cures;
    });
  }

  static bool AnyCures(const std::vector<Described>& described) {
    return std::any_of(described.begin(), described.end(), [](const Described& one) {
      return one.explanation.cure.cures;
    });
  }

  /// Where what costs least are standard deviations that do not cure the block, the first that does
  /// among those that cost more and explain all of the sample. Values that take a part stand.
  void FindCure(const Fit& before,
                const Sample& sample,
                const Block& given,
                const std::vector<Candidate>& candidates,
                std::vector<Described>* described) const {
    const Explanation& first = described->front().explanation;
    if (!first.cure.tried || first.kind != MistakeKind::kSigma) return;
    std::size_t tried = 0;
    for (const Candidate& candidate : candidates) {
      if (tried == kMaxReported) return;
      const bool known = std::any_of(described->begin(), described->end(), [&](const Described& d) {
        return AreSame(d.candidate->hypothesis, candidate.hypothesis);
      });
      if (known || !Explains(before, candidate) || !ExplainsAll(candidate.solved.fit)) continue;
      if (!PatternUnder(candidate, sample, given).empty()) continue;
      ++tried;
      Described one = DescribeWithBlock(before, candidate, true);
      if (!one.explanation.cure.cures) continue;
      described->push_back(std::move(one));
      return;
    }
  }

  /// With the size of standard deviations that the whole block asks for.
  Described DescribeWithBlock(const Fit& before, const Candidate& candidate, bool cures) const {
    Described one =
        Describe(before, candidate, {candidate.solved.value, candidate.solved.sigma, ""}, cures);
    if (FailsAsNoise(one)) return one;
    if (const auto size = SizeOfSigmas(one)) {
      Described of_block = Describe(before, candidate, *size, true);
      if (of_block.explanation.cure.cures) return of_block;
    }
    return one;
  }

  /// A change of values that has a size, or none: how many parameters undo it says how simple it
  /// is. Priors and standard deviations pay in their cost.
  static bool ChangesValues(const Hypothesis& hypothesis) {
    return hypothesis.kind != MistakeKind::kModel && hypothesis.kind != MistakeKind::kSigma;
  }

  /// Whether it is worth a solution of the block: nothing before it cures, or nothing so simple.
  static bool MayBeSimpler(const Candidate& candidate, const std::vector<Described>& before) {
    const Hypothesis& hypothesis = candidate.hypothesis;
    return std::none_of(before.begin(), before.end(), [&](const Described& other) {
      const Hypothesis& of = other.candidate->hypothesis;
      const bool simpler =
          ChangesValues(hypothesis) && ChangesValues(of) && hypothesis.parameters < of.parameters;
      return other.explanation.cure.cures && !simpler;
    });
  }

  /// Where several changes of values cure and the sample does not tell them apart, the one with the
  /// fewest parameters comes first.
  static void PutFewestParametersFirst(std::vector<Described>* described) {
    std::vector<std::size_t> places;
    std::vector<Described> sorted;
    for (std::size_t i = 0; i < described->size(); ++i) {
      const Described& one = (*described)[i];
      if (!one.explanation.cure.cures || !ChangesValues(one.candidate->hypothesis)) continue;
      // They are in the order of their cost.
      if (!sorted.empty() && one.candidate->cost - sorted.front().candidate->cost > kTied) break;
      places.push_back(i);
      sorted.push_back(one);
    }
    std::stable_sort(sorted.begin(), sorted.end(), [](const Described& a, const Described& b) {
      return a.candidate->hypothesis.parameters < b.candidate->hypothesis.parameters;
    });
    for (std::size_t k = 0; k < places.size(); ++k) (*described)[places[k]] = std::move(sorted[k]);
  }

  static int RankOf(const Explanation& reported) {
    if (!reported.cure.cures) return 2;
    return reported.cause == "model.missing" ? 0 : 1;
  }

  /// `given`: the sample as it was solved, check points as control.
  void Report(const Fit& before,
              const Sample& sample,
              const Block& given,
              const std::vector<Candidate>& candidates) {
    double max_square = 0.0;
    std::vector<const Candidate*> reported;
    for (const Candidate& candidate : candidates) {
      if (reported.size() >= kMaxReported) break;
      if (!Explains(before, candidate)) continue;
      if (!reported.empty() && candidate.cost > max_square) break;
      const bool again = std::any_of(reported.begin(), reported.end(), [&](const Candidate* other) {
        return AreSame(other->hypothesis, candidate.hypothesis);
      });
      if (again) continue;
      const std::string pattern = PatternUnder(candidate, sample, given);
      if (!pattern.empty()) {
        out_.pattern = pattern;
        continue;
      }
      if (reported.empty()) max_square = MaxReported(before, candidate.cost, kNearlyAsGood);
      reported.push_back(&candidate);
    }
    // What was chosen is suspected too where it would explain all.
    const auto chosen = std::find_if(candidates.begin(), candidates.end(), [&](const Candidate& c) {
      return c.hypothesis.kind == MistakeKind::kModel && ExplainsAll(c.solved.fit) &&
             Explains(before, c);
    });
    const bool beside = chosen != candidates.end() &&
                        std::find(reported.begin(), reported.end(), &*chosen) == reported.end();
    if (beside) {
      if (reported.size() == kMaxReported) reported.pop_back();
      reported.push_back(&*chosen);
    }
    std::vector<Described> described;
    for (const Candidate* candidate : reported) {
      Described one = DescribeWithBlock(before, *candidate, MayBeSimpler(*candidate, described));
      if (!FailsAsNoise(one)) described.push_back(std::move(one));
    }
    if (!described.empty() && !AnyCures(described))
      FindCure(before, sample, given, candidates, &described);
    whole_block_ = described.empty() || !described.front().candidate->hypothesis.of_sample;
    PutFewestParametersFirst(&described);
    if (AnyCures(described)) {
      std::erase_if(described, [](const Described& d) {
        return d.explanation.cure.tried && !d.explanation.cure.cures;
      });
    }
    // Beside what makes the whole block a good one nothing is said that does not, and corrections
    // that are missing, the commonest mistake of all, before what would do as well.
    std::stable_sort(
        described.begin(), described.end(), [](const Described& a, const Described& b) {
          return RankOf(a.explanation) < RankOf(b.explanation);
        });
    for (Described& one : described) {
      const double more = one.candidate->cost - described.front().candidate->cost;
      if (&one != &described.front() && std::abs(more) < kTied) SayTied(&one.explanation);
      out_.explanations.push_back(std::move(one.explanation));
    }
    TellDoubtfulLooks();
  }

  static void SayTied(Explanation* one) {
    const std::string before_change = "; " + one->change;
    one->sentence.insert(one->sentence.size() - before_change.size(), kTiedWords);
  }

  static bool IsOfLook(const Explanation& one) {
    return one.cause == "ids.look" || one.cause == "time.one" || one.cause == "range.one" ||
           one.cause == "cone.one";
  }

  /// Where another look of the point may as well be the wrong one, none of them is taken.
  void TellDoubtfulLooks() {
    constexpr double kAlike = 15.0;  // of v'Pv: 1e-4 that noise does it
    for (Explanation& one : out_.explanations) {
      if (!IsOfLook(one)) continue;
      const bool doubtful = std::any_of(
          out_.explanations.begin(), out_.explanations.end(), [&one](const Explanation& other) {
            return IsOfLook(other) && other.points == one.points && other.passes != one.passes &&
                   std::abs(other.square_sum_after - one.square_sum_after) < kAlike;
          });
      if (!doubtful) continue;
      const std::string change = "observations.csv: rejected = 1 in the rows of " + one.points[0] +
                                 ", whose looks do not tell which of them is wrong";
      one.sentence.replace(one.sentence.size() - one.change.size(), one.change.size(), change);
      one.change = change;
    }
  }

  /// The explanation with a size; `cures`: applied to the whole block too.
  Described Describe(const Fit& before,
                     const Candidate& candidate,
                     const Size& found,
                     bool cures) const {
    const Hypothesis& hypothesis = candidate.hypothesis;
    Described described;
    described.candidate = &candidate;
    Explanation& out = described.explanation;
    out.kind = hypothesis.kind;
    out.cause = hypothesis.cause;
    out.passes = hypothesis.passes;
    out.points = hypothesis.points;
    if (!hypothesis.unit.empty()) {
      out.value = found.value;
      out.sigma = found.sigma;
      if (hypothesis.logarithm) {
        out.value = std::exp(out.value);
        out.sigma *= out.value;
      }
      out.unit = hypothesis.unit;
    }
    const Size size = SizeOf(out.value, out.sigma, out.unit);
    out.equals = Equals(hypothesis.numbers, out.value, out.sigma);
    out.change = hypothesis.change(size);
    if (hypothesis.cautious) {
      const Hypothesis cautious = hypothesis.cautious(block_);
      const BlockCure solved =
          CureOf(block_, given_, cautious, found.value, test_level_, progress_);
      if (BearsSigmas(solved, test_level_)) out.change = cautious.change(size);
    }
    out.square_sum_before = before.SquareSum();
    out.square_sum_after = candidate.solved.fit.SquareSum();
    out.redundancy_before = before.redundancy;
    out.redundancy_after = candidate.solved.fit.redundancy - hypothesis.parameters;
    out.looks_lost_before = before.lost;
    out.looks_lost_after = candidate.solved.fit.lost;
    out.part = out.square_sum_before > 0.0
                   ? (out.square_sum_before - out.square_sum_after) / out.square_sum_before
                   : 0.0;
    if (!hypothesis.of_sample && (cures || hypothesis.kind == MistakeKind::kModel)) {
      BlockCure tried = CureOf(block_, given_, hypothesis, found.value, test_level_, progress_);
      out.cure = tried.cure;
      described.of_passes = tried.of_passes;
      described.priors_hold = tried.priors_hold;
    }
    const std::string detail =
        hypothesis.detail ? hypothesis.detail(candidate.solved.fit) : std::string();
    out.sentence = SentenceOf(hypothesis, size, detail, out);
    return described;
  }

  const Block& block_;
  CorrectionModel corrections_;  ///< of passes with looks in the sample
  CorrectionModel given_;
  double test_level_ = 0.0;
  bool whole_block_ = true;  ///< says what the first explanation does
  DiagnosisBounds bounds_;
  ProgressSink* progress_;
  Diagnosis out_;
};

}  // namespace

Diagnosis Diagnose(const Block& block,
                   const AdjustOptions& options,
                   ProgressSink* progress,
                   const DiagnosisBounds& bounds) {
  return CallInLibrary(options.threads, progress, [&] {
    ReducedBlock reduced(block);
    if (reduced.HasModels()) reduced.ReduceAt(StartPositions(block, progress));
    return Diagnosing(reduced.block(), options, bounds, progress).Run();
  });
}

std::optional<Diagnosis> ExplainFailure(const Block& block,
                                        const AdjustOptions& options,
                                        const std::vector<std::string>& warnings,
                                        AdjustResult* result,
                                        ProgressSink* progress) {
  const Assessment& assessment = result->assessment;
  if (assessment.verdict == Verdict::kAccepted) return std::nullopt;
  if (result->status == AdjustStatus::kNotConverged && assessment.reasons.size() == 1) {
    return std::nullopt;
  }
  Diagnosis diagnosis = Diagnose(block, options, progress);
  for (const std::string& remark : RemarksBeside(warnings, diagnosis)) Warn(result, remark);
  const std::vector<std::string> causes = diagnosis.Sentences();
  std::vector<std::string>& reasons = result->assessment.reasons;
  reasons.insert(reasons.begin(), causes.begin(), causes.end());
  return diagnosis;
}

Diagnosis ExplainRefusal(const Block& block, const AdjustOptions& options, ProgressSink* progress) {
  Diagnosis diagnosis = Diagnose(block, options, progress);
  std::vector<Explanation> answers;
  for (Explanation& one : diagnosis.explanations) {
    const bool places = !one.cure.tried && 2 * one.looks_lost_after < one.looks_lost_before;
    const bool tied = !one.cure.tried && !answers.empty();  // with the answer before it
    if (one.cure.cures || places || tied) answers.push_back(std::move(one));
  }
  diagnosis.explanations = std::move(answers);
  diagnosis.pattern.clear();
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
