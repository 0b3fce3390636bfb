// SPDX-License-Identifier: Apache-2.0
#include "ordering.h"

#include <array>
#include <csignal>
#include <cstddef>
#include <limits>
#include <mutex>

#include <Eigen/SparseCore>
// Eigen's header uses SparseCore without including it.
#include <Eigen/OrderingMethods>
#include <glog/logging.h>
#include <metis.h>

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

}  // namespace sarblock::sparse
