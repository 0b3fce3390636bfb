// SPDX-License-Identifier: Apache-2.0
#include "cases.h"

#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/files/block_file.h"
#include "sarblock/files/scene_file.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <sstream>
#include <utility>
#include <variant>

#include "core/threads.h"
#include "linear/dense.h"
#include "model/priors.h"
#include "normals/point.h"
#include "placement.h"
#include "quality/point_sweep.h"
#include "simulate/scene.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

std::vector<std::string> TakeTexts(const std::string& key, SceneTable* table) {
  std::vector<std::string> texts;
  if (const auto taken = table->Take(key)) {
    for (const TomlValue& entry : taken->Entries()) texts.push_back(entry.Text());
  }
  return texts;
}

/// A TOML value as text on the right of `=`.
std::string ValueText(const TomlValue& value) {
  std::ostringstream stream;
  toml::table holder;
  value.node().visit([&holder](const auto& node) { holder.insert("v", node); });
  if (toml::table* inner = holder.get("v")->as_table()) inner->is_inline(true);
  stream << holder;
  const std::string text = stream.str();
  return text.substr(text.find('=') + 1);
}

/// The number, or that of a list all of whose entries are one number; else NaN.
double NumberOf(const TomlValue& value) {
  if (value.IsNumber()) return value.Number();
  if (!value.IsArray()) return kNotGiven;
  double number = kNotGiven;
  for (const TomlValue& entry : value.Entries()) {
    if (!entry.IsNumber() || (!std::isnan(number) && entry.Number() != number)) return kNotGiven;
    number = entry.Number();
  }
  return number;
}

/// `key`, or `keys`, of an axis.
std::vector<std::string> TakeKeys(SceneTable* table) {
  std::string key;
  table->Text("key", &key);
  const auto several = table->Take("keys");
  if (!several) return key.empty() ? std::vector<std::string>() : std::vector<std::string>{key};
  if (!key.empty()) several->Fail("excludes key; give one of both");
  std::vector<std::string> keys;
  for (const TomlValue& entry : several->Entries()) keys.push_back(entry.Text());
  return keys;
}

const char* NameOf(SceneControl::Layout layout) {
  using Layout = SceneControl::Layout;
  switch (layout) {
    case Layout::kNone:
      return "none";
    case Layout::kCorners:
      return "corners";
    case Layout::kPerimeter:
      return "perimeter";
    case Layout::kGrid:
      return "grid";
    case Layout::kChain:
      return "chain";
    case Layout::kRandom:
      return "random";
    case Layout::kPlaces:
      break;
  }
  return "places";
}

void KeepFlights(const std::vector<std::string>& ids, Scene* scene) {
  std::vector<SceneFlight> kept;
  for (const std::string& id : ids) {
    const auto found = std::find_if(scene->flights.begin(),
                                    scene->flights.end(),
                                    [&](const SceneFlight& flight) { return flight.id == id; });
    if (found == scene->flights.end()) {
      throw InputError("flights", "'" + id + "' is no flight of the scene");
    }
    kept.push_back(*found);
    scene->flights.erase(found);  // a second time it is unknown
  }
  if (kept.empty()) throw InputError("flights", "must name one at least");
  scene->flights = std::move(kept);
}

}  // namespace

void CaseChoice::Add(const CaseChoice& other) {
  if (!other.label.empty()) label += (label.empty() ? "" : ", ") + other.label;
  if (other.scene) scene = other.scene;
  if (other.flights) flights = other.flights;
  set.insert(set.end(), other.set.begin(), other.set.end());
  place = other.place;
}

CaseChoice TakeChanges(SceneTable* table) {
  CaseChoice choice;
  choice.place = table->PlaceOf("set");
  if (const auto set = table->Take("set")) {
    choice.place = set->Place();
    for (const TomlValue& entry : set->Entries()) {
      choice.set.push_back(entry.Text());
      if (choice.set.back().find_first_of("\r\n") != std::string::npos) {
        entry.Fail("must be KEY=VALUE on one line");
      }
    }
  }
  std::string scene;
  table->Text("scene", &scene);
  if (!scene.empty()) choice.scene = scene;
  if (table->Has("flights")) choice.flights = TakeTexts("flights", table);
  return choice;
}

