// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace sarblock {

/// One of `count` parts of a series of tasks: those, counted from 0, whose number modulo `count` is
/// `index`. Parts are for several processes or machines; together they hold every task once.
struct TaskPart {
  std::size_t index = 0, count = 1;

  /// The part of no task at all, as a join computes none.
  [[nodiscard]] static constexpr TaskPart None() { return {0, 0}; }
  [[nodiscard]] bool IsWhole() const { return count == 1; }
  [[nodiscard]] bool Holds(std::size_t task) const { return count > 0 && task % count == index; }
  /// How many of `tasks` tasks it holds.
  [[nodiscard]] std::size_t TasksOf(std::size_t tasks) const;
  bool operator==(const TaskPart&) const = default;
};

/// "part 3/8" as --part takes it, 8/8 that of index 0.
[[nodiscard]] std::string NameOf(const TaskPart& part);

/// "I/N" with 0 <= I <= N and 1 <= N <= kMostParts: the tasks I modulo N, 0 and N the same, so that
/// job arrays may count from 0 or from 1. Nothing for another text.
inline constexpr std::size_t kMostParts = 1000000;
[[nodiscard]] std::optional<TaskPart> TaskPartOf(const std::string& text);

}  // namespace sarblock
