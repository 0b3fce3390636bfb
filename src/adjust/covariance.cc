// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/covariance.h"

#include "sarblock/adjust/elimination.h"
#include "sarblock/core/error.h"
#include "sarblock/core/parallel.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

namespace sarblock {
namespace {

constexpr std::size_t kPointsPerChunk = 1024;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// C over the blocks of a point, gathered from the selected inverse.
void GatherInverse(const BlockSymmetricMatrix& inverse, const PointRows& rows, Eigen::MatrixXd* c) {
  c->resize(rows.column_count, rows.column_count);
  for (std::size_t i = 0; i < rows.blocks.size(); ++i) {
    const int bi = rows.blocks[i], ri = rows.block_column[i];
    for (std::size_t j = 0; j <= i; ++j) {
      const int bj = rows.blocks[j], rj = rows.block_column[j];
      const auto block = inverse.Block(bi, bj);
      c->block(ri, rj, block.rows(), block.cols()) = block;
      if (i != j) c->block(rj, ri, block.cols(), block.rows()) = block.transpose();
    }
  }
}

/// R^-1 and R^-1 T of a point at the state, looks unweighted by any loss.
struct PointFactor {
  Eigen::Matrix3d r_inverse = Eigen::Matrix3d::Zero();
  Eigen::MatrixXd y;  // R^-1 T, 3 x columns
};

void FactorPoint(const AdjustmentProblem& problem,
                 const BlockState& state,
                 std::size_t point,
                 PointRows* rows,
                 PointFactor* out) {
  LinearisePoint(problem, state, {}, point, rows);
  const EliminatedPoint eliminated = EliminatePoint(rows);
  const auto r = eliminated.r.triangularView<Eigen::Upper>();
  out->r_inverse = r.solve(Eigen::Matrix3d::Identity());
  out->y = out->r_inverse * rows->a.block(0, 3, 3, rows->column_count);
}

/// Y spread over the whole vector of corrections: C Y' needs full columns.
void Scatter(const AdjustmentProblem& problem,
             const PointRows& rows,
             const Eigen::MatrixXd& y,
             Eigen::Ref<Eigen::MatrixXd> full) {
  full.setZero();
  for (std::size_t b = 0; b < rows.blocks.size(); ++b) {
    const ParameterBlock& block = problem.layout.blocks[static_cast<std::size_t>(rows.blocks[b])];
    full.middleRows(block.offset, block.size) =
        y.middleCols(rows.block_column[b], block.size).transpose();
  }
}

}  // namespace

SymmetricEnu ToEnu(const Frame& frame, const Eigen::Vector3d& p_m, const Eigen::Matrix3d& m) {
  const Eigen::Matrix3d e = frame.EnuFromFrame(p_m);
  const Eigen::Matrix3d c = e * m * e.transpose();
  return {c(0, 0), c(1, 1), c(2, 2), c(0, 1), c(0, 2), c(1, 2)};
}

std::vector<SymmetricEnu> PointCovariances(const AdjustmentProblem& problem,
                                           const BlockState& state,
                                           const BlockSymmetricMatrix* inverse,
                                           ProgressSink* progress) {
  const std::size_t points = problem.block.points.size();
  std::vector<SymmetricEnu> out(points);
  Step(progress, "covariance", 0, points);
  ParallelForChunks(points, kPointsPerChunk, [&](std::size_t, std::size_t begin, std::size_t end) {
    PointRows rows;
    PointFactor factor;
    Eigen::MatrixXd c, yc;
    for (std::size_t point = begin; point < end; ++point) {
      if (!problem.Solves(point)) {
        out[point].fill(kNaN);
        continue;
      }
      FactorPoint(problem, state, point, &rows, &factor);
      Eigen::Matrix3d covariance = factor.r_inverse * factor.r_inverse.transpose();
      if (inverse != nullptr && rows.column_count > 0) {
        GatherInverse(*inverse, rows, &c);
        yc.noalias() = factor.y * c;
        covariance.noalias() += yc * factor.y.transpose();
      }
      out[point] = ToEnu(problem.block.frame, state.Position(point), covariance);
    }
  });
  Step(progress, "covariance", points, points);
  return out;
}

std::vector<ParameterCovariance> ParameterCovariances(const ReducedSystem& system,
                                                      const BlockSymmetricMatrix& inverse) {
  std::vector<ParameterCovariance> out;
  const int n = inverse.rows();
  if (n <= kFullParameterCovariance) {
    const Eigen::MatrixXd full = system.SolveFor(Eigen::MatrixXd::Identity(n, n));
    for (int i = 0; i < n; ++i) {
      for (int j = i; j < n; ++j) {
        out.push_back({static_cast<std::uint32_t>(i),
                       static_cast<std::uint32_t>(j),
                       0.5 * (full(i, j) + full(j, i))});
      }
    }
    return out;
  }
  for (int j = 0; j < inverse.block_count(); ++j) {
    for (const int i : inverse.RowsOfColumn(j)) {
      const auto block = inverse.Block(i, j);
      for (int c = 0; c < inverse.size(j); ++c) {
        for (int r = i == j ? c : 0; r < inverse.size(i); ++r) {
          const int a = inverse.offset(j) + c, b = inverse.offset(i) + r;
          out.push_back({static_cast<std::uint32_t>(std::min(a, b)),
                         static_cast<std::uint32_t>(std::max(a, b)),
                         block(r, c)});
        }
      }
    }
  }
  return out;
}

std::vector<PairResult> PairDifferences(
    const AdjustmentProblem& problem,
    const BlockState& state,
    const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs) {
  std::vector<PairResult> out;
  for (const auto& [a, b] : pairs) {
    if (!problem.Solves(a) || !problem.Solves(b)) continue;
    PairResult pair;
    pair.a = a;
    pair.b = b;
    const Eigen::Vector3d a_m = state.Position(a);
    pair.difference_enu_m = problem.block.frame.EnuFromFrame(a_m) * (state.Position(b) - a_m);
    pair.covariance_m2.fill(kNaN);
    out.push_back(pair);
  }
  return out;
}

std::vector<PairResult> PairCovariances(
    const AdjustmentProblem& problem,
    const BlockState& state,
    const ReducedSystem* system,
    const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs,
    ProgressSink* progress) {
  std::vector<PairResult> out = PairDifferences(problem, state, pairs);
  constexpr std::size_t kPairsPerChunk = 32;
  const Eigen::Index n = problem.layout.size();
  Step(progress, "pairs", 0, out.size());
  ParallelForChunks(
      out.size(), kPairsPerChunk, [&](std::size_t, std::size_t begin, std::size_t end) {
        const auto count = static_cast<Eigen::Index>(end - begin);
        PointRows rows;
        PointFactor factor;
        // Two sets of three columns a pair, Y_a' and Y_b', solved together.
        const bool coupled = system != nullptr && n > 0;
        Eigen::MatrixXd columns(coupled ? n : 0, coupled ? 6 * count : 0);
        std::vector<Eigen::Matrix3d> own(static_cast<std::size_t>(count));
        for (std::size_t q = begin; q < end; ++q) {
          const auto local = static_cast<Eigen::Index>(q - begin);
          Eigen::Matrix3d& sum = own[q - begin];
          sum.setZero();
          for (const Eigen::Index side : {0, 1}) {
            FactorPoint(problem, state, side == 0 ? out[q].a : out[q].b, &rows, &factor);
            sum += factor.r_inverse * factor.r_inverse.transpose();
            if (coupled) {
              Scatter(problem, rows, factor.y, columns.middleCols(6 * local + 3 * side, 3));
            }
          }
        }
        Eigen::MatrixXd solved;
        if (coupled) {
          // cov(b - a) = V_a^-1 + V_b^-1 + D' C D with D = Y_b' - Y_a': one solve, no cancellation.
          Eigen::MatrixXd difference(n, 3 * count);
          for (Eigen::Index q = 0; q < count; ++q) {
            difference.middleCols(3 * q, 3) =
                columns.middleCols(6 * q + 3, 3) - columns.middleCols(6 * q, 3);
          }
          solved = system->SolveFor(difference);
          for (Eigen::Index q = 0; q < count; ++q) {
            own[static_cast<std::size_t>(q)] +=
                difference.middleCols(3 * q, 3).transpose() * solved.middleCols(3 * q, 3);
          }
        }
        for (std::size_t q = begin; q < end; ++q) {
          PairResult& pair = out[q];
          const Eigen::Vector3d a_m = state.Position(pair.a);
          const Eigen::Matrix3d& covariance = own[q - begin];
          pair.covariance_m2 =
              ToEnu(problem.block.frame, a_m, 0.5 * (covariance + covariance.transpose()));
        }
      });
  Step(progress, "pairs", out.size(), out.size());
  return out;
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> AllPairs(const AdjustmentProblem& problem,
                                                              std::size_t most) {
  std::vector<std::uint32_t> solved;
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (problem.Solves(point)) solved.push_back(static_cast<std::uint32_t>(point));
  }
  const std::size_t count = solved.size() < 2 ? 0 : solved.size() * (solved.size() - 1) / 2;
  if (count > most) {
    throw InputError("adjust.pairs",
                     "'all' means " + std::to_string(count) + " pairs, at most " +
                         std::to_string(most) + " are allowed; name the pairs in a file");
  }
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (std::size_t i = 0; i < solved.size(); ++i) {
    for (std::size_t j = i + 1; j < solved.size(); ++j) pairs.emplace_back(solved[i], solved[j]);
  }
  return pairs;
}

}  // namespace sarblock
