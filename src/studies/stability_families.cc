// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/core/id_table.h"

#include <algorithm>
#include <cmath>

#include "stability_plan.h"

namespace sarblock {
namespace {

/// Four passes of one side along x, antenna i at elevation and distance from the middle.
StabilityPlan OneSide(double heading_rad = 0.0) {
  StabilityPlan plan = AircraftPlan();
  plan.swing_m = 0.0;
  plan.passes.assign(4, {LookSide::kLeft, heading_rad, 9370.0, 9130.0});
  return plan;
}

/// Area and relief no larger than the height allows.
void FitArea(double height_m, StabilityPlan* plan) {
  plan->along_m = plan->across_m = std::min(3900.0, 0.3 * height_m);
  plan->relief_m = std::min(640.0, 0.05 * height_m);
  plan->swing_m = std::min(5.3, 1e-3 * height_m);
}

/// Squints in degrees up to a line of sight along the flight.
const std::vector<double>& Squints() {
  static const std::vector<double> kSquints_deg = {
      0, 0.1, 1, 5, 10, 20, 30, 45, 60, 70, 80, 85, 88, 89, 89.5, 89.9};
  return kSquints_deg;
}

StabilityPlan Squinted(double squint_deg) {
  StabilityPlan plan = AircraftPlan();
  for (PlannedPass& pass : plan.passes) pass.squint_rad = squint_deg * kRadPerDeg;
  return plan;
}

/// Their Doppler centroids are given in place of angles.
StabilityPlan SquintedByDoppler(double squint_deg) {
  StabilityPlan plan = Squinted(squint_deg);
  plan.doppler_wavelength_m = 0.031;
  return plan;
}

}  // namespace

const std::vector<PlannedFamily>& GeometryFamilies() {
  static const std::vector<PlannedFamily> kFamilies = {
      {"intersection-angle",
       "angle_deg",
       "four passes of one side within an angle at the points",
       Ratios(60.0, 1e-6, 16),
       [](double v) {
         StabilityPlan plan = OneSide();
         for (std::size_t i = 0; i < 4; ++i) {
           const double elevation = (45.0 + v * (static_cast<double>(i) / 3.0 - 0.5)) * kRadPerDeg;
           plan.passes[i].ground_range_m = 13000.0 * std::cos(elevation);
           plan.passes[i].height_m = 13000.0 * std::sin(elevation);
         }
         return plan;
       }},
      {"base",
       "base_m",
       "four passes of one side at one height within a base",
       Prepend(0.0, Ratios(1e4, 1e-6, 16)),
       [](double v) {
         StabilityPlan plan = OneSide();
         for (std::size_t i = 0; i < 4; ++i) {
           plan.passes[i].ground_range_m += v * static_cast<double>(i) / 3.0;
         }
         return plan;
       }},
      {"altitude-difference",
       "difference_m",
       "four passes over one ground track",
       Prepend(0.0, Ratios(1e4, 1e-4, 13)),
       [](double v) {
         StabilityPlan plan = OneSide();
         for (std::size_t i = 0; i < 4; ++i) {
           plan.passes[i].height_m += v * static_cast<double>(i) / 3.0;
         }
         return plan;
       }},
      {"crossing-angle",
       "angle_deg",
       "passes of one place whose tracks cross at an angle",
       Ratios(90.0, 1e-6, 14),
       [](double v) {
         StabilityPlan plan = OneSide();
         for (std::size_t i = 0; i < 4; ++i) {
           plan.passes[i].heading_rad = v * kRadPerDeg * static_cast<double>(i) / 3.0;
         }
         return plan;
       }},
      {"height",
       "height_m",
       "the same look angles from any height over an area that stays",
       Ratios(100.0, 1e9, 15),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         for (PlannedPass& pass : plan.passes) {
           pass.ground_range_m *= v / 9130.0;
           pass.height_m *= v / 9130.0;
         }
         FitArea(v, &plan);
         return plan;
       }},
      {"height-over-base",
       "height_m",
       "bases that stay, under 45 degrees from any height",
       Ratios(5e3, 1e9, 14),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         for (PlannedPass& pass : plan.passes) {
           pass.ground_range_m += v - 9370.0;
           pass.height_m += v - 9130.0;
         }
         FitArea(v, &plan);
         return plan;
       }},
      {"squint", "squint_deg", "all passes squinted", Squints(), Squinted},
      {"doppler",
       "squint_deg",
       "the same, given as Doppler centroids",
       Squints(),
       SquintedByDoppler},
      {"measured-doppler",
       "squint_deg",
       "the same, the Doppler centroids measured at exact times",
       Squints(),
       [](double v) {
         StabilityPlan plan = SquintedByDoppler(v);
         plan.sigma = {0.83, 1.3, AzimuthUnit::kHertz};
         return plan;
       }},
      {"near-nadir",
       "incidence_deg",
       "passes over the points, looking down",
       Ratios(45.0, 1e-6, 14),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         const double tangent = std::tan(v * kRadPerDeg);
         for (PlannedPass& pass : plan.passes) {
           pass.heading_rad = 0.0;
           pass.ground_range_m *= tangent;
         }
         plan.swing_m = std::min(5.3, 0.01 * 9370.0 * tangent);
         plan.across_m = std::min(3900.0, 0.4 * 9370.0 * tangent);
         return plan;
       }},
      {"grazing",
       "elevation_deg",
       "sight lines along the ground",
       Ratios(45.0, 1e-6, 14),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         for (PlannedPass& pass : plan.passes) pass.height_m *= std::tan(v * kRadPerDeg);
         plan.swing_m = std::min(5.3, 1e-3 * plan.passes[0].height_m);
         plan.relief_m = std::min(640.0, 0.1 * plan.passes[0].height_m);
         return plan;
       }},
      {"coordinates",
       "distance_m",
       "a local frame whose origin is far away",
       Ratios(1.0, 1e9, 13),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.origin_m = {v, -0.7 * v, 0.0};
         return plan;
       }},
      {"coordinates-fine",
       "distance_m",
       "the same with millimetres",
       Ratios(1.0, 1e9, 13),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.origin_m = {v, -0.7 * v, 0.0};
         plan.sigma = {0.83e-3, 1.21e-3, AzimuthUnit::kMetres};
         SetControlSigma(1e-3, &plan);
         return plan;
       }},
      {"coordinates-up",
       "distance_m",
       "heights that count from far below",
       Ratios(1.0, 1e9, 10),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.origin_m = {0.0, 0.0, v};
         return plan;
       }},
      {"area",
       "half_width_m",
       "points ever closer together",
       Ratios(4e3, 1e-6, 13),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.along_m = plan.across_m = v;
         plan.relief_m = 0.2 * v;
         return plan;
       }},
      {"strip-length",
       "length_m",
       "parallel strips of any length",
       Ratios(10.0, 1e6, 13),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         for (PlannedPass& pass : plan.passes) pass.heading_rad = 0.0;
         plan.along_m = 0.5 * v;
         plan.options.groups = {Drift(2, 3.7)};
         return plan;
       }},
      {"looks-per-point",
       "looks",
       "passes, all of which see all points",
       {2, 3, 4, 6, 8, 12, 17, 25, 40, 60, 100, 160, 250, 500},
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.points = 4;
         plan.control.resize(1);
         plan.states = 5;
         plan.passes.clear();
         for (int i = 0; i < static_cast<int>(v); ++i) {
           plan.passes.push_back({i % 3 == 2 ? LookSide::kRight : LookSide::kLeft,
                                  0.05 * std::sin(1.7 * i),
                                  9370.0 + 4100.0 * (1.0 + std::sin(2.3 * i)),
                                  9130.0 + 300.0 * std::cos(1.1 * i)});
         }
         CorrectionGroup drift = Drift(1, 3.7);
         drift.passes = {"A1"};
         plan.options.groups = {drift};
         RangeCorrection range;
         range.bias = true;
         plan.options.groups.push_back({"range", range, {}, true});
         return plan;
       },
       true},
      {"points",
       "points",
       "few and many points",
       {1, 2, 3, 4, 6, 8, 12, 20, 30, 50},
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.points = static_cast<std::size_t>(v);
         plan.control.resize(1);
         return plan;
       },
       true},
      {"orbit-base",
       "base_m",
       "orbits of one side, geocentric",
       Prepend(0.0, Ratios(3e5, 1e-2, 14)),
       [](double v) {
         StabilityPlan plan = OrbitPlan();
         for (std::size_t i = 0; i < 4; ++i) {
           plan.passes[i] = {
               LookSide::kRight, 1.80, 391000.0 + v * static_cast<double>(i) / 3.0, 697000.0};
         }
         return plan;
       }},
      {"orbit-height",
       "height_m",
       "orbits of any height, geocentric",
       Ratios(1e5, 1e9, 13),
       [](double v) {
         StabilityPlan plan = OrbitPlan();
         for (PlannedPass& pass : plan.passes) {
           pass.ground_range_m = std::min(2e6, pass.ground_range_m * v / 697000.0);
           pass.height_m *= v / 697000.0;
         }
         return plan;
       }},
      {"body-radius",
       "radius_m",
       "orbits about a sphere of any size",
       Ratios(1e2, 1e9, 13),
       [](double v) {
         StabilityPlan plan = OrbitPlan();
         const double part = v / 6378000.0;
         plan.body_radius_m = v;
         plan.speed_mps *= part;
         plan.along_m *= part;
         plan.across_m *= part;
         plan.relief_m *= part;
         plan.sigma = {std::min(1.17, 1e-5 * v), std::min(1.21, 1e-5 * v), AzimuthUnit::kMetres};
         for (PlannedPass& pass : plan.passes) {
           pass.ground_range_m *= part;
           pass.height_m *= part;
         }
         return plan;
       }},
  };
  return kFamilies;
}

