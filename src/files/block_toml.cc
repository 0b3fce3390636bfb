// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/core/id_table.h"
#include "sarblock/core/statistics.h"
#include "sarblock/files/block_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "block_file.h"
#include "core/text.h"
#include "correction_options.h"
#include "reduction/frames.h"
#include "reduction/reduction.h"
#include "tables/toml.h"

namespace sarblock::files {
namespace {

std::vector<double> Numbers(const TomlValue& list) {
  std::vector<double> numbers;
  for (const TomlValue& entry : list.Entries()) numbers.push_back(entry.Number());
  return numbers;
}

// A list of numbers is one polynomial; a list of tables is one a time.
std::vector<GroundRangePolynomial> ReadGroundRange(const TomlValue& value) {
  const std::vector<TomlValue> entries = value.Entries();
  if (entries.empty()) value.Fail("is empty, the coefficients c0, c1, ... are needed");
  if (entries.front().IsNumber()) return {{0.0, 0.0, Numbers(value)}};
  std::vector<GroundRangePolynomial> all;
  for (const TomlValue& entry : entries) {
    const TomlTable table(entry);
    table.RefuseOthers({"time_s", "origin_m", "coefficients"});
    GroundRangePolynomial polynomial;
    polynomial.coefficients = Numbers(table.Require("coefficients", "a list c0, c1, ..."));
    const auto origin = table.Find("origin_m"), time = table.Find("time_s");
    if (origin) polynomial.origin_m = origin->Number();
    if (time) polynomial.time_s = time->Number();
    if (!time && entries.size() > 1) {
      static_cast<void>(table.Require("time_s", "with several polynomials the time of each"));
    }
    all.push_back(std::move(polynomial));
  }
  return all;
}

void ReadLines(const TomlTable& table, ImageGrid* grid) {
  grid->line_interval_s = table.Require("line_interval_s", "the time from line to line").Positive();
  const auto bursts = table.Find("burst_start_s");
  if (!bursts) {
    grid->first_line_s = table.Require("first_line_s", "the time of line 0").Number();
    return;
  }
  grid->burst_start_s = Numbers(*bursts);
  if (grid->burst_start_s.empty()) bursts->Fail("is empty, the time of every burst is needed");
  constexpr int kMaxLines = 10'000'000;
  grid->lines_per_burst = static_cast<std::size_t>(
      table.Require("lines_per_burst", "with burst_start_s the number of lines of a burst")
          .Integer(1, kMaxLines));
  const auto first = table.Find("first_line_s");
  grid->first_line_s = first ? first->Number() : grid->burst_start_s.front();
}

std::string ListText(const std::vector<double>& numbers) {
  std::string text = "[";
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    text += (i > 0 ? ", " : "") + NumberText(numbers[i]);
  }
  return text + "]";
}

}  // namespace

ImageGrid ReadImageTable(const TomlTable& table, PixelSigma* sigma) {
  table.RefuseOthers({"presentation",
                      "first_line_s",
                      "line_interval_s",
                      "near_range_m",
                      "range_spacing_m",
                      "ground_range",
                      "burst_start_s",
                      "lines_per_burst",
                      "line_sigma_px",
                      "pixel_sigma_px"});
  ImageGrid grid;
  const std::vector<std::string> names{"slant", "ground"};
  const bool slant = table.Require("presentation", Listed(names)).OneOf(names) == 0;
  grid.presentation = slant ? Presentation::kSlant : Presentation::kGround;
  ReadLines(table, &grid);
  grid.range_spacing_m =
      table.Require("range_spacing_m", "the range from pixel to pixel").Positive();
  if (slant) {
    grid.near_range_m = table.Require("near_range_m", "the slant range of pixel 0").Positive();
  } else if (const auto near = table.Find("near_range_m")) {
    grid.near_range_m = near->Number();
  }
  if (const auto polynomial = table.Find("ground_range")) {
    grid.ground_range = ReadGroundRange(*polynomial);
  }
  try {
    CheckImageGrid(grid);
  } catch (const InputError& error) {
    const std::string text = error.what();  // "key: problem"
    const std::size_t colon = text.find(": ");
    const std::string key = text.substr(0, colon);
    FilePlace place = table.PlaceOf(key);
    if (const auto value = table.Find(key.substr(0, key.find('[')))) {
      place.line = value->Place().line;
    }
    throw InputError(place, text.substr(colon + 2));
  }
  if (const auto value = table.FindPositive("line_sigma_px")) sigma->line_px = *value;
  if (const auto value = table.FindPositive("pixel_sigma_px")) sigma->pixel_px = *value;
  return grid;
}

