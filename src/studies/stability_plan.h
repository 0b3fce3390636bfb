// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/options.h"
#include "sarblock/simulate/scene.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// One pass of a block of the stability study; it looks at the middle of the area.
struct PlannedPass {
  LookSide side = LookSide::kLeft;
  double heading_rad = 0.0;     ///< of the flight, from x or east towards north
  double ground_range_m = 0.0;  ///< from below the antenna to the middle of the area
  double height_m = 0.0;        ///< of the antenna above the middle of the area
  double squint_rad = 0.0;
  double range_sigma_factor = 1.0;
};

struct PlannedControl {
  std::size_t point = 0;
  std::array<double, 3> sigma_enu_m{};
  double correlation_en = 0.0;
};

/// A flight with trajectory errors that is recorded with errors; the looks are those of the true
/// flight.
struct PlannedRecording {
  SceneTrajectoryError trajectory_error;
  SceneRecorder recorder;  ///< its rate is needed
};

/// A small block by its geometry and weights, with noise of its own standard deviations.
struct StabilityPlan {
  bool orbit =
      false;  ///< circular orbits about a body that does not turn, geocentric; else straight
  double body_radius_m = 0.0;  ///< orbit: radius of a sphere; 0: WGS84
  std::vector<PlannedPass> passes;
  std::size_t points = 10;
  double along_m = 3900.0, across_m = 3900.0;  ///< half the area, along x or east and across it
  double relief_m = 640.0;
  double speed_mps = 173.4;
  double swing_m = 5.3;               ///< of the antenna about its straight line
  double doppler_wavelength_m = 0.0;  ///< > 0: the cone is written as a Doppler centroid
  LookSigma sigma{0.83, 1.21, AzimuthUnit::kMetres};
  double noise = 1.0;  ///< drawn, in standard deviations
  std::vector<PlannedControl> control;
  double control_spread = 1.0;  ///< < 1: control points drawn together about the middle
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();  ///< added to all coordinates (not orbit)
  double time_origin_s = 391.7;
  std::size_t states = 41;     ///< of a path that is not recorded, and of the planned flight
  double time_margin_s = 0.0;  ///< by which paths are longer at either end
  std::optional<PlannedRecording> recording;
  double strip_factor = 0.0;   ///< > 0: strip spans given, this many times the looks' own
  double start_error_m = 0.0;  ///< > 0: points get start coordinates this far off
  double blunder = 0.0;        ///< added to the first range, in standard deviations
  double path_error_m = 0.0;   ///< by which the first pass is shifted in all axes
  AdjustOptions options;
  std::uint64_t seed = 1978;
};

/// Five passes of an aircraft, three of which look left, one right and one across them, ten points
/// of which three are control, and drifts of the paths under a prior.
[[nodiscard]] StabilityPlan AircraftPlan();
/// Four passes of an orbit 700 km high.
[[nodiscard]] StabilityPlan OrbitPlan();

/// Position corrections of a polynomial, the same prior for all degrees; NaN: none.
[[nodiscard]] CorrectionGroup Drift(int degree, double prior_sigma_m);

/// Throws InputError where a pass of the plan cannot see its area.
[[nodiscard]] Block MakeStabilityBlock(const StabilityPlan& plan);

/// A family with the way from its number to a block.
struct PlannedFamily {
  const char* name;
  const char* parameter;
  const char* about;
  std::vector<double> values;
  StabilityPlan (*plan)(double value);
  bool whole = false;
};

/// `count` values from `from` to `to` with equal ratios.
[[nodiscard]] std::vector<double> Ratios(double from, double to, int count);
[[nodiscard]] std::vector<double> Prepend(double first, std::vector<double> rest);
/// The same standard deviation for all components of all control points.
void SetControlSigma(double sigma_m, StabilityPlan* plan);

/// Families that push the geometry of a block.
[[nodiscard]] const std::vector<PlannedFamily>& GeometryFamilies();

/// Families that push the corrections of a block.
[[nodiscard]] const std::vector<PlannedFamily>& CorrectionFamilies();

/// Families that push the weights of a block.
[[nodiscard]] const std::vector<PlannedFamily>& WeightFamilies();

/// Families of recorded flights: noise, spacing and contradictions of the states, and the deviation
/// of a flight from a straight line.
[[nodiscard]] const std::vector<PlannedFamily>& RecordingFamilies();

/// A family of small blocks that one number pushes from comfortable to impossible.
struct StabilityFamily {
  std::string name;       ///< "intersection-angle"
  std::string parameter;  ///< what the number is, with its unit: "angle_deg"
  std::string about;      ///< one sentence for people
  std::vector<double> values;
  bool whole = false;  ///< the number counts something
};

/// All families with the values they are run with by default (docs/studies/stability.md).
[[nodiscard]] std::vector<StabilityFamily> StabilityFamilies();

/// All families, in the order they are run.
[[nodiscard]] std::vector<const PlannedFamily*> PlannedFamilies();

/// The block of a step of a family; throws InputError for a family that does not exist.
[[nodiscard]] StabilityPlan PlanOf(const std::string& family, double value);

}  // namespace sarblock
