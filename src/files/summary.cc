// SPDX-License-Identifier: Apache-2.0
#include "summary.h"

#include "sarblock/core/error.h"
#include "sarblock/files/block_file.h"
#include "sarblock/files/result.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <initializer_list>
#include <sstream>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "block_file.h"
#include "core/text.h"
#include "correction_options.h"
#include "quality/assess.h"
#include "result_tables.h"
#include "tables/checksum.h"
#include "tables/json.h"
#include "tables/open.h"
#include <nlohmann/json.hpp>
#include <toml++/toml.h>

namespace sarblock::files {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kResultFormat = "sarblock-result 1";

/// What an object of the summary holds is listed once, by a function List(members, value): a
/// MemberWriter makes the object of the value, a MemberReader the value of the object.
class MemberWriter {
 public:
  explicit MemberWriter(Json* json) : json_(json) {}
  template <typename T>
  void operator()(const char* name, const T& value) const {
    (*json_)[name] = value;
  }
  template <typename T>
  void Required(const char* name, const T& value) const {
    (*this)(name, value);
  }
  /// A figure that follows from the others, for who reads the file.
  template <typename T>
  void Derived(const char* name, const T& value) const {
    (*this)(name, value);
  }
  /// An index, as the name that belongs to it.
  template <typename T>
  void Choice(const char* name, const T& value, const std::vector<std::string>& names) const {
    (*json_)[name] = names.at(static_cast<std::size_t>(value));
  }

 private:
  Json* json_;
};

/// Members that are missing or null: NaN, and the values of a structure as it is made. Names of an
/// index are required.
class MemberReader {
 public:
  explicit MemberReader(const JsonValue& section) : section_(section) {}
  template <typename T>
  void operator()(const char* name, T& value) const {
    if (const auto found = section_.Find(name)) {
      Get(*found, value);
    } else if constexpr (std::is_floating_point_v<T>) {
      value = kNotGiven;
    }
  }
  template <typename T>
  void Required(const char* name, T& value) const {
    Get(section_.Require(name), value);
  }
  template <typename T>
  void Derived(const char*, const T&) const {}
  template <typename T>
  void Choice(const char* name, T& value, const std::vector<std::string>& names) const {
    value = static_cast<T>(section_.Require(name).OneOf(names));
  }

 private:
  static void Get(const JsonValue& from, double& value) { value = from.Number(); }
  static void Get(const JsonValue& from, bool& value) { value = from.Flag(); }
  static void Get(const JsonValue& from, std::string& value) { value = from.Text(); }
  template <std::integral T>
  static void Get(const JsonValue& from, T& value) {
    value = static_cast<T>(from.Count());
  }
  static void Get(const JsonValue& from, std::vector<std::string>& values) {
    for (const JsonValue& entry : from.Entries()) values.push_back(entry.Text());
  }

