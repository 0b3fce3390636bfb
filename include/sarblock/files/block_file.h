// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/id_table.h"
#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"
#include "sarblock/tables/output.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sarblock::files {

/// One key of the `[adjust]` table (docs/adjust_options.md is made of these).
struct AdjustOption {
  std::string_view key;       ///< dotted, below `adjust`
  std::string_view type;      ///< "text", "number", "integer", "flag", "list", ...
  std::string_view allowed;   ///< names or bounds
  std::string_view standard;  ///< what holds where the key is left out
  std::string_view help;      ///< one sentence
};

/// The `[adjust]` table of a block: the options of Adjust() and those that need files, which
/// functions on blocks in memory do not have.
struct AdjustTable : AdjustOptions {
  AdjustTable() = default;
  AdjustTable(const AdjustOptions& options)  // NOLINT(google-explicit-constructor)
      : AdjustOptions(options) {}

  /// With pairs == kList: CSV with columns point_a, point_b, relative to the block, for
  /// ReadPairs().
  std::string pairs_file;
  /// CSV with columns pass, point, rejected, such as residuals.csv of a result, relative to the
  /// block, for ApplyRejections(); empty: none.
  std::string rejections_file;
  bool diagnose = true;  ///< a result whose tests fail is explained, see Diagnose()
};

/// Every key of `[adjust]`, in the order of the manual. The same table drives reading,
/// `--dump-config` and the documentation.
[[nodiscard]] std::span<const AdjustOption> AdjustOptionTable();

/// Reads the `[adjust]` table of a TOML text (no table: the defaults). `file` is for messages,
/// `pass_ids` are what `passes = [...]` may name. Everything not allowed throws InputError with
/// place and key; an unknown key gets the nearest known one.
/// `overrides` are `KEY=VALUE` with dotted keys below `adjust` ("correction.position.degree=2");
/// a value that is no TOML is taken as a text.
[[nodiscard]] AdjustTable ReadAdjustTable(std::string_view toml_text,
                                          const std::string& file,
                                          const std::vector<std::string>& pass_ids,
                                          const std::vector<std::string>& overrides = {});

/// The options as a TOML `[adjust]` table, defaults written out; reads back to the same options.
[[nodiscard]] std::string DumpAdjustTable(const AdjustTable& options);

/// Whether looks must carry their measured time and range.
enum class Measurements {
  kRequired,
  kOptional,  ///< a plan: time_s and range_m may be left out and are NaN in Looks then
};

/// What becomes of a block that contradicts itself grossly: looks whose time is outside their
/// flight path, Dopplers too large for any direction, geocentric paths deep below the ground.
enum class Contradictions {
  kRefuse,
  kKeep,  ///< for Diagnose(), which looks for the cause
};

struct ReadOptions {
  Contradictions contradictions = Contradictions::kRefuse;
  Measurements measurements = Measurements::kRequired;
  std::vector<std::string> set_overrides;  ///< KEY=VALUE below `[adjust]`, see adjust_table.h
  ProgressSink* progress = nullptr;
};

/// A block folder as it was read.
struct BlockFile {
  Block block;
  AdjustTable adjust;
  std::vector<std::string> warnings;  ///< such as columns not known and ignored
};

/// Reads block.toml, trajectories.csv, observations.csv and, if it exists, points.csv, each
/// table plain or as `.csv.gz` (docs/formats.md), or all of an HDF5 file (docs/container.md).
/// Points are in the order of points.csv and then of their first look; angles become radians here.
/// Every fault of the input throws InputError with file, line, field, what is wrong and what is
/// allowed. Memory: about 60 bytes per look and 60 per point, twice that while it reads.
[[nodiscard]] BlockFile ReadBlock(const std::filesystem::path& path,
                                  const ReadOptions& options = {});

/// A block as texts, named like the files they replace.
struct BlockTexts {
  std::string_view block_toml;
  std::string_view trajectories_csv;
  std::string_view observations_csv;
  std::optional<std::string_view> points_csv;
};
/// The same from memory.
[[nodiscard]] BlockFile ReadBlockTexts(const BlockTexts& texts, const ReadOptions& options = {});

/// Reads truth.csv and truth_passes.csv if they exist (else the members stay empty). For
/// `predict` and for tests; the adjustment never reads them.
[[nodiscard]] Truth ReadTruth(const std::filesystem::path& folder, const Block& block);

/// Point pairs of a CSV file with columns point_a, point_b; a relative name counts from `folder`,
/// or, if that is a file, from its folder; so below.
[[nodiscard]] std::vector<std::pair<std::uint32_t, std::uint32_t>> ReadPairs(
    const std::filesystem::path& folder, const std::string& file, const Block& block);

/// Marks the looks that a table names (columns pass, point, rejected; other columns are ignored) as
/// rejected in `block`: residuals.csv of a result starts an adjustment from what that one left out.
/// Looks with 0 or an empty cell stay as they are. A relative name counts from `folder`. Refuses a
/// pass or point the block does not have, and a look it does not have. Returns the number of looks
/// newly rejected.
std::size_t ApplyRejections(const std::filesystem::path& folder,
                            const std::string& file,
                            Block* block);

/// Writes a block folder, or an HDF5 file where the name ends in ".h5". ReadBlock gives the same
/// block back, to the last bit but for squint angles (degrees in the file: one unit in the last
/// place). The same block gives the same bytes.
/// Tables of the other compression and, without `truth`, an older truth are removed.
void WriteBlock(const std::filesystem::path& target,
                const Block& block,
                const AdjustTable& adjust,
                const Truth* truth = nullptr,
                Compression compression = Compression::kNone);

/// A column of a table in memory: numbers, NaN where none is given, or texts. Nothing is copied
/// before the block is read: the arrays are the caller's.
struct ArrayColumn {
  std::string name;               ///< as in docs/formats.md
  std::span<const double> cells;  ///< numbers; their unit is the end of the name
  /// Texts: row i holds (*texts)[indices[i]]. Columns may share their texts. Null: numbers.
  std::shared_ptr<const IdTable> texts = nullptr;
  std::span<const std::uint32_t> indices = {};
  [[nodiscard]] std::size_t rows() const { return texts ? indices.size() : cells.size(); }
};

struct ArrayTable {
  std::string name;  ///< "trajectories", "observations" or "points"
  std::vector<ArrayColumn> columns;
};

/// A block as the content of its block.toml and tables of arrays; without points there are tie
/// points alone.
struct BlockArrays {
  std::string_view block_toml;
  std::vector<ArrayTable> tables;
};

/// The same as ReadBlock() from arrays, by the same checks; messages name table, column and row,
/// which counts from 0: `observations.range_m[12]: must be a number above 0, got -5`.
[[nodiscard]] BlockFile ReadBlockArrays(const BlockArrays& arrays, const ReadOptions& options = {});

}  // namespace sarblock::files
