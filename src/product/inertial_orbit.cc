// SPDX-License-Identifier: Apache-2.0
#include "inertial_orbit.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <fmt/core.h>

namespace sarblock {
namespace {

void CheckAttitudes(InertialOrbit* orbit) {
  const auto fail = [orbit](std::size_t index, const char* problem) {
    throw InputError(FilePlace{orbit->file, 0, fmt::format("body rotation {}", index + 1)},
                     problem);
  };
  if (orbit->body.empty()) fail(0, "is missing, one or more are needed");
  for (std::size_t i = 0; i < orbit->body.size(); ++i) {
    BodyAttitude& attitude = orbit->body[i];
    if (!std::isfinite(attitude.time_s) || !attitude.rate_radps.allFinite()) {
      fail(i, "is not finite");
    }
    if (i > 0 && !(attitude.time_s > orbit->body[i - 1].time_s)) fail(i, "times must increase");
    if (!(std::abs(attitude.rotation.norm() - 1.0) < 1e-6)) {
      fail(i, "the quaternion is not one of a rotation: its length is not 1");
    }
    attitude.rotation.normalize();
  }
  const Eigen::Matrix3d product = orbit->constant * orbit->constant.transpose();
  if (!((product - Eigen::Matrix3d::Identity()).norm() < 1e-6)) {
    throw InputError(FilePlace{orbit->file, 0, "constant rotation"}, "is no rotation");
  }
}

BodyAttitude AttitudeAt(const InertialOrbit& orbit, double time_s) {
  const std::vector<BodyAttitude>& body = orbit.body;
  if (body.size() == 1) {
    BodyAttitude attitude = body.front();
    const Eigen::Vector3d turn_rad = attitude.rate_radps * (time_s - attitude.time_s);
    // Axes that turn with the body: coordinates of inertial vectors turn back.
    const Eigen::Vector3d axis = turn_rad.norm() > 0.0 ? Eigen::Vector3d(turn_rad.normalized())
                                                       : Eigen::Vector3d(Eigen::Vector3d::UnitZ());
    attitude.rotation = attitude.rotation * Eigen::AngleAxisd(-turn_rad.norm(), axis);
    return attitude;
  }
  const auto above = std::upper_bound(
      body.begin() + 1, body.end() - 1, time_s, [](double t, const BodyAttitude& attitude) {
        return t < attitude.time_s;
      });
  const BodyAttitude& a = *(above - 1);
  const BodyAttitude& b = *above;
  const double part = (time_s - a.time_s) / (b.time_s - a.time_s);
  return {time_s,
          a.rotation.slerp(part, b.rotation),
          (1.0 - part) * a.rate_radps + part * b.rate_radps};
}

}  // namespace

std::vector<StateVector> BodyFixedStates(const InertialOrbit& orbit, double step_s) {
  InertialOrbit checked = orbit;
  CheckAttitudes(&checked);
  const FlightPath path = [&orbit] {
    try {
      return FlightPath(orbit.states);
    } catch (const InputError& error) {
      throw InputError(FilePlace{orbit.file, 0, "instrument position"}, error.what());
    }
  }();
  constexpr double kMostSteps = 1e6;
  if (path.end_s() - path.start_s() > kMostSteps * step_s) {
    throw InputError(FilePlace{orbit.file, 0, "instrument position"},
                     fmt::format("states go over {:.3g} s, which no image takes",
                                 path.end_s() - path.start_s()));
  }
  std::vector<StateVector> states;
  const auto append = [&](const StateVector& inertial) {
    const BodyAttitude attitude = AttitudeAt(checked, inertial.time_s);
    const Eigen::Matrix3d fixed = checked.constant * attitude.rotation.toRotationMatrix();
    states.push_back(
        {inertial.time_s,
         fixed * inertial.position_m,
         fixed * (inertial.velocity_mps - attitude.rate_radps.cross(inertial.position_m))});
  };
  for (std::size_t k = 0; k < orbit.states.size(); ++k) {
    append(orbit.states[k]);
    if (k + 1 == orbit.states.size()) break;
    const double span_s = orbit.states[k + 1].time_s - orbit.states[k].time_s;
    const double parts = std::max(1.0, std::ceil(span_s / step_s - 1e-9));
    for (double part = 1.0; part < parts; part += 1.0) {
      const double time_s = orbit.states[k].time_s + span_s * (part / parts);
      const auto motion = path.At(time_s);
      if (motion) append({time_s, motion->position_m, motion->velocity_mps});
    }
  }
  return states;
}

}  // namespace sarblock
