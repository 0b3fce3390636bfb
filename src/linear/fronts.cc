// SPDX-License-Identifier: Apache-2.0
#include "fronts.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <queue>
#include <span>
#include <utility>
#include <vector>

#include "core/ranks.h"
#include "dense.h"
#include "front_ranks.h"
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>

namespace sarblock::sparse {
namespace {

/// Fronts that may be worked on, the first in the wanted order on top.
class ReadyFronts {
 public:
  explicit ReadyFronts(Walk walk) : walk_(walk) {}
  void Push(std::size_t front) {
    const std::lock_guard lock(mutex_);
    queue_.push(Key(front));
  }
  [[nodiscard]] std::size_t Pop() {
    const std::lock_guard lock(mutex_);
    const std::size_t key = queue_.top();
    queue_.pop();
    return Key(key);
  }

 private:
  /// The queue keeps its largest element on top; the key is its own inverse.
  [[nodiscard]] std::size_t Key(std::size_t front) const {
    return walk_ == Walk::kUp ? ~front : front;
  }
  Walk walk_;
  std::mutex mutex_;
  std::priority_queue<std::size_t> queue_;
};

}  // namespace

void ForFronts(const std::vector<Front>& fronts,
               const std::vector<std::size_t>& some,
               Walk walk,
               const std::function<void(std::size_t)>& work) {
  constexpr std::size_t kNotHere = static_cast<std::size_t>(-1);
  std::vector<std::atomic<std::size_t>> waits_for(fronts.size());
  for (auto& waits : waits_for) waits = kNotHere;
  for (const std::size_t f : some) waits_for[f] = 0;
  for (const std::size_t f : some) {
    if (fronts[f].parent < 0) continue;
    const auto parent = static_cast<std::size_t>(fronts[f].parent);
    if (waits_for[parent] != kNotHere) ++waits_for[walk == Walk::kUp ? parent : f];
  }
  ReadyFronts ready(walk);
  std::size_t first = 0;
  for (const std::size_t f : some) {
    if (waits_for[f] > 0) continue;
    ready.Push(f);
    ++first;
  }
  tbb::task_group group;
  // One task a ready front; which front it takes is decided when it runs.
  std::function<void()> run;
  const auto done = [&](std::size_t front) {
    if (waits_for[front] != kNotHere && --waits_for[front] == 0) {
      ready.Push(front);
      group.run(run);
    }
  };
  run = [&] {
    const std::size_t f = ready.Pop();
    work(f);
    if (walk == Walk::kDown) {
      for (const int child : fronts[f].children) done(static_cast<std::size_t>(child));
    } else if (fronts[f].parent >= 0) {
      done(static_cast<std::size_t>(fronts[f].parent));
    }
  };
  for (std::size_t i = 0; i < first; ++i) group.run(run);
  group.wait();
}

void ForPieces(std::size_t count, const std::function<void(std::size_t)>& work) {
  if (count <= 1) {
    if (count == 1) work(0);
    return;
  }
  tbb::this_task_arena::isolate([&] { tbb::parallel_for(std::size_t{0}, count, work); });
}

}  // namespace sarblock::sparse

