// SPDX-License-Identifier: Apache-2.0
#include "hdf5_file.h"

#include <algorithm>
#include <array>

namespace sarblock {

std::mutex& Hdf5Mutex() {
  static std::mutex mutex;
  return mutex;
}

std::string AttributeOf(std::string_view file) {
  std::string name(file);
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
}

Hdf5Id StringType(std::size_t bytes) {
  Hdf5Id type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type.get(), bytes);
  H5Tset_cset(type.get(), H5T_CSET_UTF8);
  if (bytes != H5T_VARIABLE) H5Tset_strpad(type.get(), H5T_STR_NULLPAD);
  return type;
}

Hdf5Id ColumnAccess(std::size_t cached_bytes) {
  Hdf5Id access(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose);
  H5Pset_chunk_cache(access.get(), 11, cached_bytes, 1.0);
  return access;
}

void SilenceHdf5() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

std::vector<std::string> MembersOf(hid_t group) {
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

Hdf5Id SelectRows(hid_t dataset, std::uint64_t first, std::uint64_t count) {
  Hdf5Id space(H5Dget_space(dataset), H5Sclose);
  const hsize_t start = first, size = count;
  if (!space.valid() ||
      H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, &start, nullptr, &size, nullptr) < 0) {
    return {};
  }
  return space;
}

}  // namespace sarblock
