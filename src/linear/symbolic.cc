// SPDX-License-Identifier: Apache-2.0
#include "symbolic.h"

#include <algorithm>
#include <array>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <mutex>
#include <optional>
#include <utility>

#include <Eigen/SparseCore>
#include <glog/logging.h>
#include <metis.h>
// Eigen's header uses SparseCore without including it.
#include <Eigen/OrderingMethods>

namespace sarblock::sparse {
namespace {

/// The blocks that may be ordered freely.
struct Nodes {
  Nodes(const BlockPattern& pattern, std::span<const int> last)
      : of_block(static_cast<std::size_t>(pattern.block_count()), 0) {
    const int count = pattern.block_count();
    for (const int b : last) {
      CHECK(b >= 0 && b < count) << b;
      if (of_block[static_cast<std::size_t>(b)] == 0) {
        of_block[static_cast<std::size_t>(b)] = -1;
        tail.push_back(b);
      }
    }
    for (int b = 0; b < count; ++b) {
      int& id = of_block[static_cast<std::size_t>(b)];
      if (id == 0) {
        id = static_cast<int>(block.size());
        block.push_back(b);
      }
    }
  }

  [[nodiscard]] int count() const { return static_cast<int>(block.size()); }
  /// Calls edge(row, column), row >= column, for all pairs of nodes, the diagonal among them.
  template <typename Edge>
  void ForEdges(const BlockPattern& pattern, const Edge& edge) const {
    for (int j = 0; j < pattern.block_count(); ++j) {
      const int column = of_block[static_cast<std::size_t>(j)];
      for (const int i : pattern.RowsOfColumn(j)) {
        const int row = of_block[static_cast<std::size_t>(i)];
        if (row >= 0 && column >= 0) edge(row, column);
      }
    }
  }
  /// The blocks in an order of nodes, and the tail.
  template <typename NodeAt>
  [[nodiscard]] std::vector<int> Blocks(const NodeAt& node_at) const {
    std::vector<int> order;
    order.reserve(of_block.size());
    for (int k = 0; k < count(); ++k) order.push_back(block[static_cast<std::size_t>(node_at(k))]);
    order.insert(order.end(), tail.begin(), tail.end());
    return order;
  }

  std::vector<int> of_block;  // -1: in the tail
  std::vector<int> block;     // of a node
  std::vector<int> tail;
};

/// METIS catches SIGABRT and SIGTERM while it works and leaves handlers behind that serve once.
class SignalsKept {
 public:
  SignalsKept() {
    for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], nullptr, &kept_[i]);
  }
  ~SignalsKept() {
    for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &kept_[i], nullptr);
  }
  SignalsKept(const SignalsKept&) = delete;
  SignalsKept& operator=(const SignalsKept&) = delete;

 private:
  static constexpr std::array<int, 2> kSignals{SIGABRT, SIGTERM};
  std::array<struct sigaction, 2> kept_{};
};

}  // namespace

std::vector<int> MinimumDegreeOrder(const BlockPattern& pattern, std::span<const int> last) {
  const Nodes nodes(pattern, last);
  if (nodes.count() == 0) return nodes.Blocks([](int k) { return k; });
  std::vector<Eigen::Triplet<double>> edges;
  edges.reserve(pattern.slot_count());
  nodes.ForEdges(pattern, [&](int row, int column) { edges.emplace_back(row, column, 1.0); });
  Eigen::SparseMatrix<double> graph(nodes.count(), nodes.count());
  graph.setFromTriplets(edges.begin(), edges.end());
  Eigen::AMDOrdering<int>::PermutationType permutation;
  Eigen::AMDOrdering<int>()(graph.selfadjointView<Eigen::Lower>(), permutation);
  return nodes.Blocks([&](int k) { return permutation.indices()[k]; });
}