namespace sarblock::dense {
namespace {

constexpr int kTileRows = 384;
constexpr int kTileColumns = 256;
/// Strips of a triangular result, so that little is computed above its diagonal.
constexpr int kStrip = 96;

std::size_t At(int row, int column, int ld) {
  return static_cast<std::size_t>(column) * static_cast<std::size_t>(ld) +
         static_cast<std::size_t>(row);
}

std::size_t Pieces(int count, int size) {
  return static_cast<std::size_t>((count + size - 1) / size);
}

/// Calls work(first, length) for pieces of [0, count).
template <typename Work>
void ForRanges(int count, int size, const Work& work) {
  sparse::ForPieces(Pieces(count, size), [&](std::size_t piece) {
    const int first = static_cast<int>(piece) * size;
    work(first, std::min(size, count - first));
  });
}

struct Tile {
  int row, column, height, width;
};

/// Lower trapezoid of c -= a a(0 : columns)', a rows x k, c rows x columns.
void SubtractTrapezoid(int rows, int columns, int k, const double* a, int lda, double* c, int ldc) {
  std::vector<Tile> tiles;
  for (int column = 0; column < columns; column += kTileColumns) {
    const int width = std::min(kTileColumns, columns - column);
    tiles.push_back({column, column, width, width});
    for (int row = column + width; row < rows; row += kTileRows) {
      tiles.push_back({row, column, std::min(kTileRows, rows - row), width});
    }
  }
  sparse::ForPieces(tiles.size(), [&](std::size_t i) {
    const Tile& t = tiles[i];
    double* target = c + At(t.row, t.column, ldc);
    if (t.row == t.column) {
      SubtractSquare(t.width, k, a + t.row, lda, target, ldc);
    } else {
      SubtractProductTransposed(
          t.height, t.width, k, a + t.row, lda, a + t.column, lda, target, ldc);
    }
  });
}

/// c = -s b, s symmetric m x m by its lower triangle, b and c m x n.
void NegativeSymmetricTiled(
    int m, int n, const double* s, int lds, const double* b, int ldb, double* c, int ldc) {
  ForRanges(m, kTileRows, [&](int row, int height) {
    const int below = row + height;
    NegativeSymmetricProduct(height, n, s + At(row, row, lds), lds, b + row, ldb, c + row, ldc);
    SubtractProduct(height, n, row, s + row, lds, b, ldb, c + row, ldc);
    SubtractTransposedProduct(
        height, n, m - below, s + At(below, row, lds), lds, b + below, ldb, c + row, ldc);
  });
}

/// InvertPanel for one block of columns. `scaled` is workspace of (height - n) n doubles.
void InvertBlock(
    int height, int n, const double* panel, int ld_panel, double* scaled, double* z, int ldz) {
  const int r = height - n;
  for (int c = 0; c < n; ++c) {
    const double* column = panel + At(0, c, ld_panel);
    std::copy(column + n, column + height, scaled + At(0, c, r));
    std::copy(column + c, column + n, z + At(c, c, ldz));
  }
  InvertFromFactor(n, z, ldz);
  if (r == 0) return;
  ForRanges(r, kTileRows, [&](int row, int rows) {
    SolveRight(rows, n, panel, ld_panel, scaled + row, r);
  });
  NegativeSymmetricTiled(r, n, z + At(n, n, ldz), ldz, scaled, r, z + n, ldz);
  ForRanges(n, kStrip, [&](int c, int width) {
    SubtractTransposedProduct(
        n - c, width, r, scaled + At(0, c, r), r, z + At(n, c, ldz), ldz, z + At(c, c, ldz), ldz);
  });
}

}  // namespace

int FactorPanel(int height, int columns, double* a, int lda) {
  for (int first = 0; first < columns; first += kBlockColumns) {
    const int width = std::min(kBlockColumns, columns - first);
    const int next = first + width;
    double* block = a + At(first, first, lda);
    const int failed = Factor(width, block, lda);
    if (failed > 0) return first + failed;
    ForRanges(height - next, kTileRows, [&](int row, int rows) {
      SolveRightTransposed(rows, width, block, lda, block + width + row, lda);
    });
    SubtractTrapezoid(
        height - next, columns - next, width, block + width, lda, a + At(next, next, lda), lda);
  }
  return 0;
}

void SubtractSquareTiled(int n, int k, const double* a, int lda, double* c, int ldc) {
  SubtractTrapezoid(n, n, k, a, lda, c, ldc);
}

void InvertPanel(int height, int columns, const double* panel, double* z) {
  const int last = (columns - 1) / kBlockColumns * kBlockColumns;
  const auto scaled = std::make_unique_for_overwrite<double[]>(
      static_cast<std::size_t>(height) *
      static_cast<std::size_t>(std::min(columns, kBlockColumns)));
  for (int first = last; first >= 0; first -= kBlockColumns) {
    InvertBlock(height - first,
                std::min(kBlockColumns, columns - first),
                panel + At(first, first, height),
                height,
                scaled.get(),
                z + At(first, first, height),
                height);
  }
}

}  // namespace sarblock::dense

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

