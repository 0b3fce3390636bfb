// SPDX-License-Identifier: Apache-2.0
#include "start.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/geometry/intersection.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/threads.h"
#include "linear/dense.h"

namespace sarblock {
namespace {

constexpr std::size_t kPointsPerChunk = 512;
/// Points follow the paths as soon as these move: where they start need be no more exact than this
/// part of a standard deviation.
constexpr double kStartSettled = 0.1;

/// What one point starts with.
struct PointStart {
  PointStatus status = PointStatus::kAdjusted;
  IntersectionOutcome outcome = IntersectionOutcome::kDetermined;  ///< of kUndetermined
  Eigen::Vector3d position_m = Eigen::Vector3d::Constant(kNotGiven);
};

PointStart Refuse(PointStatus status,
                  IntersectionOutcome outcome = IntersectionOutcome::kTooFewLooks) {
  PointStart out;
  out.status = status;
  out.outcome = outcome;
  return out;
}

/// Why a point without a start has none.
std::string ReasonOf(const PointStart& start) {
  switch (start.status) {
    case PointStatus::kNotSeen:
      return "no look of it takes part";
    case PointStatus::kTooFewLooks:
      return "one look and no control: 2 equations, 3 unknowns";
    default:
      return Explain(start.outcome);
  }
}

PointStart StartOf(const AdjustmentProblem& problem,
                   std::size_t point,
                   const std::vector<FixedPathLook>& observations,
                   const IntersectionOptions& intersection) {
  const Block& block = problem.block;
  const ControlEquations* control =
      problem.control_of[point] < 0
          ? nullptr
          : &problem.control[static_cast<std::size_t>(problem.control_of[point])];
  const int control_rows = control == nullptr ? 0 : control->rows;
  if (observations.empty()) return Refuse(PointStatus::kNotSeen);
  if (2 * static_cast<int>(observations.size()) + control_rows < 3) {
    return Refuse(PointStatus::kTooFewLooks);
  }
  PointStart out;
  const Eigen::Vector3d& given_m = block.points.given_m[point];
  // A check point's coordinates are withheld, its start values too.
  if (given_m.allFinite() && block.points.role[point] != PointRole::kCheck) {
    const auto sees = [&](const FixedPathLook& observation) {
      return LiesWhereItLooks(block.frame, observation, given_m);
    };
    if (control != nullptr || std::all_of(observations.begin(), observations.end(), sees)) {
      out.position_m = given_m;
      return out;
    }
  }
  const Intersection met = Intersect(observations, block.frame, intersection);
  // Flight-path errors may keep circles apart that the adjustment brings together: a compromise is
  // good enough to start from.
  if (met.outcome == IntersectionOutcome::kDetermined ||
      met.outcome == IntersectionOutcome::kCirclesDoNotMeet ||
      met.outcome == IntersectionOutcome::kNotConverged) {
    out.position_m = met.position_m;
    return out;
  }
  return Refuse(PointStatus::kUndetermined, met.outcome);
}

/// Refuses passes whose states contradict each other so much that between them the Doppler cone
/// passes over a point several times: no time of such a look means anything.
void RequireSteadyCones(const AdjustmentProblem& problem) {
  for (std::size_t pass = 0; pass < problem.block.passes.size(); ++pass) {
    const ConeTurning& turning = problem.model.paths()[pass].turning();
    if (!(turning.median > ConeTurning::kFolding)) continue;
    std::array<char, 640> text{};
    std::snprintf(
        text.data(),
        text.size(),
        "the flight path is too noisy to be read at %.4g km: in %zu of %zu intervals "
        "between its states the path turns the Doppler cone back over points it has "
        "passed, since positions and velocities contradict each other (median %.2g of the "
        "cone's own rate, at most %.2g is allowed); set through = \"smooth\" or \"auto\" in its "
        "trajectory, smooth the states, or give states farther apart",
        1e-3 * turning.range_m,
        turning.folded,
        turning.pieces,
        turning.median,
        ConeTurning::kFolding);
    throw InputError("pass " + problem.block.passes[pass].id, text.data());
  }
}

}  // namespace

StartReport ComputeStartValues(AdjustmentProblem* problem, ProgressSink* progress, int max_steps) {
  const IntersectionOptions intersection{
      .max_iterations = max_steps, .settled_sigmas = kStartSettled, .with_covariance = false};
  const Block& block = problem->block;
  RequireSteadyCones(*problem);
  const std::size_t points = block.points.size();
  StartReport report;
  report.state.start_m.assign(points, Eigen::Vector3d::Constant(kNotGiven));
  report.state.displacement_m.assign(points, Eigen::Vector3d::Zero());
  report.state.corrections = Eigen::VectorXd::Zero(problem->layout.size());
  // Points and looks are left out after the loop, whose chunks several ranks divide.
  std::vector<PointStart> starts(points);
  std::vector<std::uint8_t> lost(block.looks.size(), 0);
  const auto start = [&](std::size_t, std::size_t begin, std::size_t end) {
    std::vector<FixedPathLook> observations;
    for (std::size_t point = begin; point < end; ++point) {
      observations.clear();
      for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
        if (problem->look_used[i] == 0) continue;
        const std::optional<FixedPathLook> observation =
            problem->model.FixPath(i, report.state.corrections);
        if (observation) {
          observations.push_back(*observation);
        } else {
          lost[i] = 1;
        }
      }
      starts[point] = StartOf(*problem, point, observations, intersection);
    }
  };
  Step(progress, "start values", 0, points);
  ForChunksOfRanks(points,
                   kPointsPerChunk,
                   {SharedArray::ByItem(&starts), SharedArray::ByRange(block.looks.offsets, &lost)},
                   start);
  for (std::size_t i = 0; i < lost.size(); ++i) {
    if (lost[i] == 0) continue;
    report.looks_not_evaluated.push_back(i);
    problem->look_used[i] = 0;
  }
  for (std::size_t point = 0; point < points; ++point) {
    if (IsSolved(starts[point].status)) {
      report.state.start_m[point] = starts[point].position_m;
    } else {
      problem->LeaveOut(point, starts[point].status, ReasonOf(starts[point]));
    }
  }
  UpdateWeights(report.state, problem);
  Step(progress, "start values", points, points);
  return report;
}

