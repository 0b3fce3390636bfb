// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
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

/// How datasets are opened: with a cache of so many bytes in place of the megabyte that libhdf5
/// gives each: values are moved in order and once.
[[nodiscard]] inline Hdf5Id ColumnAccess(std::size_t cached_bytes) {
  Hdf5Id access(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose);
  H5Pset_chunk_cache(access.get(), 11, cached_bytes, 1.0);
  return access;
}

/// While one of these lives, libhdf5 prints no errors of the thread that made it (ours say what
/// they mean); afterwards it does again what the host program asked for. To be ended in that
/// thread.
class QuietHdf5 {
 public:
  QuietHdf5() : active_(true) {
    Asked& asked = OfThread();
    if (asked.scopes++ > 0) return;
    H5Eget_auto2(H5E_DEFAULT, &asked.print, &asked.data);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~QuietHdf5() {
    if (!active_) return;
    Asked& asked = OfThread();
    if (--asked.scopes == 0) H5Eset_auto2(H5E_DEFAULT, asked.print, asked.data);
  }
  QuietHdf5(QuietHdf5&& other) noexcept : active_(std::exchange(other.active_, false)) {}
  QuietHdf5& operator=(QuietHdf5&&) = delete;

 private:
  struct Asked {
    int scopes = 0;
    H5E_auto2_t print = nullptr;
    void* data = nullptr;
  };
  static Asked& OfThread() {
    thread_local Asked asked;
    return asked;
  }
  bool active_;
};

/// Names of the members of a group in their order, up to 255 characters of each; none where the
/// group cannot be read.
[[nodiscard]] inline std::vector<std::string> MembersOf(hid_t group) {
  std::vector<std::string> names;
  H5G_info_t info;
  if (H5Gget_info(group, &info) < 0) return names;
  for (hsize_t i = 0; i < info.nlinks; ++i) {
    std::array<char, 256> name{};
    if (H5Lget_name_by_idx(
            group, ".", H5_INDEX_NAME, H5_ITER_INC, i, name.data(), name.size(), H5P_DEFAULT) >=
        0) {
      names.emplace_back(name.data());
    }
  }
  return names;
}

/// libhdf5 serves one thread at a time: hold this mutex where other threads may call it.
[[nodiscard]] std::mutex& Hdf5Mutex();

/// Whether every file is walked through in a process of its own (hdf5_walk.cc) before it is opened;
/// true at first. The walk reads every group, attribute and dataset, of large datasets the first
/// and the last values. At some places libhdf5 does not survive bytes that a disk or a line has
/// changed: it reads beyond its memory, frees memory that it does not have, or never ends. What it
/// survives in the walk it survives here. An object that the walk cannot open is no error; it is
/// reported when it is needed.
///
/// Callers may have threads that hold locks of any library. So nothing is forked: the program of
/// the walk is a part of this library, started by posix_spawn().
void SetHdf5Trial(bool on);

/// What the program of the walk says on its standard output, in this order.
inline constexpr const char* kWalkBegins = "begun ";
inline constexpr const char* kWalkEnds = "whole";

/// Rows that are moved at a time, and the rows of a chunk: 64 KiB of numbers.
inline constexpr std::size_t kSlabRows = 8192;
/// The datasets of the ids that columns of these kinds are indices into.
inline constexpr const char* kPassIds = "pass_id";
inline constexpr const char* kPointIds = "point_id";
/// Ending of the dataset with the texts that a column of text is indices into.
inline constexpr std::string_view kValuesEnding = "_values";
/// The dimension of a table's columns.
inline constexpr const char* kRowDimension = "row";

/// The attribute with the text of a file: "block_toml" for "block.toml".
[[nodiscard]] std::string AttributeOf(std::string_view file);
/// A string type of `bytes` bytes, or of variable length for H5T_VARIABLE.
[[nodiscard]] Hdf5Id StringType(std::size_t bytes);
/// Rows [first, first + count) of a column as a selection in its file.
[[nodiscard]] Hdf5Id SelectRows(hid_t dataset, std::uint64_t first, std::uint64_t count);

/// A file open for reading, and the limits of every dataset of it.
struct OpenedHdf5 {
  std::string path;
  std::uint64_t bytes = 0;
  QuietHdf5 quiet;
  Hdf5Id file;

