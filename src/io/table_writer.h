// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>

namespace sarblock {

/// Writes a table cell by cell, whatever it is stored in; it appears whole at Commit().
class TableWriter {
 public:
  virtual ~TableWriter() = default;

  virtual TableWriter& Text(std::string_view text) = 0;
  /// Text that is an id of the block: number `index` of its passes or its points.
  virtual TableWriter& Id(std::string_view text, std::uint32_t /*index*/) { return Text(text); }
  /// NaN is an empty cell; refuses infinity (InputError): no table holds one.
  virtual TableWriter& Number(double) = 0;
  template <std::integral T>
  TableWriter& Integer(T value) {
    return Signed(static_cast<std::int64_t>(value));
  }
  virtual TableWriter& Empty(std::size_t cells) = 0;
  TableWriter& Empty() { return Empty(1); }
  /// Ends the row; std::logic_error unless it has a cell for every column.
  virtual void EndRow() = 0;
  virtual void Commit() = 0;

  /// A writer of rows of this table that another thread may use beside this one: it keeps them
  /// until Append() writes them. Ids that the table is given the index of go to a part by Id().
  [[nodiscard]] virtual std::unique_ptr<TableWriter> Part() = 0;
  /// Writes the rows of a Part() of this table behind those written before.
  virtual void Append(const TableWriter& part) = 0;

 protected:
  TableWriter() = default;
  TableWriter(TableWriter&&) = default;
  TableWriter& operator=(TableWriter&&) = default;
  virtual TableWriter& Signed(std::int64_t value) = 0;
};

/// Has `write(begin, end, out)` write the rows of [0, count): pieces of `per_piece` on all threads.
/// The rows stand in their order.
void WriteRows(std::size_t count,
               std::size_t per_piece,
               TableWriter* out,
               const std::function<void(std::size_t, std::size_t, TableWriter*)>& write);

/// Throws InputError naming the file for a number that no table holds.
void RefuseInfinity(double value, std::string_view file);

}  // namespace sarblock
