// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "model/problem.h"
#include "quality/verdict_tests.h"
#include "sample.h"
#include <Eigen/Core>

namespace sarblock {

/// A number that is typical of a mistake, and its meaning.
struct KnownNumber {
  double value = 0.0;  ///< in the unit of the hypothesis
  std::string text;
};

/// Size of a mistake as found: `text` is "18.000 +- 0.001 s", or the size that was tried.
struct Size {
  double value = kNotGiven, sigma = kNotGiven;
  std::string text;
};

struct Fit;

/// One mistake that may have been made, and the change of the block that undoes it. `undo` is
/// called on the sample and on small parts of it, so it finds passes and points by their ids and
/// leaves alone what is not there.
struct Hypothesis {
  MistakeKind kind = MistakeKind::kTime;
  std::string cause;
  std::vector<std::string> passes;  ///< empty: all
  std::vector<std::string> points;
  std::function<void(Block*, double value)> undo;
  /// Undoes a mistake in the corrections asked for; empty for all other mistakes.
  std::function<void(CorrectionModel*, double value)> remodel;
  double log_cost = 0.0;  ///< this times `value` is added to -2 log of the likelihood, for wider
                          ///< priors
  int parameters = 1;     ///< that undoing it fits to the looks; 0: a change without a size
  /// The size is found from `value` on with first steps of `step`; else `value` is the size.
  bool free = false;
  double value = 0.0, step = 0.0;
  bool logarithm = false;  ///< value and step are logarithms of what is reported
  std::string unit;
  std::vector<KnownNumber> numbers;
  /// "the times of pass DSC are 18.000 +- 0.001 s late"
  std::function<std::string(const Size&)> says;
  std::function<std::string(const Size&)> change;
  std::function<std::string(const Fit&)> detail;  ///< what its solution shows; empty: nothing
  /// Solved without the screening: known points cannot show it, or a score test found it.
  bool screened = false;
  /// Rank among those that are tried: what the laws of motion show; corrections that were chosen;
  /// what the data show by themselves, and hypotheses that leave known points less than a tenth of
  /// their misfit; what score tests show; hypotheses that leave known points more; guesses.
  double order = kGuessed;
  static constexpr double kCertain = 0.0, kChosen = 0.05, kReported = 0.1, kScored = 0.6,
                          kWeak = 0.7, kGuessed = 1.0;
  /// Changes one of the measurements that the hypothesis before leaves out: not tried where that
  /// one is of no use.
  bool within_last = false;
  /// Number of recorded states whose path, made anew when the mistake is undone, does not go
  /// through them.
  std::size_t smoothed_states = 0;
  /// Not reported where v'Pv over its redundancy stays above this: a curve fits a part of any
  /// residuals.
  double max_unexplained = std::numeric_limits<double>::infinity();
  /// Changes little: solved from the solution of the sample as it is.
  bool local = false;
  /// Undone only in the points of the sample, so the whole block cannot show its effect.
  bool of_sample = false;
  /// The same error with larger standard deviations, which are advised instead where the residuals
  /// of the whole block are not too small for them.
  std::function<Hypothesis(const Block& whole)> cautious;
};

/// Four digits, without trailing zeros.
[[nodiscard]] std::string Short(double value);

/// A size to write into a file: to the second digit of its sigma, at least four digits; without a
/// sigma ten.
[[nodiscard]] std::string InFiles(double value, double sigma = kNotGiven);

/// "18.000 +- 0.001 s": both to the second digit of sigma; without a sigma six digits.
[[nodiscard]] Size SizeOf(double value, double sigma, const std::string& unit);

/// The text of the number that a size equals within four of its sigmas and a thousandth; empty if
/// there is none, or if the sigma is too large to tell.
[[nodiscard]] std::string Equals(const std::vector<KnownNumber>& numbers,
                                 double value,
                                 double sigma);

/// "pass A", "passes A and B", "all passes" for none.
[[nodiscard]] std::string PassWords(const std::vector<std::string>& passes);
/// "of A", "of A and B", "of all passes" for none.
[[nodiscard]] std::string PassesPhrase(const std::vector<std::string>& passes);

/// The sentence of an explanation whose other members are set.
[[nodiscard]] std::string SentenceOf(const Hypothesis& hypothesis,
                                     const Size& size,
                                     const std::string& detail,
                                     const Explanation& explanation);

/// A sample of a block solved by least squares, as far as it can be.
struct Fit {
  bool solved = false;
  double square_sum = 0.0;  ///< v'Pv of what has a place
  double redundancy = 0.0;
  ProblemCounts counts;
  std::size_t looks = 0;  ///< that have a place
  std::size_t lost = 0;   ///< looks without one, or whose point lies where they do not look to
  /// Sum over the measurements of r ln sigma^2 less that of the sample as it was given, r their
  /// redundancy numbers (Trials::WeighLogSigmas), and what wider priors cost.
  double log_sigmas = 0.0;
  int formed = 0;        ///< times that the system was formed
  bool settled = false;  ///< the solution converged
  BlockState state;

