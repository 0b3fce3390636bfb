// SPDX-License-Identifier: Apache-2.0
#include "checksum.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <stdexcept>
#include <vector>

#include "core/threads.h"
#include <openssl/evp.h>

namespace sarblock {

struct Sha256::State {
  EVP_MD_CTX* digest = EVP_MD_CTX_new();

  State() = default;
  ~State() { EVP_MD_CTX_free(digest); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;
};

namespace {

void Require(bool done) {
  if (!done) throw std::runtime_error("libcrypto computes no SHA-256");
}

}  // namespace

Sha256::Sha256() : state_(std::make_unique<State>()) {
  Require(state_->digest != nullptr &&
          EVP_DigestInit_ex(state_->digest, EVP_sha256(), nullptr) == 1);
}
Sha256::~Sha256() = default;
Sha256::Sha256(Sha256&&) noexcept = default;
Sha256& Sha256::operator=(Sha256&&) noexcept = default;

void Sha256::Add(std::string_view bytes) {
  Require(EVP_DigestUpdate(state_->digest, bytes.data(), bytes.size()) == 1);
}

std::string Sha256::Digits() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> value{};
  unsigned int size = 0;
  Require(EVP_DigestFinal_ex(state_->digest, value.data(), &size) == 1);
  constexpr const char* kHexadecimal = "0123456789abcdef";
  std::string text;
  for (unsigned int i = 0; i < size; ++i) {
    text += kHexadecimal[value[i] >> 4U];
    text += kHexadecimal[value[i] & 15U];
  }
  return text;
}

std::string Sha256Of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw InputError(FilePlace{file.string(), 0, ""}, "cannot be opened");
  Sha256 sum;
  std::vector<char> buffer(std::size_t{1} << 18U);
  while (stream) {
    stream.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    sum.Add({buffer.data(), static_cast<std::size_t>(stream.gcount())});
  }
  if (!stream.eof()) throw InputError(FilePlace{file.string(), 0, ""}, "cannot be read to its end");
  return sum.Digits();
}

namespace {

constexpr const char* kNote = ".sarblock-written";
constexpr std::size_t kDigits = 64;

}  // namespace

void NoteWritten(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<std::string> lines(files.size());
  ParallelForChunks(files.size(), 1, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      lines[i] = Sha256Of(files[i]) + "  " + files[i].filename().string() + "\n";
    }
  });
  std::ofstream note(folder / kNote, std::ios::binary);
  for (const std::string& line : lines) note << line;
  if (!note.flush())
    throw InputError(FilePlace{(folder / kNote).string(), 0, ""}, "writing failed");
}

std::string ChangedSinceWritten(const std::filesystem::path& folder) {
  std::ifstream note(folder / kNote, std::ios::binary);
  for (std::string line; std::getline(note, line);) {
    if (line.size() <= kDigits + 2) continue;
    const std::string name = line.substr(kDigits + 2);
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(folder / name, ignored) ||
        Sha256Of(folder / name) != line.substr(0, kDigits)) {
      return name;
    }
  }
  return {};
}

}  // namespace sarblock
