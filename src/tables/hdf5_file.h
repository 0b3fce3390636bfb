// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
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

/// A file open for reading, and what every dataset of it is held to.
struct OpenedHdf5 {
  std::string path;
  std::uint64_t bytes = 0;
  Hdf5Id file;

  [[noreturn]] void Fail(const std::string& object, const std::string& problem) const;
};
[[nodiscard]] OpenedHdf5 OpenHdf5(const std::filesystem::path& path);

/// Whether a group has a member of this name that stands in this file itself; links to others are
/// refused. `path` is the member's, for messages.
[[nodiscard]] bool HasMember(const OpenedHdf5& opened,
                             hid_t group,
                             const std::string& name,
                             const std::string& path);

/// A dataset and what it says of its values. None of them is read yet.
struct StoredDataset {
  Hdf5Id dataset;
  H5T_class_t type = H5T_NO_CLASS;
  std::size_t value_bytes = 0;
  bool variable_text = false;
  std::vector<std::uint64_t> size;  ///< one number a dimension; none: a scalar
  std::uint64_t count = 0;          ///< values, the product of these
  bool whole = true;                ///< all values stand in the file
  bool none = false;                ///< none of them does
  /// Of a dataset of one dimension whose chunks are values and nothing else, as `own_type` has
  /// them: their values; else 0.
  std::uint64_t chunk_values = 0;
  hid_t own_type = -1;  ///< the type of libhdf5 for this machine, if there is one
};

/// Opens a dataset of `rank` dimensions. How many values it claims is held against the bytes of the
/// file, so that `whole` bounds the memory that reading it costs. Refused are values in other
/// files and chunks of more than 64 MiB.
[[nodiscard]] StoredDataset OpenStored(const OpenedHdf5& opened,
                                       hid_t group,
                                       const std::string& name,
                                       const std::string& path,
                                       int rank);

/// What is found of the rows of a column.
enum class StoredRows : std::uint8_t {
  kRead,
  kNone,    ///< numbers of a column without values; nothing is read
  kDamaged  ///< libhdf5 cannot read them
};
/// Reads the rows [first, first + count) as `type`; `memory` is a space of so many. A whole chunk
/// is taken as it stands where it can be.
[[nodiscard]] StoredRows ReadRows(const StoredDataset& stored,
                                  std::uint64_t first,
                                  std::uint64_t count,
                                  hid_t memory,
                                  hid_t type,
                                  void* values);

/// A text attribute of an object; nothing where it does not stand. `place` is for messages.
[[nodiscard]] std::optional<std::string> ReadTextAttribute(const OpenedHdf5& opened,
                                                           hid_t object,
                                                           const std::string& name,
                                                           const std::string& place);

/// Walks through an HDF5 file in a process of its own: every group, attribute and dataset, of large
/// datasets the first and the last values. libhdf5 does not bear bytes that a disk or a line has
/// changed everywhere: it reads beyond its memory, frees what it has not, or never ends. What it
/// bears there, it bears here. Throws InputError where the process does not come to its end. What
/// the walk cannot open is no error: it is named when it is needed. `bytes` is the file's length,
/// which bounds the time and the memory of the walk.
void TryHdf5(const std::string& path, std::uint64_t bytes);

struct OpenedHdf5;  ///< src/tables/hdf5_file.h

/// Numbers of a dataset with one, two or three dimensions, the last one running fastest.
struct Hdf5Array {
  std::vector<std::size_t> size;  ///< one number a dimension
  std::vector<double> values;     ///< finite
};

/// Datasets of an HDF5 file of others, by paths such as "/science/LSAR/identification". Groups and
/// datasets must stand in the file itself, links are refused; what is read is bounded by the size
/// of the file before any memory is taken. Everything that is wrong throws InputError with the file
/// and the path.
class Hdf5Values {
 public:
  /// Throws where the file cannot be opened, is cut off or is no HDF5 file.
  explicit Hdf5Values(const std::string& file);
  ~Hdf5Values();

  [[nodiscard]] const std::string& file() const;
  /// Whether a group or dataset stands there.
  [[nodiscard]] bool Has(const std::string& path) const;
  /// One text, of fixed or variable length.
  [[nodiscard]] std::string Text(const std::string& path) const;
  /// One number.
  [[nodiscard]] double Number(const std::string& path) const;
  /// All numbers of a dataset of `rank` dimensions; more than `most` are refused, and any that is
  /// not finite.
  [[nodiscard]] Hdf5Array Numbers(const std::string& path, int rank, std::size_t most) const;
  /// A text attribute of a dataset.
  [[nodiscard]] std::string TextAttribute(const std::string& path, const std::string& name) const;

  [[noreturn]] void Fail(const std::string& path, const std::string& problem) const;

 private:
  std::unique_ptr<OpenedHdf5> opened_;
};

}  // namespace sarblock
