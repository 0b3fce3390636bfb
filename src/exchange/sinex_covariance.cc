// SPDX-License-Identifier: Apache-2.0
#include "sinex_covariance.h"

#include "sarblock/core/error.h"
#include "sarblock/model/result.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "linear/block_cholesky.h"

namespace sarblock {
namespace {

Eigen::Matrix3d InFrame(const Frame& frame, const Eigen::Vector3d& p_m, const SymmetricEnu& c) {
  const Eigen::Matrix3d enu = MatrixOf(c);
  const Eigen::Matrix3d enu_from_frame = frame.EnuFromFrame(p_m);
  const Eigen::Matrix3d turned = enu_from_frame.transpose() * enu * enu_from_frame;
  return 0.5 * (turned + turned.transpose());
}

void RequirePositiveDefinite(const SinexCovariance& covariance) {
  const std::size_t points = covariance.own.size();
  std::vector<std::pair<int, int>> pairs;
  for (const auto& block : covariance.cross) {
    pairs.emplace_back(static_cast<int>(block.row), static_cast<int>(block.column));
  }
  BlockSymmetricMatrix matrix(std::vector<int>(points, 3), std::move(pairs));
  std::vector<Eigen::Vector3d> scale(points);  // to correlations
  for (std::size_t i = 0; i < points; ++i) {
    scale[i] = covariance.own[i].diagonal().cwiseSqrt().cwiseInverse();
    matrix.Block(static_cast<int>(i), static_cast<int>(i)) =
        scale[i].asDiagonal() * covariance.own[i] * scale[i].asDiagonal();
  }
  for (const auto& block : covariance.cross) {
    matrix.Block(static_cast<int>(block.row), static_cast<int>(block.column)) =
        scale[block.row].asDiagonal() * block.covariance_m2 * scale[block.column].asDiagonal();
  }
  BlockCholesky factor(matrix);
  const BlockCholesky::Outcome outcome = factor.Factorize(matrix);
  constexpr double kLeastPivot = 1e-13;  // fifteen digits are written
  if (outcome.positive_definite && outcome.smallest_pivot_ratio > kLeastPivot) return;
  throw InputError(
      "cross",
      "the covariance with the pairs of pairs.csv is not positive definite, because those of the "
      "other pairs are not given; pairs = \"all\" in the adjustment gives them all, --no-cross "
      "leaves all out");
}

}  // namespace

SinexCovariance FormCovariance(const ExportView& view) {
  const ResultFile& result = view.result;
  SinexCovariance covariance;
  std::vector<std::size_t> place(result.points.size(), view.points.size());
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    const std::uint32_t point = view.points[i];
    place[point] = i;
    covariance.own.push_back(
        InFrame(result.frame, view.Position_m(point), view.Covariance_m2(point)));
  }
  if (!view.options.cross_covariances) return covariance;
  for (const PairResult& pair : result.pairs) {
    const std::size_t a = place[pair.a], b = place[pair.b];
    if (a == b || std::max(a, b) == view.points.size() || std::isnan(pair.covariance_m2[0])) {
      continue;
    }
    const Eigen::Matrix3d difference =
        InFrame(result.frame, view.Position_m(pair.a), pair.covariance_m2);
    covariance.cross.push_back({std::max(a, b),
                                std::min(a, b),
                                0.5 * (covariance.own[a] + covariance.own[b] - difference)});
  }
  const auto key = [](const SinexCovariance::Cross& c) { return std::pair(c.row, c.column); };
  std::stable_sort(covariance.cross.begin(),
                   covariance.cross.end(),
                   [&key](const auto& x, const auto& y) { return key(x) < key(y); });
  covariance.cross.erase(
      std::unique(covariance.cross.begin(),
                  covariance.cross.end(),
                  [&key](const auto& x, const auto& y) { return key(x) == key(y); }),
      covariance.cross.end());
  if (!covariance.cross.empty()) RequirePositiveDefinite(covariance);
  return covariance;
}

}  // namespace sarblock
