// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/core/id_table.h"
#include "sarblock/files/block_file.h"
#include "sarblock/geometry/path.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <utility>
#include <vector>

#include "block/plausibility.h"
#include "block/read_recorded.h"
#include "block_parts.h"
#include "core/text.h"
#include "core/threads.h"
#include "correction_options.h"
#include "reduction/frames.h"
#include "tables/open.h"
#include "tables/toml.h"
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sarblock::files {

namespace {

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

/// An id as one that was typed again would be: without blanks (no-break ones too), zeros before
/// digits, and the difference of capitals.
std::string NearKey(std::string_view id) {
  std::string simple;
  for (std::size_t i = 0; i < id.size(); ++i) {
    if (id.substr(i).starts_with("\xC2\xA0")) {
      ++i;
    } else if (id[i] == '0' && (simple.empty() || !IsDigit(simple.back())) && i + 1 < id.size() &&
               IsDigit(id[i + 1])) {
      continue;
    } else if (id[i] != ' ' && id[i] != '\t') {
      simple += static_cast<char>(std::tolower(static_cast<unsigned char>(id[i])));
    }
  }
  return simple;
}

/// The id in quotes, with words for blanks that do not show.
std::string Shown(std::string_view id) {
  std::string shown(id);
  for (std::size_t at = 0; (at = shown.find("\xC2\xA0", at)) != std::string::npos;) {
    shown.replace(at, 2, "<no-break space>");
  }
  return Quoted(shown);
}

/// Warns of known points without a look whose names are nearly those of points that have looks and
/// do not stand in the table of points, of which there are `listed`.
void WarnOfNearNames(std::size_t listed, BlockReading* reading) {
  const Points& points = reading->result.block.points;
  const Looks& looks = reading->result.block.looks;
  std::map<std::string, std::uint32_t> missing;
  for (const KnownPosition& known : points.known) {
    if (looks.offsets[known.point] != looks.offsets[known.point + 1]) continue;
    missing.emplace(NearKey(points.ids[known.point]), known.point);
  }
  std::vector<std::string> pairs;
  std::size_t found = 0;
  for (std::size_t i = listed; i < points.size() && !missing.empty(); ++i) {
    const auto known = missing.find(NearKey(points.ids[i]));
    if (known == missing.end()) continue;
    constexpr std::size_t kNamed = 5;
    if (++found > kNamed) continue;
    pairs.push_back(Shown(points.ids[known->second]) + " and " + Shown(points.ids[i]));
  }
  if (found == 0) return;
  std::string text = fmt::format("{}", fmt::join(pairs, ", "));
  if (found > pairs.size()) text += fmt::format(" and {} more", found - pairs.size());
  reading->result.warnings.push_back(
      fmt::format("{} known point{} no look, and the observations have nearly the same name{}: {}; "
                  "are they the same points?",
                  found,
                  found == 1 ? " has" : "s have",
                  found == 1 ? "" : "s",
                  text));
}

/// Names that begin with # are comments where they are not quoted: known points would be lost
/// without a word.
void RefuseCommentedPoints(std::size_t listed, const BlockReading& reading) {
  if (!reading.commented_point) return;
  const IdTable& ids = reading.result.block.points.ids;
  for (std::size_t i = listed; i < ids.size(); ++i) {
    if (!ids[i].starts_with('#')) continue;
    throw InputError(*reading.commented_point,
                     "a line that begins with # is a comment, and the observations name a point " +
                         Quoted(ids[i]) +
                         " that no other line gives: names that begin with # "
                         "stand in quotes");
  }
}

void WarnOfRejectedPasses(BlockReading* reading) {
  const Block& block = reading->result.block;
  std::vector<std::size_t> looks(block.passes.size(), 0), taken(block.passes.size(), 0);
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    ++looks[block.looks.pass[i]];
    taken[block.looks.pass[i]] += block.looks.rejected(i) ? 0U : 1U;
  }
  for (std::size_t i = 0; i < looks.size(); ++i) {
    if (looks[i] == 0 || taken[i] > 0) continue;
    reading->result.warnings.push_back(
        fmt::format("pass {}: all {} looks are rejected, so it takes no part",
                    Quoted(block.passes[i].id),
                    looks[i]));
  }
}

/// Whether there are corrections of the path, all of them shared by the two passes.
bool SharePathCorrections(const AdjustTable& options,
                          const std::string& pass_a,
                          const std::string& pass_b) {
  std::size_t shared = 0;
  for (const CorrectionGroup& group : options.groups) {
    if (!std::holds_alternative<PositionCorrection>(group.model) &&
        !std::holds_alternative<VelocityCorrection>(group.model)) {
      continue;
    }
    const auto has = [&group](const std::string& id) {
      return group.passes.empty() ||
             std::find(group.passes.begin(), group.passes.end(), id) != group.passes.end();
    };
    const bool a = has(pass_a), b = has(pass_b);
    if (!a && !b) continue;
    if (!(a && b && group.shared)) return false;
    ++shared;
  }
  return shared > 0;
}

}  // namespace

