// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
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

 protected:
  TableWriter() = default;
  TableWriter(TableWriter&&) = default;
  TableWriter& operator=(TableWriter&&) = default;
  virtual TableWriter& Signed(std::int64_t value) = 0;
};

/// Throws InputError naming the file for a number that no table holds.
void RefuseInfinity(double value, std::string_view file);

}  // namespace sarblock
