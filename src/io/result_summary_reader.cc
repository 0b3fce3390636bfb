// SPDX-License-Identifier: Apache-2.0
#include "result_summary_reader.h"

#include <array>
#include <limits>
#include <tuple>

#include "core/text.h"
#include "tables/json.h"

namespace sarblock {
namespace {

constexpr const char* kResultFormat = "sarblock-result 1";

JsonValue RequireNewer(const JsonValue& summary, const char* name) {
  if (const auto value = summary.Find(name)) return *value;
  summary.Fail(std::string("has no ") + name +
               ": an earlier version of the program wrote it, a result computed anew has it");
}

// Members of a section that it may lack: NaN, 0, empty, false.
double NumberIn(const JsonValue& section, const char* name) {
  const auto value = section.Find(name);
  return value ? value->Number() : kNotGiven;
}
std::size_t CountIn(const JsonValue& section, const char* name) {
  const auto value = section.Find(name);
  return value ? value->Count() : 0;
}
std::string TextIn(const JsonValue& section, const char* name) {
  const auto value = section.Find(name);
  return value ? value->Text() : "";
}
bool FlagIn(const JsonValue& section, const char* name) {
  const auto value = section.Find(name);
  return value && value->Flag();
}
std::vector<JsonValue> EntriesIn(const JsonValue& section, const char* name) {
  const auto value = section.Find(name);
  return value ? value->Entries() : std::vector<JsonValue>();
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

void ReadPasses(const JsonValue& passes, ResultReading* reading) {
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

void ReadCounts(const JsonValue& counts, ResultReading* reading) {
  for (const auto& [name, value] : counts.Members()) {
    if (name != "point_status") reading->result.summary.counts.emplace_back(name, value.Number());
  }
  reading->points = counts.Require("points").Count();
  reading->looks = counts.Require("looks").Count();
}

ResultTest ReadTest(const JsonValue& test) {
  return {kNotGiven,
          kNotGiven,
          test.Require("lower").Number(),
          test.Require("upper").Number(),
          test.Require("level").Number(),
          test.Require("passed").Flag()};
}

ResultTests ReadTests(const JsonValue& quality) {
  ResultTests tests{NumberIn(quality, "alpha_one"),
                    NumberIn(quality, "power"),
                    NumberIn(quality, "critical_w"),
                    NumberIn(quality, "expected_above"),
                    CountIn(quality, "tests"),
                    CountIn(quality, "looks_not_localisable")};
  if (const auto above = quality.Find("above_critical")) {
    tests.above = {
        CountIn(*above, "range"), CountIn(*above, "azimuth"), CountIn(*above, "control")};
  }
  return tests;
}

ResultFinding ReadFinding(const JsonValue& entry) {
  ResultFinding finding{CountIn(entry, "round"),
                        TextIn(entry, "point"),
                        "",
                        TextIn(entry, "component"),
                        TextIn(entry, "action"),
                        TextIn(entry, "note"),
                        NumberIn(entry, "w"),
                        FlagIn(entry, "located")};
  const auto add = [&](const std::string& name) {
    finding.passes += (finding.passes.empty() ? "" : ", ") + name;
  };
  for (const JsonValue& pass : EntriesIn(entry, "passes")) add(pass.Text());
  if (FlagIn(entry, "control")) add("control");
  return finding;
}

void ReadVariances(const JsonValue& section, ResultSummary* summary) {
  if (const auto before = section.Find("before")) {
    summary->test_before = ReadTest(*before);
    summary->test_before->sigma0_squared = NumberIn(*before, "sigma0_squared");
    summary->test_before->redundancy = NumberIn(*before, "redundancy");
  }
  for (const JsonValue& entry : EntriesIn(section, "components")) {
    summary->variances.push_back({TextIn(entry, "group"),
                                  TextIn(entry, "component"),
                                  TextIn(entry, "unit"),
                                  TextIn(entry, "note"),
                                  FlagIn(entry, "estimated"),
                                  CountIn(entry, "looks"),
                                  NumberIn(entry, "redundancy"),
                                  NumberIn(entry, "factor"),
                                  NumberIn(entry, "factor_sigma"),
                                  NumberIn(entry, "sigma_before"),
                                  NumberIn(entry, "sigma_after"),
                                  NumberIn(entry, "sigma_after_sigma")});
  }
}

ResultRepetition ReadRepetition(const JsonValue& section) {
  ResultRepetition repetition{
      CountIn(section, "runs"), CountIn(section, "seed"), TextIn(section, "verdict"), {}};
  for (const char* name : {"normalised_square",
                           "variance_ratio_e",
                           "variance_ratio_n",
                           "variance_ratio_u",
                           "coverage_50",
                           "coverage_90",
                           "coverage_99"}) {
    const auto figure = section.Find(name);
    if (!figure) continue;
    repetition.figures.push_back({name,
                                  NumberIn(*figure, "expected"),
                                  NumberIn(*figure, "mean"),
                                  NumberIn(*figure, "lower"),
                                  NumberIn(*figure, "upper"),
                                  FlagIn(*figure, "agrees")});
  }
  return repetition;
}

void ReadSections(const JsonValue& root, ResultSummary* summary) {
  if (const auto test = root.Find("chi_square")) {
    summary->chi_square = ReadTest(*test);
    summary->chi_square->sigma0_squared = summary->sigma0_squared;
    summary->chi_square->redundancy = summary->Count("redundancy");
  }
  if (const auto checks = root.Find("check_points")) {
    summary->checks = {CountIn(*checks, "points"),
                       CountIn(*checks, "components"),
                       NumberIn(*checks, "error_ratio"),
                       FlagIn(*checks, "realistic"),
                       TextIn(*checks, "says")};
  }
  if (const auto quality = root.Find("quality")) summary->tests = ReadTests(*quality);
  if (const auto snooping = root.Find("snooping")) {
    summary->snooping_rounds = CountIn(*snooping, "rounds");
    for (const JsonValue& entry : EntriesIn(*snooping, "findings")) {
      summary->findings.push_back(ReadFinding(entry));
    }
  }
  if (const auto section = root.Find("variance_components")) ReadVariances(*section, summary);
  if (const auto section = root.Find("montecarlo")) summary->repetition = ReadRepetition(*section);
  if (const auto selection = root.Find("selection")) {
    summary->selected_model = TextIn(*selection, "model");
    summary->selection_settled = FlagIn(*selection, "settled");
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

void ReadResultSummary(ResultReading* reading) {
  ResultFile& result = reading->result;
  ResultSummary& summary = result.summary;
  std::string file;
  std::tie(file, summary.json) = reading->source.Read("summary.json");
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
  result.frame = ReadFrame(RequireNewer(root, "frame"));
  ReadPasses(RequireNewer(root, "passes"), reading);
  ReadCounts(root.Require("counts"), reading);
  summary.iterations = root.Require("iterations").Count();
  summary.initial_cost = root.Require("initial_cost").Number();
  summary.final_cost = root.Require("final_cost").Number();
  summary.gradient = root.Require("gradient").Number();
  summary.remaining_step = NumberIn(root, "remaining_step");
  summary.sigma0_squared = root.Require("sigma0_squared").Number();
  summary.sigma_scaled_by_posterior = root.Require("sigma_scaled_by_posterior").Flag();
  ReadSections(root, &summary);
  summary.covariance = root.Require("covariance").Text();
  summary.condition = root.Require("condition").Number();
  for (const auto& [name, stage] : root.Require("stages").Members()) {
    summary.stages.push_back(
        {name, stage.Require("wall_s").Number(), stage.Require("peak_mib").Number()});
  }
  for (const JsonValue& warning : root.Require("warnings").Entries()) {
    summary.warnings.push_back(warning.Text());
  }
  for (const JsonValue& input : EntriesIn(root, "inputs")) {
    summary.inputs.push_back(
        {TextIn(input, "file"), CountIn(input, "bytes"), TextIn(input, "sha256")});
  }
  if (const auto configuration = root.Find("configuration")) {
    Flatten(*configuration, "", &summary);
  }
}

}  // namespace sarblock
