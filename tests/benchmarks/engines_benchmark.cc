// SPDX-License-Identifier: Apache-2.0
// One iteration of the reduced engine against one of Ceres (SPARSE_SCHUR, SuiteSparse) on the same
// equations with the same analytic Jacobians, and the memory that each takes beside the block.
//   engines_benchmark SCENE.toml POINTS PASSES THREADS
// Prints rows of a CSV (header: engines_benchmark). Run by scripts/bench.sh engines.
//
// An iteration is the same for both: linearise, form and factor the reduced matrix, substitute
// back, evaluate the step. It is the time between two reports of the solver, without what comes
// before the first one (preprocessing, the first linearisation); the fastest counts. Neither
// contains the steps that finish Ceres' solution to a part of a sigma.
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "core/threads.h"
#include "solve/ceres_engine.h"
#include "solve/reduced_engine.h"
#include "strips_block.h"
#include <ceres/iteration_callback.h>
#include <ceres/solver.h>
#include <malloc.h>

namespace sarblock {
namespace {

/// Wall time and CPU time of all threads.
struct Moment {
  double wall_s = 0.0, cpu_s = 0.0;
};

Moment Now() {
  timespec cpu{}, wall{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &cpu);
  clock_gettime(CLOCK_MONOTONIC, &wall);
  const auto seconds = [](const timespec& t) {
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  };
  return {seconds(wall), seconds(cpu)};
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
  Moment iteration;      ///< the least
  double whole_s = 0.0;  ///< wall, with everything that is set up once
  double bytes = 0.0;
  double cost = 0.0;
};

/// The least time between reports of successive iterations, of either engine.
class IterationTimes final : public ProgressSink, public ceres::IterationCallback {
 public:
  void Update(std::string_view, std::size_t done, std::size_t, std::string_view) override {
    Report(done);
  }
  [[nodiscard]] bool Cancelled() const override { return false; }
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    Report(static_cast<std::size_t>(summary.iteration));
    return ceres::SOLVER_CONTINUE;
  }
  [[nodiscard]] const Moment& least() const { return least_; }

 private:
  void Report(std::size_t done) {
    const Moment now = Now();
    if (done > done_) {
      least_.wall_s = std::min(least_.wall_s, now.wall_s - last_.wall_s);
      least_.cpu_s = std::min(least_.cpu_s, now.cpu_s - last_.cpu_s);
    }
    done_ = done;
    last_ = Now();
  }
  std::size_t done_ = 0;
  Moment last_;
  Moment least_{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
};

Run SolveByReduced(const AdjustmentProblem& problem, BlockState state, int threads) {
  SolveOptions options;
  options.threads = threads;
  const PeakMemory memory;
  const Moment begin = Now();
  IterationTimes times;
  const SolveReport report = SolveReduced(problem, {}, options, &state, &times);
  return {report.iterations,
          times.least(),
          Now().wall_s - begin.wall_s,
          memory.Bytes(),
          report.final_cost};
}

Run SolveByCeres(const AdjustmentProblem& problem, BlockState state, int threads) {
  const PeakMemory memory;
  const Moment begin = Now();
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
  IterationTimes times;
  options.callbacks.push_back(&times);
  ceres::Solver::Summary summary;
  ceres::Solve(options, ceres_problem.get(), &summary);
  return {summary.num_successful_steps,
          times.least(),
          Now().wall_s - begin.wall_s,
          memory.Bytes(),
          summary.final_cost};
}

void Print(const char* engine, const AdjustmentProblem& problem, int threads, const Run& run) {
  const auto looks = static_cast<double>(problem.block.looks.size());
  std::printf("%zu,%zu,%d,%s,%d,%.5f,%.5f,%.4f,%.0f,%.12g\n",
              problem.block.points.size(),
              problem.block.looks.size(),
              threads,
              engine,
              run.iterations,
              run.iteration.wall_s,
              run.iteration.cpu_s,
              run.whole_s,
              run.bytes / looks,
              run.cost);
  std::fflush(stdout);
}

void Compare(const std::string& scene_file, std::size_t points, std::size_t passes, int threads) {
  const ThreadLimit limit(threads);
  const StripsBlock strips = MakeStrips(scene_file, points, passes);
  const SimulatedBlock& simulated = strips.simulated;
  AdjustmentProblem problem(simulated.block, strips.options.groups);
  BlockState state;
  state.start_m = simulated.truth.points_m;
  state.displacement_m.assign(state.start_m.size(), {37.0, -23.0, 29.0});
  state.corrections.setZero(problem.layout.size());
  UpdateWeights(state, &problem);
  for (int round = 0; round < 3; ++round) {
    Print("reduced", problem, threads, SolveByReduced(problem, state, threads));
    Print("ceres", problem, threads, SolveByCeres(problem, state, threads));
  }
}

}  // namespace
}  // namespace sarblock

int main(int count, char** arguments) {
  if (count != 5) {
    std::puts(
        "points,looks,threads,engine,iterations,iteration_wall_s,iteration_cpu_s,whole_s,bytes_a_"
        "look,cost");
    return 0;
  }
  sarblock::Compare(
      arguments[1], std::stoul(arguments[2]), std::stoul(arguments[3]), std::stoi(arguments[4]));
  return 0;
}
