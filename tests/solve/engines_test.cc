// SPDX-License-Identifier: Apache-2.0
// Two routes to one solution, on every shipped scene: the reduced normal equations and Ceres. And
// what a user may choose of either: how Ceres solves, and where iteration ends.
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "normals/back.h"
#include "normals/point.h"
#include "normals/reduced_system.h"
#include "solve/ceres_engine.h"
#include "solve/reduced_engine.h"
#include "solve/solve_block.h"
#include "solve/start.h"
#include "support/scene_blocks.h"
#include "support/small_blocks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using test::SceneBlock;

AdjustResult Solved(const SceneBlock& made, Engine engine) {
  AdjustOptions options = made.options;
  options.engine = engine;
  return Adjust(made.block, options);
}

/// False for a point of two looks of which a loss takes weight: beyond its scale Huber's loss is
/// linear, so that the misclosure may lie in either look at the same cost.
bool Unique(const Block& block, const AdjustResult& result, std::size_t point) {
  const auto begin = block.looks.offsets[point], end = block.looks.offsets[point + 1];
  if (result.looks.weight.empty() || end - begin > 2) return true;
  return std::all_of(result.looks.weight.begin() + static_cast<std::ptrdiff_t>(begin),
                     result.looks.weight.begin() + static_cast<std::ptrdiff_t>(end),
                     [](float weight) { return weight >= 1.0F; });
}

/// Largest distance of a point of two solutions in sigmas, sqrt(d' Q^-1 d).
double LargestShiftOfPoints(const Block& block, const AdjustResult& a, const AdjustResult& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.points.status.size(); ++i) {
    if (!IsSolved(a.points.status[i]) || !Unique(block, a, i)) continue;
    largest = std::max(largest,
                       test::DistanceInSigmas(block.frame,
                                              a.points.position_m[i],
                                              b.points.position_m[i],
                                              a.points.covariance_m2[i]));
  }
  return largest;
}

/// The same of points and of corrections, |d|/sigma.
double LargestShift(const Block& block, const AdjustResult& a, const AdjustResult& b) {
  double largest = LargestShiftOfPoints(block, a, b);
  for (std::size_t k = 0; k < a.parameters.size(); ++k) {
    largest = std::max(
        largest, std::abs(a.parameters[k].value - b.parameters[k].value) / a.parameters[k].sigma);
  }
  return largest;
}

/// Largest difference of two covariances, each element by its own sigmas.
double LargestCovarianceError(const AdjustResult& a, const AdjustResult& b) {
  constexpr std::size_t kRow[] = {0, 1, 2, 0, 0, 1}, kColumn[] = {0, 1, 2, 1, 2, 2};
  double largest = 0.0;
  for (std::size_t i = 0; i < a.points.status.size(); ++i) {
    if (!IsSolved(a.points.status[i])) continue;
    const SymmetricEnu& p = a.points.covariance_m2[i];
    const SymmetricEnu& q = b.points.covariance_m2[i];
    for (std::size_t k = 0; k < 6; ++k) {
      largest = std::max(largest, std::abs(p[k] - q[k]) / std::sqrt(p[kRow[k]] * p[kColumn[k]]));
    }
  }
  for (std::size_t k = 0; k < a.parameters.size(); ++k) {
    largest = std::max(largest, std::abs(a.parameters[k].sigma / b.parameters[k].sigma - 1.0));
  }
  return largest;
}

void ExpectSameOutcome(const AdjustResult& reduced, const AdjustResult& ceres) {
  ASSERT_TRUE(reduced.usable());
  ASSERT_TRUE(ceres.usable());
  ASSERT_EQ(reduced.points.status, ceres.points.status);
  ASSERT_EQ(reduced.looks.rejected, ceres.looks.rejected);
  EXPECT_NEAR(reduced.final_cost, ceres.final_cost, 1e-9 * ceres.final_cost);
}

