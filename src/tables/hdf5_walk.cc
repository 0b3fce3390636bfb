// SPDX-License-Identifier: Apache-2.0
// The program that walks through an HDF5 file before another process reads it (hdf5_file.h).
// usage: hdf5_walk FILE BYTES
#include <algorithm>
#include <array>
#include <charconv>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <set>
#include <string>
#include <vector>

#include "hdf5_file.h"
#include <malloc.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#ifdef __SANITIZE_ADDRESS__  // gcc
#define SARBLOCK_ADDRESS_SANITIZER
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define SARBLOCK_ADDRESS_SANITIZER
#endif
#endif

namespace sarblock {
namespace {

/// Datasets up to this size are read whole.
constexpr std::uint64_t kWholeBytes = std::uint64_t{1} << 20;
/// A walk of a file of ours takes milliseconds; one of 10 GB that stores chunks of 64 KiB a second.
constexpr rlim_t kMinSeconds = 10;
constexpr std::uint64_t kBytesPerSecond = std::uint64_t{100} << 20;
[[maybe_unused]] constexpr std::uint64_t kMinMemoryBytes = std::uint64_t{2} << 30;

/// All that can be opened in a file. Nothing is reported: what counts is that it comes to its end.
class Walk {
 public:
  void Through(const char* path) {
    const QuietHdf5 quiet;
    const Hdf5Id file(H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
    if (file.valid()) Open(file.get(), "/", 0);
  }

 private:
  static constexpr int kMaxDepth = 64;
  static constexpr std::size_t kMaxOpened = 1000000;

  void Open(hid_t parent, const std::string& name, int depth) {
    const Hdf5Id object(H5Oopen(parent, name.c_str(), H5P_DEFAULT), H5Oclose);
    if (!object.valid() || depth > kMaxDepth || ++opened_ > kMaxOpened) return;
    H5O_info_t info;  // an object without this information is read all the same
    if (H5Oget_info(object.get(), &info) >= 0 && !seen_.insert(info.addr).second) return;
    ReadAttributes(object.get());
    const H5I_type_t kind = H5Iget_type(object.get());
    if (kind == H5I_DATASET) {
      // Without a cache values are not copied; as the reader opens what is not deflated.
      const Hdf5Id access = ColumnAccess(0);
      const Hdf5Id dataset(H5Dopen2(parent, name.c_str(), access.get()), H5Dclose);
      ReadValues(dataset.valid() ? dataset.get() : object.get());
    }
    if (kind != H5I_GROUP) return;
    // Both ways to the members, for one may fail where the other does not.
    std::vector<std::string> names = MembersOf(object.get());
    H5Literate(object.get(), H5_INDEX_NAME, H5_ITER_NATIVE, nullptr, &Collect, &names);
    std::sort(names.begin(), names.end());
    names.erase(std::unique(names.begin(), names.end()), names.end());
    for (const std::string& member : names) {
      H5L_info_t link;
      if (H5Lget_info(object.get(), member.c_str(), &link, H5P_DEFAULT) < 0) continue;
      if (link.type == H5L_TYPE_HARD) Open(object.get(), member, depth + 1);
    }
  }
  static herr_t Collect(hid_t, const char* name, const H5L_info_t*, void* names) {
    static_cast<std::vector<std::string>*>(names)->emplace_back(name);
    return 0;
  }

  void ReadAttributes(hid_t object) {
    const int count = H5Aget_num_attrs(object);
    for (int i = 0; i < count; ++i) {
      const Hdf5Id attribute(H5Aopen_by_idx(object,
                                            ".",
                                            H5_INDEX_NAME,
                                            H5_ITER_NATIVE,
                                            static_cast<hsize_t>(i),
                                            H5P_DEFAULT,
                                            H5P_DEFAULT),
                             H5Aclose);
      if (!attribute.valid()) continue;
      const Hdf5Id type(H5Aget_type(attribute.get()), H5Tclose);
      const Hdf5Id space(H5Aget_space(attribute.get()), H5Sclose);
      if (!type.valid() || !space.valid()) continue;
      Into(type.get(), space.get(), [&](void* values) {
        return H5Aread(attribute.get(), type.get(), values);
      });
    }
  }

  void ReadValues(hid_t dataset) {
    const Hdf5Id type(H5Dget_type(dataset), H5Tclose);
    const Hdf5Id space(H5Dget_space(dataset), H5Sclose);
    const Hdf5Id made(H5Dget_create_plist(dataset), H5Pclose);
    if (!type.valid() || !space.valid() || !made.valid()) return;
    hsize_t chunks = 0;
    if (H5Pget_layout(made.get()) == H5D_CHUNKED) {
      H5Dget_num_chunks(dataset, space.get(), &chunks);
    }
    static_cast<void>(H5Dget_storage_size(dataset));
    const auto read = [&](hid_t memory, hid_t from) {
      return [&, memory, from](void* values) {
        return H5Dread(dataset, type.get(), memory, from, H5P_DEFAULT, values);
      };
    };
    if (Into(type.get(), space.get(), read(H5S_ALL, H5S_ALL))) return;
    // The first and the last row of values, 1024 of them at most.
    std::array<hsize_t, H5S_MAX_RANK> size{}, start{}, count{};
    const int rank = H5Sget_simple_extent_ndims(space.get());
    if (rank < 1 || H5Sget_simple_extent_dims(space.get(), size.data(), nullptr) < 0) return;
    count.fill(1);
    count[static_cast<std::size_t>(rank - 1)] =
        std::min<hsize_t>(1024, size[static_cast<std::size_t>(rank - 1)]);
    const Hdf5Id memory(H5Screate_simple(rank, count.data(), nullptr), H5Sclose);
    for (const bool last : {false, true}) {
      for (std::size_t i = 0; last && i < static_cast<std::size_t>(rank); ++i) {
        start[i] = size[i] - count[i];
      }
      if (H5Sselect_hyperslab(
              space.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr) >= 0) {
        Into(type.get(), memory.get(), read(memory.get(), space.get()));
      }
    }
  }

  /// Reads as many values as a space has; false where they are too many for that.
  template <typename Read>
  bool Into(hid_t type, hid_t space, const Read& read) {
    const hssize_t count = H5Sget_simple_extent_npoints(space);
    const std::size_t each = H5Tget_size(type);
    if (count <= 0 || each == 0) return true;
    if (static_cast<std::uint64_t>(count) > kWholeBytes / each) return false;
    buffer_.assign(static_cast<std::size_t>(count) * each, std::byte{0});
    const bool there = read(static_cast<void*>(buffer_.data())) >= 0;
    const bool variable = H5Tis_variable_str(type) > 0 || H5Tdetect_class(type, H5T_VLEN) > 0;
    if (there && variable) H5Dvlen_reclaim(type, space, H5P_DEFAULT, buffer_.data());
    return true;
  }

  std::set<haddr_t> seen_;
  std::size_t opened_ = 0;
  std::vector<std::byte> buffer_;
};

void Limit(int resource, rlim_t value) {
  const rlimit limit{value, value};
  setrlimit(static_cast<__rlimit_resource_t>(resource), &limit);
}

/// A walk must not take all memory; processes with sanitizers ask for terabytes.
void LimitMemory([[maybe_unused]] std::uint64_t bytes) {
#ifndef SARBLOCK_ADDRESS_SANITIZER
  unsigned long pages = 0;  // that this process has asked for, its code among them
  if (std::FILE* const file = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(file, "%lu", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  const std::uint64_t asked = pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  Limit(RLIMIT_AS, asked + kMinMemoryBytes + 4 * bytes);
#endif
}

void Say(const char* word) {
  if (write(STDOUT_FILENO, word, std::strlen(word)) < 0) _exit(1);
}

}  // namespace
}  // namespace sarblock

int main(int argc, char** argv) {
  using namespace sarblock;
  std::uint64_t bytes = 0;
  if (argc != 3 ||
      std::from_chars(argv[2], argv[2] + std::strlen(argv[2]), bytes).ec != std::errc()) {
    return 2;
  }
  Say(kWalkBegins);
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // nobody waits any more
  std::signal(SIGINT, SIG_IGN);      // the process that waits answers it
  // Memory that libhdf5 reads without having written it is zero in one process and a pointer in
  // another; here it is filled with a harmful pattern, and no block comes from libhdf5's free
  // lists.
  mallopt(M_PERTURB, 0x5a);
  H5set_free_list_limits(0, 0, 0, 0, 0, 0);
  Limit(RLIMIT_CORE, 0);
  Limit(RLIMIT_CPU, kMinSeconds + static_cast<rlim_t>(bytes / kBytesPerSecond));
  LimitMemory(bytes);
  Walk().Through(argv[1]);
  Say(kWalkEnds);
  _exit(0);
}
