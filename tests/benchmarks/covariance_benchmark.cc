// SPDX-License-Identifier: Apache-2.0
// All 3 x 3 blocks of the points and all blocks of the passes: the reduced route against
// ceres::Covariance (SPARSE_QR, SuiteSparse) on the same equations at the same linearisation point.
//   covariance_benchmark SCENE.toml POINTS PASSES THREADS
// Prints one row of a CSV (header: covariance_benchmark). Run by scripts/bench.sh covariance.
#include "sarblock/model/result.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/threads.h"
#include "normals/reduced_system.h"
#include "quality/point_sweep.h"
#include "solve/ceres_engine.h"
#include "solve/rank.h"
#include "strips_block.h"
#include <Eigen/Core>
#include <ceres/covariance.h>

namespace sarblock {
namespace {

/// Wall and CPU seconds of all threads since it was made.
class Clock {
 public:
  [[nodiscard]] double Wall_s() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_).count();
  }
  [[nodiscard]] double Cpu_s() const { return CpuNow_s() - cpu_s_; }

 private:
  static double CpuNow_s() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
  }
  std::chrono::steady_clock::time_point wall_ = std::chrono::steady_clock::now();
  double cpu_s_ = CpuNow_s();
};

struct Covariances {
  std::vector<SymmetricEnu> points;
  std::vector<Eigen::MatrixXd> passes;  ///< by parameter block
};

/// kPivots: by the pivots of the factor alone, as ceres::Covariance does. kSearch: `adjust` looks
/// for weak directions as well and names them; ceres::Covariance has nothing like it.
enum class RankBy { kPivots, kSearch };

Covariances Reduced(const AdjustmentProblem& problem, const BlockState& state, RankBy rank) {
  ReducedSystem system(problem, KeptFactors::kMaxBytes);
  system.Form(state, {}, nullptr);
  if (rank == RankBy::kSearch) {
    FactorRegular(&system);
  } else if (!system.FactorDamped()) {
    throw std::runtime_error("singular");
  }
  const CorrectionCovariance inverse = system.SelectedInverse();
  Covariances out;
  out.points = SweepPoints(problem, state, &inverse, false, nullptr, system.kept()).covariance_m2;
  for (int b = 0; b < inverse.blocks.block_count(); ++b)
    out.passes.emplace_back(inverse.blocks.Block(b, b));
  return out;
}

/// CPU time of a sweep over the points with reliability over one without; the least of five each.
double QualityRatio(const AdjustmentProblem& problem, const BlockState& state) {
  ReducedSystem system(problem);
  system.Form(state, {}, nullptr);
  FactorRegular(&system);
  const CorrectionCovariance inverse = system.SelectedInverse();
  double least_s[2] = {HUGE_VAL, HUGE_VAL};
  for (int round = 0; round < 5; ++round) {
    for (const bool quality : {false, true}) {
      const Clock clock;
      const PointSweep sweep = SweepPoints(problem, state, &inverse, quality, nullptr);
      least_s[quality ? 1 : 0] = std::min(least_s[quality ? 1 : 0], clock.Cpu_s());
    }
  }
  return least_s[1] / least_s[0];
}

/// Ceres as it would be called by hand: only the blocks wanted, no cross-covariances.
class CeresRoute {
 public:
  CeresRoute(const AdjustmentProblem& problem, const BlockState& state, int threads)
      : problem_(problem),
        state_(state),
        ceres_problem_(MakeCeresProblem(problem, {}, &state_)),
        threads_(threads) {}

  Covariances Run() {
    ceres::Covariance::Options options;
    options.algorithm_type = ceres::SPARSE_QR;
    options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
    options.num_threads = threads_;
    ceres::Covariance covariance(options);
    std::vector<const double*> wanted;
    for (const Eigen::Vector3d& d : state_.displacement_m) wanted.push_back(d.data());
    for (const ParameterBlock& block : problem_.layout.blocks) {
      wanted.push_back(state_.corrections.data() + block.offset);
    }
    std::vector<std::pair<const double*, const double*>> pairs;
    for (const double* block : wanted) pairs.emplace_back(block, block);
    if (!covariance.Compute(pairs, ceres_problem_.get())) throw std::runtime_error("ceres failed");
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    const auto get = [&covariance](const double* at, int size) {
      RowMajor block(size, size);
      covariance.GetCovarianceBlock(at, at, block.data());
      return block;
    };
    Covariances out;
    for (std::size_t j = 0; j < state_.displacement_m.size(); ++j) {
      const Eigen::Matrix3d block = get(state_.displacement_m[j].data(), 3);
      out.points.push_back(ToEnu(problem_.block.frame, state_.Position(j), block));
    }
    for (const ParameterBlock& block : problem_.layout.blocks) {
      out.passes.emplace_back(get(state_.corrections.data() + block.offset, block.size));
    }
    return out;
  }

