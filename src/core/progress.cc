// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/progress.h"

#include "sarblock/core/error.h"

#include <charconv>
#include <string>
#include <system_error>

namespace sarblock {

void Step(ProgressSink* sink,
          std::string_view stage,
          std::size_t done,
          std::size_t total,
          std::string_view detail) {
  if (sink == nullptr) return;
  sink->Update(stage, done, total, detail);
  if (sink->Cancelled()) throw Interrupted(std::string(stage));
}

std::size_t TaskPart::TasksOf(std::size_t tasks) const {
  return index < tasks ? (tasks - index - 1) / count + 1 : 0;
}

std::string NameOf(const TaskPart& part) {
  const std::size_t number = part.index == 0 ? part.count : part.index;
  return "part " + std::to_string(number) + "/" + std::to_string(part.count);
}

std::optional<TaskPart> TaskPartOf(const std::string& text) {
  const std::size_t slash = text.find('/');
  const auto number = [&](std::size_t from, std::size_t to, std::size_t* value) {
    const auto [end, error] = std::from_chars(text.data() + from, text.data() + to, *value);
    return from < to && error == std::errc() && end == text.data() + to;
  };
  TaskPart part;
  if (slash == std::string::npos || !number(0, slash, &part.index) ||
      !number(slash + 1, text.size(), &part.count) || part.count < 1 || part.count > kMaxParts ||
      part.index > part.count) {
    return std::nullopt;
  }
  part.index %= part.count;
  return part;
}

}  // namespace sarblock
