// SPDX-License-Identifier: Apache-2.0
// What models take off a look, against formulas written out here and against times and ranges of a
// point that was really moved.
#include "sarblock/core/error.h"
#include "sarblock/reduction/reduction.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "core/utc.h"
#include "reduction/reduction.h"
#include "support/small_blocks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::HasSubstr;

constexpr auto kTroposphere = static_cast<std::size_t>(ReductionSource::kTroposphere);
constexpr auto kIonosphere = static_cast<std::size_t>(ReductionSource::kIonosphere);
constexpr auto kTide = static_cast<std::size_t>(ReductionSource::kTide);
constexpr auto kMotion = static_cast<std::size_t>(ReductionSource::kMotion);

constexpr const char* kEpoch = "2022-10-16T01:50:44Z";

std::string DateOf(double time_s) { return UtcText(AddSeconds(ParseUtc(kEpoch).value(), time_s)); }

struct Orbits {
  explicit Orbits(double squint_deg = 0.0, bool doppler = false)
      : known(test::MakeBlock(test::OrbitPlan(squint_deg, doppler))) {
    for (Pass& pass : known.block.passes) {
      pass.epoch_utc = kEpoch;
      pass.wavelength_m = 0.0555;
    }
  }
  [[nodiscard]] LookReduction Of(const ReductionModels& models,
                                 std::size_t look,
                                 const Eigen::Vector3d& velocity_mpy = {0.0, 0.0, 0.0}) const {
    const Block& block = known.block;
    const ReductionOfLooks all(block, std::vector(block.passes.size(), models));
    return all.Of(block.looks.pass[look],
                  block.looks.time_s[look],
                  block.ConeOf(look),
                  known.truth_m[block.looks.PointOf(look)],
                  velocity_mpy);
  }
  /// Range and time of a look at a point that lies elsewhere, less those at the point: the cone's
  /// time found anew.
  [[nodiscard]] RadarCoordinates Moved(std::size_t look, const Eigen::Vector3d& by_m) const {
    const Block& block = known.block;
    const FlightPath& path = block.passes[block.looks.pass[look]].path;
    const auto seen = [&](const Eigen::Vector3d& p_m) {
      const double time_s =
          FindConeTime(path, p_m, block.ConeOf(look), path.start_s(), path.end_s()).value();
      return RadarCoordinates{time_s, (p_m - path.At(time_s)->position_m).norm()};
    };
    const Eigen::Vector3d& p_m = known.truth_m[block.looks.PointOf(look)];
    const RadarCoordinates before = seen(p_m), after = seen(p_m + by_m);
    return {after.time_s - before.time_s, after.range_m - before.range_m};
  }
  test::KnownBlock known;
};

TEST(LookReductionTest, TroposphereAndIonosphereByHeightAndIncidence) {
  const Orbits orbits;
  ReductionModels models;
  models.troposphere = TroposphereModel::kStandard;
  models.ionosphere = Ionosphere{20.0, 0.8};
  for (std::size_t look = 0; look < orbits.known.block.looks.size(); ++look) {
    const Block& block = orbits.known.block;
    const Eigen::Vector3d& p_m = orbits.known.truth_m[block.looks.PointOf(look)];
    const Geodetic place = block.frame.GeodeticFromFrame(p_m);
    const Eigen::Vector3d up{std::cos(place.lat_rad) * std::cos(place.lon_rad),
                             std::cos(place.lat_rad) * std::sin(place.lon_rad),
                             std::sin(place.lat_rad)};
    const Eigen::Vector3d to_antenna =
        block.passes[block.looks.pass[look]].path.At(block.looks.time_s[look])->position_m - p_m;
    const double zenith_rad = std::acos(up.dot(to_antenna.normalized()));
    const LookReduction at = orbits.Of(models, look);
    // Jehle et al. (2008); the curvature of the atmosphere takes some millimetres off the secant.
    const double zenith_m = place.h_m * place.h_m / 8.55e7 - place.h_m / 3411.0 + 2.41;
    const double secant_m = zenith_m / std::cos(zenith_rad);
    EXPECT_LT(at.range_m[kTroposphere], secant_m);
    EXPECT_NEAR(
        at.range_m[kTroposphere], secant_m, 2e-3 * secant_m * std::pow(std::tan(zenith_rad), 2.0));
    const double shell_rad = std::asin(6371.0 / 6821.0 * std::sin(zenith_rad));
    const double frequency_hz = 299792458.0 / 0.0555;
    EXPECT_NEAR(at.range_m[kIonosphere],
                40.3 * 20e16 * 0.8 / (frequency_hz * frequency_hz) / std::cos(shell_rad),
                1e-3);
    EXPECT_EQ(at.Time_s(), 0.0);
  }
}