void ExpectSameRobust(const Block& block, const AdjustResult& reduced, const AdjustResult& ceres) {
  ExpectSameOutcome(reduced, ceres);
  // Each is within its last Newton step of the minimum; twice that, for what is not quadratic.
  const double left = 2.0 * (reduced.remaining_step + ceres.remaining_step);
  // Reweighting converges linearly: the way left is tens of last steps.
  EXPECT_LT(LargestShift(block, reduced, ceres), 100.0 * left + 1e-8);
  EXPECT_LT(left, 2e-4);
  EXPECT_LT(LargestCovarianceError(reduced, ceres), 1e-6);
}

class EnginesTest : public testing::TestWithParam<std::string> {};

TEST_P(EnginesTest, GiveTheSamePositionsAndCovariances) {
  const SceneBlock made = test::SmallSceneBlock(GetParam());
  if (GetParam() == "single-flight-squint") {  // neither may answer
    for (const Engine engine : {Engine::kReduced, Engine::kCeres}) {
      EXPECT_THROW(static_cast<void>(Solved(made, engine)), UndeterminedError);
    }
    return;
  }
  const AdjustResult reduced = Solved(made, Engine::kReduced);
  const AdjustResult ceres = Solved(made, Engine::kCeres);
  ExpectSameOutcome(reduced, ceres);
  EXPECT_LT(LargestShift(made.block, reduced, ceres), 1e-6);
  EXPECT_LT(LargestCovarianceError(reduced, ceres), 1e-6);
}

/// The corrections that a user may choose for a recorded flight: polynomials of a degree, a range
/// and a time bias of each pass, with priors of 100 m.
AdjustOptions Biased(const SceneBlock& made, int degree) {
  constexpr double kPrior_m = 100.0;
  PositionCorrection position;
  position.degree = degree;
  position.prior_sigma_m.fill({kPrior_m});
  RangeCorrection range;
  range.bias = true;
  range.bias_prior_sigma_m = kPrior_m;
  TimeCorrection time;
  const StateVector& state = made.block.passes[0].path.states()[0];
  time.bias_prior_sigma_s = kPrior_m / state.velocity_mps.norm();
  AdjustOptions options = made.options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = {
      {"position", position, {}, false}, {"range", range, {}, false}, {"time", time, {}, false}};
  return options;
}

// Recorded flights whose states carry noise: where their paths are read must not depend on the way
// that an engine takes to the solution. With 150 points `uav` of degree 2 has two minima, costs
// 416.3 and 417.4, and a warning that its equations are not linear (curvature 1.2 and more).
TEST(RecordedEnginesTest, GiveTheSameOnRecordedFlightsWithTimeBiases) {
  for (const char* const name : {"uav", "airborne-turbulent"}) {
    const SceneBlock made =
        test::SimulatedSceneBlock("scenes/recorded", name, {"points.count=200"});
    for (const int degree : {0, 2}) {
      SCOPED_TRACE(std::string(name) + " " + std::to_string(degree));
      AdjustOptions options = Biased(made, degree);
      const AdjustResult reduced = Adjust(made.block, options);
      options.engine = Engine::kCeres;
      const AdjustResult ceres = Adjust(made.block, options);
      ExpectSameOutcome(reduced, ceres);
      EXPECT_LT(LargestShift(made.block, reduced, ceres), 1e-6);
    }
  }
}

// Hand value: the change of the weights is the largest of any look, also where S is summed twice
// because points take nearly all of it: the second sum finds the weights of the first.
TEST(RecordedEnginesTest, KnowHowMuchTheWeightsChange) {
  const SceneBlock made = test::SimulatedSceneBlock("scenes/recorded", "uav", {"points.count=150"});
  for (const int degree : {0, 2}) {
    AdjustmentProblem problem(made.block, Biased(made, degree).groups);
    BlockState state = ComputeStartValues(&problem, nullptr).state;
    const std::vector<LookWeights> before = problem.weights;
    for (Eigen::Vector3d& moved_m : state.displacement_m)
      moved_m += Eigen::Vector3d(0.3, -0.2, 1.1);
    ReducedSystem system(problem);
    system.Form(state, {.renewed = &problem.weights}, nullptr);
    double largest = 0.0;
    for (std::size_t i = 0; i < before.size(); ++i) {
      if (problem.look_used[i] == 0) continue;
      const double now = problem.weights[i].azimuth_per_unit;
      largest = std::max(largest, std::abs(now / before[i].azimuth_per_unit - 1.0));
    }
    EXPECT_GT(largest, 1e-4) << degree;
    EXPECT_EQ(system.weight_change(), largest) << degree;
  }
}

