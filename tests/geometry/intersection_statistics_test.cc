// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/statistics.h"
#include "sarblock/geometry/intersection.h"

#include <cmath>
#include <vector>

#include "geometry/sight_scene.h"
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing_scene::FixPath;
using testing_scene::View;

constexpr int kDraws = 1500;

struct Sums {
  double square_sum = 0.0;  // of v'Pv
  double nees = 0.0;        // of e'Q^-1 e
  int determined = 0;
};

// Adds noise as a radar makes it: the antenna's true place is read at a wrong time, the range is
// measured at the true one. Accelerations are zero: straight paths.
Sums Draw(const std::vector<FixedPathLook>& exact, const Eigen::Vector3d& p, std::uint64_t seed) {
  Sums sums;
  for (int draw = 0; draw < kDraws; ++draw) {
    RandomStream random(seed, static_cast<std::uint64_t>(draw));
    std::vector<FixedPathLook> observations = exact;
    for (FixedPathLook& observation : observations) {
      const double speed_mps = observation.velocity_mps.norm();
      // Metres along track at the target are those of a straight flight.
      const double sigma_t_s = observation.azimuth_in_seconds
                                   ? observation.azimuth_sigma
                                   : observation.azimuth_sigma / speed_mps;
      observation.antenna_m += sigma_t_s * random.Normal() * observation.velocity_mps;
      observation.range_m += observation.range_sigma_m * random.Normal();
    }
    const Intersection result = Intersect(observations, Frame::Local());
    if (result.outcome != IntersectionOutcome::kDetermined) {
      continue;
    }
    ++sums.determined;
    const Eigen::Vector3d error_m = result.position_m - p;
    sums.square_sum += result.weighted_square_sum;
    sums.nees += error_m.dot(result.covariance_m2.llt().solve(error_m));
  }
  return sums;
}

// Seeded statistics: sums of kDraws chi-square variables within their 99.9 % intervals.
void ExpectChiSquare(const std::vector<FixedPathLook>& exact,
                     const Eigen::Vector3d& p,
                     std::uint64_t seed) {
  const Sums sums = Draw(exact, p, seed);
  ASSERT_EQ(sums.determined, kDraws);
  const double redundancy = 2.0 * static_cast<double>(exact.size()) - 3.0;
  const Interval misfit = ChiSquareInterval(0.999, redundancy * kDraws);
  EXPECT_TRUE(misfit.Contains(sums.square_sum)) << sums.square_sum / kDraws;
  const Interval nees = ChiSquareInterval(0.999, 3.0 * kDraws);
  EXPECT_TRUE(nees.Contains(sums.nees)) << sums.nees / kDraws;
}

std::vector<FixedPathLook> SquintedPair(const Eigen::Vector3d& p) {
  View near, far;
  near.look_rad = 0.61;
  near.squint_rad = 0.52;
  near.range_m = 10123.75;
  far.look_rad = 0.95;
  far.squint_rad = -0.44;
  far.range_m = 13371.5;
  far.heading_rad = 0.12;
  std::vector<FixedPathLook> observations = {FixPath(p, near), FixPath(p, far)};
  observations[0].range_sigma_m = 1.7;
  observations[1].range_sigma_m = 0.6;
  return observations;
}

TEST(IntersectionStatisticsTest, SquintedPairWithAzimuthInMetres) {
  const Eigen::Vector3d p(-512.25, 77.5, 123.0);
  std::vector<FixedPathLook> observations = SquintedPair(p);
  observations[0].azimuth_sigma = 2.9;
  observations[1].azimuth_sigma = 1.1;
  ExpectChiSquare(observations, p, 11);
}

TEST(IntersectionStatisticsTest, SquintedPairWithAzimuthInSeconds) {
  const Eigen::Vector3d p(-512.25, 77.5, 123.0);
  std::vector<FixedPathLook> observations = SquintedPair(p);
  for (FixedPathLook& observation : observations) {
    observation.azimuth_in_seconds = true;
    observation.azimuth_sigma = 0.0173;
  }
  ExpectChiSquare(observations, p, 12);
}

TEST(IntersectionStatisticsTest, OppositeAndCrossingLooksTogether) {
  const Eigen::Vector3d p(-512.25, 77.5, 123.0);
  std::vector<FixedPathLook> observations = SquintedPair(p);
  View opposite, crossing;
  opposite.side = -1;
  opposite.look_rad = 0.7;
  crossing.heading_rad = 1.9;
  crossing.squint_rad = 0.08;
  observations.push_back(FixPath(p, opposite));
  observations.push_back(FixPath(p, crossing));
  ExpectChiSquare(observations, p, 13);
}

// Badly conditioned pairs (antennas almost in line with the point, or any height difference) with
// noise: a point that is called determined has to lie within six standard deviations along its
// worst direction. A mirror solution taken for the point fails that. Seeded; the bound is exceeded
// by chance once in 1e9.
TEST(IntersectionStatisticsTest, NeverTakesAMirrorSolutionForThePoint) {
  int determined = 0;
  for (std::uint64_t seed = 0; seed < 4000; ++seed) {
    RandomStream random(100, seed);
    const auto between = [&random](double lower, double upper) {
      return lower + (upper - lower) * random.Uniform();
    };
    const bool in_line = seed % 2 == 0;
    const Eigen::Vector3d p(between(-5e3, 5e3), between(-5e3, 5e3), between(0.0, 1e3));
    const double first_look_rad = between(0.1, 1.4);
    std::vector<FixedPathLook> observations;
    for (int k = 0; k < 2; ++k) {
      View view;
      view.look_rad = in_line ? first_look_rad + k * between(-0.03, 0.03) : between(0.05, 1.5);
      view.squint_rad = in_line ? between(-0.02, 0.02) : between(-1.0, 1.0);
      view.range_m = between(3e3, 13e3) / (std::cos(view.look_rad) * std::cos(view.squint_rad));
      FixedPathLook observation = FixPath(p, view);
      observation.range_sigma_m = 2.1;
      observation.azimuth_sigma = 3.3;
      observation.range_m += 2.1 * random.Normal();
      observation.antenna_m += 3.3 * random.Normal() * observation.velocity_mps.normalized();
      observations.push_back(observation);
    }
    const Intersection result = Intersect(observations, Frame::Local());
    if (result.outcome != IntersectionOutcome::kDetermined) {
      continue;
    }
    ++determined;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(result.covariance_m2);
    const double worst_m = eigen.eigenvectors().col(2).dot(result.position_m - p);
    EXPECT_LT(std::abs(worst_m), 6.0 * std::sqrt(eigen.eigenvalues()[2])) << seed;
  }
  EXPECT_GT(determined, 1000);
}

}  // namespace
}  // namespace sarblock
