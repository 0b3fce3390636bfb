// SPDX-License-Identifier: Apache-2.0
#include "sarblock/files/result.h"

#include "sarblock/core/error.h"
#include "sarblock/core/id_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "block_reader.h"
#include "core/text.h"
#include "geojson.h"
#include "result_tables.h"
#include "tables/json.h"
#include "tables/open.h"
#include "tables/table.h"
#include "tables/toml.h"

namespace sarblock {

/// What the readers of the single files of a result share.
struct ResultReading {
  const TableSource& source;
  const ReadResultOptions& options;
  ResultFile result;
  IdTable pass_ids;
  std::size_t points, looks;  ///< that the summary counts
};

void ReadResultPoints(ResultReading* reading);
void ReadResultParameters(ResultReading* reading);
void ReadResultLooks(ResultReading* reading);
void ReadResultControl(ResultReading* reading);
void ReadResultPairs(ResultReading* reading);
void ReadResultStrips(ResultReading* reading);
/// selection.csv and simplifications.csv.
void ReadResultSelection(ResultReading* reading);
void ReadResultPaths(ResultReading* reading);

/// summary.json: the summary, the frame and the passes. The others need it to have been read.
void ReadResultSummary(ResultReading* reading);

namespace {

ResultFile ReadResultFrom(const TableSource& source, const ReadResultOptions& options) {
  ResultReading reading{source, options, {}, {}, 0, 0};
  ReadResultSummary(&reading);
  ReadResultPoints(&reading);
  ReadResultParameters(&reading);
  if (options.paths) ReadResultPaths(&reading);
  if (options.looks) ReadResultLooks(&reading);
  ReadResultControl(&reading);
  if (options.pairs) ReadResultPairs(&reading);
  ReadResultStrips(&reading);
  ReadResultSelection(&reading);
  reading.result.points.ids.DropIndex();
  return std::move(reading.result);
}

}  // namespace

ResultFile ReadResult(const std::filesystem::path& folder, const ReadResultOptions& options) {
  return ReadResultFrom(*TablesAt(folder, FolderContent::kResult), options);
}

ResultFile ReadResultTexts(const ResultTexts& texts, const ReadResultOptions& options) {
  return ReadResultFrom(*TablesOfTexts({{"summary.json", texts.summary_json},
                                        {"points.csv", texts.points_csv},
                                        {"passes.csv", texts.passes_csv},
                                        {"residuals.csv", texts.residuals_csv},
                                        {"trajectories.csv", texts.trajectories_csv},
                                        {"passes_covariance.csv", texts.passes_covariance_csv},
                                        {"control_quality.csv", texts.control_quality_csv},
                                        {"pairs.csv", texts.pairs_csv},
                                        {"strips.csv", texts.strips_csv},
                                        {"selection.csv", texts.selection_csv},
                                        {"simplifications.csv", texts.simplifications_csv}},
                                       FolderContent::kResult),
                        options);
}

namespace {

constexpr const char* kPointsFile = "points.csv";
constexpr const char* kSummaryFile = "summary.json";

// One of the names of an enumeration's values, whose last is `last`.
template <typename Enum>
Enum ReadEnum(const TableReader& reader, std::size_t column, Enum last) {
  const auto find = [&]() -> std::uint32_t {
    const std::string_view text = reader.Text(column);
    std::vector<std::string> names;
    for (int i = 0; i <= static_cast<int>(last); ++i) {
      const auto value = static_cast<Enum>(i);
      if (text == NameOf(value)) return static_cast<std::uint32_t>(i);
      if (*NameOf(value) != '\0') names.emplace_back(NameOf(value));
    }
    reader.Fail(column, Quoted(text) + " is not known, " + Listed(names) + " is allowed");
  };
  return static_cast<Enum>(reader.Lookup(column, find));
}

double ReadSigma(const TableReader& reader, std::size_t column) {
  const double value = reader.Number(column);
  if (value < 0.0) reader.Fail(column, NumberText(value) + " is not allowed, 0 or more is");
  return value;
}

// A column of which no row gave a value was not computed.
template <typename Values>
void DropIfEmpty(Values* values) {
  const auto given = [](auto value) { return !std::isnan(value); };
  if (std::none_of(values->begin(), values->end(), given)) Values().swap(*values);
}

enum PointColumn : std::size_t {
  kPoint,
  kRole,
  kStatus,
  kLooks,
  kX,
  kY,
  kZ,
  kLatitudeOf,
  kLongitudeOf,
  kHeightAbove,
  kSigmaE,
  kSigmaN,
  kSigmaU,
  kCovEN,
  kCovEU,
  kCovNU,
  kIntersection,
  kLeberlAcross,
  kLeberlUp,
  kLeberlPathAcross,
  kLeberlPathUp,
  kLeberlAzimuth,
  kRedundancy,
  kErrorE,
  kErrorN,
  kErrorU,
  kChiSquare,
  kErrorSigmaE,
  kErrorSigmaN,
  kErrorSigmaU,
  kFixedPathE,
  kFixedPathN,
  kFixedPathU,
  kFixedPathEN,
  kReason
};

SymmetricEnu ReadCovariance(const TableReader& reader) {
  SymmetricEnu covariance_m2;
  int given = 0;
  for (std::size_t k = 0; k < 6; ++k) {
    const double value = k < 3 ? ReadSigma(reader, kSigmaE + k) : reader.Number(kSigmaE + k);
    covariance_m2[k] = k < 3 ? value * value : value;
    given += std::isnan(value) ? 0 : 1;
  }
  if (given != 0 && given != 6) {
    reader.Fail(kSigmaE, "all six figures of the covariance are needed or none");
  }
  return covariance_m2;
}

/// The table has no covariances of up.
SymmetricEnu ReadFixedPathCovariance(const TableReader& reader) {
  SymmetricEnu covariance_m2;
  covariance_m2.fill(kNotGiven);
  for (std::size_t k = 0; k < 3; ++k) {
    const double sigma_m = ReadSigma(reader, kFixedPathE + k);
    covariance_m2[k] = sigma_m * sigma_m;
  }
  covariance_m2[3] = reader.Number(kFixedPathEN);
  return covariance_m2;
}

/// Empty where no point has a covariance.
void DropIfUnknown(std::vector<SymmetricEnu>* covariances_m2) {
  const auto known = [](const SymmetricEnu& c) { return !std::isnan(c[0]); };
  if (std::none_of(covariances_m2->begin(), covariances_m2->end(), known)) covariances_m2->clear();
}

void ReadCheck(const TableReader& reader, std::uint32_t point, std::vector<CheckResult>* checks) {
  CheckResult check;
  check.point = point;
  for (std::size_t k = 0; k < 3; ++k) {
    const double error_m = reader.Number(kErrorE + k);
    check.error_enu_m[static_cast<Eigen::Index>(k)] = error_m;
    check.sigma_enu_m[static_cast<Eigen::Index>(k)] = ReadSigma(reader, kErrorSigmaE + k);
    check.components += std::isnan(error_m) ? 0 : 1;
  }
  if (check.components == 0) return;
  check.chi_square = reader.Number(kChiSquare);
  checks->push_back(check);
}

}  // namespace

void ReadResultPoints(ResultReading* reading) {
  const auto opened = reading->source.Require("points", kResultPointColumns);
  TableReader& reader = *opened;
  ResultPoints& points = reading->result.points;
  PointResults& results = points.results;
  bool reasons = false;
  while (reader.Next()) {
    const auto index = static_cast<std::uint32_t>(points.size());
    const auto find = [&] { return points.ids.FindOrAppend(reader.Id(kPoint)); };
    if (reader.Lookup(kPoint, find) != index) {
      reader.Fail(kPoint,
                  Quoted(reader.Text(kPoint)) + " stands twice, one row a point is allowed");
    }
    points.role.push_back(ReadRole(reader, kRole));
    results.status.push_back(ReadEnum(reader, kStatus, PointStatus::kUndetermined));
    results.looks.push_back(reader.Count(kLooks));
    const Eigen::Vector3d position_m(reader.Number(kX), reader.Number(kY), reader.Number(kZ));
    if (IsSolved(results.status.back()) && !position_m.allFinite()) {
      reader.Fail(kX, "is empty, a solved point has x_m, y_m and z_m");
    }
    results.position_m.push_back(position_m);
    results.covariance_m2.push_back(ReadCovariance(reader));
    results.fixed_path_covariance_m2.push_back(ReadFixedPathCovariance(reader));
    results.intersection_rad.push_back(reader.Number(kIntersection) * kRadPerDeg);
    results.sigma_leberl_across_m.push_back(reader.Number(kLeberlAcross));
    results.sigma_leberl_up_m.push_back(reader.Number(kLeberlUp));
    results.sigma_leberl_path_across_m.push_back(reader.Number(kLeberlPathAcross));
    results.sigma_leberl_path_up_m.push_back(reader.Number(kLeberlPathUp));
    results.leberl_across_azimuth_rad.push_back(reader.Number(kLeberlAzimuth) * kRadPerDeg);
    results.redundancy.push_back(reader.Number(kRedundancy));
    ReadCheck(reader, index, &points.checks);
    results.reason.emplace_back(reader.Text(kReason));
    reasons = reasons || reader.Given(kReason);
    if (index % 65536 == 65535) Step(reading->options.progress, "read", index, 0, "points");
  }
  if (points.size() != reading->points) {
    throw InputError(FilePlace{reader.file(), 0, ""},
                     "has " + std::to_string(points.size()) + " points where summary.json counts " +
                         std::to_string(reading->points) + ": files of two results");
  }
  if (!reasons) results.reason.clear();
  DropIfUnknown(&results.covariance_m2);
  DropIfUnknown(&results.fixed_path_covariance_m2);
  for (auto* column : {&results.intersection_rad,
                       &results.sigma_leberl_across_m,
                       &results.sigma_leberl_up_m,
                       &results.sigma_leberl_path_across_m,
                       &results.sigma_leberl_path_up_m,
                       &results.leberl_across_azimuth_rad,
                       &results.redundancy}) {
    DropIfEmpty(column);
  }
}

namespace {

// The name of a parameter in passes.csv: pass or shared group, and parameter.
std::pair<std::string, std::string> NameOfParameter(const TableReader& reader, std::size_t first) {
  return {std::string(reader.Id(first)), std::string(reader.Id(first + 1))};
}

}  // namespace

void ReadResultParameters(ResultReading* reading) {
  const auto opened = reading->source.Require("passes", kParameterColumns);
  TableReader& reader = *opened;
  std::vector<ParameterResult>& parameters = reading->result.parameters;
  std::map<std::pair<std::string, std::string>, std::uint32_t> index;
  while (reader.Next()) {
    const auto name = NameOfParameter(reader, 0);
    if (!index.emplace(name, static_cast<std::uint32_t>(parameters.size())).second) {
      reader.Fail(1, Quoted(name.second) + " of " + Quoted(name.first) + " stands twice");
    }
    parameters.push_back({name.first,
                          name.second,
                          std::string(reader.Text(2)),
                          reader.RequiredNumber(3),
                          ReadSigma(reader, 4),
                          ReadSigma(reader, 5),
                          std::string(reader.Text(7))});
  }
  auto covariance = reading->source.Open("passes_covariance", kParameterCovarianceColumns);
  const auto find = [&](std::size_t first) {
    const auto name = NameOfParameter(*covariance, first);
    const auto found = index.find(name);
    if (found == index.end()) {
      covariance->Fail(
          first + 1,
          "passes.csv has no parameter " + Quoted(name.second) + " of " + Quoted(name.first));
    }
    return found->second;
  };
  while (covariance && covariance->Next()) {
    reading->result.parameter_covariance.push_back(
        {find(0), find(2), covariance->RequiredNumber(4)});
  }
}

namespace {

enum LookColumn : std::size_t {
  kLookPass,
  kLookPoint,
  kRangeResidual,
  kAzimuthResidual,
  kQuality,  // redundancy, w, tau, mdb, influence, each of range and of azimuth
  kWeight = kQuality + 10,
  kRejected,
  kLookReason,
  kFinding,
  kImage  // line, pixel, line residual, pixel residual
};

// As float; a number that a float cannot hold is refused.
float ReadFloat(const TableReader& reader, std::size_t column) {
  const double value = reader.Number(column);
  if (std::abs(value) > static_cast<double>(std::numeric_limits<float>::max())) {
    reader.Fail(column, NumberText(value) + " is too large");
  }
  return static_cast<float>(value);
}

}  // namespace

void ReadResultLooks(ResultReading* reading) {
  const auto opened = reading->source.Require("residuals", kResidualColumns);
  TableReader& reader = *opened;
  ResultLooks& looks = reading->result.looks;
  const std::array<std::array<std::vector<float>, 2>*, 5> quality{
      &looks.redundancy_1, &looks.w_1, &looks.tau_1, &looks.mdb_m, &looks.influence_m};
  const std::array<std::vector<double>*, 4> image{
      &looks.line_px, &looks.pixel_px, &looks.line_residual_px, &looks.pixel_residual_px};
  while (reader.Next()) {
    const std::size_t row = looks.size();
    looks.pass.push_back(FindPass(reader, kLookPass, reading->pass_ids, kSummaryFile));
    looks.point.push_back(FindPoint(reader, kLookPoint, reading->result.points.ids, kPointsFile));
    looks.range_residual_m.push_back(reader.Number(kRangeResidual));
    looks.azimuth_residual_m.push_back(reader.Number(kAzimuthResidual));
    for (std::size_t i = 0; i < 10; ++i) {
      (*quality[i / 2])[i % 2].push_back(ReadFloat(reader, kQuality + i));
    }
    looks.weight.push_back(reader.Given(kWeight) ? ReadFloat(reader, kWeight) : 1.0f);
    looks.rejected.push_back(reader.Flag(kRejected) ? 1 : 0);
    looks.reason.push_back(ReadEnum(reader, kLookReason, RejectReason::kSuspect));
    looks.finding.push_back(reader.Count(kFinding));
    for (std::size_t i = 0; i < 4; ++i) image[i]->push_back(reader.Number(kImage + i));
    if (row % 65536 == 65535) Step(reading->options.progress, "read", row, 0, "looks");
  }
  if (looks.size() != reading->looks) {
    throw InputError(FilePlace{reader.file(), 0, ""},
                     "has " + std::to_string(looks.size()) + " looks where summary.json counts " +
                         std::to_string(reading->looks) + ": files of two results");
  }
  for (auto* figures : quality) {
    for (std::vector<float>& component : *figures) DropIfEmpty(&component);
  }
  for (auto* column : image) DropIfEmpty(column);
}

void ReadResultControl(ResultReading* reading) {
  auto reader = reading->source.Open("control_quality", kControlColumns);
  while (reader && reader->Next()) {
    ResultControl control;
    control.point = FindPoint(*reader, 0, reading->result.points.ids, kPointsFile);
    constexpr std::string_view kComponents = "enu";
    const std::string_view component = reader->Text(1);
    const std::size_t found =
        component.size() == 1 ? kComponents.find(component) : kComponents.npos;
    if (found == kComponents.npos) {
      reader->Fail(1, Quoted(component) + " is not known, e, n or u is allowed");
    }
    control.component = static_cast<int>(found);
    control.residual_m = reader->RequiredNumber(2);
    control.sigma_m = reader->Number(3);
    control.redundancy_1 = reader->Number(4);
    control.w_1 = reader->Number(5);
    control.tau_1 = reader->Number(6);
    control.mdb_m = reader->Number(7);
    control.influence_m = reader->Number(8);
    reading->result.control.push_back(control);
  }
}

void ReadResultPairs(ResultReading* reading) {
  auto reader = reading->source.Open("pairs", kPairColumns);
  while (reader && reader->Next()) {
    PairResult pair;
    pair.a = FindPoint(*reader, 0, reading->result.points.ids, kPointsFile);
    pair.b = FindPoint(*reader, 1, reading->result.points.ids, kPointsFile);
    for (std::size_t k = 0; k < 3; ++k) {
      pair.difference_enu_m[static_cast<Eigen::Index>(k)] = reader->Number(2 + k);
    }
    for (std::size_t k = 0; k < 6; ++k) pair.covariance_m2[k] = reader->Number(5 + k);
    pair.sigma_leberl_across_m = reader->Number(11);
    pair.sigma_leberl_up_m = reader->Number(12);
    pair.sigma_leberl_path_across_m = reader->Number(13);
    pair.sigma_leberl_path_up_m = reader->Number(14);
    reading->result.pairs.push_back(pair);
  }
}

void ReadResultStrips(ResultReading* reading) {
  auto reader = reading->source.Open("strips", kStripColumns);
  const auto triple = [&](std::size_t first) {
    return Eigen::Vector3d(
        reader->Number(first), reader->Number(first + 1), reader->Number(first + 2));
  };
  std::vector<StripStation>& strips = reading->result.strips;
  while (reader && reader->Next()) {
    StripStation station{FindPass(*reader, 0, reading->pass_ids, kSummaryFile),
                         reader->RequiredNumber(2),
                         reader->RequiredNumber(3),
                         triple(4),
                         triple(7),
                         triple(10),
                         triple(13),
                         triple(16)};
    if (!strips.empty() && station.pass < strips.back().pass) {
      reader->Fail(0, Quoted(reader->Text(0)) + " is not in the order of summary.json");
    }
    if (!station.antenna_m.allFinite()) reader->Fail(4, "is empty, a station has a position");
    strips.push_back(station);
  }
}

void ReadResultSelection(ResultReading* reading) {
  auto reader = reading->source.Open("selection", kSelectionColumns);
  while (reader && reader->Next()) {
    CandidateResult candidate;
    candidate.name = reader->Id(0);
    candidate.passes = reader->Text(1);
    candidate.parameters = static_cast<int>(reader->Count(2));
    candidate.test = ReadEnum(*reader, 3, SelectionTest::kNotTried);
    candidate.statistic_1 = reader->Number(4);
    candidate.f_1 = reader->Number(5);
    candidate.probability_1 = reader->Number(6);
    candidate.delta_bic_1 = reader->Number(7);
    candidate.condition_1 = reader->Number(8);
    candidate.posterior_prior_1 = reader->Number(9);
    candidate.kept = reader->Text(10) == "kept";
    if (!candidate.kept && reader->Text(10) != "dropped") {
      reader->Fail(10, Quoted(reader->Text(10)) + " is not known, kept or dropped is allowed");
    }
    candidate.reason = reader->Text(11);
    reading->result.candidates.push_back(std::move(candidate));
  }
  auto bounds = reading->source.Open("simplifications", kSimplificationColumns);
  while (bounds && bounds->Next()) {
    reading->result.simplifications.push_back({std::string(bounds->Id(0)),
                                               bounds->Number(1),
                                               bounds->Number(2),
                                               bounds->Number(3),
                                               bounds->Count(4) != 0,
                                               bounds->Count(5) != 0,
                                               kNotGiven,
                                               std::string(bounds->Text(6))});
  }
}

void ReadResultPaths(ResultReading* reading) {
  const auto reader = reading->source.Require("trajectories", kPathColumns);
  PathTable table = ReadPaths(reader.get(), reading->pass_ids, kSummaryFile);
  for (std::size_t i = 0; i < table.states.size(); ++i) {
    if (table.states[i].size() < 2) {
      throw InputError(reader->PlaceAt(table.lines[i], 0),
                       "pass " + Quoted(reading->pass_ids[i]) +
                           " has fewer than two states, two or more are needed");
    }
    reading->result.passes[i].path = FlightPath(std::move(table.states[i]));
  }
}

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
