// SPDX-License-Identifier: Apache-2.0
// Radar looks beside frame-camera rays in a ceres::Problem of one's own. docs/own_problem.md
// explains it.
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <ceres/autodiff_cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <sarblock/core/statistics.h>
#include <sarblock/cost/look_cost.h>
#include <sarblock/cost/problem_covariance.h>
#include <sarblock/geometry/look_equations.h>

using Eigen::Vector3d;

namespace {

constexpr double kRangeSigma_m = 0.5, kTimeSigma_s = 0.004, kImageSigma = 5e-5;
constexpr std::array<std::size_t, 4> kControl{0, 7, 32, 39};  // at the corners
constexpr double kStationSigma_m = 0.3, kShiftSigma_m = 3.0, kBiasSigma_m = 10.0;

// [frame]
/// A ray of a vertical frame camera: image coordinates over focal length. The station is unknown.
struct FrameRay {
  Eigen::Vector2d image;
  Vector3d origin_m;  // of the point's block, as that of its radar looks

  template <typename T>
  bool operator()(const T* point, const T* station, T* residuals) const {
    const T below_m = station[2] - (point[2] + origin_m.z());
    for (int k = 0; k < 2; ++k) {
      residuals[k] = ((point[k] + origin_m[k] - station[k]) / below_m - image[k]) / kImageSigma;
    }
    return true;
  }
};
// [frame]

/// (x - known) / sigma of three unknowns.
struct Near {
  Vector3d known_m;
  double sigma_m;

