// SPDX-License-Identifier: Apache-2.0
#include "parameters.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/text.h"

namespace sarblock {
namespace {

/// Builds a layout group by group. Static parameters are first collected per owner (a pass or a
/// shared group) and numbered at the end, so that an owner's parameters are consecutive.
class LayoutBuilder {
 public:
  LayoutBuilder(const Block& block,
                const std::vector<CorrectionGroup>& groups,
                const std::vector<JointPrior>& priors)
      : block_(block), groups_(groups), priors_(priors) {
    layout_.passes.resize(block.passes.size());
    own_of_.resize(block.passes.size());
    for (std::size_t i = 0; i < block.passes.size(); ++i) {
      const Pass& pass = block.passes[i];
      layout_.passes[i].middle_s = 0.5 * (pass.start_s + pass.end_s);
      layout_.passes[i].half_length_s = 0.5 * (pass.end_s - pass.start_s);
      index_of_pass_[pass.id] = i;
    }
  }

  void Add(const CorrectionGroup& group) {
    const std::vector<std::size_t> members = Members(group);
    if (!group.shared) {
      for (const std::size_t pass : members) {
        for (const CorrectionGroup* other : own_of_[pass]) {
          if (!Overlap(*other, group)) continue;
          throw InputError("correction." + group.name,
                           "pass " + block_.passes[pass].id +
                               " has two groups of this kind, at most one that is not shared is "
                               "allowed (for the position: one a component)");
        }
        own_of_[pass].push_back(&group);
      }
    }
    CheckCorrection(group);
    const auto* position = std::get_if<PositionCorrection>(&group.model);
    if (position != nullptr && position->basis == PositionCorrection::Basis::kSpline) {
      AddSpline(group, *position, members);
      return;
    }
    if (group.shared) {
      const int first = static_cast<int>(layout_.parameters.size());
      const std::vector<Parameter> parameters = ParametersOf(group);
      const int block = NewBlock(static_cast<int>(parameters.size()), true);
      Append(group.name, parameters);
      for (const std::size_t pass : members) {
        PassCorrections& corrections = layout_.passes[pass];
        corrections.blocks.push_back(block);
        BindCorrection(group.model, corrections.static_columns, &corrections);
        corrections.static_columns += static_cast<int>(layout_.parameters.size()) - first;
      }
    } else {
      for (const std::size_t pass : members) own_groups_[pass].push_back(&group);
    }
  }

  ParameterLayout Finish() {
    for (const auto& [pass, groups] : own_groups_) {
      PassCorrections& corrections = layout_.passes[pass];
      const int block = NewBlock(0, false);
      corrections.blocks.push_back(block);
      for (const CorrectionGroup* group : groups) {
        const std::vector<Parameter> parameters = ParametersOf(*group);
        BindCorrection(group->model, corrections.static_columns, &corrections);
        Append(block_.passes[pass].id, parameters);
        corrections.static_columns += static_cast<int>(parameters.size());
        layout_.blocks.back().size += static_cast<int>(parameters.size());
      }
    }
    BindPriors();
    for (std::size_t i = 0; i < layout_.passes.size(); ++i) {
      CheckLimits(block_.passes[i].id, layout_.passes[i]);
    }
    return std::move(layout_);
  }

 private:
  std::vector<std::size_t> Members(const CorrectionGroup& group) const {
    std::vector<std::size_t> members;
    if (group.passes.empty()) {
      for (std::size_t i = 0; i < block_.passes.size(); ++i) members.push_back(i);
      return members;
    }
    for (const std::string& id : group.passes) {
      const auto found = index_of_pass_.find(id);
      if (found == index_of_pass_.end()) {
        std::vector<std::string> known;
        for (const Pass& pass : block_.passes) known.push_back(pass.id);
        throw InputError("correction." + group.name + ".passes",
                         "no pass '" + id + "' in the block" + DidYouMean(NearestName(id, known)));
      }
      members.push_back(found->second);
    }
    std::sort(members.begin(), members.end());
    members.erase(std::unique(members.begin(), members.end()), members.end());
    return members;
  }

