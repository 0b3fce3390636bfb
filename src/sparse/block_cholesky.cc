// SPDX-License-Identifier: Apache-2.0
#include "block_cholesky.h"

#include <algorithm>
#include <memory>
#include <span>
#include <utility>

#include "core/ranks.h"
#include "dense_kernels.h"
#include "front_division.h"
#include "front_factorisation.h"
#include "front_inverse.h"
#include "front_solve.h"
#include "symbolic.h"
#include "workspace.h"
#include <glog/logging.h>

namespace sarblock {
namespace {

using Eigen::MatrixXd;
using sparse::FrontMemory;
using sparse::OwnFronts;
using sparse::Symbolic;

OwnFronts Divide(Symbolic symbolic, double divided_operations) {
  const Ranks* const ranks = RanksScope::Current();
  if (ranks == nullptr || symbolic.operations < divided_operations) {
    sparse::FrontDivision alone = sparse::DivideFronts(symbolic.fronts, 1);
    return {std::move(symbolic), std::move(alone), 0};
  }
  sparse::FrontDivision division = sparse::DivideFronts(symbolic.fronts, ranks->size());
  return {std::move(symbolic), std::move(division), ranks->rank()};
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

}  // namespace

struct BlockCholesky::Impl {
  std::shared_ptr<const BlockPattern> pattern;
  OwnFronts own;
  std::unique_ptr<FrontMemory> factor_memory;
  FrontMemory::Place factor;  ///< the own fronts' panels, column-major, lower part valid
  bool factored = false;
  FactorNeeds used;

  /// CHECKs that the last Factorize succeeded.
  void RequireFactor() const;
};

void BlockCholesky::Impl::RequireFactor() const {
  CHECK(factored) << "the matrix has not been factored";
}

BlockCholesky::BlockCholesky(std::shared_ptr<const BlockPattern> pattern,
                             std::span<const int> last,
                             double divided_operations)
    : impl_(std::make_unique<Impl>()) {
  dense::UseOneBlasThread();
  impl_->pattern = std::move(pattern);
  impl_->own = Divide(sparse::Analyse(*impl_->pattern, last), divided_operations);
}

BlockCholesky::~BlockCholesky() = default;
BlockCholesky::BlockCholesky(BlockCholesky&&) noexcept = default;
BlockCholesky& BlockCholesky::operator=(BlockCholesky&&) noexcept = default;

BlockCholesky::Outcome BlockCholesky::Factorize(const BlockSymmetricMatrix& matrix) {
  Impl& impl = *impl_;
  CHECK(matrix.pattern() == impl.pattern || *matrix.pattern() == *impl.pattern)
      << "the matrix has another pattern than the one analysed";
  impl.factored = false;
  if (!impl.factor) {
    impl.factor_memory =
        std::make_unique<FrontMemory>(FrontMemory::Rounded(impl.own.panel_entries));
    impl.factor = impl.factor_memory->Take(impl.own.panel_entries);
  }
  sparse::FrontFactorisation factorisation(impl.own, matrix.values(), impl.factor.get());
  const Outcome outcome = factorisation.Run();
  impl.used.factor = impl.own.panel_entries;
  impl.used.waiting = std::max(impl.used.waiting, factorisation.most_waiting());
  impl.factored = outcome.positive_definite;
  return outcome;
}

void BlockCholesky::Solve(Eigen::Ref<MatrixXd> b) const {
  impl_->RequireFactor();
  const Symbolic& symbolic = impl_->own.symbolic;
  MatrixXd x = Permuted(symbolic, b);
  sparse::SolveFronts(impl_->own, impl_->factor.get(), &x);
  for (Eigen::Index c = 0; c < b.cols(); ++c) {
    for (Eigen::Index r = 0; r < b.rows(); ++r) {
      b(symbolic.original_row[static_cast<std::size_t>(r)], c) = x(r, c);
    }
  }
}

BlockSymmetricMatrix BlockCholesky::SelectedInverse() const {
  impl_->RequireFactor();
  BlockSymmetricMatrix inverse(impl_->pattern);
  const std::size_t taken = sparse::InvertFronts(impl_->own, impl_->factor.get(), inverse.values());
  impl_->used.inverse_fronts = std::max(impl_->used.inverse_fronts, taken);
  return inverse;
}

bool BlockCholesky::divided() const { return impl_->own.divided(); }

std::size_t BlockCholesky::factor_entries() const { return impl_->own.symbolic.factor_entries; }

FactorNeeds BlockCholesky::Needs() const {
  const OwnFronts& own = impl_->own;
  FactorNeeds largest;
  for (const FactorNeeds& needs : sparse::NeedsOfRanks(own.symbolic.fronts, own.division)) {
    if (sparse::MostDoubles(needs) >= sparse::MostDoubles(largest)) largest = needs;
  }
  largest.operations = 0.5 * own.symbolic.operations;
  largest.dissected = own.symbolic.dissected;
  return largest;
}

FactorNeeds BlockCholesky::Used() const { return impl_->used; }

}  // namespace sarblock
