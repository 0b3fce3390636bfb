// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>

#include "products/block_builder.h"
#include <CLI/CLI.hpp>
#include <nlohmann/json_fwd.hpp>

namespace sarblock::cli {

/// A table of matched points as the command line names it; the same for every kind of image.
struct MatchArguments {
  std::string points, origin;
};

/// Adds --points and --points-origin.
void AddMatchOptions(CLI::App* command, MatchArguments* arguments);
/// Nothing where no table was given.
[[nodiscard]] std::optional<MatchedPoints> ReadMatches(const MatchArguments& arguments);

/// One number for line and sample, or LINE,SAMPLE. `option` is for messages.
[[nodiscard]] std::array<double, 2> PixelOrigin(const std::string& option, const std::string& text);

/// "12 matched points, 3 of which lie ... from their given positions".
[[nodiscard]] std::string DescribeMatches(std::size_t matches, const PixelOffset& offset);
[[nodiscard]] nlohmann::json OffsetJson(const PixelOffset& offset);

}  // namespace sarblock::cli
