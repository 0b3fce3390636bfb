// SPDX-License-Identifier: Apache-2.0
#include "cost/own_problem.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <variant>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <ceres/covariance.h>
#include <ceres/crs_matrix.h>
#include <ceres/solver.h>
#include <gtest/gtest.h>

namespace sarblock::test {
namespace {

bool Belongs(const CorrectionGroup& group, const std::string& pass) {
  return group.passes.empty() ||
         std::find(group.passes.begin(), group.passes.end(), pass) != group.passes.end();
}

}  // namespace

OwnProblem::OwnProblem(const Block& block,
                       const std::vector<CorrectionGroup>& groups,
                       const AdjustResult& result)
    : block_(block), result_(result), arrays_of_(block.passes.size()) {
  std::vector<Array*> shared(groups.size(), nullptr);
  for (std::size_t pass = 0; pass < block.passes.size(); ++pass) {
    std::vector<FlightCorrection> corrections;
    std::vector<std::size_t> group_of;
    bool spline = false;
    for (std::size_t g = 0; g < groups.size(); ++g) {
      if (!Belongs(groups[g], block.passes[pass].id)) continue;
      FlightCorrection correction{groups[g].model, {}};
      const auto* position = std::get_if<PositionCorrection>(&groups[g].model);
      spline =
          spline || (position != nullptr && position->basis == PositionCorrection::Basis::kSpline);
      if (groups[g].shared) {  // one spline over the strips of all its passes
        TimeSpan span{1e300, -1e300};
        for (const Pass& member : block.passes) {
          if (!Belongs(groups[g], member.id)) continue;
          span.first_s = std::min(span.first_s, member.start_s);
          span.last_s = std::max(span.last_s, member.end_s);
        }
        correction.knots_s = span;
      }
      corrections.push_back(correction);
      group_of.push_back(g);
    }
    // Where Adjust() reads a path: near the time bias, in steps of a twentieth of the knots of a
    // spline, so that of some milliseconds at the measured time. Read elsewhere, the continued
    // third derivative of a spline changes partials by 1e-8.
    double time_bias_s = 0.0;
    for (const ParameterResult& parameter : result.parameters) {
      const bool own = parameter.owner == block.passes[pass].id;
      if (own && parameter.name == "time.bias" && !spline) time_bias_s = parameter.value;
    }
    auto flight = std::make_shared<CorrectedFlight>(block, pass, corrections, time_bias_s);
    for (std::size_t q = 0; q < group_of.size(); ++q) {
      Array*& array = shared[group_of[q]];
      const bool is_shared = groups[group_of[q]].shared;
      if (is_shared && array != nullptr) {
        arrays_of_[pass].push_back(array->values.data());
        continue;
      }
      Array& made = arrays_.emplace_back();
      made.owner = is_shared ? groups[group_of[q]].name : block.passes[pass].id;
      made.names = flight->ParameterNames(q);
      made.values.assign(made.names.size(), 0.0);
      made.block_size = static_cast<std::size_t>(flight->BlockSize(q));
      if (is_shared) array = &made;
      arrays_of_[pass].push_back(made.values.data());
      priors_.push_back({pass, q, made.values.data()});
    }
    flights_.push_back(std::move(flight));
  }
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    Eigen::Vector3d origin_m = result.points.position_m[point];
    if (IsSolved(result.points.status[point])) {
      const Eigen::Vector3d sigma_m =
          MatrixOf(result.points.covariance_m2[point]).diagonal().cwiseSqrt();
      origin_m += 2.3 * sigma_m.maxCoeff() * Eigen::Vector3d(0.7, -1.1, 0.9);
    }
    origins_m_.push_back(origin_m);
    displacements_m_.emplace_back(Eigen::Vector3d::Zero());
  }
}

