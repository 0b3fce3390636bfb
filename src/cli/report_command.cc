// SPDX-License-Identifier: Apache-2.0
#include "report_command.h"

#include "sarblock/core/error.h"
#include "sarblock/tables/output.h"

#include <filesystem>
#include <memory>

#include "report/result_page.h"
#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace sarblock::cli {
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
    session.Show(fmt::format("{} ({:.2f} MB)\n  written to {}\n",
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
  command->add_option(
      "-o,--output",
      arguments->out,
      "File to write (report.html in the folder or beside the file, comparison.html in the "
      "second)");
  AddForce(command, &arguments->foreign, "Replace files that sarblock did not write");
  command->callback([=] { session->run = [=] { return RunReport(*arguments, *session); }; });
}

void ReportResult(const std::string& folder, const Session& session) {
  const ReportFile report = WriteReport(folder, {}, session.progress.get());
  if (!session.json) session.Show(fmt::format("  report: {}\n", report.file.string()));
}

}  // namespace sarblock::cli
