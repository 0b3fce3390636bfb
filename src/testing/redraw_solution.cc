// SPDX-License-Identifier: Apache-2.0
#include "redraw_solution.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <cmath>

#include "core/threads.h"
#include "linear/dense.h"

namespace sarblock {
namespace {

constexpr std::size_t kRedrawnPerChunk = 512;
constexpr int kMostSteps = 30;
/// A step this small in metres along track moves no position that counts.
constexpr double kCloseEnough_m = 1e-7;

// Kinds of random streams.
constexpr std::uint64_t kLookKind = 101, kControlKind = 102, kPriorKind = 103;

std::uint64_t StreamOf(std::uint64_t run, std::uint64_t kind, std::uint64_t index) {
  return MixStream(MixStream(run, kind), index);
}

/// Time or Doppler and range at which a look has no error at the solution. The model predicts them
/// from where it reads the path, which is nearer at every step; it reads what was measured from
/// `block`, which it was made of.
void SolveLook(const AdjustmentProblem& problem,
               const BlockState& state,
               std::size_t point,
               std::size_t look,
               Block* block,
               ExactReadings* out) {
  LookColumns columns;
  LookEvaluation at;
  double& azimuth =
      block->MeasuresDoppler(look) ? block->looks.cone[look] : block->looks.time_s[look];
  for (int step = 0; step < kMostSteps; ++step) {
    if (!EvaluateLook(problem.model, state, point, look, {}, &columns, &at) || at.beyond_path) {
      break;
    }
    if (std::abs(at.error_1[1]) * at.azimuth_unit_m < kCloseEnough_m) {
      const LookSigma sigma = problem.model.SigmaOf(look);
      out->azimuth[look] = azimuth;
      out->range_m[look] = block->looks.range_m[look] + at.error_1[0];
      out->azimuth_sigma[look] = sigma.azimuth_unit == AzimuthUnit::kMetres
                                     ? sigma.azimuth / at.azimuth_unit_m
                                     : sigma.azimuth;
      return;
    }
    azimuth += at.error_1[1];
  }
  throw InputError("adjust.covariance",
                   "'montecarlo' cannot repeat the look of " +
                       std::string(block->points.ids[point]) + " in pass " +
                       block->passes[block->looks.pass[look]].id +
                       ": its noise-free time lies outside the path");
}

/// Noise of the held components of a known position with their covariance, east-north-up [m].
Eigen::Vector3d DrawKnown(const KnownPosition& known, RandomStream* random) {
  std::vector<Eigen::Index> held;
  for (std::size_t i = 0; i < 3; ++i) {
    if (known.held[i]) held.push_back(static_cast<Eigen::Index>(i));
  }
  Eigen::VectorXd normal(static_cast<Eigen::Index>(held.size()));
  for (double& value : normal) value = random->Normal();
  const Eigen::MatrixXd covariance = known.covariance_enu_m2(held, held);
  Eigen::Vector3d noise_m = Eigen::Vector3d::Zero();
  noise_m(held) = dense::Cholesky(covariance).L().triangularView<Eigen::Lower>() * normal;
  return noise_m;
}

}  // namespace

ExactReadings ReadExactly(const AdjustmentProblem& problem, const BlockState& state) {
  Block block = problem.block;
  AdjustmentProblem exact(block, problem);
  exact.model.ScaleSigmas(problem.model.sigma_factors());
  ExactReadings out;
  for (std::vector<double>* column : {&out.range_m, &out.azimuth, &out.azimuth_sigma}) {
    column->assign(block.looks.size(), kNotGiven);
  }
  const std::vector<std::uint64_t>& offsets = block.looks.offsets;
  ParallelForChunks(
      block.points.size(), kRedrawnPerChunk, [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t point = begin; point < end; ++point) {
          for (std::size_t i = offsets[point]; i < offsets[point + 1]; ++i) {
            if (problem.look_used[i] == 0) continue;
            SolveLook(exact, state, point, i, &block, &out);
          }
        }
      });
  return out;
}

void RedrawSolution(const AdjustmentProblem& problem,
                    const BlockState& state,
                    const ExactReadings& exact,
                    std::uint64_t seed,
                    std::uint64_t run,
                    Block* block,
                    std::vector<double>* prior_values) {
  for (std::size_t i = 0; i < problem.look_used.size(); ++i) {
    if (problem.look_used[i] == 0) continue;
    RandomStream random(seed, StreamOf(run, kLookKind, i));
    const double azimuth = exact.azimuth[i] + exact.azimuth_sigma[i] * random.Normal();
    (block->MeasuresDoppler(i) ? block->looks.cone : block->looks.time_s)[i] = azimuth;
    block->looks.range_m[i] = exact.range_m[i] + problem.model.SigmaOf(i).range_m * random.Normal();
  }
  for (const ControlEquations& control : problem.control) {
    if (!problem.Solves(control.point) || problem.control_of[control.point] < 0) continue;
    RandomStream random(seed, StreamOf(run, kControlKind, control.point));
    const Eigen::Vector3d p_m = state.Position(control.point);
    block->points.given_m[control.point] =
        p_m + block->frame.EnuFromFrame(p_m).transpose() *
                  DrawKnown(*block->points.FindKnown(control.point), &random);
  }
  prior_values->assign(problem.layout.parameters.size(), 0.0);
  for (std::size_t i = 0; i < prior_values->size(); ++i) {
    const Parameter& parameter = problem.layout.parameters[i];
    if (!parameter.has_own_prior()) continue;
    RandomStream random(seed, StreamOf(run, kPriorKind, i));
    (*prior_values)[i] =
        state.corrections[static_cast<Eigen::Index>(i)] + parameter.prior_sigma * random.Normal();
  }
  for (const JointPriorTerm& prior : problem.layout.joint_priors) {
    Eigen::VectorXd normal(prior.factor.rows());
    for (Eigen::Index k = 0; k < normal.size(); ++k) {
      const int parameter = prior.parameters[static_cast<std::size_t>(k)];
      const auto stream = static_cast<std::uint64_t>(parameter);
      normal[k] = RandomStream(seed, StreamOf(run, kPriorKind, stream)).Normal();
    }
    const Eigen::VectorXd drawn = state.corrections(prior.parameters) + prior.factor * normal;
    for (Eigen::Index k = 0; k < drawn.size(); ++k) {
      const int parameter = prior.parameters[static_cast<std::size_t>(k)];
      (*prior_values)[static_cast<std::size_t>(parameter)] = drawn[k];
    }
  }
}

}  // namespace sarblock
