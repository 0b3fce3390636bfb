// SPDX-License-Identifier: Apache-2.0
#include "scratch.h"

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <utility>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

namespace sarblock {
namespace {

thread_local const ScratchScope* current = nullptr;

/// Arrays begin behind the first of these bytes of their file; few other allocations begin at such
/// an address.
constexpr std::size_t kPage = 4096;

/// Stands at the beginning of a mapped file. A list of these needs no allocation, which operator
/// delete could not have.
struct Entry {
  std::size_t bytes = 0;  ///< of the whole file
  Entry* next = nullptr;
};

std::mutex list_mutex;
Entry* first_entry = nullptr;
std::atomic<std::size_t> entry_count{0};

void* ArrayOf(Entry* entry) { return reinterpret_cast<std::byte*>(entry) + kPage; }

[[noreturn]] void Refuse(const std::filesystem::path& folder, std::size_t bytes, int reason) {
  throw ScratchError(folder.string() + ": has no place for a scratch file" +
                     (bytes > 0 ? " of " + std::to_string(bytes >> 20) + " MiB" : "") + ": " +
                     std::strerror(reason) +
                     "; --scratch takes a folder that can be written, with room for all arrays by "
                     "look and by point (sarblock check)");
}

/// A file without a name.
class ScratchFile {
 public:
  explicit ScratchFile(const std::filesystem::path& folder)
      : descriptor_(::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600)) {
    if (descriptor_ >= 0) return;
    // Not every file system makes files without a name.
    if (errno != EOPNOTSUPP && errno != EISDIR) Refuse(folder, 0, errno);
    std::string name = (folder / "sarblock-XXXXXX").string();
    descriptor_ = ::mkostemp(name.data(), O_CLOEXEC);
    if (descriptor_ < 0) Refuse(folder, 0, errno);
    ::unlink(name.c_str());
  }
  ~ScratchFile() { ::close(descriptor_); }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  /// Takes its space on disk; the number of an error, or 0.
  [[nodiscard]] int Take(std::size_t bytes) const {
    // Beyond this limit the kernel sends a signal.
    rlimit limit{};
    if (::getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur < bytes) return EFBIG;
    int failed = 0;
    do {
      failed = ::posix_fallocate(descriptor_, 0, static_cast<off_t>(bytes));
    } while (failed == EINTR);
    return failed;
  }

  /// Null, with errno, where it cannot be mapped.
  [[nodiscard]] void* Map(std::size_t bytes) const {
    void* array = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor_, 0);
    return array == MAP_FAILED ? nullptr : array;
  }

 private:
  int descriptor_;
};

}  // namespace

ScratchScope::ScratchScope(std::filesystem::path folder)
    : folder_(std::move(folder)), outer_(current) {
  const ScratchFile trial(folder_);
  current = this;
}

ScratchScope::~ScratchScope() { current = outer_; }

const ScratchScope* ScratchScope::Current() { return current; }

ResidentScope::ResidentScope() : outer_(std::exchange(current, nullptr)) {}

ResidentScope::~ResidentScope() { current = outer_; }

void* AllocateScratch(std::size_t bytes) {
  if (bytes < kScratchLeastBytes || current == nullptr) return nullptr;
  const std::filesystem::path& folder = current->folder();
  const std::size_t whole = bytes + kPage;
  const ScratchFile file(folder);
  if (const int failed = file.Take(whole); failed != 0) Refuse(folder, bytes, failed);
  void* begin = file.Map(whole);
  if (begin == nullptr) Refuse(folder, bytes, errno);
  auto* entry = new (begin) Entry{whole, nullptr};
  const std::lock_guard lock(list_mutex);
  entry->next = std::exchange(first_entry, entry);
  ++entry_count;
  return ArrayOf(entry);
}

bool FreeScratch(void* array) noexcept {
  if (array == nullptr || reinterpret_cast<std::uintptr_t>(array) % kPage != 0) return false;
  if (entry_count == 0) return false;
  Entry* found = nullptr;
  {
    const std::lock_guard lock(list_mutex);
    Entry** place = &first_entry;
    while (*place != nullptr && ArrayOf(*place) != array) place = &(*place)->next;
    found = *place;
    if (found == nullptr) return false;
    *place = found->next;
    --entry_count;
  }
  ::munmap(found, found->bytes);
  return true;
}

}  // namespace sarblock
