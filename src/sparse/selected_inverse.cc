// SPDX-License-Identifier: Apache-2.0
#include "sarblock/sparse/block_cholesky.h"

#include <algorithm>
#include <memory>
#include <vector>

#include "block_cholesky_impl.h"
#include "dense_kernels.h"

namespace sarblock {
namespace {

using sparse::Entry;
using sparse::Front;
using sparse::Run;

std::size_t At(int index) { return static_cast<std::size_t>(index); }

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

/// Z_RJ and the lower triangle of Z_JJ of a front whose Z_RR is in place. `scaled` is workspace.
void Recur(const Front& front, const double* panel, std::vector<double>& scaled, double* z) {
  const int height = front.height(), n = front.eliminated, r = front.remaining;
  const std::size_t ld = At(height);
  scaled.resize(At(r) * At(n));
  for (int c = 0; c < n; ++c) {
    std::copy(panel + At(c) * ld + n, panel + At(c) * ld + height, scaled.data() + At(c) * At(r));
    std::copy(panel + At(c) * ld + c, panel + At(c) * ld + n, z + At(c) * ld + c);
  }
  dense::InvertFromFactor(n, z, height);
  if (r == 0) {
    return;
  }
  dense::SolveRight(r, n, panel, height, scaled.data(), r);
  dense::NegativeSymmetricProduct(
      r, n, z + At(n) * ld + n, height, scaled.data(), r, z + n, height);
  // By strips of columns from the diagonal down: half the work of the whole square.
  constexpr int kStrip = 96;
  for (int c = 0; c < n; c += kStrip) {
    dense::SubtractTransposedProduct(n - c,
                                     std::min(kStrip, n - c),
                                     r,
                                     scaled.data() + At(c) * At(r),
                                     r,
                                     z + At(c) * ld + n,
                                     height,
                                     z + At(c) * ld + c,
                                     height);
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

std::ptrdiff_t FrontSize(const Front& front) {
  return static_cast<std::ptrdiff_t>(front.height()) * front.height();
}

/// Doubles in the Z of fronts at the worst moment of the walk from the last front to the first.
std::size_t StackSize(const std::vector<Front>& fronts) {
  std::vector<std::size_t> waiting(fronts.size());
  std::ptrdiff_t top = 0, peak = 0;
  for (std::size_t f = fronts.size(); f-- > 0;) {
    waiting[f] = fronts[f].children.size();
    top += FrontSize(fronts[f]);
    peak = std::max(peak, top);
    if (fronts[f].parent >= 0 && --waiting[At(fronts[f].parent)] == 0) {
      top -= FrontSize(fronts[At(fronts[f].parent)]);
    }
    if (waiting[f] == 0) {
      top -= FrontSize(fronts[f]);
    }
  }
  return static_cast<std::size_t>(peak);
}

}  // namespace

BlockSymmetricMatrix BlockCholesky::SelectedInverse() const {
  impl_->RequireFactor();
  const std::vector<Front>& fronts = impl_->symbolic.fronts;
  BlockSymmetricMatrix inverse(impl_->pattern);
  std::vector<std::size_t> waiting(fronts.size());  // children still to read a front's Z
  std::vector<double> scaled;
  // The fronts whose children are not done are the ancestors of the present one: a stack.
  const auto stack = std::make_unique_for_overwrite<double[]>(StackSize(fronts));
  double* top = stack.get();
  for (std::size_t f = fronts.size(); f-- > 0;) {
    const Front& front = fronts[f];
    waiting[f] = front.children.size();
    double* z = top;
    if (front.parent >= 0) {
      const Front& parent = fronts[At(front.parent)];
      double* parent_z = top - FrontSize(parent);
      Gather(front, parent_z, parent.height(), z);
      if (--waiting[At(front.parent)] == 0) {  // the parent's place is free
        const std::ptrdiff_t eliminated_columns =
            static_cast<std::ptrdiff_t>(front.eliminated) * front.height();
        std::copy(z + eliminated_columns, z + FrontSize(front), parent_z + eliminated_columns);
        z = parent_z;
      }
    }
    Recur(front, impl_->Panel(front), scaled, z);
    Scatter(front, z, inverse.values());
    top = waiting[f] == 0 ? z : z + FrontSize(front);
  }
  return inverse;
}

}  // namespace sarblock