namespace {

constexpr double kMaxLost = 1.0 / 3.0;
constexpr std::size_t kMinLooks = 4;
constexpr double kFinalScale = 2.385;  // Cauchy
constexpr double kShrink = 1.5;
constexpr int kMaxIterations = 60;
/// Part of its misfit that a pass keeps at most where it is moved.
constexpr double kBetter = 0.5;

struct PointLook {
  std::size_t point = 0, look = 0;
};

/// By pass: its looks of points that others determine, of passes that lost too many.
std::vector<std::vector<PointLook>> LooksToResect(const AdjustmentProblem& problem) {
  const Block& block = problem.block;
  std::vector<std::size_t> given(block.passes.size(), 0), used(block.passes.size(), 0);
  std::vector<std::vector<PointLook>> looks(block.passes.size());
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      if (block.looks.rejected(i)) continue;
      const std::uint32_t pass = block.looks.pass[i];
      ++given[pass];
      used[pass] += problem.look_used[i];
      const int others = problem.CountLooks(point) - static_cast<int>(problem.look_used[i]);
      if (problem.Solves(point) && (others >= 2 || problem.control_of[point] >= 0)) {
        looks[pass].push_back({point, i});
      }
    }
  }
  for (std::size_t pass = 0; pass < looks.size(); ++pass) {
    const double least = (1.0 - kMaxLost) * static_cast<double>(given[pass]);
    if (static_cast<double>(used[pass]) >= least || looks[pass].size() < kMinLooks) {
      looks[pass].clear();
    }
  }
  return looks;
}

class Resection {
 public:
  Resection(const AdjustmentProblem& problem, const std::vector<PointLook>& looks)
      : problem_(problem), looks_(looks), local_(problem.layout.parameters.size(), -1) {
    LookColumns columns;
    for (const PointLook& of : looks) {
      problem.model.ColumnsOf(of.look, &columns);
      for (int b = 0; b < columns.block_count; ++b) {
        const ParameterBlock& block =
            problem.layout
                .blocks[static_cast<std::size_t>(columns.block[static_cast<std::size_t>(b)])];
        for (int k = 0; k < block.size && !block.shared; ++k) {
          int& local = local_[static_cast<std::size_t>(block.offset + k)];
          if (local >= 0) continue;
          local = static_cast<int>(parameters_.size());
          parameters_.push_back(static_cast<std::size_t>(block.offset + k));
        }
      }
    }
  }

  /// False where the pass has no corrections or is not determined.
  [[nodiscard]] bool Solve(BlockState* state) {
    if (parameters_.empty()) return false;
    for (const std::size_t i : parameters_) {
      state->corrections[static_cast<Eigen::Index>(i)] = problem_.layout.parameters[i].prior_value;
    }
    const double misfit = Misfit(*state);
    if (!std::isfinite(misfit)) return false;
    double scale = std::max(kFinalScale, 2.0 * misfit);
    for (int i = 0; i < kMaxIterations; ++i) {
      if (!Improve(scale, state)) return false;
      if (scale == kFinalScale && i > 10) break;
      scale = std::max(kFinalScale, scale / kShrink);
    }
    return true;
  }

  /// Median whitened length of the looks; points of thin intersections are not known to a sigma.
  [[nodiscard]] double Misfit(const BlockState& state) const {
    std::vector<double> lengths = LengthsOf(state);
    if (lengths.empty()) return std::numeric_limits<double>::infinity();
    return MedianInPlace(&lengths);
  }

 private:
  [[nodiscard]] bool Evaluate(const BlockState& state,
                              const PointLook& of,
                              LookColumns* columns,
                              LookEvaluation* at) const {
    if (!EvaluateLook(problem_.model, state, of.point, of.look, {}, columns, at)) return false;
    at->Scale(WeightsAt(problem_.model.SigmaOf(of.look), at->azimuth_unit_m),
              columns->column_count);
    return true;
  }