CaseAxis ReadAxis(SceneTable table) {
  const std::vector<std::string> keys = TakeKeys(&table);
  CaseAxis axis;
  if (!keys.empty()) axis.name = keys.front();
  table.Text("name", &axis.name);
  const bool own_columns = keys == std::vector<std::string>{"control.layout"} ||
                           keys == std::vector<std::string>{"control.count"};
  const bool labelled = table.Has("labels");
  const std::vector<std::string> labels = TakeTexts("labels", &table);
  std::vector<CaseChoice>& choices = axis.choices;
  if (const auto values = table.Take("values")) {
    if (keys.empty()) throw InputError(table.PlaceOf("key"), "must be given beside values");
    for (const TomlValue& value : values->Entries()) {
      CaseChoice choice;
      choice.place = value.Place();
      choice.number = NumberOf(value);
      const std::string text = ValueText(value);
      for (const std::string& key : keys) choice.set.push_back(key + "=" + text);
      const std::string shown = value.IsText() ? value.Text() : text;
      choice.value = shown.substr(std::min(shown.find_first_not_of(' '), shown.size()));
      if (labelled && choices.size() < labels.size()) {
        choice.label = choice.value = labels[choices.size()];
      } else if (!own_columns) {
        choice.label = axis.name + " " + choice.value;
      }
      choices.push_back(std::move(choice));
    }
    if (labelled && labels.size() != choices.size()) {
      throw InputError(table.PlaceOf("labels"), "must be as many as values");
    }
  } else if (labelled) {
    throw InputError(table.PlaceOf("labels"), "go with values only; a case has a name");
  }
  for (SceneTable& entry : table.Tables("case")) {
    std::string label;
    entry.Text("name", &label);
    if (label.empty()) throw InputError(entry.PlaceOf("name"), "must be given");
    CaseChoice choice = TakeChanges(&entry);
    choice.label = choice.value = label;
    entry.Number("number", &choice.number);
    entry.Finish();
    choices.push_back(std::move(choice));
  }
  table.Finish();
  if (choices.empty()) throw InputError(table.PlaceOf("values"), "must not be empty");
  return axis;
}

std::vector<CaseChoice> Product(const CaseChoice& base,
                                const std::vector<CaseAxis>& axes,
                                const FilePlace& place) {
  std::vector<CaseChoice> cases = {base};
  for (const CaseAxis& axis : axes) {
    if (cases.size() * axis.choices.size() > kMaxStudyCases) {
      throw InputError(place,
                       "give more than " + std::to_string(kMaxStudyCases) +
                           " cases together, fewer are allowed");
    }
    std::vector<CaseChoice> longer;
    for (const CaseChoice& first : cases) {
      for (const CaseChoice& second : axis.choices) {
        longer.push_back(first);
        longer.back().Add(second);
      }
    }
    cases = std::move(longer);
  }
  return cases;
}

StudyCase CaseMaker::Make(const CaseChoice& choice) {
  try {
    return MakeUnnamed(choice);
  } catch (const InputError& error) {
    FilePlace place = choice.place;
    place.file = file_;
    throw InputError(place,
                     "cannot be applied" + (choice.label.empty() ? "" : " (" + choice.label + ")") +
                         ": " + error.what());
  }
}