// Invariance: where clocks are two seconds off the antenna moves on by two seconds along the path
// without noise. Each look has the noise of another time with it, which turns the cone by half a
// standard deviation of a look (5 mm/s at 20 m/s and 0.5 km). That moves v'Pv by less than a
// percent, and points by up to two standard deviations.
TEST(RecordedEnginesTest, FollowClocksThatAreSecondsOff) {
  SceneBlock made = test::SimulatedSceneBlock("scenes/recorded", "uav", {"points.count=150"});
  AdjustOptions options = Biased(made, 0);
  std::get<TimeCorrection>(options.groups.back().model).bias_prior_sigma_s = 10.0;
  const AdjustResult right = Adjust(made.block, options);
  for (double& time_s : made.block.looks.time_s) time_s -= 2.0;
  for (const Engine engine : {Engine::kReduced, Engine::kCeres}) {
    options.engine = engine;
    const AdjustResult shifted = Adjust(made.block, options);
    ASSERT_TRUE(shifted.usable());
    EXPECT_NEAR(shifted.final_cost, right.final_cost, 0.01 * right.final_cost);
    EXPECT_LT(LargestShiftOfPoints(made.block, right, shifted), 2.0);
  }
}

// Closed form: a look sees its point at t_p, whatever its time bias b, so that t_p - t - b has the
// slope -1 and the range none. Of a path that was read at t + b both would follow its noise.
TEST(RecordedEnginesTest, ReadNoisyPathsOnOneCurve) {
  for (const char* const name : {"uav", "airborne-turbulent"}) {
    SCOPED_TRACE(name);
    const SceneBlock made = test::SimulatedSceneBlock("scenes/recorded", name, {"points.count=60"});
    AdjustmentProblem problem(made.block, Biased(made, 2).groups);
    const BlockState start = ComputeStartValues(&problem, nullptr).state;
    const auto errors_at = [&](double bias_s) {
      BlockState state = start;
      for (int i = 0; i < problem.layout.size(); ++i) {
        const Parameter& parameter = problem.layout.parameters[static_cast<std::size_t>(i)];
        if (parameter.name == "time.bias") state.corrections[i] = bias_s;
        if (parameter.name.starts_with("position.")) state.corrections[i] = 7.0;
      }
      std::vector<Eigen::Vector2d> errors;
      LookColumns columns;
      LookEvaluation at;
      const Looks& looks = made.block.looks;
      for (std::size_t point = 0; point < made.block.points.size(); ++point) {
        for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
          EXPECT_TRUE(
              EvaluateLook(problem.model, state, point, i, problem.weights[i], &columns, &at));
          errors.push_back(at.whitened_error);
          errors.back()[1] += problem.weights[i].azimuth_per_unit * bias_s;
        }
      }
      return errors;
    };
    const std::vector<Eigen::Vector2d> unbiased = errors_at(0.0);
    for (const double bias_s : {-0.3, -0.05, 0.01, 0.2}) {
      const std::vector<Eigen::Vector2d> biased = errors_at(bias_s);
      for (std::size_t i = 0; i < biased.size(); ++i) {
        EXPECT_LT((biased[i] - unbiased[i]).norm(), 1e-5) << bias_s << " " << i;
      }
    }
  }
}

// Statistics over seeds: standard deviations of time biases are those of their errors. Where noise
// changes with the bias their squares sum to 71 here.
TEST(RecordedEnginesTest, KnowHowWellTheyKnowTimeBiases) {
  double square = 0.0, count = 0.0;
  for (int seed = 1; seed <= 8; ++seed) {
    const SceneBlock made =
        test::SimulatedSceneBlock("scenes/recorded",
                                  "airborne-turbulent",
                                  {"points.count=300", "seed=" + std::to_string(seed)});
    const AdjustResult result = Adjust(made.block, Biased(made, 0));
    for (const ParameterResult& correction : result.parameters) {
      if (correction.name != "time.bias") continue;
      square += std::pow(correction.significance(), 2);
      count += 1.0;
    }
  }
  ASSERT_EQ(count, 32.0);
  EXPECT_LT(square, ChiSquareQuantile(0.999, count));
}