std::string ImageTableText(const ImageGrid& grid) {
  const bool slant = grid.presentation == Presentation::kSlant;
  std::string text = "[pass.image]\npresentation = ";
  text += slant ? "\"slant\"\n" : "\"ground\"\n";
  text += "first_line_s = " + NumberText(grid.first_line_s) + "\n";
  text += "line_interval_s = " + NumberText(grid.line_interval_s) + "\n";
  text += "near_range_m = " + NumberText(grid.near_range_m) + "\n";
  text += "range_spacing_m = " + NumberText(grid.range_spacing_m) + "\n";
  if (!grid.burst_start_s.empty()) {
    text += "burst_start_s = " + ListText(grid.burst_start_s) + "\n";
    text += "lines_per_burst = " + std::to_string(grid.lines_per_burst) + "\n";
  }
  for (const GroundRangePolynomial& polynomial : grid.ground_range) {
    text += "[[pass.image.ground_range]]\ntime_s = " + NumberText(polynomial.time_s) + "\n";
    text += "origin_m = " + NumberText(polynomial.origin_m) + "\n";
    text += "coefficients = " + ListText(polynomial.coefficients) + "\n";
  }
  return text;
}

namespace {

bool SameIgnoringCase(const std::string& a, const std::string& b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; };
  return std::equal(
      a.begin(), a.end(), b.begin(), b.end(), [&](char x, char y) { return lower(x) == lower(y); });
}

}  // namespace

std::optional<Swath> ReadSwath(
    const std::function<std::optional<TomlValue>(const std::string&)>& find) {
  std::optional<Swath> swath;
  std::string given;
  for (std::size_t kind = 0; kind < kSwathKeys.size(); ++kind) {
    const auto value = find(kSwathKeys[kind].key);
    if (!value) continue;
    if (!given.empty()) value->Fail("excludes " + given + "; give one of both");
    given = kSwathKeys[kind].key;
    const std::vector<double> limits = Numbers(*value);
    if (limits.size() != 2) {
      value->Fail("is a list of " + std::to_string(limits.size()) +
                  ", a list of 2 numbers is needed");
    }
    const double unit = kSwathKeys[kind].factor;
    swath = Swath{static_cast<SwathKind>(kind), {limits[0] * unit, limits[1] * unit}};
    if (const auto problem = ProblemOf(*swath)) value->Fail(*problem);
  }
  return swath;
}

Ellipsoid ReadEllipsoid(const TomlValue& value) {
  if (value.IsText()) {
    const std::string text = value.Text();
    for (const std::string& name : EllipsoidNames()) {
      if (SameIgnoringCase(name, text)) return NamedEllipsoid(name);
    }
    value.Fail(Quoted(text) + " is not known, " + Listed(EllipsoidNames()) +
               " or { a_m = ..., f = ... } is allowed" +
               DidYouMean(NearestName(text, EllipsoidNames())));
  }
  const TomlTable table(value);
  table.RefuseOthers({"a_m", "f"});
  Ellipsoid ellipsoid;
  ellipsoid.name = "custom";
  ellipsoid.a_m = table.Require("a_m", "the equatorial radius in metres").Positive();
  const TomlValue flattening = table.Require("f", "the flattening (a - b)/a");
  ellipsoid.flattening = flattening.Number();
  if (!(ellipsoid.flattening >= 0.0 && ellipsoid.flattening < 1.0)) {
    flattening.Fail("must be 0 <= f < 1, got " + NumberText(ellipsoid.flattening));
  }
  return ellipsoid;
}

