// SPDX-License-Identifier: Apache-2.0
#include "block_cholesky.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "block_cholesky_impl.h"
#include "dense_kernels.h"
#include "front_schedule.h"
#include "tiled_kernels.h"
#include <glog/logging.h>

namespace sarblock {
namespace {

using sparse::At;
using sparse::Entry;
using sparse::Front;
using sparse::FrontMemory;
using sparse::Run;

/// Adds the blocks of S a front eliminates to its zeroed panel.
void Assemble(const Front& front, std::span<const double> values, double* panel) {
  const std::size_t ld = At(front.height());
  for (const Entry& entry : front.entries) {
    const double* value = values.data() + entry.value;
    for (int c = 0; c < entry.width; ++c) {
      double* target = panel + At(entry.column + c) * ld + At(entry.row);
      for (int r = 0; r < entry.height; ++r) {
        target[r] += entry.transposed ? value[At(r) * At(entry.width) + At(c)]
                                      : value[At(c) * At(entry.height) + At(r)];
      }
    }
  }
}

/// Adds a child's update matrix (lower triangle) to the panel and update matrix of its parent.
void ExtendAdd(const Front& child,
               const double* child_update,
               const Front& front,
               double* panel,
               double* update) {
  const std::size_t ld = At(front.height()), ld_update = At(front.remaining);
  for (std::size_t q = 0; q < child.runs.size(); ++q) {
    for (int t = 0; t < child.runs[q].length; ++t) {
      const int column = child.runs[q].parent_begin + t;
      double* target = column < front.eliminated
                           ? panel + At(column) * ld
                           : update + At(column - front.eliminated) * ld_update - front.eliminated;
      const double* source = child_update + At(child.runs[q].begin + t) * At(child.remaining);
      for (std::size_t p = q; p < child.runs.size(); ++p) {
        const int skip = p == q ? t : 0;  // above the diagonal
        const double* from = source + child.runs[p].begin;
        double* to = target + child.runs[p].parent_begin;
        for (int r = skip; r < child.runs[p].length; ++r) {
          to[r] += from[r];
        }
      }
    }
  }
}

std::size_t UpdateSize(const Front& front) { return At(front.remaining) * At(front.remaining); }

std::size_t AllUpdates(const std::vector<Front>& fronts) {
  std::size_t sum = 0;
  for (const Front& front : fronts) sum += FrontMemory::Rounded(UpdateSize(front));
  return sum;
}

void ZeroLower(int n, double* a) {
  for (int c = 0; c < n; ++c) {
    std::fill_n(a + At(c) * At(n) + c, n - c, 0.0);
  }
}

/// One factorisation: every front into its panel, its update matrix handed to its parent.
class FrontFactorisation {
 public:
  FrontFactorisation(const sparse::Symbolic& symbolic,
                     std::span<const double> values,
                     double* factor)
      : symbolic_(symbolic),
        values_(values),
        factor_(factor),
        memory_(AllUpdates(symbolic.fronts)),
        updates_(symbolic.fronts.size()),
        pivots_(symbolic.fronts.size()),
        failed_front_(symbolic.fronts.size()) {}

  BlockCholesky::Outcome Run() {
    sparse::ForFronts(symbolic_.fronts, sparse::Walk::kUp, [this](std::size_t f) { Work(f); });
    BlockCholesky::Outcome outcome;
    outcome.smallest_pivot_ratio = 1.0;
    const std::size_t end = std::min(symbolic_.fronts.size(), failed_front_ + 1);
    for (std::size_t f = 0; f < end; ++f) {  // as if one front had followed the other
      const Pivot& pivot = pivots_[f];
      if (pivot.row < 0) continue;
      if (outcome.smallest_pivot_row < 0 || pivot.ratio < outcome.smallest_pivot_ratio) {
        outcome.smallest_pivot_ratio = pivot.ratio;
        outcome.smallest_pivot_row = symbolic_.original_row[At(pivot.row)];
      }
    }
    outcome.positive_definite = failed_front_ == symbolic_.fronts.size();
    if (!outcome.positive_definite) {
      outcome.failed_row = symbolic_.original_row[At(pivots_[failed_front_].row)];
    }
    return outcome;
  }

