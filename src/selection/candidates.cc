// SPDX-License-Identifier: Apache-2.0
#include "candidates.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <limits>
#include <map>
#include <sstream>
#include <utility>

#include "linear/dense.h"
#include "quadratic_model.h"
#include "solve/rank.h"
#include "solve/weak_directions.h"
#include <glog/logging.h>

namespace sarblock {
namespace {

using Axes = PositionCorrection::Axes;
using Basis = PositionCorrection::Basis;

std::vector<std::size_t> LooksByPass(const AdjustmentProblem& problem) {
  std::vector<std::size_t> looks(problem.block.passes.size(), 0);
  for (std::size_t i = 0; i < problem.look_used.size(); ++i) {
    if (problem.look_used[i] != 0) ++looks[problem.block.looks.pass[i]];
  }
  return looks;
}

CorrectionGroup StandardGroup(CorrectionKind kind, int max_degree) {
  CorrectionGroup group;
  switch (kind) {
    case CorrectionKind::kPosition: {
      PositionCorrection position;
      position.degree = max_degree;
      group.name = "position";
      group.model = position;
      break;
    }
    case CorrectionKind::kVelocity:
      group.name = "velocity";
      group.model = VelocityCorrection{};
      break;
    case CorrectionKind::kRange: {
      RangeCorrection range;
      range.bias = range.scale = true;
      group.name = "range";
      group.model = range;
      break;
    }
    case CorrectionKind::kTime:
      group.name = "time";
      group.model = TimeCorrection{};
      break;
    case CorrectionKind::kSquint:
      group.name = "squint";
      group.model = SquintCorrection{};
      break;
    case CorrectionKind::kTroposphere:
      group.name = "troposphere";
      group.model = TroposphereCorrection{};
      break;
  }
  return group;
}

/// The passes of a group that have looks, by index.
std::vector<std::size_t> MembersOf(const Block& block,
                                   const CorrectionGroup& group,
                                   const std::vector<std::size_t>& looks) {
  std::vector<std::size_t> members;
  for (std::size_t i = 0; i < block.passes.size(); ++i) {
    const bool named = group.passes.empty() ||
                       std::find(group.passes.begin(), group.passes.end(), block.passes[i].id) !=
                           group.passes.end();
    if (named && looks[i] > 0) members.push_back(i);
  }
  return members;
}

/// Sets the passes of a group; all passes of the block is the empty list.
void SetPasses(const Block& block, std::vector<std::size_t> members, CorrectionGroup* group) {
  group->passes.clear();
  std::sort(members.begin(), members.end());
  if (members.size() == block.passes.size()) return;
  for (const std::size_t pass : members) group->passes.push_back(block.passes[pass].id);
}

bool HasPrior(const PositionCorrection& position) {
  return std::any_of(position.prior_sigma_m.begin(),
                     position.prior_sigma_m.end(),
                     [](const std::vector<double>& sigma_m) { return !sigma_m.empty(); });
}

std::vector<double> Spacings(const Block& block, const SelectionOptions& options) {
  if (options.knot_spacings_s) {
    std::vector<double> spacings_s = *options.knot_spacings_s;
    std::sort(spacings_s.rbegin(), spacings_s.rend());
    return spacings_s;
  }
  double longest_s = 0.0;
  for (const Pass& pass : block.passes) longest_s = std::max(longest_s, pass.end_s - pass.start_s);
  return {longest_s / 4.0, longest_s / 8.0};
}

std::string SpacingText(double spacing_s) {
  std::ostringstream text;
  text << spacing_s << " s";
  return text.str();
}

/// Name of an auxiliary group; the control character keeps it apart from names of passes.
std::string SplineOwner(std::size_t group, std::size_t spacing, const std::string& pass) {
  return "\x01" + std::to_string(group) + "/" + std::to_string(spacing) + "/" + pass;
}

const char* AxisName(const PositionCorrection& position, int axis) {
  const auto i = static_cast<std::size_t>(axis);
  return position.axes == Axes::kTrack ? kTrackAxisNames[i] : kFrameAxisNames[i];
}

/// One set of passes that is chosen for together.
struct Scope {
  std::string label;
  std::vector<std::size_t> passes;
  std::vector<std::string> owners;  ///< of the parameters, as the layout names them
};

class Lister {
 public:
  Lister(const AdjustmentProblem& measured,
         const AdjustOptions& options,
         const std::vector<std::size_t>& spline_groups)
      : block_(measured.block), options_(options), spline_groups_(spline_groups) {
    looks_ = LooksByPass(measured);
    spacings_s_ = Spacings(block_, options.selection);
  }

