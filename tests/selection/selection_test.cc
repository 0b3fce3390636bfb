// SPDX-License-Identifier: Apache-2.0
#include "selection/selection.h"

#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/files/scene_file.h"
#include "sarblock/simulate/scene.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "model/priors.h"
#include "selection/quadratic_model.h"
#include <Eigen/Cholesky>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

/// Four strips and two across them with control, flight errors and noise scaled by one factor.
Scene StripsScene(double scale, const std::vector<std::string>& overrides = {}) {
  std::vector<std::string> all{"flight.0.count=4",
                               "flight.0.length_m=40000",
                               "flight.1.length_m=27000",
                               "flight.2.length_m=27000",
                               "flight.2.start_m=[51000, 13000]",
                               "points.count=160",
                               "points.east_m=[1000, 39000]",
                               "points.north_m=[16000, 37000]",
                               "control.count=10",
                               "check.count=3"};
  all.insert(all.end(), overrides.begin(), overrides.end());
  Scene scene =
      files::ReadScene(std::string(SARBLOCK_DATASETS) + "/scenes/block-12-strips.toml", all);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    scene.navigation.constant_sigma_m[axis] *= scale;
    scene.navigation.drift_sigma_m[axis] *= scale;
  }
  scene.looks.noise_scale *= scale;
  scene.control.noise_scale *= scale;
  return scene;
}

AdjustOptions Auto() {
  AdjustOptions options;
  options.corrections = CorrectionChoice::kAuto;
  options.covariance = CovarianceLevel::kNone;
  return options;
}

const CandidateResult& Row(const SelectionReport& report, const std::string& name) {
  for (const CandidateResult& row : report.candidates) {
    if (row.name == name) return row;
  }
  throw InputError("candidate", "no row " + name);
}

/// The group that has just what a row of the standard candidates stands for, nothing kept.
CorrectionGroup GroupOf(const std::string& name) {
  CorrectionGroup group;
  group.name = name.substr(0, name.find('.'));
  RangeCorrection range;
  if (group.name == "position") {
    PositionCorrection position;
    position.degree = name.back() - '0';
    position.components = {name.find("along") != std::string::npos,
                           name.find("across") != std::string::npos,
                           name.find("up") != std::string::npos};
    group.model = position;
  } else if (name == "range.bias" || name == "range.scale") {
    (name == "range.bias" ? range.bias : range.scale) = true;
    group.model = range;
  } else if (name == "squint.bias") {
    group.model = SquintCorrection{};
  } else if (name == "troposphere.zenith") {
    group.model = TroposphereCorrection{};
  } else {
    throw InputError("candidate", name);
  }
  return group;
}

AdjustResult Fit(const Block& block, const std::vector<CorrectionGroup>& groups) {
  AdjustOptions options;
  options.covariance = CovarianceLevel::kNone;
  options.corrections = groups.empty() ? CorrectionChoice::kNone : CorrectionChoice::kGiven;
  options.groups = groups;
  return Adjust(block, options);
}

// Second route: every candidate adjusted on its own. The score test has the F of the refit to first
// order: the relative difference falls with the size of all errors.
TEST(SelectionTest, TheScoreTestHasTheFOfARefitToFirstOrder) {
  double largest_at_one = 0.0;
  for (const double scale : {1.0, 0.25}) {
    const Block block = Simulate(StripsScene(scale)).block;
    AdjustOptions options = Auto();
    options.selection.significance = 1e-300;  // nothing is kept: all are tested on the same base
    options.selection.max_degree = 2;
    options.selection.knot_spacings_s = std::vector<double>{};
    const SelectionReport report = SelectCorrections(block, options);
    for (const CandidateResult& row : report.candidates) ASSERT_FALSE(row.kept) << row.name;
    const AdjustResult base = Fit(block, {});
    double largest = 0.0;
    int compared = 0;
    for (const CandidateResult& row : report.candidates) {
      if (row.test != SelectionTest::kScore || row.name == "time.bias") continue;
      ASSERT_TRUE(std::isfinite(row.f)) << row.name;
      const AdjustResult fit = Fit(block, {GroupOf(row.name)});
      ASSERT_EQ(fit.status, AdjustStatus::kConverged) << row.name;
      const double k = base.redundancy() - fit.redundancy();
      EXPECT_EQ(k, row.parameters) << row.name;
      const double f =
          ((base.final_cost - fit.final_cost) / k) / (fit.final_cost / fit.redundancy());
      largest = std::max(largest, std::abs(row.f / f - 1.0));
      ++compared;
    }
    EXPECT_EQ(compared, 13);  // 9 of the position, 2 of the range, squint and troposphere
    if (scale == 1.0) {
      largest_at_one = largest;
      EXPECT_LT(largest, 0.02);
    } else {
      EXPECT_LT(largest, 0.4 * largest_at_one);  // a quarter to first order
    }
  }
}

