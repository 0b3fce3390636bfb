// SPDX-License-Identifier: Apache-2.0
// What was chosen, suspected before what was measured: priors that are too tight, a term of
// corrections that is missing, a degree too low, knots too wide, passes held as exact.
#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/text.h"
#include "linear/dense.h"
#include "mistakes.h"
#include "model/parameters.h"
#include "model/priors.h"
#include "sample.h"

namespace sarblock {
namespace {

using NameSet = std::set<std::string>;

/// Priors of terms that are tried, in standard deviations of a look: as good as none, and nothing
/// that they leave open is singular.
constexpr double kWidePrior = 1e3;
/// Factors by which all priors are tried wider.
constexpr std::array kWider = {3.0, 10.0, 30.0, 100.0, 1000.0, 10000.0};
/// Part of the work at which no more of them are.
constexpr double kPartForWider = 0.25;
/// Root mean square of a term over its priors above which these are doubted.
constexpr double kDoubted = 1.5;
/// Standard deviation of a term that is added, in those of the terms beside it: an error that is
/// much larger than they allow is not one of a degree or of knots.
constexpr double kBesideOthers = 3.0;
/// Part of the range beyond which an error of a path is that of another path.
constexpr double kLargestPathError = 0.05;
/// Knots of a spline that is tried in place of a polynomial, in a strip.
constexpr double kKnotsOfStrip = 8.0;

/// Coefficients of one axis have one name where they are those of a spline.
std::string NameOfPriors(const Parameter& parameter) {
  return parameter.spline ? parameter.name.substr(0, parameter.name.rfind('.')) : parameter.name;
}

/// Multiplies the priors of parameters with these names.
void ScaleOwnPriors(const NameSet& names, double factor, CorrectionGroup* group) {
  const auto scale = [&](const char* name, PriorSigma* sigma) {
    if (names.contains(name)) *sigma *= factor;
  };
  if (auto* position = std::get_if<PositionCorrection>(&group->model)) {
    const bool spline = position->basis == PositionCorrection::Basis::kSpline;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::vector<double>& sigma_m = position->prior_sigma_m[axis];
      if (sigma_m.empty()) continue;
      if (!spline) sigma_m.resize(static_cast<std::size_t>(position->degree) + 1, sigma_m.front());
      for (std::size_t k = 0; k < sigma_m.size(); ++k) {
        Parameter parameter = PositionParameter(*position, axis, k);
        if (!names.contains(NameOfPriors(parameter))) continue;
        sigma_m[k] *= factor;
        position->start_sigma_m[axis] *= factor;  // NaN but of a random walk
      }
    }
  } else if (auto* velocity = std::get_if<VelocityCorrection>(&group->model)) {
    scale("velocity.across", &velocity->prior_sigma[0]);
    scale("velocity.up", &velocity->prior_sigma[1]);
  } else if (auto* range = std::get_if<RangeCorrection>(&group->model)) {
    scale("range.bias", &range->bias_prior_sigma_m);
    scale("range.scale", &range->scale_prior_sigma);
  } else if (auto* time = std::get_if<TimeCorrection>(&group->model)) {
    scale("time.bias", &time->bias_prior_sigma_s);
  } else if (auto* squint = std::get_if<SquintCorrection>(&group->model)) {
    scale("squint.bias", &squint->bias_prior_sigma_rad);
  } else if (auto* troposphere = std::get_if<TroposphereCorrection>(&group->model)) {
    scale("troposphere.zenith", &troposphere->zenith_prior_sigma_m);
  }
}

void ScalePriors(const NameSet& names, double factor, CorrectionModel* model) {
  for (CorrectionGroup& group : model->groups) ScaleOwnPriors(names, factor, &group);
  for (JointPrior& prior : model->priors) {
    const bool named = std::any_of(prior.parameters.begin(),
                                   prior.parameters.end(),
                                   [&](const std::string& name) { return names.contains(name); });
    if (!named) continue;
    for (double& element : prior.covariance.values) element *= factor * factor;
    for (double& sigma : prior.sigma) sigma *= factor;
  }
}

std::string JoinedNames(const NameSet& names) {
  std::string text;
  std::size_t i = 0;
  for (const std::string& name : names) {
    text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + name;
    ++i;
  }
  return text;
}

Hypothesis OfModel(std::string cause) {
  Hypothesis out;
  out.kind = MistakeKind::kModel;
  out.cause = std::move(cause);
  out.undo = [](Block*, double) {};
  out.screened = true;
  out.local = true;
  out.order = Hypothesis::kChosen;
  return out;
}

/// v'Pv of priors and their number, by the name of what they are of.
struct KindOfTerm {
  double square = 0.0;
  int count = 0;
  [[nodiscard]] double rms() const { return std::sqrt(square / count); }
};

/// By the whitened equations of the priors: those of a process or of a joint prior are independent
/// where their coefficients are not.
std::map<std::string, KindOfTerm> TermsOf(const Block& sample,
                                          const CorrectionModel& model,
                                          const Fit& fit) {
  std::map<std::string, KindOfTerm> out;
  const ParameterLayout layout = MakeParameterLayout(sample, model.groups, model.priors);
  if (!fit.solved || fit.state.corrections.size() != layout.size()) return out;
  for (int block = 0; block < static_cast<int>(layout.blocks.size()); ++block) {
    for (const PriorRow& row : PriorRowsOf(layout, block)) {
      double error = 0.0;
      for (const PriorRow::Term& term : row.terms) {
        const Parameter& parameter = layout.parameters[static_cast<std::size_t>(term.parameter)];
        error += term.weight * (fit.state.corrections[term.parameter] - parameter.prior_value);
      }
      const auto last = static_cast<std::size_t>(row.terms.back().parameter);
      KindOfTerm& kind = out[NameOfPriors(layout.parameters[last])];
      kind.square += error * error;
      ++kind.count;
    }
  }
  return out;
}

Hypothesis TightPriors(const NameSet& names, int priors) {
  Hypothesis out = OfModel("model.priors");
  out.remodel = [names](CorrectionModel* model, double log_factor) {
    ScalePriors(names, std::exp(log_factor), model);
  };
  out.free = true;
  out.logarithm = true;
  out.step = 0.1;
  out.unit = "1";
  out.log_cost = 2.0 * priors;
  out.max_unexplained = 3.0;  // wide priors take a part of anything
  out.numbers = {{1000.0, "kilometres for metres, or milliseconds for seconds"},
                 {100.0, "metres for centimetres, or a hundred"}};
  out.says = [names](const Size& size) {
    const std::string factor = std::isfinite(size.sigma) ? size.text : Short(size.value);
    return "the priors of " + JoinedNames(names) + " are " + factor +
           " times too tight for the corrections that looks and control ask for";
  };
  out.change = [](const Size& size) {
    return "block.toml: standard deviations of these corrections times " + Short(size.value) +
           " in [adjust.correction] or [adjust.prior], if the flights are those of these images";
  };
  return out;
}

double MedianRange_m(const Block& sample) { return Median(sample.looks.range_m); }

double LargestPosition_m(const Block& sample, const CorrectionModel& model, const Fit& fit) {
  double largest_m = 0.0;
  const ParameterLayout layout = MakeParameterLayout(sample, model.groups, model.priors);
  for (int i = 0; i < layout.size(); ++i) {
    if (layout.parameters[static_cast<std::size_t>(i)].kind != ParameterKind::kPosition) continue;
    largest_m = std::max(largest_m, std::abs(fit.state.corrections[i]));
  }
  return largest_m;
}

/// The priors that the block would leave behind if they were wider: all of them are, by the factor
/// of the likelihood's choice, which shows the terms that ask for it.
void AddTightPriors(const Facts& facts, Trials* trials, Hypotheses* out) {
  NameSet all;
  int count = 0;
  const Block& sample = facts.sample.block;
  const CorrectionModel& model = facts.corrections;
  for (const Parameter& parameter :
       MakeParameterLayout(sample, model.groups, model.priors).parameters) {
    if (!parameter.has_prior()) continue;
    all.insert(NameOfPriors(parameter));
    ++count;
  }
  if (all.empty()) return;
  const auto asked = TermsOf(sample, model, facts.before);
  const bool doubted = asked.empty() || std::any_of(asked.begin(), asked.end(), [](const auto& of) {
                         return of.second.rms() > kDoubted;
                       });
  if (!doubted) return;
  Hypothesis wider = TightPriors(all, count);
  if (!trials->work().Allows(kPartForWider)) {  // to be counted
    wider.value = std::log(kWider.front());
    out->push_back(std::move(wider));
    return;
  }
  const FitOptions options{.warm = facts.near() ? &facts.before.state : nullptr,
                           .effort = Effort::kQuick};
  Fit best;
  double factor = 1.0;
  double least =
      facts.before.solved ? facts.before.Cost() : std::numeric_limits<double>::infinity();
  for (const double tried : kWider) {
    if (!trials->work().Allows(kPartForWider)) break;
    Fit fit = trials->With(wider, std::log(tried), options);
    if (fit.solved && fit.Cost() < least) {
      least = fit.Cost();
      factor = tried;
      best = std::move(fit);
    } else if (fit.solved && factor > 1.0) {
      break;  // the cost has one minimum
    }
  }
  if (factor == 1.0) return;
  CorrectionModel widened = model;
  wider.remodel(&widened, std::log(factor));
  constexpr double kTight = 2.0;
  NameSet tight;
  int priors = 0;
  double square = 0.0;
  for (const auto& [name, kind] : TermsOf(sample, widened, best)) {
    if (!(factor * kind.rms() > kTight)) continue;
    tight.insert(name);
    priors += kind.count;
    square += kind.square;
  }
  if (tight.empty()) return;
  Hypothesis tighter = TightPriors(tight, priors);
  tighter.value = std::log(factor * std::sqrt(square / priors));
  if (LargestPosition_m(sample, widened, best) > kLargestPathError * MedianRange_m(sample)) return;
  out->push_back(std::move(tighter));
}

/// Takes the polynomial of this degree in their number off the coefficients of a spline, which are
/// those of a polynomial nearly where it is one: what the degree leaves of an error of a flight.
void TakeOffPolynomial(int degree, Eigen::VectorXd* coefficients) {
  const Eigen::Index n = coefficients->size();
  if (degree < 0 || n <= degree + 1) return;
  Eigen::MatrixXd powers(n, degree + 1);
  const Eigen::VectorXd at = Eigen::VectorXd::LinSpaced(n, -1.0, 1.0);
  powers.col(0).setOnes();
  for (int k = 1; k <= degree; ++k) powers.col(k) = powers.col(k - 1).cwiseProduct(at);
  const Eigen::MatrixXd q = dense::Orthogonal(powers).Q(degree + 1);
  *coefficients -= q * (q.transpose() * *coefficients);
}

/// "position.up.1 9.81 m (most S3, 14.2 m)": root mean square of the new terms of a model, of a
/// spline what the polynomial in its place does not take.
std::string NewTerms(const Block& sample,
                     const CorrectionModel& before,
                     const CorrectionModel& after,
                     const Fit& fit) {
  const ParameterLayout layout = MakeParameterLayout(sample, after.groups, after.priors);
  if (!fit.solved || fit.state.corrections.size() != layout.size()) return "";
  std::set<std::pair<std::string, std::string>> known;
  std::map<std::pair<std::string, int>, int> degrees;  // of owners and axes
  for (const Parameter& p : MakeParameterLayout(sample, before.groups, before.priors).parameters) {
    if (p.spline) continue;
    known.emplace(p.owner, p.name);
    if (p.kind == ParameterKind::kPosition) degrees[{p.owner, p.axis}] = p.degree;
  }
  Eigen::VectorXd values = fit.state.corrections;
  std::map<std::pair<std::string, int>, std::vector<Eigen::Index>> splines;
  for (int i = 0; i < layout.size(); ++i) {
    const Parameter& p = layout.parameters[static_cast<std::size_t>(i)];
    if (p.spline && degrees.contains({p.owner, p.axis})) splines[{p.owner, p.axis}].push_back(i);
  }
  for (const auto& [spline, places] : splines) {
    Eigen::VectorXd coefficients = values(places);
    TakeOffPolynomial(degrees.at(spline), &coefficients);
    values(places) = coefficients;
  }
  struct Term {
    double square = 0.0, largest = 0.0;
    int count = 0;
    std::string owner, unit;
  };
  std::map<std::string, Term> terms;
  for (int i = 0; i < layout.size(); ++i) {
    const Parameter& p = layout.parameters[static_cast<std::size_t>(i)];
    if (known.contains({p.owner, p.name})) continue;
    const double value = values[i];
    Term& term = terms[NameOfPriors(p)];
    term.square += value * value;
    ++term.count;
    if (std::abs(value) > std::abs(term.largest)) {
      term.largest = value;
      term.owner = p.owner;
      term.unit = p.unit;
    }
  }
  std::vector<std::pair<double, std::string>> lines;
  for (const auto& [name, term] : terms) {
    const double rms = std::sqrt(term.square / term.count);
    lines.emplace_back(-rms,
                       name + " " + Digits(rms, 3) + " " + term.unit + " (most " + term.owner +
                           ", " + Digits(term.largest, 3) + " " + term.unit + ")");
  }
  std::sort(lines.begin(), lines.end());
  constexpr std::size_t kNamed = 3;
  std::string text;
  for (std::size_t i = 0; i < std::min(kNamed, lines.size()); ++i) {
    text += (i == 0 ? "" : ", ") + lines[i].second;
  }
  return text;
}

struct Choice {
  std::string cause, says, change;
  std::vector<std::string> passes;
  bool fewer_terms = false;  ///< than the one added before, whose uselessness it shares
};

/// Adds other corrections than those asked for; false where they add no parameter or exclude
/// others.
bool AddOther(const Facts& facts, Choice choice, CorrectionModel other, Hypotheses* out) {
  const Block& sample = facts.sample.block;
  try {
    const CorrectionModel& given = facts.corrections;
    const int more = MakeParameterLayout(sample, other.groups, other.priors).size() -
                     MakeParameterLayout(sample, given.groups, given.priors).size();
    if (more <= 0) return false;
    Hypothesis tried = OfModel(choice.cause);
    tried.passes = choice.passes;
    tried.within_last = choice.fewer_terms;
    // Far from a solution single mistakes that known points show come first.
    if (!facts.near()) tried.order = Hypothesis::kScored;
    tried.parameters = more;
    tried.max_unexplained = 10.0;
    tried.remodel = [other](CorrectionModel* model, double) { *model = other; };
    tried.detail = [&sample, given, other](const Fit& fit) {
      return NewTerms(sample, given, other, fit);
    };
    tried.says = [says = choice.says](const Size&) { return says; };
    tried.change = [change = choice.change](const Size&) { return change; };
    out->push_back(std::move(tried));
    return true;
  } catch (const std::exception&) {  // corrections that do not stand beside each other
    return false;
  }
}

/// Median standard deviation of the ranges.
double LookSigma_m(const Block& block) {
  std::vector<double> sigma_m;
  for (std::size_t i = 0; i < block.looks.size(); ++i) sigma_m.push_back(block.SigmaOf(i).range_m);
  const double median_m = Median(std::move(sigma_m));
  return median_m > 0.0 ? median_m : 1.0;
}

/// With all looks: a trial fits the strips to them, and times that are wrong may span a day.
double LongestStrip_s(const Block& sample) {
  double longest_s = 0.0;
  Block block = sample;
  FitStrips(&block);
  for (const Pass& pass : block.passes) longest_s = std::max(longest_s, pass.end_s - pass.start_s);
  return longest_s;
}

PositionCorrection Polynomial(int degree, double prior_m) {
  PositionCorrection out;
  out.degree = degree;
  out.prior_sigma_m.fill({prior_m});
  return out;
}

/// With terms up to `degree`.
PositionCorrection Raised(PositionCorrection position, int degree) {
  for (std::vector<double>& sigma_m : position.prior_sigma_m) {
    if (sigma_m.empty()) continue;
    const double most_m = *std::max_element(sigma_m.begin(), sigma_m.end());
    sigma_m.resize(static_cast<std::size_t>(position.degree) + 1, sigma_m.front());
    sigma_m.resize(static_cast<std::size_t>(degree) + 1, kBesideOthers * most_m);
  }
  position.degree = degree;
  return position;
}

PositionCorrection Spline(PositionCorrection position, double spacing_s) {
  position.basis = PositionCorrection::Basis::kSpline;
  position.knot_spacing_s = spacing_s;
  for (std::vector<double>& sigma_m : position.prior_sigma_m) {
    if (!sigma_m.empty()) sigma_m = {*std::max_element(sigma_m.begin(), sigma_m.end())};
  }
  return position;
}

/// Its table in block.toml; the name has a number where there are several.
std::string TableOf(const CorrectionGroup& group) {
  const std::size_t dot = group.name.find('.');
  if (dot == std::string::npos) return "[adjust.correction." + group.name + "]";
  return "number " + group.name.substr(dot + 1) + " of [[adjust.correction." +
         group.name.substr(0, dot) + "]]";
}

std::string Degree(int degree) { return std::to_string(degree); }

void AddMissingPosition(const Facts& facts, double prior_m, Hypotheses* out) {
  constexpr std::array<const char*, 3> kTerms = {
      "a constant", "a constant and a drift", "a constant, a drift and a curve"};
  bool added = false;
  for (int degree = 2; degree >= 0; --degree) {
    CorrectionModel other = facts.corrections;
    other.groups.push_back({"position", Polynomial(degree, prior_m), {}, false});
    added =
        AddOther(facts,
                 {"model.missing",
                  std::string("no correction takes errors of the flights that the looks show: ") +
                      kTerms.at(static_cast<std::size_t>(degree)) + " of the position of each pass",
                  "block.toml: [adjust.correction.position] with degree = " + Degree(degree) +
                      " and sigma_m as the flights are known (tried: " + InFiles(prior_m) + ")",
                  {},
                  added},
                 std::move(other),
                 out) ||
        added;
  }
  CorrectionModel other = facts.corrections;
  const double spacing_s = LongestStrip_s(facts.sample.block) / kKnotsOfStrip;
  other.groups.push_back({"position", Spline(Polynomial(0, prior_m), spacing_s), {}, false});
  AddOther(facts,
           {"model.missing",
            "no correction takes errors of the flights that the looks show, which change along "
            "the strips",
            "block.toml: [adjust.correction.position] with basis = \"spline\", knot_spacing_s = " +
                Short(spacing_s) +
                " and sigma_m as the flights are known (tried: " + InFiles(prior_m) + ")",
            {}},
           std::move(other),
           out);
}

void AddHigherDegrees(const Facts& facts, std::size_t g, Hypotheses* out) {
  const CorrectionGroup& group = facts.corrections.groups[g];
  const auto& position = std::get<PositionCorrection>(group.model);
  const auto with = [&](const PositionCorrection& changed) {
    CorrectionModel other = facts.corrections;
    other.groups[g].model = changed;
    return other;
  };
  const std::string table = "block.toml: " + TableOf(group) + " with ";
  if (position.basis == PositionCorrection::Basis::kSpline) {
    const double spacing_s = 0.5 * position.knot_spacing_s;
    AddOther(facts,
             {"model.knots",
              "the knots of " + group.name + " are too wide for the errors of the flights",
              table + "knot_spacing_s = " + Short(spacing_s),
              group.passes},
             with(Spline(position, spacing_s)),
             out);
    return;
  }
  // The most terms first: where they are of no use, fewer are of none.
  bool added = false;
  for (const int more : {3, 2, 1}) {
    const int degree = position.degree + more;
    if (degree > PositionCorrection::kMaxDegree) continue;
    added = AddOther(facts,
                     {"model.degree",
                      "degree " + Degree(position.degree) + " of " + group.name +
                          " is too low for the errors of the flights, degree " + Degree(degree) +
                          " takes them",
                      table + "degree = " + Degree(degree) + " and a prior for its terms (tried: " +
                          Short(kBesideOthers) + " times the largest of the axis)",
                      group.passes,
                      added},
                     with(Raised(position, degree)),
                     out) ||
            added;
  }
  const double spacing_s = LongestStrip_s(facts.sample.block) / kKnotsOfStrip;
  AddOther(facts,
           {"model.degree",
            "degree " + Degree(position.degree) + " of " + group.name +
                " is too low for errors of the flights that change along the strips",
            table + "basis = \"spline\", knot_spacing_s = " + Short(spacing_s) +
                " and of the priors of an axis the largest",
            group.passes},
           with(Spline(position, spacing_s)),
           out);
}

/// Passes that have no correction of a kind that others have.
void AddHeldPasses(const Facts& facts, std::size_t g, double prior_m, Hypotheses* out) {
  const CorrectionGroup& group = facts.corrections.groups[g];
  if (group.passes.empty() || group.shared) return;
  std::vector<std::string> fixed;
  for (const Pass& pass : facts.sample.block.passes) {
    const bool corrected =
        std::any_of(facts.corrections.groups.begin(),
                    facts.corrections.groups.end(),
                    [&](const CorrectionGroup& other) {
                      return other.model.index() == group.model.index() &&
                             (other.passes.empty() ||
                              std::find(other.passes.begin(), other.passes.end(), pass.id) !=
                                  other.passes.end());
                    });
    if (!corrected) fixed.push_back(pass.id);
  }
  if (fixed.empty()) return;
  CorrectionModel other = facts.corrections;
  CorrectionGroup added = group;
  added.passes = fixed;
  if (auto* position = std::get_if<PositionCorrection>(&added.model)) {
    for (std::vector<double>& sigma_m : position->prior_sigma_m) {
      for (double& sigma : sigma_m) sigma = std::max(sigma, prior_m);
    }
  }
  other.groups.push_back(added);
  AddOther(facts,
           {"model.held",
            PassWords(fixed) + (fixed.size() == 1 ? " is" : " are") +
                " held as exact beside others with corrections of " + group.name,
            "block.toml: passes of " + TableOf(group) + " with " + PassWords(fixed),
            fixed},
           std::move(other),
           out);
}

}  // namespace

void AddModelMistakes(const Facts& facts, Trials* trials, Hypotheses* out) {
  const double prior_m = kWidePrior * LookSigma_m(facts.sample.block);
  AddTightPriors(facts, trials, out);
  bool position = false;
  for (std::size_t g = 0; g < facts.corrections.groups.size(); ++g) {
    AddHeldPasses(facts, g, prior_m, out);
    const bool of_position =
        std::holds_alternative<PositionCorrection>(facts.corrections.groups[g].model);
    if (of_position) AddHigherDegrees(facts, g, out);
    position = position || of_position;
  }
  if (!position) AddMissingPosition(facts, prior_m, out);
}

}  // namespace sarblock
