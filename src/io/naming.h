// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/error.h"

#include <string>
#include <string_view>

namespace sarblock {

/// What `work` returns; an InputError of it that does not begin with the file or folder `input`,
/// because what throws knows no files, names it.
template <typename Work>
auto Naming(const std::string& input, const Work& work) {
  try {
    return work();
  } catch (const InputError& error) {
    if (std::string_view(error.what()).starts_with(input)) throw;
    throw InputError(FilePlace{input, 0, ""}, error.what());
  }
}

}  // namespace sarblock
