// SPDX-License-Identifier: Apache-2.0
#include "block_cholesky.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "dense_kernels.h"
#include "front_schedule.h"
#include "symbolic.h"
#include "tiled_kernels.h"
#include "workspace.h"
#include <glog/logging.h>

namespace sarblock {
namespace {

using Eigen::MatrixXd;
using sparse::At;
using sparse::Entry;
using sparse::Front;
using sparse::FrontMemory;
using sparse::Run;
using sparse::Symbolic;

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
  [[nodiscard]] std::size_t most_waiting() const { return memory_.most_taken(); }

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

/// Lower triangle of Z_RR of a front out of the Z of its parent's front.
void Gather(const Front& front, const double* parent, int parent_height, double* z) {
  const std::size_t ld = At(front.height());
  for (std::size_t q = 0; q < front.runs.size(); ++q) {
    for (int t = 0; t < front.runs[q].length; ++t) {
      const double* source = parent + At(front.runs[q].parent_begin + t) * At(parent_height);
      double* target = z + At(front.eliminated + front.runs[q].begin + t) * ld + front.eliminated;
      for (std::size_t p = q; p < front.runs.size(); ++p) {
        const Run& run = front.runs[p];
        const int skip = p == q ? t : 0;  // above the diagonal
        std::copy(source + run.parent_begin + skip,
                  source + run.parent_begin + run.length,
                  target + run.begin + skip);
      }
    }
  }
}

/// The blocks of the pattern out of the front that eliminates the earlier block.
void Scatter(const Front& front, const double* z, std::span<double> values) {
  const std::size_t ld = At(front.height());
  for (const Entry& entry : front.entries) {
    double* value = values.data() + entry.value;
    for (int c = 0; c < entry.width; ++c) {
      for (int r = 0; r < entry.height; ++r) {
        // A diagonal block is read from its lower triangle.
        const int row = std::max(entry.row + r, entry.column + c);
        const int column = std::min(entry.row + r, entry.column + c);
        value[entry.transposed ? At(r) * At(entry.width) + At(c)
                               : At(c) * At(entry.height) + At(r)] = z[At(column) * ld + At(row)];
      }
    }
  }
}

std::size_t FrontSize(const Front& front) { return At(front.height()) * At(front.height()); }

}  // namespace

struct BlockCholesky::Impl {
  std::shared_ptr<const BlockPattern> pattern;
  sparse::Symbolic symbolic;
  std::unique_ptr<sparse::FrontMemory> factor_memory;
  sparse::FrontMemory::Place factor;  ///< the fronts' panels, column-major, lower part valid
  bool factored = false;
  FactorNeeds used;

  [[nodiscard]] const double* Panel(const sparse::Front& front) const {
    return factor.get() + front.panel;
  }
  /// CHECKs that the last Factorize succeeded.
  void RequireFactor() const;
};

void BlockCholesky::Impl::RequireFactor() const {
  CHECK(factored) << "the matrix has not been factored";
}

BlockCholesky::BlockCholesky(std::shared_ptr<const BlockPattern> pattern, std::span<const int> last)
    : impl_(std::make_unique<Impl>()) {
  dense::UseOneBlasThread();
  impl_->pattern = std::move(pattern);
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
    impl.factor_memory =
        std::make_unique<FrontMemory>(FrontMemory::Rounded(symbolic.factor_entries));
    impl.factor = impl.factor_memory->Take(symbolic.factor_entries);
  }
  FrontFactorisation factorisation(symbolic, matrix.values(), impl.factor.get());
  const Outcome outcome = factorisation.Run();
  impl.used.factor = symbolic.factor_entries;
  impl.used.waiting = std::max(impl.used.waiting, factorisation.most_waiting());
  impl.factored = outcome.positive_definite;
  return outcome;
}

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

BlockSymmetricMatrix BlockCholesky::SelectedInverse() const {
  impl_->RequireFactor();
  const std::vector<Front>& fronts = impl_->symbolic.fronts;
  BlockSymmetricMatrix inverse(impl_->pattern);
  std::size_t all = 0;
  for (const Front& front : fronts) all += FrontMemory::Rounded(FrontSize(front));
  FrontMemory memory(all);
  // Z of the fronts whose children have not all read it yet: the ancestors of those at work.
  std::vector<FrontMemory::Place> waiting(fronts.size());
  std::vector<std::atomic<std::size_t>> unread(fronts.size());
  for (std::size_t f = 0; f < fronts.size(); ++f) unread[f] = fronts[f].children.size();
  sparse::ForFronts(fronts, sparse::Walk::kDown, [&](std::size_t f) {
    const Front& front = fronts[f];
    FrontMemory::Place z = memory.Take(FrontSize(front));
    if (front.parent >= 0) {
      const std::size_t parent = At(front.parent);
      Gather(front, waiting[parent].get(), fronts[parent].height(), z.get());
      if (--unread[parent] == 0) waiting[parent].reset();
    }
    dense::InvertPanel(front.height(), front.eliminated, impl_->Panel(front), z.get());
    Scatter(front, z.get(), inverse.values());
    if (!front.children.empty()) waiting[f] = std::move(z);
  });
  impl_->used.inverse_fronts = std::max(impl_->used.inverse_fronts, memory.most_taken());
  return inverse;
}

std::size_t BlockCholesky::factor_entries() const { return impl_->symbolic.factor_entries; }

FactorNeeds BlockCholesky::Needs() const {
  const Symbolic& symbolic = impl_->symbolic;
  const std::vector<Front>& fronts = symbolic.fronts;
  FactorNeeds needs;
  needs.factor = symbolic.factor_entries;
  needs.operations = 0.5 * symbolic.operations;
  needs.dissected = symbolic.dissected;
  std::size_t held = 0;
  for (const Front& front : fronts) {  // as FrontFactorisation::Work takes and gives back
    held += FrontMemory::Rounded(UpdateSize(front));
    needs.waiting = std::max(needs.waiting, held);
    for (const int child : front.children) {
      held -= FrontMemory::Rounded(UpdateSize(fronts[At(child)]));
    }
    if (front.parent < 0) held -= FrontMemory::Rounded(UpdateSize(front));
  }
  std::vector<std::size_t> unread(fronts.size());
  for (std::size_t f = 0; f < fronts.size(); ++f) unread[f] = fronts[f].children.size();
  held = 0;
  for (std::size_t f = fronts.size(); f-- > 0;) {  // as SelectedInverse does
    held += FrontMemory::Rounded(FrontSize(fronts[f]));
    needs.inverse_fronts = std::max(needs.inverse_fronts, held);
    if (fronts[f].parent >= 0) {
      const std::size_t parent = At(fronts[f].parent);
      if (--unread[parent] == 0) held -= FrontMemory::Rounded(FrontSize(fronts[parent]));
    }
    if (fronts[f].children.empty()) held -= FrontMemory::Rounded(FrontSize(fronts[f]));
  }
  return needs;
}

FactorNeeds BlockCholesky::Used() const { return impl_->used; }

}  // namespace sarblock
