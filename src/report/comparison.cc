// SPDX-License-Identifier: Apache-2.0
#include "comparison.h"

#include "sarblock/geodesy/frame.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace sarblock {
namespace {

using Key = std::pair<std::string, std::string>;

double Larger(double a, double b) { return std::fmax(a, b); }

void ComparePoints(const ResultFolder& a, const ResultFolder& b, ResultDifference* out) {
  const bool geocentric = a.summary.geocentric && a.summary.a_m > 0.0;
  const Frame frame =
      geocentric ? Frame::Geocentric({"", a.summary.a_m, a.summary.flattening}) : Frame::Local();
  std::size_t matched = 0;
  for (std::uint32_t i = 0; i < a.points.size(); ++i) {
    if (a.points.solved[i] == 0) continue;
    const std::uint32_t j = b.points.ids.Find(a.points.ids[i]);
    if (j == IdTable::kNone || b.points.solved[j] == 0) {
      ++out->only_in_a;
      continue;
    }
    ++matched;
    ResultDifference::Point point;
    point.a = i;
    point.b = j;
    const auto& pa = a.points.position_m[i];
    const auto& pb = b.points.position_m[j];
    const Eigen::Vector3d from(pa[0], pa[1], pa[2]), to(pb[0], pb[1], pb[2]);
    const Eigen::Vector3d shift = frame.EnuFromFrame(from) * (to - from);
    point.shift_length_m = shift.norm();
    for (std::size_t k = 0; k < 3; ++k) {
      point.shift_m[k] = shift[static_cast<Eigen::Index>(k)];
      const auto sa = static_cast<double>(a.points.sigma_m[i][k]);
      const auto sb = static_cast<double>(b.points.sigma_m[j][k]);
      point.sigma_ratio_1[k] = sb / sa;
      point.shift_sigmas_1 =
          Larger(point.shift_sigmas_1, std::abs(point.shift_m[k]) / Larger(sa, sb));
    }
    out->common.push_back(point);
  }
  const auto solved_in_b = static_cast<std::size_t>(
      std::count(b.points.solved.begin(), b.points.solved.end(), std::uint8_t{1}));
  out->only_in_b = solved_in_b - matched;
}

void CompareParameters(const ResultFolder& a, const ResultFolder& b, ResultDifference* out) {
  std::map<Key, std::uint32_t> of_b;
  for (std::uint32_t j = 0; j < b.parameters.size(); ++j) {
    of_b[{b.parameters[j].pass, b.parameters[j].name}] = j;
  }
  for (std::uint32_t i = 0; i < a.parameters.size(); ++i) {
    const auto found = of_b.find({a.parameters[i].pass, a.parameters[i].name});
    if (found == of_b.end()) {
      ++out->parameters_only_in_a;
      continue;
    }
    ResultDifference::Parameter parameter;
    parameter.a = i;
    parameter.b = found->second;
    parameter.change = b.parameters[found->second].value - a.parameters[i].value;
    parameter.change_sigmas_1 = std::abs(parameter.change) /
                                Larger(a.parameters[i].sigma, b.parameters[found->second].sigma);
    out->parameters.push_back(parameter);
  }
  out->parameters_only_in_b = b.parameters.size() - out->parameters.size();
}

void CompareSettings(const ReportSummary& a, const ReportSummary& b, ResultDifference* out) {
  std::map<std::string, std::array<std::string, 2>> values;
  for (const auto& [key, value] : a.configuration) values[key][0] = value;
  for (const auto& [key, value] : b.configuration) values[key][1] = value;
  for (const auto& [key, value] : values) {
    if (value[0] != value[1]) out->settings.push_back({key, value[0], value[1]});
  }
  std::map<std::string, std::array<std::string, 2>> files;
  for (const InputFigures& input : a.inputs) files[input.file][0] = input.sha256;
  for (const InputFigures& input : b.inputs) files[input.file][1] = input.sha256;
  for (const auto& [name, sums] : files) {
    if (sums[0] != sums[1]) out->inputs.push_back(name);
  }
}

}  // namespace

ResultDifference CompareResults(const ResultFolder& a, const ResultFolder& b) {
  ResultDifference out;
  ComparePoints(a, b, &out);
  CompareParameters(a, b, &out);
  CompareSettings(a.summary, b.summary, &out);
  return out;
}

}  // namespace sarblock