namespace {

constexpr const char* kBlockFormat = "sarblock-block 1";

// Which realization positions refer to, and when.
void ReadRealization(const TomlTable& table, Block* block) {
  const auto realization = table.Find("realization"), epoch = table.Find("epoch");
  for (const auto& value : {realization, epoch}) {
    if (value && !IsEarth(block->frame)) {
      value->Fail("belongs to geocentric frames of the Earth, this one has none");
    }
  }
  const auto checked = [](const TomlValue& value, const auto& read) {
    try {
      read();
    } catch (const InputError& error) {
      value.Fail(error.problem());
    }
  };
  if (realization) {
    checked(*realization,
            [&] { block->realization = ReferenceFrames().Named(realization->Text()); });
  }
  if (epoch) {
    block->epoch_year = epoch->Number();
    checked(*epoch, [&] { RequireEpoch(block->epoch_year); });
  }
}

Frame ReadFrame(const TomlTable& file) {
  const TomlTable table(file.Require("frame", "a table [frame] with kind"));
  table.RefuseOthers({"kind", "ellipsoid", "realization", "epoch"});
  const std::vector<std::string> kinds{"local", "geocentric"};
  const bool local = table.Require("kind", Listed(kinds)).OneOf(kinds) == 0;
  if (!local) return Frame::Geocentric(ReadEllipsoid(table.Require("ellipsoid", "its name")));
  if (const auto ellipsoid = table.Find("ellipsoid")) {
    ellipsoid->Fail("belongs to kind = \"geocentric\", a local frame has none");
  }
  return Frame::Local();
}

// Overrides the parts of `sigma` that the table gives. `suffix` is "" or "_sigma".
void ReadLookSigma(const TomlTable& table, const std::string& infix, LookSigma* sigma) {
  if (const auto range_m = table.FindPositive("range" + infix + "_m")) sigma->range_m = *range_m;
  std::string given;
  for (const auto& [key, unit] : {std::pair{"azimuth" + infix + "_m", AzimuthUnit::kMetres},
                                  std::pair{"azimuth" + infix + "_s", AzimuthUnit::kSeconds},
                                  std::pair{"doppler" + infix + "_hz", AzimuthUnit::kHertz}}) {
    const auto value = table.FindPositive(key);
    if (!value) continue;
    if (!given.empty()) {
      table.Find(key)->Fail("excludes " + given + "; give one of both");
    }
    given = key;
    sigma->azimuth = *value;
    sigma->azimuth_unit = unit;
  }
}

// Overrides the parts that the table gives.
void ReadTrajectoryTable(const TomlTable& table, TrajectoryOptions* options) {
  table.RefuseOthers({"through", "sigma_m", "sigma_mps"});
  if (const auto through = table.Find("through")) {
    std::vector<std::string> names;
    for (const PathThrough way : kPathsThrough) names.emplace_back(NameOf(way));
    options->through = kPathsThrough[through->OneOf(names)];
  }
  if (const auto value = table.FindPositive("sigma_m")) options->sigma.position_m = *value;
  if (const auto value = table.FindPositive("sigma_mps")) options->sigma.velocity_mps = *value;
}

// The raster of the pass. Standard deviations in pixels become those of the pass, but for pixels of
// a ground presentation, whose size in range differs from look to look.
void ReadImageGrid(const TomlTable& table, Pass* pass, BlockReading* reading) {
  PixelSigma sigma;
  if (const auto image = table.Find("image")) {
    pass->image = ReadImageTable(TomlTable(*image), &sigma);
    const auto refuse_both = [&table](bool in_pixels, const char* key, const char* pixel_key) {
      const auto other = table.Find(key);
      if (in_pixels && other) {
        other->Fail(std::string("excludes image.") + pixel_key + "; give one of both");
      }
    };
    refuse_both(!std::isnan(sigma.line_px), "azimuth_sigma_m", "line_sigma_px");
    refuse_both(!std::isnan(sigma.line_px), "azimuth_sigma_s", "line_sigma_px");
    refuse_both(!std::isnan(sigma.line_px), "doppler_sigma_hz", "line_sigma_px");
    refuse_both(!std::isnan(sigma.pixel_px), "range_sigma_m", "pixel_sigma_px");
    if (!std::isnan(sigma.line_px)) {
      pass->sigma.azimuth = sigma.line_px * pass->image->line_interval_s;
      pass->sigma.azimuth_unit = AzimuthUnit::kSeconds;
    }
    if (pass->image->presentation == Presentation::kSlant && !std::isnan(sigma.pixel_px)) {
      pass->sigma.range_m = sigma.pixel_px * pass->image->range_spacing_m;
      sigma.pixel_px = kNotGiven;
    }
  }
  reading->pixel_sigma_px.push_back(sigma.pixel_px);
}

void ReadPass(const TomlTable& table,
              const LookSigma& standard,
              const TrajectoryOptions& trajectory,
              const ReductionModels& reduction,
              BlockReading* reading) {
  table.RefuseOthers({"id",
                      "look",
                      "wavelength_m",
                      "range_sigma_m",
                      "azimuth_sigma_m",
                      "azimuth_sigma_s",
                      "doppler_sigma_hz",
                      "start_s",
                      "end_s",
                      "epoch_utc",
                      "image",
                      "trajectory",
                      "reduction",
                      "squint_deg",
                      "swath_look_deg",
                      "swath_ground_m",
                      "swath_range_m"});
  Pass pass;
  const TomlValue id = table.Require("id", "the name of the pass");
  pass.id = id.Text();
  if (pass.id.empty()) id.Fail("is empty, a name is needed");
  const auto control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
  if (std::any_of(pass.id.begin(), pass.id.end(), control)) {
    id.Fail("the name holds a control character, which is not allowed");
  }
  const std::uint32_t other = reading->pass_ids.Find(pass.id);
  if (other != IdTable::kNone) {
    id.Fail("pass " + Quoted(pass.id) + " is given twice, first on line " +
            std::to_string(reading->pass_places[other].line));
  }
  reading->pass_ids.FindOrAppend(pass.id);
  reading->pass_places.push_back(id.Place());
  const bool left = table.Require("look", "left or right").OneOf({"left", "right"}) == 0;
  pass.side = left ? LookSide::kLeft : LookSide::kRight;
  if (const auto value = table.FindPositive("wavelength_m")) pass.wavelength_m = *value;
  pass.sigma = standard;
  ReadLookSigma(table, "_sigma", &pass.sigma);
  if (const auto value = table.Find("epoch_utc")) pass.epoch_utc = value->Text();
  pass.recorded.asked = trajectory;
  if (const auto own = table.Find("trajectory")) {
    ReadTrajectoryTable(TomlTable(*own), &pass.recorded.asked);
  }
  pass.reduction = reduction;
  if (const auto own = table.Find("reduction")) {
    pass.reduction = ReadReduction(TomlTable(*own), reduction);
  }
  ReadImageGrid(table, &pass, reading);
  pass.swath = ReadSwath([&table](const std::string& key) { return table.Find(key); });
  if (const auto squint = table.Find("squint_deg")) {
    if (!(std::abs(squint->Number()) < 90.0)) {
      squint->Fail("must be between -90 and 90, got " + NumberText(squint->Number()));
    }
    pass.squint_rad = squint->Number() * kRadPerDeg;
  }
  std::optional<std::array<double, 2>> span_s;
  const auto start = table.Find("start_s"), end = table.Find("end_s");
  if (start || end) {
    span_s = {table.Require("start_s", "with end_s the start of the strip").Number(),
              table.Require("end_s", "with start_s the end of the strip").Number()};
    if (!((*span_s)[0] < (*span_s)[1])) {
      end->Fail("must be after start_s = " + NumberText((*span_s)[0]) + ", got " +
                NumberText((*span_s)[1]));
    }
  }
  reading->strip_spans_s.push_back(span_s);
  reading->result.block.passes.push_back(std::move(pass));
}

}  // namespace

