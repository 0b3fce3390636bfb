// SPDX-License-Identifier: Apache-2.0
// Cost functions one by one. Evidence: hand values, difference quotients (ceres::GradientChecker),
// identities between the costs.
#include "sarblock/cost/look_cost.h"

#include "sarblock/core/error.h"

#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "support/small_blocks.h"
#include <ceres/gradient_checker.h>
#include <ceres/manifold.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::HasSubstr;

/// Straight and level along x at 100 m/s and 3 km, so that a look is hand arithmetic: states from
/// -50 to 50 s, at x = 0 at time 0.
FlightPath StraightPath() {
  std::vector<StateVector> states;
  for (double time_s = -50.0; time_s <= 50.0; time_s += 10.0) {
    states.push_back({time_s, {100.0 * time_s, 0.0, 3000.0}, {100.0, 0.0, 0.0}});
  }
  return FlightPath(states);
}
FlightPointer StraightFlight(std::vector<FlightCorrection> corrections) {
  return std::make_shared<CorrectedFlight>(
      Frame::Local(), StraightPath(), FlightOptions{{-40.0, 40.0}}, std::move(corrections));
}

/// A look at 12.5 s whose point is 4 km to the side, 1300 m along and on the ground: 5 km away, 0.5
/// s after the measured time.
const Eigen::Vector3d kPoint_m(1300.0, 4000.0, 0.0);
LookMeasurement StraightLook() {
  LookMeasurement look;
  look.time_s = 12.5;
  look.range_m = 4999.0;
  look.range_sigma_m = 0.5;
  look.time_sigma_s = 0.01;
  return look;
}

struct Evaluated {
  bool has_value = false;
  std::vector<double> residuals;
  std::vector<std::vector<double>> jacobians;  ///< by block, row by row
};
Evaluated Evaluate(const ceres::CostFunction& cost, const std::vector<double*>& blocks) {
  Evaluated out;
  out.residuals.resize(static_cast<std::size_t>(cost.num_residuals()));
  std::vector<double*> jacobians;
  for (const int size : cost.parameter_block_sizes()) {
    out.jacobians.emplace_back(static_cast<std::size_t>(size * cost.num_residuals()), 99.0);
  }
  for (std::vector<double>& jacobian : out.jacobians) jacobians.push_back(jacobian.data());
  out.has_value = cost.Evaluate(blocks.data(), out.residuals.data(), jacobians.data());
  return out;
}

// Hand arithmetic: the cone passes over the point 0.5 s after the measured time, at 5000 m.
TEST(RangeDopplerCostTest, IsRangeAndTimeOverTheirStandardDeviations) {
  Eigen::Vector3d block(3.0, 0.0, 0.0);
  const CostPointer cost = RangeDopplerCost(StraightFlight({}), StraightLook(), kPoint_m - block);
  const Evaluated at = Evaluate(*cost, {block.data()});
  ASSERT_TRUE(at.has_value);
  EXPECT_NEAR(at.residuals[0], (5000.0 - 4999.0) / 0.5, 1e-10);
  EXPECT_NEAR(at.residuals[1], 0.5 / 0.01, 1e-10);
  const std::array<double, 6> expected{0.0, 0.8 / 0.5, -0.6 / 0.5, 0.01 / 0.01, 0.0, 0.0};
  for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(at.jacobians[0][k], expected[k], 1e-12);
}

// Hand arithmetic: at the measured time the point is 50 m ahead, sqrt(5000^2 + 50^2) away.
TEST(RangeSphereCostTest, IsTheRangeAtTheMeasuredTime) {
  RangeCorrection range;
  range.bias = range.scale = true;
  const CostPointer cost = RangeSphereCost(StraightFlight({{range, {}}}), StraightLook());
  ASSERT_EQ(cost->num_residuals(), 1);
  Eigen::Vector3d point = kPoint_m;
  std::array<double, 2> bias{-0.25, 1e-4};
  const Evaluated at = Evaluate(*cost, {point.data(), bias.data()});
  ASSERT_TRUE(at.has_value);
  const double rho_m = std::hypot(5000.0, 50.0);
  EXPECT_NEAR(at.residuals[0], (1.0001 * rho_m - 0.25 - 4999.0) / 0.5, 1e-10);
  const std::array<double, 3> by_point{50.0, 4000.0, -3000.0};
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(at.jacobians[0][k], 1.0001 * by_point[k] / rho_m / 0.5, 1e-12);
  }
  EXPECT_NEAR(at.jacobians[1][0], 2.0, 1e-12);
  EXPECT_NEAR(at.jacobians[1][1], rho_m / 0.5, 1e-9);
}

