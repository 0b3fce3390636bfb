// SPDX-License-Identifier: Apache-2.0
#include "stability_corrections.h"

#include <algorithm>
#include <cmath>

namespace sarblock {
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
         plan.strip_factor_1 = v;
         plan.options.groups = {Drift(3, 3.7)};
         return plan;
       }},
      {"start-error",
       "error_m",
       "start coordinates far off",
       With(0.0, Ratios(1.0, 1e5, 12)),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.start_error_m = v;
         return plan;
       }},
      {"orbit-start-error",
       "error_m",
       "start coordinates far off, from orbit",
       With(0.0, Ratios(1.0, 1e6, 12)),
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
       With(0.0, Ratios(1.0, 1e9, 10)),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.time_origin_s = v;
         return plan;
       }},
      {"time-origin-bias",
       "origin_s",
       "the same from orbit, with time biases",
       With(0.0, Ratios(1.0, 1e9, 10)),
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
       With(0.0, Ratios(1e-3, 1e2, 10)),
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

}  // namespace sarblock
