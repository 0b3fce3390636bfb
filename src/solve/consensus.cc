// SPDX-License-Identifier: Apache-2.0
#include "consensus.h"

#include "sarblock/core/statistics.h"
#include "sarblock/geometry/intersection.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/threads.h"
#include "determinacy/connectivity.h"
#include "ground_consensus.h"
#include "normals/point.h"
#include "pass_looks.h"
#include "point_consensus.h"
#include "reduced_engine.h"
#include "relocate_passes.h"

namespace sarblock {
namespace {

constexpr std::size_t kJudgedPerChunk = 256;
/// Of Cauchy's loss at the end: 95 percent efficient at the normal distribution.
constexpr double kLastScale_1 = 2.385;
/// From one scale of the graduated loss to the next.
constexpr double kScaleStep_1 = 3.0;
constexpr int kMostStepsOfScale = 12, kMostLastSteps = 40;
constexpr int kMostJudgements = 8;
/// Looks of a control point this far (squared) from where it is known to be are left out.
constexpr double kFar_1 = 0.999;
constexpr double kMostOfPass_1 = 0.5;

/// Takes everything in again that has equations enough.
void TakeAll(AdjustmentProblem* problem) {
  const Block& block = problem->block;
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(problem->layout.size());
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    const PointStatus status = problem->point_status[point];
    if (status == PointStatus::kNotSeen || status == PointStatus::kTooFewLooks) continue;
    std::vector<std::size_t> looks;
    for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      problem->look_used[i] = 0;
      if (!block.looks.rejected(i) && problem->model.SightOf(i, none)) looks.push_back(i);
    }
    problem->TakeBack(point, looks);
  }
}

/// The median height of the control, else of the start positions, else of the ellipsoid.
double ReferenceHeight_m(const AdjustmentProblem& problem, const BlockState& state) {
  std::vector<double> heights_m;
  for (const ControlEquations& control : problem.control) {
    heights_m.push_back(problem.block.frame.VerticalAt(control.known_m).height_m);
  }
  if (heights_m.empty()) {
    for (const Eigen::Vector3d& start_m : state.start_m) {
      if (start_m.allFinite()) {
        heights_m.push_back(problem.block.frame.VerticalAt(start_m).height_m);
      }
    }
  }
  const double median_m = MedianInPlace(&heights_m);
  return std::isfinite(median_m) ? median_m : 0.0;
}

/// Points start on the ground, at the mean of the places of their looks that agree; what agrees
/// takes part. False where nothing is left.
void StartOnGround(const GroundConsensus& ground, AdjustmentProblem* problem, BlockState* state) {
  const Block& block = problem->block;
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    if (!problem->Solves(point)) continue;
    const bool known = problem->control_of[point] >= 0 && block.points.given_m[point].allFinite();
    Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
    int used = 0;
    for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      if (problem->look_used[i] == 0) continue;
      if (ground.agrees[i] == 0 || !ground.place_m[i].allFinite()) {
        problem->look_used[i] = 0;
        continue;
      }
      sum_m += ground.place_m[i];
      ++used;
    }
    state->displacement_m[point].setZero();
    if (known) {
      state->start_m[point] = block.points.given_m[point];
    } else if (used >= 2) {
      state->start_m[point] = sum_m / used;
    } else {
      problem->LeaveOut(point, PointStatus::kUndetermined, "");
    }
  }
}

/// Whitened lengths of all looks in use.
std::vector<double> LengthsOf(const AdjustmentProblem& problem, const BlockState& state) {
  std::vector<double> lengths;
  WhitenedLook at;
  const auto& offsets = problem.block.looks.offsets;
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (!problem.Solves(point)) continue;
    for (std::size_t i = offsets[point]; i < offsets[point + 1]; ++i) {
      if (problem.look_used[i] == 0) continue;
      if (EvaluateWhitened(problem, state, {}, point, i, &at)) {
        lengths.push_back(at.error_1.norm());
      }
    }
  }
  return lengths;
}

int SolveAt(double scale_1,
            int most_steps,
            const AdjustOptions& options,
            AdjustmentProblem* problem,
            BlockState* state,
            ProgressSink* progress) {
  SolveOptions solve;
  solve.max_iterations = most_steps;
  solve.threads = options.threads;
  solve.settled_1 = 0.1;
  Weighting weighting{RobustLoss::kCauchy, scale_1};
  weighting.renewed = &problem->weights;
  return SolveReduced(*problem, weighting, solve, state, progress).iterations;
}

