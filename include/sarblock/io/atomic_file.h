// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace sarblock {

enum class Compression { kNone, kGzip };

/// The name `.NAME.tmp-PID` beside a target, for a file that appears whole or not at all: whoever
/// writes it calls Commit(), which renames it. Without a Commit() the destructor removes it.
class TemporaryName {
 public:
  /// Removes what a killed process that had the same number left.
  explicit TemporaryName(const std::filesystem::path& target);
  ~TemporaryName();
  TemporaryName(const TemporaryName&) = delete;
  TemporaryName& operator=(const TemporaryName&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }
  /// Throws InputError naming the target if it cannot be replaced. Call once.
  void Commit();

 private:
  std::filesystem::path target_;
  std::string name_;  // empty: committed
  int slot_ = -1;
};

/// A file that appears whole or not at all: written under a TemporaryName and renamed by Commit().
/// A target that exists and is no regular file (a pipe, a device) is written directly.
/// Every write is checked; failures (no space left, no such folder) throw InputError naming the
/// file. Gzip output is the same bytes for the same text (no time stamp, no name).
class AtomicFile {
 public:
  explicit AtomicFile(const std::filesystem::path& target,
                      Compression compression = Compression::kNone);
  ~AtomicFile();
  AtomicFile(AtomicFile&&) noexcept;
  AtomicFile& operator=(AtomicFile&&) = delete;

  void Write(std::string_view text);
  /// Writes what is buffered, closes and renames. Call once.
  void Commit();

 private:
  struct State;
  void Flush();
  void WriteThrough(std::string_view text);
  [[noreturn]] void Fail(const std::string& doing);
  std::unique_ptr<State> state_;
};

/// Removes the temporary files that are open in this process. Async-signal-safe (a signal handler
/// may call it before the process ends); the files' AtomicFile objects must not be used afterwards.
void RemoveOpenTemporaryFiles() noexcept;

/// A file that goes with a block or a result: `name` in its folder, or beside the file that stands
/// for one: "x.report.html" for "x.h5".
[[nodiscard]] std::filesystem::path FileOf(const std::filesystem::path& owner,
                                           const std::string& name);

/// Makes a folder and its parents; throws InputError naming it where that fails.
void MakeFolder(const std::filesystem::path& folder);

}  // namespace sarblock
