// SPDX-License-Identifier: Apache-2.0
#include "stability_weights.h"

#include <algorithm>
#include <cmath>

namespace sarblock {
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
         plan.passes[0].range_sigma_factor_1 = v;
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
         HoldControlTo(v, &plan);
         return plan;
       }},
      {"orbit-control-sigma",
       "sigma_m",
       "the same from orbit",
       Ratios(1e-9, 1e6, 16),
       [](double v) {
         StabilityPlan plan = OrbitPlan();
         HoldControlTo(v, &plan);
         return plan;
       }},
      {"control-spread",
       "part_of_area",
       "control drawn together in one place, drifts free",
       Ratios(0.99, 1e-9, 13),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.control_spread_1 = v;
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
         for (PlannedControl& control : plan.control) control.correlation_en_1 = 1.0 - v;
         return plan;
       }},
      {"noise",
       "sigmas",
       "looks that contradict each other",
       With(0.0, Ratios(1e-6, 1e4, 13)),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.noise_1 = v;
         return plan;
       }},
      {"blunder",
       "sigmas",
       "one range far off",
       With(0.0, Ratios(1.0, 1e6, 13)),
       [](double v) {
         StabilityPlan plan = AircraftPlan();
         plan.sigma = {0.0083, 0.0121, AzimuthUnit::kMetres};
         plan.blunder_1 = v;
         return plan;
       }},
  };
  return kFamilies;
}

}  // namespace sarblock