  JsonValue section_;
};

/// U, constant where it is written.
template <typename T, typename U>
concept Either = std::same_as<std::remove_const_t<T>, U>;

template <typename Members, Either<ObservationGroup> T>
void List(const Members& members, T& group) {
  members("group", group.name);
  members("square_sum", group.square_sum);
  members("redundancy", group.redundancy);
  members.Derived("factor", group.factor());
  members.Derived("sigma", group.factor_deviation());
  members("lower", group.band.lower);
  members("upper", group.band.upper);
}

template <typename Members, Either<ReductionTerm> T>
void List(const Members& members, T& reduction, const std::vector<std::string>& passes) {
  members.Choice("pass", reduction.pass, passes);
  members("term", reduction.term);
  members("unit", reduction.unit);
  members("mean", reduction.mean);
  members("least", reduction.least);
  members("largest", reduction.largest);
}

template <typename Members, Either<DifferenceClass> T>
void List(const Members& members, T& difference) {
  members.Choice("direction", difference.along, {"across", "along"});
  members("distance_m", difference.distance_m);
  members("pairs", difference.pairs);
  members("sigma_along_m", difference.sigma_along_m);
  members("sigma_across_m", difference.sigma_across_m);
  members("sigma_up_m", difference.sigma_up_m);
}

template <typename Members, Either<ResultFinding> T>
void List(const Members& members, T& finding) {
  members("round", finding.round);
  members("point", finding.point);
  members("passes", finding.passes);
  members("control", finding.control);
  members("component", finding.component);
  members("w", finding.w);
  members("located", finding.located);
  members("action", finding.action);
  members("note", finding.note);
}

template <typename Members, Either<VarianceComponent> T>
void List(const Members& members, T& component) {
  members("group", component.group);
  members.Choice("component", component.component, {"range", "azimuth"});
  members("looks", component.looks);
  members("redundancy", component.redundancy);
  members("estimated", component.estimated);
  members("factor", component.factor);
  members("factor_sigma", component.factor_deviation);
  members("sigma_before", component.sigma_before);
  members.Derived("sigma_after", component.sigma_after());
  members.Derived("sigma_after_sigma", component.sigma_deviation());
  members("unit", component.unit);
  members("note", component.note);
}

template <typename Members, Either<ResultRepetition::Figure> T>
void List(const Members& members, T& figure) {
  members("expected", figure.expected);
  members("mean", figure.mean);
  members("lower", figure.lower);
  members("upper", figure.upper);
  members("agrees", figure.agrees);
}

template <typename Members, Either<InputFile> T>
void List(const Members& members, T& file) {
  members("file", file.name);
  members("bytes", file.bytes);
  members("sha256", file.sha256);
}

template <typename Members, typename T>
void ListAcceptance(const Members& members, T& test) {
  members.Required("lower", test.chi_square.lower);
  members.Required("upper", test.chi_square.upper);
  members.Required("level", test.level);
  members.Required("passed", test.passed);
}

/// A test of `variance_components`.
template <typename Members, Either<ResultTest> T>
void List(const Members& members, T& test) {
  members("sigma0_squared", test.sigma0_squared);
  members("redundancy", test.redundancy);
  members.Derived("value", test.sigma0_squared * test.redundancy);
  ListAcceptance(members, test);
}

/// `chi_square`, beside which the summary has sigma0_squared.
template <typename Members, typename T>
void ListChiSquare(const Members& members, T& test) {
  members.Derived("value", test.sigma0_squared * test.redundancy);
  members("redundancy", test.redundancy);
  ListAcceptance(members, test);
}

/// How an AdjustResult, or a ResultSummary, came to its solution.
template <typename Members, typename T>
void ListSolution(const Members& members, T& result) {
  members.Required("iterations", result.iterations);
  members.Required("initial_cost", result.initial_cost);
  members.Required("final_cost", result.final_cost);
  members.Required("gradient", result.gradient);
  members("remaining_step", result.remaining_step);
  members.Required("sigma0_squared", result.sigma0_squared);
}

/// `names` is what List() takes beside the value.
template <typename T, typename... Names>
Json Written(const T& value, const Names&... names) {
  Json json = Json::object();
  List(MemberWriter(&json), value, names...);
  return json;
}
template <typename T, typename... Names>
Json WrittenAll(const std::vector<T>& values, const Names&... names) {
  Json list = Json::array();
  for (const T& value : values) list.push_back(Written(value, names...));
  return list;
}
template <typename T, typename... Names>
T ReadAs(const JsonValue& section, const Names&... names) {
  T value{};
  List(MemberReader(section), value, names...);
  return value;
}

/// The figures of repeated noise, in the order of MonteCarloSection().
constexpr std::array kRepeatedFigures = {"normalised_square",
                                         "variance_ratio_e",
                                         "variance_ratio_n",
                                         "variance_ratio_u",
                                         "coverage_50",
                                         "coverage_90",
                                         "coverage_99"};

const char* NameOf(AdjustStatus status) {
  switch (status) {
    case AdjustStatus::kConverged:
      return "converged";
    case AdjustStatus::kNotConverged:
      return "not_converged";
    case AdjustStatus::kIntersected:
      return "intersected";
    case AdjustStatus::kPredicted:
      return "predicted";
  }
  return "";
}

Json FrameJson(const Block& block) {
  if (block.frame.kind() == FrameKind::kLocal) return {{"kind", "local"}};
  const Ellipsoid& ellipsoid = block.frame.ellipsoid();
  Json json = {{"kind", "geocentric"},
               {"ellipsoid",
                {{"name", ellipsoid.name}, {"a_m", ellipsoid.a_m}, {"f", ellipsoid.flattening}}}};
  if (!block.realization.empty()) json["realization"] = block.realization;
  if (!std::isnan(block.epoch_year)) json["epoch"] = block.epoch_year;
  return json;
}

/// How the recorded flight of a pass was read and what that does to a point.
Json TrajectoryJson(const RecordedFlight& recorded) {
  const RecordingEffect& effect = recorded.effect;
  Json json = {{"through", NameOf(effect.through)},
               {"asked", NameOf(recorded.asked.through)},
               {"noise_m", effect.noise_m},
               {"contradiction_m", effect.contradiction_m},
               {"interpolation_m", effect.interpolation_m},
               {"azimuth_sigma_m", effect.azimuth_sigma_m},
               {"state_sigma_m", effect.noise.position_m},
               {"state_sigma_mps", effect.noise.velocity_mps}};
  if (!effect.why.empty()) json["why"] = effect.why;
  if (effect.fit) {
    json["fit"] = {{"position", effect.fit->position_ratio},
                   {"position_freedom", effect.fit->position_freedom},
                   {"velocity", effect.fit->velocity_ratio},
                   {"velocity_freedom", effect.fit->velocity_freedom}};
  }
  return json;
}

Json PassesJson(const Block& block) {
  Json passes = Json::array();
  for (const Pass& pass : block.passes) {
    Json entry = {{"id", pass.id},
                  {"look", pass.side == LookSide::kLeft ? "left" : "right"},
                  {"start_s", pass.start_s},
                  {"end_s", pass.end_s}};
    if (!std::isnan(pass.wavelength_m)) entry["wavelength_m"] = pass.wavelength_m;
    if (!pass.epoch_utc.empty()) entry["epoch_utc"] = pass.epoch_utc;
    entry["trajectory"] = TrajectoryJson(pass.recorded);
    passes.push_back(std::move(entry));
  }
  return passes;
}

Json Counts(const Block& block, const AdjustResult& result) {
  Json counts = {{"passes", block.passes.size()},
                 {"points", block.points.size()},
                 {"looks", block.looks.size()},
                 {"parameters", result.parameter_count},
                 {"observations", result.observation_count},
                 {"datum_defects", result.datum_defects},
                 {"redundancy", result.redundancy()},
                 {"looks_used", result.looks_used},
                 {"looks_not_evaluated", result.looks_not_evaluated}};
  for (const PointRole role : {PointRole::kTie, PointRole::kControl, PointRole::kCheck}) {
    counts[std::string(files::NameOf(role)) + "_points"] =
        std::count(block.points.role.begin(), block.points.role.end(), role);
  }
  counts["point_status"] = Json::object();
  for (const PointStatus status : result.points.status) {
    Json& count = counts["point_status"][sarblock::NameOf(status)];
    count = count.is_null() ? 1 : count.get<int>() + 1;
  }
  return counts;
}

Json Curvatures(const AdjustResult& result) {
  Json curvatures = Json::array();
  for (const CorrectionCurvature& of : result.curvatures) {
    const ParameterResult& parameter = result.parameters[of.parameter];
    curvatures.push_back(
        {{"owner", parameter.owner}, {"parameter", parameter.name}, {"curvature", of.curvature}});
  }
  return curvatures;
}

/// The test of the result as it is.
ResultTest TestOf(const AdjustResult& result, const AdjustTable& options) {
  return {
      {result.sigma0_squared, result.test_redundancy, result.chi_square, result.chi_square_passed},
      options.test_level};
}

Json ChiSquare(const AdjustTable& options, const AdjustResult& result) {
  if (std::isnan(result.sigma0_squared)) return nullptr;
  const ResultTest test = TestOf(result, options);
  Json json;
  ListChiSquare(MemberWriter(&json), test);
  return json;
}

Json Selection(const SelectionReport& selection) {
  Json kept = Json::array(), held = Json::array();
  for (const CandidateResult& candidate : selection.candidates) {
    if (!candidate.kept && !candidate.held) continue;
    (candidate.kept ? kept : held)
        .push_back({{"candidate", candidate.name}, {"passes", candidate.passes}});
  }
  Json simplifications = Json::array();
  for (const SimplificationBound& bound : selection.simplifications) {
    simplifications.push_back({{"simplification", bound.name},
                               {"fraction", bound.fraction},
                               {"allowed", bound.allowed},
                               {"taken", bound.taken},
                               {"gain", bound.gain},
                               {"verdict", bound.verdict}});
  }
  return {{"candidates", selection.candidates.size()},
          {"rounds", selection.rounds},
          {"steps", selection.steps},
          {"settled", selection.settled},
          {"kept", kept},
          {"held", held},
          {"simplifications", simplifications},
          {"simplified_gain", selection.simplified_gain},
          {"simplified_shift", selection.simplified_shift},
          {"model", DumpCorrections(selection.groups)}};
}

// A stage that ran more than once has the sum of its times.
Json Stages(std::initializer_list<const std::vector<StageCost>*> lists) {
  Json stages = Json::object();
  for (const std::vector<StageCost>* list : lists) {
    for (const StageCost& cost : *list) {
      Json& stage = stages[cost.stage];
      const double before_s = stage.is_null() ? 0.0 : stage["wall_s"].get<double>();
      stage = {{"wall_s", before_s + cost.wall_s}, {"peak_mib", cost.peak_mib}};
    }
  }
  return stages;
}

const char* ComponentName(bool azimuth) { return azimuth ? "azimuth" : "range"; }

Json WorstJson(const Block& block, const QualitySummary& summary) {
  Json worst = Json::array();
  for (const TestedLook& look : summary.worst) {
    worst.push_back({{"pass", block.passes[block.looks.pass[look.look]].id},
                     {"point", std::string(block.points.ids[look.point])},
                     {"component", ComponentName(look.azimuth)},
                     {"w", look.w},
                     {"redundancy", look.redundancy}});
  }
  return worst;
}

Json PriorsJson(const AdjustResult& result) {
  const PriorSummary& summary = result.assessment.priors;
  Json json = {{"priors", summary.priors},
               {"redundancy", summary.redundancy},
               {"tested", summary.tested},
               {"above_critical", summary.above},
               {"expected_above", summary.expected_above}};
  if (summary.tested > 0) {
    const ParameterResult& worst = result.parameters[summary.worst];
    json["worst"] = {{"pass", worst.owner}, {"parameter", worst.name}, {"w", summary.worst_w}};
  }
  return json;
}

Json SharesJson(const std::vector<PassShare>& all) {
  Json shares = Json::array();
  for (const PassShare& share : all) {
    shares.push_back({{"pass", share.owner},
                      {"looks", share.looks},
                      {"square_sum", share.square_sum},
                      {"redundancy", share.redundancy},
                      {"prior_square_sum", share.prior_square_sum},
                      {"prior_redundancy", share.prior_redundancy},
                      {"sigma0_squared", share.variance_factor()}});
  }
  return shares;
}

/// What others check of ranges, azimuths and control; infinite figures are null.
Json CheckedJson(const Block& block, const QualitySummary& summary) {
  constexpr std::array kKinds = {"range", "azimuth", "control"};
  constexpr std::array kAxisNames = {"e", "n", "u"};
  Json json = Json::object();
  for (std::size_t k = 0; k < kKinds.size(); ++k) {
    const CheckedObservations& of = summary.checked[k];
    if (of.count == 0) continue;
    Json weakest = {{"point", std::string(block.points.ids[of.point])}};
    if (k == 2) {
      weakest["component"] = kAxisNames[of.part];
    } else {
      weakest["pass"] = block.passes[of.part].id;
    }
    weakest["redundancy"] = of.redundancy;
    weakest["mdb_m"] = of.blunder_m;
    weakest["influence_m"] = of.shift_m;
    json[kKinds[k]] = {
        {"observations", of.count}, {"hardly_checked", of.hardly}, {"weakest", std::move(weakest)}};
  }
  return json;
}

Json QualityJson(const Block& block, const AdjustTable& options, const AdjustResult& result) {
  const QualitySummary& summary = result.assessment.tests;
  const ReliabilityFigures& figures = summary.figures;
  Json json = {
      {"alpha", options.quality.alpha},
      {"power", options.quality.power},
      {"family_wise", NameOfChoice("quality.family_wise", options)},
      {"test", NameOfChoice("quality.test", options)},
      {"tests", figures.tests},
      {"alpha_one", figures.alpha_one},
      {"alpha_all", figures.alpha_all},
      {"critical_w", figures.critical_w},
      {"critical_tau", figures.critical_tau},
      {"delta0", figures.delta0},
      {"median_redundancy",
       {{"range", summary.median_redundancy[0]}, {"azimuth", summary.median_redundancy[1]}}},
      {"above_critical",
       {{"range", summary.looks_above[0]},
        {"azimuth", summary.looks_above[1]},
        {"control", summary.control_above}}},
      {"expected_above", summary.expected_above()},
      {"looks_not_localisable", summary.looks_not_localisable},
      {"checked", CheckedJson(block, summary)},
      {"worst", WorstJson(block, summary)},
      {"priors", PriorsJson(result)},
      {"passes", SharesJson(result.assessment.shares)}};
  if (result.status == AdjustStatus::kPredicted) json.erase("above_critical");
  return json;
}

Json SnoopingJson(const Block& block, const SnoopingReport& report) {
  Json findings = Json::array();
  for (const BlunderFinding& finding : report.findings) {
    std::vector<std::string> passes;
    for (const std::uint64_t look : finding.looks) {
      passes.push_back(block.passes[block.looks.pass[look]].id);
    }
    findings.push_back(Written(ResultFinding{static_cast<std::size_t>(finding.round),
                                             std::string(block.points.ids[finding.point]),
                                             std::move(passes),
                                             finding.control,
                                             ComponentName(finding.azimuth),
                                             NameOf(finding.action),
                                             finding.note,
                                             finding.w,
                                             finding.located()}));
  }
  return {{"rounds", report.rounds},
          {"left_out_by_robust_start", report.robust.size()},
          {"findings", findings}};
}

Json CheckPointsJson(const CheckSummary& summary, double level) {
  Json json = {{"points", summary.points},
               {"points_without_sigma", summary.points_without_sigma},
               {"rms_e_m", summary.rms_m[0]},
               {"rms_n_m", summary.rms_m[1]},
               {"rms_u_m", summary.rms_m[2]},
               {"components", summary.components},
               {"chi_square", summary.chi_square}};
  if (summary.components == 0) return json;
  json["freedom"] = summary.freedom;
  json["lower"] = summary.chi_square_interval.lower;
  json["upper"] = summary.chi_square_interval.upper;
  json["level"] = level;
  json["realistic"] = summary.realistic();
  json["error_ratio"] = summary.error_ratio;
  json["points_outside"] = summary.points_outside;
  json["says"] = DescribeChecks(summary, level);
  return json;
}

Json VarianceComponentsSection(const AdjustTable& options, const AdjustResult& result) {
  const VarianceComponentReport& report = *result.variance_components;
  Json section;
  section["iterations"] = report.iterations;
  section["converged"] = report.converged;
  section["before"] = Written(ResultTest{report.before, options.test_level});
  section["after"] = Written(TestOf(result, options));
  section["components"] = WrittenAll(report.components);
  return section;
}

Json MonteCarloSection(const MonteCarloReport& report) {
  Json section;
  section["runs"] = report.runs;
  section["failed"] = report.failed;
  section["seed"] = report.seed;
  section["points"] = report.points;
  section["confidence"] = 0.99;
  const std::array<RunMean, kRepeatedFigures.size()> means = {report.square_ratio,
                                                              report.variance_ratio[0],
                                                              report.variance_ratio[1],
                                                              report.variance_ratio[2],
                                                              report.coverage[0],
                                                              report.coverage[1],
                                                              report.coverage[2]};
  for (std::size_t k = 0; k < means.size(); ++k) {
    const RunMean& mean = means[k];
    section[kRepeatedFigures[k]] = Written(ResultRepetition::Figure{
        {}, mean.expected, mean.mean, mean.lower(), mean.upper(), mean.Agrees()});
  }
  section["points_outside"] = report.points_outside;
  section["verdict"] = report.sentence;
  return section;
}

/// null where there is no number.
Json Number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

/// The whole block with an explanation undone; null where it was not tried.
Json CureJson(const Explanation::Cure& cure) {
  if (!cure.tried) return nullptr;
  return {{"cures", cure.cures},
          {"sigma0_squared", Number(cure.factor)},
          {"lower", Number(cure.lower)},
          {"upper", Number(cure.upper)},
          {"priors", Number(cure.priors_factor)},
          {"points", cure.points}};
}

Json ConfigurationJson(const AdjustTable& options) {
  const toml::table table = toml::parse(DumpAdjustTable(options));
  std::ostringstream text;
  text << toml::json_formatter{*table.get("adjust")};
  auto configuration = Json::parse(text.str());
  configuration["threads"] = options.threads;
  return configuration;
}

}  // namespace

