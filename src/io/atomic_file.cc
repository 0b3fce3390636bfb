// SPDX-License-Identifier: Apache-2.0
#include "sarblock/io/atomic_file.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <cstdio>
#include <cstring>
#include <optional>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>
#include <zlib.h>

namespace sarblock {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 18;

// Names of open temporary files at fixed addresses, so that a signal handler can walk them.
struct Slot {
  std::atomic<int> state{0};  // 0 free, 1 being filled or emptied, 2 holds a name
  char name[PATH_MAX];
};
std::array<Slot, 32> g_slots;

// A file beyond the last slot is still removed by its destructor, only not by a signal.
int Register(const std::string& name) {
  if (name.size() >= PATH_MAX) return -1;
  for (std::size_t i = 0; i < g_slots.size(); ++i) {
    int free = 0;
    if (!g_slots[i].state.compare_exchange_strong(free, 1)) continue;
    std::memcpy(g_slots[i].name, name.c_str(), name.size() + 1);
    g_slots[i].state.store(2);
    return static_cast<int>(i);
  }
  return -1;
}

void Unregister(int slot) {
  if (slot >= 0) g_slots[static_cast<std::size_t>(slot)].state.store(0);
}

bool IsSpecial(const std::filesystem::path& target) {
  std::error_code error;
  const auto status = std::filesystem::status(target, error);
  return std::filesystem::exists(status) && !std::filesystem::is_regular_file(status);
}

}  // namespace

TemporaryName::TemporaryName(const std::filesystem::path& target) : target_(target) {
  const std::string ending = ".tmp-" + std::to_string(::getpid());
  name_ = (target.parent_path() / ("." + target.filename().string() + ending)).string();
  ::unlink(name_.c_str());
  slot_ = Register(name_);
}

TemporaryName::~TemporaryName() {
  if (name_.empty()) return;
  ::unlink(name_.c_str());
  Unregister(slot_);
}

void TemporaryName::Commit() {
  if (std::rename(name_.c_str(), target_.c_str()) != 0) {
    throw InputError(FilePlace{target_.string(), 0, ""},
                     std::string("cannot be replaced: ") + std::strerror(errno));
  }
  Unregister(slot_);
  name_.clear();
}

struct AtomicFile::State {
  std::filesystem::path target;
  std::optional<TemporaryName> temporary;  // nothing: written directly
  int descriptor = -1;
  gzFile gzip = nullptr;
  std::string buffer;

  void Close() {
    if (gzip != nullptr) gzclose_w(gzip);
    if (gzip == nullptr && descriptor >= 0) ::close(descriptor);
    gzip = nullptr;
    descriptor = -1;
  }
  ~State() { Close(); }
};

AtomicFile::AtomicFile(const std::filesystem::path& target, Compression compression)
    : state_(std::make_unique<State>()) {
  state_->target = target;
  state_->buffer.reserve(kBufferBytes);
  std::string name = target.string();
  int flags = O_WRONLY | O_CLOEXEC;
  if (!IsSpecial(target)) {
    name = state_->temporary.emplace(target).name();
    flags |= O_CREAT | O_EXCL;
  }
  state_->descriptor = ::open(name.c_str(), flags, 0666);
  if (state_->descriptor < 0) Fail("cannot be written");
  if (compression == Compression::kGzip) {
    state_->gzip = gzdopen(state_->descriptor, "wb");
    if (state_->gzip == nullptr) Fail("cannot be written");
    gzbuffer(state_->gzip, 1u << 17);
  }
}

AtomicFile::~AtomicFile() = default;
AtomicFile::AtomicFile(AtomicFile&&) noexcept = default;

void AtomicFile::Write(std::string_view text) {
  if (state_->buffer.size() + text.size() > kBufferBytes) Flush();
  if (text.size() > kBufferBytes) {
    WriteThrough(text);
  } else {
    state_->buffer += text;
  }
}

void AtomicFile::Flush() {
  WriteThrough(state_->buffer);
  state_->buffer.clear();
}

void AtomicFile::WriteThrough(std::string_view text) {
  while (!text.empty()) {
    const std::size_t size = std::min<std::size_t>(text.size(), std::size_t{1} << 30);
    errno = 0;
    const auto done = state_->gzip != nullptr
                          ? gzwrite(state_->gzip, text.data(), static_cast<unsigned>(size))
                          : ::write(state_->descriptor, text.data(), size);
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) Fail("writing failed");
    text.remove_prefix(static_cast<std::size_t>(done));
  }
}

void AtomicFile::Commit() {
  Flush();
  errno = 0;
  const bool gzip = state_->gzip != nullptr;
  const int code = gzip ? gzclose_w(state_->gzip) : ::close(state_->descriptor);
  state_->gzip = nullptr;
  state_->descriptor = -1;
  if (code != 0) Fail("writing failed");
  if (state_->temporary) state_->temporary->Commit();
}

void AtomicFile::Fail(const std::string& doing) {
  const std::string reason = errno != 0 ? std::strerror(errno) : "compression failed";
  throw InputError(FilePlace{state_->target.string(), 0, ""}, doing + ": " + reason);
}

void RemoveOpenTemporaryFiles() noexcept {
  for (Slot& slot : g_slots) {
    if (slot.state.load() == 2) ::unlink(slot.name);
  }
}

std::filesystem::path FileOf(const std::filesystem::path& owner, const std::string& name) {
  if (!std::filesystem::is_regular_file(owner)) return owner / name;
  return owner.parent_path() / (owner.stem().string() + "." + name);
}

void MakeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder, error)) {
    throw InputError(FilePlace{folder.string(), 0, ""},
                     "cannot be made a folder: " +
                         (error ? error.message() : std::string("a file has this name")));
  }
}

}  // namespace sarblock