/// Priors of a problem as long as looks count as so many times less accurate than they are: what is
/// believed of a look is then no more than what is believed of a path.
class TemperedPriors {
 public:
  explicit TemperedPriors(AdjustmentProblem* problem)
      : parameters_(problem->layout.parameters),
        joint_(problem->layout.joint_priors),
        given_(joint_) {
    for (const Parameter& parameter : parameters_) sigma_.push_back(parameter.prior_sigma);
  }
  ~TemperedPriors() { Divide(1.0); }
  TemperedPriors(const TemperedPriors&) = delete;
  TemperedPriors& operator=(const TemperedPriors&) = delete;
  void Divide(double factor_1) {
    for (std::size_t i = 0; i < sigma_.size(); ++i) {
      parameters_[i].prior_sigma = sigma_[i] / factor_1;
    }
    for (std::size_t i = 0; i < joint_.size(); ++i) {
      joint_[i] = given_[i];
      if (factor_1 != 1.0) joint_[i].Set(given_[i].covariance / (factor_1 * factor_1));
    }
  }

 private:
  std::vector<Parameter>& parameters_;
  std::vector<JointPriorTerm>& joint_;
  std::vector<JointPriorTerm> given_;
  std::vector<PriorSigma> sigma_;
};

/// Graduated non-convexity: from a scale at which every look that agrees on the ground counts.
int SolveGraduated(const AdjustOptions& options,
                   AdjustmentProblem* problem,
                   BlockState* state,
                   ProgressSink* progress) {
  std::vector<double> lengths = LengthsOf(*problem, *state);
  double scale_1 = std::max(kLastScale_1, 2.0 * MedianInPlace(&lengths));
  int iterations = 0;
  TemperedPriors priors(problem);
  for (; scale_1 > kLastScale_1; scale_1 /= kScaleStep_1) {
    priors.Divide(scale_1 / kLastScale_1);
    iterations += SolveAt(scale_1, kMostStepsOfScale, options, problem, state, progress);
  }
  priors.Divide(1.0);
  return iterations + SolveAt(kLastScale_1, kMostLastSteps, options, problem, state, progress);
}

/// How much more than noise keeps the circles of all points apart: the lower quartile of v'Pv over
/// its expectation, which gross errors leave alone, 1 at least.
double VarianceOf(const AdjustmentProblem& problem, const BlockState& state) {
  const Block& block = problem.block;
  std::vector<double> ratios(block.points.size(), kNotGiven);
  ParallelForChunks(
      block.points.size(), kJudgedPerChunk, [&](std::size_t, std::size_t begin, std::size_t end) {
        std::vector<Sight> sights;
        for (std::size_t point = begin; point < end; ++point) {
          if (!problem.Solves(point)) continue;
          sights.clear();
          for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1];
               ++i) {
            if (problem.look_used[i] == 0) continue;
            const auto sight = problem.model.SightOf(i, state.corrections);
            if (sight) sights.push_back(*sight);
          }
          if (sights.size() < 2) continue;
          const double freedom_1 = 2.0 * static_cast<double>(sights.size()) - 3.0;
          ratios[point] = Intersect(sights, block.frame).weighted_square_sum /
                          ChiSquareQuantile(0.25, freedom_1);
        }
      });
  std::vector<double> finite;
  for (const double ratio : ratios) {
    if (std::isfinite(ratio)) finite.push_back(ratio);
  }
  if (finite.empty()) return 1.0;
  const auto quarter = finite.begin() + static_cast<std::ptrdiff_t>(finite.size() / 4);
  std::nth_element(finite.begin(), quarter, finite.end());
  return std::max(1.0, *quarter);
}

/// Of a control point whose looks contradict each other those near its known position; all where
/// none or every one is. Looks that agree are not judged by the known position, which may be wrong
/// itself: the search for blunders compares them.
PointConsensus ConsensusOfControl(const AdjustmentProblem& problem,
                                  const BlockState& state,
                                  std::size_t point,
                                  double variance_1) {
  const Block& block = problem.block;
  const double limit = variance_1 * ChiSquareQuantile(kFar_1, 2.0);
  PointConsensus out = FindPointConsensus(problem, state, point, variance_1);
  if (out.outcome == PointConsensus::Outcome::kAgree ||
      out.outcome == PointConsensus::Outcome::kMajority) {
    return out;
  }
  out.position_m = state.Position(point);
  out.looks.clear();
  std::vector<std::size_t> all;
  WhitenedLook at;
  for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
    if (block.looks.rejected(i) || !problem.model.SightOf(i, state.corrections)) continue;
    all.push_back(i);
    if (EvaluateWhitened(problem, state, {}, point, i, &at) && at.error_1.squaredNorm() <= limit) {
      out.looks.push_back(i);
    }
  }
  const bool every = out.looks.empty() || out.looks.size() == all.size();
  out.outcome = every ? PointConsensus::Outcome::kAgree : PointConsensus::Outcome::kMajority;
  if (every) out.looks = std::move(all);
  return out;
}

