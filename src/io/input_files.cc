// SPDX-License-Identifier: Apache-2.0
#include "sarblock/io/input_files.h"

#include "sarblock/core/error.h"

#include <array>
#include <fstream>
#include <memory>

#include "tables/open.h"
#include <openssl/evp.h>

namespace sarblock {

std::string Sha256OfFile(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw InputError(FilePlace{file.string(), 0, ""}, "cannot be opened");
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> digest(EVP_MD_CTX_new(),
                                                                       &EVP_MD_CTX_free);
  bool good = digest != nullptr && EVP_DigestInit_ex(digest.get(), EVP_sha256(), nullptr) == 1;
  std::vector<char> buffer(std::size_t{1} << 18U);
  while (good && stream) {
    stream.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    const auto count = static_cast<std::size_t>(stream.gcount());
    good = EVP_DigestUpdate(digest.get(), buffer.data(), count) == 1;
  }
  std::array<unsigned char, EVP_MAX_MD_SIZE> value{};
  unsigned int size = 0;
  good = good && stream.eof() && EVP_DigestFinal_ex(digest.get(), value.data(), &size) == 1;
  if (!good) throw InputError(FilePlace{file.string(), 0, ""}, "cannot be read to its end");
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text;
  for (unsigned int i = 0; i < size; ++i) {
    text += kDigits[value[i] >> 4U];
    text += kDigits[value[i] & 15U];
  }
  return text;
}

std::vector<InputFile> ListInputFiles(const std::filesystem::path& block,
                                      const AdjustOptions& options) {
  std::vector<std::filesystem::path> files;
  if (std::filesystem::is_regular_file(block)) {
    files.push_back(block);
  } else {
    files.push_back(block / "block.toml");
    for (const char* table : {"trajectories", "observations", "points"}) {
      if (const auto found = FindTable(block, table)) files.push_back(*found);
    }
  }
  for (const std::string& list : {options.pairs_file, options.rejections_file}) {
    if (!list.empty()) files.push_back(FolderOf(block) / list);
  }
  std::vector<InputFile> out;
  for (const std::filesystem::path& file : files) {
    if (!std::filesystem::is_regular_file(file)) continue;
    out.push_back({file.filename().string(), std::filesystem::file_size(file), Sha256OfFile(file)});
  }
  return out;
}

}  // namespace sarblock
