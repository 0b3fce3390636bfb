// SPDX-License-Identifier: Apache-2.0
#include "hdf5_file.h"

#include <algorithm>
#include <array>
#include <fstream>

namespace sarblock {

bool NamesContainer(const std::filesystem::path& path) { return path.extension() == ".h5"; }

bool IsContainer(const std::filesystem::path& path) {
  if (!std::filesystem::is_regular_file(path)) return false;
  constexpr std::string_view kSignature = "\x89HDF\r\n\x1a\n";
  std::array<char, kSignature.size()> begin{};
  std::ifstream(path, std::ios::binary).read(begin.data(), begin.size());
  return std::string_view(begin.data(), begin.size()) == kSignature;
}

std::optional<FolderContent> ContentOf(const std::filesystem::path& container) {
  SilenceHdf5();
  const Hdf5Id file(H5Fopen(container.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!file.valid()) return std::nullopt;
  const bool block = H5Aexists(file.get(), AttributeOf("block.toml").c_str()) > 0;
  const bool result = H5Aexists(file.get(), AttributeOf("summary.json").c_str()) > 0;
  if (block == result) return std::nullopt;
  return block ? FolderContent::kBlock : FolderContent::kResult;
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

Hdf5Id ColumnAccess() {
  Hdf5Id access(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose);
  H5Pset_chunk_cache(access.get(), 11, kSlabRows * sizeof(double), 1.0);
  return access;
}

void SilenceHdf5() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

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
