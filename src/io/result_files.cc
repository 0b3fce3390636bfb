// SPDX-License-Identifier: Apache-2.0
#include "sarblock/io/result_files.h"

#include "sarblock/core/error.h"
#include "sarblock/io/adjust_table.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "adjust_corrections.h"
#include "adjust_table.h"
#include "core/threads.h"
#include "diagnosis_section.h"
#include "path_writer.h"
#include "result_quality.h"
#include "result_realism.h"
#include "result_tables.h"
#include "run_origin.h"
#include "tables/open.h"
#include <nlohmann/json.hpp>

namespace sarblock {
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

Json FrameJson(const Frame& frame) {
  if (frame.kind() == FrameKind::kLocal) return {{"kind", "local"}};
  const Ellipsoid& ellipsoid = frame.ellipsoid();
  return {{"kind", "geocentric"},
          {"ellipsoid",
           {{"name", ellipsoid.name}, {"a_m", ellipsoid.a_m}, {"f", ellipsoid.flattening}}}};
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
    json["fit"] = {{"position", effect.fit->position_1},
                   {"position_freedom", effect.fit->position_freedom},
                   {"velocity", effect.fit->velocity_1},
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
    counts[std::string(NameOf(role)) + "_points"] =
        std::count(block.points.role.begin(), block.points.role.end(), role);
  }
  counts["point_status"] = Json::object();
  for (const PointStatus status : result.points.status) {
    Json& count = counts["point_status"][sarblock::NameOf(status)];
    count = count.is_null() ? 1 : count.get<int>() + 1;
  }
  return counts;
}

Json ChiSquare(const AdjustOptions& options, const AdjustResult& result) {
  if (std::isnan(result.sigma0_squared)) return nullptr;
  return {{"value", result.sigma0_squared * result.redundancy()},
          {"lower", result.chi_square.lower},
          {"upper", result.chi_square.upper},
          {"level", options.test_level},
          {"passed", result.chi_square_passed}};
}

Json Selection(const SelectionReport& selection) {
  Json kept = Json::array();
  for (const CandidateResult& candidate : selection.candidates) {
    if (candidate.kept)
      kept.push_back({{"candidate", candidate.name}, {"passes", candidate.passes}});
  }
  Json simplifications = Json::array();
  for (const SimplificationBound& bound : selection.simplifications) {
    simplifications.push_back({{"simplification", bound.name},
                               {"fraction", bound.fraction_1},
                               {"allowed", bound.allowed},
                               {"taken", bound.taken},
                               {"gain", bound.gain_1},
                               {"verdict", bound.verdict}});
  }
  return {{"candidates", selection.candidates.size()},
          {"rounds", selection.rounds},
          {"steps", selection.steps},
          {"settled", selection.settled},
          {"kept", kept},
          {"simplifications", simplifications},
          {"simplified_gain", selection.simplified_gain_1},
          {"simplified_shift", selection.simplified_shift_1},
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
                    const AdjustOptions& options,
                    const AdjustResult& result,
                    const ResultContext& context,
                    const std::vector<StageCost>& written) {
  Json summary;
  summary["format"] = "sarblock-result 1";
  summary["version"] = Version();
  summary["command"] = context.command;
  summary["block"] = block.name;
  summary["status"] = NameOf(result.status);
  summary["verdict"] = NameOf(result.assessment.verdict);
  summary["verdict_reasons"] = result.assessment.reasons;
  summary["accepted"] = result.accepted();
  summary["frame"] = FrameJson(block.frame);
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
  if (!result.checks.empty()) {
    summary["check_points"] = CheckPointsJson(result.assessment.checks, options.test_level);
  }
  if (!result.quality.empty()) summary["quality"] = QualityJson(block, options, result);
  if (result.snooping) summary["snooping"] = SnoopingJson(block, *result.snooping);
  if (result.variance_components) {
    summary["variance_components"] = VarianceComponentsSection(options, result);
  }
  if (result.montecarlo) summary["montecarlo"] = MonteCarloSection(*result.montecarlo);
  summary["covariance"] = NameOfChoice("covariance", options);
  summary["condition"] = result.condition;
  if (!result.selection.empty()) summary["selection"] = Selection(result.selection);
  if (context.diagnosis) summary["diagnosis"] = DiagnosisSection(*context.diagnosis);
  summary["stages"] = Stages({&context.stages, &result.stages, &written});
  summary["warnings"] = context.warnings;
  for (const std::string& warning : result.warnings) summary["warnings"].push_back(warning);
  summary["inputs"] = InputsJson(context.inputs);
  summary["configuration"] = ConfigurationJson(options);
  return summary.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

std::string SummaryJson(const Block& block,
                        const AdjustOptions& options,
                        const AdjustResult& result,
                        const ResultContext& context) {
  return Summary(block, options, result, context, {});
}

namespace {

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
  if (view.options.pairs != PairChoice::kNone) WritePairTable(sink, view);
  if (result.montecarlo) WriteMonteCarloTable(sink, view);
  const bool corrected = !result.corrected_paths.empty();
  WritePaths(sink, "trajectories", block, corrected ? result.corrected_paths : NominalPaths(block));
  const auto folder = sink->folder();
  if (block.frame.kind() != FrameKind::kGeocentric || !folder) return;
  WriteGeoJson(*folder / "points.geojson",
               {.frame = block.frame,
                .name = block.name,
                .ids = block.points.ids,
                .role = block.points.role,
                .points = result.points,
                .covariance_factor_1 = view.factor,
                .polygons = result.points.status.size() <= ellipse_limit});
}

}  // namespace

std::string WriteResult(const std::filesystem::path& target,
                        const Block& block,
                        const AdjustOptions& options,
                        const AdjustResult& result,
                        const ResultContext& context) {
  const ResultView view{block, options, result, CovarianceFactor(options, result)};
  ResultContext said = context;
  if (block.frame.kind() == FrameKind::kGeocentric && !NamesContainer(target) &&
      result.points.status.size() > context.ellipse_limit) {
    said.warnings.push_back(
        "points.geojson has the numbers of the error ellipses but not their "
        "polygons, there are more than " +
        std::to_string(context.ellipse_limit) + " points");
  }
  std::string summary;
  const IdTable passes = PassIds(block);
  const TextsOfTable pass_ids(passes), point_ids(block.points.ids);
  const BlockIds ids{&pass_ids, &point_ids};
  const auto write = [&](TableSink* sink) {
    std::vector<StageCost> written;
    {
      const StageTimer timer("write", &written);
      WriteResultTables(sink, view, context.ellipse_limit);
    }
    summary = Summary(block, options, result, said, written);
    sink->WriteText("summary.json", summary);
  };
  WriteTables(FolderContent::kResult, target, context.compression, ids, write);
  return summary;
}

}  // namespace sarblock
