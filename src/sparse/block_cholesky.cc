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

std::ptrdiff_t UpdateSize(const Front& front) {
  return static_cast<std::ptrdiff_t>(front.remaining) * front.remaining;
}

/// Doubles in waiting update matrices at the worst moment.
std::size_t UpdateStackSize(const std::vector<Front>& fronts) {
  std::ptrdiff_t top = 0, peak = 0;
  for (const Front& front : fronts) {
    peak = std::max(peak, top + UpdateSize(front));
    for (const int child : front.children) {
      top -= UpdateSize(fronts[At(child)]);
    }
    top += UpdateSize(front);
  }
  return static_cast<std::size_t>(peak);
}

void ZeroLower(int n, double* a) {
  for (int c = 0; c < n; ++c) {
    std::fill_n(a + At(c) * At(n) + c, n - c, 0.0);
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
  CHECK(matrix.pattern() == impl.pattern || *matrix.pattern() == *impl.pattern)
      << "the matrix has another pattern than the one analysed";
  const sparse::Symbolic& symbolic = impl.symbolic;
  impl.factored = false;
  if (!impl.factor) {
    impl.factor = std::make_unique_for_overwrite<double[]>(symbolic.factor_entries);
  }
  Outcome outcome;
  outcome.smallest_pivot_ratio = 1.0;
  // Update matrices wait for their parents on a stack: in postorder the children's are on its top.
  const auto stack = std::make_unique_for_overwrite<double[]>(UpdateStackSize(symbolic.fronts));
  double* top = stack.get();
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
    double* update = top;
    ZeroLower(front.remaining, update);
    double* bottom = top;
    for (const int child : front.children) {
      bottom -= UpdateSize(symbolic.fronts[At(child)]);
    }
    const double* child_update = bottom;
    for (const int child : front.children) {
      ExtendAdd(symbolic.fronts[At(child)], child_update, front, panel, update);
      child_update += UpdateSize(symbolic.fronts[At(child)]);
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
    dense::SubtractSquare(front.remaining, n, panel + n, height, update, front.remaining);
    if (bottom != update) {  // over the children's
      std::copy(update, update + UpdateSize(front), bottom);
    }
    top = bottom + UpdateSize(front);
  }
  impl.factored = true;
  outcome.positive_definite = true;
  return outcome;
}

std::size_t BlockCholesky::factor_entries() const { return impl_->symbolic.factor_entries; }

}  // namespace sarblock
