// SPDX-License-Identifier: Apache-2.0
#include "connectivity.h"

#include <cstddef>
#include <numeric>

namespace sarblock {
namespace {

std::uint32_t RootOf(std::vector<std::uint32_t>* parent, std::uint32_t node) {
  while ((*parent)[node] != node) {
    (*parent)[node] = (*parent)[(*parent)[node]];
    node = (*parent)[node];
  }
  return node;
}

}  // namespace

bool PassConnection::IsKeptBy(const PassConnection& after) const {
  return after.islands <= islands && after.pass_has_looks == pass_has_looks;
}

PassConnection ConnectPasses(const AdjustmentProblem& problem) {
  const Looks& looks = problem.block.looks;
  const std::size_t passes = problem.block.passes.size();
  PassConnection out;
  out.pass_has_looks.assign(passes, 0);
  std::vector<std::uint32_t> parent(passes);
  std::iota(parent.begin(), parent.end(), 0U);
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (!problem.Solves(point)) continue;
    bool first = true;
    std::uint32_t joined = 0;
    for (std::uint64_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      if (problem.look_used[i] == 0) continue;
      const std::uint32_t pass = looks.pass[i];
      out.pass_has_looks[pass] = 1;
      if (first) joined = RootOf(&parent, pass);
      first = false;
      parent[RootOf(&parent, pass)] = joined;
    }
  }
  for (std::uint32_t pass = 0; pass < passes; ++pass) {
    if (out.pass_has_looks[pass] != 0 && parent[pass] == pass) ++out.islands;
  }
  return out;
}

}  // namespace sarblock