StudyCase CaseMaker::MakeUnnamed(const CaseChoice& choice) {
  if (!choice.scene) throw InputError("scene", "must be given, the path of a scene file");
  auto found = texts_.find(*choice.scene);
  if (found == texts_.end()) {
    found = texts_.emplace(*choice.scene, scene_text_(*choice.scene)).first;
  }
  StudyCase made;
  made.variant = choice.label;
  made.scene = files::ParseScene(found->second, *choice.scene, choice.set);
  if (choice.flights) KeepFlights(*choice.flights, &made.scene);
  made.layout = NameOf(made.scene.control.layout);
  std::vector<std::string> passes;
  for (const SceneFlight& flight : made.scene.flights) {
    for (std::size_t p = 0; p < flight.count * flight.segments; ++p) {
      passes.push_back(PassId(flight, p / flight.segments, p % flight.segments));
    }
  }
  made.adjust = files::ReadAdjustTable(made.scene.adjust_toml, *choice.scene, passes);
  if (made.adjust.corrections == CorrectionChoice::kAuto) {
    throw InputError("adjust.corrections", "'auto' needs measured values; 'given' is allowed");
  }
  if (made.adjust.covariance_method == CovarianceMethod::kCeres) {
    throw InputError("adjust.covariance_method", "'ceres' is not offered in a study");
  }
  return made;
}

bool IsDetermined(const StudyTable& table, std::size_t row) {
  return table.Number(row, "determined") == 1.0;
}

SimulatedBlock PlannedBlock(const Scene& scene) {
  SimulatedBlock planned = Simulate(scene);
  if (!planned.planned.empty()) planned.block.passes = planned.planned;
  planned.block.looks.time_s = planned.exact.nominal_time_s;
  std::fill(planned.block.looks.range_m.begin(), planned.block.looks.range_m.end(), kNotGiven);
  return planned;
}

double VerificationOptions::LevelOfOne(std::size_t cases) const {
  std::size_t verified = 0;
  for (std::size_t i = 0; i < cases; ++i) verified += Covers(i) ? 1U : 0U;
  return std::pow(level, 1.0 / static_cast<double>(std::max<std::size_t>(1, verified)));
}

VerificationOptions ReadVerification(SceneTable& table) {
  using Navigation = VerificationOptions::Navigation;
  VerificationOptions verify;
  if (const auto runs = table.Take("runs")) verify.runs = runs->Integer(0, 1000000);
  table.Count("every", &verify.every);
  if (verify.every == 0) throw InputError(table.PlaceOf("every"), "must be 1 at least");
  table.Number("level", &verify.level);
  if (!(verify.level > 0.0 && verify.level < 1.0)) {
    throw InputError(table.PlaceOf("level"), "must lie between 0 and 1");
  }
  table.Choice<Navigation>("navigation",
                           {{"priors", Navigation::kPriors}, {"scene", Navigation::kScene}},
                           &verify.navigation);
  table.Finish();
  return verify;
}

std::vector<std::uint32_t> PointsCounted(const Block& block, const PointResults& points) {
  std::vector<std::uint32_t> counted;
  for (std::size_t i = 0; i < points.status.size(); ++i) {
    if (IsSolved(points.status[i]) && block.points.role[i] != PointRole::kControl) {
      counted.push_back(static_cast<std::uint32_t>(i));
    }
  }
  return counted;
}

