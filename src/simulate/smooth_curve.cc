// SPDX-License-Identifier: Apache-2.0
#include "smooth_curve.h"

#include <algorithm>
#include <cstddef>

namespace sarblock {

SmoothCurve SmoothCurve::Natural(const std::vector<double>& times_s,
                                 const std::vector<double>& values) {
  const std::size_t count = times_s.size();
  std::vector<Node> nodes(count);
  for (std::size_t i = 0; i < count; ++i) nodes[i] = {times_s[i], values[i], 0.0, 0.0};
  const auto span_s = [&](std::size_t i) { return times_s[i + 1] - times_s[i]; };
  const auto slope = [&](std::size_t i) { return (values[i + 1] - values[i]) / span_s(i); };
  // Continuity of the first derivative: h_i-1 m_i-1 + 2 (h_i-1 + h_i) m_i + h_i m_i+1 =
  // 6 (d_i - d_i-1), m the second derivatives, zero at the ends. Elimination without pivoting.
  std::vector<double> above(count, 0.0);
  for (std::size_t i = 1; i + 1 < count; ++i) {
    const double pivot = 2.0 * (span_s(i - 1) + span_s(i)) - span_s(i - 1) * above[i - 1];
    above[i] = span_s(i) / pivot;
    nodes[i].second =
        (6.0 * (slope(i) - slope(i - 1)) - span_s(i - 1) * nodes[i - 1].second) / pivot;
  }
  for (std::size_t i = count - 1; i-- > 1;) nodes[i].second -= above[i] * nodes[i + 1].second;
  for (std::size_t i = 0; i + 1 < count; ++i) {
    nodes[i].first = slope(i) - span_s(i) / 6.0 * (2.0 * nodes[i].second + nodes[i + 1].second);
  }
  const std::size_t last = count - 1;
  nodes[last].first = slope(last - 1) + span_s(last - 1) / 6.0 * nodes[last - 1].second;
  return SmoothCurve(std::move(nodes));
}

std::array<double, 4> SmoothCurve::At(double time_s) const {
  if (nodes_.empty()) return {};
  const auto next =
      std::upper_bound(nodes_.begin(), nodes_.end(), time_s, [](double time, const Node& node) {
        return time < node.time_s;
      });
  if (next == nodes_.begin() || next == nodes_.end()) {
    const Node& end = next == nodes_.begin() ? nodes_.front() : nodes_.back();
    return {end.value + end.first * (time_s - end.time_s), end.first, 0.0, 0.0};
  }
  const Node& a = *(next - 1);
  const Node& b = *next;
  const double h = b.time_s - a.time_s;
  const double u = (time_s - a.time_s) / h;
  const double c1 = a.first * h, c2 = 0.5 * a.second * h * h;
  const double value = b.value - a.value - c1 - c2;  // what the three others must add up to
  const double first = b.first * h - c1 - 2.0 * c2;
  const double second = b.second * h * h - 2.0 * c2;
  const double c3 = 10.0 * value - 4.0 * first + 0.5 * second;
  const double c4 = -15.0 * value + 7.0 * first - second;
  const double c5 = 6.0 * value - 3.0 * first + 0.5 * second;
  return {a.value + u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * c5)))),
          (c1 + u * (2.0 * c2 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))) / h,
          (2.0 * c2 + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5))) / (h * h),
          (6.0 * c3 + u * (24.0 * c4 + u * 60.0 * c5)) / (h * h * h)};
}

}  // namespace sarblock