/// What is kept, without what is held by priors. Standard candidates have no priors of their own.
std::vector<CorrectionGroup> KeptOf(const SelectionReport& report) {
  std::vector<CorrectionGroup> kept;
  for (const CorrectionGroup& group : report.groups) {
    if (const auto* position = std::get_if<PositionCorrection>(&group.model)) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!position->components[axis]) continue;
        const std::vector<double>& sigma_m = position->prior_sigma_m[axis];
        const auto held =
            std::find_if(sigma_m.begin(), sigma_m.end(), [](double s) { return !std::isnan(s); });
        const std::ptrdiff_t degrees =
            sigma_m.empty() ? position->degree + 1 : held - sigma_m.begin();
        if (degrees == 0) continue;
        CorrectionGroup one = group;
        auto& own = std::get<PositionCorrection>(one.model);
        own.degree = static_cast<int>(degrees) - 1;
        own.components = {axis == 0, axis == 1, axis == 2};
        own.prior_sigma_m = {};
        kept.push_back(one);
      }
      continue;
    }
    const std::vector<Parameter> parameters = ParametersOf(group);
    if (std::none_of(parameters.begin(), parameters.end(), [](const Parameter& parameter) {
          return parameter.has_prior();
        })) {
      kept.push_back(group);
    }
  }
  return kept;
}

// Second route: what is kept tested by leaving it out and adjusting again.
TEST(SelectionTest, WaldsTestHasTheFOfLeavingOut) {
  const Block block = Simulate(StripsScene(1.0)).block;
  const SelectionReport report = SelectCorrections(block, Auto());
  const std::vector<CorrectionGroup> kept = KeptOf(report);
  const AdjustResult full = Fit(block, kept);
  const CandidateResult& row = Row(report, "position.across.1");
  ASSERT_TRUE(row.kept);
  ASSERT_EQ(row.test, SelectionTest::kWald);
  std::vector<CorrectionGroup> fewer = kept;
  for (CorrectionGroup& group : fewer) {
    auto* position = std::get_if<PositionCorrection>(&group.model);
    if (position == nullptr || !position->components[1]) continue;
    ASSERT_EQ(position->degree, 1);
    position->degree = 0;
  }
  const AdjustResult less = Fit(block, fewer);
  const double k = less.redundancy() - full.redundancy();
  EXPECT_EQ(k, row.parameters);
  const double f =
      ((less.final_cost - full.final_cost) / k) / (full.final_cost / full.redundancy());
  EXPECT_NEAR(row.f / f, 1.0, 0.01);  // first order
  EXPECT_EQ(row.probability, FisherTailProbability(row.f, k, full.redundancy()));
}

TEST(SelectionTest, EveryCandidateHasItsRowFiguresAndReason) {
  const Block block = Simulate(StripsScene(1.0)).block;
  const AdjustResult result = Adjust(block, Auto());
  ASSERT_TRUE(result.usable());
  const SelectionReport& report = result.selection;
  // Three components of degrees 0 to 3 and two splines and a process, two of the range, three more.
  EXPECT_EQ(report.candidates.size(), 3u * 7u + 5u);
  std::set<std::string> names;
  std::size_t kept = 0;
  for (const CandidateResult& row : report.candidates) {
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_EQ(row.passes, "all");
    EXPECT_FALSE(row.reason.empty()) << row.name;
    EXPECT_EQ(row.parameters > 0, row.test != SelectionTest::kNotTried) << row.name;
    EXPECT_EQ(row.held, row.reason.find("held by a prior that was estimated") != std::string::npos)
        << row.reason;
    EXPECT_FALSE(row.held && row.kept) << row.name;
    if (!row.kept) continue;
    EXPECT_EQ(row.test, SelectionTest::kWald) << row.name;
    EXPECT_GT(row.step, 0) << row.name;
    kept += static_cast<std::size_t>(row.parameters);
  }
  // What is kept has no prior, what is held has one.
  for (const ParameterResult& parameter : result.parameters) {
    EXPECT_THAT(parameter.kept, HasSubstr("F ")) << parameter.name;
    const CandidateResult& row = Row(report, parameter.name);
    EXPECT_EQ(row.held, parameter.prior_sigma > 0.0) << parameter.name;
    EXPECT_EQ(row.kept, std::isnan(parameter.prior_sigma)) << parameter.name;
    kept -= row.kept ? 1u : 0u;
  }
  EXPECT_EQ(kept, 0u);
  EXPECT_TRUE(Row(report, "position.along.2").held);
  // A time bias is a shift along these straight tracks, which is kept: nothing is left of it.
  EXPECT_STREQ(Row(report, "time.bias").verdict(), "dropped");
  // Truth: constants and drifts, and nothing else.
  EXPECT_TRUE(Row(report, "position.along.0").kept);
  EXPECT_TRUE(Row(report, "position.along.1").kept);
  EXPECT_TRUE(Row(report, "position.across.1").kept);
  EXPECT_FALSE(Row(report, "position.along.2").kept);
  EXPECT_FALSE(Row(report, "range.bias").kept);
  EXPECT_TRUE(report.settled);
}

