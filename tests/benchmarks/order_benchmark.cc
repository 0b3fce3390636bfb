// SPDX-License-Identifier: Apache-2.0
// Orders of elimination of two-dimensional nets of passes, six parameters each: operations of the
// factor by minimum degree and by the better of that and nested dissection, and how long the
// analysis takes without and with the second.
//   order_benchmark network.toml LINES SEGMENTS POINTS
// Prints one row of a CSV (header: order_benchmark). Run by scripts/bench.sh orders.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "linear/symbolic.h"
#include "network_block.h"
#include "normals/pieces.h"

namespace sarblock {
namespace {

double CpuOfThread_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void Run(char** argument) {
  const SimulatedBlock made =
      MakeNetwork(argument[1], std::atoi(argument[2]), std::atoi(argument[3]), argument[4]);
  const AdjustmentProblem problem(made.block, NetworkCorrections(1));
  const ReducedPattern found = FindPattern(problem, true);
  const double begin_s = CpuOfThread_s();
  const sparse::Symbolic degree = sparse::Analyse(*found.pattern, {}, HUGE_VAL);
  const double middle_s = CpuOfThread_s();
  const sparse::Symbolic better = sparse::Analyse(*found.pattern, {}, 0.0);
  const double end_s = CpuOfThread_s();
  std::printf("%zu,%zu,%zu,%.3g,%.3g,%.3f,%d,%.2f,%.2f\n",
              made.block.passes.size(),
              made.block.points.size(),
              found.pattern->slot_count(),
              degree.operations,
              better.operations,
              better.operations / degree.operations,
              better.dissected ? 1 : 0,
              middle_s - begin_s,
              end_s - middle_s);
}

}  // namespace
}  // namespace sarblock

int main(int count, char** argument) {
  if (count == 5) {
    sarblock::Run(argument);
  } else {
    std::printf("passes,points,blocks,degree,better,ratio,dissected,degree_cpu_s,both_cpu_s\n");
  }
  return 0;
}