namespace {

[[noreturn]] void Refuse(const CorrectionGroup& group, const std::string& why) {
  throw InputError("verify.navigation",
                   "'priors' cannot draw the corrections '" + group.name + "' (" + why +
                       "); 'scene' draws the scene's [navigation]");
}

/// Prior, or what the scene has where there is none.
double Or(double prior, double scene) { return std::isnan(prior) ? scene : prior; }

void Take(const CorrectionGroup& group,
          const PositionCorrection& position,
          const SceneNavigation& scene,
          SceneNavigation* drawn) {
  using Process = PositionCorrection::Process;
  if (position.basis == PositionCorrection::Basis::kSpline) {
    if (position.process == Process::kWhite) Refuse(group, "splines of independent coefficients");
    if (drawn->process != SceneNavigation::Process::kNone) Refuse(group, "several splines");
  }
  if (position.axes != PositionCorrection::Axes::kTrack) Refuse(group, "frame axes");
  if (position.degree > 2) Refuse(group, "a degree above 2");
  if (group.shared) Refuse(group, "shared by passes");
  const std::array<std::array<double, 3> SceneNavigation::*, 3> members = {
      &SceneNavigation::constant_sigma_m,
      &SceneNavigation::drift_sigma_m,
      &SceneNavigation::curvature_sigma_m};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!position.components[axis]) continue;
    const std::vector<double>& prior = position.prior_sigma_m[axis];
    if (position.basis == PositionCorrection::Basis::kSpline) {
      const bool walk = position.process == Process::kRandomWalk;
      drawn->process =
          walk ? SceneNavigation::Process::kRandomWalk : SceneNavigation::Process::kGaussMarkov;
      drawn->knot_spacing_s = position.knot_spacing_s;
      drawn->correlation_time_s = position.correlation_time_s;
      drawn->process_sigma_m[axis] = prior.empty() ? scene.process_sigma_m[axis] : prior.front();
      // A walk that starts anywhere is one from zero and a constant.
      if (walk && !prior.empty()) drawn->constant_sigma_m[axis] = position.start_sigma_m[axis];
      continue;
    }
    for (std::size_t degree = 0; degree <= static_cast<std::size_t>(position.degree); ++degree) {
      const double sigma_m = prior.empty()       ? kNotGiven
                             : prior.size() == 1 ? prior[0]
                                                 : prior[degree];
      (drawn->*members[degree])[axis] = Or(sigma_m, (scene.*members[degree])[axis]);
    }
  }
}

/// Which of the corrections that are not shared have joint priors, in the order of the groups.
std::set<int> JointParameters(const AdjustOptions& options) {
  const JointPriorBindings bindings = BindJointPriors({"pass"}, options.groups, options.priors);
  for (const JointPrior& prior : options.priors) {
    if (prior.passes.empty()) continue;
    throw InputError("verify.navigation",
                     "'priors' cannot draw " + KeyOf(prior) +
                         " (single passes); 'scene' draws the scene's [navigation]");
  }
  if (bindings.problem) throw InputError("adjust.prior", bindings.problem->problem);
  std::set<int> joint;
  for (const JointPriorBinding& binding : bindings.bound) {
    joint.insert(binding.parameters.begin(), binding.parameters.end());
  }
  return joint;
}

}  // namespace

SceneNavigation NavigationFromPriors(const AdjustOptions& options, const SceneNavigation& scene) {
  SceneNavigation drawn;
  drawn.shared_biases = scene.shared_biases;
  if (options.corrections != CorrectionChoice::kGiven) return drawn;
  drawn.joint = options.priors;
  const std::set<int> joint = JointParameters(options);
  int next = 0;  // parameter that is not shared
  for (const CorrectionGroup& group : options.groups) {
    if (!group.passes.empty()) Refuse(group, "single passes");
    if (!group.shared) {
      const auto parameters = static_cast<int>(ParametersOf(group).size());
      const auto of_joint =
          std::distance(joint.lower_bound(next), joint.lower_bound(next + parameters));
      next += parameters;
      if (of_joint > 0 && of_joint == parameters) continue;
      if (of_joint > 0) Refuse(group, "a joint prior for a part of its parameters");
    }
    if (const auto* position = std::get_if<PositionCorrection>(&group.model)) {
      Take(group, *position, scene, &drawn);
      continue;
    }
    if (group.shared != scene.shared_biases) {
      Refuse(group, "shared where navigation.shared_biases is not, or the other way round");
    }
    if (const auto* range = std::get_if<RangeCorrection>(&group.model)) {
      if (range->bias) {
        drawn.range_bias_sigma_m = Or(range->bias_prior_sigma_m, scene.range_bias_sigma_m);
      }
      if (range->scale) {
        drawn.range_scale_sigma = Or(range->scale_prior_sigma, scene.range_scale_sigma);
      }
    } else if (const auto* time = std::get_if<TimeCorrection>(&group.model)) {
      drawn.time_bias_sigma_s = Or(time->bias_prior_sigma_s, scene.time_bias_sigma_s);
    } else if (const auto* squint = std::get_if<SquintCorrection>(&group.model)) {
      drawn.squint_bias_sigma_rad = Or(squint->bias_prior_sigma_rad, scene.squint_bias_sigma_rad);
    } else {
      Refuse(group, "velocity or troposphere");
    }
  }
  return drawn;
}

