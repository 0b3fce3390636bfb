// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

#include <utility>

namespace sarblock {
namespace {

std::string Message(const FilePlace& place, const std::string& problem) {
  std::string text = place.file;
  if (!place.file.empty() && place.line > 0) text.append(":").append(std::to_string(place.line));
  if (!text.empty()) text += ": ";
  if (!place.field.empty()) text += place.field + ": ";
  return text + problem;
}

// "A1 range.bias, A2 range.bias and 7 more": enough to act on, short enough to read.
std::string Listed(const std::string& problem, const std::vector<std::string>& names) {
  constexpr std::size_t kShown = 10;
  std::string text = problem;
  for (std::size_t i = 0; i < names.size() && i < kShown; ++i) {
    text.append(i == 0 ? ": " : ", ").append(names[i]);
  }
  if (names.size() > kShown) {
    text.append(" and ").append(std::to_string(names.size() - kShown)).append(" more");
  }
  return text;
}

}  // namespace

InputError::InputError(FilePlace place, std::string problem)
    : Error(Message(place, problem)), place_(std::move(place)), problem_(std::move(problem)) {}

InputError::InputError(std::string field, std::string problem)
    : InputError(FilePlace{.file = {}, .line = 0, .field = std::move(field)}, std::move(problem)) {}

UndeterminedError::UndeterminedError(const std::string& problem, std::vector<std::string> names)
    : Error(Listed(problem, names)), names_(std::move(names)) {}

Interrupted::Interrupted(std::string stage)
    : Error("interrupted during " + stage), stage_(std::move(stage)) {}

static_assert(SARBLOCK_VERSION == SARBLOCK_PROJECT_VERSION_NUMBER, "core/error.h, CMakeLists.txt");
const char* Version() { return SARBLOCK_PROJECT_VERSION; }

}  // namespace sarblock