  Candidates List() {
    std::vector<CorrectionGroup> asked = options_.groups;
    if (asked.empty()) {
      for (const CorrectionKind kind : options_.selection.kinds) {
        asked.push_back(StandardGroup(kind, options_.selection.max_degree));
      }
    }
    for (CorrectionGroup& group : asked) {
      const std::vector<std::size_t> members = MembersOf(block_, group, looks_);
      if (members.empty()) continue;
      SetPasses(block_, members, &group);
      out_.groups.push_back(group);
      members_.push_back(members);
    }
    Extend();
    const ParameterLayout layout = MakeParameterLayout(block_, out_.extended);
    out_.parameters = layout.parameters;
    for (std::size_t i = 0; i < layout.parameters.size(); ++i) {
      column_of_[{layout.parameters[i].owner, layout.parameters[i].name}].push_back(
          static_cast<int>(i));
    }
    for (std::size_t g = 0; g < out_.groups.size(); ++g) ListGroup(g);
    return std::move(out_);
  }

 private:
  void Extend() {
    out_.extended = out_.groups;
    for (const std::size_t g : spline_groups_) {
      const auto& position = std::get<PositionCorrection>(out_.groups[g].model);
      for (std::size_t s = 0; s < spacings_s_.size(); ++s) {
        for (const std::size_t pass : members_[g]) {
          CorrectionGroup spline = out_.groups[g];
          PositionCorrection model = position;
          model.basis = Basis::kSpline;
          model.degree = 0;
          model.knot_spacing_s = spacings_s_[s];
          spline.model = model;
          // Not shared: together with the polynomial of the same component, which a group of the
          // pass's own must not be.
          spline.shared = true;
          spline.name = SplineOwner(g, s, block_.passes[pass].id);
          spline.passes = {block_.passes[pass].id};
          pass_of_spline_[spline.name] = block_.passes[pass].id;
          out_.extended.push_back(std::move(spline));
        }
      }
    }
  }

  std::vector<Scope> ScopesOf(std::size_t g) const {
    const CorrectionGroup& group = out_.groups[g];
    std::vector<Scope> scopes;
    if (group.shared) return {{group.name, members_[g], {group.name}}};
    for (const std::size_t pass : members_[g]) {
      const std::string& id = block_.passes[pass].id;
      const bool new_scope =
          scopes.empty() || options_.selection.mode == SelectionOptions::Mode::kPerPass;
      if (new_scope) scopes.emplace_back();
      Scope& scope = scopes.back();
      scope.label += (scope.label.empty() ? "" : " ") + id;
      scope.passes.push_back(pass);
      scope.owners.push_back(id);
    }
    if (options_.selection.mode == SelectionOptions::Mode::kCommon && group.passes.empty()) {
      scopes.front().label = "all";
    }
    return scopes;
  }

  /// Columns of one parameter name for all owners of a scope.
  void AddColumns(const Scope& scope, const std::string& name, std::vector<int>* columns) const {
    for (const std::string& owner : scope.owners) {
      const auto found = column_of_.find({owner, name});
      CHECK(found != column_of_.end()) << owner << " " << name;
      columns->push_back(found->second.front());
    }
  }

  void AddPlain(std::size_t g, const Scope& scope, int axis, const std::string& name) {
    SelectionTerm term{g, axis, scope.label, scope.passes, {}};
    TermLevel level;
    level.name = name;
    AddColumns(scope, name, &level.columns);
    term.levels.push_back(std::move(level));
    out_.terms.push_back(std::move(term));
  }

  /// Coefficients of a spline, whose number differs with the length of the strip.
  void AddSplineColumns(const Scope& scope,
                        const std::string& stem,
                        std::vector<int>* columns) const {
    for (const std::string& owner : scope.owners) {
      for (int q = 0;; ++q) {
        const std::string name = stem + "." + std::to_string(q);
        if (!column_of_.contains({owner, name})) break;
        AddColumns({{}, {}, {owner}}, name, columns);
      }
    }
  }

