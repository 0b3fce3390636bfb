// SPDX-License-Identifier: Apache-2.0
#include "front_solve.h"

#include <algorithm>
#include <span>
#include <vector>

#include "core/ranks.h"
#include "dense_kernels.h"
#include "front_moves.h"

namespace sarblock::sparse {
namespace {

using Eigen::MatrixXd;

int RowCount(const MatrixXd& x) { return static_cast<int>(x.rows()); }
int ColumnCount(const MatrixXd& x) { return static_cast<int>(x.cols()); }

/// Calls visit(row of R, row of the parent's front, rows) for the rows of R of a front that its
/// parent eliminates, or for the others.
enum class Part { kEliminated, kRemaining };
template <typename Visit>
void ForRuns(const Front& front, const Front& parent, Part part, const Visit& visit) {
  for (const Run& run : front.runs) {
    const int split = std::clamp(parent.eliminated - run.parent_begin, 0, run.length);
    const int begin = part == Part::kEliminated ? 0 : split;
    const int end = part == Part::kEliminated ? split : run.length;
    if (begin < end) visit(run.begin + begin, run.parent_begin + begin, end - begin);
  }
}

/// x = L^-1 x. What a front subtracts from rows further up is summed along the tree, so that only
/// sums cross from rank to rank.
class Forward {
 public:
  Forward(const OwnFronts& own, const double* factor, MatrixXd* x)
      : own_(own), fronts_(own.symbolic.fronts), factor_(factor), x_(*x), sums_(fronts_.size()) {}

  void Run(Ranks* ranks) {
    for (int stage = 0; stage < own_.division.stages; ++stage) {
      for (const std::size_t f : own_.stages[At(stage)]) Work(f);
      if (ranks != nullptr && stage + 1 < own_.division.stages) MoveUp(stage, ranks);
    }
  }

 private:
  void Work(std::size_t f) {
    const Front& front = fronts_[f];
    const int n = front.eliminated;
    for (const int child : front.children) {
      ForRuns(fronts_[At(child)], front, Part::kEliminated, [&](int row, int to, int rows) {
        x_.middleRows(front.first_row + to, rows) -= sums_[At(child)].middleRows(row, rows);
      });
    }
    const double* const panel = factor_ + own_.panel[f];
    double* const top = x_.data() + front.first_row;
    dense::SolveLeft(n, ColumnCount(x_), panel, front.height(), top, RowCount(x_));
    MatrixXd& sum = sums_[f];
    if (n == 0) {
      sum.setZero(front.remaining, x_.cols());
    } else if (front.remaining > 0) {
      sum.resize(front.remaining, x_.cols());
      dense::Product(front.remaining,
                     ColumnCount(x_),
                     n,
                     panel + n,
                     front.height(),
                     top,
                     RowCount(x_),
                     sum.data(),
                     front.remaining);
    }
    for (const int child : front.children) {
      ForRuns(fronts_[At(child)], front, Part::kRemaining, [&](int row, int to, int rows) {
        sum.middleRows(to - n, rows) += sums_[At(child)].middleRows(row, rows);
      });
      sums_[At(child)].resize(0, 0);
    }
  }

  void MoveUp(int stage, Ranks* ranks) {
    std::vector<RankPart> parts;
    FrontMoves moves(own_, &parts);
    for (std::size_t f = 0; f < fronts_.size(); ++f) {
      if (own_.division.stage[f] != stage || !own_.division.Crosses(fronts_[f], f)) continue;
      const std::size_t parent = At(fronts_[f].parent);
      if (own_.Owns(parent)) sums_[f].resize(fronts_[f].remaining, x_.cols());
      const std::size_t count = At(fronts_[f].remaining) * At(ColumnCount(x_));
      moves.Add(sums_[f].data(), count, own_.division.owner[f], own_.division.owner[parent]);
    }
    ranks->Share(parts);
    for (std::size_t f = 0; f < fronts_.size(); ++f) {
      const bool gone = own_.division.stage[f] == stage && own_.division.Crosses(fronts_[f], f);
      if (gone && own_.Owns(f)) sums_[f].resize(0, 0);
    }
  }

  const OwnFronts& own_;
  const std::vector<Front>& fronts_;
  const double* factor_;
  MatrixXd& x_;
  std::vector<MatrixXd> sums_;  // by front, over R, until the parent has taken it
};

/// x_J of one front of x = L'^-1 x, all rows of R being there.
void WorkBackward(const Symbolic& symbolic,
                  const Front& front,
                  const double* panel,
                  MatrixXd* remaining,
                  MatrixXd& x) {
  const int n = front.eliminated, height = front.height();
  double* const top = x.data() + front.first_row;
  if (front.remaining > 0) {
    remaining->resize(front.remaining, x.cols());
    int row = 0;
    for (const int block : front.rows) {
      const int begin = symbolic.row_begin[At(block)];
      const int size = symbolic.row_begin[At(block) + 1] - begin;
      remaining->middleRows(row, size) = x.middleRows(begin, size);
      row += size;
    }
    dense::SubtractTransposedProduct(n,
                                     ColumnCount(x),
                                     front.remaining,
                                     panel + n,
                                     height,
                                     remaining->data(),
                                     front.remaining,
                                     top,
                                     RowCount(x));
  }
  dense::SolveLeftTransposed(n, ColumnCount(x), panel, height, top, RowCount(x));
}

/// The rows that a stage eliminates, from the ranks that have them to all.
void ShareRows(const OwnFronts& own, int stage, Ranks* ranks, MatrixXd* x) {
  std::vector<RankPart> parts;
  for (Eigen::Index column = 0; column < x->cols(); ++column) {
    for (std::size_t f = 0; f < own.symbolic.fronts.size(); ++f) {
      if (own.division.stage[f] != stage) continue;
      const Front& front = own.symbolic.fronts[f];
      const std::span<double> rows(x->col(column).data() + front.first_row, At(front.eliminated));
      AddPart(std::as_writable_bytes(rows), own.division.owner[f], &parts);
    }
  }
  ranks->Share(parts);
}

}  // namespace

void SolveFronts(const OwnFronts& own, const double* factor, MatrixXd* x) {
  Ranks* const ranks = RanksOf(own);
  Forward(own, factor, x).Run(ranks);
  MatrixXd remaining;
  for (int stage = own.division.stages; stage-- > 0;) {
    const std::vector<std::size_t>& fronts = own.stages[At(stage)];
    for (auto f = fronts.rbegin(); f != fronts.rend(); ++f) {
      WorkBackward(own.symbolic, own.symbolic.fronts[*f], factor + own.panel[*f], &remaining, *x);
    }
    if (ranks != nullptr) ShareRows(own, stage, ranks, x);
  }
}

}  // namespace sarblock::sparse