std::optional<std::vector<int>> DissectionOrder(const BlockPattern& pattern,
                                                std::span<const int> last) {
  const Nodes nodes(pattern, last);
  if (nodes.count() == 0) return nodes.Blocks([](int k) { return k; });
  if (2 * pattern.slot_count() > static_cast<std::size_t>(std::numeric_limits<idx_t>::max())) {
    return std::nullopt;
  }
  const auto count = static_cast<std::size_t>(nodes.count());
  std::vector<idx_t> begin(count + 1, 0), weight(count);
  nodes.ForEdges(pattern, [&](int row, int column) {
    if (row == column) return;
    ++begin[static_cast<std::size_t>(row) + 1];
    ++begin[static_cast<std::size_t>(column) + 1];
  });
  for (std::size_t i = 0; i < count; ++i) begin[i + 1] += begin[i];
  std::vector<idx_t> next(begin.begin(), begin.end() - 1);
  std::vector<idx_t> neighbour(static_cast<std::size_t>(begin.back()));
  nodes.ForEdges(pattern, [&](int row, int column) {
    if (row == column) return;
    neighbour[static_cast<std::size_t>(next[static_cast<std::size_t>(row)]++)] = column;
    neighbour[static_cast<std::size_t>(next[static_cast<std::size_t>(column)]++)] = row;
  });
  for (std::size_t i = 0; i < count; ++i) weight[i] = pattern.size(nodes.block[i]);

  std::array<idx_t, METIS_NOPTIONS> options{};
  METIS_SetDefaultOptions(options.data());
  options[METIS_OPTION_NUMBERING] = 0;
  options[METIS_OPTION_SEED] = 1;
  std::vector<idx_t> order(count), place(count);
  auto nodes_count = static_cast<idx_t>(count);
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  const SignalsKept kept;
  if (METIS_NodeND(&nodes_count,
                   begin.data(),
                   neighbour.data(),
                   weight.data(),
                   options.data(),
                   order.data(),
                   place.data()) != METIS_OK) {
    return std::nullopt;
  }
  return nodes.Blocks([&](int k) { return order[static_cast<std::size_t>(k)]; });
}

namespace {

using Lists = std::vector<std::vector<int>>;

/// For each position the later positions its block is paired with.
Lists LaterNeighbours(const BlockPattern& pattern, const std::vector<int>& position) {
  Lists later(position.size());
  for (int j = 0; j < pattern.block_count(); ++j) {
    for (const int i : pattern.RowsOfColumn(j)) {
      if (i != j) {
        const auto [p, q] = std::minmax(position[At(i)], position[At(j)]);
        later[At(p)].push_back(q);
      }
    }
  }
  return later;
}

/// Structure of each column of L below the diagonal, by positions, sorted: its own neighbours and
/// what its children in the elimination tree hand up. The first row is the parent.
Lists ColumnStructures(Lists later) {
  const int count = static_cast<int>(later.size());
  std::vector<int> mark(later.size(), -1);
  Lists children(later.size());
  for (int k = 0; k < count; ++k) {
    std::vector<int>& structure = later[At(k)];
    mark[At(k)] = k;
    for (const int row : structure) {
      mark[At(row)] = k;
    }
    for (const int child : children[At(k)]) {
      for (const int row : later[At(child)]) {
        if (mark[At(row)] != k) {
          mark[At(row)] = k;
          structure.push_back(row);
        }
      }
    }
    std::sort(structure.begin(), structure.end());
    if (!structure.empty()) {
      children[At(structure.front())].push_back(k);
    }
  }
  return later;
}

/// An order of elimination and what it makes of the columns, all but `position` by place in it.
struct Elimination {
  Elimination(const BlockPattern& pattern, std::vector<int> blocks)
      : order(std::move(blocks)), position(order.size()), weights(order.size()) {
    for (std::size_t k = 0; k < order.size(); ++k) {
      position[At(order[k])] = static_cast<int>(k);
      weights[k] = pattern.size(order[k]);
    }
    structures = ColumnStructures(LaterNeighbours(pattern, position));
    for (std::size_t k = 0; k < order.size(); ++k) {
      double height = 0.0;
      for (const int row : structures[k]) height += weights[At(row)];
      for (int column = 0; column < weights[k]; ++column) {
        height += 1.0;  // of the last column of the block first
        operations += height * height;
      }
    }
  }
  std::vector<int> order;     // block eliminated k-th
  std::vector<int> position;  // by block
  std::vector<int> weights;   // rows
  Lists structures;           // below the diagonal
  double operations = 0.0;
};

/// Supernodes while they are being merged, each named by its topmost column.
class Supernodes {
 public:
  Supernodes(const Lists& structures, const std::vector<int>& weights)
      : structures_(structures), owner_(weights.size()), width_(weights.begin(), weights.end()) {
    const std::size_t count = weights.size();
    columns_.resize(count);
    below_.resize(count);
    zeros_.assign(count, 0);
    for (std::size_t k = 0; k < count; ++k) {
      owner_[k] = static_cast<int>(k);
      columns_[k] = {static_cast<int>(k)};
      for (const int row : structures[k]) {
        below_[k] += weights[At(row)];
      }
    }
    for (const bool relaxed : {false, true}) {
      for (int k = 0; k < static_cast<int>(count); ++k) {
        if (owner_[At(k)] == k && !structures_[At(k)].empty()) {
          TryMerge(k, Owner(structures_[At(k)].front()), relaxed);
        }
      }
    }
  }

