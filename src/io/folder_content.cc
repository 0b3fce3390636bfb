// SPDX-License-Identifier: Apache-2.0
#include "folder_content.h"

#include <array>
#include <fstream>
#include <string_view>

#include "hdf5_file.h"

namespace sarblock {

bool NamesContainer(const std::filesystem::path& path) { return path.extension() == ".h5"; }

std::string NameAt(const std::filesystem::path& path) {
  const auto whole = std::filesystem::absolute(path).lexically_normal();
  const auto last = (whole.has_filename() ? whole : whole.parent_path()).filename();
  return (NamesContainer(last) ? last.stem() : last).string();
}

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

}  // namespace sarblock