  void AddSpline(const CorrectionGroup& group,
                 const PositionCorrection& position,
                 const std::vector<std::size_t>& members) {
    // A shared spline is one function of time over all its passes (strips of one flight).
    std::vector<std::vector<std::size_t>> sets;
    if (group.shared) {
      sets.push_back(members);
    } else {
      for (const std::size_t pass : members) sets.push_back({pass});
    }
    for (const std::vector<std::size_t>& set : sets) {
      double start_s = block_.passes[set.front()].start_s;
      double end_s = block_.passes[set.front()].end_s;
      for (const std::size_t pass : set) {
        start_s = std::min(start_s, block_.passes[pass].start_s);
        end_s = std::max(end_s, block_.passes[pass].end_s);
      }
      SplineTerm term = MakeSplineTerm(position, start_s, end_s);
      term.first_block = static_cast<int>(layout_.blocks.size());
      const std::string owner = group.shared ? group.name : block_.passes[set.front()].id;
      for (std::size_t q = 0; q < term.spline.count(); ++q) {
        NewBlock(term.component_count, group.shared);
        std::vector<Parameter> coefficient;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          if (!position.components[axis]) continue;
          coefficient.push_back(PositionParameter(position, axis, q));
          const int before = static_cast<int>(layout_.parameters.size() + coefficient.size()) - 1 -
                             term.component_count;
          SetProcess(
              position, term.spline.spacing_s(), term.spline.count(), before, &coefficient.back());
        }
        Append(owner, coefficient);
      }
      for (const std::size_t pass : set) layout_.passes[pass].splines.push_back(term);
    }
  }

  /// A pass's own parameters are one block, its last: so is what a joint prior speaks of.
  void BindPriors() {
    if (priors_.empty()) return;
    std::vector<std::string> ids;
    for (const Pass& pass : block_.passes) ids.push_back(pass.id);
    const JointPriorBindings bindings = BindJointPriors(ids, groups_, priors_);
    if (bindings.problem) {
      const JointPriorProblem& problem = *bindings.problem;
      throw InputError(KeyOf(priors_[problem.prior]) + "." + problem.field, problem.problem);
    }
    for (const JointPriorBinding& binding : bindings.bound) {
      const JointPrior& prior = priors_[binding.prior];
      const Pass& pass = block_.passes[binding.pass];
      JointPriorTerm term;
      term.name = prior.name;
      term.owner = pass.id;
      term.block = layout_.passes[binding.pass].blocks.back();
      term.Set(CovarianceOf(prior, block_.frame, pass, binding.axes));
      const int offset = layout_.blocks[static_cast<std::size_t>(term.block)].offset;
      for (std::size_t i = 0; i < binding.parameters.size(); ++i) {
        term.parameters.push_back(offset + binding.parameters[i]);
        Parameter& parameter = layout_.parameters[static_cast<std::size_t>(term.parameters.back())];
        const auto row = static_cast<Eigen::Index>(i);
        parameter.prior_sigma = std::sqrt(term.covariance(row, row));
        parameter.joint = static_cast<int>(layout_.joint_priors.size());
      }
      layout_.joint_priors.push_back(std::move(term));
    }
  }

  int NewBlock(int size, bool shared) {
    layout_.blocks.push_back({static_cast<int>(layout_.parameters.size()), size, shared});
    return static_cast<int>(layout_.blocks.size()) - 1;
  }

  void Append(const std::string& owner, std::vector<Parameter> parameters) {
    for (Parameter& parameter : parameters) {
      parameter.owner = owner;
      layout_.parameters.push_back(std::move(parameter));
    }
  }

  const Block& block_;
  const std::vector<CorrectionGroup>& groups_;
  const std::vector<JointPrior>& priors_;
  ParameterLayout layout_;
  std::map<std::string, std::size_t> index_of_pass_;
  std::map<std::size_t, std::vector<const CorrectionGroup*>> own_groups_;
  std::vector<std::vector<const CorrectionGroup*>> own_of_;
};

}  // namespace

bool Overlap(const CorrectionGroup& a, const CorrectionGroup& b) {
  if (a.model.index() != b.model.index()) return false;
  const auto* one = std::get_if<PositionCorrection>(&a.model);
  const auto* two = std::get_if<PositionCorrection>(&b.model);
  if (one == nullptr || one->axes != two->axes) return true;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (one->components[axis] && two->components[axis]) return true;
  }
  return false;
}