  [[nodiscard]] bool IsTop(int column) const { return owner_[At(column)] == column; }
  /// Supernode of a column.
  [[nodiscard]] int Owner(int column) {
    while (owner_[At(column)] != column) {
      owner_[At(column)] = owner_[At(owner_[At(column)])];
      column = owner_[At(column)];
    }
    return column;
  }
  [[nodiscard]] const std::vector<int>& columns(int top) const { return columns_[At(top)]; }
  [[nodiscard]] std::int64_t width(int top) const { return width_[At(top)]; }
  [[nodiscard]] std::int64_t below(int top) const { return below_[At(top)]; }

 private:
  void TryMerge(int child, int parent, bool relaxed) {
    const auto c = At(child), p = At(parent);
    const std::int64_t width = width_[c] + width_[p];
    const std::int64_t added = width_[c] * (width_[p] + below_[p] - below_[c]);
    const std::int64_t zeros = zeros_[c] + zeros_[p] + added;
    if (!relaxed ? added > 0 : !Worthwhile(width, below_[p], zeros)) {
      return;
    }
    owner_[c] = parent;
    width_[p] = width;
    zeros_[p] = zeros;
    columns_[c].insert(columns_[c].end(), columns_[p].begin(), columns_[p].end());
    columns_[p] = std::move(columns_[c]);
    columns_[c].clear();
  }

  static bool Worthwhile(std::int64_t width, std::int64_t below, std::int64_t zeros) {
    const double entries = static_cast<double>(width) *
                           (static_cast<double>(width + 1) / 2 + static_cast<double>(below));
    const double fraction = entries > 0 ? static_cast<double>(zeros) / entries : 0.0;
    return width <= 4 || (width <= 16 && fraction < 0.8) || (width <= 48 && fraction < 0.1) ||
           fraction < 0.05;
  }

  const Lists& structures_;
  std::vector<int> owner_;
  std::vector<std::int64_t> width_, below_, zeros_;
  Lists columns_;
};

/// Tops of the supernodes in a postorder of their tree that keeps few update matrices waiting at
/// a time: the child whose subtree needs most beyond its own update matrix goes first (Liu 1986).
std::vector<int> Postorder(Supernodes& nodes, const Lists& structures) {
  const std::size_t count = structures.size();
  Lists children(count);
  std::vector<int> roots;
  std::vector<double> peak(count, 0.0);
  const auto update = [&](int top) {
    return static_cast<double>(nodes.below(top)) * static_cast<double>(nodes.below(top));
  };
  for (int k = 0; k < static_cast<int>(count); ++k) {
    if (!nodes.IsTop(k)) {
      continue;
    }
    std::vector<int>& mine = children[At(k)];
    std::stable_sort(mine.begin(), mine.end(), [&](int a, int b) {
      return peak[At(a)] - update(a) > peak[At(b)] - update(b);
    });
    double waiting = 0.0;
    for (const int child : mine) {
      peak[At(k)] = std::max(peak[At(k)], waiting + peak[At(child)]);
      waiting += update(child);
    }
    peak[At(k)] = std::max(peak[At(k)], waiting + update(k));
    if (structures[At(k)].empty()) {
      roots.push_back(k);
    } else {
      children[At(nodes.Owner(structures[At(k)].front()))].push_back(k);
    }
  }
  // Preorder with the children reversed, then reversed as a whole, is the postorder.
  std::vector<int> order, stack(roots.begin(), roots.end());
  while (!stack.empty()) {
    const int top = stack.back();
    stack.pop_back();
    order.push_back(top);
    stack.insert(stack.end(), children[At(top)].begin(), children[At(top)].end());
  }
  std::reverse(order.begin(), order.end());
  return order;
}

/// First row of each block of a front, by position in elimination order; valid for one front.
class LocalRows {
 public:
  explicit LocalRows(const std::vector<int>& row_begin)
      : row_begin_(row_begin), local_(row_begin.size() - 1) {}

  void Set(const Front& front) {
    front_ = &front;
    int row = front.eliminated;
    for (const int block : front.rows) {
      local_[At(block)] = row;
      row += row_begin_[At(block) + 1] - row_begin_[At(block)];
    }
  }
  [[nodiscard]] int operator()(int block) const {
    const int row = row_begin_[At(block)] - front_->first_row;
    return row < front_->eliminated ? row : local_[At(block)];
  }

 private:
  const std::vector<int>& row_begin_;
  std::vector<int> local_;
  const Front* front_ = nullptr;
};

std::vector<Run> RunsInParent(const Front& child,
                              const LocalRows& local,
                              const std::vector<int>& row_begin) {
  std::vector<Run> runs;
  int begin = 0;
  for (const int block : child.rows) {
    const int size = row_begin[At(block) + 1] - row_begin[At(block)];
    const int parent_begin = local(block);
    if (!runs.empty() && runs.back().parent_begin + runs.back().length == parent_begin) {
      runs.back().length += size;
    } else {
      runs.push_back({begin, parent_begin, size});
    }
    begin += size;
  }
  return runs;
}

}  // namespace

