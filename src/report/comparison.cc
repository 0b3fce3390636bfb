// SPDX-License-Identifier: Apache-2.0
#include "comparison.h"

#include "sarblock/geometry/frame.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace sarblock {
namespace {

using Key = std::pair<std::string, std::string>;

double Larger(double a, double b) { return std::fmax(a, b); }

void ComparePoints(const ResultFolder& a, const ResultFolder& b, ResultDifference* out) {
  const ResultPoints &pa = a.file.points, &pb = b.file.points;
  std::size_t matched = 0;
  for (std::uint32_t i = 0; i < pa.size(); ++i) {
    if (!IsSolved(pa.results.status[i])) continue;
    const std::uint32_t j = pb.ids.Find(pa.ids[i]);
    if (j == IdTable::kNone || !IsSolved(pb.results.status[j])) {
      ++out->only_in_a;
      continue;
    }
    ++matched;
    ResultDifference::Point point;
    point.a = i;
    point.b = j;
    const Eigen::Vector3d& from_m = pa.results.position_m[i];
    const Eigen::Vector3d shift =
        a.file.frame.EnuFromFrame(from_m) * (pb.results.position_m[j] - from_m);
    point.shift_length_m = shift.norm();
    for (std::size_t k = 0; k < 3; ++k) {
      point.shift_m[k] = shift[static_cast<Eigen::Index>(k)];
      const double sa = SigmaOf(pa, i, k), sb = SigmaOf(pb, j, k);
      point.sigma_ratio_1[k] = sb / sa;
      point.shift_sigmas_1 =
          Larger(point.shift_sigmas_1, std::abs(point.shift_m[k]) / Larger(sa, sb));
    }
    out->common.push_back(point);
  }
  out->only_in_b = pb.size() - b.unsolved.size() - matched;
}

void CompareParameters(const std::vector<ParameterResult>& a,
                       const std::vector<ParameterResult>& b,
                       ResultDifference* out) {
  std::map<Key, std::uint32_t> of_b;
  for (std::uint32_t j = 0; j < b.size(); ++j) {
    of_b[{b[j].owner, b[j].name}] = j;
  }
  for (std::uint32_t i = 0; i < a.size(); ++i) {
    const auto found = of_b.find({a[i].owner, a[i].name});
    if (found == of_b.end()) {
      ++out->parameters_only_in_a;
      continue;
    }
    ResultDifference::Parameter parameter;
    parameter.a = i;
    parameter.b = found->second;
    parameter.change = b[found->second].value - a[i].value;
    parameter.change_sigmas_1 =
        std::abs(parameter.change) / Larger(a[i].sigma, b[found->second].sigma);
    out->parameters.push_back(parameter);
  }
  out->parameters_only_in_b = b.size() - out->parameters.size();
}

void CompareSettings(const ResultSummary& a, const ResultSummary& b, ResultDifference* out) {
  std::map<std::string, std::array<std::string, 2>> values;
  for (const auto& [key, value] : a.configuration) values[key][0] = value;
  for (const auto& [key, value] : b.configuration) values[key][1] = value;
  for (const auto& [key, value] : values) {
    if (value[0] != value[1]) out->settings.push_back({key, value[0], value[1]});
  }
  std::map<std::string, std::array<std::string, 2>> files;
  for (const InputFile& input : a.inputs) files[input.name][0] = input.sha256;
  for (const InputFile& input : b.inputs) files[input.name][1] = input.sha256;
  for (const auto& [name, sums] : files) {
    if (sums[0] != sums[1]) out->inputs.push_back(name);
  }
}

}  // namespace

ResultDifference CompareResults(const ResultFolder& a, const ResultFolder& b) {
  ResultDifference out;
  ComparePoints(a, b, &out);
  CompareParameters(a.file.parameters, b.file.parameters, &out);
  CompareSettings(a.file.summary, b.file.summary, &out);
  return out;
}

}  // namespace sarblock