 private:
  /// The least pivot of a front, or the one that failed, with ratio 0.
  struct Pivot {
    double ratio = 1.0;
    int row = -1;  // in elimination order
  };

  void Work(std::size_t f) {
    // Fronts before the failed one go on: a failure among them is the one to report.
    if (f > failed_front_) return;
    const Front& front = symbolic_.fronts[f];
    const int height = front.height(), n = front.eliminated;
    double* panel = factor_ + front.panel;
    std::fill_n(panel, At(height) * At(n), 0.0);
    Assemble(front, values_, panel);
    std::vector<double> diagonal(At(n));
    for (std::size_t k = 0; k < At(n); ++k) diagonal[k] = panel[k * (At(height) + 1)];
    FrontMemory::Place update = memory_.Take(UpdateSize(front));
    ZeroLower(front.remaining, update.get());
    for (const int child : front.children) {
      ExtendAdd(symbolic_.fronts[At(child)], updates_[At(child)].get(), front, panel, update.get());
      updates_[At(child)].reset();
    }
    const int failed = dense::FactorPanel(height, n, panel, height);
    RecordPivots(f, diagonal, panel, failed);
    if (failed > 0) return;
    dense::SubtractSquareTiled(
        front.remaining, n, panel + n, height, update.get(), front.remaining);
    updates_[f] = std::move(update);
  }

  void RecordPivots(std::size_t f,
                    const std::vector<double>& diagonal,
                    const double* panel,
                    int failed) {
    const Front& front = symbolic_.fronts[f];
    Pivot& least = pivots_[f];
    const int good = failed > 0 ? failed - 1 : front.eliminated;
    for (int k = 0; k < good; ++k) {
      const double pivot = panel[At(k) * (At(front.height()) + 1)];
      const double ratio = pivot * pivot / diagonal[At(k)];
      if (least.row < 0 || ratio < least.ratio) least = {ratio, front.first_row + k};
    }
    if (failed == 0) return;
    least = {0.0, front.first_row + failed - 1};
    std::size_t before = failed_front_;
    while (f < before && !failed_front_.compare_exchange_weak(before, f)) {
    }
  }

  const sparse::Symbolic& symbolic_;
  std::span<const double> values_;
  double* factor_;
  FrontMemory memory_;
  std::vector<FrontMemory::Place> updates_;  // waiting for their parents
  std::vector<Pivot> pivots_;
  std::atomic<std::size_t> failed_front_;  // the first in postorder
};

}  // namespace

void BlockCholesky::Impl::RequireFactor() const {
  CHECK(factored) << "the matrix has not been factored";
}

BlockCholesky::BlockCholesky(const BlockSymmetricMatrix& pattern, std::span<const int> last)
    : impl_(std::make_unique<Impl>()) {
  dense::UseOneBlasThread();
  impl_->pattern = pattern.pattern();
  impl_->symbolic = sparse::Analyse(*impl_->pattern, last);
}

BlockCholesky::~BlockCholesky() = default;
BlockCholesky::BlockCholesky(BlockCholesky&&) noexcept = default;
BlockCholesky& BlockCholesky::operator=(BlockCholesky&&) noexcept = default;

BlockCholesky::Outcome BlockCholesky::Factorize(const BlockSymmetricMatrix& matrix) {
  Impl& impl = *impl_;
  CHECK(matrix.pattern() == impl.pattern || *matrix.pattern() == *impl.pattern)
      << "the matrix has another pattern than the one analysed";
  const sparse::Symbolic& symbolic = impl.symbolic;
  impl.factored = false;
  impl.least.reset();
  if (!impl.factor) {
    impl.factor_memory =
        std::make_unique<FrontMemory>(FrontMemory::Rounded(symbolic.factor_entries));
    impl.factor = impl.factor_memory->Take(symbolic.factor_entries);
  }
  FrontFactorisation factorisation(symbolic, matrix.values(), impl.factor.get());
  const Outcome outcome = factorisation.Run();
  impl.factored = outcome.positive_definite;
  return outcome;
}

std::size_t BlockCholesky::factor_entries() const { return impl_->symbolic.factor_entries; }

}  // namespace sarblock