TEST(LookReductionTest, AnAircraftLeavesTheAtmosphereAboveItAlone) {
  const test::KnownBlock known = test::MakeBlock(test::AircraftPlan());
  ReductionModels models;
  models.troposphere = TroposphereModel::kStandard;
  const Block& block = known.block;
  const ReductionOfLooks all(block, std::vector(block.passes.size(), models));
  const Eigen::Vector3d& p_m = known.truth_m[0];
  const Eigen::Vector3d antenna_m =
      block.passes[block.looks.pass[0]].path.At(block.looks.time_s[0])->position_m;
  const double between_m = ZenithDelay_m(p_m.z()) - ZenithDelay_m(antenna_m.z());
  const double cos_zenith = (antenna_m - p_m).normalized().z();
  EXPECT_GT(between_m, 0.0);
  EXPECT_NEAR(all.Of(block.looks.pass[0], block.looks.time_s[0], {}, p_m, Eigen::Vector3d::Zero())
                  .Range_m(),
              between_m / cos_zenith,
              3e-3 * between_m / std::pow(cos_zenith, 3.0));
}

TEST(LookReductionTest, AMovedPointIsSeenWhereTheConeMeetsIt) {
  for (const auto& [squint_deg, doppler] : {std::pair{0.0, false}, {8.0, false}, {8.0, true}}) {
    const Orbits orbits(squint_deg, doppler);
    const Block& block = orbits.known.block;
    ReductionModels tide;
    tide.solid_tide = true;
    for (std::size_t look = 0; look < block.looks.size(); ++look) {
      const Eigen::Vector3d& p_m = orbits.known.truth_m[block.looks.PointOf(look)];
      const Eigen::Vector3d tide_m =
          block.frame.EnuFromFrame(p_m).transpose() *
          SolidEarthTide_m(block.frame.GeodeticFromFrame(p_m), DateOf(block.looks.time_s[look]));
      const RadarCoordinates moved = orbits.Moved(look, tide_m);
      const LookReduction at = orbits.Of(tide, look);
      EXPECT_GT(tide_m.norm(), 0.01);
      EXPECT_NEAR(at.range_m[kTide], moved.range_m, 3e-4);  // Sun and Moon of up to 10 s before
      EXPECT_NEAR(at.time_s[kTide], moved.time_s, 5e-8);
    }
  }
}

TEST(LookReductionTest, KnownPointsMoveFromTheirEpochToTheImage) {
  Orbits orbits(5.0);
  Block& block = orbits.known.block;
  test::AddKnownPoint(0, {0.01, 0.01, 0.01}, &orbits.known);
  const Eigen::Vector3d velocity_mpy{-0.031, 0.042, 0.053};
  block.points.known[0].velocity_mpy = velocity_mpy;
  block.epoch_year = 2010.0;
  // 2022-10-16 is day 289: 2022 + 288.58/365.25, to some hours.
  const RadarCoordinates moved = orbits.Moved(0, 12.79 * velocity_mpy);
  const LookReduction at = orbits.Of({}, 0, velocity_mpy);
  EXPECT_NEAR(at.range_m[kMotion], moved.range_m, 2e-4);
  EXPECT_NEAR(at.time_s[kMotion], moved.time_s, 3e-8);
  EXPECT_GT(std::abs(moved.range_m), 0.1);
  // Through the block: only the looks of that point.
  ReducedBlock reduced(block);
  ASSERT_TRUE(reduced.HasModels());
  reduced.ReduceAt(orbits.known.truth_m);
  const Looks& looks = reduced.block().looks;
  for (std::size_t i = 0; i < looks.size(); ++i) {
    EXPECT_EQ(looks.range_delay_m[i] != 0.0, looks.PointOf(i) == 0);
  }
}

