// SPDX-License-Identifier: Apache-2.0
#include "weak_basis.h"

#include <algorithm>
#include <cmath>

#include "block_structure.h"
#include "core/text.h"
#include "linear/dense.h"
#include "rigid_motions.h"
#include "weak_words.h"

namespace sarblock {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A motion counts as weak where this much of its length lies in the weak subspace.
constexpr double kInside_1 = 0.95;
/// Islands beyond this number are told of by the structure alone.
constexpr std::size_t kMostIslands = 8;

MatrixXd Orthonormal(const MatrixXd& a) {
  if (a.cols() == 0) return a;
  return dense::PivotedOrthogonal(a).Basis();
}

/// Rows that tell the columns of q, which are orthonormal, apart: each the longest of what those
/// before it leave. They belong to the subspace and not to its basis; of rows that are equal but
/// for rounding the first is taken.
std::vector<Index> TellingRows(const MatrixXd& q) {
  std::vector<Index> rows;
  MatrixXd left = q;
  for (Index k = 0; k < q.cols(); ++k) {
    const VectorXd lengths = left.rowwise().norm();
    Index longest = 0;
    for (Index i = 1; i < lengths.size(); ++i) {
      if (lengths[i] > lengths[longest] * (1.0 + 1e-6)) longest = i;
    }
    rows.push_back(longest);
    const VectorXd direction = left.row(longest).transpose() / lengths[longest];
    left -= (left * direction) * direction.transpose();
  }
  return rows;
}

/// The basis of the columns' span in which each has a row of its own where all others are zero; it
/// and its order do not depend on the columns that span it.
void MakeEchelon(MatrixXd* a) {
  if (a->cols() == 0) return;
  const MatrixXd q = Orthonormal(*a);
  const std::vector<Index> rows = TellingRows(q);
  MatrixXd head(q.cols(), q.cols());
  for (Index k = 0; k < q.cols(); ++k) head.row(k) = q.row(rows[static_cast<std::size_t>(k)]);
  *a = dense::PivotedOrthogonal(head.transpose()).Solve(q.transpose()).transpose();
}

/// The rigid motions of every island, in scaled parameters, columns of unit length or zero.
struct Candidates {
  MatrixXd columns;
  VectorXd lengths;  // of the columns before
  std::vector<std::string> whose;
};

Candidates CandidatesOf(const AdjustmentProblem& problem,
                        const std::vector<int>& pass_of_parameter,
                        const VectorXd& scale) {
  std::vector<std::vector<std::uint32_t>> islands = PassIslands(problem);
  if (islands.size() > kMostIslands) islands.resize(kMostIslands);
  Candidates out;
  out.columns = MatrixXd::Zero(scale.size(), kMotions * static_cast<Index>(islands.size()));
  out.lengths = VectorXd::Ones(out.columns.cols());
  for (std::size_t k = 0; k < islands.size(); ++k) {
    std::vector<std::string> names;
    for (const std::uint32_t pass : islands[k]) names.push_back(problem.block.passes[pass].id);
    out.whose.push_back(islands.size() == 1 ? "the whole block"
                                            : "the island of " + ListNames(names));
    out.columns.middleCols(kMotions * static_cast<Index>(k), kMotions) =
        scale.cwiseInverse().asDiagonal() * RigidMotions(problem, pass_of_parameter, islands[k]);
  }
  for (Index c = 0; c < out.columns.cols(); ++c) {
    const double length = out.columns.col(c).norm();
    if (!(length > 0.0)) continue;
    out.columns.col(c) /= length;
    out.lengths[c] = length;
  }
  return out;
}

/// Mixtures of the candidates that lie in the subspace, by columns of coefficients.
MatrixXd MotionsInside(const Candidates& candidates, const MatrixXd& weak) {
  const dense::PivotedOrthogonal qr(candidates.columns, 1e-6);
  if (qr.rank() == 0) return MatrixXd(candidates.columns.cols(), 0);
  const MatrixXd q = qr.Basis();
  const dense::SingularValues svd = dense::DecomposeSingular(weak.transpose() * q);
  const Index inside = (svd.values.array() >= kInside_1).count();
  if (inside == 0) return MatrixXd(candidates.columns.cols(), 0);
  MatrixXd part = qr.Solve(q * svd.v.leftCols(inside));
  MakeEchelon(&part);
  return part;
}

}  // namespace

std::vector<NamedDirection> NameableBasis(const AdjustmentProblem& problem,
                                          const std::vector<int>& pass_of_parameter,
                                          const VectorXd& scale,
                                          const MatrixXd& weak) {
  std::vector<NamedDirection> out;
  if (weak.cols() == 0) return out;
  const MatrixXd space = Orthonormal(weak);
  const Candidates candidates = CandidatesOf(problem, pass_of_parameter, scale);
  const MatrixXd part = MotionsInside(candidates, space);
  MatrixXd taken(space.cols(), part.cols());
  for (Index k = 0; k < part.cols(); ++k) {
    taken.col(k) = space.transpose() * (candidates.columns * part.col(k));
    // The island with the largest part, and of its motions those that count.
    Index most = 0;
    part.col(k).cwiseAbs().maxCoeff(&most);
    const Index first = most / kMotions * kMotions;
    Eigen::Matrix<double, kMotions, 1> motion;
    for (Index i = 0; i < kMotions; ++i) {
      const double coefficient = part(first + i, k);
      const bool counts = std::abs(coefficient) >= 0.1 * std::abs(part(most, k));
      motion[i] = counts ? coefficient / candidates.lengths[first + i] : 0.0;
    }
    out.push_back({(space * taken.col(k)).normalized(),
                   NameMotion(motion,
                              problem.block.frame.kind(),
                              candidates.whose[static_cast<std::size_t>(most / kMotions)])});
  }
  MatrixXd rest = space;
  if (part.cols() > 0) {
    const MatrixXd q = Orthonormal(taken);
    rest = space * dense::Orthogonal(q).Q(q.rows()).rightCols(q.rows() - q.cols());
  }
  MakeEchelon(&rest);
  for (Index k = 0; k < rest.cols(); ++k) out.push_back({rest.col(k).normalized(), {}});
  return out;
}

}  // namespace sarblock