void ReadBlockToml(BlockReading* reading) {
  const auto [name, text] = reading->source.Read("block.toml");
  toml::table parsed = ParseToml(text, name);
  const TomlTable file(parsed, "");
  const TomlValue format = file.Require("format", std::string("format = \"") + kBlockFormat + "\"");
  if (format.Text() != kBlockFormat) {
    format.Fail(Quoted(format.Text()) + " is not known, \"" + kBlockFormat + "\" is allowed");
  }
  file.RefuseOthers(
      {"format", "name", "frame", "sigma", "trajectory", "reduction", "adjust", "pass"});
  ApplyOverrides(reading->options.set_overrides, &parsed);
  Block& block = reading->result.block;
  const auto block_name = file.Find("name");
  block.name = block_name ? block_name->Text() : reading->source.DefaultName();
  block.frame = ReadFrame(file);
  ReadRealization(TomlTable(*file.Find("frame")), &block);
  LookSigma standard;
  if (const auto sigma = file.Find("sigma")) {
    const TomlTable table(*sigma);
    table.RefuseOthers({"range_m", "azimuth_m", "azimuth_s", "doppler_hz"});
    ReadLookSigma(table, "", &standard);
  }
  TrajectoryOptions trajectory;
  if (const auto given = file.Find("trajectory")) {
    ReadTrajectoryTable(TomlTable(*given), &trajectory);
  }
  ReductionModels reduction;
  if (const auto given = file.Find("reduction")) {
    reduction = ReadReduction(TomlTable(*given), reduction);
  }
  const TomlValue passes = file.Require("pass", "a table [[pass]] for every pass");
  for (const TomlValue& pass : passes.Entries()) {
    ReadPass(TomlTable(pass), standard, trajectory, reduction, reading);
  }
  if (block.passes.empty()) passes.Fail("is empty, a table [[pass]] for every pass is needed");
  std::vector<std::string> ids;
  for (const Pass& pass : block.passes) ids.push_back(pass.id);
  reading->result.adjust = ReadAdjust(file, ids);
}

