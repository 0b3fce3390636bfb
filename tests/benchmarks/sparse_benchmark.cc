// SPDX-License-Identifier: Apache-2.0
// Factor, selected inverse and solves of the reduced normal matrix: passes of `parameters` each in
// a strips x segments x sides grid, paired within two steps. Run by hand; results in docs.
#include <cstddef>
#include <random>
#include <vector>

#include "linear/block_cholesky.h"
#include "linear/random_block_matrix.h"
#include "solve/rank.h"
#include <benchmark/benchmark.h>

namespace sarblock {
namespace {

BlockSymmetricMatrix PassGrid(const benchmark::State& state) {
  const int strips = static_cast<int>(state.range(0)), segments = static_cast<int>(state.range(1));
  const int parameters = static_cast<int>(state.range(2));
  std::mt19937_64 engine(2022);
  const std::vector<int> sizes(static_cast<std::size_t>(strips * segments * 2), parameters);
  return test::RandomPositive(sizes, test::Grid(strips, segments, 2, 2), 1.0, engine);
}

void Analyse(benchmark::State& state) {
  const BlockSymmetricMatrix matrix = PassGrid(state);
  for (auto _ : state) {
    const BlockCholesky cholesky(matrix);
    state.counters["entries"] = static_cast<double>(cholesky.factor_entries());
  }
}

void Factorize(benchmark::State& state) {
  const BlockSymmetricMatrix matrix = PassGrid(state);
  BlockCholesky cholesky(matrix);
  for (auto _ : state) {
    benchmark::DoNotOptimize(cholesky.Factorize(matrix));
  }
}

void SelectedInverse(benchmark::State& state) {
  const BlockSymmetricMatrix matrix = PassGrid(state);
  BlockCholesky cholesky(matrix);
  benchmark::DoNotOptimize(cholesky.Factorize(matrix));
  for (auto _ : state) {
    benchmark::DoNotOptimize(cholesky.SelectedInverse());
  }
}

void LeastSix(benchmark::State& state) {
  const BlockSymmetricMatrix matrix = PassGrid(state);
  BorderedCholesky cholesky(matrix);
  benchmark::DoNotOptimize(cholesky.Factorize(matrix));
  for (auto _ : state) {
    benchmark::DoNotOptimize(FindLeastEigenpairs(matrix, cholesky).values.sum());
  }
}

void SolveColumns(benchmark::State& state) {
  const BlockSymmetricMatrix matrix = PassGrid(state);
  BlockCholesky cholesky(matrix);
  benchmark::DoNotOptimize(cholesky.Factorize(matrix));
  const Eigen::MatrixXd b = Eigen::MatrixXd::Ones(matrix.rows(), state.range(3));
  for (auto _ : state) {
    Eigen::MatrixXd x = b;
    cholesky.Solve(x);
    benchmark::DoNotOptimize(x.data());
  }
}

void LookUpBlocks(benchmark::State& state) {
  const BlockSymmetricMatrix matrix = PassGrid(state);
  const int count = matrix.block_count();
  int j = 0;
  for (auto _ : state) {  // one point's block column, the next point one pass further
    for (const int i : matrix.RowsOfColumn(j)) {
      benchmark::DoNotOptimize(matrix.Block(i, j).data());
    }
    j = j + 1 < count ? j + 1 : 0;
  }
}

void Sizes(benchmark::internal::Benchmark* benchmark) {
  benchmark->Args({15, 1, 6})->Args({50, 1, 6})->Args({150, 1, 6})->Args({50, 20, 6});
  benchmark->Args({50, 20, 24})->Unit(benchmark::kMillisecond);
}

BENCHMARK(Analyse)->Apply(Sizes);
BENCHMARK(Factorize)->Apply(Sizes);
BENCHMARK(SelectedInverse)->Apply(Sizes);
BENCHMARK(LeastSix)->Apply(Sizes);
BENCHMARK(SolveColumns)->Args({50, 20, 6, 1})->Args({50, 20, 6, 64})->Unit(benchmark::kMillisecond);
BENCHMARK(LookUpBlocks)->Args({50, 20, 6})->Args({60, 20, 6});

}  // namespace
}  // namespace sarblock

BENCHMARK_MAIN();
