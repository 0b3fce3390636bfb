// SPDX-License-Identifier: Apache-2.0
// ProblemCovariance against ceres::Covariance, which factors the Jacobian of the whole problem, and
// against the inverse of its normal equations. The problems are bundles of a camera: nothing of
// radar is in them.
#include "sarblock/cost/problem_covariance.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <ceres/autodiff_cost_function.h>
#include <ceres/covariance.h>
#include <ceres/crs_matrix.h>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using testing::ElementsAre;
using testing::HasSubstr;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr double kImageSigma = 1e-4;

/// A ray of a camera: rotation (quaternion), station, focal length of all, point.
struct Ray {
  double x, y;
  template <typename T>
  bool operator()(
      const T* turn, const T* station, const T* focal, const T* point, T* residuals) const {
    const Eigen::Map<const Eigen::Quaternion<T>> q(turn);
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> c(station), p(point);
    const Eigen::Matrix<T, 3, 1> seen = q * (p - c);
    residuals[0] = (focal[0] * seen[0] / seen[2] - x) / kImageSigma;
    residuals[1] = (focal[0] * seen[1] / seen[2] - y) / kImageSigma;
    return true;
  }
};

struct Known {
  Vector3d value;
  double sigma;
  template <typename T>
  bool operator()(const T* x, T* residuals) const {
    for (int k = 0; k < 3; ++k) residuals[k] = (x[k] - value[k]) / sigma;
    return true;
  }
};

/// Cameras in a row above points, each point seen by the three nearest.
struct Bundle {
  explicit Bundle(std::size_t cameras, std::size_t count, bool held = true) {
    std::uint64_t stream = 0;
    const auto draw = [&] { return RandomStream(7, ++stream).Normal(); };
    for (std::size_t i = 0; i < cameras; ++i) {
      stations.push_back({100.0 * static_cast<double>(i), 3.0 * draw(), 500.0 + 3.0 * draw()});
      Eigen::Quaterniond q(1.0, 0.02 * draw(), 0.02 * draw(), 0.02 * draw());
      q = q.normalized() * Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0);
      turns.push_back(q);
    }
    for (std::size_t i = 0; i < count; ++i) {
      const double along = 100.0 * static_cast<double>(cameras - 1) * static_cast<double>(i) /
                           static_cast<double>(count - 1);
      points.push_back({along, 60.0 * draw(), 20.0 * draw()});
    }
    for (std::size_t i = 0; i < count; ++i) {
      std::vector<std::size_t> order(cameras);
      for (std::size_t c = 0; c < cameras; ++c) order[c] = c;
      std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return std::abs(stations[a].x() - points[i].x()) <
               std::abs(stations[b].x() - points[i].x());
      });
      for (std::size_t k = 0; k < std::min<std::size_t>(3, cameras); ++k) AddRay(order[k], i, draw);
    }
    for (Eigen::Quaterniond& turn : turns) {
      problem.SetManifold(turn.coeffs().data(), new ceres::EigenQuaternionManifold);
    }
    if (!held) return;
    for (const std::size_t i : {std::size_t{0}, count / 3, count / 2, count - 1}) {
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<Known, 3, 3>(new Known{points[i], 0.1}),
          nullptr,
          points[i].data());
    }
  }

  template <typename Draw>
  void AddRay(std::size_t camera, std::size_t point, Draw&& draw) {
    const Vector3d seen = turns[camera] * (points[point] - stations[camera]);
    Ray* const ray = new Ray{focal * seen.x() / seen.z() + kImageSigma * draw(),
                             focal * seen.y() / seen.z() + kImageSigma * draw()};
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Ray, 2, 4, 3, 1, 3>(ray),
                             loss,
                             turns[camera].coeffs().data(),
                             stations[camera].data(),
                             &focal,
                             points[point].data());
  }

  std::vector<double*> Points() {
    std::vector<double*> out;
    for (Vector3d& point : points) out.push_back(point.data());
    return out;
  }

  std::vector<Vector3d> stations, points;
  std::vector<Eigen::Quaterniond> turns;
  double focal = 1.0;
  ceres::LossFunction* loss = nullptr;  // the problem's, of rays that are added
  ceres::Problem problem;
};

