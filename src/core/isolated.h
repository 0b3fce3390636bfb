// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

namespace sarblock {

/// Runs work so that this thread, while a loop inside (parallel.h) waits for its last pieces, takes
/// up no piece of a loop outside: large pieces that contain loops of their own begin one after the
/// other, not one inside the other.
void RunIsolated(const std::function<void()>& work);

}  // namespace sarblock
