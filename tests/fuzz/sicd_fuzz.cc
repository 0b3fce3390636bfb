// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>

#include "fuzz/sicd_fuzz_targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  sarblock::fuzz::Sicd(bytes);
  sarblock::fuzz::Sicd(sarblock::fuzz::NitfOf(bytes));
  return 0;
}