/// Largest element of |A - B| over the product of the standard deviations.
double Difference(const MatrixXd& a,
                  const MatrixXd& b,
                  const MatrixXd& of_rows,
                  const MatrixXd& of_columns) {
  const Eigen::VectorXd rows = of_rows.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::VectorXd columns = of_columns.diagonal().cwiseSqrt().cwiseInverse();
  return (rows.asDiagonal() * (a - b) * columns.asDiagonal()).cwiseAbs().maxCoeff();
}

/// Two blocks by name, with the number of values in tangent space and around it.
struct Block {
  const double* values;
  int tangent, ambient;
};

void ExpectThatOfCeres(Bundle& bundle,
                       const ProblemCovariance& covariance,
                       const std::vector<std::array<Block, 2>>& pairs) {
  ceres::Covariance::Options options;
  options.algorithm_type = ceres::SPARSE_QR;
  ceres::Covariance ceres_covariance(options);
  std::vector<std::pair<const double*, const double*>> asked;
  for (const auto& [a, b] : pairs) {
    for (const auto& pair : {std::pair{a.values, b.values},
                             std::pair{a.values, a.values},
                             std::pair{b.values, b.values}}) {
      if (std::find(asked.begin(), asked.end(), pair) == asked.end()) asked.push_back(pair);
    }
  }
  ASSERT_TRUE(ceres_covariance.Compute(asked, &bundle.problem));
  const auto of_ceres = [&](const Block& a, const Block& b, bool tangent) {
    RowMajor out(tangent ? a.tangent : a.ambient, tangent ? b.tangent : b.ambient);
    EXPECT_TRUE(
        tangent ? ceres_covariance.GetCovarianceBlockInTangentSpace(a.values, b.values, out.data())
                : ceres_covariance.GetCovarianceBlock(a.values, b.values, out.data()));
    return MatrixXd(out);
  };
  const auto ours = [&](const Block& a, const Block& b, bool tangent) {
    RowMajor out(tangent ? a.tangent : a.ambient, tangent ? b.tangent : b.ambient);
    tangent ? covariance.GetInTangentSpace(a.values, b.values, out.data())
            : covariance.Get(a.values, b.values, out.data());
    return MatrixXd(out);
  };
  for (const auto& [a, b] : pairs) {
    for (const bool tangent : {true, false}) {
      EXPECT_LT(Difference(ours(a, b, tangent),
                           of_ceres(a, b, tangent),
                           of_ceres(a, a, tangent),
                           of_ceres(b, b, tangent)),
                1e-9);
      EXPECT_EQ(ours(a, b, tangent).rows(), tangent ? a.tangent : a.ambient);
    }
  }
}

class ProblemCovarianceTest : public testing::Test {
 protected:
  [[nodiscard]] Block Point(std::size_t i) const { return {bundle_.points[i].data(), 3, 3}; }
  [[nodiscard]] Block Station(std::size_t i) const { return {bundle_.stations[i].data(), 3, 3}; }
  [[nodiscard]] Block Turn(std::size_t i) const { return {bundle_.turns[i].coeffs().data(), 3, 4}; }
  [[nodiscard]] Block Focal() const { return {&bundle_.focal, 1, 1}; }
  [[nodiscard]] std::string Refusal(const ProblemCovarianceOptions& options = {}) {
    try {
      const ProblemCovariance covariance(bundle_.problem, bundle_.Points(), options);
    } catch (const InputError& refused) {
      return refused.what();
    } catch (const UndeterminedError& refused) {
      names_ = refused.names();
      return refused.what();
    }
    return "";
  }
  Bundle bundle_{6, 40};
  std::vector<std::string> names_;
};

