// SPDX-License-Identifier: Apache-2.0
#include "least_eigenpairs.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "linear/dense.h"

namespace sarblock {
namespace {

/// The same start on every machine: std::mt19937_64 is specified bit by bit.
Eigen::MatrixXd StartColumns(Eigen::Index rows, Eigen::Index columns) {
  std::mt19937_64 engine(19790801);
  Eigen::MatrixXd x(rows, columns);
  for (Eigen::Index c = 0; c < columns; ++c) {
    for (Eigen::Index r = 0; r < rows; ++r) {
      x(r, c) = static_cast<double>(engine() >> 11) * 0x1p-53 - 0.5;
    }
  }
  return x;
}

void Orthonormalise(Eigen::MatrixXd* x) { *x = dense::Orthogonal(*x).Q(x->cols()); }

/// Rotates the columns to the Ritz vectors of `matrix`; returns the Ritz values.
Eigen::VectorXd Ritz(const BorderedMatrix& matrix, Eigen::MatrixXd* x) {
  Eigen::MatrixXd product(x->rows(), x->cols());
  for (Eigen::Index c = 0; c < x->cols(); ++c) product.col(c) = matrix.Multiply(x->col(c));
  const Eigen::MatrixXd h = x->transpose() * product;
  const dense::Eigenpairs eigen = dense::SymmetricEigenpairs(0.5 * (h + h.transpose()));
  *x = *x * eigen.vectors;
  return eigen.values;
}

}  // namespace

LeastEigenpairs FindLeastEigenpairs(const BorderedMatrix& matrix,
                                    const BorderedCholesky& factor,
                                    const LeastEigenpairOptions& options) {
  LeastEigenpairs pairs;
  const Eigen::Index n = matrix.rows(), k = std::min<Eigen::Index>(n, options.count);
  if (k == 0) return pairs;
  pairs.vectors = StartColumns(n, k);
  Orthonormalise(&pairs.vectors);
  pairs.values = Eigen::VectorXd::Constant(k, 1.0);
  const auto settled = [&](const Eigen::VectorXd& now) {
    for (Eigen::Index i = 0; i < k; ++i) {
      if ((i > 0 && !(now[i] < options.settle_below_1)) || now[i] < options.rounding_1) continue;
      if (std::abs(now[i] - pairs.values[i]) > options.relative_change_1 * now[i]) return false;
    }
    return true;
  };
  for (int step = 0; step < options.most_steps; ++step) {
    factor.Solve(pairs.vectors);
    Orthonormalise(&pairs.vectors);
    const Eigen::VectorXd now = Ritz(matrix, &pairs.vectors);
    const bool done = settled(now) && step > 0;
    pairs.values = now;
    if (done) break;
  }
  return pairs;
}

double LargestEigenvalue(const BorderedMatrix& matrix) {
  constexpr int kSteps = 200;
  constexpr double kRelativeChange = 1e-3;
  Eigen::VectorXd x = StartColumns(matrix.rows(), 1).col(0).normalized();
  double largest = 0.0;
  for (int step = 0; step < kSteps && x.size() > 0; ++step) {
    const Eigen::VectorXd next = matrix.Multiply(x);
    const double value = x.dot(next);
    x = next.normalized();
    const double change = std::abs(value - largest);
    largest = value;
    if (change <= kRelativeChange * value) break;
  }
  return largest;
}

}  // namespace sarblock