  [[nodiscard]] std::vector<double> LengthsOf(const BlockState& state) const {
    std::vector<double> lengths;
    LookColumns columns;
    LookEvaluation at;
    for (const PointLook& of : looks_) {
      if (Evaluate(state, of, &columns, &at)) lengths.push_back(at.whitened_error.norm());
    }
    return lengths;
  }

  /// The equation of the process that leads to parameter `index`, between coefficients that looks
  /// ask for.
  void AddStep(std::size_t index,
               double scale,
               const BlockState& state,
               Eigen::MatrixXd* normal,
               Eigen::VectorXd* gradient) const {
    const Parameter& parameter = problem_.layout.parameters[index];
    const int to = local_[index], from = local_[static_cast<std::size_t>(parameter.before)];
    const double sigma =
        kFinalScale / scale * (from < 0 ? parameter.prior_sigma : parameter.step_sigma);
    const double weight = 1.0 / (sigma * sigma);
    const double x =
        from < 0 ? state.corrections[static_cast<Eigen::Index>(index)] - parameter.prior_value
                 : problem_.layout.StepOf(index, state.corrections);
    (*normal)(to, to) += weight;
    (*gradient)[to] += weight * x;
    if (from < 0) return;
    const double carried = parameter.carried;
    (*normal)(from, from) += weight * carried * carried;
    (*normal)(to, from) -= weight * carried;
    (*normal)(from, to) -= weight * carried;
    (*gradient)[from] -= weight * carried * x;
  }

  /// One reweighted Gauss-Newton step of the pass's own corrections.
  [[nodiscard]] bool Improve(double scale, BlockState* state) const {
    const auto size = static_cast<Eigen::Index>(parameters_.size());
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(size, size);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(size);
    for (Eigen::Index i = 0; i < size; ++i) {
      const std::size_t index = parameters_[static_cast<std::size_t>(i)];
      const Parameter& parameter = problem_.layout.parameters[index];
      if (parameter.before >= 0) AddStep(index, scale, *state, &normal, &gradient);
      if (!parameter.has_own_prior()) continue;
      // Looks count as less accurate while the scale is large, and so does what contradicts them.
      const double sigma = parameter.prior_sigma * kFinalScale / scale;
      const double weight = 1.0 / (sigma * sigma);
      normal(i, i) += weight;
      gradient[i] +=
          weight * (state->corrections[static_cast<Eigen::Index>(index)] - parameter.prior_value);
    }
    for (const JointPriorTerm& prior : problem_.layout.joint_priors) {
      std::vector<int> at;
      for (const int parameter : prior.parameters) {
        at.push_back(local_[static_cast<std::size_t>(parameter)]);
      }
      if (at.front() < 0) continue;  // of another pass
      const double factor = scale / kFinalScale;
      const Eigen::MatrixXd information = factor * factor * prior.information;
      normal(at, at) += information;
      gradient(at) += information * problem_.layout.FromPrior(prior, state->corrections);
    }
    LookColumns columns;
    LookEvaluation at;
    Eigen::VectorXd row(size);
    for (const PointLook& of : looks_) {
      if (!Evaluate(*state, of, &columns, &at)) continue;
      const double weight = 1.0 / (1.0 + at.whitened_error.squaredNorm() / (scale * scale));
      for (std::size_t measured = 0; measured < 2; ++measured) {
        row.setZero();
        std::size_t column = 0;
        for (int b = 0; b < columns.block_count; ++b) {
          const ParameterBlock& block =
              problem_.layout
                  .blocks[static_cast<std::size_t>(columns.block[static_cast<std::size_t>(b)])];
          for (int k = 0; k < block.size; ++k, ++column) {
            const int local = local_[static_cast<std::size_t>(block.offset + k)];
            if (local >= 0) row[local] = at.row[measured][column];
          }
        }
        normal += weight * row * row.transpose();
        gradient += weight * at.whitened_error[static_cast<Eigen::Index>(measured)] * row;
      }
    }
    const dense::PivotedCholesky factor(normal);
    if (!factor.positive_semidefinite()) return false;
    const Eigen::VectorXd step = factor.Solve(gradient);
    if (!step.allFinite()) return false;
    for (Eigen::Index i = 0; i < size; ++i) {
      state->corrections[static_cast<Eigen::Index>(parameters_[static_cast<std::size_t>(i)])] -=
          step[i];
    }
    return true;
  }

  const AdjustmentProblem& problem_;
  const std::vector<PointLook>& looks_;
  std::vector<int> local_;               // by parameter: place among those of the pass, or -1
  std::vector<std::size_t> parameters_;  // of the pass
};

}  // namespace

bool RelocatePasses(const AdjustmentProblem& problem, BlockState* state) {
  bool moved = false;
  for (const std::vector<PointLook>& looks : LooksToResect(problem)) {
    if (looks.empty()) continue;
    Resection resection(problem, looks);
    const double misfit = resection.Misfit(*state);
    const Eigen::VectorXd before = state->corrections;
    if (resection.Solve(state) && resection.Misfit(*state) < kBetter * misfit) {
      moved = true;
    } else {
      state->corrections = before;
    }
  }
  return moved;
}

}  // namespace sarblock