Symbolic Analyse(const BlockPattern& pattern, std::span<const int> last, double many_operations) {
  const std::size_t count = At(pattern.block_count());
  Elimination elimination(pattern, MinimumDegreeOrder(pattern, last));
  Symbolic symbolic;
  if (elimination.operations >= many_operations) {
    if (std::optional<std::vector<int>> order = DissectionOrder(pattern, last)) {
      Elimination dissected(pattern, std::move(*order));
      symbolic.dissected = dissected.operations < elimination.operations;
      if (symbolic.dissected) elimination = std::move(dissected);
    }
  }
  symbolic.operations = elimination.operations;
  const auto& [first_order, position, weights, structures, operations] = elimination;
  Supernodes nodes(structures, weights);

  symbolic.row_begin.push_back(0);
  std::vector<int> final_position(count), front_of_block(count);  // by first position
  const std::vector<int> tops = Postorder(nodes, structures);
  symbolic.fronts.resize(tops.size());
  for (std::size_t f = 0; f < tops.size(); ++f) {
    Front& front = symbolic.fronts[f];
    front.first_row = symbolic.row_begin.back();
    front.eliminated = static_cast<int>(nodes.width(tops[f]));
    front.remaining = static_cast<int>(nodes.below(tops[f]));
    symbolic.factor_entries += At(front.height()) * At(front.eliminated);
    for (const int column : nodes.columns(tops[f])) {
      final_position[At(column)] = static_cast<int>(symbolic.order.size());
      front_of_block[At(column)] = static_cast<int>(f);
      symbolic.order.push_back(first_order[At(column)]);
      symbolic.row_begin.push_back(symbolic.row_begin.back() + weights[At(column)]);
    }
  }
  symbolic.original_row.resize(At(pattern.rows()));
  for (std::size_t k = 0; k < count; ++k) {
    for (int row = 0; row < pattern.size(symbolic.order[k]); ++row) {
      symbolic.original_row[At(symbolic.row_begin[k] + row)] =
          pattern.offset(symbolic.order[k]) + row;
    }
  }
  for (std::size_t f = 0; f < tops.size(); ++f) {
    Front& front = symbolic.fronts[f];
    for (const int row : structures[At(tops[f])]) {
      front.rows.push_back(final_position[At(row)]);
    }
    std::sort(front.rows.begin(), front.rows.end());
    if (!front.rows.empty()) {
      front.parent = front_of_block[At(structures[At(tops[f])].front())];
      symbolic.fronts[At(front.parent)].children.push_back(static_cast<int>(f));
    }
  }

  // Blocks of S by the front of the earlier one, then their rows and the children's within it.
  Lists blocks(tops.size());               // pairs (i, j) flattened
  std::vector<int> final_of_block(count);  // position
  for (std::size_t k = 0; k < count; ++k) {
    final_of_block[At(first_order[k])] = final_position[k];
  }
  std::vector<int> front_of(count);
  for (std::size_t k = 0; k < count; ++k) {
    front_of[At(final_position[k])] = front_of_block[k];
  }
  for (int j = 0; j < pattern.block_count(); ++j) {
    for (const int i : pattern.RowsOfColumn(j)) {
      std::vector<int>& pairs =
          blocks[At(front_of[At(std::min(final_of_block[At(i)], final_of_block[At(j)]))])];
      pairs.insert(pairs.end(), {i, j});
    }
  }
  LocalRows local(symbolic.row_begin);
  for (std::size_t f = 0; f < tops.size(); ++f) {
    Front& front = symbolic.fronts[f];
    local.Set(front);
    for (const int child : front.children) {
      symbolic.fronts[At(child)].runs =
          RunsInParent(symbolic.fronts[At(child)], local, symbolic.row_begin);
    }
    front.entries.reserve(blocks[f].size() / 2);
    for (std::size_t e = 0; e < blocks[f].size(); e += 2) {
      int i = blocks[f][e], j = blocks[f][e + 1];
      const std::size_t value = pattern.ValueBegin(pattern.Slot(i, j));
      const bool transposed = final_of_block[At(i)] < final_of_block[At(j)];
      if (transposed) {
        std::swap(i, j);
      }
      front.entries.push_back({value,
                               local(final_of_block[At(i)]),
                               local(final_of_block[At(j)]),
                               pattern.size(i),
                               pattern.size(j),
                               transposed});
    }
  }
  return symbolic;
}

}  // namespace sarblock::sparse
