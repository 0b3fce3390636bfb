// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

namespace sarblock {

/// Refuses options that this build does not offer, by name.
void RequireOffered(const AdjustOptions& options);

/// For commands that adjust nothing: refuses `montecarlo` and says that variance components are not
/// estimated.
void RefuseRepetition(const AdjustOptions& options, const char* command, AdjustResult* result);

}  // namespace sarblock
