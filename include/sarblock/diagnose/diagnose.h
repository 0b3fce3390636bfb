// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <optional>
#include <string>
#include <vector>

namespace sarblock {

/// How much a diagnosis may do.
struct DiagnosisBounds {
  /// Work in adjustments of the block, counted and not timed (docs/theory/diagnosis.md, eq. (11)).
  /// Infinity: every hypothesis is tried.
  double adjustments = 5.0;
};

/// Explains why a block contradicts itself by mistakes that people make: times, ranges, look sides,
/// cones, flight paths, known positions, ids and standard deviations (docs/theory/diagnosis.md has
/// the list). Each hypothesis is a change of the block with at most one free size c. It is tried on
/// a sample of the points, check points as control, and kept if with it
///
///     F = ((v'Pv before - v'Pv after)/k) / (v'Pv after / redundancy after)
///
/// is significant, all hypotheses tried together, and it explains at least half of the excess of
/// v'Pv over its redundancy. Ordered by -2 log L of the looks with the parameters counted (BIC), so
/// that other standard deviations compete fairly with other values. The size is the minimum of
/// v'Pv(c), its standard deviation from the curvature there.
///
/// Corrections are those of `options` where given, with their priors. Hypotheses are tried in the
/// order of their promise until `bounds` end it; those left are counted (Diagnosis::untried). The
/// same block has the same diagnosis with any number of threads. A block in which nothing
/// contradicts has no explanations. Throws only Interrupted: blocks that cannot be solved are its
/// purpose.
[[nodiscard]] Diagnosis Diagnose(const Block& block,
                                 const AdjustOptions& options,
                                 ProgressSink* progress = nullptr,
                                 const DiagnosisBounds& bounds = {});

/// The diagnosis of a block whose result is not accepted or fails a test; nothing where all is
/// well, or the only reason is that the solution did not converge: a mistake shows in tests. Its
/// sentences become the first reasons of the verdict, its remarks warnings of the result unless
/// `warnings`, those of reading the block, have them already.
std::optional<Diagnosis> ExplainFailure(const Block& block,
                                        const AdjustOptions& options,
                                        const std::vector<std::string>& warnings,
                                        AdjustResult* result,
                                        ProgressSink* progress = nullptr);

/// The diagnosis of a block that was refused, for people who have read the refusal: of its
/// explanations only those with which the whole block is determined and sound, or with which half
/// of the looks without a place find one. An explanation that only lowers v'Pv does not say why a
/// datum, equations or points are missing.
[[nodiscard]] Diagnosis ExplainRefusal(const Block& block,
                                       const AdjustOptions& options,
                                       ProgressSink* progress = nullptr);

/// Remarks of a diagnosis that are not among `warnings`.
[[nodiscard]] std::vector<std::string> RemarksBeside(const std::vector<std::string>& warnings,
                                                     const Diagnosis& diagnosis);

}  // namespace sarblock
