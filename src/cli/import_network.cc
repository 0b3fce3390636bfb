// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/files/block_file.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <vector>

#include "import.h"
#include "products/block_builder.h"
#include "products/csm.h"
#include "products/image_table.h"
#include "products/import.h"
#include "products/isis.h"
#include "products/network.h"
#include "program.h"
#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace sarblock::cli {
namespace {

enum class ImageKind { kIsis, kCsm };

struct NetworkArguments {
  ImageKind kind = ImageKind::kIsis;
  std::string network;
  std::vector<std::string> images, serials, serial_lists;
  std::string pixel_origin;
  MatchArguments matches;
  NetworkImportOptions options;
  ImportOutput output;
};

constexpr const char* kSerialForm = "SERIAL=FILE";

// Serials given by options and by lines of lists; blank lines and those that begin with # are
// skipped.
std::vector<std::pair<std::string, std::string>> GivenSerials(const NetworkArguments& arguments) {
  std::vector<std::pair<std::string, std::string>> serials;
  for (const std::string& text : arguments.serials) {
    serials.push_back(SplitPair(text, kSerialForm, FilePlace{"--serial", 0, ""}));
  }
  for (const std::string& file : arguments.serial_lists) {
    std::ifstream stream(file);
    if (!std::filesystem::is_regular_file(file) || !stream) {
      throw InputError(FilePlace{file, 0, ""}, "cannot be opened, lines SERIAL=FILE are needed");
    }
    std::string line;
    for (std::size_t number = 1; std::getline(stream, line); ++number) {
      if (line.ends_with('\r')) line.pop_back();
      if (line.find_first_not_of(" \t") == std::string::npos || line.starts_with('#')) continue;
      serials.push_back(SplitPair(line, kSerialForm, FilePlace{file, number, ""}));
    }
  }
  return serials;
}

// The image of a file that --serial names: one of those given, by path or name, or one more.
std::size_t ImageOfFile(const std::string& file, std::vector<std::string>* images) {
  const auto named = [&](const std::string& image) {
    return image == file || std::filesystem::path(image).filename() == file;
  };
  const auto found = std::find_if(images->begin(), images->end(), named);
  if (found != images->end()) return static_cast<std::size_t>(found - images->begin());
  images->push_back(file);
  return images->size() - 1;
}

std::string SigmaOfPass(const Pass& pass, bool jigsaw) {
  if (jigsaw)
    return fmt::format("{:.5g} m in range, by Doppler shift along track", pass.sigma.range_m);
  const auto text = [](double sigma_m) {
    return std::isnan(sigma_m) ? std::string("those of the network")
                               : fmt::format("{:.3g} m", sigma_m);
  };
  return text(pass.sigma.range_m) + " in range, " + text(pass.sigma.azimuth) + " in azimuth";
}

std::string DescribeNetwork(const NetworkArguments& arguments,
                            const ControlNetwork& network,
                            const ImportedNetwork& imported) {
  const Block& block = imported.block;
  std::string text;
  const auto out = std::back_inserter(text);
  for (std::size_t i = 0; i < imported.images.size(); ++i) {
    const ImportedImage& image = imported.images[i];
    fmt::format_to(out,
                   "{}: {} measures, {} rejected; serial number {}\n",
                   image.pass,
                   image.looks,
                   image.rejected,
                   image.serial);
    fmt::format_to(out,
                   "  standard deviations of its looks: {}\n",
                   SigmaOfPass(block.passes[i], arguments.options.jigsaw_sigma));
    if (image.offset.looks == 0) continue;
    fmt::format_to(out,
                   "  {} measures lie {:.2f} lines and {:.2f} samples (median) from their points' "
                   "given positions\n",
                   image.offset.looks,
                   image.offset.line_px,
                   image.offset.sample_px);
  }
  const auto control =
      std::count(block.points.role.begin(), block.points.role.end(), PointRole::kControl);
  fmt::format_to(out,
                 "{}: network of version {}; {} passes, {} points ({} control), {} looks written "
                 "to {}\n",
                 block.name,
                 network.version,
                 block.passes.size(),
                 block.points.size(),
                 control,
                 block.looks.size(),
                 arguments.output.folder);
  if (imported.matches > 0) {
    fmt::format_to(
        out, "  {} of the looks are of {}\n", imported.matches, arguments.matches.points);
  }
  if (imported.fixed_points > 0) {
    fmt::format_to(out,
                   "  {} fixed points are held to {} m (--fixed-sigma-m)\n",
                   imported.fixed_points,
                   arguments.options.fixed_sigma_m);
  }
  return text;
}

std::string NetworkJson(const NetworkArguments& arguments,
                        const ControlNetwork& network,
                        const ImportedNetwork& imported) {
  nlohmann::json images = nlohmann::json::array();
  const auto number = [](double value) {
    return std::isnan(value) ? nlohmann::json() : nlohmann::json(value);
  };
  for (const ImportedImage& image : imported.images) {
    images.push_back({{"file", image.file},
                      {"pass", image.pass},
                      {"serial", image.serial},
                      {"looks", image.looks},
                      {"rejected", image.rejected},
                      {"offset_looks", image.offset.looks},
                      {"line_offset_px", number(image.offset.line_px)},
                      {"sample_offset_px", number(image.offset.sample_px)}});
  }
  const nlohmann::json summary = {{"format", "sarblock-import 1"},
                                  {"block", arguments.output.folder},
                                  {"network", network.file},
                                  {"network_version", network.version},
                                  {"images", images},
                                  {"matches", imported.matches},
                                  {"passes", imported.block.passes.size()},
                                  {"points", imported.block.points.size()},
                                  {"looks", imported.block.looks.size()},
                                  {"warnings", imported.warnings}};
  return summary.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

int RunNetworkImport(const NetworkArguments& arguments, const Session& session) {
  const auto lock = RequireImportFolder(arguments.output, session);
  NetworkImportOptions options = arguments.options;
  options.name = arguments.output.BlockName();
  if (!arguments.pixel_origin.empty()) {
    options.pixel_origin_px = PixelOrigin("pixel-origin", arguments.pixel_origin);
  }
  options.points = ReadMatches(arguments.matches);
  std::vector<std::string> files = arguments.images;
  for (const auto& [serial, file] : GivenSerials(arguments)) {
    options.serials.push_back({serial, ImageOfFile(file, &files)});
  }
  const ControlNetwork network = ReadControlNetwork(arguments.network);
  std::vector<RadarImage> images;
  for (const std::string& file : files) {
    Step(session.progress.get(), "read", images.size(), files.size(), "images");
    images.push_back(arguments.kind == ImageKind::kIsis ? ReadIsisCube(file) : ReadCsmIsd(file));
  }
  const ImportedNetwork imported = ImportNetwork(network, images, options);
  if (!WriteImported(arguments.output, imported.block, session)) return kAccepted;
  for (const std::string& warning : imported.warnings) session.Warn("warning: " + warning);
  if (session.json) {
    fmt::print("{}\n", NetworkJson(arguments, network, imported));
  } else {
    session.Print(DescribeNetwork(arguments, network, imported));
  }
  return kAccepted;
}

void AddNetworkOptions(CLI::App* command, NetworkArguments* arguments) {
  const bool isis = arguments->kind == ImageKind::kIsis;
  NetworkImportOptions& options = arguments->options;
  command->add_option("network", arguments->network, "Control network (.net) of version 2 or 5")
      ->required();
  command->add_option(
      "images",
      arguments->images,
      isis ? "Cubes of ISIS (.cub) after spiceinit" : "ISDs or model states (JSON) of USGSCSM");
  AddImportOutput(command, &arguments->output);
  AddMatchOptions(command, &arguments->matches);
  // One value each time: what follows may be an image.
  command
      ->add_option("--serial",
                   arguments->serials,
                   "SERIAL=FILE: the image that a serial number means; may be repeated")
      ->allow_extra_args(false);
  command->add_option("--serial-list", arguments->serial_lists, "File with lines SERIAL=FILE")
      ->allow_extra_args(false);
  command->add_option("--pixel-origin",
                      arguments->pixel_origin,
                      std::string("Line and sample of the first pixel's centre in the network, one "
                                  "number or LINE,SAMPLE (default: ") +
                          (isis ? "1, of ISIS)" : "0.5, of CSM)"));
  AddRangePolynomial(command,
                     "Ground range polynomials: at their times, or as USGSCSM spaces them",
                     &options.range_polynomial);
  AddNumber(command,
            "--range-sigma-m",
            &options.range_sigma_m,
            "Standard deviation in range of measures to which the network gives none");
  AddNumber(command,
            "--azimuth-sigma-m",
            &options.azimuth_sigma_m,
            "The same along track, at the target");
  if (isis) {
    command->add_flag("--jigsaw-weights",
                      options.jigsaw_sigma,
                      "Use the standard deviations that jigsaw gives measures of Mini-RF");
  }
  AddNumber(command,
            "--control-sigma-m",
            &options.control_sigma_m,
            "Standard deviation, each axis, of constrained points without a covariance");
  command
      ->add_option("--fixed-sigma-m",
                   options.fixed_sigma_m,
                   "Standard deviation, each axis, of fixed points")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  AddNumber(
      command,
      "--height-sigma-m",
      &options.height_sigma_m,
      "Constrain the heights of free points that have a position, as jigsaw constrains radii");
  command->add_option("--id", options.pass_ids, "Ids of the passes, one per image");
  command->add_flag(
      "--leave-out-missing",
      [&options](std::int64_t) { options.missing = MissingImages::kLeaveOut; },
      "Leave out measures in images that are not given");
}

}  // namespace

void AddNetworkImports(CLI::App* group, Session* session) {
  const auto add = [&](ImageKind kind, const char* name, double origin_px, const char* help) {
    auto arguments = std::make_shared<NetworkArguments>();
    arguments->kind = kind;
    arguments->options.pixel_origin_px = {origin_px, origin_px};
    CLI::App* const command = group->add_subcommand(name, help);
    AddNetworkOptions(command, arguments.get());
    command->callback(
        [=] { session->run = [=] { return RunNetworkImport(*arguments, *session); }; });
  };
  add(ImageKind::kIsis,
      "isis",
      1.0,
      "Import an ISIS control network with its cubes (paths, rasters, measures)");
  add(ImageKind::kCsm,
      "csm",
      0.5,
      "Import an ISIS control network with ISDs of USGSCSM's SAR model");
}

}  // namespace sarblock::cli