  [[noreturn]] void Fail(const std::string& object, const std::string& problem) const;
};
/// Throws InputError where the walk does not come to its end or cannot be started, and for what is
/// no HDF5 file; Interrupted where CancellationScope::Current() asks for it.
[[nodiscard]] OpenedHdf5 OpenHdf5(const std::filesystem::path& path);

/// Whether a group has a member of this name in this file itself; links to others are
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
  bool whole = true;                ///< all values are in the file
  bool none = false;                ///< no value is in the file
  /// Values per chunk of a dataset of one dimension whose chunks hold nothing but values of
  /// `own_type`; otherwise 0.
  std::uint64_t chunk_values = 0;
  hid_t own_type = -1;  ///< the type of libhdf5 for this machine, if there is one
};

/// Opens a dataset of `rank` dimensions. The number of values it claims is checked against the
/// bytes of the file, so that `whole` bounds the memory that reading it costs. Refused are values
/// in other files and chunks of more than 64 MiB.
[[nodiscard]] StoredDataset OpenStored(const OpenedHdf5& opened,
                                       hid_t group,
                                       const std::string& name,
                                       const std::string& path,
                                       int rank);

/// Outcome of reading rows of a column.
enum class StoredRows : std::uint8_t {
  kRead,
  kNone,    ///< numbers of a column without values; nothing is read
  kDamaged  ///< libhdf5 cannot read them
};
/// Reads the rows [first, first + count) as `type`; `memory` is a space of so many. A whole chunk
/// is taken as stored where possible.
[[nodiscard]] StoredRows ReadRows(const StoredDataset& stored,
                                  std::uint64_t first,
                                  std::uint64_t count,
                                  hid_t memory,
                                  hid_t type,
                                  void* values);

/// A text attribute of an object; nothing if there is none. `place` is for messages.
[[nodiscard]] std::optional<std::string> ReadTextAttribute(const OpenedHdf5& opened,
                                                           hid_t object,
                                                           const std::string& name,
                                                           const std::string& place);

/// Numbers of a dataset with one, two or three dimensions, the last one running fastest.
struct Hdf5Array {
  std::vector<std::size_t> size;  ///< one number a dimension
  std::vector<double> values;     ///< finite
};

/// Datasets of an HDF5 file of others, by paths such as "/science/LSAR/identification". Groups and
/// datasets must be in the file itself, links are refused; what is read is bounded by the size
/// of the file before any memory is taken. Everything that is wrong throws InputError with the file
/// and the path.
class Hdf5Values {
 public:
  /// Throws where the file cannot be opened, is cut off or is no HDF5 file.
  explicit Hdf5Values(const std::string& file);
  ~Hdf5Values();

  [[nodiscard]] const std::string& file() const;
  /// Whether the file has a group or dataset at this path.
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

/// A file that libhdf5 writes through our own driver, which never reports a failed write to it: if
/// libhdf5 cannot write what it still holds, it crashes when the file is closed or the process
/// ends. Bytes that the disk did not accept are kept here for reading back until the file is
/// closed; callers check error() and stop.
class FailingSafely {
 public:
  FailingSafely();

  /// For H5Fcreate. This object outlives the file.
  [[nodiscard]] Hdf5Id Access();
  /// `errno` of the first write that failed; 0: none did.
  [[nodiscard]] int error() const { return error_; }

  /// The calls of the driver.
  void Write(int descriptor, std::uint64_t at, const char* bytes, std::uint64_t count);
  [[nodiscard]] bool Read(int descriptor, std::uint64_t at, char* bytes, std::uint64_t count);
  void Note(int error) { error_ = error_ != 0 ? error_ : error; }

 private:
  Hdf5Id driver_;
  int error_ = 0;
  std::map<std::uint64_t, std::vector<char>> not_written_;  // by number of a page, pages whole
};

}  // namespace sarblock