BlockFile ReadBlockFrom(const TableSource& source, const ReadOptions& options) {
  BlockReading reading{source, options, {}, {}, {}, {}, {}};
  ReadBlockToml(&reading);
  ReadTrajectories(&reading);
  ReadPoints(&reading);
  const std::size_t listed = reading.result.block.points.size();
  ReadLooks(&reading);
  RefuseCommentedPoints(listed, reading);
  WarnOfNearNames(listed, &reading);
  WarnOfRejectedPasses(&reading);
  SetStripSpans(reading.strip_spans_s, &reading.result.block);
  RequireReductions(reading.result.block, reading.pass_places);
  if (options.contradictions == Contradictions::kRefuse) {
    RequireAboveGround(reading.result.block);
    RequireBodyFixedStates(reading.result.block);
  }
  for (std::string& warning : ReadRecordedFlights(&reading.result.block)) {
    reading.result.warnings.push_back(std::move(warning));
  }
  for (std::string& remark : DoubtsOfReductions(reading.result.block)) {
    reading.result.warnings.push_back(std::move(remark));
  }
  for (std::string& remark : ExaminePlausibility(reading.result.block)) {
    reading.result.warnings.push_back(std::move(remark));
  }
  const AdjustTable& adjust = reading.result.adjust;
  for (std::string& remark :
       FindSameFlights(reading.result.block, [&](std::size_t a, std::size_t b) {
         return SharePathCorrections(
             adjust, reading.result.block.passes[a].id, reading.result.block.passes[b].id);
       })) {
    reading.result.warnings.push_back(std::move(remark));
  }
  for (std::string& remark : FindSameKnownPoints(reading.result.block)) {
    reading.result.warnings.push_back(std::move(remark));
  }
  const Copies copies = FindCopiedPasses(reading.result.block);
  CountOnce(copies, &reading.result.block);
  for (const std::string& remark : copies.remarks) reading.result.warnings.push_back(remark);
  reading.result.block.points.ids.DropIndex();
  return std::move(reading.result);
}

BlockFile ReadBlock(const std::filesystem::path& folder, const ReadOptions& options) {
  const CancellationScope scope(options.progress);
  return ReadBlockFrom(*TablesAt(folder, FolderContent::kBlock), options);
}

BlockFile ReadBlockTexts(const BlockTexts& texts, const ReadOptions& options) {
  return ReadBlockFrom(*TablesOfTexts({{"block.toml", texts.block_toml},
                                       {"trajectories.csv", texts.trajectories_csv},
                                       {"observations.csv", texts.observations_csv},
                                       {"points.csv", texts.points_csv}},
                                      FolderContent::kBlock),
                       options);
}

std::uint32_t IdFinder::Find(const Row& row, std::size_t column) {
  return found_.Of(row, column, [&] {
    const std::string_view id = row.Id(column);
    const std::uint32_t found = ids_.Find(id);
    if (found == IdTable::kNone) {
      row.Fail(column,
               std::string(holder_) + " has no " + noun_ + " " + Quoted(id) +
                   DidYouMean(ids_.Nearest(id)));
    }
    return found;
  });
}

double LengthNumber(const Row& row, std::size_t column) {
  const double value_m = row.Number(column);
  if (std::abs(value_m) > kLargestLength_m) {
    row.Fail(column,
             "must be at most " + NumberText(kLargestLength_m) + " m, got " + NumberText(value_m) +
                 " m");
  }
  return value_m;
}

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
      table.Require("lines_per_burst", "with burst_start_s the lines of a burst")
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

class ArrayReader final : public TableReader {
 public:
  ArrayReader(const ArrayTable& table, Schema schema)
      : TableReader(table.name, schema),
        table_(table),
        rows_(table.columns.empty() ? 0 : table.columns.front().rows()),
        arrays_(schema.size()) {
    for (const ArrayColumn& array : table.columns) {
      const auto known = std::find(names_.begin(), names_.end(), array.name);
      if (known == names_.end()) {
        unknown_.push_back(array.name);
      } else {
        OpenArray(static_cast<std::size_t>(known - names_.begin()), array);
      }
    }
    RequireColumns();
  }

