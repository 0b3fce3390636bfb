// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <utility>

#include "block_cholesky.h"
#include "block_matrix.h"
#include <Eigen/Core>

namespace sarblock {

/// S = A - T' T: A on a pattern of blocks, T a few rows over all columns, whose square would fill
/// the pattern. Without rows S is A.
struct BorderedMatrix {
  BorderedMatrix() = default;
  BorderedMatrix(BlockSymmetricMatrix a)  // NOLINT(google-explicit-constructor): S = A
      : sparse(std::move(a)), border(0, sparse.rows()) {}
  BorderedMatrix(BlockSymmetricMatrix a, Eigen::MatrixXd t)
      : sparse(std::move(a)), border(std::move(t)) {}

  BlockSymmetricMatrix sparse;  ///< A
  Eigen::MatrixXd border;       ///< T, terms x rows()

  [[nodiscard]] int rows() const { return sparse.rows(); }
  [[nodiscard]] Eigen::VectorXd Diagonal() const;
  [[nodiscard]] Eigen::MatrixXd ToDense() const;
  [[nodiscard]] Eigen::VectorXd Multiply(const Eigen::Ref<const Eigen::VectorXd>& x) const;
  /// D S D with the diagonal matrix D of rows() elements.
  [[nodiscard]] BorderedMatrix Scaled(const Eigen::VectorXd& d) const;
};

/// `matrix` becomes D M D with the diagonal matrix D of its rows.
void ScaleBlocks(const Eigen::VectorXd& d, BlockSymmetricMatrix* matrix);

/// Parts of the inverse of a BorderedMatrix.
struct BorderedInverse {
  BlockSymmetricMatrix blocks;  ///< S^-1 on the pattern of A
  Eigen::MatrixXd border;       ///< T S^-1, terms x rows
};

/// Factor of a BorderedMatrix: that of A, and that of what A leaves of the border (Golub and Van
/// Loan, Matrix Computations, 2.1.4, Sherman, Morrison and Woodbury; the same arithmetic as
/// eliminating A from [A T'; T I]):
///
///     Z = A^-1 T',   K = I - T Z,   S^-1 = A^-1 + Z K^-1 Z',   T S^-1 = K^-1 Z'
///
/// A is positive definite where S is. Costs a solution with as many columns as T has rows. Among
/// ranks the factor of A is divided as BlockCholesky says; Z and K stand on all of them.
class BorderedCholesky {
 public:
  explicit BorderedCholesky(std::shared_ptr<const BlockPattern> pattern,
                            std::span<const int> last = {},
                            double divided_operations = BlockCholesky::kDividedOperations)
      : factor_(std::move(pattern), last, divided_operations) {}
  explicit BorderedCholesky(const BlockSymmetricMatrix& matrix,
                            std::span<const int> last = {},
                            double divided_operations = BlockCholesky::kDividedOperations)
      : factor_(matrix, last, divided_operations) {}

  /// False where S is not positive definite; then only Factorize may be called.
  [[nodiscard]] bool Factorize(const BorderedMatrix& matrix);
  /// Solves S X = B in place, any number of columns.
  void Solve(Eigen::Ref<Eigen::MatrixXd> b) const;
  [[nodiscard]] BorderedInverse SelectedInverse() const;
  // Of the factor of A.
  [[nodiscard]] bool divided() const { return factor_.divided(); }
  [[nodiscard]] FactorNeeds Needs() const { return factor_.Needs(); }
  [[nodiscard]] FactorNeeds Used() const { return factor_.Used(); }

 private:
  BlockCholesky factor_;
  Eigen::MatrixXd z_;  // Z, rows x terms
  Eigen::MatrixXd k_;  // L of K = L L', in the lower triangle
};

}  // namespace sarblock
