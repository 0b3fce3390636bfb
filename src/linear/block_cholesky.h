// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <utility>

#include "block_matrix.h"
#include "front_ranks.h"
#include "fronts.h"
#include "symbolic.h"
#include <Eigen/Core>

namespace sarblock {

/// Cholesky factor of a BlockSymmetricMatrix, its solves and its selected inverse.
///
/// P S P' = L L', P a fill-reducing order of the block graph (AMD, or METIS where that is less
/// work), `last` blocks kept at the end.
/// Multifrontal on supernodes: dense fronts, BLAS kernels. The selected inverse is the Takahashi
/// recursion supernode by supernode from the root down: with front variables J (eliminated) and R
/// (the rest), Z_RJ = -Z_RR L_RJ L_JJ^-1, Z_JJ = L_JJ^-T L_JJ^-1 - (L_RJ L_JJ^-1)' Z_RJ, and Z_RR
/// is a submatrix of the parent's Z (docs/theory/covariance.md). Work grows with the fill, never
/// with the square of the matrix. Results do not depend on the number of threads.
///
/// Threads: those ThreadLimit allows (core/threads.h), over the branches of the elimination tree
/// and over the tiles of large fronts.
///
/// Memory: factor_entries() doubles and, while factoring or inverting, the waiting fronts (about a
/// third of the factor on a two-dimensional grid of passes, more by one branch of the tree for each
/// further thread). Constructing one restricts OpenBLAS, if that is the BLAS loaded, to one thread
/// for the whole process; the threads above call it side by side.
///
/// Ranks (core/ranks.h): constructed within a RanksScope of two or more, a factor of
/// `divided_operations` or more is distributed over all of them, each front on one rank, subtree by
/// subtree (front_ranks.h). All ranks then call its functions together, in that scope and outside
/// of loops; results are those of a single process, bit for bit, and available on every rank. Then
/// any function may throw OtherRankFailed. A smaller one is factored by every rank.
///
/// Diagonal blocks: only the lower triangle of S is read; SelectedInverse fills both.
class BlockCholesky {
 public:
  /// The sum of h^2 over the columns of L, h their entries, from which on ranks divide the factor:
  /// some hundredths of a second of one processor, where exchanges take thousandths.
  static constexpr double kDividedOperations = 1e9;

  /// Symbolic analysis of a pattern; may be kept for any number of factorisations.
  /// `last` names blocks to be eliminated last (shared parameters seen by all).
  explicit BlockCholesky(std::shared_ptr<const BlockPattern> pattern,
                         std::span<const int> last = {},
                         double divided_operations = kDividedOperations);
  explicit BlockCholesky(const BlockSymmetricMatrix& matrix,
                         std::span<const int> last = {},
                         double divided_operations = kDividedOperations)
      : BlockCholesky(matrix.pattern(), last, divided_operations) {}
  ~BlockCholesky();
  BlockCholesky(BlockCholesky&&) noexcept;
  BlockCholesky& operator=(BlockCholesky&&) noexcept;

  using Outcome = FactorOutcome;
  /// Factors `matrix` (same pattern). After a failure only Factorize may be called; the least
  /// pivot is then the one that failed, with ratio 0. A matrix that is singular but for rounding
  /// may pass: judge smallest_pivot_ratio, which is of the order of 1e-16 there.
  [[nodiscard]] Outcome Factorize(const BlockSymmetricMatrix& matrix);

  /// Solves S X = B in place, any number of columns (original order of rows).
  void Solve(Eigen::Ref<Eigen::MatrixXd> b) const;

  /// Blocks of S^-1 on the pattern of S (exact, not an approximation).
  [[nodiscard]] BlockSymmetricMatrix SelectedInverse() const;

  /// Whether its fronts are on several ranks.
  [[nodiscard]] bool divided() const;
  [[nodiscard]] std::size_t factor_entries() const;  ///< doubles of the factor, on all ranks
  /// Memory and work, known before anything is allocated; those of the rank that needs most.
  [[nodiscard]] FactorNeeds Needs() const;
  /// Doubles used so far on this rank, counted when they were allocated.
  [[nodiscard]] FactorNeeds Used() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sarblock

namespace sarblock::sparse {

/// x = (L L')^-1 x, rows in elimination order; x is identical on all ranks on entry and on return.
/// `factor` holds this rank's panels. Throws OtherRankFailed.
void SolveFronts(const OwnFronts& own, const double* factor, Eigen::MatrixXd* x);

}  // namespace sarblock::sparse

namespace sarblock {

/// S = A - T' T: A on a pattern of blocks, T a few rows over all columns, whose square would fill
/// the pattern. Without rows S is A.
struct BorderedMatrix {
  BorderedMatrix() = default;
  BorderedMatrix(BlockSymmetricMatrix a)  // NOLINT(google-explicit-constructor): S = A
      : sparse(std::move(a)), border(Eigen::MatrixXd(0, sparse.rows())) {}
  BorderedMatrix(BlockSymmetricMatrix a, Border t) : sparse(std::move(a)), border(std::move(t)) {}
  BorderedMatrix(BlockSymmetricMatrix a, const Eigen::MatrixXd& t)
      : sparse(std::move(a)), border(t) {}

  BlockSymmetricMatrix sparse;  ///< A
  Border border;                ///< T, terms x rows()

  [[nodiscard]] int rows() const { return sparse.rows(); }
  [[nodiscard]] Eigen::VectorXd Diagonal() const;
  [[nodiscard]] Eigen::MatrixXd ToDense() const;
  [[nodiscard]] Eigen::MatrixXd Multiply(const Eigen::Ref<const Eigen::MatrixXd>& x) const;
  /// D S D with the diagonal matrix D of rows() elements.
  [[nodiscard]] BorderedMatrix Scaled(const Eigen::VectorXd& d) const;
};

/// `matrix` becomes D M D with the diagonal matrix D of its rows.
void ScaleBlocks(const Eigen::VectorXd& d, BlockSymmetricMatrix* matrix);

/// Parts of the inverse of a BorderedMatrix.
struct BorderedInverse {
  BlockSymmetricMatrix blocks;  ///< S^-1 on the pattern of A
  Border border;                ///< T S^-1 on the pattern of T
};

/// Factor of a BorderedMatrix: the factor of A, and that of the border reduced by A (Golub and Van
/// Loan, Matrix Computations, 2.1.4, Sherman, Morrison and Woodbury; the same arithmetic as
/// eliminating A from [A T'; T I]):
///
///     Z = A^-1 T',   K = I - T Z,   S^-1 = A^-1 + Z K^-1 Z',   T S^-1 = K^-1 Z'
///
/// A is positive definite where S is. Costs a solution with as many columns as a group of T has
/// terms, since groups that A does not join are solved for side by side. Among
/// ranks the factor of A is divided as BlockCholesky says; Z and K are on all of them.
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
  // As in BlockCholesky, for the factor of A.
  [[nodiscard]] bool divided() const { return factor_.divided(); }
  [[nodiscard]] FactorNeeds Needs() const { return factor_.Needs(); }
  [[nodiscard]] FactorNeeds Used() const { return factor_.Used(); }

 private:
  void SolveTerms(const Border& t, int first, int count);

  BlockCholesky factor_;
  Border z_;           // Z' on the pattern of T
  Eigen::MatrixXd k_;  // L of K = L L', in the lower triangle
};

}  // namespace sarblock
