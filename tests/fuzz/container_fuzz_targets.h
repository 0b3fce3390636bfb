// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

#include "files/convert.h"
#include "fuzz/container_edit.h"
#include "fuzz/fuzz_targets.h"

// The HDF5 file of a small block, damaged by the lines of container_edit.h, is read and converted.
// Bytes inside it are not: what they mean is libhdf5's.
namespace sarblock::fuzz {

inline void WriteSmallContainer(const std::filesystem::path& file) {
  const files::BlockFile small = files::ReadBlockTexts({kToml, kPaths, kLooks, std::nullopt});
  files::WriteBlock(file, small.block, small.adjust);
}

inline void Container(std::string_view lines, const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "fuzz.h5";
  WriteSmallContainer(file);
  ContainerEdit(file, lines);
  AllowInputError([&] { CheckBlock(files::ReadBlock(file).block); });
  AllowInputError([&] { static_cast<void>(files::ReadResult(file)); });
  AllowInputError([&] { files::Convert(file, folder / "fuzz"); });
  std::filesystem::remove_all(folder / "fuzz");
}

}  // namespace sarblock::fuzz
