// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace sarblock {

/// SHA-256 (FIPS 180-4) of bytes as they come.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(Sha256&&) noexcept;
  Sha256& operator=(Sha256&&) noexcept;

  void Add(std::string_view bytes);
  /// In hexadecimal, 64 digits, as `sha256sum` prints it. Call once, nothing is added afterwards.
  [[nodiscard]] std::string Digits();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// SHA-256 of a file's bytes in hexadecimal digits. Throws InputError if it cannot be read.
[[nodiscard]] std::string Sha256Of(const std::filesystem::path& file);

/// Notes the checksums of all files of a folder in its hidden file `.sarblock-written`, as
/// `sha256sum -c` reads them, so that later changes by hand can be detected.
void NoteWritten(const std::filesystem::path& folder);
/// Name of a file that differs from what was noted, or is missing; empty: there is none, or nothing
/// was noted.
[[nodiscard]] std::string ChangedSinceWritten(const std::filesystem::path& folder);

}  // namespace sarblock
