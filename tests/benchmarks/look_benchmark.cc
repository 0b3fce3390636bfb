// SPDX-License-Identifier: Apache-2.0
// Time of the parts of an iteration for each look of a block, one thread, at its start values: the
// least of many short repetitions, so that other work on the machine hardly counts. `cost_ns` is
// one Evaluate() of a public cost function with all its Jacobians.
//
//     look_benchmark BLOCK...
#include "sarblock/cost/look_cost.h"
#include "sarblock/files/block_file.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <limits>
#include <memory>
#include <vector>

#include "core/threads.h"
#include "model/problem.h"
#include "normals/back.h"
#include "normals/reduced_system.h"
#include "solve/start.h"

namespace sarblock {
namespace {

/// Least time of `repetitions` calls, in nanoseconds a look.
template <typename F>
double LeastTime_ns(int repetitions, std::size_t looks, F&& f) {
  double least_s = std::numeric_limits<double>::infinity();
  for (int i = 0; i < repetitions; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    f();
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - begin;
    least_s = std::min(least_s, time.count());
  }
  return 1e9 * least_s / static_cast<double>(looks);
}

/// Time of RangeDopplerCost() for the looks of the first points, corrections 0, on flights with one
/// block for each group of corrections.
double CostTime_ns(const AdjustmentProblem& problem, const BlockState& state, std::size_t points) {
  const Block& block = problem.block;
  std::vector<FlightCorrection> corrections;
  for (const CorrectionGroup& group : problem.groups) corrections.push_back({group.model, {}});
  std::vector<FlightPointer> flights;
  for (std::size_t pass = 0; pass < block.passes.size(); ++pass) {
    flights.push_back(std::make_shared<CorrectedFlight>(block, pass, corrections));
  }
  std::vector<double> zero(100000, 0.0);
  const std::vector<double*> arrays(corrections.size(), zero.data());
  struct Made {
    CostPointer cost;
    std::vector<double*> blocks;
  };
  std::vector<Made> made;
  std::vector<Eigen::Vector3d> displacements_m = state.displacement_m;
  for (std::size_t point = 0; point < points; ++point) {
    if (!problem.Solves(point)) continue;
    for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      const FlightPointer& flight = flights[block.looks.pass[i]];
      const LookMeasurement look = MeasurementOf(block, i, *flight, state.Position(point));
      made.push_back({RangeDopplerCost(flight, look, state.start_m[point]),
                      flight->Blocks(displacements_m[point].data(), arrays, look.time_s)});
    }
  }
  std::vector<double> memory(2 * ParameterLayout::kMaxLocalColumns);
  double sum = 0.0;
  const double time_ns = LeastTime_ns(200, made.size(), [&] {
    std::vector<double*> jacobians(40);
    for (const Made& look : made) {
      double* next = memory.data();
      const std::vector<int>& sizes = look.cost->parameter_block_sizes();
      for (std::size_t b = 0; b < sizes.size(); ++b, next += 2 * sizes[b - 1]) jacobians[b] = next;
      std::array<double, 2> residuals;
      if (look.cost->Evaluate(look.blocks.data(), residuals.data(), jacobians.data())) {
        sum += residuals[0];
      }
    }
  });
  return sum == 0.0 ? 0.0 : time_ns;
}

void Measure(const char* folder) {
  const files::BlockFile file = files::ReadBlock(folder);
  const Block& block = file.block;
  AdjustmentProblem problem(block, file.adjust.groups, {});
  const BlockState state = ComputeStartValues(&problem, nullptr).state;
  const std::size_t points = std::min<std::size_t>(block.points.size(), 4000);
  const std::size_t some = block.looks.offsets[points], all = block.looks.size();
  LookColumns columns;
  LookEvaluation look;
  double sum = 0.0;
  const double evaluate_ns = LeastTime_ns(200, some, [&] {
    for (std::size_t point = 0; point < points; ++point) {
      if (!problem.Solves(point)) continue;
      for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
        if (EvaluateLook(problem.model, state, point, i, problem.weights[i], &columns, &look)) {
          sum += look.whitened_error[0];
        }
      }
    }
  });
  ReducedSystem system(problem);
  const int repetitions = 20;
  const double form_ns = LeastTime_ns(repetitions, all, [&] { system.Form(state, {}, nullptr); });
  const Eigen::VectorXd dx = Eigen::VectorXd::Zero(problem.layout.size());
  const double back_ns = LeastTime_ns(repetitions, all, [&] {
    sum += SubstituteBack(problem, state, {}, 0.0, dx).predicted_decrease;
  });
  std::printf("%s,%zu,%.0f,%.0f,%.0f,%.0f%s\n",
              folder,
              all,
              evaluate_ns,
              CostTime_ns(problem, state, points),
              form_ns,
              back_ns,
              sum == 0.0 ? "," : "");
}

}  // namespace
}  // namespace sarblock

int main(int argc, char** argv) {
  const sarblock::ThreadLimit limit(1);
  std::printf("block,looks,evaluate_ns,cost_ns,form_ns,substitute_back_ns\n");
  for (int i = 1; i < argc; ++i) sarblock::Measure(argv[i]);
  return 0;
}
