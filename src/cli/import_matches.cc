// SPDX-License-Identifier: Apache-2.0
#include "import_matches.h"

#include "sarblock/core/error.h"

#include <charconv>
#include <cmath>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace sarblock::cli {

void AddMatchOptions(CLI::App* command, MatchArguments* arguments) {
  command
      ->add_option("--points",
                   arguments->points,
                   "Table of matched points (CSV): point, image, line, sample")
      ->allow_extra_args(false);
  command->add_option("--points-origin",
                      arguments->origin,
                      "Line and sample of the first pixel's centre in that table, one number or "
                      "LINE,SAMPLE (left out: 0)");
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
    throw InputError(option,
                     "'" + text + "' is not allowed, a number or LINE,SAMPLE of -10 to 10 is");
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

}  // namespace sarblock::cli