// Hand argument: straight flight at constant speed, so a time bias is a shift along track.
TEST(SelectionTest, NamesWhatIsNotDeterminable) {
  const Block block = Simulate(StripsScene(1.0)).block;
  const SelectionReport report = SelectCorrections(block, Auto());
  const CandidateResult& time = Row(report, "time.bias");
  EXPECT_FALSE(time.kept);
  EXPECT_THAT(time.reason, StartsWith("not determinable"));
  EXPECT_GT(time.condition, 1e8);
}

// Without control the block floats: of three constants for all passes, which contain a translation
// of the whole block, one at least is not determinable. Nothing throws.
TEST(SelectionTest, ABlockWithoutControlLeavesATranslationOut) {
  Scene scene = StripsScene(1.0);
  scene.control.layout = SceneControl::Layout::kNone;
  const AdjustResult result = Adjust(Simulate(scene).block, Auto());
  EXPECT_TRUE(result.usable());
  int refused = 0;
  for (const char* name : {"position.along.0", "position.across.0", "position.up.0"}) {
    const CandidateResult& row = Row(result.selection, name);
    if (row.reason.starts_with("not determinable")) ++refused;
  }
  EXPECT_GE(refused, 1);
}

TEST(SelectionTest, PerPassCorrectsOnlyThePassThatIsWrong) {
  Scene scene = StripsScene(1.0);
  scene.navigation = {};
  SimulatedBlock simulated = Simulate(scene);
  // The nominal path of one pass is shifted by 6 m up.
  Pass& pass = simulated.block.passes[2];
  std::vector<StateVector> states = pass.path.states();
  for (StateVector& state : states) state.position_m.z() += 6.0;
  pass.path = FlightPath(states);
  AdjustOptions options = Auto();
  options.selection.mode = SelectionOptions::Mode::kPerPass;
  options.covariance = CovarianceLevel::kBlock;
  const AdjustResult result = Adjust(simulated.block, options);
  ASSERT_TRUE(result.usable());
  std::vector<ParameterResult> kept;
  for (const ParameterResult& parameter : result.parameters) {
    if (std::isnan(parameter.prior_sigma)) kept.push_back(parameter);
  }
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept[0].owner, pass.id);
  EXPECT_EQ(kept[0].name, "position.up.0");
  EXPECT_NEAR(kept[0].value, -6.0, 4.0 * kept[0].sigma);
  // Standard deviations take the choice of what is kept for certain: the result says so, the common
  // choice need not.
  const auto warns = testing::Contains(HasSubstr("chosen for every pass by itself"));
  EXPECT_THAT(result.warnings, warns);
  options.selection.mode = SelectionOptions::Mode::kCommon;
  EXPECT_THAT(Adjust(simulated.block, options).warnings, testing::Not(warns));
}

TEST(SelectionTest, CorrectionTablesAreTheCandidatesWithTheirPriors) {
  const Block block = Simulate(StripsScene(1.0)).block;
  AdjustOptions options = Auto();
  CorrectionGroup position;
  position.name = "position";
  PositionCorrection model;
  model.degree = 1;
  // Of the along shift nothing is known beyond 4 m; up is known to a micrometre.
  model.components = {true, false, true};
  model.prior_sigma_m = {{{4.0}, {}, {1e-6}}};
  position.model = model;
  options.groups = {position};
  const SelectionReport report = SelectCorrections(block, options);
  ASSERT_EQ(report.candidates.size(), 4u);
  EXPECT_TRUE(Row(report, "position.along.0").kept);
  EXPECT_LT(Row(report, "position.along.0").posterior_prior, 0.2);
  EXPECT_THAT(Row(report, "position.up.0").reason, HasSubstr("add little to its prior"));
  EXPECT_STREQ(Row(report, "position.up.0").verdict(), "held");
  EXPECT_THAT(Row(report, "position.up.0").reason, HasSubstr("held by its prior"));
  // A prior says how large an error may be: left out, it would be said to be zero.
  ASSERT_EQ(report.groups.size(), 1u);
  const auto& chosen = std::get<PositionCorrection>(report.groups[0].model);
  EXPECT_EQ(chosen.degree, 1);
  EXPECT_EQ(chosen.components, model.components);
  EXPECT_EQ(chosen.prior_sigma_m[0], (std::vector<double>{4.0, 4.0}));
  EXPECT_EQ(chosen.prior_sigma_m[2], (std::vector<double>{1e-6, 1e-6}));
}

