// SPDX-License-Identifier: Apache-2.0
#include "bordered_matrix.h"

#include "dense_kernels.h"

namespace sarblock {
namespace {

int Terms(const Eigen::MatrixXd& k) { return static_cast<int>(k.rows()); }

}  // namespace

Eigen::VectorXd BorderedMatrix::Diagonal() const {
  Eigen::VectorXd out(rows());
  for (int b = 0; b < sparse.block_count(); ++b) {
    out.segment(sparse.offset(b), sparse.size(b)) = sparse.Block(b, b).diagonal();
  }
  return out - border.colwise().squaredNorm().transpose();
}

Eigen::MatrixXd BorderedMatrix::ToDense() const {
  return sparse.ToDense() - border.transpose() * border;
}

Eigen::VectorXd BorderedMatrix::Multiply(const Eigen::Ref<const Eigen::VectorXd>& x) const {
  Eigen::VectorXd out = sparse.Multiply(x);
  if (border.rows() > 0) out -= border.transpose() * (border * x);
  return out;
}

BorderedMatrix BorderedMatrix::Scaled(const Eigen::VectorXd& d) const {
  BorderedMatrix out(sparse, border * d.asDiagonal());
  ScaleBlocks(d, &out.sparse);
  return out;
}

void ScaleBlocks(const Eigen::VectorXd& d, BlockSymmetricMatrix* matrix) {
  for (int j = 0; j < matrix->block_count(); ++j) {
    for (const int i : matrix->RowsOfColumn(j)) {
      matrix->Block(i, j) = d.segment(matrix->offset(i), matrix->size(i)).asDiagonal() *
                            matrix->Block(i, j) *
                            d.segment(matrix->offset(j), matrix->size(j)).asDiagonal();
    }
  }
}

bool BorderedCholesky::Factorize(const BorderedMatrix& matrix) {
  if (!factor_.Factorize(matrix.sparse).positive_definite) return false;
  z_ = matrix.border.transpose();
  k_.setIdentity(z_.cols(), z_.cols());
  if (z_.cols() == 0) return true;
  factor_.Solve(z_);
  k_ -= matrix.border * z_;
  return dense::Factor(Terms(k_), k_.data(), Terms(k_)) == 0;
}

void BorderedCholesky::Solve(Eigen::Ref<Eigen::MatrixXd> b) const {
  if (z_.cols() == 0) {
    factor_.Solve(b);
    return;
  }
  Eigen::MatrixXd of_border = z_.transpose() * b;
  const int columns = static_cast<int>(b.cols());
  dense::SolveLeft(Terms(k_), columns, k_.data(), Terms(k_), of_border.data(), Terms(k_));
  dense::SolveLeftTransposed(Terms(k_), columns, k_.data(), Terms(k_), of_border.data(), Terms(k_));
  factor_.Solve(b);
  b += z_ * of_border;
}

BorderedInverse BorderedCholesky::SelectedInverse() const {
  BorderedInverse out{factor_.SelectedInverse(), z_.transpose()};
  if (z_.cols() == 0) return out;
  const int rows = static_cast<int>(z_.rows());
  // W = L^-1 Z', then S^-1 = A^-1 + W' W and T S^-1 = L'^-1 W.
  dense::SolveLeft(Terms(k_), rows, k_.data(), Terms(k_), out.border.data(), Terms(k_));
  BlockSymmetricMatrix& blocks = out.blocks;
  for (int j = 0; j < blocks.block_count(); ++j) {
    const auto of_column = out.border.middleCols(blocks.offset(j), blocks.size(j));
    for (const int i : blocks.RowsOfColumn(j)) {
      blocks.Block(i, j) +=
          out.border.middleCols(blocks.offset(i), blocks.size(i)).transpose() * of_column;
    }
  }
  dense::SolveLeftTransposed(Terms(k_), rows, k_.data(), Terms(k_), out.border.data(), Terms(k_));
  return out;
}

}  // namespace sarblock