void BindCorrection(const Correction& correction, int column, PassCorrections* pass) {
  if (const auto* position = std::get_if<PositionCorrection>(&correction)) {
    pass->polynomials.push_back({position->axes, position->components, position->degree, column});
  } else if (const auto* velocity = std::get_if<VelocityCorrection>(&correction)) {
    if (velocity->components[0]) pass->velocity_across.push_back(column++);
    if (velocity->components[1]) pass->velocity_up.push_back(column);
  } else if (const auto* range = std::get_if<RangeCorrection>(&correction)) {
    if (range->bias) pass->range_bias.push_back(column++);
    if (range->scale) pass->range_scale.push_back(column);
  } else if (std::holds_alternative<TimeCorrection>(correction)) {
    pass->time_bias.push_back(column);
  } else if (std::holds_alternative<SquintCorrection>(correction)) {
    pass->squint_bias.push_back(column);
  } else if (const auto* air = std::get_if<TroposphereCorrection>(&correction)) {
    pass->troposphere.push_back({column, air->scale_height_m});
  }
}

SplineTerm MakeSplineTerm(const PositionCorrection& position, double start_s, double end_s) {
  SplineTerm term;
  term.axes = position.axes;
  term.components = position.components;
  term.component_count =
      static_cast<int>(std::count(position.components.begin(), position.components.end(), true));
  term.spline = UniformSpline(start_s, end_s, position.knot_spacing_s);
  return term;
}

namespace {

/// What is wrong with the process of a position correction; the key counts from the correction.
void CheckProcess(const std::string& key, const PositionCorrection& position) {
  using Process = PositionCorrection::Process;
  if (position.process == Process::kWhite) return;
  if (position.basis != PositionCorrection::Basis::kSpline) {
    throw InputError(key + ".process", "is one of the coefficients of a spline");
  }
  bool any = false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!position.components[axis] || position.prior_sigma_m[axis].empty()) continue;
    any = true;
    const double start_m = position.start_sigma_m[axis];
    if (position.process == Process::kRandomWalk && !(start_m > 0.0 && std::isfinite(start_m))) {
      throw InputError(key + ".start_sigma_m",
                       "must be given for a random walk and above 0, the standard deviation of "
                       "its first coefficient, got " +
                           NumberText(start_m));
    }
  }
  if (!any) throw InputError(key + ".sigma_m", "is not given, a process needs it");
  if (position.process != Process::kGaussMarkov) return;
  const double time_s = position.correlation_time_s;
  if (!(time_s > 0.0 && std::isfinite(time_s))) {
    throw InputError(
        key + ".correlation_time_s",
        "must be given for a Gauss-Markov process and above 0, got " + NumberText(time_s));
  }
  if (position.knot_spacing_s > 0.0 &&
      !(-std::expm1(-2.0 * position.knot_spacing_s / time_s) > kMinPriorPivot)) {
    throw InputError(key + ".correlation_time_s",
                     "is so much longer than knot_spacing_s that neighbours are one number, got " +
                         NumberText(time_s) + " s; a random walk, or a polynomial, is allowed");
  }
}

}  // namespace

void CheckCorrection(const CorrectionGroup& group) {
  const std::string key = "correction." + group.name;
  const auto check_sigma = [&key](double sigma) {
    if (std::isnan(sigma) || (sigma > 0.0 && std::isfinite(sigma))) return;
    throw InputError(key,
                     "the standard deviation of a prior must be finite and above 0, got " +
                         std::to_string(sigma));
  };
  if (const auto* position = std::get_if<PositionCorrection>(&group.model)) {
    const bool spline = position->basis == PositionCorrection::Basis::kSpline;
    if (position->degree < 0 || position->degree > PositionCorrection::kMaxDegree) {
      throw InputError(key + ".degree",
                       std::to_string(position->degree) + " is outside 0 to " +
                           std::to_string(PositionCorrection::kMaxDegree));
    }
    const auto on = std::count(position->components.begin(), position->components.end(), true);
    if (on == 0) throw InputError(key + ".components", "is empty, name at least one axis");
    for (const std::vector<double>& sigma_m : position->prior_sigma_m) {
      const bool fits =
          sigma_m.size() <= 1 ||
          (!spline && sigma_m.size() == static_cast<std::size_t>(position->degree) + 1);
      if (!fits) {
        throw InputError(key + ".sigma_m",
                         std::to_string(sigma_m.size()) +
                             " values for one axis, allowed are one value or one a degree");
      }
      for (const double sigma : sigma_m) check_sigma(sigma);
    }
    CheckProcess(key, *position);
    return;
  }
  for (const Parameter& parameter : ParametersOf(group)) check_sigma(parameter.prior_sigma);
  if (const auto* air = std::get_if<TroposphereCorrection>(&group.model)) {
    if (!(air->scale_height_m > 0.0)) {
      throw InputError(key + ".scale_height_m",
                       "must be above 0, got " + std::to_string(air->scale_height_m));
    }
  }
}

