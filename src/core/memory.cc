// SPDX-License-Identifier: Apache-2.0
#include "memory.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>
#include <mutex>
#include <optional>
#include <sstream>
#include <string>
#include <utility>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

namespace sarblock {
namespace {

namespace fs = std::filesystem;

constexpr double kUnlimited_bytes = std::numeric_limits<double>::infinity();

/// The number in a file of one number; nothing where there is none ("max").
std::optional<double> NumberIn(const fs::path& file) {
  std::ifstream in(file);
  double value = 0.0;
  if (in >> value) return value;
  return std::nullopt;
}

/// The number behind a name in a file of lines "name number" or "name: number".
std::optional<double> NumberAfter(const fs::path& file, const std::string& name) {
  std::ifstream in(file);
  std::string line;
  while (std::getline(in, line)) {
    std::istringstream words(line);
    std::string first;
    double value = 0.0;
    if (words >> first && (first == name || first == name + ":") && words >> value) return value;
  }
  return std::nullopt;
}

/// Names of a control group's files.
struct GroupFiles {
  const char* limit;
  const char* usage;
  const char* cache;  ///< in memory.stat
};
constexpr GroupFiles kVersion1{"memory.limit_in_bytes", "memory.usage_in_bytes", "total_cache"};
constexpr GroupFiles kVersion2{"memory.max", "memory.current", "file"};

/// Memory that a group and the groups around it leave.
double FreeByGroups(const fs::path& mount, const fs::path& group, const GroupFiles& files) {
  double left_bytes = kUnlimited_bytes;
  for (fs::path at = group.relative_path();; at = at.parent_path()) {
    const fs::path folder = at.empty() ? mount : mount / at;
    const std::optional<double> limit = NumberIn(folder / files.limit);
    const std::optional<double> usage = NumberIn(folder / files.usage);
    if (limit && usage) {
      const double cache = NumberAfter(folder / "memory.stat", files.cache).value_or(0.0);
      left_bytes = std::min(left_bytes, std::max(0.0, *limit - std::max(0.0, *usage - cache)));
    }
    if (at.empty()) return left_bytes;
  }
}

}  // namespace

double AvailableMemory_bytes(const fs::path& root) {
  double left_bytes = kUnlimited_bytes;
  if (const auto kib = NumberAfter(root / "proc/meminfo", "MemAvailable")) {
    left_bytes = 1024.0 * *kib;
  }
  // "Max address space  LIMIT  LIMIT  bytes", a number or "unlimited".
  std::ifstream limits(root / "proc/self/limits");
  const std::string name = "Max address space";
  for (std::string row; std::getline(limits, row);) {
    if (!row.starts_with(name)) continue;
    double limit_bytes = 0.0;
    const auto pages = NumberIn(root / "proc/self/statm");  // that this process has asked for
    if (!(std::istringstream(row.substr(name.size())) >> limit_bytes) || !pages) break;
    const double asked_bytes = *pages * static_cast<double>(::sysconf(_SC_PAGESIZE));
    left_bytes = std::min(left_bytes, std::max(0.0, limit_bytes - asked_bytes));
  }
  std::ifstream groups(root / "proc/self/cgroup");
  std::string line;  // "0::/path" of version 2, "4:memory:/path" of version 1
  while (std::getline(groups, line)) {
    const std::size_t first = line.find(':');
    const std::size_t second = first == std::string::npos ? first : line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    const fs::path group = line.substr(second + 1);
    const fs::path mounted = root / "sys/fs/cgroup";
    if (controllers == ",,") {
      left_bytes = std::min(left_bytes, FreeByGroups(mounted, group, kVersion2));
    } else if (controllers.find(",memory,") != std::string::npos) {
      left_bytes = std::min(left_bytes, FreeByGroups(mounted / "memory", group, kVersion1));
    }
  }
  return left_bytes;
}

void PreferLargePages(void* array, std::size_t bytes) {
  constexpr std::uintptr_t kLargePage = std::uintptr_t{2} << 20;
  const auto begin = reinterpret_cast<std::uintptr_t>(array);
  // Whole ones that belong to nobody else.
  const std::uintptr_t first = (begin + kLargePage - 1) / kLargePage * kLargePage;
  const std::uintptr_t last = (begin + bytes) / kLargePage * kLargePage;
  if (first < last) ::madvise(reinterpret_cast<void*>(first), last - first, MADV_HUGEPAGE);
}

namespace {

thread_local const ScratchScope* current = nullptr;

/// Arrays begin behind the first of these bytes of their file; few other allocations begin at such
/// an address.
constexpr std::size_t kPage = 4096;

/// Header at the beginning of a mapped file. A list of these needs no allocation, which operator
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
  if (bytes < kScratchMinBytes || current == nullptr) return nullptr;
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