  /// v'Pv with a look that has no place counted by kLost.
  [[nodiscard]] double SquareSum() const;
  /// -2 log of the restricted likelihood but for a constant (docs/theory/diagnosis.md, eq. (2)).
  [[nodiscard]] double Cost() const { return SquareSum() + log_sigmas; }
};

/// True where a fit is so good that hypotheses which change little can start from it: with a gross
/// mistake the rest of the solution is wrong too, and looks without a place find none from there.
[[nodiscard]] bool IsNear(const Fit& fit);

/// Part of v'Pv that a look without a place counts for: residuals of 30 sigma in range and azimuth.
inline constexpr double kLost = 1800.0;

/// How often a solution may form its system. With a correct hypothesis it converges after two or
/// three times; with others it need not converge.
enum class Effort { kQuick, kFull };

struct FitOptions {
  /// State of another fit of the same points to start from, which leaves out what has no place
  /// there. None: start values of the sample's own.
  const BlockState* warm = nullptr;
  Effort effort = Effort::kFull;
  /// v'Pv above which the fit is of no use: it may be given up (SolveOptions).
  double useless_above = std::numeric_limits<double>::infinity();
};

/// Solves the sample. Throws only Interrupted: if it cannot be solved, the Fit is not `solved`.
[[nodiscard]] Fit SolveSample(const Block& sample,
                              const CorrectionModel& corrections,
                              const FitOptions& options,
                              ProgressSink* progress);

/// The priors of a fit (quality/verdict_tests.h); all zero where it has none or no covariance.
[[nodiscard]] PriorSums PriorsOf(const Block& sample,
                                 const CorrectionModel& corrections,
                                 const Fit& fit);

/// Errors and redundancies of every look at a fit, NaN where it has none; columns range and
/// azimuth.
struct SampleResiduals {
  Eigen::MatrixX2d whitened_errors;  ///< over their standard deviations
  Eigen::MatrixX2d redundancy;       ///< part of an error of the measurement that its own residual
                                ///< shows while corrections stay: 1 less what its point follows
  /// v'Pv of the known points' own rows, and their redundancy in the same sense.
  double known_square = 0.0, known_redundancy = 0.0;
};
[[nodiscard]] SampleResiduals ResidualsOf(const Block& sample,
                                          const CorrectionModel& corrections,
                                          const Fit& fit);

/// What hypotheses are made of.
struct Facts {
  const Sample& sample;
  const std::vector<PassPredictions>& passes;  ///< of the sample's known points
  const CorrectionModel& corrections;
  const Fit& before;                 ///< the sample as it is
  const SampleResiduals& residuals;  ///< of `before`
  /// Hypotheses that change little can start from `before` (IsNear).
  [[nodiscard]] bool near() const { return IsNear(before); }
  /// Whether a mistake in the rows of these points alone may be an explanation: without all of them
  /// (no change of them does better) v'Pv falls by as much as an explanation must take.
  const std::function<bool(const std::vector<std::uint32_t>& points)>& may_explain;
};

using Hypotheses = std::vector<Hypothesis>;

/// Work of a diagnosis, counted and not timed, so that the same block gets the same answer on every
/// machine and with any number of threads. Its unit is a look formed: the equations of one look
/// made once, with its part of their elimination (docs/theory/diagnosis.md, eq. (11)).
class Work {
 public:
  enum class Start { kCold, kWarm };

