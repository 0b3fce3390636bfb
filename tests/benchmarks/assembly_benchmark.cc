// SPDX-License-Identifier: Apache-2.0
// The sum of the reduced normal matrix over the points of a two-dimensional net of passes, with one
// thread and with two in turn, the least wall time of each.
//   assembly_benchmark network.toml LINES SEGMENTS POINTS DEGREE ROUNDS
// Prints a CSV. Run by scripts/bench.sh assembly. `cores` is CPU time over wall time: two quiet
// cores give the second row nearly 2; what other work took is what is missing.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "core/threads.h"
#include "network_block.h"
#include "normals/reduced_system.h"
#include <Eigen/Core>

namespace sarblock {
namespace {

struct Cost {
  double wall_s = HUGE_VAL, cpu_s = 0.0;
};

double CpuNow_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void FormOnce(const BlockState& state, ReducedSystem* system, Cost* least) {
  const auto begin = std::chrono::steady_clock::now();
  const double cpu_s = CpuNow_s();
  system->Form(state, {}, nullptr);
  const double wall_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (wall_s < least->wall_s) *least = {wall_s, CpuNow_s() - cpu_s};
}

void Run(char** argument) {
  const SimulatedBlock made =
      MakeNetwork(argument[1], std::atoi(argument[2]), std::atoi(argument[3]), argument[4]);
  AdjustmentProblem problem(made.block, NetworkCorrections(std::atoi(argument[5])));
  BlockState state;
  state.start_m = made.truth.points_m;
  state.displacement_m.assign(state.start_m.size(), {0.31, -0.22, 0.17});
  state.corrections.setZero(problem.layout.size());
  UpdateWeights(state, &problem);
  ReducedSystem system(problem);
  constexpr int kThreads[] = {1, 2};
  Cost least[2];
  for (int round = 0; round < std::atoi(argument[6]); ++round) {
    for (int k = 0; k < 2; ++k) {
      const ThreadLimit limit(kThreads[k]);
      FormOnce(state, &system, &least[k]);
    }
  }
  constexpr double kMiB = 1024.0 * 1024.0 / sizeof(double);
  std::printf(
      "passes,points,looks,unknowns,s_mib,partial_sums_mib,threads,wall_s,cpu_s,cores,ratio\n");
  for (int k = 0; k < 2; ++k) {
    std::printf("%zu,%zu,%zu,%d,%.0f,%.0f,%d,%.3f,%.3f,%.2f,%.2f\n",
                made.block.passes.size(),
                made.block.points.size(),
                made.block.looks.size(),
                system.rows(),
                static_cast<double>(system.matrix().sparse.values().size()) / kMiB,
                static_cast<double>(system.pieces().MaxDoubles(kThreads[k])) / kMiB,
                kThreads[k],
                least[k].wall_s,
                least[k].cpu_s,
                least[k].cpu_s / least[k].wall_s,
                least[0].wall_s / least[k].wall_s);
  }
}

}  // namespace
}  // namespace sarblock

int main(int count, char** argument) {
  if (count != 7) {
    std::fprintf(stderr, "assembly_benchmark network.toml LINES SEGMENTS POINTS DEGREE ROUNDS\n");
    return 2;
  }
  sarblock::Run(argument);
  return 0;
}
