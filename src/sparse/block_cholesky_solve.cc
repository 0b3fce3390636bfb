// SPDX-License-Identifier: Apache-2.0
#include "sarblock/sparse/block_cholesky.h"
#include "sarblock/sparse/least_eigenpairs.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "block_cholesky_impl.h"
#include "dense_kernels.h"
#include <glog/logging.h>

namespace sarblock {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using sparse::Front;
using sparse::Symbolic;

std::size_t At(int index) { return static_cast<std::size_t>(index); }

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
  constexpr int kSteps = 200;
  constexpr double kRelativeChange = 1e-6;
  EigenPair pair;
  pair.vector = StartVector(impl_->pattern->rows());
  for (int step = 0; step < kSteps && pair.vector.size() > 0; ++step) {
    VectorXd next = pair.vector;
    Solve(next);
    const double value = 1.0 / pair.vector.dot(next);  // Rayleigh quotient of the inverse
    pair.vector = next.normalized();
    const double change = std::abs(value - pair.value);
    pair.value = value;
    if (change <= kRelativeChange * value) {
      break;
    }
  }
  return pair;
}

double BlockCholesky::ConditionEstimate(const BlockSymmetricMatrix& matrix) const {
  return matrix.rows() > 0 ? LargestEigenvalue(matrix) / SmallestEigenpair().value : 1.0;
}

}  // namespace sarblock
