// SPDX-License-Identifier: Apache-2.0
#include "table_writer.h"

#include "sarblock/core/error.h"

#include <cmath>
#include <string>

namespace sarblock {

void RefuseInfinity(double value, std::string_view file) {
  if (!std::isinf(value)) return;
  throw InputError(FilePlace{std::string(file), 0, ""},
                   "a number became infinite and cannot be written: something that was given is "
                   "too large or too small to compute with");
}

}  // namespace sarblock
