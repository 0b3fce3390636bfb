// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/elimination.h"
#include "sarblock/adjust/variance_components.h"
#include "sarblock/core/parallel.h"

#include <algorithm>
#include <optional>

namespace sarblock {
namespace {

constexpr std::size_t kPointsPerPartial = 256;
constexpr std::size_t kMostPartials = 8;
/// Of the dense normals by component, all partial sums together.
constexpr std::size_t kMostBytes = std::size_t{256} << 20;

/// What every range of points needs.
struct Sweep {
  const AdjustmentProblem& problem;
  const BlockState& state;
  const std::vector<std::array<int, 2>>& component_of;
  std::size_t components;
  std::optional<BlockSymmetricMatrix> inverse;  // C on the pattern of S; empty without corrections
  bool couples = false;                         // points of all the block through C
};

/// What one range of points adds.
struct Partial {
  explicit Partial(const Sweep& sweep) {
    const auto k = static_cast<Eigen::Index>(sweep.components);
    sums.looks.assign(sweep.components, 0);
    sums.square_1.setZero(k);
    sums.redundancy_1.setZero(k);
    sums.helmert_1.setZero(k, k);
    const Eigen::Index n = sweep.couples ? sweep.problem.layout.size() : 0;
    normals.assign(sweep.couples ? sweep.components : 0, Eigen::MatrixXd::Zero(n, n));
  }
  VarianceSums sums;
  std::vector<Eigen::MatrixXd> normals;  // M_k = B' E_k B, over all corrections
};

/// Components of the rows of a point in the order of LinearisePoint; -1 for control.
void ComponentsOfRows(const Sweep& sweep,
                      std::size_t point,
                      int row_count,
                      std::vector<int>* component,
                      std::vector<std::size_t>* looks) {
  component->clear();
  looks->clear();
  const Looks& all = sweep.problem.block.looks;
  for (std::size_t i = all.offsets[point]; i < all.offsets[point + 1]; ++i) {
    if (sweep.problem.look_used[i] == 0) continue;
    looks->push_back(i);
    for (const int k : sweep.component_of[all.pass[i]]) component->push_back(k);
  }
  component->resize(static_cast<std::size_t>(row_count), -1);
}

/// Turns the two whitened rows of each look to its measured components, range and azimuth. Both
/// describe the same two standard normal errors, so this is a rotation: the range's direction is
/// W (1, 0)' made unit (docs/theory/variance_components.md, eq. (2)).
void TurnToMeasured(const AdjustmentProblem& problem,
                    const std::vector<std::size_t>& looks,
                    Eigen::Ref<Eigen::MatrixXd> rows) {
  for (std::size_t k = 0; k < looks.size(); ++k) {
    const Whitening& w = problem.whitening[looks[k]];
    const Eigen::Vector2d u = Eigen::Vector2d(w.w00, w.w10).normalized();
    const auto r = static_cast<Eigen::Index>(2 * k);
    const Eigen::RowVectorXd range = u.x() * rows.row(r) + u.y() * rows.row(r + 1);
    rows.row(r + 1) = u.x() * rows.row(r + 1) - u.y() * rows.row(r);
    rows.row(r) = range;
  }
}

/// C over the parameter blocks of a point.
Eigen::MatrixXd Gather(const BlockSymmetricMatrix& inverse, const PointRows& rows) {
  Eigen::MatrixXd c(rows.column_count, rows.column_count);
  for (std::size_t i = 0; i < rows.blocks.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      const auto block = inverse.Block(rows.blocks[i], rows.blocks[j]);
      const int ri = rows.block_column[i], rj = rows.block_column[j];
      c.block(ri, rj, block.rows(), block.cols()) = block;
      c.block(rj, ri, block.cols(), block.rows()) = block.transpose();
    }
  }
  return c;
}

/// normals += b' b of one row over the blocks of its point.
void AddNormals(const AdjustmentProblem& problem,
                const PointRows& rows,
                const Eigen::RowVectorXd& b,
                Eigen::MatrixXd* normals) {
  for (std::size_t i = 0; i < rows.blocks.size(); ++i) {
    const ParameterBlock& bi = problem.layout.blocks[static_cast<std::size_t>(rows.blocks[i])];
    for (std::size_t j = 0; j < rows.blocks.size(); ++j) {
      const ParameterBlock& bj = problem.layout.blocks[static_cast<std::size_t>(rows.blocks[j])];
      normals->block(bi.offset, bj.offset, bi.size, bj.size).noalias() +=
          b.segment(rows.block_column[i], bi.size).transpose() *
          b.segment(rows.block_column[j], bj.size);
    }
  }
}

void AddPoint(const Sweep& sweep,
              std::size_t point,
              PointRows* rows,
              std::vector<int>* component,
              std::vector<std::size_t>* looks,
              Partial* out) {
  LinearisePoint(sweep.problem, sweep.state, {}, point, rows);
  if (rows->looks_not_evaluated > 0) return;  // not a solution: the adjustment is refused anyway
  const Eigen::Index m = rows->row_count, n = rows->column_count;
  ComponentsOfRows(sweep, point, rows->row_count, component, looks);
  TurnToMeasured(sweep.problem, *looks, rows->a.topLeftCorner(m, 3 + n + 1));
  const Eigen::MatrixXd a = rows->a.topLeftCorner(m, 3 + n + 1);
  const Eigen::Matrix3d r = EliminatePoint(rows).r;
  const Eigen::MatrixXd q =
      r.transpose().triangularView<Eigen::Lower>().solve(a.leftCols<3>().transpose()).transpose();
  // R = P - B C B' within the point; P projects on what the point leaves open, B = P J_c.
  const Eigen::MatrixXd p = Eigen::MatrixXd::Identity(m, m) - q * q.transpose();
  Eigen::MatrixXd shared = Eigen::MatrixXd::Zero(m, m), b;
  if (n > 0) {
    b = a.middleCols(3, n) - q * rows->a.block(0, 3, 3, n);
    shared = b * Gather(*sweep.inverse, *rows) * b.transpose();
  }
  VarianceSums& sums = out->sums;
  for (Eigen::Index i = 0; i < m; ++i) {
    const int k = (*component)[static_cast<std::size_t>(i)];
    if (k < 0) continue;
    ++sums.looks[static_cast<std::size_t>(k)];
    sums.square_1[k] += a(i, 3 + n) * a(i, 3 + n);
    sums.redundancy_1[k] += p(i, i) - shared(i, i);
    for (Eigen::Index j = 0; j < m; ++j) {
      const int l = (*component)[static_cast<std::size_t>(j)];
      if (l < 0) continue;
      // The square of `shared` is a part of the sum over all pairs of points, added at the end.
      sums.helmert_1(k, l) += sweep.couples ? p(i, j) * (p(i, j) - 2.0 * shared(i, j))
                                            : (p(i, j) - shared(i, j)) * (p(i, j) - shared(i, j));
    }
    if (sweep.couples) {
      AddNormals(sweep.problem, *rows, b.row(i), &out->normals[static_cast<std::size_t>(k)]);
    }
  }
}

/// Sum over all pairs of rows of (B C B')_ij^2 by component: tr(C M_k C M_l).
void AddCoupling(const ReducedSystem& system,
                 const std::vector<Eigen::MatrixXd>& normals,
                 Eigen::MatrixXd* helmert_1) {
  std::vector<Eigen::MatrixXd> solved;
  for (const Eigen::MatrixXd& m : normals) solved.push_back(system.SolveFor(m));
  for (std::size_t k = 0; k < solved.size(); ++k) {
    for (std::size_t l = 0; l < solved.size(); ++l) {
      (*helmert_1)(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(l)) +=
          solved[k].cwiseProduct(solved[l].transpose()).sum();
    }
  }
}

}  // namespace