// Identity: sphere and cone are the two rows of both together where the time is exact; the cone
// alone is the second row where it is measured.
TEST(DopplerConeCostTest, IsTheSecondResidualOfBothTogether) {
  const FlightPointer flight = StraightFlight({{PositionCorrection{}, {}},
                                               {VelocityCorrection{}, {}},
                                               {SquintCorrection{}, {}},
                                               {TimeCorrection{}, {}}});
  Eigen::Vector3d point = kPoint_m, shift_m(1.3, -0.7, 2.1);
  std::array<double, 2> turn{3e-4, -5e-4};
  double squint_rad = 0.013, time_s = 0.21;
  const std::vector<double*> blocks{
      point.data(), shift_m.data(), turn.data(), &squint_rad, &time_s};
  LookMeasurement doppler = StraightLook();
  doppler.cone = {Cone::Kind::kDoppler, 0.0, 1.7};
  doppler.time_sigma_s = kNotGiven;
  doppler.doppler_sigma_hz = 0.9;
  doppler.wavelength_m = 0.031;
  for (const LookMeasurement& look : {StraightLook(), doppler}) {
    const Evaluated both = Evaluate(*RangeDopplerCost(flight, look), blocks);
    const Evaluated cone = Evaluate(*DopplerConeCost(flight, look), blocks);
    ASSERT_TRUE(both.has_value && cone.has_value);
    EXPECT_EQ(cone.residuals[0], both.residuals[1]);
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      const std::size_t size = both.jacobians[b].size() / 2;
      for (std::size_t k = 0; k < size; ++k) {
        EXPECT_EQ(cone.jacobians[b][k], both.jacobians[b][size + k]);
      }
    }
  }
  const Evaluated both = Evaluate(*RangeDopplerCost(flight, doppler), blocks);
  const Evaluated sphere = Evaluate(*RangeSphereCost(flight, doppler), blocks);
  ASSERT_TRUE(sphere.has_value);
  EXPECT_NEAR(sphere.residuals[0], both.residuals[0], 1e-10);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    for (std::size_t k = 0; k < sphere.jacobians[b].size(); ++k) {
      EXPECT_NEAR(sphere.jacobians[b][k], both.jacobians[b][k], 1e-9);
    }
  }
}

TEST(LookCostTest, WritesNoJacobianThatIsNotAskedFor) {
  RangeCorrection range;
  range.bias = true;
  const FlightPointer flight = StraightFlight({{range, {}}, {SquintCorrection{}, {}}});
  const CostPointer cost = RangeDopplerCost(flight, StraightLook());
  Eigen::Vector3d point = kPoint_m;
  double bias_m = 0.4, squint_rad = 0.002;
  const std::vector<double*> blocks{point.data(), &bias_m, &squint_rad};
  const Evaluated all = Evaluate(*cost, blocks);
  std::array<double, 2> residuals{}, only{};
  ASSERT_TRUE(cost->Evaluate(blocks.data(), residuals.data(), nullptr));
  EXPECT_EQ(residuals[0], all.residuals[0]);
  EXPECT_EQ(residuals[1], all.residuals[1]);
  std::array<double*, 3> some{nullptr, only.data(), nullptr};
  ASSERT_TRUE(cost->Evaluate(blocks.data(), residuals.data(), some.data()));
  EXPECT_EQ(only[0], all.jacobians[1][0]);
  EXPECT_EQ(only[1], all.jacobians[1][1]);
}

