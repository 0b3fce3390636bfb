// SPDX-License-Identifier: Apache-2.0
#include "sarblock/io/result_reader.h"

#include "sarblock/geodesy/ellipsoid.h"

#include "json_reader.h"
#include "number.h"
#include "result_table_reader.h"

namespace sarblock {
namespace {

constexpr const char* kResultFormat = "sarblock-result 1";
constexpr FolderKind kResult{
    "result", "summary.json, points.csv, passes.csv, residuals.csv and trajectories.csv"};

JsonValue RequireNewer(const JsonValue& summary, const char* name) {
  if (const auto value = summary.Find(name)) return *value;
  summary.Fail(std::string("has no ") + name +
               ": an earlier version of the program wrote it, a result computed anew has it");
}

Frame ReadResultFrame(const JsonValue& frame) {
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

void ReadResultPasses(const JsonValue& passes, ResultReading* reading) {
  for (const JsonValue& entry : passes.Entries()) {
    ResultPass pass;
    pass.id = entry.Require("id").Text();
    const auto index = static_cast<std::uint32_t>(reading->result.passes.size());
    if (pass.id.empty() || reading->pass_ids.FindOrAppend(pass.id) != index) {
      entry.Require("id").Fail(Quoted(pass.id) + " is empty or stands twice");
    }
    pass.side =
        entry.Require("look").OneOf({"left", "right"}) == 0 ? LookSide::kLeft : LookSide::kRight;
    if (const auto value = entry.Find("wavelength_m")) pass.wavelength_m = value->Number();
    pass.start_s = entry.Require("start_s").Number();
    pass.end_s = entry.Require("end_s").Number();
    if (!(pass.start_s < pass.end_s)) entry.Fail("start_s is not before end_s");
    if (const auto value = entry.Find("epoch_utc")) pass.epoch_utc = value->Text();
    reading->result.passes.push_back(std::move(pass));
  }
}

void ReadCounts(const JsonValue& counts, ResultSummary* summary) {
  summary->points = counts.Require("points").Count();
  summary->looks = counts.Require("looks").Count();
  summary->looks_used = counts.Require("looks_used").Count();
  summary->parameters = counts.Require("parameters").Count();
  summary->observations = counts.Require("observations").Count();
  summary->redundancy = counts.Require("redundancy").Number();
}

void ReadResultSummary(ResultReading* reading) {
  ResultFile& result = reading->result;
  ResultSummary& summary = result.summary;
  std::string file;
  std::tie(file, summary.json) = reading->source.Read("summary.json");
  const nlohmann::json parsed = ParseJson(summary.json, file);
  const JsonValue root(parsed, file, "");
  const JsonValue format = root.Require("format");
  if (format.Text() != kResultFormat) {
    format.Fail(Quoted(format.Text()) + " is not known, \"" + kResultFormat + "\" is allowed");
  }
  summary.version = root.Require("version").Text();
  summary.command = root.Require("command").Text();
  summary.block = root.Require("block").Text();
  summary.status = root.Require("status").Text();
  summary.accepted = root.Require("accepted").Flag();
  result.frame = ReadResultFrame(RequireNewer(root, "frame"));
  ReadResultPasses(RequireNewer(root, "passes"), reading);
  ReadCounts(root.Require("counts"), &summary);
  summary.iterations = root.Require("iterations").Count();
  summary.initial_cost = root.Require("initial_cost").Number();
  summary.final_cost = root.Require("final_cost").Number();
  summary.gradient = root.Require("gradient").Number();
  summary.sigma0_squared = root.Require("sigma0_squared").Number();
  summary.sigma_scaled_by_posterior = root.Require("sigma_scaled_by_posterior").Flag();
  if (const auto test = root.Find("chi_square")) {
    summary.chi_square = ResultTest{test->Require("value").Number(),
                                    test->Require("lower").Number(),
                                    test->Require("upper").Number(),
                                    test->Require("level").Number(),
                                    test->Require("passed").Flag()};
  }
  summary.covariance = root.Require("covariance").Text();
  summary.condition = root.Require("condition").Number();
  for (const auto& [name, stage] : root.Require("stages").Members()) {
    summary.stages.push_back(
        {name, stage.Require("wall_s").Number(), stage.Require("peak_mib").Number()});
  }
  for (const JsonValue& warning : root.Require("warnings").Entries()) {
    summary.warnings.push_back(warning.Text());
  }
}

ResultFile ReadResultFrom(const TableSource& source, const ReadResultOptions& options) {
  ResultReading reading{source, options, {}, {}};
  ReadResultSummary(&reading);
  ReadResultPoints(&reading);
  ReadResultParameters(&reading);
  if (options.paths) ReadResultPaths(&reading);
  if (options.looks) ReadResultLooks(&reading);
  ReadResultControl(&reading);
  if (options.pairs) ReadResultPairs(&reading);
  reading.result.points.ids.DropIndex();
  return std::move(reading.result);
}

}  // namespace

ResultFile ReadResult(const std::filesystem::path& folder, const ReadResultOptions& options) {
  return ReadResultFrom(*TablesOfFolder(folder, kResult), options);
}

ResultFile ReadResultTexts(const ResultTexts& texts, const ReadResultOptions& options) {
  return ReadResultFrom(*TablesOfTexts({{"summary.json", texts.summary_json},
                                        {"points.csv", texts.points_csv},
                                        {"passes.csv", texts.passes_csv},
                                        {"residuals.csv", texts.residuals_csv},
                                        {"trajectories.csv", texts.trajectories_csv},
                                        {"passes_covariance.csv", texts.passes_covariance_csv},
                                        {"control_quality.csv", texts.control_quality_csv},
                                        {"pairs.csv", texts.pairs_csv}},
                                       kResult),
                        options);
}

}  // namespace sarblock
