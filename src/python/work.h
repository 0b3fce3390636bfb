// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"

#include <functional>
#include <optional>
#include <type_traits>
#include <utility>

#include <pybind11/pybind11.h>

namespace sarblock::python {

/// Runs `work` in a thread of its own while the caller waits with the interpreter lock released, so
/// that other Python threads run. Ten times a second and more the caller looks for signals and
/// tells `progress`, None or a callable (stage, done, total, detail), how far the work is. Ctrl-C
/// asks the work to end and throws Interrupted; whatever else a signal or the callable raises is
/// thrown once the work has ended. BLAS then has as many threads as before.
void RunUnlocked(const pybind11::object& progress, const std::function<void(ProgressSink*)>& work);

/// The same for work that returns something.
template <typename Work>
[[nodiscard]] auto RunWork(const pybind11::object& progress, const Work& work) {
  std::optional<std::invoke_result_t<Work, ProgressSink*>> out;
  RunUnlocked(progress, [&](ProgressSink* sink) { out.emplace(work(sink)); });
  return std::move(*out);
}

}  // namespace sarblock::python