/// A block solved by least squares, its normal equations without damping, and steps of corrections.
struct Formed {
  Formed(const SceneBlock& made, const AdjustOptions& options)
      : problem(made.block, options.groups), state(ComputeStartValues(&problem, nullptr).state) {
    EXPECT_TRUE(SolveRounds({}, options, &problem, &state, nullptr).converged);
    system.emplace(problem);
    system->Form(state, {}, nullptr);
    EXPECT_TRUE(system->FactorDamped());
  }
  /// Moves correction k by so many standard deviations, the others to where they then fit best.
  [[nodiscard]] Eigen::VectorXd StepAlong(Eigen::Index k, double deviations) const {
    const Eigen::VectorXd along = system->SolveFor(Eigen::VectorXd::Unit(system->rows(), k));
    return deviations / std::sqrt(along[k]) * along;
  }
  AdjustmentProblem problem;
  BlockState state;
  std::optional<ReducedSystem> system;
};

// Second route: v'Pv where the correction is held beside its solution, by a prior of a millionth of
// its standard deviation, and all others and the points are solved anew. On a block whose
// curvatures are moderate: where one is larger, third order counts in all. It does in a bias that
// lies between its two minima as well, which is less than a standard deviation off.
TEST(CurvatureTest, IsThatOfSolutionsWithACorrectionHeld) {
  const SceneBlock made =
      test::SimulatedSceneBlock("scenes/recorded", "uav", {"points.count=250", "seed=5"});
  const AdjustOptions options = Biased(made, 1);
  const AdjustResult result = Adjust(made.block, options);
  ASSERT_TRUE(result.usable());
  ASSERT_EQ(result.curvatures.size(), 8U);
  ASSERT_GT(std::abs(result.curvatures.front().curvature), 0.1);
  int compared = 0;
  for (const CorrectionCurvature& of : result.curvatures) {
    const ParameterResult& correction = result.parameters[of.parameter];
    if (correction.significance() < 1.0) continue;
    ++compared;
    SCOPED_TRACE(correction.owner + " " + correction.name);
    const auto k = static_cast<Eigen::Index>(of.parameter);
    // (t + c t^2)^2 / t^2 = 1 + 2 c t + c^2 t^2 of both sides.
    std::array<double, 2> rise{};
    constexpr double kT = 0.4;
    for (const std::size_t side : {0U, 1U}) {
      const double t = side == 0 ? -kT : kT;
      Formed at(made, options);
      const Eigen::VectorXd step = at.StepAlong(k, t);
      EXPECT_NEAR(step[k] / t, correction.sigma, 1e-3 * correction.sigma);
      at.state.corrections += step;
      Parameter& held = at.problem.layout.parameters[of.parameter];
      const double own_prior = at.state.corrections[k] / held.prior_sigma;
      held.prior_value = at.state.corrections[k];
      held.prior_sigma = 1e-6 * correction.sigma;
      SolveOptions to_the_end;
      to_the_end.settle_below = 1e-7;
      const SolveReport report = SolveReduced(at.problem, {}, to_the_end, &at.state, nullptr);
      ASSERT_TRUE(report.converged) << report.message;
      rise[side] =
          (2.0 * (report.final_cost - at.system->cost()) + own_prior * own_prior) / (kT * kT);
    }
    const double found = (rise[1] - rise[0]) / (4.0 * kT);
    EXPECT_NEAR(of.curvature, found, 0.3 * std::abs(found));
  }
  EXPECT_EQ(compared, 6);
}

