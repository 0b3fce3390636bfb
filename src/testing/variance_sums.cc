// SPDX-License-Identifier: Apache-2.0
#include "variance_sums.h"

#include <algorithm>
#include <optional>

#include "core/parallel.h"
#include "covariance/point_sweep.h"
#include "normals/elimination.h"

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

/// Everything about one point; storage reused from point to point.
struct PointState {
  PointFactor factor;
  PointColumns columns;
  std::vector<int> component;  // by row, -1 for control
};

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// C over the parameter blocks of a point.
Eigen::MatrixXd BlocksOf(const BlockSymmetricMatrix& inverse, const PointColumns& columns) {
  Eigen::MatrixXd c(columns.width, columns.width);
  for (std::size_t i = 0; i < columns.blocks.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      const auto block = inverse.Block(columns.blocks[i], columns.blocks[j]);
      const int ri = columns.begin[i], rj = columns.begin[j];
      c.block(ri, rj, block.rows(), block.cols()) = block;
      c.block(rj, ri, block.cols(), block.rows()) = block.transpose();
    }
  }
  return c;
}

/// normals += b' b of one row over the blocks of its point.
void AddNormals(const AdjustmentProblem& problem,
                const PointColumns& columns,
                const Eigen::RowVectorXd& b,
                Eigen::MatrixXd* normals) {
  for (std::size_t i = 0; i < columns.blocks.size(); ++i) {
    const ParameterBlock& bi = problem.layout.blocks[static_cast<std::size_t>(columns.blocks[i])];
    for (std::size_t j = 0; j < columns.blocks.size(); ++j) {
      const ParameterBlock& bj = problem.layout.blocks[static_cast<std::size_t>(columns.blocks[j])];
      normals->block(bi.offset, bj.offset, bi.size, bj.size).noalias() +=
          b.segment(columns.begin[i], bi.size).transpose() * b.segment(columns.begin[j], bj.size);
    }
  }
}

void AddPoint(const Sweep& sweep, std::size_t point, PointState* at, Partial* out) {
  const PointFactor& factor = at->factor;
  FactorPoint(sweep.problem, sweep.state, {}, 0.0, point, &at->factor);
  const Eigen::Index m = factor.row_count;
  at->component.clear();
  for (int k = 0; k < factor.look_count; ++k) {
    const std::size_t look = factor.looks[static_cast<std::size_t>(k)].look;
    for (const int c : sweep.component_of[sweep.problem.block.looks.pass[look]]) {
      at->component.push_back(c);
    }
  }
  at->component.resize(static_cast<std::size_t>(m), -1);
  Eigen::MatrixXd q = Eigen::Map<const Eigen::MatrixXd>(factor.q.data(), m, 3);
  Eigen::MatrixXd v = Eigen::Map<const Eigen::VectorXd>(factor.e.data(), m);
  // R = P - B C B' within the point; P projects on what the point leaves open, B = P J_c.
  const Eigen::MatrixXd p = Eigen::MatrixXd::Identity(m, m) - q * q.transpose();
  Eigen::MatrixXd shared = Eigen::MatrixXd::Zero(m, m), b;
  if (sweep.inverse) {
    ProjectColumns(sweep.problem, factor, &at->columns);
    Complement(sweep.problem, factor, &at->columns);
    const Eigen::Index n = at->columns.width;
    b = Eigen::Map<const RowMajor>(at->columns.m.data(), m, n + 1).leftCols(n);
    shared = b * BlocksOf(*sweep.inverse, at->columns) * b.transpose();
  }
  VarianceSums& sums = out->sums;
  for (Eigen::Index i = 0; i < m; ++i) {
    const int k = at->component[static_cast<std::size_t>(i)];
    if (k < 0) continue;
    ++sums.looks[static_cast<std::size_t>(k)];
    sums.square_1[k] += v(i, 0) * v(i, 0);
    sums.redundancy_1[k] += p(i, i) - shared(i, i);
    for (Eigen::Index j = 0; j < m; ++j) {
      const int l = at->component[static_cast<std::size_t>(j)];
      if (l < 0) continue;
      // The square of `shared` is a part of the sum over all pairs of points, added at the end.
      sums.helmert_1(k, l) += sweep.couples ? p(i, j) * (p(i, j) - 2.0 * shared(i, j))
                                            : (p(i, j) - shared(i, j)) * (p(i, j) - shared(i, j));
    }
    if (sweep.couples) {
      AddNormals(sweep.problem, at->columns, b.row(i), &out->normals[static_cast<std::size_t>(k)]);
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
    PointState at;
    for (std::size_t point = begin; point < end; ++point) {
      if (problem.Solves(point)) AddPoint(sweep, point, &at, &out);
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
