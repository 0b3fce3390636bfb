// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/task_part.h"

#include <charconv>
#include <system_error>

namespace sarblock {

std::size_t TaskPart::TasksOf(std::size_t tasks) const {
  return count > 0 && index < tasks ? (tasks - index - 1) / count + 1 : 0;
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
      !number(slash + 1, text.size(), &part.count) || part.count < 1 || part.count > kMostParts ||
      part.index > part.count) {
    return std::nullopt;
  }
  part.index %= part.count;
  return part;
}

}  // namespace sarblock