namespace {

constexpr double kWithoutPrior = std::numeric_limits<double>::quiet_NaN();

std::vector<double> Integers(int from, int to) {
  std::vector<double> out;
  for (int i = from; i <= to; ++i) out.push_back(i);
  return out;
}

CorrectionGroup Spline(double pieces, double prior_sigma_m, const StabilityPlan& plan) {
  PositionCorrection position;
  position.basis = PositionCorrection::Basis::kSpline;
  // The strip of a pass along x is about as long as the area.
  position.knot_spacing_s = 2.0 * plan.along_m / plan.speed_mps / pieces;
  if (std::isfinite(prior_sigma_m)) position.prior_sigma_m.fill({prior_sigma_m});
  return {"spline", position, {"A1"}, false};
}

template <typename Model>
void AddGroup(const std::string& name, const Model& model, StabilityPlan* plan) {
  plan->options.groups.push_back({name, model, {}, false});
}

}  // namespace

const std::vector<PlannedFamily>& CorrectionFamilies() {
  static const std::vector<PlannedFamily> kFamilies = {
      {"degree",
       "degree",
       "polynomials under a prior",
       Integers(0, 15),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.options.groups = {Drift(static_cast<int>(v), 3.7)};
         return plan;
       },
       true},
      {"degree-free",
       "degree",
       "polynomials without a prior, 20 points, half of them control",
       Integers(0, 15),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.points = 20;
         plan.control.clear();
         for (std::size_t i = 0; i < 20; i += 2) plan.control.push_back({i, {0.53, 0.47, 0.41}});
         plan.options.groups = {Drift(static_cast<int>(v), kWithoutPrior)};
         return plan;
       },
       true},
      {"spline-knots",
       "pieces",
       "a spline in one pass under a prior, knots denser than looks",
       {1, 2, 3, 4, 6, 8, 11, 16, 23, 32, 45, 64},
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.options.groups = {Spline(v, 3.7, plan)};
         return plan;
       }},
      {"spline-knots-free",
       "pieces",
       "the same without a prior",
       {1, 2, 3, 4, 6, 8, 11, 16, 23, 32, 45, 64},
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.options.groups = {Spline(v, kWithoutPrior, plan)};
         return plan;
       }},
      {"spline-prior",
       "sigma_m",
       "eight pieces under priors from tight to loose",
       Ratios(1e-6, 1e9, 13),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.options.groups = {Spline(8.0, v, plan)};
         return plan;
       }},
      {"strip-span",
       "factor",
       "a strip given far longer than its looks",
       Ratios(1.0, 1e9, 10),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.strip_factor = v;
         plan.options.groups = {Drift(3, 3.7)};
         return plan;
       }},
      {"start-error",
       "error_m",
       "start coordinates far off",
       Prepend(0.0, Ratios(1.0, 1e5, 12)),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.start_error_m = v;
         return plan;
       }},
      {"orbit-start-error",
       "error_m",
       "start coordinates far off, from orbit",
       Prepend(0.0, Ratios(1.0, 1e6, 12)),
       [](double v) {
         StabilityPlan plan = OrbitPlan();
         plan.start_error_m = v;
         return plan;
       }},
      {"path-error",
       "error_m",
       "one path far off, priors of the size of the error",
       Ratios(1e-3, 1e5, 13),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.path_error_m = v;
         plan.options.groups = {Drift(1, std::max(3.7, v))};
         return plan;
       }},
      {"path-error-tight",
       "error_m",
       "one path far off, priors that do not know",
       Ratios(1e-3, 1e5, 13),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.path_error_m = v;
         return plan;
       }},
      {"time-origin",
       "origin_s",
       "times that count from long ago",
       Prepend(0.0, Ratios(1.0, 1e9, 10)),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.time_origin_s = v;
         return plan;
       }},
      {"time-origin-bias",
       "origin_s",
       "the same from orbit, with time biases",
       Prepend(0.0, Ratios(1.0, 1e9, 10)),
       [](double v) {
         StabilityPlan plan = OrbitPlan();
         plan.time_origin_s = v;
         plan.sigma = {0.117, 2.3e-5, AzimuthUnit::kSeconds};
         AddGroup("time", TimeCorrection{1e-3}, &plan);
         return plan;
       }},
      {"speed",
       "speed_mps",
       "azimuth in seconds at any speed",
       Ratios(1e-3, 1e8, 12),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.speed_mps = v;
         plan.sigma = {0.83, 1.21 / v, AzimuthUnit::kSeconds};
         return plan;
       }},
      {"states",
       "states",
       "state vectors of a path",
       {2, 3, 5, 9, 17, 33, 65, 129, 257, 513, 1025, 4097},
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.states = static_cast<std::size_t>(v);
         return plan;
       },
       true},
      {"swing",
       "swing_m",
       "antennas that leave their line",
       Prepend(0.0, Ratios(1e-3, 1e2, 10)),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.swing_m = v;
         return plan;
       }},
      {"range-scale",
       "sigma_1",
       "prior of a range scale beside drifts",
       Ratios(1e-12, 1e3, 12),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         RangeCorrection range;
         range.scale = true;
         range.scale_prior_sigma = v;
         AddGroup("range", range, &plan);
         return plan;
       }},
      {"swath",
       "half_width_m",
       "range bias, across and up all free on a narrow swath",
       Ratios(4e3, 1e-3, 12),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.across_m = v;
         plan.relief_m = 0.1 * v;
         RangeCorrection range;
         range.bias = true;
         AddGroup("range", range, &plan);
         return plan;
       }},
      {"velocity",
       "sigma_1",
       "prior of the directions of flight",
       Ratios(1e-12, 1e2, 12),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         VelocityCorrection velocity;
         velocity.prior_sigma = {v, v};
         AddGroup("velocity", velocity, &plan);
         return plan;
       }},
      {"squint-bias",
       "sigma_rad",
       "prior of squint biases",
       Ratios(1e-12, 1e2, 12),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         for (PlannedPass& pass : plan.passes) pass.squint_rad = 0.21;
         AddGroup("squint", SquintCorrection{v}, &plan);
         return plan;
       }},
      {"time-bias",
       "sigma_s",
       "prior of time biases beside drifts",
       Ratios(1e-12, 1e3, 12),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         AddGroup("time", TimeCorrection{v}, &plan);
         return plan;
       }},
      {"troposphere",
       "sigma_m",
       "prior of zenith delays from orbit",
       Ratios(1e-6, 1e6, 12),
       [](double v) {
         StabilityPlan plan = OrbitPlan();
         TroposphereCorrection troposphere;
         troposphere.zenith_prior_sigma_m = v;
         AddGroup("troposphere", troposphere, &plan);
         return plan;
       }},
  };
  return kFamilies;
}

