// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/io/block_files.h"
#include "sarblock/io/csv_reader.h"

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sarblock {

/// Where the files of a block come from: a folder or texts in memory.
class BlockSource {
 public:
  virtual ~BlockSource() = default;
  /// Name for messages and text of block.toml.
  [[nodiscard]] virtual std::pair<std::string, std::string> ReadToml() const = 0;
  /// A table by its name without ending ("points"), or nothing if it does not stand there.
  [[nodiscard]] virtual std::optional<CsvReader> Open(std::string_view table,
                                                      std::span<const CsvColumn> columns) const = 0;
  /// The name for messages of a table that must be there.
  [[nodiscard]] virtual std::string NameOf(std::string_view table) const = 0;
  /// The name a block takes that gives itself none.
  [[nodiscard]] virtual std::string DefaultName() const = 0;
  [[nodiscard]] CsvReader Require(std::string_view table, std::span<const CsvColumn> columns) const;
};

/// The file of a table in a folder: NAME.csv or NAME.csv.gz; nothing if neither is there. Both at
/// once are refused.
[[nodiscard]] std::optional<std::filesystem::path> FindTable(const std::filesystem::path& folder,
                                                             std::string_view name);

/// What the readers of the single files share.
struct BlockReading {
  const BlockSource& source;
  const ReadOptions& options;
  BlockFile result;
  IdTable pass_ids;
  std::vector<FilePlace> pass_places;                               ///< by pass: its `id` key
  std::vector<std::optional<std::array<double, 2>>> strip_spans_s;  ///< by pass, where given
  /// By pass: standard deviation of range in pixels of a ground presentation; NaN: none.
  std::vector<double> pixel_sigma_px;
};

void ReadBlockToml(BlockReading* reading);
void ReadTrajectories(BlockReading* reading);
void ReadPoints(BlockReading* reading);
void ReadLooks(BlockReading* reading);

/// Adds the one warning about columns nobody knows.
void WarnOfUnknownColumns(const CsvReader& reader, std::vector<std::string>* warnings);
/// Index of the pass a cell names; refuses others, giving the nearest.
[[nodiscard]] std::uint32_t FindPass(const CsvReader& reader,
                                     std::size_t column,
                                     const IdTable& pass_ids);
/// Index of the point a cell names, in the same way.
[[nodiscard]] std::uint32_t FindPoint(const CsvReader& reader,
                                      std::size_t column,
                                      const IdTable& ids);
/// The column `rejected`: true for 1, false for 0 or an empty cell.
[[nodiscard]] bool ReadRejected(const CsvReader& reader, std::size_t column);
/// A number above 0, or NaN for an empty cell.
[[nodiscard]] double PositiveNumber(const CsvReader& reader, std::size_t column);

/// Paths by pass from a table with the columns of trajectories.csv. A pass without states gets an
/// empty path.
struct PathTable {
  std::vector<std::vector<StateVector>> states;  ///< by pass
  std::vector<std::size_t> lines;                ///< of each pass's last state
};
[[nodiscard]] PathTable ReadPaths(CsvReader* reader, const IdTable& pass_ids);
inline constexpr std::array<CsvColumn, 8> kPathColumns{{{"pass", CsvNeed::kRequired},
                                                        {"time_s", CsvNeed::kRequired},
                                                        {"x_m", CsvNeed::kRequired},
                                                        {"y_m", CsvNeed::kRequired},
                                                        {"z_m", CsvNeed::kRequired},
                                                        {"vx_mps", CsvNeed::kRequired},
                                                        {"vy_mps", CsvNeed::kRequired},
                                                        {"vz_mps", CsvNeed::kRequired}}};

}  // namespace sarblock
