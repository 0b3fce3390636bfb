// SPDX-License-Identifier: Apache-2.0
#include "block_image.h"

#include "sarblock/core/error.h"

#include <vector>

#include "core/text.h"

namespace sarblock {
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
  constexpr int kMostLines = 10'000'000;
  grid->lines_per_burst = static_cast<std::size_t>(
      table.Require("lines_per_burst", "with burst_start_s the lines of a burst")
          .Integer(1, kMostLines));
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

}  // namespace sarblock