// Seeded truth: a random walk of B-spline coefficients, which no cubic polynomial follows.
TEST(SelectionTest, ASplineReplacesThePolynomialThatCannotFollow) {
  Scene scene = StripsScene(1.0, {"points.count=600"});
  scene.navigation.process = SceneNavigation::Process::kRandomWalk;
  scene.navigation.process_sigma_m = {30.0, 0.0, 0.0};
  scene.navigation.knot_spacing_s = 25.0;
  AdjustOptions options = Auto();
  options.selection.knot_spacings_s = {{25.0}};
  const Block block = Simulate(scene).block;
  const AdjustResult result = Adjust(block, options);
  ASSERT_TRUE(result.usable());
  EXPECT_TRUE(Row(result.selection, "position.along.process 25 s").kept);
  EXPECT_FALSE(Row(result.selection, "position.along.3").kept);
  EXPECT_THAT(Row(result.selection, "position.along.3").reason, HasSubstr("spline"));
  EXPECT_TRUE(result.chi_square_passed);
}

// Points only in the west of the strips.
TEST(SelectionTest, WhereFreeKnotsAreRefusedAProcessIsChosenAndHolds) {
  Scene scene = StripsScene(1.0, {"points.count=600", "points.east_m=[1000, 16000]"});
  scene.navigation.process = SceneNavigation::Process::kRandomWalk;
  scene.navigation.process_sigma_m = {30.0, 0.0, 0.0};
  scene.navigation.knot_spacing_s = 25.0;
  const Block block = Simulate(scene).block;
  CorrectionGroup group;
  group.name = "position";
  PositionCorrection free;
  free.basis = PositionCorrection::Basis::kSpline;
  free.knot_spacing_s = 25.0;
  free.components = {true, false, false};
  group.model = free;
  EXPECT_THROW(static_cast<void>(Fit(block, {group})), UndeterminedError);
  AdjustOptions options = Auto();
  options.selection.knot_spacings_s = {{25.0}};
  const AdjustResult result = Adjust(block, options);
  ASSERT_TRUE(result.usable());
  EXPECT_TRUE(Row(result.selection, "position.along.process 25 s").kept);
  for (const std::string& warning : result.warnings) {
    EXPECT_THAT(warning, Not(HasSubstr("nearly undetermined")));
  }
}

// Seeded truth: coefficients drawn with one standard deviation, so that the square sum of those
// drawn is chi-square; the estimate adds little to its scatter, since the looks fix a coefficient
// to a part of that. The same model given gives the same solution.
TEST(SelectionTest, TheVarianceOfAProcessIsThatOfItsCoefficients) {
  Scene scene = StripsScene(1.0, {"points.count=600"});
  scene.navigation = {};
  scene.navigation.process = SceneNavigation::Process::kGaussMarkov;
  scene.navigation.correlation_time_s = 0.5;
  scene.navigation.process_sigma_m = {0.0, 1.0, 0.0};
  scene.navigation.knot_spacing_s = 40.0;
  AdjustOptions options = Auto();
  options.selection.knot_spacings_s = {{40.0}};
  const Block block = Simulate(scene).block;
  const AdjustResult result = Adjust(block, options);
  ASSERT_TRUE(result.usable());
  EXPECT_TRUE(Row(result.selection, "position.across.process 40 s").kept);
  double coefficients = 0.0, sigma_m = kNotGiven;
  for (const ParameterResult& parameter : result.parameters) {
    if (!parameter.name.starts_with("position.across")) continue;
    ++coefficients;
    sigma_m = parameter.prior_sigma;
  }
  const Interval region = ChiSquareInterval(0.999, coefficients);  // of one metre drawn
  EXPECT_TRUE(region.Contains(coefficients * sigma_m * sigma_m)) << sigma_m;
  EXPECT_TRUE(result.chi_square_passed);
  const AdjustResult given = Fit(block, result.selection.groups);
  EXPECT_EQ(given.final_cost, result.final_cost);
}

