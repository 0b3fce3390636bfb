// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

#include <iterator>
#include <map>
#include <memory>

#include "command_line.h"
#include "commands.h"
#include "import_matches.h"
#include "import_network_command.h"
#include "import_output.h"
#include "products/block_builder.h"
#include "products/image_table.h"
#include "products/import.h"
#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace sarblock::cli {
namespace {

enum class ImportKind { kSentinel1, kNisar, kSicd, kImages };

/// What grid points become; held against the orbit they are in any case.
enum class GridUse { kNone, kCheck, kControl, kTie };
std::optional<PointRole> RoleOf(GridUse use) {
  switch (use) {
    case GridUse::kNone:
      break;
    case GridUse::kCheck:
      return PointRole::kCheck;
    case GridUse::kControl:
      return PointRole::kControl;
    case GridUse::kTie:
      return PointRole::kTie;
  }
  return std::nullopt;
}

/// What the corners of a SICD image become.
enum class CornerUse { kNone, kCheck };

struct ImportArguments {
  ImportKind kind = ImportKind::kSentinel1;
  GridUse grid = GridUse::kCheck;
  std::vector<std::string> images, orbits;
  MatchArguments matches;
  std::string reflectors;
  NisarFrequency frequency = NisarFrequency::kA;
  CornerUse corners = CornerUse::kNone;
  std::optional<double> corner_sigma_m;
  ImportOptions options;
  ImportOutput output;
};

std::string SigmaText(const LookSigma& sigma) {
  const char* const unit = sigma.azimuth_unit == AzimuthUnit::kSeconds ? "s"
                           : sigma.azimuth_unit == AzimuthUnit::kHertz ? "Hz"
                                                                       : "m";
  return fmt::format("{:.3g} m in range, {:.3g} {} in azimuth", sigma.range_m, sigma.azimuth, unit);
}

std::string DescribeGrid(const ImportedProduct& product, const char* orbit) {
  return fmt::format(
      "{}: {} of {} grid points fit the {} orbit within {:.2f} mm in range, {:.1f} mm "
      "along track (mean {:.1f} mm)\n",
      product.pass,
      product.good,
      product.grid_points,
      orbit,
      1e3 * product.largest_range_m,
      1e3 * product.largest_along_m,
      1e3 * product.mean_along_m);
}

std::string DescribeImport(const ImportArguments& arguments, const ImportedBlock& imported) {
  std::string text;
  const auto out = std::back_inserter(text);
  for (std::size_t i = 0; i < imported.products.size(); ++i) {
    const ImportedProduct& product = imported.products[i];
    const char* const orbit = arguments.orbits.empty() ? product.orbit_source.c_str() : "given";
    text += product.grid_points > 0 ? DescribeGrid(product, orbit)
                                    : product.pass + ": " + product.file + "\n";
    fmt::format_to(
        out, "  standard deviations of its looks: {}\n", SigmaText(imported.block.passes[i].sigma));
    if (product.corners > 0) {
      fmt::format_to(out,
                     "  {} corners fit within {:.3g} m in range, {:.3g} m along track\n",
                     product.corners,
                     product.corner_range_m,
                     product.corner_along_m);
    }
    if (!product.priors.empty()) text += "  " + product.priors + "\n";
    if (product.matches > 0) {
      text += "  " + DescribeMatches(product.matches, product.offset) + "\n";
    }
    for (const ReflectorInImage& reflector : imported.reflectors) {
      if (reflector.pass != i) continue;
      fmt::format_to(out,
                     "  reflector {} should be at line {:.3f}, sample {:.3f}\n",
                     reflector.id,
                     reflector.line_px,
                     reflector.sample_px);
    }
  }
  fmt::format_to(out,
                 "{}: {} passes, {} points, {} looks written to {}\n",
                 imported.block.name,
                 imported.block.passes.size(),
                 imported.block.points.size(),
                 imported.block.looks.size(),
                 arguments.output.folder);
  return text;
}

std::string ImportJson(const ImportArguments& arguments, const ImportedBlock& imported) {
  nlohmann::json products = nlohmann::json::array(), faults = nlohmann::json::array();
  nlohmann::json reflectors = nlohmann::json::array();
  for (const ImportedProduct& product : imported.products) {
    products.push_back({{"file", product.file},
                        {"pass", product.pass},
                        {"orbit_source", product.orbit_source},
                        {"grid_points", product.grid_points},
                        {"good", product.good},
                        {"largest_range_misfit_m", product.largest_range_m},
                        {"largest_along_misfit_m", product.largest_along_m},
                        {"mean_along_misfit_m", product.mean_along_m},
                        {"corners", product.corners},
                        {"largest_corner_range_misfit_m", product.corner_range_m},
                        {"largest_corner_along_misfit_m", product.corner_along_m},
                        {"matches", product.matches},
                        {"priors", product.priors},
                        {"offset", OffsetJson(product.offset)}});
  }
  for (const ReflectorInImage& reflector : imported.reflectors) {
    reflectors.push_back({{"point", reflector.id},
                          {"pass", imported.block.passes[reflector.pass].id},
                          {"line", reflector.line_px},
                          {"sample", reflector.sample_px}});
  }
  for (const FaultyRow& row : imported.faults) {
    faults.push_back({{"file", row.file},
                      {"line", row.line},
                      {"row", row.row},
                      {"fault", row.fault == GridFault::kPosition ? "position" : "height"},
                      {"same_time", row.same_time},
                      {"points", row.points},
                      {"of", row.of},
                      {"along_m", row.along_m},
                      {"range_m", row.range_m},
                      {"height_m", row.height_m},
                      {"message", Describe(row)}});
  }
  const nlohmann::json summary = {{"format", "sarblock-import 1"},
                                  {"block", arguments.output.folder},
                                  {"products", products},
                                  {"faulty_rows", faults},
                                  {"reflectors", reflectors},
                                  {"passes", imported.block.passes.size()},
                                  {"points", imported.block.points.size()},
                                  {"looks", imported.block.looks.size()},
                                  {"warnings", imported.warnings}};
  return summary.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

SensorImage ReadImageFile(const ImportArguments& arguments, const std::string& file) {
  switch (arguments.kind) {
    case ImportKind::kSentinel1:
      return ReadSentinel1(file);
    case ImportKind::kNisar:
      return ReadNisar(file, arguments.frequency);
    case ImportKind::kSicd:
      return ReadSicd(file);
    case ImportKind::kImages:
      break;
  }
  return ReadSensorImage(file, arguments.frequency);
}

int RunImport(const ImportArguments& arguments, const Session& session) {
  RequireImportFolder(arguments.output, session);
  ImportOptions options = arguments.options;
  options.name = arguments.output.BlockName();
  std::vector<SensorImage> images;
  for (const std::string& file : arguments.images) {
    Step(session.progress.get(), "read", images.size(), arguments.images.size(), "images");
    images.push_back(ReadImageFile(arguments, file));
  }
  std::vector<OrbitFile> orbits;
  for (const std::string& file : arguments.orbits) orbits.push_back(ReadOrbitFile(file));
  options.grid = RoleOf(arguments.grid);
  if (arguments.corners == CornerUse::kCheck) {
    if (!arguments.corner_sigma_m) {
      throw InputError("--corners",
                       "check needs --corner-sigma-m, how well the file places its corners");
    }
    options.corner_sigma_m = arguments.corner_sigma_m;
  }
  options.points = ReadMatches(arguments.matches);
  if (!arguments.reflectors.empty()) options.reflectors = ReadReflectors(arguments.reflectors);
  // Of several the id of the pass says which.
  const std::string only = arguments.images.size() == 1 ? arguments.images.front() : "";
  const ImportedBlock imported =
      Naming(only, [&] { return ImportProducts(images, orbits, options); });
  AdjustOptions own;
  own.groups = imported.corrections;
  own.priors = imported.priors;
  if (!WriteImported(arguments.output, imported.block, session, own)) return kAccepted;
  for (const FaultyRow& row : imported.faults) session.Say("warning: " + Describe(row));
  for (const std::string& warning : imported.warnings) session.Say("warning: " + warning);
  if (session.json) {
    fmt::print("{}\n", ImportJson(arguments, imported));
  } else {
    session.Show(DescribeImport(arguments, imported));
  }
  return kAccepted;
}

void AddGridOptions(CLI::App* command, ImportArguments* arguments) {
  ImportOptions& options = arguments->options;
  const std::map<std::string, GridUse> uses{{"none", GridUse::kNone},
                                            {"check", GridUse::kCheck},
                                            {"control", GridUse::kControl},
                                            {"tie", GridUse::kTie}};
  command
      ->add_option(
          "--grid",
          arguments->grid,
          "What grid points (of SICD: the scene centre) become: none, check, control or tie")
      ->transform(ChoiceOf(uses))
      ->default_str(arguments->kind == ImportKind::kSentinel1 ? "check" : "none");
  AddNumber(command,
            "--grid-sigma-m",
            &options.grid_sigma_m,
            "Standard deviation of the grid's positions, each axis");
  command
      ->add_option(
          "--max-misfit-m", options.max_misfit_m, "Grid points that fit the orbit worse are faulty")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
}

void AddCornerOptions(CLI::App* command, ImportArguments* arguments) {
  const std::map<std::string, CornerUse> uses{{"none", CornerUse::kNone},
                                              {"check", CornerUse::kCheck}};
  command
      ->add_option("--corners",
                   arguments->corners,
                   "What the corners of the image, as the file places them, become")
      ->transform(ChoiceOf(uses))
      ->default_str("none");
  AddNumber(command,
            "--corner-sigma-m",
            &arguments->corner_sigma_m,
            "Standard deviation of their positions, each axis: they are approximate");
}

void AddOrbitOptions(CLI::App* command, ImportArguments* arguments) {
  ImportOptions& options = arguments->options;
  if (arguments->kind != ImportKind::kNisar) {
    command->add_option("--orbit",
                        arguments->orbits,
                        "Orbit files (EOF) instead of the annotated orbits of Sentinel-1");
    command
        ->add_option("--orbit-margin-s",
                     options.orbit_margin_s,
                     "Of an orbit file, taken before and after the product")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
  }
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
}

void AddReflectorOptions(CLI::App* command, ImportArguments* arguments) {
  ImportOptions& options = arguments->options;
  command
      ->add_option("--reflectors",
                   arguments->reflectors,
                   "Table of corner reflectors (CSV), taken to the dates of the images")
      ->allow_extra_args(false);
  const std::map<std::string, PointRole> roles{{"control", PointRole::kControl},
                                               {"check", PointRole::kCheck}};
  command
      ->add_option(
          "--reflector-role", options.reflector_role, "What reflectors become: control or check")
      ->transform(ChoiceOf(roles))
      ->default_str("control");
  AddNumber(command,
            "--reflector-sigma-m",
            &options.reflector_sigma_m,
            "Standard deviation of their positions, each axis; check without it: exactly known");
}

const char* HelpOfFiles(ImportKind kind) {
  switch (kind) {
    case ImportKind::kSentinel1:
      return "Annotation files (XML), SLC or GRD";
    case ImportKind::kNisar:
      return "RSLC products (HDF5)";
    case ImportKind::kSicd:
      return "SICD images (NITF) or their metadata (XML)";
    case ImportKind::kImages:
      break;
  }
  return "Images of any kinds: Sentinel-1 annotations, RSLC of NISAR, SICD, cubes of ISIS, ISDs";
}

void AddOptions(CLI::App* command, ImportArguments* arguments) {
  ImportOptions& options = arguments->options;
  const ImportKind kind = arguments->kind;
  const bool sentinel1 = kind == ImportKind::kSentinel1;
  command->add_option(sentinel1 ? "annotations" : "images", arguments->images, HelpOfFiles(kind))
      ->required();
  AddMatchOptions(command, &arguments->matches);
  AddReflectorOptions(command, arguments);
  AddNumber(command,
            sentinel1 ? "--range-sigma-m,--sigma-range-m" : "--range-sigma-m",
            &options.range_sigma_m,
            "Of the looks' range (left out: a pixel, evenly spread)");
  AddNumber(command,
            sentinel1 ? "--azimuth-sigma-m,--sigma-azimuth-m" : "--azimuth-sigma-m",
            &options.azimuth_sigma_m,
            "Of the looks' azimuth (left out: a line, evenly spread)");
  if (kind == ImportKind::kNisar || kind == ImportKind::kImages) {
    const std::map<std::string, NisarFrequency> frequencies{{"A", NisarFrequency::kA},
                                                            {"B", NisarFrequency::kB}};
    command->add_option("--frequency", arguments->frequency, "Which image of an RSLC: A or B")
        ->transform(ChoiceOf(frequencies))
        ->default_str("A");
  }
  AddGridOptions(command, arguments);
  if (kind == ImportKind::kSicd) {
    AddCornerOptions(command, arguments);
  } else {
    AddOrbitOptions(command, arguments);
  }
  command->add_option("--id", options.pass_ids, "Ids of the passes, one an image");
  AddImportOutput(command, &arguments->output);
}

void AddImportOf(
    CLI::App* group, Session* session, ImportKind kind, const char* name, const char* help) {
  auto arguments = std::make_shared<ImportArguments>();
  arguments->kind = kind;
  if (kind != ImportKind::kSentinel1) arguments->grid = GridUse::kNone;
  CLI::App* const command = group->add_subcommand(name, help);
  AddOptions(command, arguments.get());
  command->callback([=] { session->run = [=] { return RunImport(*arguments, *session); }; });
}

}  // namespace

void AddImport(CLI::App* app, Session* session) {
  CLI::App* group = app->add_subcommand("import", "Make a block of products of others");
  group->require_subcommand(1);
  AddImportOf(group,
              session,
              ImportKind::kSentinel1,
              "sentinel1",
              "Of Sentinel-1 annotations: orbits, image rasters and geolocation grids");
  AddImportOf(group,
              session,
              ImportKind::kNisar,
              "nisar",
              "Of RSLC products of NISAR: orbits, image rasters, reflectors");
  AddImportOf(group,
              session,
              ImportKind::kSicd,
              "sicd",
              "Of SICD images: paths, image rasters, times and Dopplers of matched points");
  AddImportOf(group,
              session,
              ImportKind::kImages,
              "images",
              "Of images of several kinds and a table of points matched in them");
  AddNetworkImports(group, session);
}

}  // namespace sarblock::cli
