// SPDX-License-Identifier: Apache-2.0
#include "point_terms.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sarblock {
namespace {

/// Orthonormal columns that complete Q (m x 3, orthonormal) to a basis: the last m - 3 columns of
/// the product of the three Householder reflections that take Q to the axes. m x (m - 3).
void CompleteBasis(std::size_t m, const std::vector<double>& q, std::vector<double>* out) {
  const std::size_t count = m - 3;
  // The reflections' vectors; row k - 1 and those above are zero in vector k.
  std::array<double, 3> half_square;
  out->assign(m * count + 3 * m, 0.0);
  double* v = out->data() + m * count;
  std::copy_n(q.data(), 3 * m, v);
  for (std::size_t k = 0; k < 3; ++k) {
    double* vk = v + k * m;
    for (std::size_t j = 0; j < k; ++j) {
      const double* vj = v + j * m;
      const double part = Dot(m - j, vj + j, vk + j) / half_square[j];
      for (std::size_t i = j; i < m; ++i) vk[i] -= part * vj[i];
    }
    // What is left of the column below row k has length 1; its reflection goes to -sign(v_kk).
    std::fill_n(vk, k, 0.0);
    const double sign = vk[k] < 0.0 ? -1.0 : 1.0;
    half_square[k] = 1.0 + std::abs(vk[k]);
    vk[k] += sign;
  }
  for (std::size_t c = 0; c < count; ++c) {
    double* column = out->data() + c * m;
    column[3 + c] = 1.0;
    for (std::size_t k = 3; k-- > 0;) {
      const double* vk = v + k * m;
      const double part = Dot(m - k, vk + k, column + k) / half_square[k];
      for (std::size_t i = k; i < m; ++i) column[i] -= part * vk[i];
    }
  }
}

}  // namespace

void FindColumns(const ParameterLayout& layout, const PointFactor& factor, PointColumns* columns) {
  columns->blocks.clear();
  for (int k = 0; k < factor.look_count; ++k) {
    InsertBlocks(factor.looks[static_cast<std::size_t>(k)].columns, &columns->blocks);
  }
  PlaceColumns(layout, columns);
}

void PlaceColumns(const ParameterLayout& layout, PointColumns* columns) {
  if (columns->column_of_block.size() < layout.blocks.size()) {
    columns->column_of_block.resize(layout.blocks.size());
  }
  const std::vector<int>& blocks = columns->blocks;
  columns->begin.resize(blocks.size());
  columns->width = 0;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const auto id = static_cast<std::size_t>(blocks[i]);
    columns->begin[i] = columns->width;
    columns->column_of_block[id] = columns->width;
    columns->width += layout.blocks[id].size;
  }
}

void AddTurnedColumns(const ParameterLayout& layout,
                      const PointFactor& factor,
                      const PointColumns& columns,
                      const double* b,
                      int terms,
                      double* out) {
  const auto m = static_cast<std::size_t>(factor.row_count);
  for (int k = 0; k < factor.look_count; ++k, b += 2) {
    const WhitenedLook& look = factor.looks[static_cast<std::size_t>(k)];
    const double* range = look.row[0].data();
    const double* doppler = look.row[1].data();
    for (int q = 0; q < look.columns.block_count; ++q) {
      const auto id = static_cast<std::size_t>(look.columns.block[static_cast<std::size_t>(q)]);
      const int size = layout.blocks[id].size;
      Kernels().AddTurned(out + columns.column_of_block[id],
                          static_cast<std::size_t>(columns.width),
                          terms,
                          b,
                          m,
                          range,
                          doppler,
                          size);
      range += size;
      doppler += size;
    }
  }
}

PointBlocks FindSlots(const ParameterLayout& layout,
                      const BlockPattern& pattern,
                      PointTerms* terms) {
  const std::vector<int>& blocks = terms->columns.blocks;
  terms->size.resize(blocks.size());
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    terms->size[i] = layout.blocks[static_cast<std::size_t>(blocks[i])].size;
  }
  terms->value.resize(blocks.size() * (blocks.size() + 1) / 2);
  pattern.SlotsOfPairs(blocks, terms->value.data());
  return {static_cast<int>(blocks.size()),
          terms->columns.begin.data(),
          terms->size.data(),
          terms->value.data()};
}

PointBlocks FindBlocks(const ParameterLayout& layout,
                       const BlockPattern& pattern,
                       PointTerms* terms) {
  const PointBlocks blocks = FindSlots(layout, pattern, terms);
  for (std::size_t& at : terms->value) at = pattern.ValueBegin(at);
  return blocks;
}

void TurnToRest(const ParameterLayout& layout, const PointFactor& factor, PointTerms* terms) {
  const auto m = static_cast<std::size_t>(factor.row_count);
  const std::size_t rest = m - 3;
  CompleteBasis(m, factor.q, &terms->basis);
  const double* basis = terms->basis.data();
  terms->rest.assign(rest * static_cast<std::size_t>(terms->columns.width), 0.0);
  AddTurnedColumns(
      layout, factor, terms->columns, basis, static_cast<int>(rest), terms->rest.data());
  terms->rest_e.resize(rest);
  for (std::size_t k = 0; k < rest; ++k) {
    terms->rest_e[k] = Dot(m, basis + k * m, factor.e.data());
  }
}

}  // namespace sarblock
