// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/corrections.h"
#include "sarblock/model/simplified.h"

#include <string>
#include <vector>

namespace sarblock {

/// How a candidate was tested last.
enum class SelectionTest {
  kScore,    ///< Rao's score: what adding it to the final model would take off v'Pv
  kWald,     ///< what leaving it out of the final model would add to v'Pv
  kNotTried  ///< what it needs is not in the model
};

/// One candidate of the model selection with its figures at the final model. Degree d of a position
/// polynomial that is not kept stands for all degrees above the kept ones up to d, together; a
/// spline replaces the polynomial of its component. docs/theory/selection.md.
struct CandidateResult {
  std::string name;    ///< "position.up.1", "position.up.spline 10 s", "range.bias"
  std::string passes;  ///< "all", pass ids, or the name of a shared group
  int parameters = 0;  ///< that it adds
  SelectionTest test = SelectionTest::kNotTried;
  double statistic_1 = kNotGiven;        ///< score or Wald statistic: the change of v'Pv
  double f_1 = kNotGiven;                ///< F
  double probability_1 = kNotGiven;      ///< of a larger F without the correction
  double delta_bic_1 = kNotGiven;        ///< with less without; below 0 it pays
  double condition_1 = kNotGiven;        ///< largest factor by which the other unknowns, points
                                         ///< included, inflate a variance; infinite: singular
  double posterior_prior_1 = kNotGiven;  ///< mean ratio of standard deviations; NaN: no prior
  bool kept = false;
  int step = 0;  ///< in which it entered, or was dropped after it had; 0: neither
  std::string reason;
};

/// What a simplification of the model would do to the points (simplifications.h).
struct SimplificationBound {
  std::string name{};             ///< "flat-frame", "fixed-track-axes", "linear-velocity"
  double bound_m = kNotGiven;     ///< no point moves by more, at the point with the largest part
  double sigma_m = kNotGiven;     ///< its standard deviation, paths held
  double fraction_1 = kNotGiven;  ///< bound over sigma, the largest of all points
  bool allowed = false;           ///< the part is below the limit
  bool taken = false;             ///< the result is that of a model without it
  double gain_1 = kNotGiven;      ///< measured: time of evaluating a look with it over without it;
                                  ///< NaN where there is nothing to gain or it is not allowed
  std::string verdict{};          ///< "taken", "not allowed" or why it was not taken
};

/// The outcome of a model selection.
struct SelectionReport {
  std::vector<CandidateResult> candidates;  ///< every one, in the order of the candidate groups
  std::vector<CorrectionGroup> groups;      ///< the model chosen; may be empty
  std::vector<SimplificationBound> simplifications;  ///< all four; empty without solved points
  Simplified simplified;                             ///< what was taken
  double simplified_gain_1 = kNotGiven;              ///< measured, of all that was taken together
  double simplified_shift_1 = kNotGiven;  ///< by which the full model would move a point, in sigmas
                                          ///< of it: of what was taken, or given up for that
  int rounds = 0;                         ///< linearisations
  int steps = 0;                          ///< candidates that entered or were dropped
  bool settled = true;                    ///< the last round changed nothing
  [[nodiscard]] bool empty() const { return candidates.empty(); }
};

}  // namespace sarblock