// Second route: ceres::Covariance, every kind of pair.
TEST_F(ProblemCovarianceTest, IsThatOfCeres) {
  const ProblemCovariance covariance(bundle_.problem, bundle_.Points());
  EXPECT_EQ(covariance.rows(), 2U * 3U * 40U + 12U);
  EXPECT_EQ(covariance.unknowns(), 6U * 6U + 1U + 3U * 40U);
  ExpectThatOfCeres(bundle_,
                    covariance,
                    {{Point(5), Point(5)},    // its own
                     {Point(5), Point(6)},    // the same cameras
                     {Point(0), Point(39)},   // none in common: a solution
                     {Point(5), Station(1)},  // seen by it
                     {Station(5), Point(0)},  // not
                     {Turn(0), Turn(0)},      // a manifold
                     {Turn(0), Station(0)},
                     {Turn(2), Point(9)},
                     {Turn(0), Turn(5)},  // no point in common
                     {Focal(), Turn(3)},
                     {Focal(), Focal()}});
}

TEST_F(ProblemCovarianceTest, IsTheSameWhateverIsEliminated) {
  std::vector<double*> some;
  for (std::size_t i = 0; i < 40; i += 3) some.push_back(bundle_.points[i].data());
  for (const auto& points : {std::vector<double*>{}, some}) {
    ExpectThatOfCeres(
        bundle_,
        ProblemCovariance(bundle_.problem, points),
        {{Point(3), Point(3)}, {Point(3), Point(4)}, {Point(4), Turn(0)}, {Turn(1), Focal()}});
  }
}

TEST_F(ProblemCovarianceTest, WeightsLossesAsTheSolverDoes) {
  bundle_.loss = new ceres::CauchyLoss(1.5);
  for (std::size_t i = 0; i < 40; ++i) {
    bundle_.AddRay(
        i % 6, i, [n = i]() mutable { return 3.0 * RandomStream(9, 100 * ++n).Normal(); });
  }
  ExpectThatOfCeres(bundle_,
                    ProblemCovariance(bundle_.problem, bundle_.Points()),
                    {{Point(7), Point(7)}, {Turn(2), Station(2)}});
  ProblemCovarianceOptions without;
  without.apply_loss_function = false;
  Eigen::Matrix3d weighted, plain;
  ProblemCovariance(bundle_.problem, bundle_.Points())
      .Get(bundle_.points[7].data(), bundle_.points[7].data(), weighted.data());
  ProblemCovariance(bundle_.problem, bundle_.Points(), without)
      .Get(bundle_.points[7].data(), bundle_.points[7].data(), plain.data());
  EXPECT_GT(weighted.trace(), 1.01 * plain.trace());
}

// What is constant has no covariance, neither as a point nor beside them.
TEST_F(ProblemCovarianceTest, TakesConstantBlocksForKnown) {
  bundle_.problem.SetParameterBlockConstant(&bundle_.focal);
  bundle_.problem.SetParameterBlockConstant(bundle_.points[4].data());
  bundle_.problem.SetParameterBlockConstant(bundle_.turns[2].coeffs().data());
  const ProblemCovariance covariance(bundle_.problem, bundle_.Points());
  EXPECT_EQ(covariance.unknowns(), 36U - 3U + 3U * 39U);
  ExpectThatOfCeres(bundle_, covariance, {{Point(5), Point(5)}, {Station(2), Turn(1)}});
  Eigen::Matrix<double, 4, 3> values = Eigen::Matrix<double, 4, 3>::Ones();
  covariance.Get(Turn(2).values, Point(5).values, values.data());
  EXPECT_EQ(values.cwiseAbs().maxCoeff(), 0.0);
}

// Every pass known: each point by itself.
TEST_F(ProblemCovarianceTest, NeedsNoOtherBlocks) {
  bundle_.problem.SetParameterBlockConstant(&bundle_.focal);
  for (std::size_t i = 0; i < 6; ++i) {
    bundle_.problem.SetParameterBlockConstant(bundle_.stations[i].data());
    bundle_.problem.SetParameterBlockConstant(bundle_.turns[i].coeffs().data());
  }
  ExpectThatOfCeres(bundle_,
                    ProblemCovariance(bundle_.problem, bundle_.Points()),
                    {{Point(5), Point(5)}, {Point(5), Point(6)}});
}

