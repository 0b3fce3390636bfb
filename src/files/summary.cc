// SPDX-License-Identifier: Apache-2.0
#include "summary.h"

#include "sarblock/core/error.h"
#include "sarblock/files/block_file.h"
#include "sarblock/files/result.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <initializer_list>
#include <memory>
#include <sstream>
#include <string>

#include "block_file.h"
#include "core/threads.h"
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

Json ChiSquare(const AdjustTable& options, const AdjustResult& result) {
  if (std::isnan(result.sigma0_squared)) return nullptr;
  return {{"value", result.sigma0_squared * result.test_redundancy},
          {"redundancy", result.test_redundancy},
          {"lower", result.chi_square.lower},
          {"upper", result.chi_square.upper},
          {"level", options.test_level},
          {"passed", result.chi_square_passed}};
}

Json Groups(const AdjustResult& result) {
  Json groups = Json::array();
  for (const ObservationGroup& group : result.assessment.groups) {
    groups.push_back({{"group", group.name},
                      {"square_sum", group.square_sum},
                      {"redundancy", group.redundancy},
                      {"factor", group.factor()},
                      {"sigma", group.factor_deviation()},
                      {"lower", group.band.lower},
                      {"upper", group.band.upper}});
  }
  return groups;
}

Json ReductionsJson(const Block& block, const AdjustResult& result) {
  Json terms = Json::array();
  for (const ReductionTerm& term : result.reductions.terms) {
    terms.push_back({{"pass", block.passes[term.pass].id},
                     {"term", term.term},
                     {"unit", term.unit},
                     {"mean", term.mean},
                     {"least", term.least},
                     {"largest", term.largest}});
  }
  return terms;
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

std::string Summary(const Block& block,
                    const AdjustTable& options,
                    const AdjustResult& result,
                    const ResultContext& context,
                    const std::vector<StageCost>& written,
                    const std::vector<TableSum>& tables) {
  Json summary;
  summary["format"] = "sarblock-result 1";
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
  summary["iterations"] = result.iterations;
  summary["initial_cost"] = result.initial_cost;
  summary["final_cost"] = result.final_cost;
  summary["gradient"] = result.gradient;
  summary["remaining_step"] = result.remaining_step;
  summary["sigma0_squared"] = result.sigma0_squared;
  summary["sigma_scaled_by_posterior"] = options.scale_by_posterior;
  summary["chi_square"] = ChiSquare(options, result);
  summary["groups"] = Groups(result);
  if (!result.reductions.terms.empty()) summary["reductions"] = ReductionsJson(block, result);
  if (!result.checks.empty()) {
    summary["check_points"] =
        CheckPointsJson(result.assessment.checks, LevelOfOneTest(options.test_level));
  }
  if (!result.quality.empty()) summary["quality"] = QualityJson(block, options, result);
  if (!result.assessment.differences.empty()) {
    summary["differences"] = DifferencesJson(result.assessment.differences);
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
  summary["inputs"] = InputsJson(context.inputs);
  if (!tables.empty()) summary["tables"] = TablesJson(tables);
  summary["configuration"] = ConfigurationJson(options);
  return summary.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

std::string SummaryJson(const Block& block,
                        const AdjustTable& options,
                        const AdjustResult& result,
                        const ResultContext& context) {
  return Summary(block, options, result, context, {}, {});
}

namespace {

/// By pass: the names of the corrections of the result that its corrected states do not hold.
std::vector<std::string> NotInStates(const ResultView& view) {
  std::vector<std::string> out(view.pass_ids.size());
  const auto add = [&out](std::uint32_t pass, const std::string& name) {
    out[pass] += (out[pass].empty() ? "" : " ") + name;
  };
  const SelectionReport& selection = view.result.selection;
  const std::vector<CorrectionGroup>& groups =
      selection.empty() ? view.options.groups : selection.groups;
  for (const ParameterResult& parameter : view.result.parameters) {
    if (parameter.name.starts_with("position.") || parameter.value == 0.0) continue;
    const auto shared = std::find_if(groups.begin(), groups.end(), [&](const CorrectionGroup& g) {
      return g.shared && g.name == parameter.owner;
    });
    if (shared == groups.end()) {
      const std::uint32_t own = view.pass_ids.Find(parameter.owner);
      if (own != IdTable::kNone) add(own, parameter.name);
      continue;
    }
    for (std::uint32_t pass = 0; pass < out.size(); ++pass) {
      if (IsOf(*shared, std::string(view.pass_ids[pass]))) add(pass, parameter.name);
    }
  }
  for (std::string& names : out) {
    if (names.empty()) names = kAllAdjusted;
  }
  return out;
}

void WriteResultTables(TableSink* sink, const ResultView& view, std::size_t ellipse_limit) {
  const Block& block = view.block;
  const AdjustResult& result = view.result;
  WritePointTable(sink, view);
  WriteParameterTable(sink, view);
  WriteParameterCovariance(sink, view);
  if (!result.selection.empty()) {
    WriteSelectionTable(sink, view);
    WriteSimplificationTable(sink, view);
  }
  WriteStripTable(sink, view);
  WriteResidualTable(sink, view);
  if (!result.control_quality.empty()) WriteControlTable(sink, view);
  if (view.options.pairs != PairChoice::kNone || !result.pairs.empty()) WritePairTable(sink, view);
  if (result.montecarlo) WriteMonteCarloTable(sink, view);
  if (result.corrected_paths.empty()) {
    WritePaths(sink, "trajectories", view.pass_ids, NominalPaths(block));
  } else {
    WritePaths(sink, "trajectories", view.pass_ids, result.corrected_paths, NotInStates(view));
  }
  const auto folder = sink->folder();
  if (block.frame.kind() != FrameKind::kGeocentric || !folder) return;
  WriteGeoJson(*folder / "points.geojson",
               {.frame = block.frame,
                .name = block.name,
                .ids = block.points.ids,
                .role = block.points.role,
                .points = result.points,
                .polygons = result.points.status.size() <= ellipse_limit});
}

}  // namespace

std::string WriteResult(const std::filesystem::path& target,
                        const Block& block,
                        const AdjustTable& options,
                        const AdjustResult& result,
                        const ResultContext& context) {
  const IdTable passes = PassIds(block);
  const ResultView view{block, passes, options, result};
  ResultContext said = context;
  if (block.frame.kind() == FrameKind::kGeocentric && !NamesContainer(target) &&
      result.points.status.size() > context.ellipse_limit) {
    said.warnings.push_back(
        "points.geojson has the numbers of the error ellipses but not their "
        "polygons, there are more than " +
        std::to_string(context.ellipse_limit) + " points");
  }
  std::string summary;
  const BlockIds ids{&passes, &block.points.ids};
  const auto write = [&](TableSink* sink) {
    std::vector<StageCost> written;
    {
      const StageTimer timer("write", &written);
      WriteResultTables(sink, view, context.ellipse_limit);
    }
    const auto folder = sink->folder();
    summary =
        Summary(block,
                options,
                result,
                said,
                written,
                folder ? SumsOfTables(*folder, FolderContent::kResult) : std::vector<TableSum>());
    sink->WriteText("summary.json", summary);
  };
  WriteTables(FolderContent::kResult, target, context.compression, ids, write);
  return summary;
}

namespace {

using Json = nlohmann::ordered_json;

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

}  // namespace

Json DifferencesJson(const std::vector<DifferenceClass>& differences) {
  Json json = Json::array();
  for (const DifferenceClass& of : differences) {
    json.push_back({{"direction", of.along ? "along" : "across"},
                    {"distance_m", of.distance_m},
                    {"pairs", of.pairs},
                    {"sigma_along_m", of.sigma_along_m},
                    {"sigma_across_m", of.sigma_across_m},
                    {"sigma_up_m", of.sigma_up_m}});
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
    Json passes = Json::array();
    for (const std::uint64_t look : finding.looks) {
      passes.push_back(block.passes[block.looks.pass[look]].id);
    }
    findings.push_back({{"round", finding.round},
                        {"point", std::string(block.points.ids[finding.point])},
                        {"passes", passes},
                        {"control", finding.control},
                        {"component", ComponentName(finding.azimuth)},
                        {"w", finding.w},
                        {"located", finding.located()},
                        {"action", NameOf(finding.action)},
                        {"note", finding.note}});
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

namespace {

using Json = nlohmann::ordered_json;

Json TestSection(const GlobalTest& test, double level) {
  return {{"sigma0_squared", test.sigma0_squared},
          {"redundancy", test.redundancy},
          {"value", test.sigma0_squared * test.redundancy},
          {"lower", test.chi_square.lower},
          {"upper", test.chi_square.upper},
          {"level", level},
          {"passed", test.passed}};
}

Json MeanSection(const RunMean& mean) {
  return {{"expected", mean.expected},
          {"mean", mean.mean},
          {"lower", mean.lower()},
          {"upper", mean.upper()},
          {"agrees", mean.Agrees()}};
}

}  // namespace

Json VarianceComponentsSection(const AdjustTable& options, const AdjustResult& result) {
  const VarianceComponentReport& report = *result.variance_components;
  Json section;
  section["iterations"] = report.iterations;
  section["converged"] = report.converged;
  section["before"] = TestSection(report.before, options.test_level);
  section["after"] = TestSection(
      {result.sigma0_squared, result.test_redundancy, result.chi_square, result.chi_square_passed},
      options.test_level);
  section["components"] = Json::array();
  for (const VarianceComponent& c : report.components) {
    section["components"].push_back({{"group", c.group},
                                     {"component", c.component == 0 ? "range" : "azimuth"},
                                     {"looks", c.looks},
                                     {"redundancy", c.redundancy},
                                     {"estimated", c.estimated},
                                     {"factor", c.factor},
                                     {"factor_sigma", c.factor_deviation},
                                     {"sigma_before", c.sigma_before},
                                     {"sigma_after", c.sigma_after()},
                                     {"sigma_after_sigma", c.sigma_deviation()},
                                     {"unit", c.unit},
                                     {"note", c.note}});
  }
  return section;
}

Json MonteCarloSection(const MonteCarloReport& report) {
  Json section;
  section["runs"] = report.runs;
  section["failed"] = report.failed;
  section["seed"] = report.seed;
  section["points"] = report.points;
  section["confidence"] = 0.99;
  section["normalised_square"] = MeanSection(report.square_ratio);
  section["variance_ratio_e"] = MeanSection(report.variance_ratio[0]);
  section["variance_ratio_n"] = MeanSection(report.variance_ratio[1]);
  section["variance_ratio_u"] = MeanSection(report.variance_ratio[2]);
  section["coverage_50"] = MeanSection(report.coverage[0]);
  section["coverage_90"] = MeanSection(report.coverage[1]);
  section["coverage_99"] = MeanSection(report.coverage[2]);
  section["points_outside"] = report.points_outside;
  section["verdict"] = report.sentence;
  return section;
}

void WriteMonteCarloTable(TableSink* sink, const ResultView& view) {
  constexpr const auto& kColumns = kMonteCarloColumns;
  const auto table = sink->Open("montecarlo", kColumns);
  const MonteCarloReport& report = *view.result.montecarlo;
  WriteEach(report.square.size(), table.get(), [&](std::size_t point, Batch* batch) {
    if (report.runs == 0 || std::isnan(report.square[point])) return;
    const std::array<double, 6>& sample_m2 = report.sample_m2[point];
    const SymmetricEnu& rigorous_m2 = view.result.points.covariance_m2[point];
    NewRow row(batch);
    row.Id(kColumns("point"), view.block.points.ids, static_cast<std::uint32_t>(point));
    std::array<double, 3> sample_m{}, rigorous_m{}, ratio{}, coverage{};
    for (std::size_t i = 0; i < 3; ++i) {
      sample_m[i] = std::sqrt(sample_m2[i]);
      rigorous_m[i] = std::sqrt(rigorous_m2[i]);
      ratio[i] = std::sqrt(sample_m2[i] / rigorous_m2[i]);
      coverage[i] = static_cast<double>(report.inside[i][point]) / report.runs;
    }
    row.Numbers(kColumns("sample_sigma_e_m", "sample_sigma_n_m", "sample_sigma_u_m"), sample_m);
    row.Numbers(kColumns("sigma_e_m", "sigma_n_m", "sigma_u_m"), rigorous_m);
    row.Numbers(kColumns("ratio_e", "ratio_n", "ratio_u"), ratio);
    row.Number(kColumns("normalised_square"), report.square[point]);
    row.Numbers(kColumns("coverage_50", "coverage_90", "coverage_99"), coverage);
  });
  table->Commit();
}

namespace {

using Json = nlohmann::ordered_json;

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

}  // namespace

Json DiagnosisSection(const Diagnosis& diagnosis) {
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

nlohmann::ordered_json ConfigurationJson(const AdjustTable& options) {
  const toml::table table = toml::parse(DumpAdjustTable(options));
  std::ostringstream text;
  text << toml::json_formatter{*table.get("adjust")};
  auto configuration = nlohmann::ordered_json::parse(text.str());
  configuration["threads"] = options.threads;
  return configuration;
}

nlohmann::ordered_json InputsJson(const std::vector<InputFile>& files) {
  auto inputs = nlohmann::ordered_json::array();
  for (const InputFile& file : files) {
    inputs.push_back({{"file", file.name}, {"bytes", file.bytes}, {"sha256", file.sha256}});
  }
  return inputs;
}

nlohmann::ordered_json TablesJson(const std::vector<TableSum>& tables) {
  auto list = nlohmann::ordered_json::array();
  for (const TableSum& table : tables) {
    list.push_back({{"table", table.table}, {"bytes", table.bytes}, {"sha256", table.sha256}});
  }
  return list;
}

std::string Sha256OfFile(const std::filesystem::path& file) { return Sha256Of(file); }

std::vector<InputFile> ListInputFiles(const std::filesystem::path& block,
                                      const AdjustTable& options) {
  std::vector<std::filesystem::path> files;
  if (std::filesystem::is_regular_file(block)) {
    files.push_back(block);
  } else {
    files.push_back(block / "block.toml");
    for (const char* table : {"trajectories", "observations", "points"}) {
      if (const auto found = FindTable(block, table)) files.push_back(*found);
    }
  }
  for (const std::string& list : {options.pairs_file, options.rejections_file}) {
    if (!list.empty()) files.push_back(FolderOf(block) / list);
  }
  std::vector<InputFile> out;
  for (const std::filesystem::path& file : files) {
    if (!std::filesystem::is_regular_file(file)) continue;
    out.push_back({file.filename().string(), std::filesystem::file_size(file), Sha256OfFile(file)});
  }
  return out;
}

namespace {

// A JSON value as a TOML value on one line: tables are inline, what is null is left out. Texts and
// numbers are written alike in both.
std::string TomlOf(const nlohmann::ordered_json& value) {
  std::string text;
  const auto append = [&text](const std::string& part) {
    text += (text.size() > 1 ? ", " : "") + part;
  };
  if (value.is_object()) {
    text = "{";
    for (const auto& [key, member] : value.items()) {
      if (!member.is_null()) append(nlohmann::ordered_json(key).dump() + " = " + TomlOf(member));
    }
    return text + "}";
  }
  if (value.is_array()) {
    text = "[";
    for (const auto& entry : value) append(TomlOf(entry));
    return text + "]";
  }
  return value.dump();
}

}  // namespace

std::vector<CorrectionGroup> CorrectionsOf(const ResultFile& result) {
  constexpr const char* kFile = "summary.json";
  std::vector<std::string> passes;
  for (const ResultPass& pass : result.passes) passes.push_back(pass.id);
  if (!result.summary.selected_model.empty()) {
    return ReadAdjustTable(result.summary.selected_model, kFile, passes).groups;
  }
  const JsonFile json(result.summary.json, kFile);
  const auto configuration = json.Root().Find("configuration");
  if (!configuration) return {};
  const auto chosen = configuration->Find("corrections");
  const auto correction = configuration->Find("correction");
  if (!chosen || chosen->Text() != "given" || !correction) return {};
  return ReadAdjustTable(
             "[adjust]\ncorrection = " + TomlOf(correction->Node()) + "\n", kFile, passes)
      .groups;
}

}  // namespace sarblock::files
