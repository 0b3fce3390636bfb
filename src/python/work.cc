// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/core/progress.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <set>
#include <string>
#include <thread>

#include "arrays.h"
#include "core/threads.h"
#include "linear/dense.h"
#include "module.h"
#include <unistd.h>

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

/// The works that go on, and the threads that ask for the interpreter lock. Until 3.14 Python ends
/// a thread that asks for it once the interpreter ends, by unwinding its stack, which C++ answers
/// with abort(): so from the start of the end on threads wait for ever instead (a daemon's own
/// end).
class Works {
 public:
  /// Never destroyed: daemons may ask when the process is nearly gone.
  static Works& Of() {
    static auto* const works = new Works;
    return *works;
  }

  void Add(Relay* relay) {
    const std::lock_guard lock(mutex_);
    if (std::exchange(process_, ::getpid()) != ::getpid()) {  // a fork copied those of others
      relays_.clear();
      asking_ = 0;
    }
    relays_.insert(relay);
    if (ended() && !IsEnding()) relay->Cancel();
  }
  void Remove(Relay* relay) {
    const std::lock_guard lock(mutex_);
    relays_.erase(relay);
    changed_.notify_all();
  }

  /// Before the interpreter lock is asked for.
  void Ask() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !ended() || IsEnding(); });
    ++asking_;
  }
  /// Once nothing is left to do under the lock that was asked for.
  void Leave() {
    const std::lock_guard lock(mutex_);
    --asking_;
    changed_.notify_all();
  }

  /// The interpreter ends: cancels all works and waits for them, and for those who ask.
  void End() {
    constexpr std::chrono::seconds kMostWait{20};
    const py::gil_scoped_release unlocked;
    std::unique_lock lock(mutex_);
    ended_by_ = std::this_thread::get_id();
    if (process_ != ::getpid()) return;
    for (Relay* relay : relays_) relay->Cancel();
    changed_.wait_for(lock, kMostWait, [this] { return relays_.empty() && asking_ == 0; });
  }

 private:
  [[nodiscard]] bool ended() const { return ended_by_ != std::thread::id(); }
  /// Other functions that end with the interpreter may still call for work.
  [[nodiscard]] bool IsEnding() const { return ended_by_ == std::this_thread::get_id(); }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::set<Relay*> relays_;
  int asking_ = 0;
  std::thread::id ended_by_;  ///< of no thread while it does not end
  pid_t process_ = 0;
};

/// The interpreter lock is released in its scope, and at its end asked for.
class Unlocked {
 public:
  Unlocked() : state_(PyEval_SaveThread()) {}
  ~Unlocked() {
    Works::Of().Ask();
    PyEval_RestoreThread(state_);
    Works::Of().Leave();
  }
  Unlocked(const Unlocked&) = delete;
  Unlocked& operator=(const Unlocked&) = delete;

 private:
  PyThreadState* state_;
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
  Works::Of().Add(&relay);
  std::thread worker([&] {
    {
      const dense::BlasThreadsKept kept;
      try {
        const CancellationScope scope(&relay);
        work(&relay);
      } catch (...) {
        failure = std::current_exception();
      }
    }
    relay.End();
    Works::Of().Remove(&relay);
  });
  {
    const Unlocked unlocked;
    while (!relay.WaitForEnd(kListenEvery)) {
      Works::Of().Ask();
      {
        const py::gil_scoped_acquire locked;
        Listen(progress, &relay, &raised);
      }
      Works::Of().Leave();
    }
    worker.join();
  }
  if (!raised && failure) std::rethrow_exception(failure);
  Listen(progress, &relay, &raised);  // the last report
  if (!raised) return;
  if (raised->matches(PyExc_KeyboardInterrupt)) throw Interrupted(relay.Stage());
  throw *raised;
}

void EndWorkWithInterpreter() {
  py::module_::import("atexit").attr("register")(py::cpp_function([] { Works::Of().End(); }));
}

}  // namespace sarblock::python
