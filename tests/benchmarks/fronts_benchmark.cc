// SPDX-License-Identifier: Apache-2.0
// Factor, one solution and selected inverse of the reduced matrix of a two-dimensional net of
// passes: by the first rank alone while the others sleep, and by all of them, in turn, one thread
// each; the least wall time of each.
//   mpirun -n RANKS --bind-to core fronts_benchmark network.toml LINES SEGMENTS POINTS DEGREE
//   ROUNDS
// The first rank prints a CSV. Memory is that of factor, fronts and inverse on the rank that takes
// most, counted when it is allocated; `same` is whether the inverse has the bytes of one process.
// Run by scripts/bench.sh fronts.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <vector>

#include "core/ranks.h"
#include "core/threads.h"
#include "linear/block_cholesky.h"
#include "mpi/ranks.h"
#include "network_block.h"
#include "normals/reduced_system.h"
#include <Eigen/Core>
#include <mpi.h>

namespace sarblock {
namespace {

struct Cost {
  double factor_s = HUGE_VAL, solve_s = HUGE_VAL, inverse_s = HUGE_VAL;
  double mib = 0.0;

  void Least(const Cost& other) {
    factor_s = std::min(factor_s, other.factor_s);
    solve_s = std::min(solve_s, other.solve_s);
    inverse_s = std::min(inverse_s, other.inverse_s);
    mib = other.mib;
  }
};

/// Seconds until all ranks of the scope have done it.
template <typename Work>
double Seconds(const Work& work) {
  Ranks* const ranks = RanksScope::Current();
  if (ranks != nullptr) static_cast<void>(ranks->Agree(nullptr));
  const auto begin = std::chrono::steady_clock::now();
  work();
  if (ranks != nullptr) static_cast<void>(ranks->Agree(nullptr));
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

Cost Measure(const BlockSymmetricMatrix& matrix, BlockSymmetricMatrix* inverse) {
  Cost cost;
  BlockCholesky factor(matrix);
  cost.factor_s = Seconds([&] {
    if (!factor.Factorize(matrix).positive_definite) std::abort();
  });
  Eigen::MatrixXd x = Eigen::MatrixXd::Ones(matrix.rows(), 1);
  cost.solve_s = Seconds([&] { factor.Solve(x); });
  cost.inverse_s = Seconds([&] { *inverse = factor.SelectedInverse(); });
  const FactorNeeds used = factor.Used();
  const std::size_t doubles =
      used.factor + std::max(used.waiting, used.inverse_fronts + inverse->values().size());
  constexpr double kMiB = 1024.0 * 1024.0 / sizeof(double);
  const std::vector<double> of_ranks =
      JoinedOfRanks(std::vector<double>{static_cast<double>(doubles) / kMiB});
  cost.mib = *std::max_element(of_ranks.begin(), of_ranks.end());
  return cost;
}

void Run(char** argument) {
  mpi::MpiRanks ranks;
  const ThreadLimit one(1);
  const SimulatedBlock made =
      MakeNetwork(argument[1], std::atoi(argument[2]), std::atoi(argument[3]), argument[4]);
  AdjustmentProblem problem(made.block, NetworkCorrections(std::atoi(argument[5])));
  BlockState state;
  state.start_m = made.truth.points_m;
  state.displacement_m.assign(state.start_m.size(), {0.31, -0.22, 0.17});
  state.corrections.setZero(problem.layout.size());
  UpdateWeights(state, &problem);
  std::optional<ReducedSystem> system(problem);
  system->Form(state, {}, nullptr);
  const BlockSymmetricMatrix matrix = system->FormScaled().sparse;
  system.reset();
  BlockSymmetricMatrix of_one, of_all;
  Cost alone, together;
  for (int round = 0; round < std::atoi(argument[6]); ++round) {
    if (ranks.first()) alone.Least(Measure(matrix, &of_one));
    static_cast<void>(ranks.Agree(nullptr));
    const RanksScope scope(&ranks);
    together.Least(Measure(matrix, &of_all));
  }
  if (!ranks.first()) return;
  const auto a = of_one.values(), b = of_all.values();
  const bool same = std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
  const double one_s = alone.factor_s + alone.inverse_s;
  std::printf("passes,unknowns,ranks,factor_s,solve_s,inverse_s,mib,speed,memory,same\n");
  for (const bool all : {false, true}) {
    const Cost& cost = all ? together : alone;
    std::printf("%zu,%d,%d,%.3f,%.4f,%.3f,%.0f,%.2f,%.2f,%d\n",
                made.block.passes.size(),
                matrix.rows(),
                all ? ranks.size() : 1,
                cost.factor_s,
                cost.solve_s,
                cost.inverse_s,
                cost.mib,
                one_s / (cost.factor_s + cost.inverse_s),
                cost.mib / alone.mib,
                same ? 1 : 0);
  }
}

}  // namespace
}  // namespace sarblock

int main(int count, char** argument) {
  int provided = 0;
  MPI_Init_thread(&count, &argument, MPI_THREAD_FUNNELED, &provided);
  if (count == 7) {
    sarblock::Run(argument);
  } else {
    std::fprintf(stderr, "fronts_benchmark network.toml LINES SEGMENTS POINTS DEGREE ROUNDS\n");
  }
  MPI_Finalize();
  return count == 7 ? 0 : 2;
}
