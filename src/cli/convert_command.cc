// SPDX-License-Identifier: Apache-2.0
#include "sarblock/files/convert.h"
#include "sarblock/tables/output.h"

#include <memory>

#include "commands.h"
#include "tables/open.h"
#include <fmt/core.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

namespace sarblock::cli {
namespace {

struct ConvertArguments {
  std::string from;
  std::string to;
  bool gzip = false;
  ForeignFiles foreign = ForeignFiles::kRefuse;
};

int RunConvert(const ConvertArguments& arguments, const Session& session) {
  RequireFolderFor(ContentAt(arguments.from), arguments.to, arguments.foreign);
  const ConversionReport report = Convert(arguments.from,
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
    session.Say(fmt::format("sarblock: not tables of a {} and left out: {}",
                            report.kind,
                            fmt::join(report.left_out, ", ")));
  }
  session.Show(fmt::format("{}: {} tables, {} rows written to {}\n",
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

}  // namespace sarblock::cli
