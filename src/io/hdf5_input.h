// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "hdf5_file.h"

namespace sarblock {

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

}  // namespace sarblock
