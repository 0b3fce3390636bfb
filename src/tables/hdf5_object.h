// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <hdf5.h>

namespace sarblock {

/// An object of libhdf5, closed when this ends. A negative id is one that could not be made.
class Hdf5Id {
 public:
  Hdf5Id() = default;
  Hdf5Id(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Hdf5Id() { Release(); }
  Hdf5Id(Hdf5Id&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Hdf5Id& operator=(Hdf5Id&& other) noexcept {
    Release();
    id_ = std::exchange(other.id_, -1);
    close_ = other.close_;
    return *this;
  }
  [[nodiscard]] hid_t get() const { return id_; }
  [[nodiscard]] bool valid() const { return id_ >= 0; }
  /// Negative where closing failed, which for a file means that it is not whole.
  herr_t Release() {
    const hid_t id = std::exchange(id_, -1);
    return id >= 0 ? close_(id) : 0;
  }

 private:
  hid_t id_ = -1;
  herr_t (*close_)(hid_t) = nullptr;
};

/// How datasets are opened: with a cache of so many bytes in place of the megabyte that libhdf5
/// gives each: values are moved in order and once.
[[nodiscard]] inline Hdf5Id ColumnAccess(std::size_t cached_bytes) {
  Hdf5Id access(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose);
  H5Pset_chunk_cache(access.get(), 11, cached_bytes, 1.0);
  return access;
}

/// While one of these lives, libhdf5 prints no errors of the thread that made it (ours say what
/// they mean); afterwards it does again what the host program asked for. To be ended in that
/// thread.
class QuietHdf5 {
 public:
  QuietHdf5() : active_(true) {
    Asked& asked = OfThread();
    if (asked.scopes++ > 0) return;
    H5Eget_auto2(H5E_DEFAULT, &asked.print, &asked.data);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~QuietHdf5() {
    if (!active_) return;
    Asked& asked = OfThread();
    if (--asked.scopes == 0) H5Eset_auto2(H5E_DEFAULT, asked.print, asked.data);
  }
  QuietHdf5(QuietHdf5&& other) noexcept : active_(std::exchange(other.active_, false)) {}
  QuietHdf5& operator=(QuietHdf5&&) = delete;

 private:
  struct Asked {
    int scopes = 0;
    H5E_auto2_t print = nullptr;
    void* data = nullptr;
  };
  static Asked& OfThread() {
    thread_local Asked asked;
    return asked;
  }
  bool active_;
};

/// Names of the members of a group in their order, up to 255 characters of each; none where the
/// group cannot be read.
[[nodiscard]] inline std::vector<std::string> MembersOf(hid_t group) {
  std::vector<std::string> names;
  H5G_info_t info;
  if (H5Gget_info(group, &info) < 0) return names;
  for (hsize_t i = 0; i < info.nlinks; ++i) {
    std::array<char, 256> name{};
    if (H5Lget_name_by_idx(
            group, ".", H5_INDEX_NAME, H5_ITER_INC, i, name.data(), name.size(), H5P_DEFAULT) >=
        0) {
      names.emplace_back(name.data());
    }
  }
  return names;
}

}  // namespace sarblock
