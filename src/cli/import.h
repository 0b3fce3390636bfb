// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/options.h"

#include <array>
#include <cstddef>
#include <optional>
#include <string>

#include "products/block_builder.h"
#include "session.h"
#include <CLI/CLI.hpp>
#include <nlohmann/json_fwd.hpp>

namespace sarblock::cli {

/// Where and how an imported block is written; the same for every kind of product.
struct ImportOutput {
  std::string folder, name;
  bool gzip = false;
  ForeignFiles foreign = ForeignFiles::kRefuse;

  /// `name`, or the folder's own where none was given.
  [[nodiscard]] std::string BlockName() const;
};

/// Adds -o, --name, --gzip and --force.
void AddImportOutput(CLI::App* command, ImportOutput* output);

/// Refuses a folder that the block cannot be written to, before anything is read, and keeps it for
/// this run. Nothing with --dump-config.
[[nodiscard]] std::optional<OutputLock> RequireImportFolder(const ImportOutput& output,
                                                            const Session& session);

/// Writes the block with the `[adjust]` table that `own` and --set ask for. With --dump-config it
/// prints that table instead and returns false.
[[nodiscard]] bool WriteImported(const ImportOutput& output,
                                 const Block& block,
                                 const Session& session,
                                 const AdjustOptions& own = {});

/// Adds --range-polynomial: how the ground range polynomials of an ISD are read.
void AddRangePolynomial(CLI::App* command, const std::string& help, RangePolynomialTimes* value);

/// An option that is a number above 0; left out, `value` stays empty.
void AddNumber(CLI::App* command,
               const std::string& name,
               std::optional<double>* value,
               const std::string& help);

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

/// Adds `isis` and `csm` to the command `import`.
void AddNetworkImports(CLI::App* group, Session* session);

}  // namespace sarblock::cli
