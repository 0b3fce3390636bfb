// SPDX-License-Identifier: Apache-2.0
#include "selection_rows.h"

#include <cmath>
#include <sstream>

#include "selection_determinacy.h"
#include "solve/rank.h"

namespace sarblock {
namespace {

std::string Text(double value) {
  std::ostringstream text;
  text.precision(3);
  text << value;
  return text.str();
}

}  // namespace

std::string WhyNot(const CandidateFigures& figures,
                   const SelectionOptions& options,
                   std::size_t tests) {
  if (!std::isfinite(figures.condition_1)) {
    return "not determinable: the other unknowns can take up its effect; control or a prior would "
           "hold it";
  }
  if (!figures.regular) return "not determinable: no redundancy would be left";
  if (figures.condition_1 > MostCondition(options)) {
    return "not determinable: its condition is above " + Text(MostCondition(options));
  }
  if (figures.effect_part_1 > kNearEffectPart_1) {
    return "not determinable: with it a correction would have a standard deviation of more than " +
           Text(100.0 * kNearEffectPart_1) + " percent of the slant range";
  }
  if (figures.posterior_prior_1 > options.max_posterior_prior_1) {
    return "not determinable: the observations add little to its prior";
  }
  const double level_1 = options.significance_1 / static_cast<double>(tests);
  if (!(figures.probability_1 <= level_1)) {
    return "not significant: p is above " + Text(level_1) + " (" + Text(options.significance_1) +
           " over " + std::to_string(tests) + " terms)";
  }
  if (!(figures.delta_bic_1 < 0.0)) return "does not pay: the information criterion would grow";
  return {};
}

bool Passes(const CandidateFigures& figures, const SelectionOptions& options, std::size_t tests) {
  return WhyNot(figures, options, tests).empty();
}

SelectionRows::Row& SelectionRows::At(std::size_t term, std::size_t level) {
  if (rows_.size() <= term) rows_.resize(term + 1);
  if (rows_[term].size() < level) rows_[term].resize(level);
  return rows_[term][level - 1];
}

void SelectionRows::Note(std::size_t term,
                         std::size_t level,
                         SelectionTest test,
                         const CandidateFigures& figures) {
  Row& row = At(term, level);
  row.test = test;
  row.figures = figures;
}

void SelectionRows::NoteStep(std::size_t term, std::size_t level, int step) {
  At(term, level).step = step;
}

std::vector<CandidateResult> SelectionRows::Finish(const Candidates& candidates,
                                                   const std::vector<std::size_t>& levels,
                                                   const SelectionOptions& options) const {
  std::vector<CandidateResult> out;
  const std::size_t tests = candidates.terms.size();
  for (std::size_t t = 0; t < candidates.terms.size(); ++t) {
    const SelectionTerm& term = candidates.terms[t];
    const bool spline = levels[t] > 0 && term.levels[levels[t] - 1].spline;
    for (std::size_t l = 1; l <= term.levels.size(); ++l) {
      const TermLevel& level = term.levels[l - 1];
      Row row;
      if (t < rows_.size() && l <= rows_[t].size()) row = rows_[t][l - 1];
      CandidateResult result;
      result.name = level.name;
      result.passes = term.scope;
      result.step = row.step;
      result.kept = spline ? l == levels[t] : l <= levels[t];
      const bool contained = spline && l < levels[t];
      if (result.kept || (row.test == SelectionTest::kScore && !contained)) result.test = row.test;
      if (result.test != SelectionTest::kNotTried) {
        result.parameters = row.figures.columns;
        result.condition_1 = row.figures.condition_1;
      }
      if (result.test != SelectionTest::kNotTried && row.figures.regular) {
        result.statistic_1 = row.figures.statistic_1;
        result.f_1 = row.figures.f_1;
        result.probability_1 = row.figures.probability_1;
        result.delta_bic_1 = row.figures.delta_bic_1;
        result.posterior_prior_1 = row.figures.posterior_prior_1;
      }
      const std::string why = WhyNot(row.figures, options, tests);
      if (result.kept) {
        result.reason =
            why.empty() ? "determinable, significant and pays" : "below a degree that is kept";
        if (row.figures.variance_1 > 0.0) {
          result.reason += ", prior of " + Text(std::sqrt(row.figures.variance_1)) + " m";
        }
      } else if (contained) {
        result.reason = "contained in the spline that is kept";
      } else if (result.test == SelectionTest::kScore) {
        result.reason = why;
        if (why.empty()) result.reason = "another candidate of its term pays more";
      } else if (level.spline) {
        result.reason =
            "not tried: polynomials leave no misfit and no component needs the highest degree, or "
            "one holds as much";
      } else {
        result.reason = "not tried";
      }
      if (!result.kept && result.step > 0) {
        result.reason += "; dropped after it had entered";
      }
      out.push_back(std::move(result));
    }
  }
  return out;
}

std::string KeptText(const SelectionReport& report,
                     const std::string& owner,
                     const std::string& parameter) {
  const std::string stem = parameter.substr(0, parameter.rfind('.'));
  for (const CandidateResult& candidate : report.candidates) {
    if (!candidate.kept) continue;
    const bool spline = candidate.name.starts_with(stem + ".spline ") ||
                        candidate.name.starts_with(stem + ".process ");
    if (candidate.name != parameter && !spline) continue;
    const std::string among = " " + candidate.passes + " ";
    if (candidate.passes != "all" && among.find(" " + owner + " ") == std::string::npos) continue;
    return candidate.reason + ": F " + Text(candidate.f_1) + ", p " +
           Text(candidate.probability_1) + ", delta BIC " + Text(candidate.delta_bic_1);
  }
  return {};
}

}  // namespace sarblock
