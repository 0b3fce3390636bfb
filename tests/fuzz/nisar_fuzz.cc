// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <string>

#include "nisar_fuzz_targets.h"
#include <unistd.h>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("nisar_fuzz-" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  sarblock::fuzz::Nisar({reinterpret_cast<const char*>(data), size}, folder);
  return 0;
}