TEST(LookCostTest, HasNoValueWhereItsHeaderSaysSo) {
  TroposphereCorrection air;
  const FlightPointer flight = StraightFlight({{TimeCorrection{}, {}}, {air, {}}});
  const CostPointer cost = RangeDopplerCost(flight, StraightLook());
  const auto evaluates = [&](Eigen::Vector3d point_m, double bias_s) {
    double zenith_m = 2.3;
    return Evaluate(*cost, {point_m.data(), &bias_s, &zenith_m}).has_value;
  };
  EXPECT_TRUE(evaluates(kPoint_m, 0.0));
  EXPECT_TRUE(evaluates(kPoint_m, 90.0)) << "beyond the path by less than its length";
  EXPECT_FALSE(evaluates(kPoint_m, 140.0)) << "farther beyond the path";
  EXPECT_FALSE(evaluates({1300.0, 0.0, 3000.0}, 0.0)) << "at the antenna";
  EXPECT_FALSE(evaluates({1300.0, 4000.0, 3000.0}, 0.0)) << "a level line of sight";
  EXPECT_FALSE(evaluates({kNotGiven, 4000.0, 0.0}, 0.0)) << "not a number";
  EXPECT_FALSE(evaluates(kPoint_m, kNotGiven)) << "a bias that is not a number";

  // Flown around the point: the cone turns with it.
  std::vector<StateVector> circle;
  for (int k = 0; k <= 40; ++k) {
    const double angle = 0.05 * k;
    circle.push_back({0.5 * k,
                      {1000.0 * std::cos(angle), 1000.0 * std::sin(angle), 3000.0},
                      {-100.0 * std::sin(angle), 100.0 * std::cos(angle), 0.0}});
  }
  LookMeasurement look = StraightLook();
  look.time_s = 10.3;
  const CostPointer around =
      RangeDopplerCost(std::make_shared<CorrectedFlight>(Frame::Local(),
                                                         FlightPath(circle),
                                                         FlightOptions{{0.0, 20.0}},
                                                         std::vector<FlightCorrection>{}),
                       look);
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  EXPECT_FALSE(Evaluate(*around, {centre_m.data()}).has_value)
      << "a cone that turns with the point";
}

TEST(LookCostTest, RefusesWhatCannotBeMeant) {
  const FlightPointer flight = StraightFlight({});
  const auto refuses = [&](const char* field, auto change) {
    LookMeasurement look = StraightLook();
    change(&look);
    try {
      (void)RangeDopplerCost(flight, look);
      ADD_FAILURE() << field << " is accepted";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(field));
    }
  };
  refuses("look.time_s", [](LookMeasurement* look) { look->time_s = 50.1; });
  refuses("look.time_s", [](LookMeasurement* look) { look->time_s = kNotGiven; });
  refuses("look.range_m", [](LookMeasurement* look) { look->range_m = -1.0; });
  refuses("look.range_sigma_m", [](LookMeasurement* look) { look->range_sigma_m = 0.0; });
  refuses("look.time_sigma_s", [](LookMeasurement* look) { look->time_sigma_s = kNotGiven; });
  refuses("look.cone", [](LookMeasurement* look) { look->cone.squint_rad = 20.0; });
  refuses("look.doppler_sigma_hz", [](LookMeasurement* look) { look->doppler_sigma_hz = 1.0; });
  refuses("look.wavelength_m", [](LookMeasurement* look) {
    look->cone.kind = Cone::Kind::kDoppler;
    look->doppler_sigma_hz = 1.0;
  });
  EXPECT_THROW((void)RangeDopplerCost(nullptr, StraightLook()), InputError);
}

TEST(CorrectedFlightTest, RefusesWhatAdjustRefuses) {
  const auto refuses = [](const Correction& correction, const char* text) {
    try {
      (void)StraightFlight({{correction, {}}});
      ADD_FAILURE() << text << ": accepted";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(text));
    }
  };
  PositionCorrection position;
  position.degree = 16;
  refuses(position, "position.degree");
  position = {};
  position.components = {false, false, false};
  refuses(position, "position.components");
  position = {};
  position.basis = PositionCorrection::Basis::kSpline;
  refuses(position, "knot");
  position = {};
  position.prior_sigma_m[1] = {-2.0};
  refuses(position, "above 0");
  refuses(RangeCorrection{}, "no parameter");
  TroposphereCorrection air;
  air.scale_height_m = 0.0;
  refuses(air, "scale_height_m");
  EXPECT_THROW(CorrectedFlight(Frame::Local(), FlightPath(), {{0.0, 1.0}}, {}), InputError);
  EXPECT_THROW(CorrectedFlight(Frame::Local(), StraightPath(), {{1.0, 1.0}}, {}), InputError);
  const std::vector<FlightCorrection> too_many(5, {PositionCorrection{}, {}});
  EXPECT_THROW((void)StraightFlight(too_many), InputError);
}