 private:
  const AdjustmentProblem& problem_;
  BlockState state_;
  std::unique_ptr<ceres::Problem> ceres_problem_;
  int threads_;
};

void Compare(const std::string& scene_file, std::size_t points, std::size_t passes, int threads) {
  const ThreadLimit limit(threads);
  const StripsBlock strips = MakeStrips(scene_file, points, passes);
  const SimulatedBlock& simulated = strips.simulated;
  AdjustmentProblem problem(simulated.block, strips.options.groups);
  BlockState state;
  state.start_m = simulated.truth.points_m;
  state.displacement_m.assign(state.start_m.size(), {0.7, -0.3, 0.9});
  state.corrections.setConstant(problem.layout.size(), 0.13);
  UpdateWeights(state, &problem);

  // Each as often as it takes a second, seven times at most; the least counts.
  struct Least {
    double wall_s = std::numeric_limits<double>::infinity(), cpu_s = wall_s;
  };
  Covariances ours, ceres;
  Least ours_least, searched_least, ceres_least;
  const auto repeat = [](auto&& run, Covariances* out, Least* least) {
    const Clock all;
    for (int round = 0; round < 7 && (round == 0 || all.Wall_s() < 1.0); ++round) {
      const Clock clock;
      *out = run();
      least->wall_s = std::min(least->wall_s, clock.Wall_s());
      least->cpu_s = std::min(least->cpu_s, clock.Cpu_s());
    }
  };
  CeresRoute route(problem, state, threads);
  const auto ours_twice = [&] {
    repeat([&] { return Reduced(problem, state, RankBy::kSearch); }, &ours, &searched_least);
    repeat([&] { return Reduced(problem, state, RankBy::kPivots); }, &ours, &ours_least);
  };
  ours_twice();
  repeat([&] { return route.Run(); }, &ceres, &ceres_least);
  ours_twice();

  double point_difference = 0.0, pass_difference = 0.0;
  for (std::size_t j = 0; j < ours.points.size(); ++j) {
    const Eigen::Matrix3d expected = MatrixOf(ceres.points[j]);
    point_difference =
        std::max(point_difference, (MatrixOf(ours.points[j]) - expected).norm() / expected.norm());
  }
  for (std::size_t b = 0; b < ours.passes.size(); ++b) {
    const Eigen::MatrixXd mine = ours.passes[b].selfadjointView<Eigen::Lower>();
    pass_difference =
        std::max(pass_difference, (mine - ceres.passes[b]).norm() / ceres.passes[b].norm());
  }
  std::printf(
      "%zu,%zu,%zu,%d,%d,%.5f,%.5f,%.5f,%.5f,%.3f,%.3f,%.0f,%.0f,%.0f,%.0f,%.2e,%.2e,%.2f\n",
      simulated.block.points.size(),
      simulated.block.passes.size(),
      simulated.block.looks.size(),
      problem.layout.size(),
      threads,
      ours_least.wall_s,
      ours_least.cpu_s,
      searched_least.wall_s,
      searched_least.cpu_s,
      ceres_least.wall_s,
      ceres_least.cpu_s,
      ceres_least.wall_s / ours_least.wall_s,
      ceres_least.cpu_s / ours_least.cpu_s,
      ceres_least.wall_s / searched_least.wall_s,
      ceres_least.cpu_s / searched_least.cpu_s,
      point_difference,
      pass_difference,
      QualityRatio(problem, state));
}

}  // namespace
}  // namespace sarblock

int main(int count, char** arguments) {
  if (count != 5) {
    std::puts(
        "points,passes,looks,parameters,threads,ours_wall_s,ours_cpu_s,with_search_wall_s,"
        "with_search_cpu_s,ceres_wall_s,ceres_cpu_s,wall_ratio,cpu_ratio,wall_ratio_with_search,"
        "cpu_ratio_with_search,largest_point_difference,largest_pass_difference,"
        "sweep_with_quality_over_without");
    return 0;
  }
  sarblock::Compare(
      arguments[1], std::stoul(arguments[2]), std::stoul(arguments[3]), std::stoi(arguments[4]));
  return 0;
}
