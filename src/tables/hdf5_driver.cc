// SPDX-License-Identifier: Apache-2.0
#include "hdf5_driver.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>

#include <fcntl.h>
#include <unistd.h>

namespace sarblock {
namespace {

constexpr std::uint64_t kPageBytes = 4096;
constexpr haddr_t kMaxAddress = (haddr_t{1} << 62) - 1;

/// What H5Pset_driver() is given, and what stands in the list of properties.
struct Options {
  FailingSafely* owner;
};

struct OpenFile {
  H5FD_t base{};  // first: libhdf5 knows no more of it
  FailingSafely* owner = nullptr;
  int descriptor = -1;
  haddr_t end_allocated = 0, end_of_file = 0;
};

OpenFile* Of(H5FD_t* file) { return reinterpret_cast<OpenFile*>(file); }
const OpenFile* Of(const H5FD_t* file) { return reinterpret_cast<const OpenFile*>(file); }

H5FD_t* Open(const char* name, unsigned flags, hid_t access, haddr_t /*most*/) {
  const auto* options = static_cast<const Options*>(H5Pget_driver_info(access));
  if (options == nullptr || (flags & H5F_ACC_CREAT) == 0) return nullptr;
  auto file = std::make_unique<OpenFile>();
  file->owner = options->owner;
  file->descriptor = ::open(name, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file->descriptor < 0) {
    file->owner->Note(errno);
    return nullptr;
  }
  return &file.release()->base;
}

herr_t Close(H5FD_t* file) {
  const std::unique_ptr<OpenFile> closed(Of(file));
  if (::close(closed->descriptor) != 0) closed->owner->Note(errno);
  return 0;
}

herr_t Query(const H5FD_t* /*file*/, unsigned long* flags) {
  *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
           H5FD_FEAT_AGGREGATE_SMALLDATA | H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
  return 0;
}

haddr_t EndAllocated(const H5FD_t* file, H5FD_mem_t /*kind*/) { return Of(file)->end_allocated; }
herr_t SetEndAllocated(H5FD_t* file, H5FD_mem_t /*kind*/, haddr_t end) {
  Of(file)->end_allocated = end;
  return 0;
}
haddr_t EndOfFile(const H5FD_t* file, H5FD_mem_t /*kind*/) { return Of(file)->end_of_file; }

herr_t Read(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t count, void* bytes) {
  OpenFile& from = *Of(file);
  return from.owner->Read(from.descriptor, at, static_cast<char*>(bytes), count) ? 0 : -1;
}

herr_t Write(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t count, const void* bytes) {
  OpenFile& to = *Of(file);
  to.owner->Write(to.descriptor, at, static_cast<const char*>(bytes), count);
  to.end_of_file = std::max<haddr_t>(to.end_of_file, at + count);
  return 0;
}

herr_t Truncate(H5FD_t* file, hid_t, hbool_t /*closing*/) {
  OpenFile& to = *Of(file);
  if (to.end_of_file == to.end_allocated) return 0;
  if (::ftruncate(to.descriptor, static_cast<off_t>(to.end_allocated)) != 0) to.owner->Note(errno);
  to.end_of_file = to.end_allocated;
  return 0;
}

H5FD_class_t Driver() {
  H5FD_class_t driver{};
#if H5_VERSION_GE(1, 13, 2)
  driver.version = H5FD_CLASS_VERSION;
  driver.value = static_cast<H5FD_class_value_t>(512);  // the first that is free for all
#endif
  driver.name = "sarblock";
  driver.maxaddr = kMaxAddress;
  driver.fc_degree = H5F_CLOSE_STRONG;
  driver.fapl_size = sizeof(Options);
  driver.open = Open;
  driver.close = Close;
  driver.query = Query;
  driver.get_eoa = EndAllocated;
  driver.set_eoa = SetEndAllocated;
  driver.get_eof = EndOfFile;
  driver.read = Read;
  driver.write = Write;
  driver.truncate = Truncate;
  constexpr H5FD_mem_t kLists[] = H5FD_FLMAP_DICHOTOMY;
  std::copy(std::begin(kLists), std::end(kLists), std::begin(driver.fl_map));
  return driver;
}

/// False where the descriptor does not take or give all bytes; errno says why.
template <typename Move>
bool MoveAll(std::uint64_t at, std::uint64_t count, const Move& move) {
  for (std::uint64_t done = 0; done < count;) {
    errno = 0;
    const ssize_t moved = move(done, static_cast<off_t>(at + done), count - done);
    if (moved < 0 && errno == EINTR) continue;
    if (moved <= 0) return false;
    done += static_cast<std::uint64_t>(moved);
  }
  return true;
}

}  // namespace

FailingSafely::FailingSafely() {
  static const H5FD_class_t kDriver = Driver();
  driver_ = Hdf5Id(H5FDregister(&kDriver), H5FDunregister);
}

Hdf5Id FailingSafely::Access() {
  Hdf5Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  const Options options{this};
  H5Pset_driver(access.get(), driver_.get(), &options);
  return access;
}

void FailingSafely::Write(int descriptor,
                          std::uint64_t at,
                          const char* bytes,
                          std::uint64_t count) {
  if (error_ == 0 && MoveAll(at, count, [&](std::uint64_t done, off_t place, std::uint64_t left) {
        return ::pwrite(descriptor, bytes + done, left, place);
      })) {
    return;
  }
  Note(errno != 0 ? errno : ENOSPC);
  for (std::uint64_t done = 0; done < count;) {
    const std::uint64_t page = (at + done) / kPageBytes, offset = (at + done) % kPageBytes;
    const std::uint64_t size = std::min(kPageBytes - offset, count - done);
    std::vector<char>& kept = not_written_[page];
    if (kept.empty()) {
      std::vector<char> whole(kPageBytes);
      const ssize_t got =
          ::pread(descriptor, whole.data(), kPageBytes, static_cast<off_t>(page * kPageBytes));
      static_cast<void>(got);  // what the file has not is zero
      kept = std::move(whole);
    }
    std::memcpy(kept.data() + offset, bytes + done, size);
    done += size;
  }
}

bool FailingSafely::Read(int descriptor, std::uint64_t at, char* bytes, std::uint64_t count) {
  std::uint64_t read = 0;
  while (read < count) {
    const ssize_t got =
        ::pread(descriptor, bytes + read, count - read, static_cast<off_t>(at + read));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return false;
    if (got == 0) break;
    read += static_cast<std::uint64_t>(got);
  }
  std::memset(bytes + read, 0, count - read);  // behind the end, as libhdf5's own driver gives it
  const std::uint64_t end = at + count;
  for (auto page = not_written_.lower_bound(at / kPageBytes);
       page != not_written_.end() && page->first * kPageBytes < end;
       ++page) {
    const std::uint64_t first = std::max(at, page->first * kPageBytes);
    const std::uint64_t last = std::min(end, (page->first + 1) * kPageBytes);
    std::memcpy(bytes + (first - at),
                page->second.data() + (first - page->first * kPageBytes),
                last - first);
  }
  return true;
}

}  // namespace sarblock