  bool Next(Batch* batch) override {
    if (next_ == rows_) return false;
    batch->first = next_;
    next_ += std::min(rows_ - next_, kRowsAtOnce);
    return true;
  }
  void Parse(Batch* batch) const override {
    batch->Begin(schema_);
    batch->table = this;
    batch->rows = std::min(rows_ - batch->first, kRowsAtOnce);
    for (std::size_t i = 0; i < schema_.size(); ++i) {
      Column& column = batch->columns[i];
      column.texts = Has(i) ? arrays_[i]->texts.get() : nullptr;
      if (!Has(i)) continue;
      const auto copy = [&](const auto& from, auto* to) {
        const auto rows = from.subspan(batch->first, batch->rows);
        to->assign(rows.begin(), rows.end());
      };
      if (column.texts == nullptr) {
        copy(arrays_[i]->cells, &column.numbers);
        continue;
      }
      copy(arrays_[i]->indices, &column.indices);
      if (IsText(schema_[i].kind)) continue;
      for (const std::uint32_t text : column.indices) {  // numbers are asked for
        column.numbers.push_back(NumberOfText((*column.texts)[text], schema_[i].kind));
      }
      column.texts = nullptr;
    }
  }
  std::size_t RowsLeft() const override { return rows_ - next_; }
  std::string TextOfCell(const Row& row, std::size_t column) const override {
    const ArrayColumn& array = *arrays_[column];
    const std::size_t cell = row.line() - 1;
    return array.texts != nullptr ? std::string((*array.texts)[array.indices[cell]])
                                  : NumberText(array.cells[cell]);
  }
  FilePlace PlaceAt(std::size_t line, std::size_t column) const override {
    std::string field = file_ + "." + names_[column];
    if (line > 0) field += "[" + std::to_string(line - 1) + "]";
    return {{}, 0, std::move(field)};
  }
  std::string NameOfLine(std::size_t line) const override {
    return "row " + std::to_string(line - 1);
  }

 private:
  void OpenArray(std::size_t column, const ArrayColumn& array) {
    const FilePlace place = PlaceAt(0, column);
    if (Has(column)) throw InputError(place, "is given twice; one column only");
    if (array.rows() != rows_) {
      throw InputError(place,
                       "has " + std::to_string(array.rows()) + " rows where " + file_ + "." +
                           table_.columns.front().name + " has " + std::to_string(rows_) +
                           ", as many are needed");
    }
    arrays_[column] = &array;
    place_[column] = column;
    for (std::size_t row = 0; array.texts != nullptr && row < rows_; ++row) {
      if (array.indices[row] < array.texts->size()) continue;
      throw InputError(PlaceAt(row + 1, column),
                       "must be an index below " + std::to_string(array.texts->size()) +
                           ", the number of texts, got " + std::to_string(array.indices[row]));
    }
    if (array.texts == nullptr && IsText(schema_[column].kind)) {
      throw InputError(place, "holds numbers, texts are needed");
    }
    for (std::size_t row = 0; row < array.cells.size(); ++row) {
      if (!std::isinf(array.cells[row])) continue;
      throw InputError(PlaceAt(row + 1, column),
                       "must be a finite number, got " + NumberText(array.cells[row]));
    }
  }
  std::string ColumnsThere() const override {
    std::string text = "there are ";
    for (const ArrayColumn& column : table_.columns) {
      text += (&column == &table_.columns.front() ? "" : ",") + column.name;
    }
    return text;
  }

  const ArrayTable& table_;
  std::size_t rows_;
  std::vector<const ArrayColumn*> arrays_;  // by column; null: not there
  std::size_t next_ = 0;
};

class ArraySource final : public TableSource {
 public:
  explicit ArraySource(const BlockArrays& arrays)
      : TableSource(FolderContent::kBlock), arrays_(arrays) {}
  std::pair<std::string, std::string> Read(std::string_view file) const override {
    return {std::string(file), std::string(arrays_.block_toml)};
  }
  std::unique_ptr<TableReader> Open(std::string_view table, Schema schema) const override {
    for (const ArrayTable& held : arrays_.tables) {
      if (held.name == table) return std::make_unique<ArrayReader>(held, schema);
    }
    return nullptr;
  }
  std::string NameOf(std::string_view table) const override { return std::string(table); }
  std::string DefaultName() const override { return "block"; }

 private:
  const BlockArrays& arrays_;
};

}  // namespace

BlockFile ReadBlockArrays(const BlockArrays& arrays, const ReadOptions& options) {
  return ReadBlockFrom(ArraySource(arrays), options);
}

}  // namespace sarblock::files