VarianceSums SumVariances(const AdjustmentProblem& problem,
                          const BlockState& state,
                          const ReducedSystem& system,
                          const std::vector<std::array<int, 2>>& component_of,
                          std::size_t component_count) {
  Sweep sweep{problem, state, component_of, component_count, std::nullopt};
  const std::size_t points = problem.block.points.size();
  std::size_t partials = std::clamp<std::size_t>(points / kPointsPerPartial, 1, kMostPartials);
  if (problem.layout.size() > 0) {
    sweep.inverse = system.SelectedInverse();
    const auto n = static_cast<std::size_t>(problem.layout.size());
    const std::size_t bytes = component_count * n * n * sizeof(double);
    sweep.couples = bytes <= kMostBytes;
    if (sweep.couples) partials = std::clamp<std::size_t>(kMostBytes / bytes, 1, partials);
  }
  std::vector<std::optional<Partial>> parts(partials);
  const std::size_t per_part = (points + partials - 1) / partials;
  ParallelForChunks(points, per_part, [&](std::size_t part, std::size_t begin, std::size_t end) {
    Partial& out = parts[part].emplace(sweep);
    PointRows rows;
    std::vector<int> component;
    std::vector<std::size_t> looks;
    for (std::size_t point = begin; point < end; ++point) {
      if (problem.Solves(point)) AddPoint(sweep, point, &rows, &component, &looks, &out);
    }
  });
  Partial total(sweep);
  for (const std::optional<Partial>& part : parts) {
    if (!part) continue;
    for (std::size_t k = 0; k < component_count; ++k) total.sums.looks[k] += part->sums.looks[k];
    total.sums.square_1 += part->sums.square_1;
    total.sums.redundancy_1 += part->sums.redundancy_1;
    total.sums.helmert_1 += part->sums.helmert_1;
    for (std::size_t k = 0; k < total.normals.size(); ++k) total.normals[k] += part->normals[k];
  }
  if (sweep.couples) AddCoupling(system, total.normals, &total.sums.helmert_1);
  return total.sums;
}

}  // namespace sarblock