void CheckLimits(const std::string& pass_id, const PassCorrections& pass) {
  const auto check = [&pass_id](const char* kind, std::size_t count, std::size_t most) {
    if (count <= most) return;
    throw InputError("correction",
                     "pass " + pass_id + " has " + std::to_string(count) + " groups of " + kind +
                         ", at most " + std::to_string(most) + " are allowed");
  };
  check("position (polynomial)", pass.polynomials.size(), ParameterLayout::kMaxPolynomials);
  check("position (spline)", pass.splines.size(), ParameterLayout::kMaxSplines);
  check("troposphere", pass.troposphere.size(), ParameterLayout::kMaxTroposphere);
  int columns = pass.static_columns;
  for (const SplineTerm& term : pass.splines) columns += 4 * term.component_count;
  if (columns > ParameterLayout::kMaxLocalColumns) {
    throw InputError("correction",
                     "pass " + pass_id + " has " + std::to_string(columns) +
                         " parameters at one look, at most " +
                         std::to_string(ParameterLayout::kMaxLocalColumns) + " are allowed");
  }
}

bool PassCorrections::NeedsTrackAxes() const {
  if (!velocity_across.empty() || !velocity_up.empty()) return true;
  const auto track = [](const auto& term) { return term.axes == PositionCorrection::Axes::kTrack; };
  return std::any_of(polynomials.begin(), polynomials.end(), track) ||
         std::any_of(splines.begin(), splines.end(), track);
}

std::string ParameterLayout::Describe(int parameter) const {
  const Parameter& p = parameters[static_cast<std::size_t>(parameter)];
  return p.owner + " " + p.name;
}

double ParameterLayout::TimeBias_s(std::size_t pass, const Eigen::VectorXd& corrections) const {
  const PassCorrections& c = passes[pass];
  double sum_s = 0.0;
  for (const int column : c.time_bias) {
    int first = 0;
    for (const int id : c.blocks) {
      const ParameterBlock& block = blocks[static_cast<std::size_t>(id)];
      if (column < first + block.size) {
        sum_s += corrections[block.offset + column - first];
        break;
      }
      first += block.size;
    }
  }
  return sum_s;
}

double ParameterLayout::StepOf(std::size_t parameter, const Eigen::VectorXd& corrections) const {
  const Parameter& to = parameters[parameter];
  const Parameter& from = parameters[static_cast<std::size_t>(to.before)];
  return corrections[static_cast<Eigen::Index>(parameter)] - to.prior_value -
         to.carried * (corrections[to.before] - from.prior_value);
}

Eigen::VectorXd ParameterLayout::FromPrior(const JointPriorTerm& prior,
                                           const Eigen::VectorXd& corrections) const {
  Eigen::VectorXd out = corrections(prior.parameters);
  for (std::size_t i = 0; i < prior.parameters.size(); ++i) {
    out[static_cast<Eigen::Index>(i)] -=
        parameters[static_cast<std::size_t>(prior.parameters[i])].prior_value;
  }
  return out;
}

std::vector<PriorRow> PriorRowsOf(const ParameterLayout& layout, int block) {
  std::vector<PriorRow> rows;
  const ParameterBlock& of = layout.blocks[static_cast<std::size_t>(block)];
  for (int i = of.offset; i < of.offset + of.size; ++i) {
    const Parameter& parameter = layout.parameters[static_cast<std::size_t>(i)];
    if (parameter.has_own_prior()) rows.push_back({{{i, 1.0 / parameter.prior_sigma}}});
    if (parameter.before >= 0) {
      const double weight = 1.0 / parameter.step_sigma;
      rows.push_back({{{parameter.before, -parameter.carried * weight}, {i, weight}}});
    }
  }
  for (const JointPriorTerm& prior : layout.joint_priors) {
    if (prior.block != block) continue;
    for (Eigen::Index r = 0; r < prior.whitening.rows(); ++r) {
      PriorRow& row = rows.emplace_back();
      for (Eigen::Index c = 0; c <= r; ++c) {
        row.terms.push_back({prior.parameters[static_cast<std::size_t>(c)], prior.whitening(r, c)});
      }
    }
  }
  return rows;
}

ParameterLayout MakeParameterLayout(const Block& block,
                                    const std::vector<CorrectionGroup>& groups,
                                    const std::vector<JointPrior>& priors) {
  LayoutBuilder builder(block, groups, priors);
  for (const CorrectionGroup& group : groups) builder.Add(group);
  return builder.Finish();
}

}  // namespace sarblock
