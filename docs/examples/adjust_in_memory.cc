// SPDX-License-Identifier: Apache-2.0
// A block made in memory and adjusted: two strips with shifted flight paths, four control points at
// the corners and 15 tie points between them. docs/api.md explains it.
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <sarblock/adjust/adjust.h>
#include <sarblock/core/statistics.h>

namespace {

using Eigen::Vector3d;

constexpr double kSpeed_mps = 150.0, kHeight_m = 6000.0, kSigma_m = 0.5;

// [pass]
// Flight along +x at y = y0, looking left, so toward +y. States every 10 s.
sarblock::Pass StraightPass(const std::string& id, double y0_m) {
  std::vector<sarblock::StateVector> states;
  for (double time_s = -10.0; time_s <= 60.0; time_s += 10.0) {
    states.push_back({time_s, {kSpeed_mps * time_s, y0_m, kHeight_m}, {kSpeed_mps, 0.0, 0.0}});
  }
  sarblock::Pass pass;
  pass.id = id;
  pass.side = sarblock::LookSide::kLeft;
  pass.path = sarblock::FlightPath(states);
  pass.sigma = {kSigma_m, kSigma_m, sarblock::AzimuthUnit::kMetres};
  return pass;
}
// [pass]

}  // namespace

int main() {
  // [block]
  sarblock::Block block;
  block.name = "in memory";
  block.passes = {StraightPass("A", 0.0), StraightPass("B", 4000.0)};
  const Vector3d shift_m[] = {{-2.0, 3.0, 1.0}, {6.0, -4.0, 2.5}};  // what the paths do not know

  std::vector<Vector3d> truth_m;
  std::vector<std::uint32_t> point_of_look;
  sarblock::RandomStream random(2026, 1);
  for (int i = 0; i < 19; ++i) {
    const bool control = i < 4;
    const double x_m = control ? (i % 2) * 6000.0 : 600.0 + 1200.0 * (i % 5);
    const double y_m = control ? 8000.0 + (i / 2) * 4000.0 : 9000.0 + 1000.0 * (i % 3);
    truth_m.push_back({x_m, y_m, 40.0 * std::sin(0.9 * i)});
    const auto point = block.points.ids.Append((control ? "C" : "T") + std::to_string(i));
    block.points.role.push_back(control ? sarblock::PointRole::kControl
                                        : sarblock::PointRole::kTie);
    block.points.given_m.push_back(control ? truth_m.back()
                                           : Vector3d::Constant(sarblock::kNotGiven));
    if (control) {
      block.points.known.push_back(
          {point, {true, true, true}, 0.05 * 0.05 * Eigen::Matrix3d::Identity()});
    }
    // Zero Doppler: the antenna is where the point is, along the flight.
    for (std::uint32_t pass = 0; pass < 2; ++pass) {
      const Vector3d antenna_m = shift_m[pass] + Vector3d(x_m, 4000.0 * pass, kHeight_m);
      const Vector3d d_m = truth_m.back() - Vector3d(x_m, antenna_m.y(), antenna_m.z());
      point_of_look.push_back(point);
      block.looks.pass.push_back(pass);
      block.looks.flags.push_back(0);
      block.looks.time_s.push_back((x_m - shift_m[pass].x() + kSigma_m * random.Normal()) /
                                   kSpeed_mps);
      block.looks.range_m.push_back(d_m.norm() + kSigma_m * random.Normal());
    }
  }
  sarblock::SortLooksByPoint(point_of_look, block.points.size(), &block.looks);
  sarblock::SetStripSpans({}, &block);
  // [block]

  // [adjust]
  sarblock::AdjustOptions options;
  options.groups = {{"position", sarblock::PositionCorrection{}}};  // a shift of every pass
  const sarblock::AdjustResult result = sarblock::Adjust(block, options);
  // [adjust]

  // [print]
  std::printf("accepted %d, s0^2 %.2f, redundancy %.0f\n",
              result.accepted() ? 1 : 0,
              result.sigma0_squared,
              result.redundancy());
  for (const sarblock::ParameterResult& parameter : result.parameters) {
    std::printf("%s %-16s %7.2f +- %.2f m\n",
                parameter.owner.c_str(),
                parameter.name.c_str(),
                parameter.value,
                parameter.sigma);
  }
  const std::size_t last = block.points.size() - 1;
  const sarblock::SymmetricEnu& covariance_m2 = result.points.covariance_m2[last];
  const Vector3d error_m = result.points.position_m[last] - truth_m[last];
  std::printf("T%zu sigma %.2f %.2f %.2f m, true error %.2f %.2f %.2f m\n",
              last,
              std::sqrt(covariance_m2[0]),
              std::sqrt(covariance_m2[1]),
              std::sqrt(covariance_m2[2]),
              error_m.x(),
              error_m.y(),
              error_m.z());
  // [print]

  // As a test: every true shift within four of its standard deviations.
  bool right = result.accepted() && result.parameters.size() == 6;
  for (std::size_t i = 0; right && i < 6; ++i) {
    const double error = result.parameters[i].value - shift_m[i / 3][static_cast<int>(i % 3)];
    right = std::abs(error) < 4.0 * result.parameters[i].sigma;
  }
  return right ? 0 : 1;
}
