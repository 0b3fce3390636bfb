// SPDX-License-Identifier: Apache-2.0
#include "sarblock/geometry/path.h"
#include "sarblock/io/adjust_table.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "adjust_table.h"
#include "block_image.h"
#include "block_reader.h"
#include "core/text.h"
#include "ellipsoid_reader.h"
#include "tables/toml.h"

namespace sarblock {
namespace {

constexpr const char* kBlockFormat = "sarblock-block 1";

Frame ReadFrame(const TomlTable& file) {
  const TomlTable table(file.Require("frame", "a table [frame] with kind"));
  table.RefuseOthers({"kind", "ellipsoid"});
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
      table.Find(key)->Fail("stands beside " + given + ", one of both is allowed");
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
        other->Fail(std::string("stands beside image.") + pixel_key + ", one of both is allowed");
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
                      "trajectory"});
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
    id.Fail("pass " + Quoted(pass.id) + " stands twice, first on line " +
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
  ReadImageGrid(table, &pass, reading);
  std::optional<std::array<double, 2>> span_s;
  const auto start = table.Find("start_s"), end = table.Find("end_s");
  if (start || end) {
    span_s = {table.Require("start_s", "with end_s the start of the strip").Number(),
              table.Require("end_s", "with start_s the end of the strip").Number()};
    if (!((*span_s)[0] < (*span_s)[1])) {
      end->Fail(NumberText((*span_s)[1]) +
                " is not allowed, an end after start_s = " + NumberText((*span_s)[0]) + " is");
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
  file.RefuseOthers({"format", "name", "frame", "sigma", "trajectory", "adjust", "pass"});
  ApplyOverrides(reading->options.set_overrides, &parsed);
  Block& block = reading->result.block;
  const auto block_name = file.Find("name");
  block.name = block_name ? block_name->Text() : reading->source.DefaultName();
  block.frame = ReadFrame(file);
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
  const TomlValue passes = file.Require("pass", "a table [[pass]] for every pass");
  for (const TomlValue& pass : passes.Entries()) {
    ReadPass(TomlTable(pass), standard, trajectory, reading);
  }
  if (block.passes.empty()) passes.Fail("is empty, a table [[pass]] for every pass is needed");
  std::vector<std::string> ids;
  for (const Pass& pass : block.passes) ids.push_back(pass.id);
  reading->result.adjust = ReadAdjust(file, ids);
}

}  // namespace sarblock