  void AddPosition(std::size_t g, const Scope& scope, const PositionCorrection& position) {
    for (int axis = 0; axis < 3; ++axis) {
      if (!position.components[static_cast<std::size_t>(axis)]) continue;
      const std::string stem = std::string("position.") + AxisName(position, axis);
      SelectionTerm term{g, axis, scope.label, scope.passes, {}};
      if (position.basis == Basis::kSpline) {
        TermLevel level{stem + ".spline " + SpacingText(position.knot_spacing_s),
                        {},
                        true,
                        position.knot_spacing_s};
        AddSplineColumns(scope, stem, &level.columns);
        term.levels.push_back(std::move(level));
        out_.terms.push_back(std::move(term));
        continue;
      }
      std::size_t degree_columns = 0;
      for (int k = 0; k <= position.degree; ++k) {
        TermLevel level;
        level.name = stem + "." + std::to_string(k);
        AddColumns(scope, level.name, &level.columns);
        degree_columns += level.columns.size();
        term.levels.push_back(std::move(level));
      }
      if (!out_.groups[g].shared && !HasPrior(position)) {
        AddReplacements(g, scope, stem, position, degree_columns, &term);
      }
      out_.terms.push_back(std::move(term));
    }
  }

  void AddReplacements(std::size_t g,
                       const Scope& scope,
                       const std::string& stem,
                       const PositionCorrection& position,
                       std::size_t degree_columns,
                       SelectionTerm* term) {
    // A cubic spline contains cubic polynomials, no higher ones.
    if (position.degree > 3) return;
    const bool formed =
        std::find(spline_groups_.begin(), spline_groups_.end(), g) != spline_groups_.end();
    std::size_t widest = degree_columns;
    for (std::size_t s = 0; s < spacings_s_.size(); ++s) {
      TermLevel level{stem + ".spline " + SpacingText(spacings_s_[s]), {}, true, spacings_s_[s]};
      if (formed) {
        Scope spline = scope;
        for (std::size_t i = 0; i < scope.passes.size(); ++i) {
          spline.owners[i] = SplineOwner(g, s, block_.passes[scope.passes[i]].id);
        }
        AddSplineColumns(spline, stem, &level.columns);
        // What is no larger than the polynomial, or than the spline before, says nothing new.
        if (level.columns.size() <= widest) level.columns.clear();
        widest = std::max(widest, level.columns.size());
        for (const int column : level.columns) {
          Parameter& parameter = out_.parameters[static_cast<std::size_t>(column)];
          const auto pass = pass_of_spline_.find(parameter.owner);
          if (pass != pass_of_spline_.end()) parameter.owner = pass->second;
        }
      }
      term->levels.push_back(std::move(level));
    }
    if (spacings_s_.empty()) return;
    TermLevel process = term->levels.back();
    process.name = stem + ".process " + SpacingText(process.spacing_s);
    process.process = true;
    term->levels.push_back(std::move(process));
  }

  void ListGroup(std::size_t g) {
    const CorrectionGroup group = out_.groups[g];
    for (const Scope& scope : ScopesOf(g)) {
      if (const auto* position = std::get_if<PositionCorrection>(&group.model)) {
        AddPosition(g, scope, *position);
      } else if (const auto* velocity = std::get_if<VelocityCorrection>(&group.model)) {
        if (velocity->components[0]) AddPlain(g, scope, 0, "velocity.across");
        if (velocity->components[1]) AddPlain(g, scope, 1, "velocity.up");
      } else if (const auto* range = std::get_if<RangeCorrection>(&group.model)) {
        if (range->bias) AddPlain(g, scope, 0, "range.bias");
        if (range->scale) AddPlain(g, scope, 1, "range.scale");
      } else if (std::holds_alternative<TimeCorrection>(group.model)) {
        AddPlain(g, scope, -1, "time.bias");
      } else if (std::holds_alternative<SquintCorrection>(group.model)) {
        AddPlain(g, scope, -1, "squint.bias");
      } else {
        AddPlain(g, scope, -1, "troposphere.zenith");
      }
    }
  }

