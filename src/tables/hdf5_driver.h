// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "hdf5_object.h"

namespace sarblock {

/// A file that libhdf5 writes through a driver of ours, which never tells it of a write that
/// failed: libhdf5 does not bear that it cannot write what it still holds, and crashes as the file
/// is closed or the process ends. What the disk did not take is kept here for reading back until
/// the file is closed; whoever writes asks error() and gives up.
class FailingSafely {
 public:
  FailingSafely();

  /// For H5Fcreate. This object outlives the file.
  [[nodiscard]] Hdf5Id Access();
  /// `errno` of the first write that failed; 0: none did.
  [[nodiscard]] int error() const { return error_; }

  /// The calls of the driver.
  void Write(int descriptor, std::uint64_t at, const char* bytes, std::uint64_t count);
  [[nodiscard]] bool Read(int descriptor, std::uint64_t at, char* bytes, std::uint64_t count);
  void Note(int error) { error_ = error_ != 0 ? error_ : error; }

 private:
  Hdf5Id driver_;
  int error_ = 0;
  std::map<std::uint64_t, std::vector<char>> not_written_;  // by number of a page, pages whole
};

}  // namespace sarblock