Scene SceneToDraw(const StudyCase& of, const VerificationOptions& options) {
  Scene scene = of.scene;
  if (options.navigation == VerificationOptions::Navigation::kPriors) {
    scene.navigation = NavigationFromPriors(of.adjust, of.scene.navigation);
  }
  return scene;
}

void CheckVerification(const VerificationOptions& options, const std::vector<StudyCase>& cases) {
  for (std::size_t i = 0; i < cases.size(); ++i) {
    if (options.Covers(i)) static_cast<void>(SceneToDraw(cases[i], options));
  }
}

namespace {

/// Square sums of one run over the points.
struct RunSums {
  std::string why_not = {};  // not empty: not compared
  std::array<double, 3> square_m2{};
  double whitened_errors = 0.0;
};

/// What a point's errors are compared with.
struct Reference {
  std::uint32_t point = 0;
  Eigen::Matrix3d enu_from_frame;
  Eigen::Matrix3d axes_from_enu;
  Eigen::Matrix3d whiten;  // inverse Cholesky factor of the covariance
};

RunSums Compare(const SimulatedBlock& drawn,
                const AdjustResult& result,
                const std::vector<Reference>& references) {
  RunSums sums;
  if (!result.usable()) {
    sums.why_not = "not converged";
    return sums;
  }
  for (const Reference& reference : references) {
    if (!IsSolved(result.points.status[reference.point])) {
      sums.why_not = "point " + std::string(drawn.block.points.ids[reference.point]) + " " +
                     NameOf(result.points.status[reference.point]);
      return sums;
    }
    const Eigen::Vector3d e_m =
        reference.enu_from_frame *
        (result.points.position_m[reference.point] - drawn.truth.points_m[reference.point]);
    const Eigen::Vector3d square_m2 = (reference.axes_from_enu * e_m).array().square();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      sums.square_m2[axis] += square_m2[static_cast<Eigen::Index>(axis)];
    }
    sums.whitened_errors += (reference.whiten * e_m).squaredNorm();
  }
  return sums;
}

}  // namespace