TEST_F(ProblemCovarianceTest, DoesNotDependOnThreads) {
  std::array<Eigen::Matrix3d, 2> values;
  for (int threads : {1, 2}) {
    ProblemCovarianceOptions options;
    options.threads = threads;
    const ProblemCovariance covariance(bundle_.problem, bundle_.Points(), options);
    covariance.Get(
        Point(5).values, Point(5).values, values[static_cast<std::size_t>(threads - 1)].data());
  }
  EXPECT_EQ(values[0], values[1]);
}

// Ceres lists blocks by their addresses.
TEST_F(ProblemCovarianceTest, DoesNotDependOnWhereTheBlocksStand) {
  std::vector<std::unique_ptr<Bundle>> bundles;
  for (int i = 0; i < 4; ++i) bundles.push_back(std::make_unique<Bundle>(6, 40));
  std::reverse(bundles.begin(), bundles.end());
  Eigen::Matrix3d first = Eigen::Matrix3d::Zero();
  for (const auto& bundle : bundles) {
    Eigen::Matrix3d values;
    const double* const point = bundle->points[5].data();
    ProblemCovariance(bundle->problem, bundle->Points()).Get(point, point, values.data());
    if (bundle == bundles.front()) first = values;
    EXPECT_EQ(values, first);
  }
}

TEST_F(ProblemCovarianceTest, OutlivesItsProblem) {
  Eigen::Matrix3d before, after;
  std::optional<ProblemCovariance> kept;
  const double* block = nullptr;
  {
    Bundle short_lived(4, 20);
    kept.emplace(short_lived.problem, short_lived.Points());
    block = short_lived.points[3].data();
    kept->Get(block, block, before.data());
  }
  const ProblemCovariance moved = std::move(*kept);
  moved.Get(block, block, after.data());
  EXPECT_EQ(before, after);
}

// A bundle that nothing holds moves, turns and grows as a whole.
TEST_F(ProblemCovarianceTest, NamesWhatMovesTogether) {
  Bundle loose(4, 30, false);
  ProblemCovarianceOptions options;
  options.name = [&](const double* block) {
    for (std::size_t i = 0; i < 4; ++i) {
      if (block == loose.stations[i].data()) return "station " + std::to_string(i);
    }
    return std::string(block == &loose.focal ? "focal length" : "");
  };
  try {
    const ProblemCovariance covariance(loose.problem, loose.Points(), options);
    FAIL() << "a datum out of nothing";
  } catch (const UndeterminedError& refused) {
    EXPECT_THAT(refused.what(), HasSubstr("can move together and change no residual: "));
    EXPECT_THAT(refused.names(),
                testing::IsSupersetOf({"station 0", "station 1", "station 2", "station 3"}));
    EXPECT_THAT(refused.names(), testing::Not(testing::Contains("focal length")));
  }
}

TEST_F(ProblemCovarianceTest, NamesPointsThatNothingDetermines) {
  std::vector<double*> points = bundle_.Points();
  Vector3d once(150.0, 10.0, 0.0), never(0.0, 0.0, 0.0);
  bundle_.problem.AddResidualBlock(
      new ceres::AutoDiffCostFunction<Ray, 2, 4, 3, 1, 3>(new Ray{0.0, 0.0}),
      nullptr,
      bundle_.turns[1].coeffs().data(),
      bundle_.stations[1].data(),
      &bundle_.focal,
      once.data());
  bundle_.problem.AddParameterBlock(never.data(), 3);
  points.push_back(once.data());
  points.push_back(never.data());
  try {
    const ProblemCovariance covariance(bundle_.problem, points);
    FAIL();
  } catch (const UndeterminedError& refused) {
    EXPECT_THAT(refused.names(), ElementsAre("point 40", "point 41"));
    EXPECT_THAT(refused.what(), HasSubstr("do not determine these points: point 40, point 41"));
  }
}

