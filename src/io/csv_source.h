// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace sarblock {

/// Bytes of a plain file, a gzip file or a text in memory.
class CsvSource {
 public:
  virtual ~CsvSource() = default;
  /// Up to `size` bytes; 0 at the end. What went wrong, if anything, goes to `problem`.
  [[nodiscard]] virtual std::size_t Read(char* to, std::size_t size, std::string* problem) = 0;

  /// Throws InputError naming the file if it cannot be opened.
  [[nodiscard]] static std::unique_ptr<CsvSource> Open(const std::filesystem::path& file);
  [[nodiscard]] static std::unique_ptr<CsvSource> InMemory(std::string_view text);
};

}  // namespace sarblock