namespace {

void ReadTroposphere(const TomlValue& value, ReductionModels* models) {
  if (value.IsText()) {
    models->troposphere = value.OneOf({"none", "standard"}) == 0 ? TroposphereModel::kNone
                                                                 : TroposphereModel::kStandard;
    return;
  }
  const TomlTable table(value);
  table.RefuseOthers({"pressure_hpa", "temperature_k", "humidity_1", "height_m"});
  models->troposphere = TroposphereModel::kWeather;
  models->weather.pressure_hpa =
      table.Require("pressure_hpa", "the air pressure in hectopascal").Number();
  models->weather.temperature_k =
      table.Require("temperature_k", "the temperature in kelvin").Number();
  models->weather.humidity = table.Require("humidity_1", "the relative humidity, 0 to 1").Number();
  const auto height = table.Find("height_m");
  models->weather.height_m = height ? height->Number() : 0.0;
}

void ReadIonosphere(const TomlValue& value, ReductionModels* models) {
  if (value.IsText()) {
    static_cast<void>(value.OneOf({"none"}));
    models->ionosphere.reset();
    return;
  }
  const TomlTable table(value);
  table.RefuseOthers({"tec_tecu", "share_1"});
  Ionosphere& ionosphere = models->ionosphere.emplace();
  ionosphere.tec_tecu = table.Require("tec_tecu", "the vertical electron content in TECU").Number();
  if (const auto share = table.Find("share_1")) ionosphere.share = share->Number();
}

}  // namespace

const std::vector<std::string>& ReductionKeys() {
  static const std::vector<std::string> keys{
      "troposphere", "ionosphere", "tide", "range_m", "time_s"};
  return keys;
}

