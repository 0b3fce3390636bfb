// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace sarblock {

/// What a mistake is about.
enum class MistakeKind : std::uint8_t {
  kTime,
  kRange,
  kCone,
  kPath,
  kControl,
  kIds,
  kSigma,
  kModel,  ///< corrections that are missing, or their priors
};
[[nodiscard]] const char* NameOf(MistakeKind kind);  ///< "time", "range", "cone", ...

/// One mistake that would explain why a block contradicts itself, with the evidence for it: the
/// weighted square sum v'Pv of a sample of the block as it is and with the mistake undone.
struct Explanation {
  MistakeKind kind = MistakeKind::kTime;
  std::string cause;     ///< stable word for programs: "time.constant", "ids.exchanged"
  std::string sentence;  ///< for people: what is wrong, how much of v'Pv it takes, what to change
  std::vector<std::string> passes;  ///< ids of the passes concerned; empty: all
  std::vector<std::string> points;  ///< ids of the points concerned
  double value = kNotGiven;         ///< size of the mistake; NaN where it has none
  double sigma = kNotGiven;         ///< its standard deviation
  std::string unit;                 ///< of value and sigma: "s", "m", "1", "rad/s"
  std::string equals;  ///< the known number that the value equals within its sigma; else empty
  std::string change;  ///< what to change: file and column, key of block.toml, correction
  double part = 0.0;   ///< of v'Pv that it takes away
  double square_sum_before = 0.0;  ///< v'Pv of the sample as it is
  double square_sum_after = 0.0;   ///< and with the mistake undone
  double redundancy_before = 0.0;  ///< of the sample as it is
  double redundancy_after = 0.0;   ///< less the parameters that undo the mistake
  /// The block as a whole with the mistake undone (docs/theory/diagnosis.md, "Cure").
  struct Cure {
    bool tried = false;  ///< solved; else the figures below are none
    bool cures = false;  ///< looks and control, and the priors, are within their bands
    double factor = kNotGiven, lower = kNotGiven, upper = kNotGiven;  ///< looks and control
    double priors_factor = kNotGiven;                                 ///< NaN without priors
    std::size_t points = 0;  ///< of the block or, where it is very large, of a part of it
  };
  Cure cure;
  /// Looks of the sample without a place (no intersection, or one where they do not look to).
  std::size_t looks_lost_before = 0, looks_lost_after = 0;
};

/// How much a diagnosis may do.
struct DiagnosisBounds {
  /// Work in adjustments of the block, counted and not timed (docs/theory/diagnosis.md, eq. (11)).
  /// Infinity: every hypothesis is tried.
  double adjustments = 5.0;
};

/// What was found, the most likely explanation first.
struct Diagnosis {
  bool contradicts = false;  ///< the sample fails its global test, or looks find no place
  std::vector<Explanation> explanations;
  /// What the residuals show that is no noise, where a standard deviation would explain them but
  /// for that; else empty.
  std::string pattern;
  std::vector<std::string> remarks;  ///< seen before any test: passes or points that are copies
  double square_sum = 0.0;           ///< v'Pv of the sample, check points as control
  double redundancy = 0.0;
  std::size_t points = 0;  ///< of the sample
  int hypotheses = 0;      ///< tried
  int solutions = 0;       ///< of the sample
  /// Hypotheses, or points that may be mistaken, that the bound of the work left untried.
  int untried = 0;
  /// Work done and its bound, in looks formed (docs/theory/diagnosis.md, eq. (11)).
  double work = 0.0, max_work = 0.0;
  /// Sentences for people, "most likely: " before the first explanation, "or: " before others.
  [[nodiscard]] std::vector<std::string> Sentences() const;
};

}  // namespace sarblock