// Second route: the likelihood of several variances from determinants of all columns together, each
// variance moved by itself. Seeded columns, coefficients of two sizes and of none.
TEST(SelectionTest, VariancesOfSeveralSetsAreTheMostLikelyOnes) {
  RandomStream random(4711, 1);
  constexpr Eigen::Index kRows = 60, kFree = 2;
  const std::vector<std::vector<int>> sets{{2, 3, 4, 5, 6, 7}, {8, 9, 10, 11}, {12, 13, 14}};
  const std::vector<double> size{3.0, 0.4, 0.0};
  const Eigen::Index columns = 15;
  Eigen::MatrixXd a(kRows, columns);
  for (double& value : a.reshaped()) value = random.Normal();
  Eigen::VectorXd x = Eigen::VectorXd::Zero(columns);
  x.head(kFree).setConstant(5.0);
  for (std::size_t k = 0; k < sets.size(); ++k) {
    for (const int c : sets[k]) x[c] = size[k] * random.Normal();
  }
  Eigen::VectorXd y = a * x;
  for (double& value : y) value += random.Normal();
  QuadraticModel::Data data;
  data.s = a.transpose() * a;
  data.b = a.transpose() * y;
  data.constant = y.squaredNorm();
  data.full_diagonal = data.s.diagonal();
  data.prior_weight = Eigen::VectorXd::Zero(columns);
  data.log_count = Eigen::VectorXd::Constant(columns, std::log(kRows));
  data.redundancy = static_cast<double>(kRows);
  QuadraticModel model(data);
  ASSERT_TRUE(model.Reset({0, 1}));
  const std::vector<double> variance = model.MostLikelyVariances(sets);
  ASSERT_EQ(variance.size(), sets.size());

  const auto cost = [&](const std::vector<double>& q) {
    Eigen::VectorXd weight = Eigen::VectorXd::Zero(columns);
    double prior = 0.0;
    for (std::size_t k = 0; k < sets.size(); ++k) {
      for (const int c : sets[k]) weight[c] = 1.0 / q[k];
      prior += (static_cast<double>(sets[k].size()) - 0.5) * std::log(q[k]);
    }
    Eigen::MatrixXd s = data.s;
    s.diagonal() += weight;
    const Eigen::LDLT<Eigen::MatrixXd> factor(s);
    return (data.redundancy - kFree) * std::log(data.constant - data.b.dot(factor.solve(data.b))) +
           factor.vectorD().array().log().sum() + prior;
  };
  const double least = cost(variance);
  for (std::size_t k = 0; k < sets.size(); ++k) {
    for (const double factor : {0.8, 0.9, 1.1, 1.25}) {
      std::vector<double> moved = variance;
      moved[k] *= factor;
      EXPECT_GT(cost(moved), least) << k << " " << factor;
    }
  }
  EXPECT_NEAR(std::sqrt(variance[0]), 3.0, 1.5);
  EXPECT_LT(std::sqrt(variance[2]), 0.2);  // about the standard deviation of one coefficient
}

TEST(SelectionTest, TheModelChosenIsOneThatCanBeGiven) {
  const Block block = Simulate(StripsScene(1.0)).block;
  const AdjustResult chosen = Adjust(block, Auto());
  const AdjustResult given = Fit(block, chosen.selection.groups);
  ASSERT_EQ(given.parameters.size(), chosen.parameters.size());
  EXPECT_EQ(given.final_cost, chosen.final_cost);
  EXPECT_EQ(given.points.position_m[20], chosen.points.position_m[20]);
}

TEST(SelectionTest, DoesNotDependOnTheNumberOfThreads) {
  const Block block = Simulate(StripsScene(1.0)).block;
  AdjustOptions options = Auto();
  const SelectionReport one = SelectCorrections(block, options);
  options.threads = 3;
  const SelectionReport three = SelectCorrections(block, options);
  ASSERT_EQ(one.candidates.size(), three.candidates.size());
  for (std::size_t i = 0; i < one.candidates.size(); ++i) {
    EXPECT_EQ(one.candidates[i].reason, three.candidates[i].reason);
    if (std::isfinite(one.candidates[i].f)) {
      EXPECT_EQ(one.candidates[i].f, three.candidates[i].f) << one.candidates[i].name;
    }
  }
}

TEST(SelectionTest, RefusesAPrediction) {
  const Block block = Simulate(StripsScene(1.0)).block;
  EXPECT_THROW((void)Predict(block, Auto(), {}), InputError);
}

}  // namespace
}  // namespace sarblock