  /// Bounds the work by so many `adjustments` of a block, of which a sample is solved; by less for
  /// a large block.
  Work(const Block& block, const Block& sample, double adjustments)
      : most_looks_(adjustments *
                    std::max(kFormedByAdjustment * static_cast<double>(block.looks.size()),
                             kMinSampleLooks * static_cast<double>(sample.looks.size()))) {
    if (std::isfinite(adjustments)) most_looks_ = std::min(most_looks_, kMaxLooks);
  }

  /// A solution of a sample of so many looks, and the recorded states that it copied.
  void AddSolution(std::size_t looks, const Fit& fit, Start start, std::size_t states) {
    const double of_start = fit.lost > 0 ? kStartOfLost : kStartValues;
    const double beside = kLastSum + (start == Start::kCold ? of_start : 0.0);
    done_looks_ += static_cast<double>(looks) * (fit.formed + beside) +
                   kCopiedState * static_cast<double>(states);
  }
  /// Adds the work of a path made of recorded states that does not go through them.
  void AddSmoothed(std::size_t states) {
    done_looks_ += kSmoothedState * static_cast<double>(states);
  }

  /// True while less than this part of the work is done.
  [[nodiscard]] bool Allows(double part) const { return done_looks_ < part * most_looks_; }
  [[nodiscard]] double done_looks() const { return done_looks_; }
  [[nodiscard]] double most_looks() const { return most_looks_; }

 private:
  /// Times that one adjustment forms each look, the work of its covariance included; and the least
  /// number per look of the sample, which is most of a small block.
  static constexpr double kFormedByAdjustment = 5.5, kMinSampleLooks = 54.0;
  /// Two seconds of work, more or less.
  static constexpr double kMaxLooks = 2e6;
  /// Work in looks formed once: of the last square sum with the places of the looks; of start
  /// values; of these where circles do not meet.
  static constexpr double kLastSum = 2.0, kStartValues = 2.0, kStartOfLost = 5.0;
  static constexpr double kCopiedState = 0.005, kSmoothedState = 4.0;

  double most_looks_;
  double done_looks_ = 0.0;
};

/// Solves a sample with mistakes undone, and counts how often and with how much work.
class Trials {
 public:
  Trials(const Block& sample, CorrectionModel corrections, Work work, ProgressSink* progress);

  /// The sample as it is.
  [[nodiscard]] Fit SolveGiven();
  /// From now on subtracts `empty_priors` from the redundancy of every fit: the redundancy of
  /// priors wider than their corrections, which adds no residuals.
  void LeaveOutOfRedundancy(double empty_priors) { empty_priors_ = empty_priors; }
  /// From now on changed standard deviations are weighed by these redundancy numbers of range and
  /// azimuth of the looks (Fit::log_sigmas); before that call they cost nothing.
  void WeighLogSigmas(Eigen::MatrixX2d redundancy) { redundancy_ = std::move(redundancy); }
  /// Solves the sample without the looks of some points.
  [[nodiscard]] Fit SolveWithout(const std::vector<std::uint32_t>& points,
                                 const FitOptions& options);
  [[nodiscard]] Fit With(const Hypothesis& hypothesis, double value, const FitOptions& options);
  /// The block that SolveGiven() solves: check points as control.
  [[nodiscard]] const Block& given() const { return given_; }
  [[nodiscard]] int solutions() const { return solutions_; }
  [[nodiscard]] const Work& work() const { return work_; }

 private:
  [[nodiscard]] Fit Solve(const Block& block,
                          const CorrectionModel& corrections,
                          const FitOptions& options);

