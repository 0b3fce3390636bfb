// SPDX-License-Identifier: Apache-2.0
#include "diagnose_command.h"

#include "sarblock/files/adjust_options.h"

#include <filesystem>
#include <limits>
#include <memory>

#include "files/summary.h"
#include <fmt/core.h>

namespace sarblock::cli {
namespace {

struct DiagnoseArguments {
  std::string block;
  std::string rejections;
  bool all = false;
};

int RunDiagnose(const DiagnoseArguments& arguments, const Session& session) {
  ReadOptions read;
  read.set_overrides = session.set;
  read.progress = session.progress.get();
  read.contradictions = Contradictions::kKeep;
  BlockFile file = ReadBlock(arguments.block, read);
  file.adjust.threads = session.Threads();
  if (!arguments.rejections.empty()) {
    file.adjust.rejections_file = std::filesystem::absolute(arguments.rejections).string();
  }
  if (session.dump_config) {
    fmt::print("{}", DumpAdjustTable(file.adjust));
    return kAccepted;
  }
  if (!file.adjust.rejections_file.empty()) {
    static_cast<void>(ApplyRejections(arguments.block, file.adjust.rejections_file, &file.block));
  }
  DiagnosisBounds bounds;
  if (arguments.all) bounds.adjustments_1 = std::numeric_limits<double>::infinity();
  const Diagnosis diagnosis = Diagnose(file.block, file.adjust, session.progress.get(), bounds);
  if (session.json) {
    const nlohmann::ordered_json summary = {{"format", "sarblock-diagnosis 1"},
                                            {"block", file.block.name},
                                            {"contradicts", diagnosis.contradicts},
                                            {"points", diagnosis.points},
                                            {"square_sum", diagnosis.square_sum},
                                            {"redundancy", diagnosis.redundancy},
                                            {"hypotheses", diagnosis.hypotheses},
                                            {"solutions", diagnosis.solutions},
                                            {"untried", diagnosis.untried},
                                            {"diagnosis", DiagnosisSection(diagnosis)},
                                            {"remarks", diagnosis.remarks},
                                            {"warnings", file.warnings}};
    fmt::print("{}\n", summary.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
    return kAccepted;
  }
  std::string text =
      fmt::format("{}: {} of {} points, v'Pv {:.4g}, redundancy {:g}: {}\n",
                  file.block.name,
                  diagnosis.points,
                  file.block.points.size(),
                  diagnosis.square_sum,
                  diagnosis.redundancy,
                  diagnosis.contradicts ? "contradicts itself" : "nothing contradicts");
  for (const std::string& warning : file.warnings) text += "  warning: " + warning + "\n";
  for (const std::string& remark : RemarksBeside(file.warnings, diagnosis)) {
    text += "  warning: " + remark + "\n";
  }
  session.Show(text + DescribeDiagnosis(diagnosis));
  return kAccepted;
}

}  // namespace

void ExplainUnread(const std::string& folder, ReadOptions read, const Session& session) {
  read.contradictions = Contradictions::kKeep;
  try {
    ExplainRefusal(ReadBlock(folder, read), session);
  } catch (const InputError&) {  // a file that cannot be read at all: its own message stands
  }
}

void ExplainRefusal(const BlockFile& file, const Session& session) {
  if (!file.adjust.diagnose) return;
  const Diagnosis diagnosis = Diagnose(file.block, file.adjust, session.progress.get());
  for (const std::string& remark : diagnosis.remarks) session.Say("sarblock: warning: " + remark);
  for (const std::string& text : diagnosis.Sentences()) session.Say("sarblock: " + text);
}

std::string DescribeDiagnosis(const Diagnosis& diagnosis) {
  std::string text;
  for (const std::string& sentence : diagnosis.Sentences()) text += "  " + sentence + "\n";
  if (diagnosis.contradicts && diagnosis.explanations.empty()) {
    text += "  none of " + std::to_string(diagnosis.hypotheses) +
            " mistakes tried takes half of what v'Pv exceeds its redundancy by\n";
  }
  if (diagnosis.untried > 0) {
    text += "  " + std::to_string(diagnosis.untried) +
            " explanations were not tried, since the work of five adjustments was done: "
            "sarblock diagnose --all tries them\n";
  }
  return text;
}

void AddDiagnose(CLI::App* app, Session* session) {
  auto arguments = std::make_shared<DiagnoseArguments>();
  CLI::App* command = app->add_subcommand(
      "diagnose", "Explain by people's mistakes why a block contradicts itself, most likely first");
  command->add_option("block", arguments->block, "Folder or .h5 file of the block")->required();
  command->add_option("--rejections",
                      arguments->rejections,
                      "Leave out the looks with rejected = 1 in this table, as adjust would");
  command->add_flag("--all",
                    arguments->all,
                    "Try every explanation, however much work; else that of five adjustments");
  command->callback([=] { session->run = [=] { return RunDiagnose(*arguments, *session); }; });
}

}  // namespace sarblock::cli
