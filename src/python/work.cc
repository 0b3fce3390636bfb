// SPDX-License-Identifier: Apache-2.0
#include "work.h"

#include "sarblock/core/error.h"
#include "sarblock/core/progress.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <string>
#include <thread>

#include "arrays.h"
#include "linear/dense.h"

namespace sarblock::python {
namespace {

namespace py = pybind11;

/// How far the work is; passed from its thread to the one that waits.
struct Report {
  std::string stage = "work";
  std::size_t done = 0, total = 0;
  std::string detail;
};

class Relay final : public ProgressSink {
 public:
  void Update(std::string_view stage,
              std::size_t done,
              std::size_t total,
              std::string_view detail) override {
    const std::lock_guard lock(mutex_);
    report_.stage = stage;
    report_.done = done;
    report_.total = total;
    report_.detail = detail;
    fresh_ = true;
  }
  [[nodiscard]] bool Cancelled() const override { return cancelled_.load(); }

  void Cancel() { cancelled_.store(true); }
  void End() {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    changed_.notify_one();
  }
  /// Waits for the end of the work, not longer than `most`; whether it has ended.
  [[nodiscard]] bool WaitForEnd(std::chrono::milliseconds most) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, most, [this] { return ended_; });
  }
  /// What was reported since the last call.
  [[nodiscard]] std::optional<Report> News() {
    const std::lock_guard lock(mutex_);
    if (!std::exchange(fresh_, false)) return std::nullopt;
    return report_;
  }
  /// The last that was reported.
  [[nodiscard]] std::string Stage() {
    const std::lock_guard lock(mutex_);
    return report_.stage;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::atomic<bool> cancelled_{false};
  Report report_;
  bool fresh_ = false, ended_ = false;
};

/// What Python raised while the work went on.
using Raised = std::optional<py::error_already_set>;

/// Requires the interpreter lock.
void Listen(const py::object& progress, Relay* relay, Raised* raised) {
  if (*raised) return;
  try {
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (progress.is_none()) return;
    if (const auto news = relay->News()) {
      progress(news->stage, news->done, news->total, TextObject(news->detail));
    }
  } catch (const py::error_already_set& error) {
    raised->emplace(error);
    relay->Cancel();
  }
}

}  // namespace

void RunUnlocked(const py::object& progress, const std::function<void(ProgressSink*)>& work) {
  constexpr std::chrono::milliseconds kListenEvery{50};
  Relay relay;
  std::exception_ptr failure;
  Raised raised;
  std::thread worker([&] {
    {
      const dense::BlasThreadsKept kept;
      try {
        const CancellationScope scope(relay);
        work(&relay);
      } catch (...) {
        failure = std::current_exception();
      }
    }
    relay.End();
  });
  {
    const py::gil_scoped_release unlocked;
    while (!relay.WaitForEnd(kListenEvery)) {
      const py::gil_scoped_acquire locked;
      Listen(progress, &relay, &raised);
    }
    worker.join();
  }
  if (!raised && failure) std::rethrow_exception(failure);
  Listen(progress, &relay, &raised);  // the last report
  if (!raised) return;
  if (raised->matches(PyExc_KeyboardInterrupt)) throw Interrupted(relay.Stage());
  throw *raised;
}

}  // namespace sarblock::python