// Hand values of sizes and names; the four coefficients that act are those of the knots around.
TEST(CorrectedFlightTest, NamesItsParametersAndTheBlocksOfALook) {
  PositionCorrection spline;
  spline.basis = PositionCorrection::Basis::kSpline;
  spline.knot_spacing_s = 20.0;
  spline.components = {true, false, true};
  RangeCorrection range;
  range.bias = range.scale = true;
  const FlightPointer flight = StraightFlight({{spline, {}}, {range, {}}});
  ASSERT_EQ(flight->correction_count(), 2U);
  EXPECT_EQ(flight->BlockSize(0), 2);
  EXPECT_EQ(flight->BlockCount(0), 7U);  // four pieces of 20 s and three
  EXPECT_EQ(flight->BlockCount(1), 1U);
  EXPECT_EQ(flight->ParameterNames(1),
            (std::vector<std::string>{"range.bias [m]", "range.scale [1]"}));
  EXPECT_EQ(flight->ParameterNames(0).size(), 14U);
  EXPECT_EQ(flight->ParameterNames(0)[3], "position.up.1 [m]");
  std::array<double, 14> knots{};
  std::array<double, 2> range_value{};
  std::array<double, 3> point{};
  const std::array<double*, 2> arrays{knots.data(), range_value.data()};
  // 12.5 s is in the third piece, -40 + 2 x 20 to 20 s.
  EXPECT_EQ(flight->Blocks(point.data(), arrays, 12.5),
            (std::vector<double*>{point.data(),
                                  range_value.data(),
                                  knots.data() + 4,
                                  knots.data() + 6,
                                  knots.data() + 8,
                                  knots.data() + 10}));
  EXPECT_THROW((void)flight->Blocks(point.data(), std::span(arrays).first(1), 12.5), InputError);
  const CostPointer cost = RangeDopplerCost(flight, StraightLook());
  EXPECT_EQ(cost->parameter_block_sizes(), (std::vector<int>{3, 2, 2, 2, 2, 2}));
}

// Hand values: 100 m/s and the path moved by the correction and its drift; half the strip is 40 s.
TEST(CorrectedFlightTest, MovesTheAntenna) {
  PositionCorrection position;
  position.degree = 1;
  const FlightPointer flight = StraightFlight({{position, {}}, {TimeCorrection{}, {}}});
  std::array<double, 6> shift{1.0, 0.0, 0.0, 8.0, 3.0, 0.0};  // along, across with drift, up
  double bias_s = 2.0;
  const std::array<double*, 2> arrays{shift.data(), &bias_s};
  const auto motion = flight->At(10.0, arrays);
  ASSERT_TRUE(motion.has_value());
  // The path is read at 12 s; corrections are functions of that time.
  EXPECT_LT((motion->position_m - Eigen::Vector3d(1201.0, 8.0 * 12.0 / 40.0, 3003.0)).norm(), 1e-9);
  EXPECT_LT((motion->velocity_mps - Eigen::Vector3d(100.0, 0.2, 0.0)).norm(), 1e-12);
  EXPECT_FALSE(flight->At(49.0, arrays).has_value());
}

TEST(CorrectedFlightTest, GivesMetresAtTheTargetForASecond) {
  EXPECT_NEAR(StraightFlight({})->AzimuthUnit_m(StraightLook(), kPoint_m), 100.0, 1e-9);
  EXPECT_TRUE(std::isnan(
      StraightFlight({})->AzimuthUnit_m(StraightLook(), Eigen::Vector3d(1300.0, 0.0, 3000.0))));
}

/// A correction of every kind.
std::vector<FlightCorrection> EveryKind(PositionCorrection::Axes axes, bool spline) {
  PositionCorrection position;
  position.axes = axes;
  position.degree = 2;
  if (spline) {
    position.basis = PositionCorrection::Basis::kSpline;
    position.knot_spacing_s = 11.0;
  }
  RangeCorrection range;
  range.bias = range.scale = true;
  return {{position, {}},
          {VelocityCorrection{}, {}},
          {range, {}},
          {TimeCorrection{}, {}},
          {SquintCorrection{}, {}},
          {TroposphereCorrection{}, {}}};
}

