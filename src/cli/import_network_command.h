// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "session.h"
#include <CLI/CLI.hpp>

namespace sarblock::cli {

/// Adds `isis` and `csm` to the command `import`.
void AddNetworkImports(CLI::App* group, Session* session);

}  // namespace sarblock::cli
