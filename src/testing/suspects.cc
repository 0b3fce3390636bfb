// SPDX-License-Identifier: Apache-2.0
#include "suspects.h"

#include "sarblock/core/statistics.h"

#include <algorithm>
#include <cmath>

#include "reliability.h"
#include <Eigen/Eigenvalues>

namespace sarblock {
namespace {

/// Looks are units 0, 1, ...; the known position is the unit after them.
Eigen::Index UnitOf(const PointResiduals& residuals, Eigen::Index row) {
  return std::min(row / 2, static_cast<Eigen::Index>(residuals.looks.size()));
}

/// Row of the largest |w|; -1 where nothing has a test.
Eigen::Index LargestRow(const PointResiduals& residuals) {
  Eigen::Index largest = -1;
  double w_1 = 0.0;
  for (Eigen::Index i = 0; i < residuals.size(); ++i) {
    const double here = std::abs(residuals.w_1(i));
    if (!(here > w_1)) continue;  // NaN neither
    w_1 = here;
    largest = i;
  }
  return largest;
}

bool MayExplain(const PointResiduals& residuals,
                Eigen::Index i,
                Eigen::Index k,
                double accepted_1) {
  const double w_k = residuals.w_1(k);
  if (std::isnan(w_k)) return false;  // an error there shows nowhere
  const double rho = residuals.Correlation(i, k);
  if (std::abs(rho) > kSameTest_1) return true;
  const double freed = (residuals.w_1(i) - rho * w_k) / std::sqrt((1.0 - rho) * (1.0 + rho));
  return std::abs(freed) <= accepted_1;
}

bool IsRemoved(const PointResiduals& residuals, const SuspectSet& set, Eigen::Index row) {
  const Eigen::Index unit = UnitOf(residuals, row);
  if (unit == static_cast<Eigen::Index>(residuals.looks.size())) return set.control;
  return std::find(set.looks.begin(),
                   set.looks.end(),
                   residuals.looks[static_cast<std::size_t>(unit)]) != set.looks.end();
}

}  // namespace

SuspectSet FindSuspects(const PointResiduals& residuals, double separation_1) {
  SuspectSet set;
  const Eigen::Index largest = LargestRow(residuals);
  if (largest < 0) return set;
  const auto looks = static_cast<Eigen::Index>(residuals.looks.size());
  std::vector<std::uint8_t> suspect(residuals.looks.size() + 1, 0);
  const double accepted_1 = NormalQuantile(0.5 * (1.0 + separation_1));
  for (Eigen::Index k = 0; k < residuals.size(); ++k) {
    const auto unit = static_cast<std::size_t>(UnitOf(residuals, k));
    if (MayExplain(residuals, largest, k, accepted_1)) suspect[unit] = 1;
  }
  const Eigen::Index first = UnitOf(residuals, largest);
  set.largest_w_1 = residuals.w_1(largest);
  set.azimuth = first < looks && largest % 2 == 1;
  if (first < looks) set.looks.push_back(residuals.looks[static_cast<std::size_t>(first)]);
  for (Eigen::Index unit = 0; unit < looks; ++unit) {
    if (unit == first || suspect[static_cast<std::size_t>(unit)] == 0) continue;
    set.looks.push_back(residuals.looks[static_cast<std::size_t>(unit)]);
  }
  set.control = first == looks || suspect.back() != 0;
  set.rest_determines = RestDetermines(residuals, set);
  return set;
}

bool RestDetermines(const PointResiduals& residuals, const SuspectSet& set) {
  if (set.looks.size() >= residuals.looks_of_point) return false;
  Eigen::Matrix3d left = Eigen::Matrix3d::Identity();
  for (Eigen::Index i = 0; i < residuals.size(); ++i) {
    if (!IsRemoved(residuals, set, i)) continue;
    left -= residuals.information_1.row(i).transpose() * residuals.information_1.row(i);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(left, Eigen::EigenvaluesOnly);
  return eigen.eigenvalues()[0] > kLeastInformationPart_1;
}

double ReachOf(const PointResiduals& residuals, const SuspectSet& set) {
  double reach = 0.0;
  for (Eigen::Index i = 0; i < residuals.size(); ++i) {
    const double w_1 = residuals.w_1(i);
    if (std::isnan(w_1) || (set.rest_determines && !IsRemoved(residuals, set, i))) continue;
    reach += std::abs(w_1) * std::sqrt(residuals.shared_1[i] / residuals.q_vv_1(i, i));
  }
  return reach;
}

bool StandsAlone(const PointResiduals& residuals, double reach_1, double critical_1) {
  const Eigen::Index i = LargestRow(residuals);
  if (i < 0) return false;
  const double part = std::sqrt(residuals.shared_1[i] / residuals.q_vv_1(i, i));
  return std::abs(residuals.w_1(i)) - part * reach_1 > critical_1;
}

std::string DescribeContradiction(const Block& block, const SuspectSet& set) {
  std::string text = "its observations contradict each other and nothing tells which is wrong: ";
  for (std::size_t i = 0; i < set.looks.size(); ++i) {
    text += (i == 0 ? "" : ", ") + block.passes[block.looks.pass[set.looks[i]]].id;
  }
  if (set.control) text += set.looks.empty() ? "its known position" : ", its known position";
  return text;
}

std::size_t CountTests(const LookQuality& quality, const std::vector<ControlQuality>& control) {
  const auto has_test = [](float w) { return !std::isnan(w); };
  std::size_t tests = 0;
  for (const std::vector<float>& w : quality.w_1) {
    tests += static_cast<std::size_t>(std::count_if(w.begin(), w.end(), has_test));
  }
  for (const ControlQuality& of : control) tests += std::isnan(of.w_1) ? 0U : 1U;
  return tests;
}

}  // namespace sarblock
