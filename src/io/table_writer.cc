// SPDX-License-Identifier: Apache-2.0
#include "table_writer.h"

#include "sarblock/core/error.h"

#include <cmath>
#include <string>

#include "ordered_pieces.h"

namespace sarblock {

void WriteRows(std::size_t count,
               std::size_t per_piece,
               TableWriter* out,
               const std::function<void(std::size_t, std::size_t, TableWriter*)>& write) {
  using Part = std::unique_ptr<TableWriter>;
  if (count <= per_piece) {
    write(0, count, out);
    return;
  }
  MakeInOrder<Part>(
      count,
      per_piece,
      [&](std::size_t begin, std::size_t end) {
        Part part = out->Part();
        write(begin, end, part.get());
        part->EndPart();
        return part;
      },
      [&](Part* part) {
        out->Append(part->get());
        part->reset();
      });
}

void RefuseInfinity(double value, std::string_view file) {
  if (!std::isinf(value)) return;
  throw InputError(FilePlace{std::string(file), 0, ""},
                   "a number became infinite and cannot be written: something that was given is "
                   "too large or too small to compute with");
}

}  // namespace sarblock
