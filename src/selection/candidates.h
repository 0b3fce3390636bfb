// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "model/parameters.h"
#include "model/problem.h"
#include "quadratic_model.h"
#include <Eigen/Core>

namespace sarblock {

/// A level of a term and the columns it needs.
struct TermLevel {
  std::string name;          ///< "position.up.1", "position.up.spline 10 s", "range.bias"
  std::vector<int> columns;  ///< polynomial: of this degree alone; else all. Empty: not formed, or
                             ///< a spline that is no larger than the model before it
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

/// Corrections that are in the model only with a prior ("held"): by term and level - 1 the standard
/// deviation of the prior in SI units, NaN for others. The held levels of a term follow the kept
/// one.
using HeldSigmas = std::vector<std::vector<double>>;

/// Correction groups of a model: a level and, for a process, the variance of its prior by term, and
/// the levels held beyond.
[[nodiscard]] std::vector<CorrectionGroup> GroupsOf(const Block& block,
                                                    const Candidates& candidates,
                                                    const std::vector<std::size_t>& levels,
                                                    const std::vector<double>& variance_m2,
                                                    const HeldSigmas& held);

/// True where a candidate is determinable, significant and pays. `tests` share the level.
[[nodiscard]] bool Passes(const CandidateFigures& figures,
                          const SelectionOptions& options,
                          std::size_t tests);
/// Why a candidate is not in the model, by its figures; empty where it Passes().
[[nodiscard]] std::string WhyNot(const CandidateFigures& figures,
                                 const SelectionOptions& options,
                                 std::size_t tests);

/// The table of candidates while the selection goes on: one row a term and level.
class SelectionRows {
 public:
  void Note(std::size_t term,
            std::size_t level,
            SelectionTest test,
            const CandidateFigures& figures);
  void NoteStep(std::size_t term, std::size_t level, int step);
  /// The finished table at a model, a level by term.
  [[nodiscard]] std::vector<CandidateResult> Finish(const Candidates& candidates,
                                                    const std::vector<std::size_t>& levels,
                                                    const HeldSigmas& held,
                                                    const SelectionOptions& options) const;

 private:
  struct Row {
    SelectionTest test = SelectionTest::kNotTried;
    CandidateFigures figures;
    int step = 0;
  };
  Row& At(std::size_t term, std::size_t level);
  std::vector<std::vector<Row>> rows_;  // by term and level - 1
};

/// Text in passes.csv on a parameter of the chosen model.
[[nodiscard]] std::string KeptText(const SelectionReport& report,
                                   const std::string& owner,
                                   const std::string& parameter);

/// What a model of corrections leaves open.
struct Determinacy {
  double condition = 1.0;    ///< CandidateFigures::condition of all its columns
  double effect_part = 0.0;  ///< largest standard deviation of a parameter without a prior, as
                             ///< movement at the target, part of the mean slant range
};

/// Part of the mean slant range that one unit of each parameter moves a look; 0 where it has a
/// prior.
[[nodiscard]] Eigen::VectorXd EffectParts(const AdjustmentProblem& problem);

/// `s` and `full_diagonal` as in QuadraticModel::Data; `prior_weight` is added to both, and what
/// has one is not judged by its effect.
[[nodiscard]] Determinacy DeterminacyOf(const Eigen::MatrixXd& s,
                                        const Eigen::VectorXd& full_diagonal,
                                        const Eigen::VectorXd& prior_weight,
                                        const Eigen::VectorXd& effect_part,
                                        const std::vector<int>& active);

/// The largest condition that is asked for and that the rank analysis does not warn of.
[[nodiscard]] double MaxCondition(const SelectionOptions& options);

/// True for a model that the rank analysis of the following adjustment (solve/rank.h) neither
/// refuses nor warns of.
[[nodiscard]] bool IsAcceptable(const Determinacy& determinacy, const SelectionOptions& options);

}  // namespace sarblock
