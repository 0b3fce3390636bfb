// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// A symmetric matrix of dense blocks over pairs of parameter blocks; the lower triangle is stored.
/// Block b has `sizes[b]` rows. The pattern always holds the diagonal. Blocks are column-major,
/// one flat array; column j's rows are sorted and start with j.
class BlockSymmetricMatrix {
 public:
  BlockSymmetricMatrix() = default;
  /// `pairs` are block pairs (i, j) in any order, duplicates allowed. All values start at zero.
  BlockSymmetricMatrix(std::vector<int> sizes, std::vector<std::pair<int, int>> pairs);

  [[nodiscard]] int block_count() const { return static_cast<int>(sizes_.size()); }
  [[nodiscard]] int size(int block) const { return sizes_[static_cast<std::size_t>(block)]; }
  [[nodiscard]] int offset(int block) const { return offsets_[static_cast<std::size_t>(block)]; }
  [[nodiscard]] int rows() const { return offsets_.back(); }
  [[nodiscard]] std::span<const int> RowsOfColumn(int column) const;
  [[nodiscard]] bool Contains(int i, int j) const;
  /// The stored block (i, j), i >= j, size(i) x size(j). It must be in the pattern (CHECK).
  [[nodiscard]] Eigen::Map<Eigen::MatrixXd> Block(int i, int j);
  [[nodiscard]] Eigen::Map<const Eigen::MatrixXd> Block(int i, int j) const;
  /// Flat values of all blocks, for summing per-thread copies in a fixed order.
  [[nodiscard]] std::span<double> values() { return values_; }
  [[nodiscard]] std::span<const double> values() const { return values_; }
  void SetZero();
  [[nodiscard]] Eigen::MatrixXd ToDense() const;

 private:
  [[nodiscard]] std::size_t Slot(int i, int j) const;
  std::vector<int> sizes_, offsets_;
  std::vector<std::size_t> column_begin_;  // into rows_ and block_begin_
  std::vector<int> rows_;
  std::vector<std::size_t> block_begin_;  // into values_
  std::vector<double> values_;
};

/// Cholesky factor of a BlockSymmetricMatrix, its solves and its selected inverse.
///
/// P S P' = L L', P a fill-reducing order (AMD) of the block graph, `last` blocks kept at the end.
/// Multifrontal on supernodes: dense fronts, BLAS kernels. The selected inverse is the Takahashi
/// recursion supernode by supernode from the root down: with front variables J (eliminated) and R
/// (the rest), Z_RJ = -Z_RR L_RJ L_JJ^-1, Z_JJ = L_JJ^-T L_JJ^-1 - (L_RJ L_JJ^-1)' Z_RJ, and Z_RR
/// is a submatrix of the parent's Z (docs/theory/covariance.md). Work grows with the fill, never
/// with the square of the matrix. Results do not depend on the number of threads.
class BlockCholesky {
 public:
  /// Symbolic analysis of a pattern; may be kept for any number of factorisations.
  /// `last` names blocks to be eliminated last (shared parameters seen by all).
  explicit BlockCholesky(const BlockSymmetricMatrix& pattern, std::span<const int> last = {});
  ~BlockCholesky();
  BlockCholesky(BlockCholesky&&) noexcept;
  BlockCholesky& operator=(BlockCholesky&&) noexcept;

  /// What Factorize met.
  struct Outcome {
    bool positive_definite = false;
    int failed_row = -1;                ///< row of S (original order) whose pivot was not positive
    double smallest_pivot_ratio = 0.0;  ///< least pivot / diagonal element, 1 for a diagonal S
    int smallest_pivot_row = -1;
  };
  /// Factors `matrix` (same pattern). After a failure only Factorize may be called.
  [[nodiscard]] Outcome Factorize(const BlockSymmetricMatrix& matrix);

  /// Solves S X = B in place, any number of columns (original order of rows).
  void Solve(Eigen::Ref<Eigen::MatrixXd> b) const;
  /// Solves L Y = P B and returns Y, so that B' S^-1 B = Y' Y.
  [[nodiscard]] Eigen::MatrixXd ForwardSolve(const Eigen::Ref<const Eigen::MatrixXd>& b) const;

  /// Blocks of S^-1 on the pattern of S (exact, not an approximation).
  [[nodiscard]] BlockSymmetricMatrix SelectedInverse() const;

  /// Least eigenvalue of S and its unit eigenvector by inverse iteration on the factor, to a
  /// relative change of 1e-6 or 200 steps. Deterministic start.
  struct EigenPair {
    double value = 0.0;
    Eigen::VectorXd vector;
  };
  [[nodiscard]] EigenPair SmallestEigenpair() const;

  [[nodiscard]] std::size_t factor_entries() const;  ///< doubles held by the factor

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sarblock