namespace {

constexpr double kNoPrior = std::numeric_limits<double>::quiet_NaN();

}  // namespace

const std::vector<PlannedFamily>& WeightFamilies() {
  static const std::vector<PlannedFamily> kFamilies = {
      {"sigma-ratio",
       "azimuth_over_range",
       "azimuth against range",
       Ratios(1e-8, 1e8, 17),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.sigma.azimuth = plan.sigma.range_m * v;
         return plan;
       }},
      {"pass-sigma-ratio",
       "first_over_others",
       "one pass against the others",
       Ratios(1e-8, 1e8, 17),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.passes[0].range_sigma_factor = v;
         return plan;
       }},
      {"sigma-level",
       "sigma_m",
       "all looks alike, control and priors as they are",
       Ratios(1e-9, 1e5, 15),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.sigma = {v, v, AzimuthUnit::kMetres};
         return plan;
       }},
      {"orbit-sigma-level",
       "sigma_m",
       "the same from orbit",
       Ratios(1e-9, 1e5, 15),
       [](double v) {
         StabilityPlan plan = OrbitPlan();
         plan.sigma = {v, v, AzimuthUnit::kMetres};
         return plan;
       }},
      {"prior",
       "sigma_m",
       "priors of the drifts, three control points",
       Ratios(1e-6, 1e9, 16),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.options.groups = {Drift(1, v)};
         return plan;
       }},
      {"prior-alone",
       "sigma_m",
       "priors of the drifts, no control",
       Ratios(1e-6, 1e9, 16),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.options.groups = {Drift(1, v)};
         plan.control.clear();
         return plan;
       }},
      {"one-control-point",
       "prior_sigma_m",
       "priors of the drifts, one control point",
       Ratios(1e-3, 1e9, 13),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.options.groups = {Drift(1, v)};
         plan.control.resize(1);
         return plan;
       }},
      {"orbit-prior",
       "sigma_m",
       "priors of the drifts of orbits, no control",
       Ratios(1e-6, 1e9, 16),
       [](double v) {
         StabilityPlan plan = OrbitPlan();
         plan.options.groups = {Drift(1, v)};
         plan.control.clear();
         return plan;
       }},
      {"control-sigma",
       "sigma_m",
       "three control points of any quality",
       Ratios(1e-9, 1e6, 16),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         SetControlSigma(v, &plan);
         return plan;
       }},
      {"orbit-control-sigma",
       "sigma_m",
       "the same from orbit",
       Ratios(1e-9, 1e6, 16),
       [](double v) {
         StabilityPlan plan = OrbitPlan();
         SetControlSigma(v, &plan);
         return plan;
       }},
      {"control-spread",
       "part_of_area",
       "control drawn together in one place, drifts free",
       Ratios(0.99, 1e-9, 13),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.control_spread = v;
         plan.control.push_back({8, {0.53, 0.47, 0.41}});
         plan.options.groups = {Drift(1, kNoPrior)};
         return plan;
       }},
      {"control-correlation",
       "one_minus_correlation",
       "east and north of control almost one number",
       Ratios(1.0, 1e-15, 13),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         for (PlannedControl& control : plan.control) control.correlation_en = 1.0 - v;
         return plan;
       }},
      {"noise",
       "sigmas",
       "looks that contradict each other",
       Prepend(0.0, Ratios(1e-6, 1e4, 13)),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.noise = v;
         return plan;
       }},
      {"blunder",
       "sigmas",
       "one range far off",
       Prepend(0.0, Ratios(1.0, 1e6, 13)),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.sigma = {0.0083, 0.0121, AzimuthUnit::kMetres};
         plan.blunder = v;
         return plan;
       }},
  };
  return kFamilies;
}

