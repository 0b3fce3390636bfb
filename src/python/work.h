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
/// that other Python threads run. At least ten times per second the caller checks for signals and
/// calls `progress`, None or a callable (stage, done, total, detail), with the progress. Ctrl-C
/// asks the work to end and throws Interrupted; any other exception of a signal handler or of the
/// callable is thrown once the work has ended. BLAS then has as many threads as before.
void RunUnlocked(const pybind11::object& progress, const std::function<void(ProgressSink*)>& work);

/// Work that goes on in daemon threads when the interpreter ends is cancelled and waited for; their
/// threads then wait for the end of the process. Called once, when the module is imported.
void EndWorkWithInterpreter();

/// The same for work that returns something.
template <typename Work>
[[nodiscard]] auto RunWork(const pybind11::object& progress, const Work& work) {
  std::optional<std::invoke_result_t<Work, ProgressSink*>> out;
  RunUnlocked(progress, [&](ProgressSink* sink) { out.emplace(work(sink)); });
  return std::move(*out);
}

}  // namespace sarblock::python
