// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <string>
#include <vector>

#include "quadratic_model.h"
#include "selection_terms.h"

namespace sarblock {

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

/// What passes.csv says of a parameter of the chosen model.
[[nodiscard]] std::string KeptText(const SelectionReport& report,
                                   const std::string& owner,
                                   const std::string& parameter);

}  // namespace sarblock
