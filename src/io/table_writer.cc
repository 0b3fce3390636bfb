// SPDX-License-Identifier: Apache-2.0
#include "table_writer.h"

#include "sarblock/core/error.h"

#include <cmath>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

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
  std::vector<Part> free;  // parts that were appended, with their room
  std::mutex mutex;
  const auto next_free = [&] {
    const std::lock_guard<std::mutex> lock(mutex);
    if (free.empty()) return out->Part();
    Part part = std::move(free.back());
    free.pop_back();
    return part;
  };
  MakeInOrder<Part>(
      count,
      per_piece,
      [&](std::size_t begin, std::size_t end) {
        Part part = next_free();
        write(begin, end, part.get());
        part->EndPart();
        return part;
      },
      [&](Part* part) {
        out->Append(part->get());
        const std::lock_guard<std::mutex> lock(mutex);
        free.push_back(std::move(*part));
      });
}

void RefuseInfinity(double value, std::string_view file) {
  if (!std::isinf(value)) return;
  throw InputError(FilePlace{std::string(file), 0, ""},
                   "a number became infinite and cannot be written: something that was given is "
                   "too large or too small to compute with");
}

}  // namespace sarblock
