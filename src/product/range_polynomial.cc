// SPDX-License-Identifier: Apache-2.0
#include "range_polynomial.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace sarblock {
namespace {

constexpr double kPartsOfInterval = 32.0;

// Nodes before and after the interval's first one: eight in the middle, fewer towards the ends.
std::ptrdiff_t NodesEachSide(std::ptrdiff_t interval, std::ptrdiff_t count) {
  if (interval >= 3 && interval < count - 4) return 4;
  if (interval >= 2 && interval < count - 3) return 3;
  if (interval >= 1 && interval < count - 2) return 2;
  return 1;
}

std::vector<double> CoefficientsAt(const std::vector<GroundRangePolynomial>& given, double nodes) {
  const auto count = static_cast<std::ptrdiff_t>(given.size());
  const auto interval =
      std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(std::floor(nodes)), 0, count - 2);
  const std::ptrdiff_t half = NodesEachSide(interval, count);
  std::vector<double> sum(given.front().coefficients.size(), 0.0);
  for (std::ptrdiff_t i = interval - half + 1; i <= interval + half; ++i) {
    double weight = 1.0;
    for (std::ptrdiff_t j = interval - half + 1; j <= interval + half; ++j) {
      if (j == i) continue;
      weight *= (nodes - static_cast<double>(j)) / static_cast<double>(i - j);
    }
    const std::vector<double>& node = given[static_cast<std::size_t>(i)].coefficients;
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += weight * node[k];
  }
  return sum;
}

}  // namespace

std::vector<GroundRangePolynomial> AsUsgscsmReads(const std::vector<GroundRangePolynomial>& given,
                                                  double start_s,
                                                  double end_s) {
  if (given.size() < 2) return given;
  const double first_s = given.front().time_s;
  const double step_s = (given.back().time_s - first_s) / static_cast<double>(given.size());
  const double part_s = step_s / kPartsOfInterval;
  // Through the nodes, where one interpolating polynomial ends and the next begins.
  const double from = std::floor((std::min(start_s, first_s) - first_s) / part_s);
  const double to = std::ceil((std::max(end_s, given.back().time_s) - first_s) / part_s);
  constexpr double kMost = 1e5;
  if (to - from > kMost) {
    throw InputError("ground_range", "polynomials stand too close in time for the path");
  }
  std::vector<GroundRangePolynomial> close;
  for (double part = from; part <= to; part += 1.0) {
    close.push_back({first_s + part * part_s,
                     given.front().origin_m,
                     CoefficientsAt(given, part / kPartsOfInterval)});
  }
  return close;
}

}  // namespace sarblock
