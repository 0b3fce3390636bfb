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

// At its own time, linear between two, that of the end beyond.
std::vector<double> AtTime(const std::vector<GroundRangePolynomial>& given, double time_s) {
  const auto above = std::upper_bound(
      given.begin(), given.end(), time_s, [](double t, const GroundRangePolynomial& polynomial) {
        return t < polynomial.time_s;
      });
  if (above == given.begin()) return above->coefficients;
  if (above == given.end()) return given.back().coefficients;
  const GroundRangePolynomial& a = *(above - 1);
  const GroundRangePolynomial& b = *above;
  const double part = (time_s - a.time_s) / (b.time_s - a.time_s);
  std::vector<double> coefficients = a.coefficients;
  for (std::size_t k = 0; k < coefficients.size(); ++k) {
    coefficients[k] += part * (b.coefficients[k] - a.coefficients[k]);
  }
  return coefficients;
}

}  // namespace

std::vector<double> AsUsgscsmInterpolates(const std::vector<std::vector<double>>& rows,
                                          double place) {
  const auto count = static_cast<std::ptrdiff_t>(rows.size());
  const auto interval =
      std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(std::floor(place)), 0, count - 2);
  const std::ptrdiff_t half = NodesEachSide(interval, count);
  std::vector<double> sum(rows.front().size(), 0.0);
  for (std::ptrdiff_t i = interval - half + 1; i <= interval + half; ++i) {
    double weight = 1.0;
    for (std::ptrdiff_t j = interval - half + 1; j <= interval + half; ++j) {
      if (j == i) continue;
      weight *= (place - static_cast<double>(j)) / static_cast<double>(i - j);
    }
    const std::vector<double>& row = rows[static_cast<std::size_t>(i)];
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += weight * row[k];
  }
  return sum;
}

std::vector<GroundRangePolynomial> ForUsgscsm(const std::vector<GroundRangePolynomial>& given,
                                              double start_s,
                                              double end_s) {
  if (given.size() < 2) return given;
  constexpr std::size_t kIntervals = 2048, kBeyond = 4;
  const double step_s = (end_s - start_s) / static_cast<double>(kIntervals);
  const double first_s = start_s - static_cast<double>(kBeyond) * step_s;
  std::vector<GroundRangePolynomial> written;
  constexpr std::size_t kCount = kIntervals + 1 + 2 * kBeyond;
  for (std::size_t k = 0; k < kCount; ++k) {
    const double time_s = first_s + static_cast<double>(k) * step_s;
    written.push_back({time_s, given.front().origin_m, AtTime(given, time_s)});
  }
  // USGSCSM divides the span by the number of polynomials, not by that of the intervals.
  written.back().time_s += step_s;
  return written;
}

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
  std::vector<std::vector<double>> rows;
  for (const GroundRangePolynomial& polynomial : given) rows.push_back(polynomial.coefficients);
  std::vector<GroundRangePolynomial> close;
  for (double part = from; part <= to; part += 1.0) {
    close.push_back({first_s + part * part_s,
                     given.front().origin_m,
                     AsUsgscsmInterpolates(rows, part / kPartsOfInterval)});
  }
  return close;
}

}  // namespace sarblock
