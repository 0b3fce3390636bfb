// SPDX-License-Identifier: Apache-2.0
#include "stability_geometry.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>

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

/// Squints in degrees up to a sight line along the flight.
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
       With(0.0, Ratios(1e4, 1e-6, 16)),
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
       With(0.0, Ratios(1e4, 1e-4, 13)),
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
         HoldControlTo(1e-3, &plan);
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
       With(0.0, Ratios(3e5, 1e-2, 14)),
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

}  // namespace sarblock
