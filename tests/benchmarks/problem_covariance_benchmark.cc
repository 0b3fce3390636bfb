// SPDX-License-Identifier: Apache-2.0
// Exact covariances of all points of a ceres::Problem, by ProblemCovariance and by
// ceres::Covariance (SPARSE_QR of SuiteSparse), in one run on one thread: a bundle of cameras in
// strips, three rays a point and more, and a radar block of a scene in a problem of its own.
//
//     problem_covariance_benchmark [--without-ceres] POINTS... [BLOCK...]
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/statistics.h"
#include "sarblock/cost/problem_covariance.h"
#include "sarblock/files/block_file.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "cost/own_problem.h"
#include <Eigen/Core>
#include <ceres/autodiff_cost_function.h>
#include <ceres/covariance.h>
#include <ceres/problem.h>

namespace sarblock {
namespace {

using Eigen::Vector3d;

constexpr double kSpacing_m = 100.0, kHeight_m = 300.0, kImageSigma = 1e-4;

/// A ray of a vertical camera: attitude as three small angles, station, point.
struct Ray {
  template <typename T>
  bool operator()(const T* camera, const T* point, T* residuals) const {
    const T d[3] = {point[0] - camera[3], point[1] - camera[4], camera[5] - point[2]};
    const T x = d[0] + camera[2] * d[1] - camera[1] * d[2];
    const T y = d[1] - camera[2] * d[0] + camera[0] * d[2];
    const T z = d[2] + camera[1] * d[0] - camera[0] * d[1];
    residuals[0] = x / z / kImageSigma;
    residuals[1] = y / z / kImageSigma;
    return true;
  }
};

struct Known {
  template <typename T>
  bool operator()(const T* x, T* residuals) const {
    for (int k = 0; k < 3; ++k) residuals[k] = x[k] / 0.1;
    return true;
  }
};

double Seconds(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void Compare(const std::string& name,
             ceres::Problem& problem,
             const std::vector<double*>& points,
             bool with_ceres) {
  std::vector<Eigen::Matrix3d> ours(points.size()), theirs(points.size());
  const double ours_s = Seconds([&] {
    ProblemCovarianceOptions options;
    options.threads = 1;
    const ProblemCovariance covariance(problem, points, options);
    for (std::size_t i = 0; i < points.size(); ++i) {
      covariance.Get(points[i], points[i], ours[i].data());
    }
  });
  if (!with_ceres) {
    std::printf("%-14s %8zu points  %8.3f s\n", name.c_str(), points.size(), ours_s);
    return;
  }
  const double theirs_s = Seconds([&] {
    ceres::Covariance::Options options;
    options.num_threads = 1;
    ceres::Covariance covariance(options);
    std::vector<std::pair<const double*, const double*>> pairs;
    for (const double* point : points) pairs.emplace_back(point, point);
    if (!covariance.Compute(pairs, &problem)) std::printf("ceres::Covariance failed\n");
    for (std::size_t i = 0; i < points.size(); ++i) {
      covariance.GetCovarianceBlock(points[i], points[i], theirs[i].data());
    }
  });
  double largest = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3d sigma = theirs[i].diagonal().cwiseSqrt();
    const Eigen::Matrix3d unit = sigma * sigma.transpose();
    largest = std::max(largest, (ours[i] - theirs[i]).cwiseQuotient(unit).cwiseAbs().maxCoeff());
  }
  std::printf("%-14s %8zu points  %8.3f s  ceres %9.3f s  %7.0f times  differ by %.1e\n",
              name.c_str(),
              points.size(),
              ours_s,
              theirs_s,
              theirs_s / ours_s,
              largest);
}

void CompareBundle(std::size_t count, bool with_ceres) {
  // Twenty points a camera, a square of strips.
  const auto side = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(count) / 20)));
  std::vector<std::array<double, 6>> cameras;
  for (std::size_t i = 0; i < side * side; ++i) {
    cameras.push_back({0.0,
                       0.0,
                       0.0,
                       kSpacing_m * static_cast<double>(i % side),
                       kSpacing_m * static_cast<double>(i / side),
                       kHeight_m});
  }
  RandomStream random(3, 1);
  const double extent_m = kSpacing_m * static_cast<double>(side - 1);
  std::vector<Vector3d> points(count);
  ceres::Problem problem;
  std::vector<double*> blocks;
  for (std::size_t i = 0; i < count; ++i) {
    points[i] = {extent_m * random.Uniform(), extent_m * random.Uniform(), 30.0 * random.Normal()};
    for (std::array<double, 6>& camera : cameras) {
      const double off_m = std::hypot(camera[3] - points[i].x(), camera[4] - points[i].y());
      if (off_m > 1.2 * kSpacing_m) continue;
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Ray, 2, 6, 3>(new Ray),
                               nullptr,
                               camera.data(),
                               points[i].data());
    }
    if (i % 50 == 0) {
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<Known, 3, 3>(new Known), nullptr, points[i].data());
    }
    blocks.push_back(points[i].data());
  }
  Compare("bundle", problem, blocks, with_ceres);
}

void CompareBlock(const std::string& folder, bool with_ceres) {
  files::BlockFile file = files::ReadBlock(folder);
  const AdjustResult result = Adjust(file.block, file.adjust);
  test::OwnProblem own(file.block, file.adjust.groups, result);
  own.Make();
  Compare(file.block.name, own.problem(), own.Points(), with_ceres);
}

}  // namespace
}  // namespace sarblock

int main(int argc, char** argv) {
  bool with_ceres = true;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--without-ceres") {
      with_ceres = false;
    } else if (argument.find_first_not_of("0123456789") == std::string::npos) {
      sarblock::CompareBundle(std::stoul(argument), with_ceres);
    } else {
      sarblock::CompareBlock(argument, with_ceres);
    }
  }
  return 0;
}