/// A cost function of parameters in units of their own: steps of ceres::GradientChecker are the
/// same part of 1 for metres and radians.
class InUnits final : public ceres::CostFunction {
 public:
  InUnits(const ceres::CostFunction& cost, std::vector<double> units)
      : cost_(cost), units_(std::move(units)) {
    set_num_residuals(cost.num_residuals());
    *mutable_parameter_block_sizes() = cost.parameter_block_sizes();
  }
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const std::vector<int>& sizes = parameter_block_sizes();
    std::vector<std::vector<double>> values;
    std::vector<const double*> value_of;
    for (std::size_t b = 0; b < sizes.size(); ++b) {
      values.emplace_back(blocks[b], blocks[b] + sizes[b]);
      for (double& value : values.back()) value *= units_[b];
    }
    for (const std::vector<double>& value : values) value_of.push_back(value.data());
    if (!cost_.Evaluate(value_of.data(), residuals, jacobians)) return false;
    for (std::size_t b = 0; b < sizes.size() && jacobians != nullptr; ++b) {
      if (jacobians[b] == nullptr) continue;
      for (int k = 0; k < sizes[b] * num_residuals(); ++k) jacobians[b][k] *= units_[b];
    }
    return true;
  }

 private:
  const ceres::CostFunction& cost_;
  std::vector<double> units_;
};

struct GradientCase {
  bool orbit = false;
  PositionCorrection::Axes axes = PositionCorrection::Axes::kTrack;
  bool spline = false;
  bool doppler = false;
};
class GradientTest : public testing::TestWithParam<GradientCase> {};