namespace {

/// Lower triangle of Z_RR of a front out of the Z of its parent's front: column(c) is where row 0
/// of a column of Z_RR would be.
template <typename Column>
void Gather(const Front& front, const double* parent, int parent_height, const Column& column) {
  for (std::size_t q = 0; q < front.runs.size(); ++q) {
    for (int t = 0; t < front.runs[q].length; ++t) {
      const double* source = parent + At(front.runs[q].parent_begin + t) * At(parent_height);
      double* target = column(front.runs[q].begin + t);
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

class FrontInversion {
 public:
  FrontInversion(const OwnFronts& own, const double* factor, std::span<double> values)
      : own_(own),
        fronts_(own.symbolic.fronts),
        factor_(factor),
        values_(values),
        memory_(AllFronts(own)),
        waiting_(fronts_.size()),
        crossing_(fronts_.size()),
        unread_(fronts_.size()) {
    for (std::size_t f = 0; f < fronts_.size(); ++f) {
      unread_[f] = static_cast<std::size_t>(
          std::count_if(fronts_[f].children.begin(), fronts_[f].children.end(), [&](int child) {
            return !Crosses(At(child));
          }));
    }
  }

  void Run() {
    Ranks* const ranks = RanksOf(own_);
    for (int stage = own_.division.stages; stage-- > 0;) {
      ForFronts(fronts_, own_.stages[At(stage)], Walk::kDown, [this](std::size_t f) { Work(f); });
      if (ranks != nullptr && stage > 0) MoveDown(stage, ranks);
    }
    if (ranks != nullptr) ShareBlocks(ranks);
  }
  [[nodiscard]] std::size_t most_taken() const { return memory_.most_taken(); }

 private:
  [[nodiscard]] bool Crosses(std::size_t f) const { return own_.division.Crosses(fronts_[f], f); }

  /// Doubles of the own fronts, and of all Z_RR that come or go.
  static std::size_t AllFronts(const OwnFronts& own) {
    const std::vector<Front>& fronts = own.symbolic.fronts;
    std::size_t sum = 0;
    for (std::size_t f = 0; f < fronts.size(); ++f) {
      if (own.Owns(f)) sum += FrontMemory::Rounded(Square(fronts[f].height()));
      if (own.division.Crosses(fronts[f], f)) {
        sum += FrontMemory::Rounded(PackedSize(fronts[f].remaining));
      }
    }
    return sum;
  }

  void Work(std::size_t f) {
    const Front& front = fronts_[f];
    const std::size_t height = At(front.height());
    FrontMemory::Place z = memory_.Take(Square(front.height()));
    double* const of_rest = z.get() + At(front.eliminated) * (height + 1);
    if (Crosses(f)) {
      const LowerTriangle came{crossing_[f].get(), front.remaining, true};
      for (int c = 0; c < front.remaining; ++c) {
        const double* const source = came.data + came.Column(c);
        std::copy(source + c, source + front.remaining, of_rest + At(c) * height + c);
      }
      crossing_[f].reset();
    } else if (front.parent >= 0) {
      const std::size_t parent = At(front.parent);
      Gather(front, waiting_[parent].get(), fronts_[parent].height(), [&](int c) {
        return of_rest + At(c) * height;
      });
      if (--unread_[parent] == 0) waiting_[parent].reset();
    }
    dense::InvertPanel(front.height(), front.eliminated, factor_ + own_.panel[f], z.get());
    Scatter(front, z.get(), values_);
    for (const int child : front.children) {
      const std::size_t c = At(child);
      if (!Crosses(c)) continue;
      const int rows = fronts_[c].remaining;
      crossing_[c] = memory_.Take(PackedSize(rows));
      double* const packed = crossing_[c].get();
      Gather(fronts_[c], z.get(), front.height(), [&](int column) {
        return packed + LowerTriangle{packed, rows, true}.Column(column);
      });
    }
    if (unread_[f] > 0) waiting_[f] = std::move(z);
  }

  /// Z_RR of the children of a stage's fronts on other ranks goes there.
  void MoveDown(int stage, Ranks* ranks) {
    std::vector<std::size_t> moved;
    std::vector<RankPart> parts;
    FrontMoves moves(own_, &parts);
    for (std::size_t f = 0; f < fronts_.size(); ++f) {
      if (!Crosses(f)) continue;
      const std::size_t parent = At(fronts_[f].parent);
      if (own_.division.stage[parent] != stage) continue;
      const std::size_t size = PackedSize(fronts_[f].remaining);
      if (own_.Owns(f)) crossing_[f] = memory_.Take(size);
      moves.Add(crossing_[f].get(), size, own_.division.owner[parent], own_.division.owner[f]);
      if (own_.Owns(parent)) moved.push_back(f);
    }
    ranks->Share(parts);
    for (const std::size_t f : moved) crossing_[f].reset();
  }

  void ShareBlocks(Ranks* ranks) {
    struct Piece {
      std::size_t begin, count;
      int rank;
    };
    std::vector<Piece> pieces;
    for (std::size_t f = 0; f < fronts_.size(); ++f) {
      for (const Entry& entry : fronts_[f].entries) {
        pieces.push_back({entry.value, At(entry.height) * At(entry.width), own_.division.owner[f]});
      }
    }
    std::sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) {
      return a.begin != b.begin ? a.begin < b.begin : a.count < b.count;
    });
    std::vector<RankPart> parts;
    for (const Piece& piece : pieces) {
      AddPart(
          std::as_writable_bytes(values_.subspan(piece.begin, piece.count)), piece.rank, &parts);
    }
    ranks->Share(parts);
  }

  const OwnFronts& own_;
  const std::vector<Front>& fronts_;
  const double* factor_;
  std::span<double> values_;
  FrontMemory memory_;
  // Z of fronts whose children here have not all read it yet: ancestors of those at work.
  std::vector<FrontMemory::Place> waiting_;
  std::vector<FrontMemory::Place> crossing_;  // Z_RR, packed, of fronts whose parent is elsewhere
  std::vector<std::atomic<std::size_t>> unread_;
};

}  // namespace

std::size_t InvertFronts(const OwnFronts& own, const double* factor, std::span<double> values) {
  FrontInversion inversion(own, factor, values);
  inversion.Run();
  return inversion.most_taken();
}

}  // namespace sarblock::sparse