TEST(LookReductionTest, WhatIsTakenOffAddsUpAndIsReportedByPass) {
  Orbits orbits;
  Block& block = orbits.known.block;
  const Looks before = block.looks;
  block.passes[0].reduction.range_m = 1.5;
  block.passes[0].reduction.time_s = -2e-4;
  block.passes[1].reduction.troposphere = TroposphereModel::kStandard;
  block.looks.range_delay_m.assign(before.size(), 0.25);
  for (double& range_m : block.looks.range_m) range_m -= 0.25;
  ReducedBlock reduced(block);
  reduced.ReduceAt(orbits.known.truth_m);
  EXPECT_EQ(reduced.ReduceAt(orbits.known.truth_m), 0.0);
  const Looks& after = reduced.block().looks;
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_NEAR(after.range_m[i] + after.range_delay_m[i], before.range_m[i], 1e-9);
    EXPECT_NEAR(after.time_s[i] + after.time_shift_s[i], before.time_s[i], 1e-15);
    if (after.pass[i] != 1) {
      EXPECT_EQ(after.range_delay_m[i], after.pass[i] == 0 ? 1.75 : 0.25);
    }
  }
  // A point 3 m higher: some 1 mm less of air.
  std::vector<Eigen::Vector3d> higher_m = orbits.known.truth_m;
  for (Eigen::Vector3d& p_m : higher_m) p_m += 3.0 * block.frame.UpAt(p_m);
  EXPECT_NEAR(reduced.ReduceAt(higher_m, 1.0), 3.0 / 3411.0 / std::cos(0.6), 5e-4);
  std::vector<std::string> terms;
  for (const ReductionTerm& term : reduced.Report().terms) {
    terms.push_back(block.passes[term.pass].id + " " + term.term + " " + term.unit);
    if (term.term == "given") {
      EXPECT_EQ(term.mean, 0.25);
      EXPECT_EQ(term.least, 0.25);
    }
    if (term.term == "troposphere") {
      EXPECT_LT(term.least, term.largest);
    }
  }
  const std::string a = block.passes[0].id, b = block.passes[1].id, c = block.passes[2].id;
  EXPECT_THAT(terms,
              testing::ElementsAre(a + " given m",
                                   a + " constant m",
                                   a + " constant s",
                                   b + " given m",
                                   b + " troposphere m",
                                   c + " given m"));
}

TEST(LookReductionTest, SaysWhatABlockCannotHave) {
  const auto problem = [](Orbits orbits, const ReductionModels& models) {
    std::vector<ReductionModels> all(orbits.known.block.passes.size());
    all[1] = models;
    const auto found = FindProblem(orbits.known.block, all);
    return found ? std::to_string(found->pass) + " " + found->key + ": " + found->problem : "";
  };
  ReductionModels models;
  EXPECT_EQ(problem(Orbits(), models), "");
  models.range_m = 2e4;
  EXPECT_THAT(problem(Orbits(), models), HasSubstr("1 reduction.range_m: must be between"));
  models = {};
  models.time_s = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(problem(Orbits(), models), HasSubstr("reduction.time_s"));
  models = {};
  models.ionosphere = Ionosphere{1e6, 1.0};
  EXPECT_THAT(problem(Orbits(), models), HasSubstr("reduction.ionosphere.tec_tecu: must be"));
  models.ionosphere = Ionosphere{20.0, 1.0};
  Orbits unknown;
  unknown.known.block.passes[1].wavelength_m = kNotGiven;
  EXPECT_THAT(problem(unknown, models), HasSubstr("needs wavelength_m"));
  Orbits low;
  low.known = test::MakeBlock(test::AircraftPlan());
  for (Pass& pass : low.known.block.passes) pass.wavelength_m = 0.24;
  EXPECT_THAT(problem(low, models), HasSubstr("lies above the antenna"));
  models = {};
  models.troposphere = TroposphereModel::kWeather;
  models.weather = {101325.0, 288.0, 0.5, 0.0};  // pascal
  EXPECT_THAT(problem(Orbits(), models), HasSubstr("reduction.troposphere.pressure_hpa: must be"));
  models = {};
  models.solid_tide = true;
  Orbits no_date;
  no_date.known.block.passes[1].epoch_utc = "about noon";
  EXPECT_THAT(problem(no_date, models), HasSubstr("epoch_utc: tides need the date"));
  Orbits late;
  late.known.block.passes[1].epoch_utc = "2040-06-15T10:40:00Z";
  EXPECT_THAT(problem(late, models), HasSubstr("1 epoch_utc: tides need the date: must be from"));
  Orbits moon;
  moon.known.block.frame = Frame::Geocentric(NamedEllipsoid("Moon"));
  EXPECT_THAT(problem(moon, models), HasSubstr("reduction.tide: is a model of the Earth"));
  Orbits flat;
  flat.known.block.frame = Frame::Local();
  EXPECT_THAT(problem(flat, models), HasSubstr("needs a geocentric frame"));
}

}  // namespace
}  // namespace sarblock