namespace {

/// The aircraft's flight, recorded at 10 Hz.
StabilityPlan RecordedAircraft(PathThrough through) {
  StabilityPlan plan = AircraftPlan();
  plan.states = 401;
  plan.recording.emplace();
  plan.recording->recorder.rate_hz = 10.0;
  plan.recording->recorder.reading.through = through;
  return plan;
}

/// An orbit with four states and more beyond either end of the strip, as interpolation of degree 7
/// needs them.
StabilityPlan RecordedOrbit(double interval_s) {
  StabilityPlan plan = OrbitPlan();
  plan.states = 2001;
  plan.time_margin_s = 4.5 * interval_s;
  plan.recording.emplace();
  plan.recording->recorder.rate_hz = 1.0 / interval_s;
  plan.recording->recorder.reading.through = PathThrough::kAuto;
  return plan;
}

}  // namespace

const std::vector<PlannedFamily>& RecordingFamilies() {
  static const std::vector<PlannedFamily> kFamilies = {
      {"state-noise",
       "noise_m",
       "noise of the positions recorded at 10 Hz, paths through the states",
       Prepend(0.0, Ratios(1e-7, 1.0, 15)),
       [](double v) {
         StabilityPlan plan = RecordedAircraft(PathThrough::kStates);
         plan.recording->recorder.noise_m = v;
         return plan;
       }},
      {"state-noise-smoothed",
       "noise_m",
       "the same and of velocities, paths smoothed where the data ask for it",
       Prepend(0.0, Ratios(1e-7, 10.0, 17)),
       [](double v) {
         StabilityPlan plan = RecordedAircraft(PathThrough::kAuto);
         plan.recording->recorder.noise_m = v;
         plan.recording->recorder.noise_mps = 0.5 * v;
         return plan;
       }},
      {"wander",
       "rms_m",
       "flights of turbulent air, recorded with 2 cm and 1 cm/s",
       Ratios(1e-3, 1e3, 13),
       [](double v) {
         StabilityPlan plan = RecordedAircraft(PathThrough::kAuto);
         plan.recording->recorder.noise_m = 0.02;
         plan.recording->recorder.noise_mps = 0.01;
         plan.recording->trajectory_error.rms_m.fill(v);
         plan.recording->trajectory_error.time_constant_s.fill(20.0);
         return plan;
       }},
      {"state-interval",
       "interval_s",
       "orbits whose states stand far apart",
       Ratios(1.0, 600.0, 12),
       [](double v) { return RecordedOrbit(v); }},
      {"velocity-contradiction",
       "bias_mps",
       "orbits whose velocities are not those of their positions, every 10 s",
       Prepend(0.0, Ratios(1e-6, 100.0, 9)),
       [](double v) {
         StabilityPlan plan = RecordedOrbit(10.0);
         plan.recording->recorder.velocity_bias_sigma_mps.fill(v);
         return plan;
       }},
  };
  return kFamilies;
}

std::vector<StabilityFamily> StabilityFamilies() {
  std::vector<StabilityFamily> out;
  for (const PlannedFamily* family : PlannedFamilies()) {
    out.push_back({family->name, family->parameter, family->about, family->values, family->whole});
  }
  return out;
}

std::vector<const PlannedFamily*> PlannedFamilies() {
  std::vector<const PlannedFamily*> out;
  for (const std::vector<PlannedFamily>* part :
       {&GeometryFamilies(), &WeightFamilies(), &CorrectionFamilies(), &RecordingFamilies()}) {
    for (const PlannedFamily& family : *part) out.push_back(&family);
  }
  return out;
}

StabilityPlan PlanOf(const std::string& name, double value) {
  std::vector<std::string> names;
  const PlannedFamily* found = nullptr;
  for (const PlannedFamily* family : PlannedFamilies()) {
    names.emplace_back(family->name);
    if (name == family->name) found = family;
  }
  if (found == nullptr) {
    throw InputError("family",
                     "'" + name + "' does not exist" + DidYouMean(NearestName(name, names)));
  }
  return found->plan(value);
}

}  // namespace sarblock