TEST_F(ProblemCovarianceTest, NamesAnotherBlockThatNothingDetermines) {
  double unused = 0.0;
  bundle_.problem.AddParameterBlock(&unused, 1);
  EXPECT_THAT(Refusal(), HasSubstr("do not determine these blocks: block "));
  EXPECT_EQ(names_.size(), 1U);
}

TEST_F(ProblemCovarianceTest, RefusesWhatCannotBeMeant) {
  std::vector<double*> points = bundle_.Points();
  double elsewhere = 0.0;
  const auto refusal = [&](std::vector<double*> of) -> std::string {
    try {
      const ProblemCovariance covariance(bundle_.problem, of);
    } catch (const InputError& refused) {
      return refused.what();
    }
    return "";
  };
  EXPECT_EQ(refusal({points[0], &elsewhere}), "points: number 1 is no block of the problem");
  EXPECT_EQ(refusal({points[0], nullptr}), "points: number 1 is no block of the problem");
  EXPECT_EQ(refusal({points[0], points[1], points[0]}), "points: number 2 is number 0 as well");
  EXPECT_EQ(
      refusal({points[0], bundle_.stations[0].data()}),
      "points: point 0 and point 1 have a residual in common: only one of them may be a point");
  const ProblemCovariance covariance(bundle_.problem, points);
  EXPECT_THROW(covariance.Get(points[0], &elsewhere, &elsewhere), InputError);
  bundle_.problem.SetParameterLowerBound(&bundle_.focal, 0, bundle_.focal);
  EXPECT_THAT(Refusal(), HasSubstr("value 0 is held by a bound"));
  bundle_.problem.SetParameterLowerBound(&bundle_.focal, 0, 0.5);
  EXPECT_EQ(Refusal(), "");
  bundle_.points[3].setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_THAT(Refusal(), HasSubstr("problem: "));
}

struct Line {
  double t;
  template <typename T>
  bool operator()(const T* line, const T* y, T* residual) const {
    residual[0] = y[0] - line[0] - t * line[1];
    return true;
  }
};
struct Measured {
  template <typename T>
  bool operator()(const T* y, T* residual) const {
    residual[0] = y[0];
    return true;
  }
};

// Closed form: a line through points of known abscissae, each ordinate an unknown of its own that
// is observed twice. sigma^2 of ordinate and of the parameters of the line by hand.
TEST(ProblemCovarianceClosedFormTest, HasThatOfALine) {
  std::array<double, 2> line{};
  std::vector<double> ordinates(11, 0.0);
  ceres::Problem problem;
  std::vector<double*> points;
  for (std::size_t i = 0; i < ordinates.size(); ++i) {
    const double t = static_cast<double>(i) - 5.0;
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Line, 1, 2, 1>(new Line{t}),
                             nullptr,
                             line.data(),
                             &ordinates[i]);
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<Measured, 1, 1>(new Measured), nullptr, &ordinates[i]);
    points.push_back(&ordinates[i]);
  }
  const ProblemCovariance covariance(problem, points);
  // y - a - b t and y, both of sigma 1: y - y = a + b t has the variance 2; sum of t^2 is 110.
  Eigen::Matrix2d of_line;
  covariance.Get(line.data(), line.data(), of_line.data());
  EXPECT_NEAR(of_line(0, 0), 2.0 / 11.0, 1e-15);
  EXPECT_NEAR(of_line(1, 1), 2.0 / 110.0, 1e-15);
  EXPECT_NEAR(of_line(0, 1), 0.0, 1e-15);
  // y is the mean of 0 and a + b t: 1/2 + (2/11 + 2 t^2/110) / 4.
  double of_end = 0.0;
  covariance.Get(&ordinates[10], &ordinates[10], &of_end);
  EXPECT_NEAR(of_end, 0.5 + (2.0 / 11.0 + 50.0 / 110.0) / 4.0, 1e-15);
}

}  // namespace
}  // namespace sarblock
