// SPDX-License-Identifier: Apache-2.0
#include "kept_factors.h"

#include <algorithm>
#include <limits>
#include <span>

#include "core/ranks.h"
#include "point_terms.h"

namespace sarblock {

KeptFactors::KeptFactors(std::size_t points, std::size_t parts, std::size_t bytes)
    : places_(points), parts_(parts) {
  for (Part& part : parts_) part.numbers.reserve(bytes / sizeof(double) / parts);
}

void KeptFactors::Keep(std::size_t part,
                       std::size_t point,
                       const PointFactor& factor,
                       const PointColumns& columns) {
  constexpr std::size_t kMost = std::numeric_limits<std::uint16_t>::max();
  if (factor.looks_not_evaluated > 0 || columns.blocks.size() > kMost ||
      static_cast<std::size_t>(factor.look_count) > kMost) {
    return;
  }
  std::vector<double>& numbers = parts_[part].numbers;
  if (numbers.empty()) numbers.push_back(0.0);
  std::vector<int>& blocks = parts_[part].blocks;
  places_[point] = {numbers.size(),
                    blocks.size(),
                    static_cast<std::uint32_t>(part),
                    static_cast<std::uint16_t>(factor.look_count),
                    static_cast<std::uint16_t>(columns.blocks.size())};
  blocks.insert(blocks.end(), columns.blocks.begin(), columns.blocks.end());
  const auto put = [&numbers](const double* from, std::size_t count) {
    numbers.insert(numbers.end(), from, from + count);
  };
  put(factor.r.data(), 9);
  put(columns.t.data(), columns.t.size());
  numbers.push_back(factor.row_count);
  put(factor.q.data(), factor.q.size());
  put(factor.e.data(), factor.e.size());
  for (int k = 0; k < factor.look_count; ++k) {
    const WhitenedLook& look = factor.looks[static_cast<std::size_t>(k)];
    for (const auto& row : look.row) {
      put(row.data(), static_cast<std::size_t>(look.columns.column_count));
    }
  }
}

void KeptFactors::Share(const PointPieces& pieces, const std::vector<int>& rank_of_part) {
  Ranks* const ranks = RanksScope::Current();
  if (ranks == nullptr) return;
  struct Sizes {
    std::size_t numbers = 0, blocks = 0;
  };
  std::vector<Sizes> sizes;
  for (const Part& part : parts_) sizes.push_back({part.numbers.size(), part.blocks.size()});
  std::vector<RankPart> told, kept;
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    AddPart(std::as_writable_bytes(std::span(&sizes[k], 1)), rank_of_part[k], &told);
  }
  ranks->Share(told);
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    Part& part = parts_[k];
    const int rank = rank_of_part[k];
    part.numbers.resize(sizes[k].numbers);
    part.blocks.resize(sizes[k].blocks);
    AddPart(std::as_writable_bytes(std::span(part.numbers)), rank, &kept);
    AddPart(std::as_writable_bytes(std::span(part.blocks)), rank, &kept);
    for (std::size_t place = pieces[k].begin; place < pieces[k].end; ++place) {
      AddPart(std::as_writable_bytes(std::span(&places_[pieces.PointAt(place)], 1)), rank, &kept);
    }
  }
  ranks->Share(kept);
}

const double* KeptFactors::Restore(const AdjustmentProblem& problem,
                                   std::size_t point,
                                   Eigen::Matrix3d* r,
                                   PointColumns* columns) const {
  const Place& place = places_[point];
  if (place.number == kNone || problem.CountLooks(point) != place.looks) return nullptr;
  const double* number = parts_[place.part].numbers.data() + place.number;
  std::copy_n(number, 9, r->data());
  const auto block = parts_[place.part].blocks.begin() + static_cast<std::ptrdiff_t>(place.block);
  columns->blocks.assign(block, block + place.blocks);
  PlaceColumns(problem.layout, columns);
  return number + 9;
}

void KeptFactors::RestoreLooks(const AdjustmentProblem& problem,
                               std::size_t point,
                               PointFactor* out) const {
  const Place& place = places_[point];
  const Part& part = parts_[place.part];
  const double* number = part.numbers.data() + place.number;
  std::copy_n(number, 9, out->r.data());
  number += 9;
  for (std::size_t k = 0; k < place.blocks; ++k) {
    const auto block = static_cast<std::size_t>(part.blocks[place.block + k]);
    number += 3 * problem.layout.blocks[block].size;
  }
  const auto take = [&number](std::size_t count, double* to) {
    std::copy_n(number, count, to);
    number += count;
  };
  out->row_count = static_cast<int>(*number++);
  const auto m = static_cast<std::size_t>(out->row_count);
  out->q.resize(3 * m);
  out->e.resize(m);
  take(3 * m, out->q.data());
  take(m, out->e.data());
  const Looks& looks = problem.block.looks;
  const std::size_t begin = looks.offsets[point], end = looks.offsets[point + 1];
  if (out->looks.size() < end - begin) out->looks.resize(end - begin);
  out->look_count = 0;
  out->looks_not_evaluated = 0;
  for (std::size_t i = begin; i < end; ++i) {
    if (problem.look_used[i] == 0) continue;
    const auto k = static_cast<std::size_t>(out->look_count++);
    WhitenedLook& look = out->looks[k];
    look.look = i;
    problem.model.ColumnsOf(i, &look.columns);
    look.error_1 = {out->e[2 * k], out->e[2 * k + 1]};
    for (auto& row : look.row) {
      take(static_cast<std::size_t>(look.columns.column_count), row.data());
    }
  }
}

}  // namespace sarblock