  template <typename T>
  bool operator()(const T* x, T* residuals) const {
    for (int k = 0; k < 3; ++k) residuals[k] = (x[k] - known_m[k]) / sigma_m;
    return true;
  }
};

/// What is unknown, and what was measured of it.
struct Survey {
  std::vector<Vector3d> truth_m, origins_m;
  std::vector<sarblock::FlightPointer> strips;
  std::vector<std::vector<sarblock::LookMeasurement>> looks;  // by strip and point
  std::vector<Vector3d> gps_m;                                // of the stations
  std::vector<std::vector<Eigen::Vector2d>> images;           // by station and point
};

/// Two strips and six frames over 40 points. The strips are a few metres off, all ranges 6.5 m too
/// long, and of each strip one range is 60 m off.
Survey Measure() {
  Survey out;
  sarblock::RandomStream random(2027, 1);
  const auto noise = [&random](double sigma) { return sigma * random.Normal(); };
  for (int i = 0; i < 40; ++i) {
    out.truth_m.emplace_back(700.0 * (i % 8), 9000.0 + 900.0 * (i / 8), 90.0 * std::sin(1.7 * i));
    out.origins_m.push_back(out.truth_m.back() + Vector3d(30.0, -20.0, 25.0));  // all that is known
  }
  // [flight]
  sarblock::PositionCorrection shift;  // a constant along, across and up, of each strip its own
  shift.prior_sigma_m = {std::vector<double>{kShiftSigma_m}, {kShiftSigma_m}, {kShiftSigma_m}};
  sarblock::RangeCorrection bias;  // of both strips
  bias.bias = true;
  bias.bias_prior_sigma_m = kBiasSigma_m;
  for (const double y_m : {0.0, 4000.0}) {
    std::vector<sarblock::StateVector> states;
    for (double t_s = -10.0; t_s <= 60.0; t_s += 10.0) {
      states.push_back({t_s, {150.0 * t_s, y_m, 6000.0}, {150.0, 0.0, 0.0}});
    }
    out.strips.push_back(std::make_shared<sarblock::CorrectedFlight>(
        sarblock::Frame::Local(),
        sarblock::FlightPath(states),
        sarblock::FlightOptions{{0.0, 40.0}},
        std::vector<sarblock::FlightCorrection>{{shift, {}}, {bias, {}}}));
  }
  // [flight]
  std::array<std::array<double, 3>, 2> shifts_m{{{-2.1, 3.4, 1.2}, {2.6, -1.9, 2.2}}};
  double bias_m = 6.5;
  for (std::size_t strip = 0; strip < 2; ++strip) {
    out.looks.emplace_back();
    const std::array<double*, 2> arrays{shifts_m[strip].data(), &bias_m};
    for (const Vector3d& p_m : out.truth_m) {
      // [predict]
      const double near_s = p_m.x() / 150.0;
      const sarblock::Motion antenna = *out.strips[strip]->At(near_s, arrays);
      sarblock::LookGeometry seen;
      seen.line_of_sight_m = p_m - antenna.position_m;
      seen.motion = antenna;
      sarblock::LookPrediction predicted;
      if (!sarblock::PredictLook(seen, &predicted)) throw std::runtime_error("not seen");
      // [predict]
      sarblock::LookMeasurement look;
      look.time_s = near_s + predicted.delay_s + noise(kTimeSigma_s);
      look.range_m = predicted.range_m + bias_m + noise(kRangeSigma_m);
      look.range_sigma_m = kRangeSigma_m;
      look.time_sigma_s = kTimeSigma_s;
      out.looks.back().push_back(look);
    }
    out.looks.back()[11 + strip].range_m += 60.0;
  }
  for (int i = 0; i < 6; ++i) {
    const Vector3d station_m(500.0 + 2000.0 * (i % 3), 9500.0 + 2400.0 * (i / 3), 5000.0);
    out.gps_m.push_back(station_m + Vector3d(noise(0.3), noise(0.3), noise(0.3)));
    out.images.emplace_back();
    for (const Vector3d& p_m : out.truth_m) {
      const Vector3d d_m = p_m - station_m;
      out.images.back().emplace_back(d_m.x() / -d_m.z() + noise(kImageSigma),
                                     d_m.y() / -d_m.z() + noise(kImageSigma));
    }
  }
  return out;
}

/// Solves for the points by radar, by frames or by both, and prints errors and standard deviations.
void Solve(const Survey& survey, bool radar, bool optical, const char* name) {
  // [unknowns]
  std::vector<Vector3d> points(survey.truth_m.size(), Vector3d::Zero());  // from their origins
  std::vector<Vector3d> stations_m = survey.gps_m;
  std::array<std::array<double, 3>, 2> shifts_m{};
  double bias_m = 0.0;  // one for both strips: the same pointer
  ceres::Problem problem;
  // [unknowns]
  // [radar]
  for (std::size_t strip = 0; radar && strip < 2; ++strip) {
    const sarblock::FlightPointer& flight = survey.strips[strip];
    const std::array<double*, 2> arrays{shifts_m[strip].data(), &bias_m};
    for (std::size_t i = 0; i < points.size(); ++i) {
      const sarblock::LookMeasurement& look = survey.looks[strip][i];
      problem.AddResidualBlock(
          sarblock::RangeDopplerCost(flight, look, survey.origins_m[i]).release(),
          new ceres::HuberLoss(1.5),
          flight->Blocks(points[i].data(), arrays, look.time_s));
    }
    problem.AddResidualBlock(
        sarblock::PriorCost(*flight, 0).release(), nullptr, shifts_m[strip].data());
  }
  if (radar) {  // once: the array is shared
    problem.AddResidualBlock(sarblock::PriorCost(*survey.strips[0], 1).release(), nullptr, &bias_m);
  }
  // [radar]
  for (std::size_t s = 0; optical && s < stations_m.size(); ++s) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<FrameRay, 2, 3, 3>(
                                   new FrameRay{survey.images[s][i], survey.origins_m[i]}),
                               nullptr,
                               points[i].data(),
                               stations_m[s].data());
    }
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<Near, 3, 3>(new Near{survey.gps_m[s], kStationSigma_m}),
        nullptr,
        stations_m[s].data());
  }
  // [control]
  sarblock::KnownPosition known;
  known.fixed = {true, true, true};
  known.covariance_enu_m2 = 0.1 * 0.1 * Eigen::Matrix3d::Identity();
  for (const std::size_t i : kControl) {
    problem.AddResidualBlock(
        sarblock::KnownPositionCost(
            sarblock::Frame::Local(), known, survey.truth_m[i], survey.origins_m[i])
            .release(),
        nullptr,
        points[i].data());
  }
  // [control]
  // [solve]
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_SCHUR;
  options.function_tolerance = 1e-12;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) return;
  std::vector<double*> blocks;
  for (Vector3d& point : points) blocks.push_back(point.data());
  const sarblock::ProblemCovariance covariance(problem, blocks);
  // [solve]
  Vector3d error_m2 = Vector3d::Zero(), variance_m2 = Vector3d::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    Eigen::Matrix3d c_m2;
    covariance.Get(blocks[i], blocks[i], c_m2.data());
    const Vector3d off_m = survey.origins_m[i] + points[i] - survey.truth_m[i];
    error_m2 += off_m.cwiseAbs2() / static_cast<double>(points.size());
    variance_m2 += c_m2.diagonal() / static_cast<double>(points.size());
  }
  const Vector3d error_m = error_m2.cwiseSqrt(), sigma_m = variance_m2.cwiseSqrt();
  std::printf("%-8s errors %5.2f %5.2f %5.2f m, standard deviations %5.2f %5.2f %5.2f m",
              name,
              error_m.x(),
              error_m.y(),
              error_m.z(),
              sigma_m.x(),
              sigma_m.y(),
              sigma_m.z());
  std::printf(radar ? ", range bias %.2f m\n" : "\n", bias_m);
}

}  // namespace

int main() {
  const Survey survey = Measure();
  Solve(survey, true, false, "radar");
  Solve(survey, false, true, "optical");
  Solve(survey, true, true, "both");
  return 0;
}
