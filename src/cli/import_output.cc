// SPDX-License-Identifier: Apache-2.0
#include "import_output.h"

#include "sarblock/files/adjust_options.h"
#include "sarblock/files/block_file.h"
#include "sarblock/tables/output.h"

#include <map>
#include <vector>

#include "command_line.h"
#include <fmt/core.h>

namespace sarblock::cli {

std::string ImportOutput::BlockName() const { return name.empty() ? NameAt(folder) : name; }

void AddImportOutput(CLI::App* command, ImportOutput* output) {
  command->add_option("-o,--output", output->folder, "Folder or .h5 file of the block to write")
      ->required();
  command->add_option("--name", output->name, "Name of the block (left out: that of its folder)");
  command->add_flag("--gzip", output->gzip, "Write the tables compressed (.csv.gz, deflate)");
  AddForce(command, &output->foreign);
}

void RequireImportFolder(const ImportOutput& output, const Session& session) {
  if (session.dump_config) return;
  RequireFolderFor(FolderContent::kBlock, output.folder, output.foreign);
}

bool WriteImported(const ImportOutput& output,
                   const Block& block,
                   const Session& session,
                   AdjustOptions own) {
  std::vector<std::string> ids;
  for (const Pass& pass : block.passes) ids.push_back(pass.id);
  // "given", also with no table: then nothing is corrected until --set, here or later, adds a
  // group.
  own.corrections = CorrectionChoice::kGiven;
  const AdjustOptions adjust = ReadAdjustTable(DumpAdjustTable(own), "import", ids, session.set);
  if (session.dump_config) {
    fmt::print("{}", DumpAdjustTable(adjust));
    return false;
  }
  WriteBlock(
      output.folder, block, adjust, nullptr, output.gzip ? Compression::kGzip : Compression::kNone);
  return true;
}

void AddRangePolynomial(CLI::App* command, const std::string& help, RangePolynomialTimes* value) {
  const std::map<std::string, RangePolynomialTimes> polynomials{
      {"times", RangePolynomialTimes::kGiven}, {"usgscsm", RangePolynomialTimes::kUsgscsm}};
  command->add_option("--range-polynomial", *value, help)
      ->transform(ChoiceOf(polynomials))
      ->default_str("times");
}

void AddNumber(CLI::App* command,
               const std::string& name,
               std::optional<double>* value,
               const std::string& help) {
  command
      ->add_option_function<double>(
          name, [value](double given) { *value = given; }, help)
      ->check(CLI::PositiveNumber);
}

}  // namespace sarblock::cli
