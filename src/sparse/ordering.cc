// SPDX-License-Identifier: Apache-2.0
#include "ordering.h"

#include <cstddef>

#include <Eigen/SparseCore>
// Eigen's header uses SparseCore without including it.
#include <Eigen/OrderingMethods>
#include <glog/logging.h>

namespace sarblock::sparse {

std::vector<int> FillReducingOrder(const BlockPattern& pattern, std::span<const int> last) {
  const int count = pattern.block_count();
  std::vector<int> node(static_cast<std::size_t>(count), 0);  // in the graph without `last`
  std::vector<int> tail;
  for (const int block : last) {
    CHECK(block >= 0 && block < count) << block;
    if (node[static_cast<std::size_t>(block)] == 0) {
      node[static_cast<std::size_t>(block)] = -1;
      tail.push_back(block);
    }
  }
  std::vector<int> block_of_node;
  for (int block = 0; block < count; ++block) {
    int& id = node[static_cast<std::size_t>(block)];
    if (id == 0) {
      id = static_cast<int>(block_of_node.size());
      block_of_node.push_back(block);
    }
  }
  const int nodes = static_cast<int>(block_of_node.size());
  std::vector<int> order;
  order.reserve(static_cast<std::size_t>(count));
  if (nodes > 0) {
    std::vector<Eigen::Triplet<double>> edges;
    edges.reserve(pattern.slot_count());
    for (int j = 0; j < count; ++j) {
      const int column = node[static_cast<std::size_t>(j)];
      for (const int i : pattern.RowsOfColumn(j)) {
        const int row = node[static_cast<std::size_t>(i)];
        if (row >= 0 && column >= 0) {
          edges.emplace_back(row, column, 1.0);
        }
      }
    }
    Eigen::SparseMatrix<double> graph(nodes, nodes);
    graph.setFromTriplets(edges.begin(), edges.end());
    Eigen::AMDOrdering<int>::PermutationType permutation;
    Eigen::AMDOrdering<int>()(graph.selfadjointView<Eigen::Lower>(), permutation);
    for (int k = 0; k < nodes; ++k) {
      order.push_back(block_of_node[static_cast<std::size_t>(permutation.indices()[k])]);
    }
  }
  order.insert(order.end(), tail.begin(), tail.end());
  return order;
}

}  // namespace sarblock::sparse
