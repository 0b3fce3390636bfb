// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/id_table.h"
#include "sarblock/files/block_file.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/model/options.h"
#include "sarblock/simulate/scene.h"

#include <array>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tables/table.h"
#include "tables/toml.h"

namespace sarblock::files {

/// The parts of a block file, its keys and its tables, as block.toml and the tables of a result and
/// of a scene have them too: what reads them first, then what writes them.

/// What the readers of the single files share.
struct BlockReading {
  const TableSource& source;
  const ReadOptions& options;
  BlockFile result;
  IdTable pass_ids;
  std::vector<FilePlace> pass_places;                               ///< by pass: its `id` key
  std::vector<std::optional<std::array<double, 2>>> strip_spans_s;  ///< by pass, where given
  /// By pass: standard deviation of range in pixels of a ground presentation; NaN: none.
  std::vector<double> pixel_sigma_px;
  /// A row of the points' table that begins with #, if there is one.
  std::optional<FilePlace> commented_point{};
};

/// Reads a block from any source of tables.
[[nodiscard]] BlockFile ReadBlockFrom(const TableSource& source, const ReadOptions& options);

void ReadBlockToml(BlockReading* reading);
void ReadTrajectories(BlockReading* reading);
void ReadPoints(BlockReading* reading);
void ReadLooks(BlockReading* reading);

/// Finds passes or points by the ids in cells of one column.
class IdFinder {
 public:
  /// For messages: `noun` is "pass" or "point", `holder` is the file that `ids` come from.
  IdFinder(const char* noun, const IdTable& ids, const char* holder)
      : noun_(noun), ids_(ids), holder_(holder) {}
  /// The index of the id; refuses one that is not there, giving the nearest.
  [[nodiscard]] std::uint32_t Find(const Row& row, std::size_t column);

 private:
  const char* noun_;
  const IdTable& ids_;
  const char* holder_;
  FoundTexts found_;
};

/// Adds the id of a cell to those of the rows before, none of which may have it; returns its index.
std::uint32_t AddId(const Row& row, std::size_t column, IdTable* ids);

/// The role of a point by its name.
[[nodiscard]] PointRole ReadRole(const Row& row, std::size_t column);

/// Lengths beyond this have squares and positions without a meaning; no body's ground is as far
/// from the origin of its frame, nor an antenna from the ground.
inline constexpr double kLargestLength_m = 1e12;
/// A coordinate or a range of at most kLargestLength_m, or NaN for an empty cell.
[[nodiscard]] double LengthNumber(const Row& row, std::size_t column);

/// Paths by pass from a table with the columns of trajectories.csv. A pass without states gets an
/// empty path.
struct PathTable {
  std::vector<std::vector<StateVector>> states;  ///< by pass
  std::vector<std::vector<std::size_t>> lines;   ///< of each state
  /// By pass, for the paths of a result: names of the corrections that the states do not contain.
  std::vector<std::string> not_in_states;
};
[[nodiscard]] PathTable ReadPaths(TableReader* reader,
                                  const IdTable& pass_ids,
                                  const char* holder = "block.toml");
/// The line of a pass's last state, 0 if it has none.
[[nodiscard]] std::size_t LastLine(const PathTable& table, std::size_t pass);

/// Standard deviations that a pass gives in pixels; NaN where it gives none.
struct PixelSigma {
  double line_px = kNotGiven;
  double pixel_px = kNotGiven;
};

/// Reads the table `[pass.image]` (docs/formats.md).
[[nodiscard]] ImageGrid ReadImageTable(const TomlTable& table, PixelSigma* sigma);

/// The same as TOML text, to stand behind the keys of its `[[pass]]`.
[[nodiscard]] std::string ImageTableText(const ImageGrid& grid);

/// The swath of a block's pass or a scene's flight by the keys of kSwathKeys, of which `find` gives
/// the values; one of them at most.
[[nodiscard]] std::optional<Swath> ReadSwath(
    const std::function<std::optional<TomlValue>(const std::string&)>& find);

/// `[recorder]` and `[wander]` of a scene; without a folder to look in `wander.table` is refused.
SceneRecorder ReadRecorder(SceneTable& table);
SceneTrajectoryError ReadTrajectoryError(SceneTable& table, const std::filesystem::path* folder);

/// The `ellipsoid` of a block's or a scene's frame: a name, or { a_m = ..., f = ... }.
[[nodiscard]] Ellipsoid ReadEllipsoid(const TomlValue& value);

/// Reads `[reduction]` of a block, of a pass or of a scene, or `[truth.delay]` (docs/formats.md).
/// Keys that are left out are as in `standard`.
[[nodiscard]] ReductionModels ReadReduction(const TomlTable& table,
                                            const ReductionModels& standard);

/// The keys of that table.
[[nodiscard]] const std::vector<std::string>& ReductionKeys();

/// The same as a table of TOML with a header of that name; nothing where there are no models.
[[nodiscard]] std::string ReductionText(const ReductionModels& models, std::string_view name);

/// Sentences on passes with reductions that no product needs: delays in another unit or of the
/// wrong sign.
[[nodiscard]] std::vector<std::string> DoubtsOfReductions(const Block& block);

/// Throws InputError for models that the block's passes cannot have (FindProblem()); `places`:
/// where the passes are in the file.
void RequireReductions(const Block& block, const std::vector<FilePlace>& places);

/// Calls write(look, point) for the looks [begin, end) in their order.
template <typename Write>
void ForLooks(const Looks& looks, std::size_t begin, std::size_t end, const Write& write) {
  std::size_t point = looks.PointOf(begin);
  for (std::size_t look = begin; look < end; ++look) {
    while (looks.offsets[point + 1] <= look) ++point;
    write(look, point);
  }
}

/// Writes flight paths, one per pass, with the columns of trajectories.csv. `adjusted`: text of
/// that column by pass; empty: the paths are not adjusted ones.
void WritePaths(TableSink* sink,
                std::string_view name,
                const IdTable& pass_ids,
                const std::vector<FlightPath>& paths,
                const std::vector<std::string>& adjusted = {});
/// Whether a group corrects a pass.
[[nodiscard]] bool IsOf(const CorrectionGroup& group, const std::string& pass);

/// Text of the column `adjusted` where the states contain all corrections.
inline constexpr const char* kAllAdjusted = "all";

/// Ids of the passes, for BlockIds.
[[nodiscard]] IdTable PassIds(const Block& block);

/// Ids of a list of passes, of a block or a result, in its order.
template <typename Passes>
[[nodiscard]] std::vector<std::string> IdsOf(const Passes& passes) {
  std::vector<std::string> ids;
  for (const auto& pass : passes) ids.push_back(pass.id);
  return ids;
}

/// The paths as the block gives them.
[[nodiscard]] std::vector<FlightPath> NominalPaths(const Block& block);

}  // namespace sarblock::files
