// SPDX-License-Identifier: Apache-2.0
#include "sarblock/sparse/block_cholesky.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "block_cholesky_impl.h"
#include "dense_kernels.h"
#include <glog/logging.h>

namespace sarblock {
namespace {

using sparse::Entry;
using sparse::Front;
using sparse::Run;

std::size_t At(int index) { return static_cast<std::size_t>(index); }

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
  CHECK_EQ(matrix.block_count(), impl.pattern->block_count());
  CHECK_EQ(matrix.values().size(), impl.pattern->ValueBegin(impl.pattern->slot_count()));
  const sparse::Symbolic& symbolic = impl.symbolic;
  impl.factored = false;
  if (!impl.factor) {
    impl.factor = std::make_unique_for_overwrite<double[]>(symbolic.factor_entries);
  }
  Outcome outcome;
  outcome.smallest_pivot_ratio = 1.0;
  std::vector<std::unique_ptr<double[]>> updates(symbolic.fronts.size());
  std::vector<double> diagonal;
  for (std::size_t f = 0; f < symbolic.fronts.size(); ++f) {
    const Front& front = symbolic.fronts[f];
    const int height = front.height(), n = front.eliminated;
    const std::size_t step = At(height) + 1;
    double* panel = impl.factor.get() + front.panel;
    std::fill_n(panel, At(height) * At(n), 0.0);
    Assemble(front, matrix.values(), panel);
    diagonal.resize(At(n));
    for (std::size_t k = 0; k < At(n); ++k) {
      diagonal[k] = panel[k * step];
    }
    if (front.remaining > 0) {
      updates[f] = std::make_unique<double[]>(At(front.remaining) * At(front.remaining));
    }
    for (const int child : front.children) {
      ExtendAdd(
          symbolic.fronts[At(child)], updates[At(child)].get(), front, panel, updates[f].get());
      updates[At(child)].reset();
    }
    const int failed = dense::Factor(n, panel, height);
    const int good = failed > 0 ? failed - 1 : n;
    for (int k = 0; k < good; ++k) {
      const double pivot = panel[At(k) * step];
      const double ratio = pivot * pivot / diagonal[At(k)];
      if (outcome.smallest_pivot_row < 0 || ratio < outcome.smallest_pivot_ratio) {
        outcome.smallest_pivot_ratio = ratio;
        outcome.smallest_pivot_row = symbolic.original_row[At(front.first_row + k)];
      }
    }
    if (failed > 0) {
      outcome.failed_row = symbolic.original_row[At(front.first_row + failed - 1)];
      outcome.smallest_pivot_row = outcome.failed_row;
      outcome.smallest_pivot_ratio = 0.0;
      return outcome;
    }
    dense::SolveRightTransposed(front.remaining, n, panel, height, panel + n, height);
    dense::SubtractSquare(front.remaining, n, panel + n, height, updates[f].get(), front.remaining);
  }
  impl.factored = true;
  outcome.positive_definite = true;
  return outcome;
}

std::size_t BlockCholesky::factor_entries() const { return impl_->symbolic.factor_entries; }

}  // namespace sarblock