void OwnProblem::Make() {
  problem_ = std::make_unique<ceres::Problem>();
  for (std::size_t point = 0; point < block_.points.size(); ++point) {
    if (!IsSolved(result_.points.status[point])) continue;
    double* displacement = displacements_m_[point].data();
    for (std::size_t i = block_.looks.offsets[point]; i < block_.looks.offsets[point + 1]; ++i) {
      if (block_.looks.rejected(i)) continue;
      const std::size_t pass = block_.looks.pass[i];
      const LookMeasurement look =
          MeasurementOf(block_, i, *flights_[pass], Position(point), arrays_of_[pass]);
      problem_->AddResidualBlock(
          RangeDopplerCost(flights_[pass], look, origins_m_[point]).release(),
          nullptr,
          flights_[pass]->Blocks(displacement, arrays_of_[pass], look.time_s));
    }
    const KnownPosition* known = block_.points.FindKnown(static_cast<std::uint32_t>(point));
    if (known == nullptr || block_.points.role[point] != PointRole::kControl) continue;
    problem_->AddResidualBlock(
        KnownPositionCost(block_.frame, *known, block_.points.given_m[point], origins_m_[point])
            .release(),
        nullptr,
        displacement);
  }
  for (const Prior& prior : priors_) {
    const CorrectedFlight& flight = *flights_[prior.pass];
    const auto size = static_cast<std::size_t>(flight.BlockSize(prior.correction));
    for (std::size_t k = 0; k < flight.BlockCount(prior.correction); ++k) {
      CostPointer cost = PriorCost(flight, prior.correction);
      if (cost == nullptr) continue;
      problem_->AddResidualBlock(cost.release(), nullptr, prior.array + k * size);
    }
  }
}

void OwnProblem::Solve() {
  for (int round = 0; round < 4; ++round) {
    Make();
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_SCHUR;
    options.max_num_iterations = 30;
    options.function_tolerance = 0.0;
    options.gradient_tolerance = 0.0;
    options.parameter_tolerance = 1e-13;
    options.initial_trust_region_radius = 1e12;
    options.max_num_consecutive_invalid_steps = 20;
    ceres::Solver::Summary summary;
    ceres::Solve(options, problem_.get(), &summary);
    ASSERT_NE(summary.termination_type, ceres::FAILURE) << summary.message;
    for (int step = 0; step < 3; ++step) Step();
  }
}

// Ceres compares costs, whose rounding hides steps of 1e-6 standard deviations.
void OwnProblem::Step() {
  std::vector<double*> blocks;
  problem_->GetParameterBlocks(&blocks);
  ceres::Problem::EvaluateOptions options;
  options.parameter_blocks = blocks;
  ceres::CRSMatrix rows;
  std::vector<double> gradient;
  ASSERT_TRUE(problem_->Evaluate(options, nullptr, nullptr, &gradient, &rows));
  const Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor>> jacobian(
      rows.num_rows,
      rows.num_cols,
      static_cast<Eigen::Index>(rows.values.size()),
      rows.rows.data(),
      rows.cols.data(),
      rows.values.data());
  const Eigen::SparseMatrix<double> by_column = jacobian;
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(by_column.transpose() *
                                                                  by_column);
  ASSERT_EQ(factor.info(), Eigen::Success);
  const Eigen::VectorXd step =
      factor.solve(Eigen::Map<const Eigen::VectorXd>(gradient.data(), rows.num_cols));
  Eigen::Index column = 0;
  for (double* block : blocks) {
    for (int i = 0; i < problem_->ParameterBlockSize(block); ++i) block[i] -= step[column++];
  }
}

const ParameterResult& OwnProblem::ResultOf(const std::string& owner,
                                            const std::string& name) const {
  const auto found = std::find_if(
      result_.parameters.begin(), result_.parameters.end(), [&](const ParameterResult& parameter) {
        return parameter.owner == owner && parameter.name + " [" + parameter.unit + "]" == name;
      });
  if (found == result_.parameters.end()) throw std::runtime_error(owner + " " + name);
  return *found;
}

