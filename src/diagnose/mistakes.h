// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "trials.h"

namespace sarblock {

/// Times that are late by a constant, from `late_s` on; empty `passes`: of all.
[[nodiscard]] Hypothesis ConstantTime(const std::vector<std::string>& passes,
                                      double late_s,
                                      double step_s);

/// Adds the hypotheses of times that this block gives reason to try, with first values
/// of their sizes: those that the predicted observations suggest, and those that show in a solution
/// alone.
void AddTimeMistakes(const Facts& facts, Hypotheses* out);

/// Ranges that are too long by a constant, from `longer_m` on; empty `passes`: of all.
[[nodiscard]] Hypothesis RangeBias(const std::vector<std::string>& passes,
                                   double longer_m,
                                   double step_m);

/// Adds the hypotheses of ranges that this block gives reason to try, with first values
/// of their sizes: those that the predicted observations suggest, and those that show in a solution
/// alone.
void AddRangeMistakes(const Facts& facts, Hypotheses* out);

/// Adds, for orbits, what ranges and times hold beyond geometry: a delay of the troposphere,
/// times that grow with range, points that the tide displaced.
void AddDelayMistakes(const Facts& facts, Hypotheses* out);

/// Squints that are too large by a constant, from `value_rad` on; empty `passes`: of all.
[[nodiscard]] Hypothesis SquintBias(const std::vector<std::string>& passes,
                                    double value_rad,
                                    double step_rad);

/// Looks at native Doppler, whose squint changes with range, given as if it did not: from this
/// change on. `constant_rad` is the squint at range zero of a change with range.
[[nodiscard]] Hypothesis NativeDoppler(const std::vector<std::string>& passes,
                                       const std::function<double(double per_m)>& constant_rad,
                                       double slope_rad_per_m,
                                       double step_rad_per_m);
/// The same of the pass of a constant squint that was solved, which is its mean, with the change
/// that the residuals beside it show; nothing where they show none.
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
/// finds at the fit as it is: what they would take off v'Pv in one linearisation, the most first.
/// Nothing where the fit is none.
[[nodiscard]] Hypotheses ScoredMistakes(const Facts& facts, ProgressSink* progress);

/// Adds the hypotheses of flight paths that this block gives reason to try, with first values
/// of their sizes: those that the predicted observations suggest, and those that show in a solution
/// alone.
void AddPathMistakes(const Facts& facts, Hypotheses* out);

/// Errors that are correlated in time: residuals of a pass that drift to and fro along its strip,
/// of its ranges or of its times, and of all such passes together. docs/theory/diagnosis.md, eq.
/// (9).
void AddTimeCorrelatedMistakes(const Facts& facts, Trials* trials, Hypotheses* out);

/// Adds those of the corrections asked for: priors too tight (one solution tells which and by how
/// much), terms that are missing, passes held as exact.
void AddModelMistakes(const Facts& facts, Trials* trials, Hypotheses* out);

/// Adds the hypotheses of known positions that this block gives reason to try, with first values
/// of their sizes: those that the predicted observations suggest, and those that show in a solution
/// alone.
void AddControlMistakes(const Facts& facts, Hypotheses* out);
/// That known points are all shifted by one vector, which a correction of the paths that all
/// passes share takes where their priors hold the block.
void AddShiftedControl(const Facts& facts, Hypotheses* out);
/// That the standard deviations of known points are too small: a few solutions with other ones
/// estimate their variance component.
void AddControlSigma(const Facts& facts, Trials* trials, Hypotheses* out);
/// Of single known points, and of pairs of them, whose rows may explain the block.
void AddKnownPointMistakes(const Facts& facts, Hypotheses* out);

/// Adds the hypotheses of single looks and points: time, range, or both that this block gives
/// reason to try, with first values of their sizes: those that the sightings suggest, and those
/// that show in a solution alone.
void AddLookMistakes(const Facts& facts, Hypotheses* out);

/// Adds the hypotheses that the ids of a pass are shifted by a row or by a time.
void AddShiftedIds(const Facts& facts, Hypotheses* out);
/// Adds the hypotheses that two suspects are exchanged in a pass, where both agree better then.
void AddExchangedPoints(const Facts& facts, Hypotheses* out);

/// Two passes whose ranges are alike at the points of both, where their paths ask for differences:
/// nothing in the block undoes that one image was resampled to the other.
[[nodiscard]] std::optional<Explanation> FindCoregistered(const Facts& facts);

/// What the residuals of a fit show that is no noise, the most striking: one sign in a pass, a
/// trend with range or time, correlation along the strip, heavy tails; empty where they are noise.
/// Points that were taken because they are the worst (`suspects`) say nothing of that. Heavy tails
/// are no objection where standard deviations are tried that are `much_larger` than those given and
/// most errors are as large as they say.
[[nodiscard]] std::string FindPattern(const Block& block,
                                      const std::vector<std::uint32_t>& suspects,
                                      const SampleResiduals& residuals,
                                      bool much_larger);

}  // namespace sarblock
