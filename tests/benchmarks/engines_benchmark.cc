// SPDX-License-Identifier: Apache-2.0
// One iteration of the reduced engine against one of Ceres (SPARSE_SCHUR, SuiteSparse) on the same
// equations with the same analytic Jacobians, and the memory that each takes beside the block.
//   engines_benchmark SCENE.toml POINTS PASSES THREADS
// Prints rows of a CSV (header: engines_benchmark). Run by scripts/bench.sh engines.
//
// An iteration is the same for both: linearise, form and factor the reduced matrix, substitute
// back, evaluate the step. Ceres' is what its summary says of its own iterations, without its
// preprocessor; ours is the time between two reports of the solver, without the first
// linearisation. Neither contains the steps that finish Ceres' solution to a part of a sigma.
#include "sarblock/adjust/ceres_engine.h"
#include "sarblock/adjust/reduced_engine.h"
#include "sarblock/core/parallel.h"
#include "sarblock/io/adjust_table.h"
#include "sarblock/io/scene_file.h"
#include "sarblock/simulate/simulate.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include <ceres/solver.h>
#include <malloc.h>

namespace sarblock {
namespace {

using Clock = std::chrono::steady_clock;

double Since_s(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// A field of /proc/self/status, in bytes.
double Status_bytes(const std::string& field) {
  std::ifstream file("/proc/self/status");
  for (std::string word; file >> word;) {
    double kib = 0.0;
    if (word == field + ":" && file >> kib) return 1024.0 * kib;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

/// Largest resident memory since it was made, beyond what was resident then.
class PeakMemory {
 public:
  PeakMemory() {
    malloc_trim(0);
    std::ofstream("/proc/self/clear_refs") << "5";  // the peak begins anew
    before_ = Status_bytes("VmRSS");
  }
  [[nodiscard]] double Bytes() const { return Status_bytes("VmHWM") - before_; }

 private:
  double before_;
};

struct Run {
  int iterations = 0;
  double iteration_s = 0.0;  ///< the least
  double whole_s = 0.0;      ///< with everything that is set up once
  double bytes = 0.0;
  double cost_1 = 0.0;
};

/// Times between the reports of successive iterations.
class IterationTimes final : public ProgressSink {
 public:
  void Update(std::string_view, std::size_t done, std::size_t, std::string_view) override {
    if (done > done_) least_s_ = std::min(least_s_, Since_s(last_));
    done_ = done;
    last_ = Clock::now();
  }
  [[nodiscard]] bool Cancelled() const override { return false; }
  [[nodiscard]] double least_s() const { return least_s_; }

 private:
  std::size_t done_ = 0;
  Clock::time_point last_ = Clock::now();
  double least_s_ = std::numeric_limits<double>::infinity();
};

Run ByReduced(const AdjustmentProblem& problem, BlockState state, int threads) {
  SolveOptions options;
  options.threads = threads;
  const PeakMemory memory;
  const Clock::time_point begin = Clock::now();
  IterationTimes times;
  const SolveReport report = SolveReduced(problem, {}, options, &state, &times);
  return {report.iterations, times.least_s(), Since_s(begin), memory.Bytes(), report.final_cost_1};
}

Run ByCeres(const AdjustmentProblem& problem, BlockState state, int threads) {
  const PeakMemory memory;
  const Clock::time_point begin = Clock::now();
  const auto ceres_problem = MakeCeresProblem(problem, {}, &state);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_SCHUR;
  options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  options.num_threads = threads;
  options.logging_type = ceres::SILENT;
  auto* ordering = new ceres::ParameterBlockOrdering;
  for (Eigen::Vector3d& displacement_m : state.displacement_m) {
    ordering->AddElementToGroup(displacement_m.data(), 0);
  }
  for (const ParameterBlock& block : problem.layout.blocks) {
    ordering->AddElementToGroup(state.corrections.data() + block.offset, 1);
  }
  options.linear_solver_ordering.reset(ordering);
  ceres::Solver::Summary summary;
  ceres::Solve(options, ceres_problem.get(), &summary);
  Run run{summary.num_successful_steps,
          std::numeric_limits<double>::infinity(),
          Since_s(begin),
          memory.Bytes(),
          summary.final_cost};
  for (std::size_t i = 1; i < summary.iterations.size(); ++i) {
    run.iteration_s = std::min(run.iteration_s, summary.iterations[i].iteration_time_in_seconds);
  }
  return run;
}

void Print(const char* engine, const AdjustmentProblem& problem, int threads, const Run& run) {
  const auto looks = static_cast<double>(problem.block.looks.size());
  std::printf("%zu,%zu,%d,%s,%d,%.5f,%.4f,%.0f,%.12g\n",
              problem.block.points.size(),
              problem.block.looks.size(),
              threads,
              engine,
              run.iterations,
              run.iteration_s,
              run.whole_s,
              run.bytes / looks,
              run.cost_1);
  std::fflush(stdout);
}

void Compare(const std::string& scene_file, std::size_t points, std::size_t passes, int threads) {
  const ThreadLimit limit(threads);
  const std::size_t strips = passes / 2;  // of each side
  const std::string north = std::to_string(13000 + 4800 * (strips - 1) + 12000);
  const Scene scene = ReadScene(scene_file,
                                {"points.count=" + std::to_string(points),
                                 "flight.0.count=" + std::to_string(strips),
                                 "flight.1.count=" + std::to_string(strips),
                                 "points.north_m=[13000, " + north + "]"});
  const SimulatedBlock simulated = Simulate(scene);
  std::vector<std::string> ids;
  for (const Pass& pass : simulated.block.passes) ids.push_back(pass.id);
  const AdjustOptions options = ReadAdjustTable(scene.adjust_toml, scene.name, ids);
  AdjustmentProblem problem(simulated.block, options.groups);
  BlockState state;
  state.start_m = simulated.truth.points_m;
  state.displacement_m.assign(state.start_m.size(), {37.0, -23.0, 29.0});
  state.corrections.setZero(problem.layout.size());
  UpdateWhitening(state, &problem);
  for (int round = 0; round < 3; ++round) {
    Print("reduced", problem, threads, ByReduced(problem, state, threads));
    Print("ceres", problem, threads, ByCeres(problem, state, threads));
  }
}

}  // namespace
}  // namespace sarblock

int main(int count, char** arguments) {
  if (count != 5) {
    std::puts("points,looks,threads,engine,iterations,iteration_s,whole_s,bytes_a_look,cost");
    return 0;
  }
  sarblock::Compare(
      arguments[1], std::stoul(arguments[2]), std::stoul(arguments[3]), std::stoi(arguments[4]));
  return 0;
}
