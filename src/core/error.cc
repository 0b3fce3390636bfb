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

InputError::InputError(const FilePlace& place, const std::string& problem)
    : std::runtime_error(Message(place, problem)) {}

InputError::InputError(const std::string& field, const std::string& problem)
    : std::runtime_error(Message({.file = {}, .line = 0, .field = field}, problem)) {}

UndeterminedError::UndeterminedError(const std::string& problem, std::vector<std::string> names)
    : std::runtime_error(Listed(problem, names)), names_(std::move(names)) {}

Interrupted::Interrupted(const std::string& stage)
    : std::runtime_error("interrupted during " + stage) {}

const char* Version() { return SARBLOCK_VERSION; }

}  // namespace sarblock
