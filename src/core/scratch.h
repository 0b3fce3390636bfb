// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <string>

namespace sarblock {

/// Arrays from so many bytes on may stand in scratch files.
inline constexpr std::size_t kScratchLeastBytes = std::size_t{2} << 20;

/// A folder that has no place for a scratch file; what() says which folder, how much and why.
class ScratchError : public std::bad_alloc {
 public:
  explicit ScratchError(const std::string& words) : words_(words) {}
  [[nodiscard]] const char* what() const noexcept override { return words_.what(); }

 private:
  std::runtime_error words_;  // whose copies never throw
};

/// While one of these lives, arrays of at least kScratchLeastBytes that this thread allocates stand
/// in mapped files of `folder`, in a program whose operator new asks AllocateScratch: the kernel
/// writes out what is not worked on and reads it again, so that they need no memory. They are read
/// and written as any other array and may outlive the scope. A file has no name from the beginning,
/// so that nothing stays behind however the process ends; its space is taken when it is made, so
/// that a full disk is an error then and never later.
class ScratchScope {
 public:
  /// Throws ScratchError if no file can be made in `folder`.
  explicit ScratchScope(std::filesystem::path folder);
  ~ScratchScope();
  ScratchScope(const ScratchScope&) = delete;
  ScratchScope& operator=(const ScratchScope&) = delete;

  /// The innermost scope of this thread; null without one.
  [[nodiscard]] static const ScratchScope* Current();
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_;
  const ScratchScope* outer_;
};

/// While one of these lives, what this thread allocates is memory again: matrices, which are worked
/// on everywhere at once.
class ResidentScope {
 public:
  ResidentScope();
  ~ResidentScope();
  ResidentScope(const ResidentScope&) = delete;
  ResidentScope& operator=(const ResidentScope&) = delete;

 private:
  const ScratchScope* outer_;
};

/// For operator new: a mapped file of so many bytes, or null where memory serves: a smaller array,
/// or no scope. Throws ScratchError.
[[nodiscard]] void* AllocateScratch(std::size_t bytes);
/// For operator delete: whether AllocateScratch made this; then it is given back.
[[nodiscard]] bool FreeScratch(void* array) noexcept;

}  // namespace sarblock