Verification Verify(const Scene& scene,
                    const SimulatedBlock& simulated,
                    const AdjustOptions& options,
                    const AdjustResult& predicted,
                    int runs,
                    std::uint64_t seed,
                    double level,
                    ProgressSink* progress,
                    const ErrorAxes& axes) {
  const std::vector<Eigen::Vector3d>& truth_m = simulated.truth.points_m;
  std::vector<Reference> references;
  for (const std::uint32_t point : PointsCounted(simulated.block, predicted.points)) {
    const SymmetricEnu& q = predicted.points.covariance_m2[point];
    const Eigen::Matrix3d matrix = MatrixOf(q);
    const std::optional<Eigen::Matrix3d> lower = dense::LowerFactor(matrix);
    if (!lower) continue;
    references.push_back({point,
                          simulated.block.frame.EnuFromFrame(truth_m[point]),
                          axes ? axes(point) : Eigen::Matrix3d::Identity(),
                          InverseOfUpper(lower->transpose()).transpose()});
  }
  AdjustOptions adjust = options;
  adjust.covariance = CovarianceLevel::kNone;
  adjust.pairs = PairChoice::kNone;
  std::vector<RunSums> sums(static_cast<std::size_t>(runs));
  ParallelForChunks(sums.size(), 1, [&](std::size_t run, std::size_t, std::size_t) {
    RunIsolated([&] {
      if (progress != nullptr && progress->Cancelled()) throw Interrupted("study");
      SimulatedBlock drawn = simulated;
      try {
        Redraw(scene, MixStream(seed, run), RedrawChoice{}, &drawn);
        std::vector<Eigen::Vector3d>& start_m = drawn.block.points.given_m;
        for (std::size_t point = 0; point < start_m.size(); ++point) {
          if (!start_m[point].allFinite()) start_m[point] = truth_m[point];  // where it was planned
        }
        sums[run] = Compare(drawn, Adjust(drawn.block, adjust), references);
      } catch (const UndeterminedError& error) {
        sums[run].why_not = error.what();
      } catch (const InputError& error) {  // a draw that gives no block
        sums[run].why_not = error.what();
      }
    });
  });

  Verification out;
  double whitened_errors = 0.0;
  std::array<double, 3> square_m2{};
  for (const RunSums& run : sums) {
    if (!run.why_not.empty()) {
      if (++out.failed == 1) out.why = run.why_not;
      continue;
    }
    ++out.runs;
    whitened_errors += run.whitened_errors;
    for (std::size_t axis = 0; axis < 3; ++axis) square_m2[axis] += run.square_m2[axis];
  }
  if (out.runs == 0 || references.empty()) return out;
  const double count = static_cast<double>(out.runs) * static_cast<double>(references.size());
  out.nees = whitened_errors / (3.0 * count);
  for (std::size_t axis = 0; axis < 3; ++axis) out.rms_m[axis] = std::sqrt(square_m2[axis] / count);
  const BlockCovariance covariance(simulated.block, options, truth_m, predicted.points.status);
  std::vector<std::size_t> chosen;
  std::size_t at = 0;
  for (const Reference& reference : references) {
    while (covariance.points()[at] != reference.point) ++at;
    chosen.push_back(at);
  }
  const double degrees = out.runs * covariance.SquareFreedom(chosen);
  const Interval square = ChiSquareInterval(level, degrees);
  out.bound = {square.lower / degrees, square.upper / degrees};
  return out;
}

void SetVerification(const Verification& verified,
                     const std::array<std::string, 3>& axes,
                     StudyRowMaker* row) {
  row->Count("runs", static_cast<std::size_t>(verified.runs));
  if (verified.runs > 0) {
    for (std::size_t axis = 0; axis < axes.size(); ++axis) {
      row->Set("montecarlo_rms_" + axes[axis] + "_m", verified.rms_m[axis]);
    }
    row->Set("nees", verified.nees)
        .Set("nees_lower", verified.bound.lower)
        .Set("nees_upper", verified.bound.upper);
  }
  const bool agrees = verified.failed == 0 && verified.bound.Contains(verified.nees);
  row->Count("agrees", agrees ? 1 : 0);
  if (verified.failed > 0) {
    row->Message(std::to_string(verified.failed) +
                 " runs could not be compared, the first: " + verified.why);
  }
}

std::vector<std::string> DescribeVerification(
    const VerificationOptions& options,
    const StudyTable& table,
    const std::function<std::string(std::size_t row)>& name_of) {
  std::size_t verified = 0, agree = 0;
  double least = 1e300, most = 0.0;
  std::string not_agreeing;
  for (std::size_t row = 0; row < table.size(); ++row) {
    if (std::isnan(table.Number(row, "agrees"))) continue;
    ++verified;
    least = std::fmin(least, table.Number(row, "nees"));
    most = std::fmax(most, table.Number(row, "nees"));
    if (table.Number(row, "agrees") == 1.0) {
      ++agree;
    } else {
      not_agreeing += fmt::format("; not {} ({:.3f}, allowed {:.3f} to {:.3f})",
                                  name_of(row),
                                  table.Number(row, "nees"),
                                  table.Number(row, "nees_lower"),
                                  table.Number(row, "nees_upper"));
    }
  }
  if (verified == 0) return {};
  return {fmt::format(
      "Monte Carlo agrees with the prediction in {} of {} verified rows, {} runs each: normalised "
      "errors squared {:.3f} to {:.3f}{}",
      agree,
      verified,
      options.runs,
      least,
      most,
      not_agreeing)};
}

}  // namespace sarblock