// Difference quotients by Ridders' method. What the model leaves out, the third time derivative of
// a correction, is below 1e-6 of a partial; of the time bias, which reads the whole path elsewhere,
// it is not left out but compared with a path continued to third order: 1e-5.
TEST_P(GradientTest, AgreesWithDifferenceQuotients) {
  const GradientCase& given = GetParam();
  test::BlockPlan plan =
      given.orbit ? test::OrbitPlan(9.0, given.doppler) : test::AircraftPlan(9.0, given.doppler);
  if (given.doppler) plan.sigma = {0.7, 1.9, AzimuthUnit::kHertz};
  const test::KnownBlock known = test::MakeBlock(plan);
  const std::size_t look = known.block.looks.offsets[4];
  const std::size_t pass = known.block.looks.pass[look];
  const auto flight =
      std::make_shared<CorrectedFlight>(known.block, pass, EveryKind(given.axes, given.spline));
  const LookMeasurement measured = MeasurementOf(known.block, look, *flight, known.truth_m[4]);
  // Of the position, velocity, range (with its scale), time, squint and zenith delay.
  const std::array<double, 6> units_of{3.7, 2e-4, 1.3e-5, 1e-3, 3e-4, 2.1};
  std::vector<double> units{10.0};
  std::vector<double*> arrays(units_of.size(), nullptr);
  for (const std::size_t q : {0U, 1U, 2U, 3U, 4U, 5U}) {
    if (q > 0 || !given.spline) units.push_back(units_of[q]);
  }
  if (given.spline) units.insert(units.end(), 4, units_of[0]);
  const CostPointer cost = RangeDopplerCost(flight, measured, known.truth_m[4]);
  const InUnits scaled(*cost, units);
  std::vector<std::vector<double>> values;
  std::vector<double*> blocks;
  for (const int size : cost->parameter_block_sizes()) {
    std::vector<double>& value = values.emplace_back();
    for (int k = 0; k < size; ++k) {
      value.push_back(std::cos(0.3 + 2.3 * k + static_cast<double>(values.size())));
    }
  }
  for (std::vector<double>& value : values) blocks.push_back(value.data());
  ceres::NumericDiffOptions steps;
  steps.ridders_relative_initial_step_size = 1e-3;  // the last of ten, each twice the next
  const std::vector<const ceres::Manifold*>* no_manifolds = nullptr;
  const ceres::GradientChecker checker(&scaled, no_manifolds, steps);
  ceres::GradientChecker::ProbeResults results;
  (void)checker.Probe(blocks.data(), 1e-6, &results);
  ASSERT_TRUE(results.return_value) << results.error_log;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    // Blocks that are no splines come first: of the time bias the fourth or fifth.
    const bool time = b == (given.spline ? 3U : 4U);
    const Eigen::MatrixXd difference = results.jacobians[b] - results.numeric_jacobians[b];
    for (Eigen::Index row = 0; row < 2; ++row) {
      const double size = results.numeric_jacobians[b].row(row).norm();
      const double bound = (time ? 1e-5 : 1e-6) * std::max(size, 1e-2);
      EXPECT_LT(difference.row(row).norm(), bound)
          << "block " << b << " row " << row << " " << size;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Flights,
    GradientTest,
    testing::Values(GradientCase{false, PositionCorrection::Axes::kTrack, false, false},
                    GradientCase{false, PositionCorrection::Axes::kFrame, true, false},
                    GradientCase{false, PositionCorrection::Axes::kTrack, false, true},
                    GradientCase{true, PositionCorrection::Axes::kTrack, false, false},
                    GradientCase{true, PositionCorrection::Axes::kTrack, true, false},
                    GradientCase{true, PositionCorrection::Axes::kFrame, false, true}));

// Hand values.
TEST(PriorCostTest, DividesByTheStandardDeviations) {
  PositionCorrection position;
  position.degree = 1;
  position.components = {true, false, true};
  position.prior_sigma_m[2] = {2.5, 0.8};
  const FlightPointer flight = StraightFlight({{position, {}}, {TimeCorrection{}, {}}});
  const CostPointer cost = PriorCost(*flight, 0);
  ASSERT_NE(cost, nullptr);
  std::array<double, 4> x{7.0, 8.0, 5.0, -1.2};
  const Evaluated at = Evaluate(*cost, {x.data()});
  ASSERT_TRUE(at.has_value);
  ASSERT_EQ(at.residuals.size(), 2U);
  EXPECT_NEAR(at.residuals[0], 2.0, 1e-15);
  EXPECT_NEAR(at.residuals[1], -1.5, 1e-15);
  EXPECT_EQ(at.jacobians[0], (std::vector<double>{0.0, 0.0, 0.4, 0.0, 0.0, 0.0, 0.0, 1.25}));
  EXPECT_EQ(PriorCost(*flight, 1), nullptr);
}

TEST(PriorCostTest, IsThatOfOneCoefficientOfASpline) {
  PositionCorrection position;
  position.basis = PositionCorrection::Basis::kSpline;
  position.knot_spacing_s = 20.0;
  position.prior_sigma_m[1] = {4.0};
  const CostPointer cost = PriorCost(*StraightFlight({{position, {}}}), 0);
  std::array<double, 3> x{1.0, 6.0, 3.0};
  const Evaluated at = Evaluate(*cost, {x.data()});
  ASSERT_EQ(at.residuals.size(), 1U);
  EXPECT_NEAR(at.residuals[0], 1.5, 1e-15);
}

// Hand values: in a local frame east, north, up are the axes; sigma 2 m in x and 0.5 m in z.
TEST(KnownPositionCostTest, IsTheDistanceInStandardDeviations) {
  KnownPosition known;
  known.fixed = {true, false, true};
  known.covariance_enu_m2(0, 0) = 4.0;
  known.covariance_enu_m2(2, 2) = 0.25;
  const CostPointer cost =
      KnownPositionCost(Frame::Local(), known, {100.0, 50.0, 7.0}, {90.0, 40.0, 0.0});
  ASSERT_EQ(cost->num_residuals(), 2);
  Eigen::Vector3d block(13.0, 99.0, 8.0);
  const Evaluated at = Evaluate(*cost, {block.data()});
  ASSERT_TRUE(at.has_value);
  EXPECT_NEAR(at.residuals[0], 1.5, 1e-15);
  EXPECT_NEAR(at.residuals[1], 2.0, 1e-15);
  EXPECT_EQ(at.jacobians[0], (std::vector<double>{0.5, 0.0, 0.0, 0.0, 0.0, 2.0}));
  known.fixed = {false, false, false};
  EXPECT_THROW((void)KnownPositionCost(Frame::Local(), known, kPoint_m), InputError);
}

}  // namespace
}  // namespace sarblock
