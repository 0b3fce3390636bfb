// SPDX-License-Identifier: Apache-2.0
#include "front_factorisation.h"

#include <algorithm>
#include <span>
#include <utility>

#include "core/ranks.h"
#include "front_moves.h"
#include "front_schedule.h"
#include "tiled_kernels.h"

namespace sarblock::sparse {
namespace {

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

/// Adds a child's update matrix to the panel and update matrix of its parent.
void ExtendAdd(const Front& child,
               const LowerTriangle& child_update,
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
      const double* source = child_update.data + child_update.Column(child.runs[q].begin + t);
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

/// Doubles of all update matrices of a rank, those that come included.
std::size_t AllUpdates(const OwnFronts& own) {
  const std::vector<Front>& fronts = own.symbolic.fronts;
  std::size_t sum = 0;
  for (std::size_t f = 0; f < fronts.size(); ++f) {
    const bool comes = own.division.Crosses(fronts[f], f) && own.Owns(At(fronts[f].parent));
    if (own.Owns(f)) sum += FrontMemory::Rounded(Square(fronts[f].remaining));
    if (comes) sum += FrontMemory::Rounded(PackedSize(fronts[f].remaining));
  }
  return sum;
}

void ZeroLower(int n, double* a) {
  for (int c = 0; c < n; ++c) {
    std::fill_n(a + At(c) * At(n) + c, n - c, 0.0);
  }
}

}  // namespace

FrontFactorisation::FrontFactorisation(const OwnFronts& own,
                                       std::span<const double> values,
                                       double* factor)
    : own_(own),
      fronts_(own.symbolic.fronts),
      values_(values),
      factor_(factor),
      memory_(AllUpdates(own)),
      updates_(fronts_.size()),
      pivots_(fronts_.size()),
      failed_front_(fronts_.size()) {}

FactorOutcome FrontFactorisation::Run() {
  Ranks* const ranks = RanksOf(own_);
  for (int stage = 0; stage < own_.division.stages; ++stage) {
    ForFronts(fronts_, own_.stages[At(stage)], Walk::kUp, [this](std::size_t f) { Work(f); });
    if (ranks == nullptr) continue;
    ShareFailure(ranks);
    if (stage + 1 < own_.division.stages) MoveUpdates(stage, ranks);
  }
  if (ranks != nullptr) SharePivots(ranks);
  FactorOutcome outcome;
  outcome.smallest_pivot_ratio = 1.0;
  const std::vector<int>& original_row = own_.symbolic.original_row;
  const auto row_of = [&](const Pivot& pivot) {
    return original_row[static_cast<std::size_t>(pivot.row)];
  };
  const std::size_t end = std::min(fronts_.size(), failed_front_ + 1);
  for (std::size_t f = 0; f < end; ++f) {  // as if one front had followed the other
    const Pivot& pivot = pivots_[f];
    if (pivot.row < 0) continue;
    if (outcome.smallest_pivot_row < 0 || pivot.ratio < outcome.smallest_pivot_ratio) {
      outcome.smallest_pivot_ratio = pivot.ratio;
      outcome.smallest_pivot_row = row_of(pivot);
    }
  }
  outcome.positive_definite = failed_front_ == fronts_.size();
  if (!outcome.positive_definite) outcome.failed_row = row_of(pivots_[failed_front_]);
  return outcome;
}

LowerTriangle FrontFactorisation::Update(std::size_t f) const {
  return {updates_[f].get(), fronts_[f].remaining, !own_.Owns(f)};
}

void FrontFactorisation::Work(std::size_t f) {
  // Fronts before the failed one go on: a failure among them is the one to report.
  if (f > failed_front_) return;
  const Front& front = fronts_[f];
  const int height = front.height(), n = front.eliminated;
  double* panel = factor_ + own_.panel[f];
  std::fill_n(panel, At(height) * At(n), 0.0);
  Assemble(front, values_, panel);
  std::vector<double> diagonal(At(n));
  for (std::size_t k = 0; k < At(n); ++k) diagonal[k] = panel[k * (At(height) + 1)];
  FrontMemory::Place update = memory_.Take(Square(front.remaining));
  ZeroLower(front.remaining, update.get());
  for (const int child : front.children) {
    ExtendAdd(fronts_[At(child)], Update(At(child)), front, panel, update.get());
    updates_[At(child)].reset();
  }
  const int failed = dense::FactorPanel(height, n, panel, height);
  RecordPivots(f, diagonal, panel, failed);
  if (failed > 0) return;
  dense::SubtractSquareTiled(front.remaining, n, panel + n, height, update.get(), front.remaining);
  if (front.parent >= 0) updates_[f] = std::move(update);
}

void FrontFactorisation::RecordPivots(std::size_t f,
                                      const std::vector<double>& diagonal,
                                      const double* panel,
                                      int failed) {
  const Front& front = fronts_[f];
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

void FrontFactorisation::ShareFailure(Ranks* ranks) {
  std::vector<std::uint64_t> failed(At(own_.division.ranks), failed_front_);
  std::vector<RankPart> parts;
  for (std::size_t r = 0; r < failed.size(); ++r) {
    AddPart(std::as_writable_bytes(std::span(&failed[r], 1)), static_cast<int>(r), &parts);
  }
  ranks->Share(parts);
  failed_front_ = *std::min_element(failed.begin(), failed.end());
}

void FrontFactorisation::MoveUpdates(int stage, Ranks* ranks) {
  std::vector<std::size_t> moved;
  std::vector<RankPart> parts;
  FrontMoves moves(own_, &parts);
  for (std::size_t f = 0; f < fronts_.size(); ++f) {
    if (own_.division.stage[f] != stage || !own_.division.Crosses(fronts_[f], f)) continue;
    const std::size_t parent = At(fronts_[f].parent);
    if (parent > failed_front_) continue;  // nobody works on it any more
    const int rows = fronts_[f].remaining;
    if (own_.Owns(parent)) updates_[f] = memory_.Take(PackedSize(rows));
    double* const place = updates_[f].get();
    moves.AddTriangle(place, place, rows, own_.division.owner[f], own_.division.owner[parent]);
    if (own_.Owns(f)) moved.push_back(f);
  }
  ranks->Share(parts);
  for (const std::size_t f : moved) updates_[f].reset();
}

void FrontFactorisation::SharePivots(Ranks* ranks) {
  std::vector<RankPart> parts;
  for (std::size_t f = 0; f < pivots_.size(); ++f) {
    AddPart(std::as_writable_bytes(std::span(&pivots_[f], 1)), own_.division.owner[f], &parts);
  }
  ranks->Share(parts);
}

}  // namespace sarblock::sparse
