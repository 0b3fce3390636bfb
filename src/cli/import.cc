// SPDX-License-Identifier: Apache-2.0
#include "import.h"

#include "sarblock/core/error.h"
#include "sarblock/files/block_file.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <vector>

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

std::string ImportOutput::BlockName() const { return name.empty() ? NameAt(folder) : name; }

void AddImportOutput(CLI::App* command, ImportOutput* output) {
  command->add_option("-o,--output", output->folder, "Folder or .h5 file of the block to write")
      ->required();
  command->add_option("--name", output->name, "Name of the block (default: that of its folder)");
  command->add_flag("--gzip", output->gzip, "Write the tables compressed (.csv.gz, deflate)");
  AddForce(command, &output->foreign);
}

std::optional<OutputLock> RequireImportFolder(const ImportOutput& output, const Session& session) {
  if (session.dump_config) return std::nullopt;
  RequireFolderFor(FolderContent::kBlock, output.folder, output.foreign);
  return OutputLock(output.folder);
}

bool WriteImported(const ImportOutput& output,
                   const Block& block,
                   const Session& session,
                   const AdjustOptions& own) {
  std::vector<std::string> ids;
  for (const Pass& pass : block.passes) ids.push_back(pass.id);
  // `own.corrections` is "given", also with no table: then nothing is corrected until --set, here
  // or later, adds a group.
  const files::AdjustTable adjust =
      files::ReadAdjustTable(files::DumpAdjustTable(own), "import", ids, session.set);
  if (session.dump_config) {
    fmt::print("{}", files::DumpAdjustTable(adjust));
    return false;
  }
  files::WriteBlock(
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

void AddMatchOptions(CLI::App* command, MatchArguments* arguments) {
  command
      ->add_option("--points",
                   arguments->points,
                   "Table of matched points (CSV): point, image, line, sample")
      ->allow_extra_args(false);
  command->add_option("--points-origin",
                      arguments->origin,
                      "Line and sample of the first pixel's centre in that table, one number or "
                      "LINE,SAMPLE (default: 0)");
}

std::optional<MatchedPoints> ReadMatches(const MatchArguments& arguments) {
  if (arguments.points.empty()) {
    if (!arguments.origin.empty()) {
      throw InputError("points-origin", "is given without --points, whose pixels it counts");
    }
    return std::nullopt;
  }
  MatchedPoints points = ReadMatchedPoints(arguments.points);
  if (!arguments.origin.empty()) {
    points.origin_px = PixelOrigin("points-origin", arguments.origin);
  }
  return points;
}

std::array<double, 2> PixelOrigin(const std::string& option, const std::string& text) {
  std::array<double, 2> origin_px{};
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  std::size_t count = 0;
  while (count < origin_px.size()) {
    const auto [stop, error] = std::from_chars(at, end, origin_px[count]);
    if (error != std::errc() || !(std::abs(origin_px[count]) <= 10.0)) break;
    ++count;
    at = stop;
    if (at == end || *at != ',') break;
    ++at;
  }
  if (count == 0 || at != end) {
    throw InputError(option, "must be a number or LINE,SAMPLE of -10 to 10, got '" + text + "'");
  }
  if (count == 1) origin_px[1] = origin_px[0];
  return origin_px;
}

std::string DescribeMatches(std::size_t matches, const PixelOffset& offset) {
  std::string text = fmt::format("{} matched points", matches);
  if (offset.looks > 0) {
    text += fmt::format(
        ", {} of them {:.3f} lines and {:.3f} samples (median) from their given positions",
        offset.looks,
        offset.line_px,
        offset.sample_px);
  }
  return text;
}

nlohmann::json OffsetJson(const PixelOffset& offset) {
  const auto number = [](double value) {
    return std::isnan(value) ? nlohmann::json() : nlohmann::json(value);
  };
  return {{"looks", offset.looks},
          {"line_px", number(offset.line_px)},
          {"sample_px", number(offset.sample_px)}};
}

namespace {

enum class ImportKind { kSentinel1, kNisar, kSicd, kImages };

/// What grid points become; they are compared with the orbit in any case.
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

std::string DescribeGrid(const ImportedProduct& product) {
  const std::string fit =
      fmt::format("{}: {} of {} grid points fit the {}",
                  product.pass,
                  product.good,
                  product.grid_points,
                  !product.orbit_file.empty()    ? "orbit of " + product.orbit_file
                  : product.orbit_source.empty() ? "annotated orbit"
                                                 : product.orbit_source + " orbit");
  if (product.good == 0) return fit + "\n";
  return fmt::format("{} within {:.2f} mm in range, {:.1f} mm along track (mean {:.1f} mm)\n",
                     fit,
                     1e3 * product.largest_range_m,
                     1e3 * product.largest_along_m,
                     1e3 * product.mean_along_m);
}

std::string DescribeImport(const ImportArguments& arguments, const ImportedBlock& imported) {
  std::string text;
  const auto out = std::back_inserter(text);
  for (std::size_t i = 0; i < imported.products.size(); ++i) {
    const ImportedProduct& product = imported.products[i];
    text +=
        product.grid_points > 0 ? DescribeGrid(product) : product.pass + ": " + product.file + "\n";
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
                        {"orbit_file", product.orbit_file},
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
  const Sentinel1Use use{RoleOf(arguments.grid) ? PartUse::kUsed : PartUse::kCompared,
                         arguments.orbits.empty() ? PartUse::kUsed : PartUse::kCompared};
  switch (arguments.kind) {
    case ImportKind::kSentinel1:
      return ReadSentinel1(file, use);
    case ImportKind::kNisar:
      return ReadNisar(file, arguments.frequency, use.grid);
    case ImportKind::kSicd:
      return ReadSicd(file);
    case ImportKind::kImages:
      break;
  }
  return ReadSensorImage(file, arguments.frequency, use);
}

int RunImport(const ImportArguments& arguments, const Session& session) {
  const auto lock = RequireImportFolder(arguments.output, session);
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
  for (const FaultyRow& row : imported.faults) session.Warn("warning: " + Describe(row));
  for (const std::string& warning : imported.warnings) session.Warn("warning: " + warning);
  if (session.json) {
    fmt::print("{}\n", ImportJson(arguments, imported));
  } else {
    session.Print(DescribeImport(arguments, imported));
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
                     "Part of an orbit file used before and after the product")
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
            "Standard deviation of range (default: uniform within a pixel)");
  AddNumber(command,
            sentinel1 ? "--azimuth-sigma-m,--sigma-azimuth-m" : "--azimuth-sigma-m",
            &options.azimuth_sigma_m,
            "Standard deviation of azimuth (default: uniform within a line)");
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
  command->add_option("--id", options.pass_ids, "Ids of the passes, one per image");
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
  CLI::App* group = app->add_subcommand("import", "Make a block from SAR products");
  group->require_subcommand(1);
  AddImportOf(group,
              session,
              ImportKind::kSentinel1,
              "sentinel1",
              "Import Sentinel-1 annotation files (orbit, raster, geolocation grid)");
  AddImportOf(group,
              session,
              ImportKind::kNisar,
              "nisar",
              "Import NISAR RSLC products (orbit, raster, reflectors)");
  AddImportOf(group,
              session,
              ImportKind::kSicd,
              "sicd",
              "Import SICD images (path, raster, times and Dopplers of matched points)");
  AddImportOf(group,
              session,
              ImportKind::kImages,
              "images",
              "Import images of several kinds with a table of points matched in them");
  AddNetworkImports(group, session);
}

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

// Of the options and of the lines of lists; blank lines and those that begin with # are skipped.
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
