// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/result.h"

#include <cstddef>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace sarblock {

/// A number that people's mistakes have, and what it is.
struct KnownNumber {
  double value = 0.0;  ///< in the unit of the hypothesis
  std::string text;
};

/// Size of a mistake as found: `text` is "18.000 +- 0.001 s", or the size that was tried.
struct Size {
  double value = kNotGiven, sigma = kNotGiven;
  std::string text;
};

struct CorrectionModel;
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
  /// A mistake in the corrections asked for: what undoes it there; empty for all others.
  std::function<void(CorrectionModel*, double value)> remodel;
  double log_cost = 0.0;  ///< on -2 log of the likelihood by `value`, of wider priors
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
  /// What known points do not show, or a score test found: solved without the screening.
  bool screened = false;
  /// Where it stands among those that are tried: what the laws of motion show; corrections that
  /// were chosen; what the data tell
  /// by themselves, also those with which known points keep less than a tenth of their misfit; what
  /// scores show; known points that keep more; what is guessed.
  double order = kGuessed;
  static constexpr double kCertain = 0.0, kChosen = 0.05, kReported = 0.1, kScored = 0.6,
                          kWeak = 0.7, kGuessed = 1.0;
  /// Changes one of the measurements that the hypothesis before leaves out: of no use where that is
  /// of none.
  bool within_last = false;
  /// Recorded states that undoing it makes paths of which do not go through them.
  std::size_t smoothed_states = 0;
  /// Not reported where v'Pv over its redundancy stays above this: a curve takes a part of
  /// anything.
  double max_unexplained = std::numeric_limits<double>::infinity();
  /// Changes little of the whole: solved from where the sample as it is ended.
  bool local = false;
  /// Undone in the points of the sample alone: the whole block cannot say what it does.
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

/// The text of the number that a size equals within four of its sigmas and a thousandth; empty
/// where none or where the sigma is so large that it says nothing.
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

}  // namespace sarblock