nlohmann::ordered_json DiagnosisSection(const Diagnosis& diagnosis) {
  Json section = Json::array();
  for (const Explanation& reported : diagnosis.explanations) {
    section.push_back({{"kind", NameOf(reported.kind)},
                       {"cause", reported.cause},
                       {"sentence", reported.sentence},
                       {"passes", reported.passes},
                       {"points", reported.points},
                       {"value", Number(reported.value)},
                       {"sigma", Number(reported.sigma)},
                       {"unit", reported.unit},
                       {"equals", reported.equals},
                       {"change", reported.change},
                       {"part", Number(reported.part)},
                       {"square_sum_before", Number(reported.square_sum_before)},
                       {"square_sum_after", Number(reported.square_sum_after)},
                       {"redundancy_before", Number(reported.redundancy_before)},
                       {"redundancy_after", Number(reported.redundancy_after)},
                       {"cure", CureJson(reported.cure)},
                       {"looks_lost_before", reported.looks_lost_before},
                       {"looks_lost_after", reported.looks_lost_after}});
  }
  return section;
}

std::string SummaryText(const Block& block,
                        const AdjustTable& options,
                        const AdjustResult& result,
                        const ResultContext& context,
                        const std::vector<StageCost>& written,
                        const std::vector<TableSum>& tables) {
  Json summary;
  summary["format"] = kResultFormat;
  summary["version"] = Version();
  summary["command"] = context.command;
  summary["block"] = block.name;
  summary["status"] = NameOf(result.status);
  summary["verdict"] = NameOf(result.assessment.verdict);
  summary["verdict_reasons"] = result.assessment.reasons;
  summary["accepted"] = result.usable();
  summary["frame"] = FrameJson(block);
  summary["passes"] = PassesJson(block);
  summary["counts"] = Counts(block, result);
  ListSolution(MemberWriter(&summary), result);
  summary["sigma_scaled_by_posterior"] = options.scale_by_posterior;
  summary["chi_square"] = ChiSquare(options, result);
  summary["groups"] = WrittenAll(result.assessment.groups);
  if (!result.reductions.terms.empty()) {
    summary["reductions"] = WrittenAll(result.reductions.terms, IdsOf(block.passes));
  }
  if (!result.checks.empty()) {
    summary["check_points"] =
        CheckPointsJson(result.assessment.checks, LevelOfOneTest(options.test_level));
  }
  if (!result.quality.empty()) summary["quality"] = QualityJson(block, options, result);
  if (!result.assessment.differences.empty()) {
    summary["differences"] = WrittenAll(result.assessment.differences);
  }
  if (result.snooping) summary["snooping"] = SnoopingJson(block, *result.snooping);
  if (result.variance_components) {
    summary["variance_components"] = VarianceComponentsSection(options, result);
  }
  if (result.montecarlo) summary["montecarlo"] = MonteCarloSection(*result.montecarlo);
  summary["covariance"] = NameOfChoice("covariance", options);
  summary["condition"] = result.condition;
  if (!result.curvatures.empty()) summary["curvatures"] = Curvatures(result);
  if (!result.selection.empty()) summary["selection"] = Selection(result.selection);
  if (context.diagnosis) summary["diagnosis"] = DiagnosisSection(*context.diagnosis);
  summary["stages"] = Stages({&context.stages, &result.stages, &written});
  summary["warnings"] = context.warnings;
  for (const std::string& warning : result.warnings) summary["warnings"].push_back(warning);
  summary["inputs"] = WrittenAll(context.inputs);
  if (!tables.empty()) summary["tables"] = TablesJson(tables);
  summary["configuration"] = ConfigurationJson(options);
  return summary.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string SummaryJson(const Block& block,
                        const AdjustTable& options,
                        const AdjustResult& result,
                        const ResultContext& context) {
  return SummaryText(block, options, result, context, {}, {});
}

nlohmann::ordered_json TablesJson(const std::vector<TableSum>& tables) {
  auto list = nlohmann::ordered_json::array();
  for (const TableSum& table : tables) {
    list.push_back({{"table", table.table}, {"bytes", table.bytes}, {"sha256", table.sha256}});
  }
  return list;
}

namespace {

JsonValue RequireNewer(const JsonValue& summary, const char* name) {
  if (const auto value = summary.Find(name)) return *value;
  summary.Fail(std::string("has no ") + name +
               ": an earlier version of the program wrote it, a result computed anew has it");
}

/// Members of a section that it may lack: NaN, 0, empty, false.
template <typename T>
T In(const JsonValue& section, const char* name) {
  T value{};
  const MemberReader read(section);
  read(name, value);
  return value;
}
std::vector<JsonValue> EntriesIn(const JsonValue& section, const char* name) {
  const auto value = section.Find(name);
  return value ? value->Entries() : std::vector<JsonValue>();
}

template <typename T, typename... Names>
void ReadAll(const JsonValue& section,
             const char* name,
             std::vector<T>* values,
             const Names&... names) {
  for (const JsonValue& entry : EntriesIn(section, name)) {
    values->push_back(ReadAs<T>(entry, names...));
  }
}

Frame ReadFrame(const JsonValue& frame) {
  if (frame.Require("kind").OneOf({"local", "geocentric"}) == 0) return Frame::Local();
  const JsonValue given = frame.Require("ellipsoid");
  const Ellipsoid ellipsoid{
      given.Require("name").Text(), given.Require("a_m").Number(), given.Require("f").Number()};
  try {
    Validate(ellipsoid);
  } catch (const InputError& error) {
    given.Fail(error.what());
  }
  return Frame::Geocentric(ellipsoid);
}

void ReadPasses(const JsonValue& passes, ResultFile* result) {
  IdTable ids;
  for (const JsonValue& entry : passes.Entries()) {
    ResultPass pass;
    pass.id = entry.Require("id").Text();
    const auto index = static_cast<std::uint32_t>(result->passes.size());
    if (pass.id.empty() || ids.FindOrAppend(pass.id) != index) {
      entry.Require("id").Fail(Quoted(pass.id) + " is empty or is given twice");
    }
    pass.side =
        entry.Require("look").OneOf({"left", "right"}) == 0 ? LookSide::kLeft : LookSide::kRight;
    if (const auto value = entry.Find("wavelength_m")) pass.wavelength_m = value->Number();
    pass.start_s = entry.Require("start_s").Number();
    pass.end_s = entry.Require("end_s").Number();
    if (!(pass.start_s < pass.end_s)) entry.Fail("start_s is not before end_s");
    if (const auto value = entry.Find("epoch_utc")) pass.epoch_utc = value->Text();
    result->passes.push_back(std::move(pass));
  }
}

ResultTests ReadTests(const JsonValue& quality) {
  ResultTests tests{In<double>(quality, "alpha_one"),
                    In<double>(quality, "power"),
                    In<double>(quality, "critical_w"),
                    In<double>(quality, "expected_above"),
                    In<std::size_t>(quality, "tests"),
                    In<std::size_t>(quality, "looks_not_localisable")};
  if (const auto above = quality.Find("above_critical")) {
    tests.above = {In<std::size_t>(*above, "range"),
                   In<std::size_t>(*above, "azimuth"),
                   In<std::size_t>(*above, "control")};
  }
  return tests;
}

ResultRepetition ReadRepetition(const JsonValue& section) {
  ResultRepetition repetition{In<std::size_t>(section, "runs"),
                              In<std::size_t>(section, "seed"),
                              In<std::string>(section, "verdict"),
                              {}};
  for (const char* name : kRepeatedFigures) {
    const auto figure = section.Find(name);
    if (!figure) continue;
    repetition.figures.push_back(ReadAs<ResultRepetition::Figure>(*figure));
    repetition.figures.back().name = name;
  }
  return repetition;
}

void ReadSections(const JsonValue& root, ResultSummary* summary) {
  if (const auto test = root.Find("chi_square")) {
    ResultTest& read = summary->chi_square.emplace();
    ListChiSquare(MemberReader(*test), read);
    read.sigma0_squared = summary->sigma0_squared;
    // Results of older versions test all observations.
    if (std::isnan(read.redundancy)) read.redundancy = summary->Count("redundancy");
  }
  ReadAll(root, "groups", &summary->groups);
  ReadAll(root, "differences", &summary->differences);
  if (const auto checks = root.Find("check_points")) {
    summary->checks = {In<std::size_t>(*checks, "points"),
                       In<std::size_t>(*checks, "components"),
                       In<double>(*checks, "error_ratio"),
                       In<bool>(*checks, "realistic"),
                       In<std::string>(*checks, "says")};
  }
  if (const auto quality = root.Find("quality")) summary->tests = ReadTests(*quality);
  if (const auto snooping = root.Find("snooping")) {
    summary->snooping_rounds = In<std::size_t>(*snooping, "rounds");
    ReadAll(*snooping, "findings", &summary->findings);
  }
  if (const auto section = root.Find("variance_components")) {
    if (const auto before = section->Find("before")) {
      summary->test_before = ReadAs<ResultTest>(*before);
    }
    ReadAll(*section, "components", &summary->variances);
  }
  if (const auto section = root.Find("montecarlo")) summary->repetition = ReadRepetition(*section);
  if (const auto selection = root.Find("selection")) {
    summary->selected_model = In<std::string>(*selection, "model");
    summary->selection_settled = In<bool>(*selection, "settled");
  }
}

void Flatten(const JsonValue& value, const std::string& key, ResultSummary* summary) {
  if (!value.IsObject()) {
    summary->configuration.emplace_back(key, value.Node().dump());
    return;
  }
  for (const auto& [name, member] : value.Members()) {
    Flatten(member, key.empty() ? name : key + "." + name, summary);
  }
}

}  // namespace

void ReadSummary(const TableSource& source, ResultFile* result) {
  ResultSummary& summary = result->summary;
  std::string file;
  std::tie(file, summary.json) = source.Read("summary.json");
  const JsonFile parsed(summary.json, file);
  const JsonValue root = parsed.Root();
  const JsonValue format = root.Require("format");
  if (format.Text() != kResultFormat) {
    format.Fail(Quoted(format.Text()) + " is not known, \"" + kResultFormat + "\" is allowed");
  }
  summary.version = root.Require("version").Text();
  summary.command = root.Require("command").Text();
  summary.block = root.Require("block").Text();
  summary.status = root.Require("status").Text();
  const JsonValue verdict = RequireNewer(root, "verdict");
  constexpr std::array kVerdicts = {
      Verdict::kAccepted, Verdict::kTestsFailed, Verdict::kNotAccepted};
  summary.verdict = kVerdicts.at(static_cast<std::size_t>(
      verdict.OneOf({NameOf(kVerdicts[0]), NameOf(kVerdicts[1]), NameOf(kVerdicts[2])})));
  for (const JsonValue& reason : EntriesIn(root, "verdict_reasons")) {
    summary.verdict_reasons.push_back(reason.Text());
  }
  const JsonValue frame = RequireNewer(root, "frame");
  result->frame = ReadFrame(frame);
  result->realization = In<std::string>(frame, "realization");
  result->epoch_year = In<double>(frame, "epoch");
  ReadPasses(RequireNewer(root, "passes"), result);
  const JsonValue counts = root.Require("counts");
  for (const char* name : {"points", "looks"}) static_cast<void>(counts.Require(name).Count());
  for (const auto& [name, value] : counts.Members()) {
    if (name != "point_status") summary.counts.emplace_back(name, value.Number());
  }
  ListSolution(MemberReader(root), summary);
  summary.sigma_scaled_by_posterior = root.Require("sigma_scaled_by_posterior").Flag();
  ReadSections(root, &summary);
  ReadAll(root, "reductions", &result->reductions.terms, IdsOf(result->passes));
  summary.covariance = root.Require("covariance").Text();
  summary.condition = root.Require("condition").Number();
  for (const auto& [name, stage] : root.Require("stages").Members()) {
    summary.stages.push_back(
        {name, stage.Require("wall_s").Number(), stage.Require("peak_mib").Number()});
  }
  for (const JsonValue& warning : root.Require("warnings").Entries()) {
    summary.warnings.push_back(warning.Text());
  }
  ReadAll(root, "inputs", &summary.inputs);
  if (const auto configuration = root.Find("configuration")) {
    Flatten(*configuration, "", &summary);
  }
}

}  // namespace sarblock::files
