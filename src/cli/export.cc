// SPDX-License-Identifier: Apache-2.0
#include "exchange/export.h"

#include "sarblock/core/error.h"
#include "sarblock/files/result.h"
#include "sarblock/tables/output.h"

#include <chrono>
#include <filesystem>
#include <map>
#include <memory>

#include "files/convert.h"
#include "import.h"
#include "program.h"
#include "report/result_page.h"
#include "tables/open.h"
#include <fmt/core.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

namespace sarblock::cli {
namespace {

struct ExportArguments {
  std::string result;
  std::string out;
  ExportFormat format = ExportFormat::kGeoJson;
  double confidence_percent = 0.0;
  bool no_ellipses = false;
  bool no_cross = false;
  std::vector<std::string> images;
  ForeignFiles foreign = ForeignFiles::kRefuse;
  ExportOptions options;
};

std::string NowUtc() {
  const std::chrono::sys_seconds now =
      std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
  const auto day = std::chrono::floor<std::chrono::days>(now);
  const std::chrono::year_month_day date(day);
  const std::chrono::hh_mm_ss time(now - day);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z",
                     static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()),
                     static_cast<unsigned>(date.day()),
                     time.hours().count(),
                     time.minutes().count(),
                     time.seconds().count());
}

std::string ExportJson(const ExportReport& report) {
  nlohmann::ordered_json json = {{"format", "sarblock-export 1"},
                                 {"points", report.points},
                                 {"points_left_out", report.points_left_out},
                                 {"ellipses", report.ellipses},
                                 {"paths", report.paths},
                                 {"files", nlohmann::ordered_json::array()},
                                 {"not_carried", report.not_carried},
                                 {"warnings", report.warnings}};
  for (const auto& file : report.files) json["files"].push_back(file.string());
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

int RunExport(const ExportArguments& arguments, const Session& session) {
  const ExportFormat format = arguments.format;
  const bool map = format == ExportFormat::kGeoJson || format == ExportFormat::kKml ||
                   format == ExportFormat::kGeoPackage;
  const files::ResultFile result =
      files::ReadResult(arguments.result,
                        {.looks = format == ExportFormat::kIsis,
                         .pairs = format == ExportFormat::kSinex,
                         .paths = map || format >= ExportFormat::kOrbitFiles,
                         .progress = session.progress.get()});
  ExportOptions options = arguments.options;
  if (arguments.confidence_percent > 0.0) {
    options.confidence = 0.01 * arguments.confidence_percent;
  }
  options.ellipses = !arguments.no_ellipses;
  options.cross_covariances = !arguments.no_cross;
  options.created_utc = NowUtc();
  for (const std::string& text : arguments.images) {
    auto [pass, file] = SplitPair(text, "PASS=FILE", FilePlace{"--image", 0, ""});
    options.images.push_back({std::move(pass), std::move(file)});
  }
  const std::filesystem::path out = arguments.out.empty()
                                        ? FileOf(arguments.result, DefaultExportName(format))
                                        : std::filesystem::path(arguments.out);
  RequireTargetFor(format, out, arguments.foreign);
  const ExportReport report =
      Naming(arguments.result, [&] { return ExportResult(result, format, out, options); });
  for (const std::string& warning : report.warnings) session.Warn("sarblock: warning: " + warning);
  if (session.json) {
    fmt::print("{}", ExportJson(report));
    return kAccepted;
  }
  std::string text;
  for (const auto& file : report.files) text += file.string() + "\n";
  if (report.points + report.points_left_out > 0) {
    text += fmt::format("  points {} ({} not solved and left out), ellipses {}, flight paths {}\n",
                        report.points,
                        report.points_left_out,
                        report.ellipses,
                        report.paths);
  } else {
    text += fmt::format("  flight paths {}\n", report.paths);
  }
  for (const std::string& what : report.not_carried) text += "  not carried: " + what + "\n";
  session.Print(text);
  return kAccepted;
}

}  // namespace

void AddExport(CLI::App* app, Session* session) {
  auto arguments = std::make_shared<ExportArguments>();
  CLI::App* command = app->add_subcommand("export", "Write a result in a format of other programs");
  command->add_option("result", arguments->result, "Folder or .h5 file of the result")->required();
  std::map<std::string, ExportFormat> formats;
  for (std::size_t i = 0; i < ExportFormatNames().size(); ++i) {
    formats[ExportFormatNames()[i]] = static_cast<ExportFormat>(i);
  }
  command->add_option("--format", arguments->format, "Which format (docs/export.md)")
      ->required()
      ->transform(ChoiceOf(formats));
  command->add_option("-o,--output",
                      arguments->out,
                      "File to write, a folder for isis, eof, csm and sicd (default: in the "
                      "result's folder, or next to its file)");
  command
      ->add_option("--confidence",
                   arguments->confidence_percent,
                   "Probability of the error ellipses in percent (default: 1 sigma, 39.3 percent)")
      ->check(CLI::Range(1e-6, 99.999999));
  command->add_flag("--no-ellipses", arguments->no_ellipses, "Leave out the ellipses' polygons");
  command->add_flag(
      "--no-cross", arguments->no_cross, "SINEX: leave out covariances between points");
  command->add_option("--agency", arguments->options.agency, "SINEX: three characters")
      ->capture_default_str();
  command->add_option(
      "--mission", arguments->options.mission, "eof: satellite, such as Sentinel-1A");
  command
      ->add_option("--image",
                   arguments->images,
                   "csm, sicd: PASS=FILE, the ISD, model state or SICD image of a pass; may be "
                   "repeated")
      ->allow_extra_args(false);
  AddRangePolynomial(command,
                     "csm: how the block was imported, the ISD's polynomials at their times or as "
                     "USGSCSM spaces them",
                     &arguments->options.range_polynomial);
  AddForce(command, &arguments->foreign, "Replace files that sarblock did not write");
  command->callback([=] { session->run = [=] { return RunExport(*arguments, *session); }; });
}

