// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sarblock::cli {

/// Exit codes (interface.md).
enum ExitCode : int {
  kAccepted = 0,
  kNotAccepted = 1,
  kWrongUsage = 2,
  kBadInput = 3,
  kUndetermined = 4,
  kInternalError = 5,
};

}  // namespace sarblock::cli
