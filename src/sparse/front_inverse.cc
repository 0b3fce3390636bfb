// SPDX-License-Identifier: Apache-2.0
#include "front_inverse.h"

#include <algorithm>
#include <atomic>
#include <utility>
#include <vector>

#include "core/ranks.h"
#include "front_moves.h"
#include "front_schedule.h"
#include "tiled_kernels.h"
#include "workspace.h"

namespace sarblock::sparse {
namespace {

/// Lower triangle of Z_RR of a front out of the Z of its parent's front: column(c) is where row 0
/// of a column of Z_RR would stand.
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
