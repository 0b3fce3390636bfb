// SPDX-License-Identifier: Apache-2.0
#include "json_numbers.h"

#include <cmath>

#include "core/text.h"
#include <fmt/core.h>

namespace sarblock {

double FiniteNumber(const JsonValue& value) {
  const double number = value.Number();
  if (!std::isfinite(number)) value.Fail("a finite number is needed");
  return number;
}

double PositiveNumber(const JsonValue& value) {
  const double number = FiniteNumber(value);
  if (!(number > 0.0)) value.Fail(NumberText(number) + " is not allowed, a number above 0 is");
  return number;
}

std::vector<double> FiniteNumbers(const JsonValue& list) {
  std::vector<double> numbers;
  for (const JsonValue& entry : list.Entries()) numbers.push_back(FiniteNumber(entry));
  return numbers;
}

std::vector<double> FiniteNumbers(const JsonValue& list, std::size_t count) {
  std::vector<double> numbers = FiniteNumbers(list);
  if (numbers.size() != count) {
    list.Fail(fmt::format("has {} numbers, {} is needed", numbers.size(), count));
  }
  return numbers;
}

Eigen::Vector3d FiniteVector(const JsonValue& list) {
  const std::vector<double> numbers = FiniteNumbers(list, 3);
  return {numbers[0], numbers[1], numbers[2]};
}

std::uint64_t CountOfOne(const JsonValue& value) {
  const std::uint64_t count = value.Count();
  if (count == 0 || count > (1ULL << 53U)) value.Fail("an integer of 1 or more is needed");
  return count;
}

}  // namespace sarblock
