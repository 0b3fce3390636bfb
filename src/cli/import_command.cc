// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/io/adjust_table.h"
#include "sarblock/io/block_files.h"
#include "sarblock/product/import_block.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>

#include "command_line.h"
#include "commands.h"
#include "io/output_folder.h"
#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace sarblock::cli {
namespace {

struct ImportArguments {
  std::vector<std::string> annotations, orbits;
  std::string out;
  ImportOptions options;
  bool gzip = false;
  bool force = false;
};

std::string ReadText(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!std::filesystem::is_regular_file(file) || !stream) {
    throw InputError(FilePlace{file, 0, ""}, "cannot be opened, an XML file is needed");
  }
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::string SigmaText(const LookSigma& sigma) {
  const bool seconds = sigma.azimuth_unit == AzimuthUnit::kSeconds;
  return fmt::format(
      "{:.3g} m in range, {:.3g} {} in azimuth", sigma.range_m, sigma.azimuth, seconds ? "s" : "m");
}

std::string DescribeImport(const ImportArguments& arguments, const ImportedBlock& imported) {
  std::string text;
  const auto out = std::back_inserter(text);
  for (std::size_t i = 0; i < imported.products.size(); ++i) {
    const ImportedProduct& product = imported.products[i];
    fmt::format_to(out,
                   "{}: {} of {} grid points fit the {} orbit within {:.2f} mm in range, {:.1f} mm "
                   "along track (mean {:.1f} mm)\n",
                   product.pass,
                   product.good,
                   product.grid_points,
                   arguments.orbits.empty() ? product.orbit_source : "given",
                   1e3 * product.largest_range_m,
                   1e3 * product.largest_along_m,
                   1e3 * product.mean_along_m);
    fmt::format_to(
        out, "  standard deviations of its looks: {}\n", SigmaText(imported.block.passes[i].sigma));
  }
  fmt::format_to(out,
                 "{}: {} passes, {} points, {} looks written to {}\n",
                 imported.block.name,
                 imported.block.passes.size(),
                 imported.block.points.size(),
                 imported.block.looks.size(),
                 arguments.out);
  return text;
}

std::string ImportJson(const ImportArguments& arguments, const ImportedBlock& imported) {
  nlohmann::json products = nlohmann::json::array(), faults = nlohmann::json::array();
  for (const ImportedProduct& product : imported.products) {
    products.push_back({{"file", product.file},
                        {"pass", product.pass},
                        {"orbit_source", product.orbit_source},
                        {"grid_points", product.grid_points},
                        {"good", product.good},
                        {"largest_range_misfit_m", product.largest_range_m},
                        {"largest_along_misfit_m", product.largest_along_m},
                        {"mean_along_misfit_m", product.mean_along_m}});
  }
  for (const FaultyRow& row : imported.faults) {
    faults.push_back({{"file", row.file},
                      {"line", row.line},
                      {"row", row.row},
                      {"fault", row.fault == GridFault::kPosition ? "position" : "height"},
                      {"points", row.points},
                      {"of", row.of},
                      {"along_m", row.along_m},
                      {"range_m", row.range_m},
                      {"height_m", row.height_m},
                      {"message", Describe(row)}});
  }
  const nlohmann::json summary = {{"format", "sarblock-import 1"},
                                  {"block", arguments.out},
                                  {"products", products},
                                  {"faulty_rows", faults},
                                  {"passes", imported.block.passes.size()},
                                  {"points", imported.block.points.size()},
                                  {"looks", imported.block.looks.size()},
                                  {"warnings", imported.warnings}};
  return summary.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

int RunImport(const ImportArguments& arguments, const Session& session) {
  if (!session.dump_config) {
    RequireFolderFor(FolderContent::kBlock,
                     arguments.out,
                     arguments.force ? ForeignFiles::kReplace : ForeignFiles::kRefuse);
  }
  std::vector<Sentinel1Product> products;
  for (const std::string& file : arguments.annotations) {
    Step(session.progress.get(), "read", products.size(), arguments.annotations.size(), "products");
    products.push_back(ParseSentinel1(ReadText(file), file));
  }
  std::vector<OrbitFile> orbits;
  for (const std::string& file : arguments.orbits) {
    orbits.push_back(ParseOrbitFile(ReadText(file), file));
  }
  // Of several the id of the pass says which.
  const std::string only = arguments.annotations.size() == 1 ? arguments.annotations.front() : "";
  const ImportedBlock imported =
      Naming(only, [&] { return ImportProducts(products, orbits, arguments.options); });
  std::vector<std::string> ids;
  for (const Pass& pass : imported.block.passes) ids.push_back(pass.id);
  // "given" with no table: nothing is corrected until --set, here or later, adds a group.
  const AdjustOptions adjust =
      ReadAdjustTable("[adjust]\ncorrections = \"given\"\n", "import", ids, session.set);
  if (session.dump_config) {
    fmt::print("{}", DumpAdjustTable(adjust));
    return kAccepted;
  }
  WriteBlock(arguments.out,
             imported.block,
             adjust,
             nullptr,
             arguments.gzip ? Compression::kGzip : Compression::kNone);
  for (const FaultyRow& row : imported.faults) session.Say("warning: " + Describe(row));
  for (const std::string& warning : imported.warnings) session.Say("warning: " + warning);
  if (session.json) {
    fmt::print("{}\n", ImportJson(arguments, imported));
  } else {
    session.Show(DescribeImport(arguments, imported));
  }
  return kAccepted;
}

// Left out: the look's standard deviations are those of a pixel, the positions have none.
void AddNumber(CLI::App* command,
               const std::string& name,
               std::optional<double>* value,
               const std::string& help) {
  command
      ->add_option_function<double>(
          name, [value](double given) { *value = given; }, help)
      ->check(CLI::PositiveNumber);
}

void AddOptions(CLI::App* command, ImportArguments* arguments) {
  ImportOptions& options = arguments->options;
  command->add_option("annotations", arguments->annotations, "Annotation files (XML), SLC or GRD")
      ->required();
  command->add_option("-o,--output", arguments->out, "Folder or .h5 file of the block to write")
      ->required();
  command->add_option(
      "--orbit", arguments->orbits, "Orbit files (EOF) instead of the annotated orbits");
  const std::map<std::string, PointRole> roles{
      {"check", PointRole::kCheck}, {"control", PointRole::kControl}, {"tie", PointRole::kTie}};
  command->add_option("--grid", options.grid, "What grid points become: check, control or tie")
      ->transform(ChoiceOf(roles))
      ->default_str("check");
  AddNumber(command,
            "--grid-sigma-m",
            &options.grid_sigma_m,
            "Standard deviation of the grid's positions, each axis");
  AddNumber(command,
            "--sigma-range-m",
            &options.range_sigma_m,
            "Of the looks' range (left out: a pixel, evenly spread)");
  AddNumber(command,
            "--sigma-azimuth-m",
            &options.azimuth_sigma_m,
            "Of the looks' azimuth (left out: a line, evenly spread)");
  command
      ->add_option(
          "--max-misfit-m", options.max_misfit_m, "Grid points that fit the orbit worse are faulty")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command
      ->add_option(
          "--orbit-step-s", options.orbit_step_s, "Spacing of the path's states; 0: as given")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  const std::map<std::string, OrbitThrough> through{{"states", OrbitThrough::kStates},
                                                    {"positions", OrbitThrough::kPositions}};
  command
      ->add_option("--orbit-through",
                   options.through,
                   "Interpolate through states (positions and velocities) or positions alone")
      ->transform(ChoiceOf(through))
      ->default_str("states");
  command
      ->add_option("--orbit-margin-s",
                   options.orbit_margin_s,
                   "Of an orbit file, taken before and after the product")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--id", options.pass_ids, "Ids of the passes, one a product");
  command->add_option("--name", options.name, "Name of the block (left out: that of its folder)");
  command->add_flag("--gzip", arguments->gzip, "Write the tables compressed (.csv.gz)");
  command->add_flag("--force", arguments->force, "Write into a folder that holds other files");
}

}  // namespace

void AddImport(CLI::App* app, Session* session) {
  CLI::App* group = app->add_subcommand("import", "Make a block of products of others");
  group->require_subcommand(1);
  auto arguments = std::make_shared<ImportArguments>();
  arguments->options.name.clear();
  CLI::App* command = group->add_subcommand(
      "sentinel1", "Of Sentinel-1 annotations: orbits, image rasters and geolocation grids");
  AddOptions(command, arguments.get());
  command->callback([=] {
    session->run = [=] {
      if (arguments->options.name.empty()) {
        const auto whole = std::filesystem::absolute(arguments->out).lexically_normal();
        arguments->options.name =
            (whole.has_filename() ? whole : whole.parent_path()).filename().string();
      }
      return RunImport(*arguments, *session);
    };
  });
}

}  // namespace sarblock::cli