  const Block& sample_;
  Block given_;
  CorrectionModel corrections_;
  Work work_;
  double empty_priors_ = 0.0;
  Eigen::MatrixX2d redundancy_;
  std::size_t states_ = 0;  ///< recorded states of the passes, which every trial copies
  ProgressSink* progress_;
  int solutions_ = 0;
};

/// A hypothesis solved: at its size, with the size's standard deviation where it is free.
struct Solved {
  double value = 0.0, sigma = kNotGiven;
  Fit fit;
};

struct SearchOptions {
  Effort effort = Effort::kFull;
  /// Cost above which a size is of no use: the search ends where even four times the decrease
  /// predicted by the parabola would not reach it.
  double useless_above = std::numeric_limits<double>::infinity();
  double part_of_work = 1.0;  ///< at which the search ends where it is
};

/// Finds the size of least cost from hypothesis.value on: Newton's steps on the parabola through
/// three solutions, a fixed number at most, fewer with Effort::kQuick. Its standard deviation is
/// that of the likelihood, sqrt(2 / cost''). Returns `first` where the cost has no minimum there.
[[nodiscard]] Solved SearchSize(const Hypothesis& hypothesis,
                                const Fit& first,
                                const SearchOptions& options,
                                Trials* trials);

/// v'Pv of some measurements and their redundancy.
struct LookSums {
  double square = 0.0, redundancy = 0.0;
};

/// The whole block, with these corrections, solved with a mistake undone.
struct BlockCure {
  Explanation::Cure cure;
  bool priors_hold = true;  ///< below what chance allows
  /// Only for mistakes in standard deviations: ranges and azimuths, of the passes concerned and of
  /// all passes.
  std::array<LookSums, 2> of_passes, of_all;
};
[[nodiscard]] BlockCure CureOf(const Block& given,
                               const CorrectionModel& corrections,
                               const Hypothesis& hypothesis,
                               double value,
                               double test_level,
                               ProgressSink* progress);
/// Whether the residuals of the block are large enough for the new standard deviations: ranges and
/// azimuths each, at the level of one test.
[[nodiscard]] bool BearsSigmas(const BlockCure& solved, double test_level);

/// Times that are late by a constant, searched from `late_s` on; empty `passes`: of all.
[[nodiscard]] Hypothesis ConstantTime(const std::vector<std::string>& passes,
                                      double late_s,
                                      double step_s);

/// Adds the hypotheses of times that this block gives reason to try, with first values
/// of their sizes: those that the predicted observations suggest, and those that show in a solution
/// alone.
void AddTimeMistakes(const Facts& facts, Hypotheses* out);

/// Ranges that are too long by a constant, searched from `longer_m` on; empty `passes`: of all.
[[nodiscard]] Hypothesis RangeBias(const std::vector<std::string>& passes,
                                   double longer_m,
                                   double step_m);

/// Adds the hypotheses of ranges that this block gives reason to try, with first values
/// of their sizes: those that the predicted observations suggest, and those that show in a solution
/// alone.
void AddRangeMistakes(const Facts& facts, Hypotheses* out);

/// Adds, for orbits, the hypotheses of delays that were not subtracted: of the troposphere, times
/// that grow with range, points that the tide displaced.
void AddDelayMistakes(const Facts& facts, Hypotheses* out);

/// Squints that are too large by a constant, searched from `value_rad` on; empty `passes`: of all.
[[nodiscard]] Hypothesis SquintBias(const std::vector<std::string>& passes,
                                    double value_rad,
                                    double step_rad);

/// Looks at native Doppler, whose squint changes with range, given as if it did not; the change is
/// searched from this one on. `constant_rad` is the squint at range zero of a change with range.
[[nodiscard]] Hypothesis NativeDoppler(const std::vector<std::string>& passes,
                                       const std::function<double(double per_m)>& constant_rad,
                                       double slope_rad_per_m,
                                       double step_rad_per_m);
/// The same for the pass of a solved constant squint, which is the mean squint, with the change
/// with range that the remaining residuals show; nothing where they show none.
[[nodiscard]] std::optional<Hypothesis> NativeBeside(const Facts& facts,
                                                     const Hypothesis& squint,
                                                     const Solved& solved);

/// Adds the hypotheses of look sides and cones that this block gives reason to try, with first
/// values of their sizes: those that the predicted observations suggest, and those that show in a
/// solution alone.
void AddConeMistakes(const Facts& facts, Hypotheses* out);

/// Adds the hypotheses of standard deviations of ranges and azimuths, of all passes and of those
/// whose residuals stand out; a few solutions estimate their variance components.
void AddSigmaMistakes(const Facts& facts, Trials* trials, Hypotheses* out);

/// Constants of time, range and squint, of one pass or of all, that Rao's score test (selection)
/// finds at the fit as it is: by the decrease of v'Pv in one linearisation, the largest first. None
/// where the sample was not solved.
[[nodiscard]] Hypotheses ScoredMistakes(const Facts& facts, ProgressSink* progress);

/// Adds the hypotheses of flight paths that this block gives reason to try, with first values
/// of their sizes: those that the predicted observations suggest, and those that show in a solution
/// alone.
void AddPathMistakes(const Facts& facts, Hypotheses* out);

/// Adds hypotheses of errors that are correlated in time: residuals of ranges or times of a pass
/// that vary slowly along its strip, and of all such passes together. docs/theory/diagnosis.md, eq.
/// (9).
void AddTimeCorrelatedMistakes(const Facts& facts, Trials* trials, Hypotheses* out);

/// Adds the hypotheses of mistakes in the corrections asked for: priors too tight (one solution
/// shows which and by how much), terms that are missing, passes taken as exact.
void AddModelMistakes(const Facts& facts, Trials* trials, Hypotheses* out);

/// Adds the hypotheses of known positions that this block gives reason to try, with first values
/// of their sizes: those that the predicted observations suggest, and those that show in a solution
/// alone.
void AddControlMistakes(const Facts& facts, Hypotheses* out);
/// Adds the hypothesis that all known points are shifted by one vector. Where their priors hold the
/// block, a correction of the paths that all passes share absorbs it.
void AddShiftedControl(const Facts& facts, Hypotheses* out);
/// Adds the hypothesis that the standard deviations of known points are too small: a few solutions
/// with other ones estimate their variance component.
void AddControlSigma(const Facts& facts, Trials* trials, Hypotheses* out);
/// Adds the hypotheses that doubtful known points are wrong, or exchanged in pairs, where that may
/// explain the block.
void AddKnownPointMistakes(const Facts& facts, Hypotheses* out);

/// Adds the hypotheses of single looks and points: time, range, or both that this block gives
/// reason to try, with first values of their sizes: those that the predicted observations suggest,
/// and those that show in a solution alone.
void AddLookMistakes(const Facts& facts, Hypotheses* out);

/// Adds the hypotheses that the ids of a pass are shifted by a row or by a time.
void AddShiftedIds(const Facts& facts, Hypotheses* out);
/// Adds the hypotheses that two suspects are exchanged in a pass, where both agree better then.
void AddExchangedPoints(const Facts& facts, Hypotheses* out);

/// Finds two passes whose ranges are equal at the points of both although their paths require
/// differences: one image was resampled to the other, which no change of the block can undo.
[[nodiscard]] std::optional<Explanation> FindCoregistered(const Facts& facts);

/// The most significant pattern in the residuals of a fit that is not noise: one sign in a pass, a
/// trend with range or time, correlation along the strip, heavy tails; empty where they are noise.
/// Points that were chosen because they are the worst (`suspects`) are left out. Heavy tails are no
/// objection where standard deviations are tried that are `much_larger` than those given and most
/// errors are as large as they say.
[[nodiscard]] std::string FindPattern(const Block& block,
                                      const std::vector<std::uint32_t>& suspects,
                                      const SampleResiduals& residuals,
                                      bool much_larger);

}  // namespace sarblock
