// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/id_table.h"
#include "sarblock/io/block_files.h"

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sarblock {

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
/// which counts from 0: `observations.range_m[12]: -5 is not allowed, a number above 0 is`.
[[nodiscard]] BlockFile ReadBlockArrays(const BlockArrays& arrays, const ReadOptions& options = {});

}  // namespace sarblock
