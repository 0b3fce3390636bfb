// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/adjust/adjust.h"
#include "sarblock/cost/look_cost.h"
#include "sarblock/cost/problem_covariance.h"

#include <cstddef>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <ceres/problem.h>

namespace sarblock::test {

/// The adjustment of a block as a ceres::Problem that a user would write with the public cost
/// functions. It shares paths, axes and bases with Adjust(), not its parameter layout, start
/// values, engines, normal equations or covariances.
class OwnProblem {
 public:
  /// Takes the points and looks that `result` has, each point counting from a place some standard
  /// deviations off the solution, all corrections from zero.
  OwnProblem(const Block& block,
             const std::vector<CorrectionGroup>& groups,
             const AdjustResult& result);

  /// The problem at the points and corrections as they are.
  void Make();
  /// Solves, azimuth weights given in metres formed anew from the last solution, until a step
  /// changes nothing.
  void Solve();

  /// Largest difference of a correction and of a coordinate (east, north, up) from those of the
  /// result, in its standard deviations.
  [[nodiscard]] double LargestParameterDifference() const;
  [[nodiscard]] double LargestPointDifference() const;
  /// Largest difference of an element of a point's covariance, or of the variance of a correction,
  /// by ceres::Covariance or by ProblemCovariance, over the product of the standard deviations.
  [[nodiscard]] double LargestCovarianceDifference();

  [[nodiscard]] ceres::Problem& problem() { return *problem_; }
  [[nodiscard]] std::vector<double*> Points();  ///< blocks of the points that are solved

 private:
  /// One array of corrections, of one pass or shared.
  struct Array {
    std::string owner;
    std::vector<std::string> names;  ///< with units
    std::vector<double> values;
    std::size_t block_size = 0;
  };
  template <typename CovarianceOf>
  [[nodiscard]] double LargestDifference(const CovarianceOf& covariance_of) const;
  /// One Gauss-Newton step with the Jacobian of the problem.
  void Step();
  [[nodiscard]] const ParameterResult& ResultOf(const std::string& owner,
                                                const std::string& name) const;
  [[nodiscard]] Eigen::Vector3d Position(std::size_t point) const {
    return origins_m_[point] + displacements_m_[point];
  }

  const Block& block_;
  const AdjustResult& result_;
  std::vector<FlightPointer> flights_;  // by pass
  std::deque<Array> arrays_;
  std::vector<std::vector<double*>> arrays_of_;  // by pass and correction
  struct Prior {
    std::size_t pass = 0, correction = 0;
    double* array = nullptr;
  };
  std::vector<Prior> priors_;
  std::vector<Eigen::Vector3d> origins_m_, displacements_m_;
  std::unique_ptr<ceres::Problem> problem_;
};

}  // namespace sarblock::test
