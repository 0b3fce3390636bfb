// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "threads.h"

namespace sarblock {

/// Memory that this process may still take without swapping: what /proc/meminfo calls available,
/// and no more than the control groups that the process is in (version 1 or 2, all of the path)
/// leave below their limits, their page cache counted as free, and than its own limit of addresses
/// (ulimit -v). Infinite where the system gives no figure. `root`: where the system's files are;
/// tests give their own.
[[nodiscard]] double AvailableMemory_bytes(const std::filesystem::path& root = "/");

/// Asks the system for pages of 2 MiB for an array that will be filled to its end: a hundred times
/// fewer pages have to be given and taken back. Where it has none nothing changes. For arrays whose
/// size is known before; in a growing vector the pages of the copies would be wasted.
void PreferLargePages(void* array, std::size_t bytes);

/// Room for `count` values, in large pages.
template <typename T>
void ReserveInLargePages(std::size_t count, std::vector<T>* values) {
  if (count <= values->capacity()) return;
  values->reserve(count);
  PreferLargePages(values->data(), values->capacity() * sizeof(T));
}

/// Arrays of at least so many bytes may be in scratch files.
inline constexpr std::size_t kScratchMinBytes = std::size_t{2} << 20;

/// Thrown where a folder has no space for a scratch file; what() says which folder, how much and
/// why.
class ScratchError : public std::bad_alloc {
 public:
  explicit ScratchError(const std::string& words) : words_(words) {}
  [[nodiscard]] const char* what() const noexcept override { return words_.what(); }

 private:
  std::runtime_error words_;  // whose copies never throw
};

/// During the life of one of these, arrays of at least kScratchMinBytes that this thread
/// allocates are mapped files of `folder`, in a program whose operator new asks AllocateScratch:
/// the kernel writes idle pages to the file and reads them again, so that they need no memory. They
/// are read and written as any other array and may outlive the scope. A file has no name from the
/// beginning, so that it disappears however the process ends; its space is allocated when it is
/// made, so that a full disk is an error then and never later.
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

/// While one of these lives, this thread allocates memory again, not scratch files: for matrices,
/// all parts of which are in use at once.
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

inline constexpr std::size_t kGatheredAtOnce = 65536;

/// Element i becomes what element old_of_new[i] was, a permutation. An empty column stays empty.
template <typename T>
void Gather(const std::vector<std::uint32_t>& old_of_new, std::vector<T>* column) {
  if (column->empty()) return;
  std::vector<T> gathered;
  ReserveInLargePages(old_of_new.size(), &gathered);
  gathered.resize(old_of_new.size());
  const auto gather = [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) gathered[i] = std::move((*column)[old_of_new[i]]);
  };
  ParallelForChunks(gathered.size(), kGatheredAtOnce, gather);
  column->swap(gathered);
}

/// The same for a column whose elements offsets[i] to offsets[i + 1] belong to item i, from the
/// offsets of the old items to those of the new.
template <typename T>
void GatherRanges(const std::vector<std::uint32_t>& old_of_new,
                  const std::vector<std::uint64_t>& old_offsets,
                  const std::vector<std::uint64_t>& new_offsets,
                  std::vector<T>* column) {
  if (column->empty()) return;
  std::vector<T> gathered;
  ReserveInLargePages(column->size(), &gathered);
  gathered.resize(column->size());
  const auto gather = [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      std::uint64_t old = old_offsets[old_of_new[i]];
      for (std::uint64_t k = new_offsets[i]; k < new_offsets[i + 1]; ++k, ++old) {
        gathered[k] = (*column)[old];
      }
    }
  };
  ParallelForChunks(old_of_new.size(), kGatheredAtOnce, gather);
  column->swap(gathered);
}

}  // namespace sarblock
