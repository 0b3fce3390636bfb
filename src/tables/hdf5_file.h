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

#include "hdf5_object.h"

namespace sarblock {

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
  bool none = false;                ///< none of them does
  /// Of a dataset of one dimension whose chunks are values and nothing else, as `own_type` has
  /// them: their values; else 0.
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

/// What is found of the rows of a column.
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

struct OpenedHdf5;  ///< src/tables/hdf5_file.h

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
  /// Whether there is a group or dataset.
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
