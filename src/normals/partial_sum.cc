// SPDX-License-Identifier: Apache-2.0
#include "partial_sum.h"

#include <algorithm>

#include "elimination.h"
#include <glog/logging.h>

namespace sarblock {
namespace {

constexpr std::uint32_t kUntouched = PieceScratch::kUntouched;

std::size_t AsSize(int i) { return static_cast<std::size_t>(i); }

}  // namespace

void PartialSum::Take(const PointPiece& piece, const BlockPattern& pattern) {
  CHECK_LT(piece.doubles(), kUntouched);
  piece_ = &piece;
  pattern_ = &pattern;
  numbers_.assign(piece.doubles(), 0.0);
}

void PartialSum::Begin(PieceScratch* scratch) {
  const PointPiece& piece = *piece_;
  const BlockPattern& pattern = *pattern_;
  if (scratch->piece == nullptr) {
    scratch->value_of_slot.assign(pattern.slot_count(), kUntouched);
    scratch->row_of_block.resize(AsSize(pattern.block_count()));
  } else {
    for (const std::uint32_t slot : scratch->piece->slots) {
      scratch->value_of_slot[slot] = kUntouched;
    }
  }
  scratch->piece = &piece;
  std::size_t value = 0;
  for (const std::uint32_t slot : piece.slots) {
    scratch->value_of_slot[slot] = static_cast<std::uint32_t>(value);
    value += pattern.ValuesOf(slot);
  }
  for (std::size_t b = 0; b < piece.blocks.size(); ++b) {
    scratch->row_of_block[AsSize(piece.blocks[b])] = static_cast<std::uint32_t>(piece.row_begin[b]);
  }
}

PointBlocks PartialSum::Blocks(const ParameterLayout& layout, PieceScratch* scratch) const {
  PointTerms& terms = scratch->terms;
  const PointBlocks blocks = FindSlots(layout, *pattern_, &terms);
  for (std::size_t& at : terms.value) {
    at = scratch->value_of_slot[at];
    CHECK_NE(at, kUntouched) << "a look takes part that did not when the points were cut";
  }
  return blocks;
}

void PartialSum::AddLooks(const ParameterLayout& layout,
                          Row gradient,
                          const PieceScratch& scratch) {
  for (int k = 0; k < scratch.factor.look_count; ++k) {
    const WhitenedLook& look = scratch.factor.looks[AsSize(k)];
    const double* range = look.row[0].data();
    const double* doppler = look.row[1].data();
    for (int b = 0; b < look.columns.block_count; ++b) {
      const int id = look.columns.block[AsSize(b)];
      const int size = layout.blocks[AsSize(id)].size;
      const std::uint32_t row = scratch.row_of_block[AsSize(id)];
      Kernels().AddLook(size,
                        range,
                        doppler,
                        look.error_1.data(),
                        Vector(Row::kDiagonal) + row,
                        Vector(gradient) + row);
      range += size;
      doppler += size;
    }
  }
}

/// J_c' J_c of each look's own blocks.
void PartialSum::AddSquaresOfLooks(const ParameterLayout& layout, const PieceScratch& scratch) {
  constexpr std::size_t kStride = ParameterLayout::kMaxLocalColumns;
  for (int k = 0; k < scratch.factor.look_count; ++k) {
    const WhitenedLook& look = scratch.factor.looks[AsSize(k)];
    int first = 0;
    for (int b = 0; b < look.columns.block_count; ++b) {
      const int id = look.columns.block[AsSize(b)];
      const int size = layout.blocks[AsSize(id)].size;
      int other = 0;
      for (int b2 = 0; b2 < look.columns.block_count; ++b2) {
        const int id2 = look.columns.block[AsSize(b2)];
        const int size2 = layout.blocks[AsSize(id2)].size;
        if (id2 <= id) {
          const std::size_t slot = id2 == id ? pattern_->FirstSlot(id) : pattern_->Slot(id, id2);
          CHECK_NE(scratch.value_of_slot[slot], kUntouched);
          Kernels().AddProducts(numbers_.data() + scratch.value_of_slot[slot],
                                size,
                                size2,
                                look.row[0].data() + first,
                                look.row[0].data() + other,
                                kStride,
                                2);
        }
        other += size2;
      }
      first += size;
    }
  }
}

/// Right side += sum_k c_k x_k over the blocks of a point, x_k rows of the width.
void PartialSum::AddRightSide(const ParameterLayout& layout,
                              const double* x,
                              std::span<const double> c,
                              const PieceScratch& scratch) {
  const PointColumns& columns = scratch.terms.columns;
  for (std::size_t j = 0; j < columns.blocks.size(); ++j) {
    const std::size_t id = AsSize(columns.blocks[j]);
    Kernels().AddCombination(layout.blocks[id].size,
                             x + columns.begin[j],
                             AsSize(columns.width),
                             static_cast<int>(c.size()),
                             c.data(),
                             Vector(Row::kRightSide) + scratch.row_of_block[id]);
  }
}

/// A point by what its elimination leaves: the square of N' J_c. No digit is lost to thin
/// intersections.
void PartialSum::AddRest(const ParameterLayout& layout, PieceScratch* scratch) {
  PointTerms& terms = scratch->terms;
  FindColumns(layout, scratch->factor, &terms.columns);
  const PointBlocks blocks = Blocks(layout, scratch);
  TurnToRest(layout, scratch->factor, &terms);
  Kernels().AddSquare(blocks,
                      terms.rest.data(),
                      AsSize(terms.columns.width),
                      static_cast<int>(terms.rest_e.size()),
                      1.0,
                      numbers_.data());
  AddRightSide(layout, terms.rest.data(), terms.rest_e, *scratch);
}

/// J_c' J_c of a point, and the right side of J_c' J_c - T' T.
void PartialSum::AddUnreduced(const AdjustmentProblem& problem,
                              const Eigen::Vector3d& c,
                              PieceScratch* scratch) {
  PointColumns& columns = scratch->terms.columns;
  ProjectColumns(problem, scratch->factor, &columns);
  AddLooks(problem.layout, Row::kSubtractedGradient, *scratch);
  AddSquaresOfLooks(problem.layout, *scratch);
  const Eigen::Vector3d taken = -c;
  AddRightSide(
      problem.layout, columns.t.data(), std::span<const double>(taken.data(), 3), *scratch);
  totals_.any_subtracted = true;
}

/// A point by J_c' J_c - T' T: three rows, however many looks. That subtraction costs digits where
/// points take most of what a correction's equations say.
void PartialSum::AddDifference(const AdjustmentProblem& problem,
                               const Eigen::Vector3d& c,
                               PieceScratch* scratch) {
  AddUnreduced(problem, c, scratch);
  const PointBlocks blocks = Blocks(problem.layout, scratch);
  const PointColumns& columns = scratch->terms.columns;
  Kernels().AddSquare(blocks, columns.t.data(), AsSize(columns.width), 3, -1.0, numbers_.data());
}

/// A point of the border by J_c' J_c and three rows T of the border.
void PartialSum::AddBordered(const PointEquations& equations,
                             const Eigen::Vector3d& c,
                             int row,
                             PieceScratch* scratch) {
  AddUnreduced(equations.problem, c, scratch);
  const PointColumns& columns = scratch->terms.columns;
  const Eigen::Map<const Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>> t(
      columns.t.data(), 3, columns.width);
  for (std::size_t b = 0; b < columns.blocks.size(); ++b) {
    const ParameterBlock& block = equations.problem.layout.blocks[AsSize(columns.blocks[b])];
    equations.border->block(row, block.offset, 3, block.size) =
        t.middleCols(columns.begin[b], block.size);
  }
}

void PartialSum::Add(const PointEquations& equations, std::size_t point, PieceScratch* scratch) {
  const AdjustmentProblem& problem = equations.problem;
  const bool damped = equations.damping_1 != 0.0;
  PointFactor& factor = scratch->factor;
  scratch->terms.columns.t.clear();
  FactorPoint(problem, equations.state, equations.weighting, equations.damping_1, point, &factor);
  totals_.cost_1 += factor.cost_1;
  totals_.not_evaluated += factor.looks_not_evaluated;
  totals_.beyond_path += factor.looks_beyond_path;
  for (Eigen::Index k = 0; k < 3; ++k) {
    if (!(factor.square_1[k] > 0.0)) continue;
    const double g = factor.gradient[k];
    totals_.gradient_square_1 = std::max(totals_.gradient_square_1, g * g / factor.square_1[k]);
  }
  if (!damped && !(factor.reciprocal_condition_1 >= kLeastPointCondition_1)) {
    AddLooks(problem.layout, Row::kExactGradient, *scratch);
    weak_.push_back({static_cast<std::uint32_t>(point), factor.reciprocal_condition_1});
    return;
  }
  const Eigen::Vector3d c = Project(factor, factor.e);
  totals_.step_square_1 += c.squaredNorm();
  const int border_row = equations.bordered.RowOf(point);
  if (border_row >= 0) {  // of hundreds of looks: it takes little of the equations of each
    AddBordered(equations, c, border_row, scratch);
    return;
  }
  // Up to three rows left are no more work than the three of T.
  if (!damped && (equations.exact || factor.row_count <= 6)) {
    AddLooks(problem.layout, Row::kExactGradient, *scratch);
    AddRest(problem.layout, scratch);
  } else {
    AddDifference(problem, c, scratch);
  }
}

void PartialSum::AddColumns(int begin, int end, const NormalSums& sums) const {
  const std::vector<int>& blocks = piece_->blocks;
  const auto first = std::lower_bound(blocks.begin(), blocks.end(), begin);
  const auto last = std::lower_bound(first, blocks.end(), end);
  if (first == last) return;
  auto b = static_cast<std::size_t>(first - blocks.begin());
  const double* value = numbers_.data() + piece_->value_begin[b];
  double* const all = sums.s->values().data();
  for (; b < static_cast<std::size_t>(last - blocks.begin()); ++b) {
    for (std::uint32_t k = piece_->slot_begin[b]; k < piece_->slot_begin[b + 1]; ++k) {
      double* const sum = all + pattern_->ValueBegin(piece_->slots[k]);
      const std::size_t size = pattern_->ValuesOf(piece_->slots[k]);
      for (std::size_t i = 0; i < size; ++i) sum[i] += value[i];
      value += size;
    }
    const Eigen::Index offset = pattern_->offset(blocks[b]), size = pattern_->size(blocks[b]);
    const auto part = [&](Row which) {
      return Eigen::Map<const Eigen::VectorXd>(Vector(which) + piece_->row_begin[b], size);
    };
    sums.right_side->segment(offset, size) +=
        part(Row::kRightSide) + part(Row::kSubtractedGradient);
    sums.diagonal->segment(offset, size) += part(Row::kDiagonal);
    sums.gradient->segment(offset, size) +=
        part(Row::kExactGradient) + part(Row::kSubtractedGradient);
  }
}

}  // namespace sarblock
