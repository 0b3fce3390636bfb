// SPDX-License-Identifier: Apache-2.0
#include "import.h"

#include "sarblock/core/error.h"
#include "sarblock/files/block_file.h"
#include "sarblock/tables/output.h"

#include <charconv>
#include <cmath>
#include <iterator>
#include <map>
#include <memory>
#include <vector>

#include "core/text.h"
#include "products/block_builder.h"
#include "products/image_table.h"
#include "products/import.h"
#include "products/network.h"
#include "program.h"
#include <fmt/format.h>
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

enum class ImportKind { kSentinel1, kNisar, kTerraSarX, kIceye, kSicd, kImages };

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

/// A kind of delay as people and files call it.
struct DelayKind {
  const char* name;
  const char* key;   ///< of JSON
  const char* unit;  ///< as printed
  double factor;     ///< from SI to it
  DelaySize ImageDelays::*size;
};
constexpr DelayKind kDelayKinds[] = {
    {"bistatic residual", "bistatic_s", "ms", 1e3, &ImageDelays::bistatic_s},
    {"mismatch of the FM rate", "fm_rate_s", "ms", 1e3, &ImageDelays::fm_rate_s},
    {"motion within the pulse", "pulse_motion_m", "m", 1.0, &ImageDelays::pulse_motion_m},
    {"troposphere", "troposphere_m", "m", 1.0, &ImageDelays::troposphere_m}};

std::string DescribeDelays(const ImportedProduct& product, const Pass& pass) {
  std::string text;
  for (const DelayKind& kind : kDelayKinds) {
    const DelaySize& size = product.delays.*kind.size;
    if (size.looks == 0) continue;
    text += fmt::format("  taken off: {} {:.3f} {} (mean of {} looks, {:.3f} to {:.3f})\n",
                        kind.name,
                        kind.factor * size.Mean(),
                        kind.unit,
                        size.looks,
                        kind.factor * size.least,
                        kind.factor * size.largest);
  }
  if (pass.reduction.troposphere == TroposphereModel::kStandard &&
      product.delays.troposphere_m.looks == 0) {
    text += "  taken off: troposphere, by the standard atmosphere\n";
  }
  if (product.grid_move_m.looks > 0) {
    text += fmt::format("  grid points moved by {:.2f} to {:.2f} m with their looks\n",
                        product.grid_move_m.least,
                        product.grid_move_m.largest);
  }
  return text;
}

nlohmann::json SizeJson(const DelaySize& size) {
  return {{"looks", size.looks},
          {"mean", size.Mean()},
          {"least", size.least},
          {"largest", size.largest}};
}

nlohmann::json DelaysJson(const ImportedProduct& product) {
  nlohmann::json delays = nlohmann::json::object();
  for (const DelayKind& kind : kDelayKinds) {
    const DelaySize& size = product.delays.*kind.size;
    if (size.looks > 0) delays[kind.key] = SizeJson(size);
  }
  return delays;
}

std::string DescribeTake(const DataTake& take) {
  return fmt::format(
      "{}: one data take, whose path errors are one shared position correction of {} m\n",
      fmt::join(take.passes, ", "),
      NumberText(take.path_sigma_m));
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
    if (!product.stated.empty()) text += "  " + product.stated + "\n";
    text += DescribeDelays(product, imported.block.passes[i]);
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
  for (const DataTake& take : imported.takes) text += DescribeTake(take);
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
                        {"stated", product.stated},
                        {"priors", product.priors},
                        {"taken_off", DelaysJson(product)},
                        {"grid_moved_m", SizeJson(product.grid_move_m)},
                        {"offset", OffsetJson(product.offset)}});
  }
  nlohmann::json takes = nlohmann::json::array();
  for (const DataTake& take : imported.takes) {
    takes.push_back({{"passes", take.passes},
                     {"path_sigma_m", take.path_sigma_m},
                     {"repeated_looks", take.repeated}});
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
                                  {"data_takes", takes},
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
    case ImportKind::kTerraSarX:
      return ReadTerraSarX(file);
    case ImportKind::kIceye:
      return ReadIceye(file);
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
  // Where there are several images, the id of the pass says which one is meant.
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
  const ImportKind kind = arguments->kind;
  if (kind == ImportKind::kSentinel1 || kind == ImportKind::kImages) {
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
      ->default_str(kind == ImportKind::kTerraSarX ? "positions"
                    : kind == ImportKind::kImages  ? "by the product"
                                                   : "states");
}

// NISAR and SICD do not say whether anything is left in their ranges.
void AddReductionOptions(CLI::App* command, ImportKind kind, ImportOptions* options) {
  const std::map<std::string, bool> choices{{"all", true}, {"none", false}};
  if (kind != ImportKind::kNisar && kind != ImportKind::kSicd) {
    command
        ->add_option("--reduce",
                     options->reduce,
                     "What is taken off ranges and times that is known to be in them beyond "
                     "geometry: all or none")
        ->transform(ChoiceOf(choices))
        ->default_str("all");
  }
  AddNumber(command,
            "--path-sigma-m",
            &options->path_sigma_m,
            "Prior of the path error that images of one flight share, each axis (default: 0.1; of "
            "an on-board orbit 1)");
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
    case ImportKind::kTerraSarX:
      return "Annotation files (XML) of products in slant range (SSC)";
    case ImportKind::kIceye:
      return "Metadata (XML) of images in ground range (GRD)";
    case ImportKind::kSicd:
      return "SICD images (NITF) or their metadata (XML)";
    case ImportKind::kImages:
      break;
  }
  return "Images of any kinds: annotations of Sentinel-1 and TerraSAR-X, ICEYE, RSLC of NISAR, "
         "SICD, "
         "cubes of "
         "ISIS, ISDs";
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
  if (kind != ImportKind::kIceye) AddGridOptions(command, arguments);
  if (kind == ImportKind::kSicd) {
    AddCornerOptions(command, arguments);
  } else {
    AddOrbitOptions(command, arguments);
  }
  AddReductionOptions(command, kind, &options);
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
  AddImportOf(
      group,
      session,
      ImportKind::kTerraSarX,
      "terrasarx",
      "Import TerraSAR-X, TanDEM-X and PAZ annotation files (orbit, raster, stated delays)");
  AddImportOf(group,
              session,
              ImportKind::kIceye,
              "iceye",
              "Import metadata of ICEYE images in ground range (orbit, raster)");
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

}  // namespace sarblock::cli
