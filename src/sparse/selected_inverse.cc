// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "block_cholesky.h"
#include "block_cholesky_impl.h"
#include "front_schedule.h"
#include "tiled_kernels.h"

namespace sarblock {
namespace {

using sparse::At;
using sparse::Entry;
using sparse::Front;
using sparse::FrontMemory;
using sparse::Run;

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
  return inverse;
}

}  // namespace sarblock
