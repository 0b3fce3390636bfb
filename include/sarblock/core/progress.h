// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace sarblock {

/// Receives the progress of long work. The library prints nothing: the command line draws a bar.
/// What Update() throws ends the work and comes out of the call.
class ProgressSink {
 public:
  virtual ~ProgressSink() = default;
  /// A named stage is `done` of `total` (total 0: unknown). `detail` is for people. Calls come from
  /// one thread at a time.
  virtual void Update(std::string_view stage,
                      std::size_t done,
                      std::size_t total,
                      std::string_view detail) = 0;
  /// True once the user asked to stop: work ends soon, within a loop over points too, by throwing
  /// Interrupted. Must answer any thread, several at once.
  [[nodiscard]] virtual bool Cancelled() const = 0;
};

/// Wall time of one stage of a run and the process's peak memory at its end.
struct StageCost {
  std::string stage;  ///< read, start, solve, covariance, quality, write
  double wall_s = 0.0;
  double peak_mib = 0.0;  ///< largest resident set of the process so far
};

/// Updates `sink` if there is one; throws Interrupted(stage) if it was cancelled.
void Step(ProgressSink* sink,
          std::string_view stage,
          std::size_t done,
          std::size_t total,
          std::string_view detail = {});

/// One of `count` parts of a series of tasks: those, counted from 0, whose number modulo `count` is
/// `index`. Parts are for several processes or machines; every task is in one of them.
struct TaskPart {
  std::size_t index = 0, count = 1;

  [[nodiscard]] bool IsWhole() const { return count == 1; }
  [[nodiscard]] bool Holds(std::size_t task) const { return task % count == index; }
  /// How many of `tasks` tasks it holds.
  [[nodiscard]] std::size_t TasksOf(std::size_t tasks) const;
  bool operator==(const TaskPart&) const = default;
};

/// "part 3/8" as --part takes it, 8/8 that of index 0.
[[nodiscard]] std::string NameOf(const TaskPart& part);

/// "I/N" with 0 <= I <= N and 1 <= N <= kMaxParts: the tasks I modulo N, 0 and N the same, so that
/// job arrays may count from 0 or from 1. Nothing for another text.
inline constexpr std::size_t kMaxParts = 1000000;
[[nodiscard]] std::optional<TaskPart> TaskPartOf(const std::string& text);

}  // namespace sarblock
