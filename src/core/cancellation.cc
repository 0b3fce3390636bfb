// SPDX-License-Identifier: Apache-2.0
#include "cancellation.h"

#include <utility>

namespace sarblock {
namespace {

thread_local const ProgressSink* t_current = nullptr;

}  // namespace

CancellationScope::CancellationScope(const ProgressSink& sink)
    : outer_(std::exchange(t_current, &sink)) {}
CancellationScope::~CancellationScope() { t_current = outer_; }

const ProgressSink* CancellationScope::Current() { return t_current; }

}  // namespace sarblock
