// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/kept_factors.h"

#include <algorithm>

namespace sarblock {

KeptFactors::KeptFactors(std::size_t points, std::size_t parts, std::size_t bytes)
    : begin_(points), part_(points), parts_(parts) {
  for (std::vector<double>& numbers : parts_) numbers.reserve(bytes / sizeof(double) / parts);
}

void KeptFactors::Keep(std::size_t part, std::size_t point, const PointFactor& factor) {
  if (factor.looks_not_evaluated > 0) return;
  std::vector<double>& numbers = parts_[part];
  if (numbers.empty()) numbers.push_back(0.0);
  begin_[point] = numbers.size();
  part_[point] = static_cast<std::uint32_t>(part);
  std::size_t count = 2 + factor.q.size() + factor.e.size() + 9;
  for (int k = 0; k < factor.look_count; ++k) {
    count += 2 * static_cast<std::size_t>(
                     factor.looks[static_cast<std::size_t>(k)].columns.column_count);
  }
  numbers.resize(numbers.size() + count);
  double* number = numbers.data() + begin_[point];
  *number++ = factor.row_count;
  *number++ = factor.look_count;
  number = std::copy(factor.q.begin(), factor.q.end(), number);
  number = std::copy(factor.e.begin(), factor.e.end(), number);
  number = std::copy_n(factor.r.data(), 9, number);
  for (int k = 0; k < factor.look_count; ++k) {
    const WhitenedLook& look = factor.looks[static_cast<std::size_t>(k)];
    for (const auto& row : look.row) {
      number = std::copy_n(row.begin(), look.columns.column_count, number);
    }
  }
}

bool KeptFactors::Restore(const AdjustmentProblem& problem,
                          std::size_t point,
                          PointFactor* out) const {
  if (begin_[point] == kNone) return false;
  const int looks_now = problem.CountLooks(point);
  const double* number = parts_[part_[point]].data() + begin_[point];
  const auto take = [&number](std::size_t count, double* to) {
    std::copy_n(number, count, to);
    number += count;
  };
  out->row_count = static_cast<int>(*number++);
  if (static_cast<int>(*number++) != looks_now) return false;
  const auto m = static_cast<std::size_t>(out->row_count);
  out->q.resize(3 * m);
  out->e.resize(m);
  take(3 * m, out->q.data());
  take(m, out->e.data());
  take(9, out->r.data());
  const Looks& looks = problem.block.looks;
  const std::size_t begin = looks.offsets[point], end = looks.offsets[point + 1];
  if (out->looks.size() < end - begin) out->looks.resize(end - begin);
  out->look_count = 0;
  out->looks_not_evaluated = 0;
  for (std::size_t i = begin; i < end; ++i) {
    if (problem.look_used[i] == 0) continue;
    const auto k = static_cast<std::size_t>(out->look_count++);
    WhitenedLook& look = out->looks[k];
    look.look = i;
    problem.model.ColumnsOf(i, &look.columns);
    look.error_1 = {out->e[2 * k], out->e[2 * k + 1]};
    for (auto& row : look.row)
      take(static_cast<std::size_t>(look.columns.column_count), row.data());
  }
  return true;
}

}  // namespace sarblock
