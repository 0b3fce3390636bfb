// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/options.h"

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "model/parameters.h"
#include "model/problem.h"

namespace sarblock {

/// A level of a term and the columns it needs.
struct TermLevel {
  std::string name;          ///< "position.up.1", "position.up.spline 10 s", "range.bias"
  std::vector<int> columns;  ///< polynomial: of this degree alone; else all. Empty: not formed, or
                             ///< a spline that is no larger than what stands before it
  bool spline = false;       ///< replaces the levels below
  double spacing_s = kNotGiven;
  bool process = false;  ///< the spline before, with one prior for its coefficients
};

/// What the selection switches on step by step: one component of the position, a bias; of one pass,
/// of all passes alike or of a shared group. Level 0 is off, level l the first l entries of
/// `levels`, or a spline alone.
struct SelectionTerm {
  std::size_t group = 0;  ///< index of the candidate group
  int axis = -1;          ///< of a position or velocity group
  std::string scope;      ///< "all", pass ids, or a shared group's name
  std::vector<std::size_t> passes;
  std::vector<TermLevel> levels;

  /// Columns of the model at a level.
  [[nodiscard]] std::vector<int> ColumnsAt(std::size_t level) const;
  /// Highest level of the polynomial; 0 for a term that is a spline alone.
  [[nodiscard]] std::size_t Degrees() const;
};

/// All candidates of a block: their groups together as one adjustment problem, and the terms.
struct Candidates {
  std::vector<CorrectionGroup> groups;    ///< as asked for, looks-free passes left out
  std::vector<CorrectionGroup> extended;  ///< the same and the splines: the extended problem's
  std::vector<SelectionTerm> terms;
  /// By column of the extended problem: what a parameter is called in a chosen model.
  std::vector<Parameter> parameters;
};

/// Lists the candidates of `options` for the looks in use. Splines that may replace a polynomial
/// are always listed, with columns only where `spline_groups` names their candidate group.
[[nodiscard]] Candidates MakeCandidates(const AdjustmentProblem& measured,
                                        const AdjustOptions& options,
                                        const std::vector<std::size_t>& spline_groups);

/// Correction groups of a model: a level and, for a process, the variance of its prior by term.
[[nodiscard]] std::vector<CorrectionGroup> GroupsOf(const Block& block,
                                                    const Candidates& candidates,
                                                    const std::vector<std::size_t>& levels,
                                                    const std::vector<double>& variance_m2);

}  // namespace sarblock
