// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <mutex>
#include <random>
#include <vector>

#include "block_cholesky.h"
#include "block_cholesky_impl.h"
#include "dense_kernels.h"
#include "least_eigenpairs.h"
#include <Eigen/Eigenvalues>
#include <glog/logging.h>

namespace sarblock {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using sparse::At;
using sparse::Front;
using sparse::Symbolic;

/// Calls `visit(row in `remaining`, row in elimination order, rows)` for the blocks of R.
template <typename Visit>
void ForRemaining(const Symbolic& symbolic, const Front& front, Visit visit) {
  int row = 0;
  for (const int block : front.rows) {
    const int begin = symbolic.row_begin[At(block)];
    const int size = symbolic.row_begin[At(block) + 1] - begin;
    visit(row, begin, size);
    row += size;
  }
}

MatrixXd Permuted(const Symbolic& symbolic, const Eigen::Ref<const MatrixXd>& b) {
  CHECK_EQ(b.rows(), static_cast<Eigen::Index>(symbolic.original_row.size()));
  MatrixXd x(b.rows(), b.cols());
  for (Eigen::Index c = 0; c < b.cols(); ++c) {
    for (Eigen::Index r = 0; r < b.rows(); ++r) {
      x(r, c) = b(symbolic.original_row[static_cast<std::size_t>(r)], c);
    }
  }
  return x;
}

int RowCount(const MatrixXd& x) { return static_cast<int>(x.rows()); }
int ColumnCount(const MatrixXd& x) { return static_cast<int>(x.cols()); }

/// x = L^-1 x, front by front from the leaves to the roots.
void Forward(const Symbolic& symbolic, const double* factor, MatrixXd& x) {
  MatrixXd remaining;
  for (const Front& front : symbolic.fronts) {
    const int n = front.eliminated, height = front.height();
    if (n == 0) {
      continue;
    }
    const double* panel = factor + front.panel;
    double* top = x.data() + front.first_row;
    dense::SolveLeft(n, ColumnCount(x), panel, height, top, RowCount(x));
    if (front.remaining == 0) {
      continue;
    }
    remaining.resize(front.remaining, x.cols());
    dense::Product(front.remaining,
                   ColumnCount(x),
                   n,
                   panel + n,
                   height,
                   top,
                   RowCount(x),
                   remaining.data(),
                   front.remaining);
    ForRemaining(symbolic, front, [&](int row, int begin, int size) {
      x.middleRows(begin, size) -= remaining.middleRows(row, size);
    });
  }
}

/// x = L'^-1 x, front by front from the roots to the leaves.
void Backward(const Symbolic& symbolic, const double* factor, MatrixXd& x) {
  MatrixXd remaining;
  for (std::size_t f = symbolic.fronts.size(); f-- > 0;) {
    const Front& front = symbolic.fronts[f];
    const int n = front.eliminated, height = front.height();
    if (n == 0) {
      continue;
    }
    const double* panel = factor + front.panel;
    double* top = x.data() + front.first_row;
    if (front.remaining > 0) {
      remaining.resize(front.remaining, x.cols());
      ForRemaining(symbolic, front, [&](int row, int begin, int size) {
        remaining.middleRows(row, size) = x.middleRows(begin, size);
      });
      dense::SubtractTransposedProduct(n,
                                       ColumnCount(x),
                                       front.remaining,
                                       panel + n,
                                       height,
                                       remaining.data(),
                                       front.remaining,
                                       top,
                                       RowCount(x));
    }
    dense::SolveLeftTransposed(n, ColumnCount(x), panel, height, top, RowCount(x));
  }
}

/// The same start on every machine: std::mt19937_64 is specified bit by bit.
VectorXd StartVector(Eigen::Index rows) {
  std::mt19937_64 engine(20220814);
  VectorXd x(rows);
  for (Eigen::Index r = 0; r < rows; ++r) {
    x[r] = static_cast<double>(engine() >> 11) * 0x1p-53 - 0.5;
  }
  return x.normalized();
}

constexpr int kStarts = 4;
constexpr int kKrylovVectors = 50;
constexpr double kEigenvalueChange = 1e-6;

/// Lanczos for the largest eigenvalue of the inverse (Golub, Van Loan, Matrix Computations, 10.1),
/// every vector made orthogonal to all before it, from pair->vector. Replaces the pair by its best
/// estimate; true where its value changes by less than kEigenvalueChange of itself.
bool LanczosOnInverse(const BlockCholesky& factor, BlockCholesky::EigenPair* pair) {
  const Eigen::Index n = pair->vector.size();
  const Eigen::Index most = std::min<Eigen::Index>(kKrylovVectors, n);
  MatrixXd basis(n, most);
  MatrixXd projected = MatrixXd::Zero(most, most);
  basis.col(0) = pair->vector;
  double largest = 0.0;
  bool settled = false;
  for (Eigen::Index k = 0; k < most; ++k) {
    VectorXd next = basis.col(k);
    factor.Solve(next);
    const auto known = basis.leftCols(k + 1);
    projected(k, k) = basis.col(k).dot(next);
    next -= known * (known.transpose() * next);
    next -= known * (known.transpose() * next);  // twice is enough
    const double left = next.norm();
    const Eigen::SelfAdjointEigenSolver<MatrixXd> ritz(projected.topLeftCorner(k + 1, k + 1));
    const double value = ritz.eigenvalues()[k];
    const double change = std::abs(value - largest);
    largest = value;
    const bool complete = !(left > 1e-14 * value) || k + 1 == n;
    settled = complete || (k > 0 && change <= kEigenvalueChange * value);
    if (settled || k + 1 == most) {
      pair->vector = (known * ritz.eigenvectors().col(k)).normalized();
      pair->value = 1.0 / value;
      break;
    }
    projected(k + 1, k) = projected(k, k + 1) = left;
    basis.col(k + 1) = next / left;
  }
  return settled;
}

}  // namespace

void BlockCholesky::Solve(Eigen::Ref<MatrixXd> b) const {
  impl_->RequireFactor();
  MatrixXd x = Permuted(impl_->symbolic, b);
  Forward(impl_->symbolic, impl_->factor.get(), x);
  Backward(impl_->symbolic, impl_->factor.get(), x);
  for (Eigen::Index c = 0; c < b.cols(); ++c) {
    for (Eigen::Index r = 0; r < b.rows(); ++r) {
      b(impl_->symbolic.original_row[static_cast<std::size_t>(r)], c) = x(r, c);
    }
  }
}

MatrixXd BlockCholesky::ForwardSolve(const Eigen::Ref<const MatrixXd>& b) const {
  impl_->RequireFactor();
  MatrixXd x = Permuted(impl_->symbolic, b);
  Forward(impl_->symbolic, impl_->factor.get(), x);
  return x;
}

BlockCholesky::EigenPair BlockCholesky::SmallestEigenpair() const {
  impl_->RequireFactor();
  const std::lock_guard lock(impl_->least_mutex);
  if (impl_->least) return *impl_->least;
  EigenPair pair;
  pair.vector = StartVector(impl_->pattern->rows());
  for (int start = 0; start < kStarts && pair.vector.size() > 0; ++start) {
    if (LanczosOnInverse(*this, &pair)) break;
  }
  impl_->least = pair;
  return pair;
}

double BlockCholesky::ConditionEstimate(const BlockSymmetricMatrix& matrix) const {
  return matrix.rows() > 0 ? LargestEigenvalue(matrix) / SmallestEigenpair().value : 1.0;
}

}  // namespace sarblock