/// Every point and look is judged again on the paths of the state and takes part accordingly;
/// true where that changed anything.
bool JudgePoints(AdjustmentProblem* problem, BlockState* state, ConsensusReport* report) {
  const Block& block = problem->block;
  const double variance_1 = VarianceOf(*problem, *state);
  const std::size_t points = block.points.size();
  std::vector<PointConsensus> found(points);
  const auto takes_part = [&](std::size_t point) {
    const PointStatus status = problem->point_status[point];
    return status != PointStatus::kNotSeen && status != PointStatus::kTooFewLooks;
  };
  ParallelForChunks(points, kJudgedPerChunk, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t point = begin; point < end; ++point) {
      if (!takes_part(point)) continue;
      found[point] = problem->control_of[point] >= 0
                         ? ConsensusOfControl(*problem, *state, point, variance_1)
                         : FindPointConsensus(*problem, *state, point, variance_1);
    }
  });
  bool changed = false;
  report->left_out.clear();
  for (std::size_t point = 0; point < points; ++point) {
    if (!takes_part(point)) continue;
    const PointConsensus& of = found[point];
    const std::size_t begin = block.looks.offsets[point], end = block.looks.offsets[point + 1];
    const std::vector<std::uint8_t> before(
        problem->look_used.begin() + static_cast<std::ptrdiff_t>(begin),
        problem->look_used.begin() + static_cast<std::ptrdiff_t>(end));
    const bool control = problem->control_of[point] >= 0;
    const bool agrees = of.outcome == PointConsensus::Outcome::kAgree ||
                        of.outcome == PointConsensus::Outcome::kMajority;
    ConsensusReport::OfPoint entry;
    entry.point = point;
    if (agrees) {
      for (std::size_t i = begin; i < end; ++i) problem->look_used[i] = 0;
      problem->TakeBack(point, of.looks);
      if (!control) {
        state->start_m[point] = of.position_m;
        state->displacement_m[point].setZero();
      }
      for (std::size_t i = begin; i < end; ++i) {
        if (!block.looks.rejected(i) && problem->look_used[i] == 0) entry.looks.push_back(i);
      }
    } else if (of.outcome == PointConsensus::Outcome::kContradict) {
      entry.looks = of.looks;
      entry.contradiction = true;
      state->start_m[point] = of.position_m;
      state->displacement_m[point].setZero();
      std::string text = "its looks contradict each other and nothing tells which is wrong: ";
      for (std::size_t k = 0; k < of.looks.size(); ++k) {
        text += (k == 0 ? "" : ", ") + block.passes[block.looks.pass[of.looks[k]]].id;
      }
      problem->LeaveOut(point, PointStatus::kApart, text);
    } else {
      problem->LeaveOut(point, PointStatus::kUndetermined, "its looks leave a direction open");
    }
    if (!entry.looks.empty()) {
      WhitenedLook at;
      for (const std::size_t look : entry.looks) {
        if (!EvaluateWhitened(*problem, *state, {}, point, look, &at)) continue;
        if (at.error_1.norm() <= entry.distance_1) continue;
        entry.distance_1 = at.error_1.norm();
        entry.azimuth = std::abs(at.error_1[1]) > std::abs(at.error_1[0]);
      }
      report->left_out.push_back(std::move(entry));
    }
    changed =
        changed || !std::equal(before.begin(),
                               before.end(),
                               problem->look_used.begin() + static_cast<std::ptrdiff_t>(begin));
  }
  UpdateWeights(*state, problem);
  return changed;
}

}  // namespace

ConsensusReport SolveByConsensus(const AdjustOptions& options,
                                 AdjustmentProblem* problem,
                                 BlockState* state,
                                 ProgressSink* progress) {
  ConsensusReport report;
  TakeAll(problem);
  const PassConnection connection = ConnectPasses(*problem);
  Step(progress, "consensus", 0, 0);
  StartOnGround(FindGroundConsensus(*problem, ReferenceHeight_m(*problem, *state)), problem, state);
  state->corrections.setZero();
  UpdateWeights(*state, problem);
  report.iterations = SolveGraduated(options, problem, state, progress);
  for (int round = 0; round < kMostJudgements; ++round) {
    bool changed = JudgePoints(problem, state, &report);
    if (round + 1 < kMostJudgements && RelocatePasses(*problem, state)) {
      changed = JudgePoints(problem, state, &report) || changed;
    }
    if (!changed) break;
    report.iterations += SolveAt(kLastScale_1, kMostLastSteps, options, problem, state, progress);
  }
  report.scattered = connection.IsKeptBy(ConnectPasses(*problem));
  for (const PassLooks& of_pass : CountPassLooks(problem->block, problem->look_used)) {
    report.scattered =
        report.scattered && of_pass.all.lost_1() <= kMostOfPass_1 && of_pass.deciding.Decide();
  }
  return report;
}

}  // namespace sarblock
