// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/core/id_table.h"
#include "sarblock/files/result.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "block_file.h"
#include "core/text.h"
#include "core/threads.h"
#include "result_tables.h"
#include "summary.h"
#include "tables/checksum.h"
#include "tables/open.h"
#include "tables/table.h"

namespace sarblock::files {

/// What the readers of the single files of a result share.
struct ResultReading {
  const TableSource& source;
  const ReadResultOptions& options;
  ResultFile result;
  IdTable pass_ids;
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

namespace {

ResultFile ReadResultFrom(const TableSource& source, const ReadResultOptions& options) {
  ResultReading reading{source, options, {}, {}};
  ReadSummary(source, &reading.result);
  for (const ResultPass& pass : reading.result.passes) reading.pass_ids.FindOrAppend(pass.id);
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
  const CancellationScope scope(options.progress);
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
Enum ReadEnum(const Row& row, std::size_t column, Enum last) {
  const std::string_view text = row.Text(column);
  for (int i = 0; i <= static_cast<int>(last); ++i) {
    if (text == NameOf(static_cast<Enum>(i))) return static_cast<Enum>(i);
  }
  std::vector<std::string> names;
  for (int i = 0; i <= static_cast<int>(last); ++i) {
    const char* const name = NameOf(static_cast<Enum>(i));
    if (*name != '\0') names.emplace_back(name);
  }
  row.Fail(column, Quoted(text) + " is not known, " + Listed(names) + " is allowed");
}

double ReadSigma(const Row& row, std::size_t column) {
  const double value = row.Number(column);
  if (value < 0.0) row.Fail(column, "must be 0 or more, got " + NumberText(value));
  return value;
}

// A column of which no row gave a value was not computed.
template <typename Values>
void DropIfEmpty(Values* values) {
  const auto given = [](auto value) { return !std::isnan(value); };
  if (std::none_of(values->begin(), values->end(), given)) Values().swap(*values);
}

SymmetricEnu ReadCovariance(const Row& row) {
  SymmetricEnu covariance_m2;
  std::size_t k = 0;
  for (const std::size_t column : kResultPointColumns("sigma_e_m", "sigma_n_m", "sigma_u_m")) {
    const double sigma_m = ReadSigma(row, column);
    covariance_m2[k++] = sigma_m * sigma_m;
  }
  for (const std::size_t column : kResultPointColumns("cov_en_m2", "cov_eu_m2", "cov_nu_m2")) {
    covariance_m2[k++] = row.Number(column);
  }
  const auto given = std::count_if(
      covariance_m2.begin(), covariance_m2.end(), [](double value) { return !std::isnan(value); });
  if (given != 0 && given != 6) {
    row.Fail(kResultPointColumns("sigma_e_m"),
             "all six figures of the covariance are needed or none");
  }
  return covariance_m2;
}

/// The table has no covariances of up.
SymmetricEnu ReadFixedPathCovariance(const Row& row) {
  SymmetricEnu covariance_m2;
  covariance_m2.fill(kNotGiven);
  std::size_t k = 0;
  for (const std::size_t column :
       kResultPointColumns("sigma_held_e_m", "sigma_held_n_m", "sigma_held_u_m")) {
    const double sigma_m = ReadSigma(row, column);
    covariance_m2[k++] = sigma_m * sigma_m;
  }
  covariance_m2[3] = row.Number(kResultPointColumns("cov_held_en_m2"));
  return covariance_m2;
}

/// Empty where no point has a covariance.
void DropIfUnknown(std::vector<SymmetricEnu>* covariances_m2) {
  const auto known = [](const SymmetricEnu& c) { return !std::isnan(c[0]); };
  if (std::none_of(covariances_m2->begin(), covariances_m2->end(), known)) covariances_m2->clear();
}

void ReadCheck(const Row& row, std::uint32_t point, std::vector<CheckResult>* checks) {
  constexpr const auto& kColumns = kResultPointColumns;
  constexpr std::array kErrors = kColumns("error_e_m", "error_n_m", "error_u_m");
  constexpr std::array kSigmas = kColumns("error_sigma_e_m", "error_sigma_n_m", "error_sigma_u_m");
  CheckResult check;
  check.point = point;
  for (std::size_t k = 0; k < 3; ++k) {
    const double error_m = row.Number(kErrors[k]);
    check.error_enu_m[static_cast<Eigen::Index>(k)] = error_m;
    check.sigma_enu_m[static_cast<Eigen::Index>(k)] = ReadSigma(row, kSigmas[k]);
    check.components += std::isnan(error_m) ? 0 : 1;
  }
  if (check.components == 0) return;
  check.chi_square = row.Number(kColumns("chi_square_3"));
  checks->push_back(check);
}

void ReadPointRow(const Row& row, ResultPoints* points) {
  constexpr const auto& kColumns = kResultPointColumns;
  PointResults& results = points->results;
  const std::uint32_t index = AddId(row, kColumns("point"), &points->ids);
  points->role.push_back(ReadRole(row, kColumns("role")));
  results.status.push_back(ReadEnum(row, kColumns("status"), PointStatus::kUndetermined));
  results.looks.push_back(row.Count(kColumns("looks")));
  const Eigen::Vector3d position_m(row.Numbers(kColumns("x_m", "y_m", "z_m")).data());
  if (IsSolved(results.status.back()) && !position_m.allFinite()) {
    row.Fail(kColumns("x_m"), "is empty, a solved point has x_m, y_m and z_m");
  }
  results.position_m.push_back(position_m);
  results.covariance_m2.push_back(ReadCovariance(row));
  results.fixed_path_covariance_m2.push_back(ReadFixedPathCovariance(row));
  for (const auto& figure : kPointFigures) {
    (results.*figure.member).push_back(row.Number(figure.column) * figure.read);
  }
  ReadCheck(row, index, &points->checks);
  results.reason.emplace_back(row.Text(kColumns("reason")));
}

/// Progress by rows that are read.
void StepRows(const ResultReading& reading, std::size_t rows, const char* what) {
  if (rows % 65536 == 0) Step(reading.options.progress, "read", rows, 0, what);
}

/// Refuses a table that has another number of rows than the summary counts, as a number: it may be
/// any.
void RequireCounted(const ResultReading& reading,
                    const std::string& file,
                    const std::string& name,
                    std::size_t rows) {
  const double counted = reading.result.summary.Count(name);
  if (static_cast<double>(rows) == counted) return;
  throw InputError(FilePlace{file, 0, ""},
                   "has " + std::to_string(rows) + " " + name + " where summary.json counts " +
                       NumberText(counted) + ": files of two results");
}

}  // namespace

void ReadResultPoints(ResultReading* reading) {
  const auto table = reading->source.Require("points", kResultPointColumns);
  ResultPoints& points = reading->result.points;
  PointResults& results = points.results;
  ForRows(table.get(), [&](const Row& row) {
    ReadPointRow(row, &points);
    StepRows(*reading, points.size(), "points");
  });
  RequireCounted(*reading, table->file(), "points", points.size());
  const auto empty = [](const std::string& reason) { return reason.empty(); };
  if (std::all_of(results.reason.begin(), results.reason.end(), empty)) results.reason.clear();
  DropIfUnknown(&results.covariance_m2);
  DropIfUnknown(&results.fixed_path_covariance_m2);
  for (const auto& figure : kPointFigures) DropIfEmpty(&(results.*figure.member));
}

namespace {

/// The name of a parameter in passes.csv: pass or shared group, and parameter.
using ParameterName = std::pair<std::string, std::string>;

}  // namespace

void ReadResultParameters(ResultReading* reading) {
  std::vector<ParameterResult>& parameters = reading->result.parameters;
  std::map<ParameterName, std::uint32_t> index;
  ForRows(reading->source.Require("passes", kParameterColumns).get(), [&](const Row& row) {
    constexpr const auto& kColumns = kParameterColumns;
    const ParameterName name(row.Id(kColumns("pass")), row.Id(kColumns("parameter")));
    if (!index.emplace(name, static_cast<std::uint32_t>(parameters.size())).second) {
      row.Fail(kColumns("parameter"),
               Quoted(name.second) + " of " + Quoted(name.first) + " is given twice");
    }
    parameters.push_back({name.first,
                          name.second,
                          std::string(row.Text(kColumns("unit"))),
                          row.RequiredNumber(kColumns("value")),
                          ReadSigma(row, kColumns("sigma")),
                          ReadSigma(row, kColumns("prior_sigma")),
                          std::string(row.Text(kColumns("kept")))});
  });
  const auto covariance = reading->source.Open("passes_covariance", kParameterCovarianceColumns);
  if (!covariance) return;
  ForRows(covariance.get(), [&](const Row& row) {
    constexpr const auto& kColumns = kParameterCovarianceColumns;
    const auto find = [&](std::size_t pass, std::size_t parameter) {
      const ParameterName name(row.Id(pass), row.Id(parameter));
      const auto found = index.find(name);
      if (found == index.end()) {
        row.Fail(
            parameter,
            "passes.csv has no parameter " + Quoted(name.second) + " of " + Quoted(name.first));
      }
      return found->second;
    };
    const std::uint32_t a = find(kColumns("pass_a"), kColumns("parameter_a"));
    const std::uint32_t b = find(kColumns("pass_b"), kColumns("parameter_b"));
    reading->result.parameter_covariance.push_back(
        {a, b, row.RequiredNumber(kColumns("covariance"))});
  });
}

namespace {

// As float; a number that a float cannot hold is refused.
float ReadFloat(const Row& row, std::size_t column) {
  const double value = row.Number(column);
  if (std::abs(value) > static_cast<double>(std::numeric_limits<float>::max())) {
    row.Fail(column, NumberText(value) + " is too large");
  }
  return static_cast<float>(value);
}

}  // namespace

void ReadResultLooks(ResultReading* reading) {
  constexpr const auto& kColumns = kResidualColumns;
  const auto table = reading->source.Require("residuals", kColumns);
  ResultLooks& looks = reading->result.looks;
  const std::array<std::pair<std::size_t, std::vector<float>*>, 10> quality{
      {{kColumns("range_redundancy"), &looks.quality.redundancy[0]},
       {kColumns("azimuth_redundancy"), &looks.quality.redundancy[1]},
       {kColumns("range_w"), &looks.quality.w[0]},
       {kColumns("azimuth_w"), &looks.quality.w[1]},
       {kColumns("range_tau"), &looks.tau[0]},
       {kColumns("azimuth_tau"), &looks.tau[1]},
       {kColumns("range_mdb_m"), &looks.mdb_m[0]},
       {kColumns("azimuth_mdb_m"), &looks.mdb_m[1]},
       {kColumns("range_influence_m"), &looks.influence_m[0]},
       {kColumns("azimuth_influence_m"), &looks.influence_m[1]}}};
  const std::array<std::pair<std::size_t, std::vector<double>*>, 6> optional{
      {{kColumns("line"), &looks.line_px},
       {kColumns("pixel"), &looks.pixel_px},
       {kColumns("line_residual_px"), &looks.line_residual_px},
       {kColumns("pixel_residual_px"), &looks.pixel_residual_px},
       {kColumns("reduction_range_m"), &reading->result.reductions.range_m},
       {kColumns("reduction_time_s"), &reading->result.reductions.time_s}}};
  IdFinder passes("pass", reading->pass_ids, kSummaryFile);
  IdFinder points("point", reading->result.points.ids, kPointsFile);
  ForRows(table.get(), [&](const Row& row) {
    looks.pass.push_back(passes.Find(row, kColumns("pass")));
    looks.point.push_back(points.Find(row, kColumns("point")));
    looks.range_residual_m.push_back(row.Number(kColumns("range_residual_m")));
    looks.azimuth_residual_m.push_back(row.Number(kColumns("azimuth_residual_m")));
    for (const auto& [column, values] : quality) values->push_back(ReadFloat(row, column));
    looks.weight.push_back(row.Given(kColumns("weight")) ? ReadFloat(row, kColumns("weight"))
                                                         : 1.0f);
    looks.rejected.push_back(row.Flag(kColumns("rejected")) ? 1 : 0);
    looks.reason.push_back(ReadEnum(row, kColumns("reason"), RejectReason::kSuspect));
    looks.finding.push_back(row.Count(kColumns("finding")));
    for (const auto& [column, values] : optional) values->push_back(row.Number(column));
    StepRows(*reading, looks.size(), "looks");
  });
  RequireCounted(*reading, table->file(), "looks", looks.size());
  for (const auto& [column, values] : quality) DropIfEmpty(values);
  for (const auto& [column, values] : optional) DropIfEmpty(values);
}

void ReadResultControl(ResultReading* reading) {
  constexpr const auto& kColumns = kControlColumns;
  const auto table = reading->source.Open("control_quality", kColumns);
  if (!table) return;
  IdFinder points("point", reading->result.points.ids, kPointsFile);
  ForRows(table.get(), [&](const Row& row) {
    ResultControl control;
    control.shift_m = kNotGiven;
    control.point = points.Find(row, kColumns("point"));
    constexpr std::string_view kComponents = "enu";
    const std::string_view component = row.Text(kColumns("component"));
    const std::size_t found =
        component.size() == 1 ? kComponents.find(component) : kComponents.npos;
    if (found == kComponents.npos) {
      row.Fail(kColumns("component"), Quoted(component) + " is not known, e, n or u is allowed");
    }
    control.component = static_cast<int>(found);
    control.residual_m = row.RequiredNumber(kColumns("residual_m"));
    control.sigma_m = row.Number(kColumns("sigma_m"));
    control.redundancy = row.Number(kColumns("redundancy"));
    control.w = row.Number(kColumns("w"));
    control.tau = row.Number(kColumns("tau"));
    control.mdb_m = row.Number(kColumns("mdb_m"));
    control.influence_m = row.Number(kColumns("influence_m"));
    reading->result.control.push_back(control);
  });
}

void ReadResultPairs(ResultReading* reading) {
  constexpr const auto& kColumns = kPairColumns;
  const auto table = reading->source.Open("pairs", kColumns);
  if (!table) return;
  IdFinder first("point", reading->result.points.ids, kPointsFile), second = first;
  ForRows(table.get(), [&](const Row& row) {
    PairResult pair;
    pair.a = first.Find(row, kColumns("point_a"));
    pair.b = second.Find(row, kColumns("point_b"));
    pair.difference_enu_m = Eigen::Vector3d(row.Numbers(kColumns("de_m", "dn_m", "du_m")).data());
    pair.covariance_m2 = row.Numbers(kPairCovariance);
    for (const auto& figure : kPairFigures) pair.*figure.member = row.Number(figure.column);
    reading->result.pairs.push_back(pair);
  });
}

void ReadResultStrips(ResultReading* reading) {
  constexpr const auto& kColumns = kStripColumns;
  const auto table = reading->source.Open("strips", kColumns);
  if (!table) return;
  IdFinder passes("pass", reading->pass_ids, kSummaryFile);
  std::vector<StripStation>& strips = reading->result.strips;
  ForRows(table.get(), [&](const Row& row) {
    const auto vector = [&row](const std::array<std::size_t, 3>& columns) {
      return Eigen::Vector3d(row.Numbers(columns).data());
    };
    StripStation station{
        passes.Find(row, kColumns("pass")),
        row.RequiredNumber(kColumns("time_s")),
        row.RequiredNumber(kColumns("strip_time")),
        vector(kColumns("x_m", "y_m", "z_m")),
        vector(kColumns("near_x_m", "near_y_m", "near_z_m")),
        vector(kColumns("far_x_m", "far_y_m", "far_z_m")),
        vector(kColumns("correction_along_m", "correction_across_m", "correction_up_m")),
        vector(kColumns("sigma_along_m", "sigma_across_m", "sigma_up_m"))};
    if (!strips.empty() && station.pass < strips.back().pass) {
      row.Fail(kColumns("pass"),
               Quoted(row.Text(kColumns("pass"))) + " is not in the order of summary.json");
    }
    if (!station.antenna_m.allFinite()) {
      row.Fail(kColumns("x_m"), "is empty, a station has a position");
    }
    strips.push_back(station);
  });
}

void ReadResultSelection(ResultReading* reading) {
  if (const auto table = reading->source.Open("selection", kSelectionColumns)) {
    ForRows(table.get(), [&](const Row& row) {
      constexpr const auto& kColumns = kSelectionColumns;
      CandidateResult candidate;
      candidate.name = row.Id(kColumns("candidate"));
      candidate.passes = row.Text(kColumns("passes"));
      candidate.parameters = static_cast<int>(row.Count(kColumns("parameters")));
      candidate.test = ReadEnum(row, kColumns("test"), SelectionTest::kNotTried);
      candidate.statistic = row.Number(kColumns("statistic"));
      candidate.f = row.Number(kColumns("f"));
      candidate.probability = row.Number(kColumns("p"));
      candidate.delta_bic = row.Number(kColumns("delta_bic"));
      candidate.condition = row.Number(kColumns("condition"));
      candidate.posterior_prior = row.Number(kColumns("posterior_prior"));
      const std::string_view verdict = row.Text(kColumns("verdict"));
      candidate.kept = verdict == "kept";
      candidate.held = verdict == "held";
      if (verdict != candidate.verdict()) {
        row.Fail(kColumns("verdict"),
                 Quoted(verdict) + " is not known, kept, held or dropped is allowed");
      }
      candidate.reason = row.Text(kColumns("reason"));
      reading->result.candidates.push_back(std::move(candidate));
    });
  }
  if (const auto table = reading->source.Open("simplifications", kSimplificationColumns)) {
    ForRows(table.get(), [&](const Row& row) {
      constexpr const auto& kColumns = kSimplificationColumns;
      reading->result.simplifications.push_back({std::string(row.Id(kColumns("simplification"))),
                                                 row.Number(kColumns("bound_m")),
                                                 row.Number(kColumns("sigma_m")),
                                                 row.Number(kColumns("fraction")),
                                                 row.Flag(kColumns("allowed")),
                                                 row.Flag(kColumns("taken")),
                                                 kNotGiven,
                                                 std::string(row.Text(kColumns("verdict")))});
    });
  }
}

void ReadResultPaths(ResultReading* reading) {
  const auto reader = reading->source.Require("trajectories", kPathColumns);
  PathTable table = ReadPaths(reader.get(), reading->pass_ids, kSummaryFile);
  for (std::size_t i = 0; i < table.states.size(); ++i) {
    if (table.states[i].size() < 2) {
      throw InputError(reader->PlaceAt(LastLine(table, i), kPathColumns("pass")),
                       "pass " + Quoted(reading->pass_ids[i]) +
                           " has fewer than two states, two or more are needed");
    }
    reading->result.passes[i].path = FlightPath(std::move(table.states[i]));
  }
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
    summary = SummaryText(
        block,
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

}  // namespace sarblock::files