  const Block& block_;
  const AdjustOptions& options_;
  const std::vector<std::size_t>& spline_groups_;
  std::vector<std::size_t> looks_;
  std::vector<double> spacings_s_;
  std::vector<std::vector<std::size_t>> members_;
  /// By owner and name of a parameter.
  std::map<std::pair<std::string, std::string>, std::vector<int>> column_of_;
  std::map<std::string, std::string> pass_of_spline_;  ///< by SplineOwner()
  Candidates out_;
};

/// Corrections of one group at one pass, by axis (or parameter).
struct PassLevels {
  std::array<std::size_t, 3> levels{};         ///< the held ones included
  std::array<std::vector<double>, 3> sigma{};  ///< of the priors, by degree; 0: none
  auto operator<=>(const PassLevels&) const = default;
};

/// What a term has in a model at a level, with what is held beyond.
struct TermPriors {
  std::size_t level = 0;
  std::vector<double> sigma;
};

TermPriors PriorsAt(const Candidates& candidates,
                    const SelectionTerm& term,
                    std::size_t level,
                    double variance_m2,
                    const std::vector<double>& held) {
  TermPriors out{level, {}};
  const auto own_prior = [&](std::size_t l) {
    const std::vector<int>& columns = term.levels[l - 1].columns;
    const double sigma =
        columns.empty()
            ? kNotGiven
            : candidates.parameters[static_cast<std::size_t>(columns.front())].prior_sigma;
    return std::isnan(sigma) ? 0.0 : sigma;
  };
  if (level > 0 && term.levels[level - 1].spline) {
    out.sigma = {term.levels[level - 1].process ? std::sqrt(variance_m2) : own_prior(level)};
    return out;
  }
  for (std::size_t l = 1; l <= level; ++l) out.sigma.push_back(own_prior(l));
  for (std::size_t l = level + 1; l <= held.size() && !std::isnan(held[l - 1]); ++l) {
    out.sigma.push_back(held[l - 1]);
    out.level = l;
  }
  return out;
}

/// The part of a position group whose components are at one level.
CorrectionGroup PositionAt(const CorrectionGroup& group,
                           const std::array<bool, 3>& components,
                           const TermLevel& top,
                           const PassLevels& at,
                           std::size_t level) {
  CorrectionGroup out = group;
  auto& position = std::get<PositionCorrection>(out.model);
  position.components = components;
  if (top.spline) {
    position.basis = Basis::kSpline;
    position.degree = 0;
    position.knot_spacing_s = top.spacing_s;
  } else {
    position.degree = static_cast<int>(level) - 1;
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::vector<double>& sigma_m = position.prior_sigma_m[axis];
    sigma_m.clear();
    if (!components[axis]) continue;
    for (const double sigma : at.sigma[axis]) sigma_m.push_back(sigma > 0.0 ? sigma : kNotGiven);
    if (std::all_of(sigma_m.begin(), sigma_m.end(), [](double s) { return std::isnan(s); })) {
      sigma_m.clear();
    }
  }
  return out;
}

std::vector<CorrectionGroup> PartsAt(const CorrectionGroup& group,
                                     const PassLevels& at,
                                     const std::array<const SelectionTerm*, 3>& terms) {
  std::vector<CorrectionGroup> out;
  const std::array<std::size_t, 3>& levels = at.levels;
  if (std::holds_alternative<PositionCorrection>(group.model)) {
    std::array<bool, 3> done{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (levels[axis] == 0 || done[axis]) continue;
      std::array<bool, 3> components{};
      for (std::size_t other = axis; other < 3; ++other) {
        components[other] = levels[other] == levels[axis];
        done[other] = done[other] || components[other];
      }
      out.push_back(
          PositionAt(group, components, terms[axis]->levels[levels[axis] - 1], at, levels[axis]));
    }
    return out;
  }
  if (levels[0] == 0 && levels[1] == 0) return out;
  CorrectionGroup part = group;
  const auto prior = [&at](std::size_t slot) {
    return at.levels[slot] > 0 && at.sigma[slot][0] > 0.0 ? at.sigma[slot][0] : kNotGiven;
  };
  if (auto* velocity = std::get_if<VelocityCorrection>(&part.model)) {
    velocity->components = {levels[0] > 0, levels[1] > 0};
    velocity->prior_sigma = {prior(0), prior(1)};
  } else if (auto* range = std::get_if<RangeCorrection>(&part.model)) {
    *range = {levels[0] > 0, prior(0), levels[1] > 0, prior(1)};
  } else if (auto* time = std::get_if<TimeCorrection>(&part.model)) {
    time->bias_prior_sigma_s = prior(0);
  } else if (auto* squint = std::get_if<SquintCorrection>(&part.model)) {
    squint->bias_prior_sigma_rad = prior(0);
  } else if (auto* air = std::get_if<TroposphereCorrection>(&part.model)) {
    air->zenith_prior_sigma_m = prior(0);
  }
  out.push_back(std::move(part));
  return out;
}

}  // namespace

std::vector<int> SelectionTerm::ColumnsAt(std::size_t level) const {
  if (level == 0) return {};
  if (levels[level - 1].spline) return levels[level - 1].columns;
  std::vector<int> columns;
  for (std::size_t l = 0; l < level; ++l) {
    columns.insert(columns.end(), levels[l].columns.begin(), levels[l].columns.end());
  }
  return columns;
}

std::size_t SelectionTerm::Degrees() const {
  return static_cast<std::size_t>(std::count_if(
      levels.begin(), levels.end(), [](const TermLevel& level) { return !level.spline; }));
}

Candidates MakeCandidates(const AdjustmentProblem& measured,
                          const AdjustOptions& options,
                          const std::vector<std::size_t>& spline_groups) {
  return Lister(measured, options, spline_groups).List();
}

std::vector<CorrectionGroup> GroupsOf(const Block& block,
                                      const Candidates& candidates,
                                      const std::vector<std::size_t>& levels,
                                      const std::vector<double>& variance_m2,
                                      const HeldSigmas& held) {
  std::vector<CorrectionGroup> out;
  for (std::size_t g = 0; g < candidates.groups.size(); ++g) {
    const CorrectionGroup& group = candidates.groups[g];
    std::map<std::size_t, PassLevels> by_pass;
    std::array<const SelectionTerm*, 3> terms{};
    for (std::size_t t = 0; t < candidates.terms.size(); ++t) {
      const SelectionTerm& term = candidates.terms[t];
      if (term.group != g) continue;
      const auto slot = static_cast<std::size_t>(std::max(term.axis, 0));
      terms[slot] = &term;
      const TermPriors priors = PriorsAt(candidates, term, levels[t], variance_m2[t], held[t]);
      for (const std::size_t pass : term.passes) {
        by_pass[pass].levels[slot] = priors.level;
        by_pass[pass].sigma[slot] = priors.sigma;
      }
    }
    // Passes of one pattern are in one group.
    std::map<PassLevels, std::vector<std::size_t>> by_pattern;
    for (const auto& [pass, pattern] : by_pass) by_pattern[pattern].push_back(pass);
    for (const auto& [pattern, passes] : by_pattern) {
      for (CorrectionGroup& part : PartsAt(group, pattern, terms)) {
        if (!group.shared) SetPasses(block, passes, &part);
        out.push_back(std::move(part));
      }
    }
  }
  return out;
}

namespace {

std::string Text(double value) {
  std::ostringstream text;
  text.precision(3);
  text << value;
  return text.str();
}

const Parameter& ParameterOf(const Candidates& candidates, const TermLevel& level) {
  return candidates.parameters[static_cast<std::size_t>(level.columns.front())];
}

std::string HeldText(const Parameter& parameter, double sigma) {
  return Text(sigma) + (parameter.unit == "1" ? "" : " " + parameter.unit);
}

}  // namespace

std::string WhyNot(const CandidateFigures& figures,
                   const SelectionOptions& options,
                   std::size_t tests) {
  if (!std::isfinite(figures.condition)) {
    return "not determinable: the other unknowns can take up its effect; control or a prior would "
           "hold it";
  }
  if (!figures.regular) return "not determinable: no redundancy would be left";
  if (figures.condition > MaxCondition(options)) {
    return "not determinable: its condition is above " + Text(MaxCondition(options));
  }
  if (figures.effect_part > kNearEffectPart) {
    return "not determinable: with it a correction would have a standard deviation of more than " +
           Text(100.0 * kNearEffectPart) + " percent of the slant range";
  }
  if (figures.posterior_prior > options.max_posterior_prior) {
    return "not determinable: the observations add little to its prior";
  }
  const double level = options.significance / static_cast<double>(tests);
  if (!(figures.probability <= level)) {
    return "not significant: p is above " + Text(level) + " (" + Text(options.significance) +
           " over " + std::to_string(tests) + " terms)";
  }
  if (!(figures.delta_bic < 0.0)) return "does not pay: the information criterion would grow";
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
                                                   const HeldSigmas& held,
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
        result.condition = row.figures.condition;
      }
      if (result.test != SelectionTest::kNotTried && row.figures.regular) {
        result.statistic = row.figures.statistic;
        result.f = row.figures.f;
        result.probability = row.figures.probability;
        result.delta_bic = row.figures.delta_bic;
        result.posterior_prior = row.figures.posterior_prior;
      }
      const std::string why = WhyNot(row.figures, options, tests);
      if (result.kept) {
        result.reason =
            why.empty() ? "determinable, significant and pays" : "below a degree that is kept";
        if (row.figures.variance > 0.0) {
          result.reason += ", prior of " + Text(std::sqrt(row.figures.variance)) + " m";
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
      if (l <= held[t].size() && !std::isnan(held[t][l - 1])) {
        const Parameter& parameter = ParameterOf(candidates, level);
        result.held = true;
        result.reason += parameter.has_prior() ? "; held by its prior"
                                               : "; held by a prior that was estimated, " +
                                                     HeldText(parameter, held[t][l - 1]);
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
    if (!candidate.kept && !candidate.held) continue;
    const bool spline = candidate.name.starts_with(stem + ".spline ") ||
                        candidate.name.starts_with(stem + ".process ");
    if (candidate.name != parameter && !spline) continue;
    const std::string among = " " + candidate.passes + " ";
    if (candidate.passes != "all" && among.find(" " + owner + " ") == std::string::npos) continue;
    if (candidate.test == SelectionTest::kNotTried) return candidate.reason;
    return candidate.reason + ": F " + Text(candidate.f) + ", p " + Text(candidate.probability) +
           ", delta BIC " + Text(candidate.delta_bic);
  }
  return {};
}

Eigen::VectorXd EffectParts(const AdjustmentProblem& problem) {
  const TargetEffects effects = TargetEffectsOf(problem, PassOfParameters(problem.layout));
  Eigen::VectorXd parts = Eigen::VectorXd::Zero(effects.metres.size());
  if (!(effects.range_m > 0.0)) return parts;
  for (Eigen::Index i = 0; i < parts.size(); ++i) {
    if (problem.layout.parameters[static_cast<std::size_t>(i)].has_prior()) continue;
    parts[i] = effects.metres[i] / effects.range_m;
  }
  return parts;
}

Determinacy DeterminacyOf(const Eigen::MatrixXd& s,
                          const Eigen::VectorXd& full_diagonal,
                          const Eigen::VectorXd& prior_weight,
                          const Eigen::VectorXd& effect_part,
                          const std::vector<int>& active) {
  Determinacy out;
  if (active.empty()) return out;
  constexpr double kOpen = std::numeric_limits<double>::infinity();
  Eigen::MatrixXd part = s(active, active);
  part.diagonal() += prior_weight(active);
  const Eigen::VectorXd diagonal = full_diagonal(active) + prior_weight(active);
  const Eigen::VectorXd scale = diagonal.cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) return {kOpen, kOpen};
  part = scale.asDiagonal() * part * scale.asDiagonal();
  out.condition = ConditionOf(part);
  if (!std::isfinite(out.condition)) return {kOpen, kOpen};
  const Eigen::Index n = part.rows();
  const Eigen::MatrixXd covariance = dense::Cholesky(part).Inverse();
  for (Eigen::Index k = 0; k < n; ++k) {
    const int column = active[static_cast<std::size_t>(k)];
    if (prior_weight[column] > 0.0) continue;
    const double sigma = scale[k] * std::sqrt(covariance(k, k));
    out.effect_part = std::max(out.effect_part, effect_part[column] * sigma);
  }
  return out;
}

double MaxCondition(const SelectionOptions& options) {
  return std::min(options.max_condition, 1.0 / kNearEigenvalue);
}

bool IsAcceptable(const Determinacy& determinacy, const SelectionOptions& options) {
  return determinacy.condition <= MaxCondition(options) &&
         determinacy.effect_part <= kNearEffectPart;
}

}  // namespace sarblock