// Closed form: of a bias that v'Pv depends on by its square alone, z standard deviations off.
TEST(CurvatureTest, IsHalfOneOverTheDistanceOfABiasThatIsObservedByItsSquare) {
  int compared = 0;
  for (int seed = 1; seed <= 8; ++seed) {
    const SceneBlock made = test::SimulatedSceneBlock(
        "scenes/recorded", "uav", {"points.count=250", "seed=" + std::to_string(seed)});
    const AdjustResult result = Adjust(made.block, Biased(made, 1));
    ASSERT_TRUE(result.usable());
    if (std::abs(result.curvatures.front().curvature) > 0.3) continue;  // third order counts
    for (const CorrectionCurvature& of : result.curvatures) {
      const ParameterResult& correction = result.parameters[of.parameter];
      if (correction.name != "time.bias" || correction.significance() < 2.0) continue;
      ++compared;
      EXPECT_NEAR(std::abs(of.curvature) * correction.significance(), 0.5, 0.15)
          << seed << " " << correction.owner << " " << correction.significance();
      EXPECT_GT(of.curvature * correction.value, 0.0);
      EXPECT_THAT(result.warnings, testing::Contains(testing::HasSubstr("are not linear within")));
    }
  }
  EXPECT_GE(compared, 5);
}

// As they are shipped, the scenes of recorded orbits have corrections that their control
// determines.
TEST(CurvatureTest, IsSmallWhereControlDeterminesCorrections) {
  for (const std::string name : {"downlink-orbit", "sparse-orbit"}) {
    const SceneBlock made = test::SimulatedSceneBlock("scenes/recorded", name, {});
    const AdjustResult result = Adjust(made.block, made.options);
    ASSERT_FALSE(result.curvatures.empty());
    EXPECT_LT(std::abs(result.curvatures.front().curvature), 0.01);
    EXPECT_THAT(result.warnings,
                testing::Not(testing::Contains(testing::HasSubstr("are not linear within"))));
  }
}

// Definition: v'Pv over s0^2, at standard deviations that are scaled by s0.
TEST(CurvatureTest, FollowsStandardDeviationsThatAreScaled) {
  const SceneBlock made = test::SimulatedSceneBlock("scenes/recorded", "uav", {"points.count=150"});
  AdjustOptions options = Biased(made, 1);
  const AdjustResult plain = Adjust(made.block, options);
  options.scale_by_posterior = true;
  const AdjustResult scaled = Adjust(made.block, options);
  ASSERT_NE(scaled.posterior_factor, 1.0);
  ASSERT_EQ(scaled.curvatures.size(), plain.curvatures.size());
  for (std::size_t i = 0; i < plain.curvatures.size(); ++i) {
    EXPECT_NEAR(scaled.curvatures[i].curvature,
                std::sqrt(scaled.posterior_factor) * plain.curvatures[i].curvature,
                1e-6);
  }
}

// A sample of many points, control points all: against the sum over all of them.
TEST(CurvatureTest, OfASampleIsThatOfAllPoints) {
  const SceneBlock made =
      test::SimulatedSceneBlock("scenes/recorded", "uav", {"points.count=3000"});
  const AdjustOptions options = Biased(made, 1);
  const AdjustResult result = Adjust(made.block, options);
  ASSERT_TRUE(result.usable());
  const Formed at(made, options);
  for (const CorrectionCurvature& of : result.curvatures) {
    SCOPED_TRACE(result.parameters[of.parameter].owner + result.parameters[of.parameter].name);
    const auto k = static_cast<Eigen::Index>(of.parameter);
    const Eigen::VectorXd step = at.StepAlong(k, 0.5);
    const double of_all = step.dot(BendOfStep(at.problem, at.state, {}, 0.0, step)) / 0.125;
    EXPECT_NEAR(of.curvature, of_all, 0.01 + 0.3 * std::abs(of_all));
  }
}

// Scenes with points of three and more looks.
TEST(RobustEnginesTest, GiveTheSameUnderRobustLosses) {
  for (const std::string name : {"block-12-strips", "earth-same-side", "venus-magellan"}) {
    SceneBlock made = test::SmallSceneBlock(name);
    made.options.max_iterations = 1000;
    for (const RobustLoss loss : {RobustLoss::kHuber, RobustLoss::kCauchy}) {
      SCOPED_TRACE(name + (loss == RobustLoss::kHuber ? " huber" : " cauchy"));
      made.options.robust = loss;
      ExpectSameRobust(made.block, Solved(made, Engine::kReduced), Solved(made, Engine::kCeres));
    }
  }
}