namespace {

struct ConvertArguments {
  std::string from;
  std::string to;
  bool gzip = false;
  ForeignFiles foreign = ForeignFiles::kRefuse;
};

int RunConvert(const ConvertArguments& arguments, const Session& session) {
  RequireFolderFor(ContentAt(arguments.from), arguments.to, arguments.foreign);
  const OutputLock lock(arguments.to);
  const files::ConversionReport report =
      files::Convert(arguments.from,
                     arguments.to,
                     arguments.gzip ? Compression::kGzip : Compression::kNone,
                     session.progress.get());
  if (session.json) {
    const nlohmann::json summary = {{"format", "sarblock-conversion 1"},
                                    {"kind", report.kind},
                                    {"output", arguments.to},
                                    {"tables", report.tables},
                                    {"rows", report.rows},
                                    {"left_out", report.left_out}};
    fmt::print("{}\n", summary.dump(2));
    return kAccepted;
  }
  if (!report.left_out.empty()) {
    session.Warn(fmt::format("sarblock: not tables of a {} and left out: {}",
                             report.kind,
                             fmt::join(report.left_out, ", ")));
  }
  session.Print(fmt::format("{}: {} tables, {} rows written to {}\n",
                            report.kind,
                            report.tables,
                            report.rows,
                            arguments.to));
  return kAccepted;
}

}  // namespace

void AddConvert(CLI::App* app, Session* session) {
  auto arguments = std::make_shared<ConvertArguments>();
  CLI::App* command = app->add_subcommand(
      "convert", "Write a block or a result as one HDF5 file, or such a file as a folder");
  command->add_option("from", arguments->from, "Folder or .h5 file of a block or a result")
      ->required();
  command->add_option("to", arguments->to, "Folder or .h5 file to write")->required();
  command->add_flag("--gzip", arguments->gzip, "Write the tables compressed (.csv.gz, deflate)");
  AddForce(command, &arguments->foreign);
  command->callback([=] { session->run = [=] { return RunConvert(*arguments, *session); }; });
}

namespace {

struct ReportArguments {
  std::vector<std::string> folders;
  std::string out;
  ForeignFiles foreign = ForeignFiles::kRefuse;
};

int RunReport(const ReportArguments& arguments, const Session& session) {
  ProgressSink* progress = session.progress.get();
  const std::vector<std::string>& folders = arguments.folders;
  const bool two = folders.size() == 2;
  std::filesystem::path out = arguments.out;
  if (out.empty()) out = FileOf(folders.back(), two ? "comparison.html" : "report.html");
  RequireFileFor(out, {kReportMark}, arguments.foreign);
  const ReportFile report = two ? WriteComparison(folders[0], folders[1], out, progress)
                                : WriteReport(folders[0], out, progress);
  if (session.json) {
    const nlohmann::json summary = {{"format", "sarblock-report 1"},
                                    {"file", report.file.string()},
                                    {"kind", report.kind},
                                    {"verdict", report.verdict},
                                    {"bytes", report.bytes}};
    fmt::print("{}\n", summary.dump(2));
  } else {
    session.Print(fmt::format("{} ({:.2f} MB)\n  written to {}\n",
                              report.verdict,
                              1e-6 * static_cast<double>(report.bytes),
                              report.file.string()));
  }
  return kAccepted;
}

}  // namespace

void AddReport(CLI::App* app, Session* session) {
  auto arguments = std::make_shared<ReportArguments>();
  CLI::App* command = app->add_subcommand(
      "report", "One HTML file that shows a result or a study, or two results side by side");
  command
      ->add_option("folders",
                   arguments->folders,
                   "Folder of a result or a study, .h5 file of a result; or two results")
      ->required()
      ->expected(1, 2);
  command->add_option("-o,--output",
                      arguments->out,
                      "File to write (default: report.html in the folder or next to the file, "
                      "comparison.html in the "
                      "second)");
  AddForce(command, &arguments->foreign, "Replace files that sarblock did not write");
  command->callback([=] { session->run = [=] { return RunReport(*arguments, *session); }; });
}

void ReportResult(const std::string& folder, const Session& session) {
  const ReportFile report = WriteReport(folder, {}, session.progress.get());
  if (!session.json) session.Print(fmt::format("  report: {}\n", report.file.string()));
}

}  // namespace sarblock::cli
