// SPDX-License-Identifier: Apache-2.0
#include "model/look_model.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <array>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include "model/look_model_twin.h"
#include "support/small_blocks.h"
#include <Eigen/Geometry>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using Digits50 = boost::multiprecision::number<boost::multiprecision::cpp_bin_float<50>,
                                               boost::multiprecision::et_off>;
using Twin = test::LookModelTwin<Digits50>;
using test::operator+;

CorrectionGroup Own(const std::string& name, decltype(CorrectionGroup::model) model) {
  return {name, std::move(model), {}, false};
}
CorrectionGroup Shared(const std::string& name,
                       decltype(CorrectionGroup::model) model,
                       std::vector<std::string> passes = {}) {
  return {name, std::move(model), std::move(passes), true};
}

/// Every kind at once: polynomial of degree 5 of each pass, shared spline and shared polynomial.
std::vector<CorrectionGroup> PolynomialGroups(double knot_spacing_s) {
  PositionCorrection polynomial;
  polynomial.degree = 5;
  PositionCorrection frame_polynomial;
  frame_polynomial.degree = 2;
  frame_polynomial.axes = PositionCorrection::Axes::kFrame;
  PositionCorrection spline;
  spline.basis = PositionCorrection::Basis::kSpline;
  spline.knot_spacing_s = knot_spacing_s;
  RangeCorrection range;
  range.bias = range.scale = true;
  TroposphereCorrection wet;
  wet.scale_height_m = 2100.0;
  return {Own("position", polynomial),
          Shared("fleet", frame_polynomial, {"A1", "A3"}),
          Shared("wave", spline, {"A1", "A2"}),
          Own("velocity", VelocityCorrection{}),
          Own("range", range),
          Shared("radar", range),
          Own("time", TimeCorrection{}),
          Shared("clock", TimeCorrection{}),
          Own("squint", SquintCorrection{}),
          Shared("mount", SquintCorrection{}),
          Shared("attitude", VelocityCorrection{}),
          Own("troposphere", TroposphereCorrection{}),
          Shared("wet", wet, {"A2", "A3"})};
}

/// Splines of each pass in frame axes, components missing here and there.
std::vector<CorrectionGroup> SplineGroups(double knot_spacing_s) {
  PositionCorrection spline;
  spline.basis = PositionCorrection::Basis::kSpline;
  spline.axes = PositionCorrection::Axes::kFrame;
  spline.knot_spacing_s = knot_spacing_s;
  spline.components = {true, false, true};
  PositionCorrection track;
  track.degree = 4;
  track.components = {false, true, true};
  VelocityCorrection velocity;
  velocity.components = {false, true};
  RangeCorrection scale;
  scale.scale = true;
  return {Own("position", spline),
          Shared("drift", track),
          Own("velocity", velocity),
          Own("range", scale),
          Own("time", TimeCorrection{})};
}

/// What a straight pass is evaluated for by a shorter way: constant and drift, and ranges.
std::vector<CorrectionGroup> StraightGroups() {
  PositionCorrection drift;
  drift.components = {true, false, true};
  PositionCorrection constant;
  constant.degree = 0;
  constant.axes = PositionCorrection::Axes::kFrame;
  RangeCorrection range;
  range.bias = range.scale = true;
  CorrectionGroup first = Own("drift", drift), second = Own("constant", constant);
  first.passes = {"A1", "A2"};
  second.passes = {"A3"};
  return {first, second, Own("range", range), Shared("radar", range)};
}

/// Biases of the time beside corrections that vary slowly: offset and drift.
std::vector<CorrectionGroup> TimeGroups() {
  PositionCorrection drift;
  drift.degree = 1;
  return {Own("position", drift),
          Own("velocity", VelocityCorrection{}),
          Own("time", TimeCorrection{}),
          Shared("clock", TimeCorrection{}),
          Own("squint", SquintCorrection{})};
}