ReductionModels ReadReduction(const TomlTable& table, const ReductionModels& standard) {
  table.RefuseOthers(ReductionKeys());
  ReductionModels models = standard;
  if (const auto value = table.Find("troposphere")) ReadTroposphere(*value, &models);
  if (const auto value = table.Find("ionosphere")) ReadIonosphere(*value, &models);
  if (const auto value = table.Find("tide")) {
    models.solid_tide = value->OneOf({"none", "solid"}) == 1;
  }
  if (const auto value = table.Find("range_m")) models.range_m = value->Number();
  if (const auto value = table.Find("time_s")) models.time_s = value->Number();
  return models;
}

std::string ReductionText(const ReductionModels& models, std::string_view name) {
  if (models == ReductionModels{}) return "";
  std::string text = "[" + std::string(name) + "]\n";
  if (models.troposphere == TroposphereModel::kStandard) text += "troposphere = \"standard\"\n";
  if (models.troposphere == TroposphereModel::kWeather) {
    const Weather& weather = models.weather;
    text += "troposphere = { pressure_hpa = " + NumberText(weather.pressure_hpa) +
            ", temperature_k = " + NumberText(weather.temperature_k) +
            ", humidity_1 = " + NumberText(weather.humidity);
    if (weather.height_m != 0.0) text += ", height_m = " + NumberText(weather.height_m);
    text += " }\n";
  }
  if (models.ionosphere) {
    text += "ionosphere = { tec_tecu = " + NumberText(models.ionosphere->tec_tecu) +
            ", share_1 = " + NumberText(models.ionosphere->share) + " }\n";
  }
  if (models.solid_tide) text += "tide = \"solid\"\n";
  if (models.range_m != 0.0) text += "range_m = " + NumberText(models.range_m) + "\n";
  if (models.time_s != 0.0) text += "time_s = " + NumberText(models.time_s) + "\n";
  return text;
}

std::vector<std::string> DoubtsOfReductions(const Block& block) {
  const Looks& looks = block.looks;
  // The atmosphere makes ranges longer by decimetres or more; motion within the pulse is below half
  // a metre of either sign. Sentinel-1's times are off by half a millisecond.
  constexpr double kWrongSign_m = -1.0, kSeconds_m = 1e-5, kMilliseconds_s = 0.01;
  std::vector<std::vector<double>> ranges_m(block.passes.size()), times_s(block.passes.size());
  for (std::size_t i = 0; i < looks.size(); ++i) {
    if (looks.rejected(i)) continue;
    if (!looks.range_delay_m.empty()) ranges_m[looks.pass[i]].push_back(looks.range_delay_m[i]);
    if (!looks.time_shift_s.empty()) times_s[looks.pass[i]].push_back(looks.time_shift_s[i]);
  }
  std::vector<std::string> doubts;
  for (std::size_t pass = 0; pass < block.passes.size(); ++pass) {
    const auto say = [&](const char* column, double value, const char* unit, const char* doubt) {
      doubts.push_back("pass " + Quoted(block.passes[pass].id) + ": " + column + " is " +
                       Digits(value, 3) + unit + " in the median: " + doubt);
    };
    if (!ranges_m[pass].empty()) {
      const double median_m = Median(std::move(ranges_m[pass]));
      if (median_m < kWrongSign_m) {
        say("range_delay_m", median_m, " m", "what makes ranges too long is positive");
      } else if (median_m != 0.0 && std::abs(median_m) < kSeconds_m) {
        say("range_delay_m", median_m, " m", "one-way metres are needed, are these seconds?");
      }
    }
    if (times_s[pass].empty()) continue;
    const double median_s = Median(std::move(times_s[pass]));
    if (std::abs(median_s) > kMilliseconds_s) {
      say("time_shift_s", median_s, " s", "seconds are needed, are these milliseconds or metres?");
    }
  }
  return doubts;
}

void RequireReductions(const Block& block, const std::vector<FilePlace>& places) {
  const auto problem = FindProblem(block, ModelsOf(block));
  if (!problem) return;
  FilePlace place = places[problem->pass];
  place.field = "pass[" + std::to_string(problem->pass) + "]." + problem->key;
  throw InputError(place, problem->problem);
}

}  // namespace sarblock::files