double OwnProblem::LargestParameterDifference() const {
  double largest = 0.0;
  std::size_t count = 0;
  for (const Array& array : arrays_) {
    for (std::size_t k = 0; k < array.values.size(); ++k, ++count) {
      const ParameterResult& parameter = ResultOf(array.owner, array.names[k]);
      largest = std::max(largest, std::abs(array.values[k] - parameter.value) / parameter.sigma);
    }
  }
  EXPECT_EQ(count, result_.parameters.size());
  return largest;
}

double OwnProblem::LargestPointDifference() const {
  double largest = 0.0;
  for (std::size_t point = 0; point < block_.points.size(); ++point) {
    if (!IsSolved(result_.points.status[point])) continue;
    const Eigen::Vector3d expected_m = result_.points.position_m[point];
    const Eigen::Vector3d enu_m =
        block_.frame.EnuFromFrame(expected_m) * (Position(point) - expected_m);
    const Eigen::Vector3d sigma_m =
        MatrixOf(result_.points.covariance_m2[point]).diagonal().cwiseSqrt();
    largest = std::max(largest, enu_m.cwiseQuotient(sigma_m).cwiseAbs().maxCoeff());
  }
  return largest;
}

std::vector<double*> OwnProblem::Points() {
  std::vector<double*> out;
  for (std::size_t point = 0; point < block_.points.size(); ++point) {
    if (IsSolved(result_.points.status[point])) out.push_back(displacements_m_[point].data());
  }
  return out;
}

double OwnProblem::LargestCovarianceDifference() {
  ceres::Covariance::Options options;
  options.algorithm_type = ceres::SPARSE_QR;
  ceres::Covariance covariance(options);
  std::vector<std::pair<const double*, const double*>> pairs;
  for (const double* block : Points()) pairs.emplace_back(block, block);
  for (const Array& array : arrays_) {
    for (std::size_t k = 0; k < array.values.size(); k += array.block_size) {
      pairs.emplace_back(array.values.data() + k, array.values.data() + k);
    }
  }
  if (!covariance.Compute(pairs, problem_.get())) throw std::runtime_error("ceres::Covariance");
  const ProblemCovariance ours(*problem_, Points());
  return std::max(LargestDifference([&](const double* block, double* values) {
                    EXPECT_TRUE(covariance.GetCovarianceBlock(block, block, values));
                  }),
                  LargestDifference([&](const double* block, double* values) {
                    ours.Get(block, block, values);
                  }));
}

template <typename CovarianceOf>
double OwnProblem::LargestDifference(const CovarianceOf& covariance_of) const {
  double largest = 0.0;
  for (std::size_t point = 0; point < block_.points.size(); ++point) {
    if (!IsSolved(result_.points.status[point])) continue;
    const double* at = displacements_m_[point].data();
    Eigen::Matrix<double, 3, 3, Eigen::RowMajor> frame_m2;
    covariance_of(at, frame_m2.data());
    const Eigen::Matrix3d enu = block_.frame.EnuFromFrame(result_.points.position_m[point]);
    const Eigen::Matrix3d expected_m2 = MatrixOf(result_.points.covariance_m2[point]);
    const Eigen::Vector3d sigma_m = expected_m2.diagonal().cwiseSqrt();
    const Eigen::Matrix3d difference_m2 = enu * frame_m2 * enu.transpose() - expected_m2;
    for (Eigen::Index i = 0; i < 3; ++i) {
      for (Eigen::Index j = 0; j < 3; ++j) {
        largest = std::max(largest, std::abs(difference_m2(i, j)) / (sigma_m[i] * sigma_m[j]));
      }
    }
  }
  for (const Array& array : arrays_) {
    const std::size_t size = array.block_size;
    for (std::size_t k = 0; k < array.values.size(); k += size) {
      const double* at = array.values.data() + k;
      std::vector<double> own(size * size);
      covariance_of(at, own.data());
      for (std::size_t i = 0; i < size; ++i) {
        const double sigma = ResultOf(array.owner, array.names[k + i]).sigma;
        largest = std::max(largest, std::abs(own[i * size + i] / (sigma * sigma) - 1.0));
      }
    }
  }
  return largest;
}

}  // namespace sarblock::test
