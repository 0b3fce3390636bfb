// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <hdf5.h>

namespace sarblock {

/// An object of libhdf5, closed when this ends. A negative id is one that could not be made.
class Hdf5Id {
 public:
  Hdf5Id() = default;
  Hdf5Id(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Hdf5Id() { Release(); }
  Hdf5Id(Hdf5Id&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Hdf5Id& operator=(Hdf5Id&& other) noexcept {
    Release();
    id_ = std::exchange(other.id_, -1);
    close_ = other.close_;
    return *this;
  }
  [[nodiscard]] hid_t get() const { return id_; }
  [[nodiscard]] bool valid() const { return id_ >= 0; }
  /// Negative where closing failed, which for a file means that it is not whole.
  herr_t Release() {
    const hid_t id = std::exchange(id_, -1);
    return id >= 0 ? close_(id) : 0;
  }

 private:
  hid_t id_ = -1;
  herr_t (*close_)(hid_t) = nullptr;
};

/// libhdf5 serves one thread at a time: to be held where others may call it meanwhile.
[[nodiscard]] std::mutex& Hdf5Mutex();

/// Rows that are moved at a time, and the rows of a chunk: 64 KiB of numbers.
inline constexpr std::size_t kSlabRows = 8192;
/// The datasets of the ids that columns of these kinds are indices into.
inline constexpr const char* kPassIds = "pass_id";
inline constexpr const char* kPointIds = "point_id";
/// Ending of the dataset with the texts that a column of text is indices into.
inline constexpr std::string_view kValuesEnding = "_values";
/// The dimension of a table's columns.
inline constexpr const char* kRowDimension = "row";

/// The attribute that stands for a text file: "block_toml" for "block.toml".
[[nodiscard]] std::string AttributeOf(std::string_view file);
/// A string type of `bytes` bytes, or of variable length for H5T_VARIABLE.
[[nodiscard]] Hdf5Id StringType(std::size_t bytes);
/// How datasets are opened: with a cache of so many bytes in place of the megabyte that libhdf5
/// gives each: values are moved in order and once.
[[nodiscard]] Hdf5Id ColumnAccess(std::size_t cached_bytes);
/// Keeps libhdf5 from printing errors of this thread; ours say what they mean.
void SilenceHdf5();
/// Names of the members of a group in their order, up to 255 characters of each; none where the
/// group cannot be read.
[[nodiscard]] std::vector<std::string> MembersOf(hid_t group);
/// Rows [first, first + count) of a column as a selection in its file.
[[nodiscard]] Hdf5Id SelectRows(hid_t dataset, std::uint64_t first, std::uint64_t count);

}  // namespace sarblock