/// Corrections as large as bad ones are: the model has to be right away from zero.
constexpr double kPositionSize_m = 27.0;
double SizeOf(const Parameter& parameter) {
  if (parameter.name.starts_with("velocity")) return 1.7e-3;
  if (parameter.name == "range.scale") return 3.1e-5;
  if (parameter.unit == "s") return 0.043;
  if (parameter.unit == "rad") return 2.3e-3;
  if (parameter.name.starts_with("troposphere")) return 2.4;
  return kPositionSize_m;
}

enum class Groups { kPolynomials, kSplines, kStraight, kTimes };

struct Case {
  const char* name;
  bool orbit;
  double squint_deg;
  bool doppler;
  Groups groups;
  bool measured = false;  ///< the Dopplers are, at exact times
};
std::ostream& operator<<(std::ostream& out, const Case& c) { return out << c.name; }

class LookModelTest : public testing::TestWithParam<Case> {};

// An independent route: the model's text in 50 digits, velocities as numerical derivatives of
// positions and partials as numerical derivatives of errors (step 1e-12, so right to 1e-20).
TEST_P(LookModelTest, AgreesWithItsTwinInFiftyDigits) {
  const Case& c = GetParam();
  test::BlockPlan plan = c.orbit ? test::OrbitPlan(c.squint_deg, c.doppler)
                                 : test::AircraftPlan(c.squint_deg, c.doppler);
  plan.points = 2;
  if (c.measured) plan.sigma = {0.7, 3.1, AzimuthUnit::kHertz};
  const test::KnownBlock known = test::MakeBlock(plan);
  const Block& block = known.block;
  const double length_s = block.passes[0].end_s - block.passes[0].start_s;
  const double speed_mps = block.passes[0].path.states()[0].velocity_mps.norm();
  const std::vector<CorrectionGroup> groups =
      c.groups == Groups::kSplines    ? SplineGroups(length_s / 2.7)
      : c.groups == Groups::kStraight ? StraightGroups()
      : c.groups == Groups::kTimes    ? TimeGroups()
                                      : PolynomialGroups(length_s / 3.4);
  const ParameterLayout layout = MakeParameterLayout(block, groups);
  LookModel model(block, layout);
  const Twin twin(block, groups);

  RandomStream random(20260714, c.orbit ? 1 : 2);
  Eigen::VectorXd x(layout.size());
  std::map<std::pair<std::string, std::string>, Digits50> values;
  for (int i = 0; i < layout.size(); ++i) {
    const Parameter& parameter = layout.parameters[static_cast<std::size_t>(i)];
    x[i] = SizeOf(parameter) * (2.0 * random.Uniform() - 1.0);
    ASSERT_TRUE(values.emplace(std::pair(parameter.owner, parameter.name), x[i]).second);
  }
  const Twin::Value value = [&values](const std::string& owner, const std::string& name) {
    return values.at({owner, name});
  };
  model.Anchor(x);
  // Coordinates of 7e6 m are rounded to 1e-9 m before anything is computed with them.
  const double error_bound_m = c.orbit ? 4e-9 : 1e-10;
  const Digits50 step("1e-12");
  for (std::size_t j = 0; j < block.points.size(); ++j) {
    for (std::size_t i = block.looks.offsets[j]; i < block.looks.offsets[j + 1]; ++i) {
      const Eigen::Vector3d start_m = known.truth_m[j] + Eigen::Vector3d(31.7, -12.3, 8.9);
      const Eigen::Vector3d displacement_m(-17.3, 23.9, -4.1);
      LookColumns columns;
      model.ColumnsOf(i, &columns);
      std::vector<double> local(static_cast<std::size_t>(columns.column_count));
      GatherColumns(layout, columns, x, local.data());
      LookEvaluation at;
      ASSERT_TRUE(model.Evaluate({i, columns, start_m, displacement_m, local.data()}, {}, &at));

      auto p = test::Cast<Digits50>(start_m) + test::Cast<Digits50>(displacement_m);
      const Digits50 read = model.paths()[block.looks.pass[i]].ReadingTime_s(block.looks.time_s[i],
                                                                             block.looks.time_s[i]);
      const auto errors = twin.Errors(i, p, value, read);
      EXPECT_NEAR(at.whitened_error[0], static_cast<double>(errors.range), error_bound_m);
      EXPECT_NEAR(at.whitened_error[1] * at.azimuth_unit_m,
                  static_cast<double>(errors.azimuth) * at.azimuth_unit_m,
                  error_bound_m);

      // Norm of the columns of one unit: what 1e-12 is relative to. (Not row by row: at zero
      // Doppler the range partial by time is what is left of 7 km/s.)
      std::map<std::string, double> square;
      std::vector<std::pair<std::string, Eigen::Vector2d>> differences;
      const auto compare = [&](const std::string& unit,
                               const Eigen::Vector2d& computed,
                               Digits50* variable) {
        const Digits50 middle = *variable;
        *variable = middle + step;
        const auto above = twin.Errors(i, p, value, read);
        *variable = middle - step;
        const auto below = twin.Errors(i, p, value, read);
        *variable = middle;
        const Eigen::Vector2d expected(
            static_cast<double>((above.range - below.range) / (2 * step)),
            at.azimuth_unit_m * static_cast<double>((above.azimuth - below.azimuth) / (2 * step)));
        square[unit] += expected.squaredNorm();
        differences.emplace_back(unit, computed - expected);
      };
      for (Eigen::Index k = 0; k < 3; ++k) {
        compare("point",
                {at.d_point(0, k), at.azimuth_unit_m * at.d_point(1, k)},
                &p[static_cast<std::size_t>(k)]);
      }
      int column = 0;
      for (int b = 0; b < columns.block_count; ++b) {
        const ParameterBlock& parameters =
            layout.blocks[static_cast<std::size_t>(columns.block[static_cast<std::size_t>(b)])];
        for (int k = 0; k < parameters.size; ++k, ++column) {
          const Parameter& parameter =
              layout.parameters[static_cast<std::size_t>(parameters.offset + k)];
          compare(parameter.unit,
                  {at.row[0][static_cast<std::size_t>(column)],
                   at.azimuth_unit_m * at.row[1][static_cast<std::size_t>(column)]},
                  &values[{parameter.owner, parameter.name}]);
        }
      }
      EXPECT_EQ(column, columns.column_count);
      for (std::size_t k = 0; k < differences.size(); ++k) {
        const auto& [unit, difference] = differences[k];
        // The crossing is found to 1e-12 of the range (src/model/look_evaluation.h). In that time
        // two things change: a Legendre polynomial of degree 5 by 15 in half of a pass at most, and
        // the rate at which the cone passes over the point by the third derivative of the
        // corrections, 420 over the cube of half a pass for a metre of that polynomial.
        const double found_s = 1e-12 * block.looks.range_m[i] / speed_mps;
        const double half_s = 0.5 * length_s;
        const double jerk_mps3 =
            c.groups == Groups::kPolynomials ? kPositionSize_m * 420.0 / std::pow(half_s, 3) : 0.0;
        const double turning_per_s = jerk_mps3 * block.looks.range_m[i] / (speed_mps * speed_mps);
        const double bound =
            unit == "m" ? 15.0 * found_s / half_s : 1e-11 + turning_per_s * found_s;
        EXPECT_LE(difference.norm(), bound * std::sqrt(square[unit]))
            << i << " column " << k << " of " << unit;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    EveryCorrection,
    LookModelTest,
    testing::Values(Case{"aircraft_zero_doppler", false, 0.0, false, Groups::kPolynomials},
                    Case{"aircraft_squint", false, 17.3, false, Groups::kSplines},
                    Case{"aircraft_doppler", false, 6.1, true, Groups::kPolynomials},
                    Case{"straight_zero_doppler", false, 0.0, false, Groups::kStraight},
                    Case{"straight_squint", false, 17.3, false, Groups::kStraight},
                    Case{"straight_doppler", false, 6.1, true, Groups::kStraight},
                    Case{"aircraft_times", false, 17.3, false, Groups::kTimes},
                    Case{"orbit_times", true, 21.7, false, Groups::kTimes},
                    Case{"orbit_zero_doppler", true, 0.0, false, Groups::kSplines},
                    Case{"orbit_squint", true, 21.7, false, Groups::kPolynomials},
                    Case{"orbit_doppler", true, -3.3, true, Groups::kSplines},
                    Case{"aircraft_measured", false, 6.1, true, Groups::kPolynomials, true},
                    Case{"aircraft_measured_times", false, 20.0, true, Groups::kTimes, true},
                    Case{"straight_measured", false, -17.3, true, Groups::kStraight, true},
                    Case{"orbit_measured", true, 21.7, true, Groups::kPolynomials, true},
                    Case{"orbit_measured_times", true, -3.3, true, Groups::kTimes, true},
                    Case{"orbit_measured_splines", true, 0.0, true, Groups::kSplines, true}),
    [](const testing::TestParamInfo<Case>& tested) { return std::string(tested.param.name); });

/// Metres along track at its target that a unit of the azimuth of look 0 is, at corrections x.
double AzimuthUnit_m(const test::KnownBlock& known,
                     const std::vector<CorrectionGroup>& groups,
                     const Eigen::VectorXd& x,
                     const Eigen::Vector3d& displacement_m) {
  const ParameterLayout layout = MakeParameterLayout(known.block, groups);
  const LookModel model(known.block, layout);
  LookColumns columns;
  model.ColumnsOf(0, &columns);
  std::vector<double> local(static_cast<std::size_t>(columns.column_count));
  GatherColumns(layout, columns, x, local.data());
  LookEvaluation at;
  EXPECT_TRUE(
      model.Evaluate({0, columns, known.truth_m[0], displacement_m, local.data()}, {}, &at));
  return at.azimuth_unit_m;
}

// Second route: eq. (10a) by the rates of range and cone, without corrections.
TEST(AzimuthUnitTest, IsTheSpeedAtWhichTheLookPassesOverItsTarget) {
  for (const bool doppler : {false, true}) {
    for (const double squint_deg : {-3.3, 0.0, 21.7}) {
      const test::KnownBlock known = test::MakeBlock(test::OrbitPlan(squint_deg, doppler));
      const Motion motion = *known.block.passes[0].path.At(known.block.looks.time_s[0]);
      const double along_mps = LookTimeRates(known.truth_m[0],
                                             motion.position_m,
                                             motion.velocity_mps,
                                             motion.acceleration_mps2,
                                             known.block.ConeOf(0))
                                   .along_mps;
      EXPECT_LT(along_mps, 0.95 * motion.velocity_mps.norm());
      EXPECT_NEAR(AzimuthUnit_m(known, {}, {}, {0, 0, 0}), along_mps, 1e-9 * along_mps);
    }
  }
}

// Invariance: a path that is shifted with its points, or flown faster past them, leaves the weights
// as they are; those of its own velocity would change by a third here.
TEST(AzimuthUnitTest, IsThatOfTheGivenPath) {
  test::KnownBlock known = test::MakeBlock(test::OrbitPlan(0.0));
  const Pass& pass = known.block.passes[0];
  known.block.looks.time_s[0] = 0.5 * (pass.start_s + pass.end_s);
  const Motion motion = *pass.path.At(known.block.looks.time_s[0]);
  const Eigen::Vector3d across_m = motion.velocity_mps.cross(motion.position_m).normalized() * 4e5;
  known.truth_m[0] = motion.position_m + across_m - 0.1 * motion.position_m;
  PositionCorrection constant;
  constant.degree = 0;
  constant.axes = PositionCorrection::Axes::kFrame;
  PositionCorrection drift;
  drift.components = {true, false, false};
  const double unit_m = AzimuthUnit_m(known, {}, {}, {0, 0, 0});
  const Eigen::Vector3d shift_m(270.0, -310.0, 190.0);
  Eigen::VectorXd shift =
      Eigen::VectorXd::Zero(MakeParameterLayout(known.block, {Own("shift", constant)}).size());
  shift.head<3>() = shift_m;
  EXPECT_NEAR(AzimuthUnit_m(known, {Own("shift", constant)}, shift, shift_m), unit_m, 1e-8);
  Eigen::VectorXd faster =
      Eigen::VectorXd::Zero(MakeParameterLayout(known.block, {Own("drift", drift)}).size());
  faster[1] = motion.velocity_mps.norm() * (pass.end_s - pass.start_s) / 6.0;
  EXPECT_NEAR(AzimuthUnit_m(known, {Own("drift", drift)}, faster, {0, 0, 0}), unit_m, 1e-8);
}

/// One look of an aircraft block with time bias and troposphere.
class LookModelDomainTest : public testing::Test {
 protected:
  LookModelDomainTest()
      : known_(test::MakeBlock(test::AircraftPlan())),
        layout_(MakeParameterLayout(
            known_.block,
            {Own("time", TimeCorrection{}), Own("troposphere", TroposphereCorrection{})})),
        model_(known_.block, layout_) {
    model_.ColumnsOf(0, &columns_);
  }
  [[nodiscard]] LookValue ValueAt(const Eigen::Vector3d& p_m,
                                  double bias_s,
                                  double zenith_m = 2.3) const {
    const std::array<double, 2> x{bias_s, zenith_m};
    LookEvaluation at;
    return model_.ValueOf({0, columns_, p_m, Eigen::Vector3d::Zero(), x.data()}, {}, &at);
  }
  [[nodiscard]] bool BeyondPath(double bias_s) const {
    const std::array<double, 2> x{bias_s, 2.3};
    LookEvaluation at;
    return model_.Evaluate(
               {0, columns_, known_.truth_m[0], Eigen::Vector3d::Zero(), x.data()}, {}, &at) &&
           at.beyond_path;
  }
  test::KnownBlock known_;
  ParameterLayout layout_;
  LookModel model_;
  LookColumns columns_;
};

// On the way to a solution a time bias may lead beyond the path; that is said, and far off there is
// no value.
TEST_F(LookModelDomainTest, TellsWhereThePathIsContinuedBeyondItsEnds) {
  const FlightPath& path = known_.block.passes[0].path;
  const double time_s = known_.block.looks.time_s[0];
  EXPECT_EQ(ValueAt(known_.truth_m[0], 0.0), LookValue::kGiven);
  EXPECT_EQ(ValueAt(known_.truth_m[0], path.end_s() - time_s - 1e-6), LookValue::kGiven);
  EXPECT_FALSE(BeyondPath(path.end_s() - time_s - 1e-6));
  EXPECT_TRUE(BeyondPath(path.end_s() - time_s + 1e-6));
  EXPECT_FALSE(BeyondPath(path.start_s() - time_s + 1e-6));
  EXPECT_TRUE(BeyondPath(path.start_s() - time_s - 1e-6));
  EXPECT_EQ(ValueAt(known_.truth_m[0], 3.0 * (path.end_s() - path.start_s())),
            LookValue::kBeyondPath);
  EXPECT_EQ(ValueAt(known_.truth_m[0], kNotGiven), LookValue::kBeyondPath);
}

// A last state 30 million years late: the cubic between the states turns round the Earth at the
// rate of the orbit all that time.
TEST(LookModelTest, NamesThePassWhosePathTurnsTooFastToBeTabulated) {
  Block block = test::MakeBlock(test::OrbitPlan()).block;
  const FlightPath& path = block.passes[1].path;
  std::vector<StateVector> states;
  for (const double time_s : {path.start_s(), path.end_s()}) {
    const Motion motion = *path.At(time_s);
    states.push_back({time_s, motion.position_m, motion.velocity_mps});
  }
  states.back().time_s += 1e15;
  block.passes[1].path = FlightPath(states);
  const ParameterLayout layout =
      MakeParameterLayout(block, {Own("position", PositionCorrection{})});
  try {
    const LookModel model(block, layout);
    FAIL() << "tabulated";
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()),
              "pass " + block.passes[1].id +
                  ": states: the flight path turns around its body too fast to be tabulated");
  }
}

TEST_F(LookModelDomainTest, HasNoValueAtTheAntennaOrForALevelSight) {
  const Motion motion = *known_.block.passes[0].path.At(known_.block.looks.time_s[0]);
  EXPECT_EQ(ValueAt(motion.position_m, 0.0), LookValue::kNoCrossing);
  Eigen::Vector3d level_m = known_.truth_m[0];
  level_m.z() = motion.position_m.z();
  EXPECT_EQ(ValueAt(level_m, 0.0), LookValue::kNotAbove);
  level_m.z() -= 1.0;  // a milliradian below the horizon there is air to look through
  EXPECT_EQ(ValueAt(level_m, 0.0), LookValue::kGiven);
  EXPECT_EQ(ValueAt(Eigen::Vector3d::Constant(1e200), 0.0), LookValue::kNoCrossing);
  EXPECT_EQ(ValueAt(known_.truth_m[0], 0.0, std::numeric_limits<double>::infinity()),
            LookValue::kNotFinite);
}

// Closed form: in the middle of its strip a path with a correction c P2 across has the velocity of
// the given one and the acceleration 3 c / T^2 across more, T half the strip. The cone passes over
// a point at the distance D across with |v| - a.d / |v| (docs/theory/observations.md, eq. (10b)),
// which must be above a fiftieth of |v|.
TEST(LookModelTest, HasNoValueWhereTheConeTurnsWithThePoint) {
  test::KnownBlock known = test::MakeBlock(test::AircraftPlan(0.0));
  const Pass& pass = known.block.passes[0];
  const double half_s = 0.5 * (pass.end_s - pass.start_s), across_m = 12e3;
  known.block.looks.time_s[0] = pass.start_s + half_s;
  const Motion motion = *pass.path.At(known.block.looks.time_s[0]);
  const Eigen::Vector3d across = Eigen::Vector3d::UnitZ().cross(motion.velocity_mps).normalized();
  PositionCorrection parabola;
  parabola.degree = 2;
  parabola.axes = PositionCorrection::Axes::kFrame;
  const ParameterLayout layout = MakeParameterLayout(known.block, {Own("position", parabola)});
  const LookModel model(known.block, layout);
  LookColumns columns;
  model.ColumnsOf(0, &columns);
  const Eigen::Vector3d d_m =
      across_m * across - 8e3 * motion.velocity_mps.normalized().cross(across);
  const auto value_at = [&](double part) {
    const double turned = part * motion.velocity_mps.squaredNorm();  // a.d
    const double c_m =
        (turned - motion.acceleration_mps2.dot(d_m)) * half_s * half_s / (3.0 * across_m);
    const std::array<double, 9> x{0, 0, c_m * across.x(), 0, 0, c_m * across.y(), 0, 0, 0};
    const Eigen::Vector3d p_m = motion.position_m - 0.5 * c_m * across + d_m;
    LookEvaluation at;
    return model.ValueOf({0, columns, p_m, Eigen::Vector3d::Zero(), x.data()}, {}, &at);
  };
  EXPECT_EQ(value_at(0.979), LookValue::kGiven);
  EXPECT_EQ(value_at(0.981), LookValue::kNoCrossing);
}

}  // namespace
}  // namespace sarblock