/// A block before it is solved.
struct Prepared {
  explicit Prepared(const SceneBlock& made) : problem(made.block, made.options.groups) {
    state = ComputeStartValues(&problem, nullptr).state;
  }
  AdjustmentProblem problem;
  BlockState state;
};

/// Newton step that is left, of equations formed anew: neither engine's own word.
double NewtonDecrement(const Prepared& at) {
  ReducedSystem system(at.problem);
  system.Form(at.state, {}, nullptr);
  EXPECT_TRUE(system.FactorDamped());
  return system.NewtonDecrement();
}

constexpr CeresSolver kCeresSolvers[] = {
    CeresSolver::kDenseSchur, CeresSolver::kSparseSchur, CeresSolver::kIterativeSchur};

// A flat block and one in geocentric coordinates, whose rounding hides the last digits of the cost.
class SolverChoiceTest : public testing::TestWithParam<std::string> {};

TEST_P(SolverChoiceTest, EverySolverEndsWithinItsTolerance) {
  const SceneBlock made = test::SmallSceneBlock(GetParam());
  // One rounding of a coordinate of 7e6 m is 1e-9 m, and of some hundred looks of a metre 2e-8
  // sigmas: less is not there to be had.
  for (const double tolerance : {1e-3, 1e-5, 1e-7}) {
    SCOPED_TRACE(tolerance);
    SolveOptions options;
    options.settle_below = tolerance;
    Prepared reduced(made);
    EXPECT_TRUE(SolveReduced(reduced.problem, {}, options, &reduced.state, nullptr).converged);
    EXPECT_LE(NewtonDecrement(reduced), tolerance);
    for (const CeresSolver solver : kCeresSolvers) {
      SCOPED_TRACE(static_cast<int>(solver));
      // With the finish: Ceres itself ends where the rounding of the cost hides what is left.
      AdjustOptions asked = made.options;
      asked.engine = Engine::kCeres;
      asked.ceres_solver = solver;
      asked.tolerance = tolerance;
      Prepared ceres(made);
      EXPECT_TRUE(SolveRounds({}, asked, &ceres.problem, &ceres.state, nullptr).converged);
      EXPECT_LE(NewtonDecrement(ceres), tolerance);
    }
  }
}

