// SPDX-License-Identifier: Apache-2.0
#include "support/small_blocks.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

namespace sarblock::test {
namespace {

constexpr double kMiddleTime_s = 391.7;
constexpr double kEarthRate_per_s = 7.292115e-5;
constexpr double kGravity_m3_per_s2 = 3.986004418e14;
constexpr double kWavelength_m = 0.0566;

/// Straight flight at 173 m/s with a swing of some metres in y and z unless `straight`.
StateVector AircraftState(const PassPlan& plan, const Eigen::Vector3d& middle_m, double t_s) {
  const double heading = plan.heading_deg * kRadPerDeg, speed_mps = 173.4;
  const Eigen::Vector3d u(std::cos(heading), std::sin(heading), 0.0);
  const Eigen::Vector3d left(-u.y(), u.x(), 0.0);
  const double side = static_cast<double>(plan.side);
  const double a = 0.031, b = 0.043, phase = 1.3 * heading;
  const double across_m = plan.straight ? 0.0 : 7.1, up_m = plan.straight ? 0.0 : 4.7;
  StateVector state;
  state.time_s = kMiddleTime_s + t_s;
  state.position_m = middle_m + u * (speed_mps * t_s) +
                     left * (-side * plan.ground_range_m + across_m * std::sin(a * t_s + phase));
  state.position_m.z() = plan.height_m + up_m * std::cos(b * t_s - phase);
  state.velocity_mps = u * speed_mps + left * (across_m * a * std::cos(a * t_s + phase));
  state.velocity_mps.z() = -up_m * b * std::sin(b * t_s - phase);
  return state;
}

/// Circular orbit that passes beside the middle of the area at t = 0, in axes turning with Earth.
StateVector OrbitState(const PassPlan& plan, const Eigen::Vector3d& middle_m, double t_s) {
  const Frame frame = Frame::Geocentric(NamedEllipsoid("WGS84"));
  const Eigen::Matrix3d enu = frame.EnuFromFrame(middle_m);
  const double heading = plan.heading_deg * kRadPerDeg;
  const Eigen::Vector3d n = middle_m.normalized();
  Eigen::Vector3d u = enu.transpose() * Eigen::Vector3d(std::cos(heading), std::sin(heading), 0.0);
  u = (u - u.dot(n) * n).normalized();
  const double r = middle_m.norm() + plan.height_m;
  const double angle = -static_cast<double>(plan.side) * plan.ground_range_m / middle_m.norm();
  const Eigen::Vector3d s = std::cos(angle) * n + std::sin(angle) * n.cross(u);
  const double rate = std::sqrt(kGravity_m3_per_s2 / r) / r;
  const Eigen::Vector3d q = r * (std::cos(rate * t_s) * s + std::sin(rate * t_s) * u);
  const Eigen::Vector3d dq = r * rate * (std::cos(rate * t_s) * u - std::sin(rate * t_s) * s);
  const Eigen::Vector3d axis(0.0, 0.0, kEarthRate_per_s);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(-kEarthRate_per_s * t_s, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  StateVector state;
  state.time_s = kMiddleTime_s + t_s;
  state.position_m = turn * q;
  state.velocity_mps = turn * (dq - axis.cross(q));
  return state;
}

FlightPath MakePath(const BlockPlan& plan, const PassPlan& pass, const Eigen::Vector3d& middle_m) {
  std::vector<StateVector> states;
  const double step_s = plan.orbit ? 9.7 : 4.3;
  for (int k = -40; k <= 40; ++k) {
    states.push_back(plan.orbit ? OrbitState(pass, middle_m, step_s * k)
                                : AircraftState(pass, middle_m, 2.0 * step_s * k));
  }
  return FlightPath(std::move(states));
}

}  // namespace

BlockPlan AircraftPlan(double squint_deg, bool doppler) {
  BlockPlan plan;
  plan.extent_m = 3900.0;
  plan.relief_m = 640.0;
  plan.sigma = {0.83, 1.21, AzimuthUnit::kMetres};
  plan.seed = 1971;
  plan.passes = {{LookSide::kLeft, 2.3, 9370.0, 9130.0, squint_deg, doppler},
                 {LookSide::kLeft, 1.1, 17210.0, 9410.0, squint_deg, doppler},
                 {LookSide::kRight, 3.7, 11830.0, 9270.0, squint_deg, doppler},
                 {LookSide::kLeft, 93.3, 13170.0, 9050.0, squint_deg, doppler}};
  return plan;
}

BlockPlan OrbitPlan(double squint_deg, bool doppler) {
  BlockPlan plan;
  plan.orbit = true;
  plan.extent_m = 31000.0;
  plan.relief_m = 1900.0;
  plan.sigma = {1.17, 2.3e-4, AzimuthUnit::kSeconds};
  plan.seed = 1978;
  plan.passes = {{LookSide::kRight, 103.2, 391000.0, 697000.0, squint_deg, doppler},
                 {LookSide::kRight, 101.9, 633000.0, 703000.0, squint_deg, doppler},
                 {LookSide::kRight, 257.3, 477000.0, 699000.0, squint_deg, doppler}};
  return plan;
}

KnownBlock MakeBlock(const BlockPlan& plan) {
  KnownBlock known;
  Block& block = known.block;
  block.name = "small";
  if (plan.orbit) block.frame = Frame::Geocentric(NamedEllipsoid("WGS84"));
  const Eigen::Vector3d middle_m = plan.orbit ? block.frame.FrameFromGeodetic({0.713, 0.219, 0.0})
                                              : Eigen::Vector3d(20317.0, -8713.0, 0.0);
  for (std::size_t i = 0; i < plan.passes.size(); ++i) {
    Pass pass;
    pass.id = "A" + std::to_string(i + 1);
    pass.side = plan.passes[i].side;
    pass.wavelength_m = kWavelength_m;
    pass.path = MakePath(plan, plan.passes[i], middle_m);
    pass.sigma = plan.sigma;
    block.passes.push_back(std::move(pass));
  }
  const Eigen::Matrix3d enu = block.frame.EnuFromFrame(middle_m);
  Looks& looks = block.looks;
  for (std::size_t j = 0; j < plan.points; ++j) {
    RandomStream random(plan.seed, j);
    const Eigen::Vector3d place((2.0 * random.Uniform() - 1.0) * plan.extent_m,
                                (2.0 * random.Uniform() - 1.0) * plan.extent_m,
                                0.0);
    const Eigen::Vector3d p_m =
        block.frame.AtHeight(middle_m + enu.transpose() * place, random.Uniform() * plan.relief_m);
    known.truth_m.push_back(p_m);
    block.points.ids.Append("P" + std::to_string(j + 1));
    block.points.role.push_back(PointRole::kTie);
    block.points.given_m.push_back(Eigen::Vector3d::Constant(kNotGiven));
    const std::size_t passes = plan.passes.size();
    for (std::size_t i = 0; i < passes; ++i) {
      const std::size_t turn = (i + passes - j % passes) % passes;
      if (plan.looks_per_point > 0 && turn >= plan.looks_per_point) continue;
      const FlightPath& path = block.passes[i].path;
      const double squint_rad = plan.passes[i].squint_deg * kRadPerDeg;
      Cone cone;
      cone.squint_rad = squint_rad;
      double doppler_hz = 0.0;
      if (plan.passes[i].doppler) {
        const double speed_mps = path.states()[3].velocity_mps.norm();
        doppler_hz = 2.0 * speed_mps * std::sin(squint_rad) / kWavelength_m;
        cone = {Cone::Kind::kDoppler, 0.0, 0.5 * kWavelength_m * doppler_hz};
      }
      const auto found_s = FindConeTime(path, p_m, cone, path.start_s(), path.end_s());
      const auto time_s = found_s ? SolveConeTime(path, p_m, cone, *found_s) : found_s;
      if (!time_s) throw std::logic_error("the plan has a pass that misses its area");
      looks.pass.push_back(static_cast<std::uint32_t>(i));
      looks.flags.push_back(plan.passes[i].doppler ? std::uint8_t{Looks::kDoppler}
                                                   : std::uint8_t{0});
      looks.time_s.push_back(*time_s);
      looks.range_m.push_back((p_m - path.At(*time_s)->position_m).norm());
      looks.cone.push_back(plan.passes[i].doppler ? doppler_hz : squint_rad);
    }
    looks.offsets.push_back(looks.pass.size());
  }
  SetStripSpans(std::vector<std::optional<std::array<double, 2>>>(block.passes.size()), &block);
  // Explicit spans at least as long as the area, wider than the looks: noise does not move them,
  // and two neighbouring points do not make a strip of a second.
  for (Pass& pass : block.passes) {
    const double middle_s = 0.5 * (pass.start_s + pass.end_s);
    const double least_s = plan.extent_m / pass.path.states().front().velocity_mps.norm();
    const double half_s = std::max(0.5 * (pass.end_s - pass.start_s), least_s);
    pass.start_s = middle_s - half_s - 0.73;
    pass.end_s = middle_s + half_s + 0.59;
  }
  return known;
}

void AddKnownPoint(std::size_t point,
                   const std::array<double, 3>& sigma_enu_m,
                   KnownBlock* known,
                   PointRole role,
                   double correlation_en) {
  Points& points = known->block.points;
  points.role[point] = role;
  points.given_m[point] = known->truth_m[point];
  KnownPosition position;
  position.point = static_cast<std::uint32_t>(point);
  for (std::size_t i = 0; i < 3; ++i) {
    position.fixed[i] = std::isfinite(sigma_enu_m[i]);
    const auto k = static_cast<Eigen::Index>(i);
    if (position.fixed[i]) position.covariance_enu_m2(k, k) = sigma_enu_m[i] * sigma_enu_m[i];
  }
  if (position.fixed[0] && position.fixed[1]) {
    const double cov_m2 = correlation_en * sigma_enu_m[0] * sigma_enu_m[1];
    position.covariance_enu_m2(0, 1) = position.covariance_enu_m2(1, 0) = cov_m2;
  }
  auto at = points.known.begin();
  while (at != points.known.end() && at->point < position.point) ++at;
  points.known.insert(at, position);
}

void AddNoise(std::uint64_t seed, double factor, KnownBlock* known) {
  Block& block = known->block;
  for (std::size_t j = 0; j < block.points.size(); ++j) {
    for (std::size_t i = block.looks.offsets[j]; i < block.looks.offsets[j + 1]; ++i) {
      RandomStream random(seed, i);
      const LookSigma sigma = block.SigmaOf(i);
      if (block.MeasuresDoppler(i)) {
        block.looks.range_m[i] += factor * sigma.range_m * random.Normal();
        block.looks.cone[i] += factor * sigma.azimuth * random.Normal();
        continue;
      }
      double sigma_s = sigma.azimuth;
      if (sigma.azimuth_unit == AzimuthUnit::kMetres) {
        const Pass& pass = block.passes[block.looks.pass[i]];
        Cone cone;
        const bool doppler = (block.looks.flags[i] & Looks::kDoppler) != 0;
        if (doppler) {
          cone = {Cone::Kind::kDoppler, 0.0, 0.5 * pass.wavelength_m * block.looks.cone[i]};
        } else {
          cone.squint_rad = block.looks.cone[i];
        }
        const Motion motion = *pass.path.At(block.looks.time_s[i]);
        sigma_s /= std::abs(EvaluateCone(motion, known->truth_m[j], cone).rate_mps);
      }
      block.looks.range_m[i] += factor * sigma.range_m * random.Normal();
      block.looks.time_s[i] += factor * sigma_s * random.Normal();
    }
  }
}

void ShiftPath(std::size_t pass, const Eigen::Vector3d& shift_m, Block* block) {
  std::vector<StateVector> states = block->passes[pass].path.states();
  for (StateVector& state : states) state.position_m += shift_m;
  block->passes[pass].path = FlightPath(std::move(states));
}

double DistanceInSigmas(const Frame& frame,
                        const Eigen::Vector3d& a_m,
                        const Eigen::Vector3d& b_m,
                        const SymmetricEnu& covariance_m2) {
  const Eigen::Vector3d d_m = frame.EnuFromFrame(a_m) * (b_m - a_m);
  const Eigen::Matrix3d c_m2 = MatrixOf(covariance_m2);
  return std::sqrt(d_m.dot(c_m2.llt().solve(d_m)));
}

}  // namespace sarblock::test