TEST_P(SolverChoiceTest, AllReachTheSameSolutionWithOneThreadAndWithTwo) {
  SceneBlock made = test::SmallSceneBlock(GetParam());
  made.options.tolerance = 1e-9;
  const AdjustResult best = Solved(made, Engine::kReduced);
  for (const double tolerance : {1e-3, 1e-6}) {
    made.options.tolerance = tolerance;
    for (const int threads : {1, 2}) {
      made.options.threads = threads;
      made.options.ceres_solver = CeresSolver::kAuto;
      const AdjustResult reduced = Solved(made, Engine::kReduced);
      EXPECT_LE(LargestShift(made.block, best, reduced), tolerance);
      EXPECT_LE(reduced.remaining_step, tolerance);
      for (const CeresSolver solver : kCeresSolvers) {
        SCOPED_TRACE(static_cast<int>(solver));
        made.options.ceres_solver = solver;
        const AdjustResult ceres = Solved(made, Engine::kCeres);
        EXPECT_TRUE(ceres.usable());
        EXPECT_LE(LargestShift(made.block, best, ceres), tolerance);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes,
                         SolverChoiceTest,
                         testing::Values("block-12-strips", "earth-same-side"),
                         [](const auto& scene) { return test::TestNameOf(scene.param); });

TEST(CeresSolverTest, IsRefusedWithoutCeres) {
  SceneBlock made = test::SmallSceneBlock("block-12-strips");
  made.options.ceres_solver = CeresSolver::kIterativeSchur;
  for (const Engine engine : {Engine::kAuto, Engine::kReduced}) {
    EXPECT_THROW(static_cast<void>(Solved(made, engine)), InputError);
  }
}

/// Counts the trials of a solver.
class Trials final : public ProgressSink {
 public:
  void Update(std::string_view, std::size_t, std::size_t, std::string_view) override { ++count; }
  [[nodiscard]] bool Cancelled() const override { return false; }
  int count = 0;
};

// A step of 3e-6 sigmas takes 5e-12 off a cost of some hundred whose rounding is 1e-10: whether it
// was a good one only the gradient can show. Refused steps would be tried again, damped.
TEST(ReducedEngineTest, TakesAStepThatTheCostIsTooCoarseToShow) {
  const SceneBlock made = test::SmallSceneBlock("block-12-strips");
  Prepared solved(made);
  SolveOptions options;
  options.settle_below = 1e-8;
  ASSERT_TRUE(SolveReduced(solved.problem, {}, options, &solved.state, nullptr).converged);
  ReducedSystem system(solved.problem);
  system.Form(solved.state, {}, nullptr);
  ASSERT_TRUE(system.FactorDamped());
  const Eigen::VectorXd unit = system.Unit();
  options.settle_below = 1e-6;
  for (Eigen::Index k = 0; k < std::min<Eigen::Index>(20, unit.size()); ++k) {
    BlockState state = solved.state;
    state.corrections[k] += 3e-6 * unit[k];
    Trials trials;
    const SolveReport report = SolveReduced(solved.problem, {}, options, &state, &trials);
    EXPECT_TRUE(report.converged);
    EXPECT_EQ(report.iterations, 1);
    EXPECT_EQ(trials.count, 2) << k;  // the step, and the look at what is left
  }
}

// Second route: a solution whose first step is made of the system that the start formed ends where
// another does, with one system less.
TEST(ReducedEngineTest, BeginsWithASystemThatIsFormed) {
  for (const char* scene :
       {"block-12-strips", "earth-same-side", "recorded/uav", "recorded/sparse-orbit"}) {
    const SceneBlock made = test::SmallSceneBlock(scene);
    Prepared anew(made), begun(made);
    SolveOptions options;
    options.settle_below = 1e-6;  // near rounding one more or less may be formed
    const SolveReport expected = SolveReduced(anew.problem, {}, options, &anew.state, nullptr);
    ReducedSystem system(begun.problem);
    system.FormSettled({}, 0.0, kMaxOwnStep, &begun.state, nullptr);
    ASSERT_TRUE(system.weak_points().empty()) << scene;
    options.formed = true;
    const SolveReport report =
        SolveReduced(begun.problem, {}, options, &system, &begun.state, nullptr);
    EXPECT_TRUE(report.converged) << scene;
    EXPECT_EQ(report.formed, expected.formed - 1) << scene;
    const Eigen::VectorXd apart = begun.state.corrections - anew.state.corrections;
    EXPECT_LT(apart.cwiseQuotient(system.Unit()).norm(), 1e-6) << scene;
  }
}

// Closed form of a count: points that follow the paths make no step of the corrections shorter,
// however many they are. Two paths start 90 and 141 m off; the linear step of a point leaves a
// curve by metres.
TEST(PointsFollowTest, IterationsDoNotGrowWithThePoints) {
  for (const char* points : {"points.count=300", "points.count=8000"}) {
    const SceneBlock made =
        test::SimulatedSceneBlock("scenes", "leberl-aircraft", {points, "seed=19790801"});
    const AdjustResult reduced = Solved(made, Engine::kReduced);
    const AdjustResult ceres = Solved(made, Engine::kCeres);
    EXPECT_LE(reduced.iterations, 4) << points;
    EXPECT_LE(ceres.iterations, 6) << points;
    EXPECT_LT(LargestShift(made.block, reduced, ceres), 1e-6) << points;
  }
}

// Each point moves down its own cost and nowhere else; a point that is settled stays where it is.
TEST(PointsFollowTest, APointIsMovedUntilItIsSettled) {
  const SceneBlock made = test::SmallSceneBlock("leberl-aircraft");
  Prepared start(made);
  start.state.corrections.setConstant(37.3);
  PointFactor factor;
  std::size_t moved = 0;
  for (std::size_t point = 0; point < made.block.points.size(); ++point) {
    if (!start.problem.Solves(point)) continue;
    FactorPoint(start.problem, start.state, {}, 1e-8, point, &factor);
    const double cost_before = factor.cost;
    if (SettlePoint(start.problem, {}, 1e-8, 1e-4, point, &start.state, &factor)) {
      ++moved;
      EXPECT_LT(factor.cost, cost_before);
    }
    EXPECT_LE(Project(factor, factor.e).norm(), 1e-4);
    const Eigen::Vector3d settled_m = start.state.displacement_m[point];
    EXPECT_FALSE(SettlePoint(start.problem, {}, 1e-8, 1e-4, point, &start.state, &factor));
    EXPECT_EQ(start.state.displacement_m[point], settled_m);
  }
  EXPECT_GT(moved, 100U);
}

// A solution that is done at a rough tolerance forms the system no more often than at a finer one,
// and its weights are those of the state.
TEST(ReducedEngineTest, FormsNoMoreForALooserTolerance) {
  const SceneBlock made = test::SmallSceneBlock("earth-same-side");
  int formed = std::numeric_limits<int>::max();
  for (const double tolerance : {1e-6, 1e-4, 1e-2}) {
    Prepared at(made);
    SolveOptions options;
    options.settle_below = 0.5;
    ASSERT_TRUE(SolveReduced(at.problem, {}, options, &at.state, nullptr).converged);
    options.undamped = true;
    options.settle_below = tolerance;
    Weighting weighting;
    weighting.renewed = &at.problem.weights;
    const SolveReport report = SolveReduced(at.problem, weighting, options, &at.state, nullptr);
    EXPECT_TRUE(report.converged) << tolerance;
    EXPECT_LT(UpdateWeights(at.state, &at.problem), 1e-9) << tolerance;
    EXPECT_LE(report.formed, formed) << tolerance;
    EXPECT_LE(report.formed, report.iterations + 2) << tolerance;
    formed = report.formed;
  }
}

// Invariance: a limit that the solution keeps changes nothing; one it cannot keep ends the steps.
TEST(ReducedEngineTest, GivesUpWhatIsOfNoUse) {
  SceneBlock made = test::SmallSceneBlock("block-12-strips");
  for (std::size_t i = 0; i < made.block.looks.size(); i += 3) made.block.looks.range_m[i] += 20.0;
  Prepared whole(made), kept(made), useless(made);
  SolveOptions options;
  const SolveReport solved = SolveReduced(whole.problem, {}, options, &whole.state, nullptr);
  ASSERT_TRUE(solved.converged);
  ASSERT_GT(solved.iterations, 3);
  options.useless_above = 4.0 * solved.final_cost;  // twice the v'Pv
  EXPECT_TRUE(SolveReduced(kept.problem, {}, options, &kept.state, nullptr).converged);
  EXPECT_EQ(kept.state.corrections, whole.state.corrections);
  options.useless_above = 0.2 * solved.final_cost;  // a tenth of it
  const SolveReport ended = SolveReduced(useless.problem, {}, options, &useless.state, nullptr);
  EXPECT_FALSE(ended.converged);
  EXPECT_LT(ended.iterations, solved.iterations);
}

INSTANTIATE_TEST_SUITE_P(Scenes,
                         EnginesTest,
                         testing::ValuesIn(test::SceneFiles()),
                         [](const auto& scene) { return test::TestNameOf(scene.param); });

// Hand values: of 50 steps the cost must fall by a thousandth, or the decrement to half.
TEST(ProgressOfStepsTest, EndsWhereNeitherCostNorStepsShrink) {
  ProgressOfSteps steps;
  EXPECT_FALSE(steps.Stagnates(50, 1000.0, 8.0));
  EXPECT_FALSE(steps.Stagnates(99, 1000.0, 8.0));  // no 50 steps since
  EXPECT_FALSE(steps.Stagnates(100, 998.9, 8.0));  // the cost fell
  EXPECT_FALSE(steps.Stagnates(150, 998.8, 3.9));  // the steps shrank
  EXPECT_TRUE(steps.Stagnates(200, 998.2, 2.0));
}

}  // namespace
}  // namespace sarblock
