// SPDX-License-Identifier: Apache-2.0
#include "result_covariance.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "covariance.h"
#include "point_sweep.h"
#include "solve/ceres_engine.h"
#include "solve/reduced_engine.h"
#include <Eigen/Core>
#include <ceres/covariance.h>

namespace sarblock {

namespace {

using Blocks = std::vector<std::pair<const double*, const double*>>;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Pairs of parameter blocks (i <= j) that are reported.
std::set<std::pair<int, int>> ParameterPairs(const AdjustmentProblem& problem) {
  std::set<std::pair<int, int>> wanted;
  const int count = static_cast<int>(problem.layout.blocks.size());
  if (problem.layout.size() <= kFullParameterCovariance) {
    for (int i = 0; i < count; ++i) {
      for (int j = i; j < count; ++j) wanted.emplace(i, j);
    }
    return wanted;
  }
  for (int i = 0; i < count; ++i) wanted.emplace(i, i);
  std::vector<int> seen;
  LookColumns columns;
  const Looks& looks = problem.block.looks;
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (!problem.Solves(point)) continue;
    seen.clear();
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      if (problem.look_used[i] == 0) continue;
      problem.model.ColumnsOf(i, &columns);
      seen.insert(seen.end(), columns.block.begin(), columns.block.begin() + columns.block_count);
    }
    for (const int i : seen) {
      for (const int j : seen) wanted.emplace(std::min(i, j), std::max(i, j));
    }
  }
  return wanted;
}

class CeresRoute {
 public:
  CeresRoute(const AdjustmentProblem& problem, const BlockState& state, int threads)
      : problem_(problem),
        state_(state),
        unknowns_(UnknownsOf(state)),
        ceres_problem_(MakeCeresProblem(
            problem, {}, state, {unknowns_.data(), unknowns_.data() + CorrectionsBegin()})),
        covariance_(OptionsFor(threads)) {}

  CeresCovariances Run(const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs) {
    CeresCovariances out;
    out.pairs = PairDifferences(problem_, state_, pairs);
    const std::set<std::pair<int, int>> parameters = ParameterPairs(problem_);
    Compute(parameters, out.pairs);
    FillPoints(&out);
    FillParameters(parameters, &out);
    for (PairResult& pair : out.pairs) {
      const Eigen::Matrix3d cross = Get(PointAt(pair.a), 3, PointAt(pair.b), 3);
      const Eigen::Matrix3d difference = Point(pair.a) + Point(pair.b) - cross - cross.transpose();
      pair.covariance_m2 = ToEnu(problem_.block.frame, state_.Position(pair.a), difference);
    }
    return out;
  }

 private:
  static std::vector<double> UnknownsOf(const BlockState& state) {
    std::vector<double> out;
    for (const Eigen::Vector3d& point_m : state.displacement_m) {
      out.insert(out.end(), point_m.begin(), point_m.end());
    }
    out.insert(out.end(), state.corrections.begin(), state.corrections.end());
    return out;
  }
  static ceres::Covariance::Options OptionsFor(int threads) {
    ceres::Covariance::Options options;
    options.algorithm_type = ceres::SPARSE_QR;
    options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
    options.num_threads = threads;
    return options;
  }

  [[nodiscard]] std::size_t CorrectionsBegin() const { return 3 * state_.displacement_m.size(); }
  [[nodiscard]] const double* PointAt(std::size_t point) const {
    return unknowns_.data() + 3 * point;
  }
  [[nodiscard]] const ParameterBlock& BlockOf(int block) const {
    return problem_.layout.blocks[static_cast<std::size_t>(block)];
  }
  [[nodiscard]] const double* ParametersAt(int block) const {
    return unknowns_.data() + CorrectionsBegin() + BlockOf(block).offset;
  }

  void Compute(const std::set<std::pair<int, int>>& parameters,
               const std::vector<PairResult>& pairs) {
    Blocks wanted;
    for (std::size_t point = 0; point < problem_.block.points.size(); ++point) {
      if (problem_.Solves(point)) wanted.emplace_back(PointAt(point), PointAt(point));
    }
    for (const auto& [i, j] : parameters) wanted.emplace_back(ParametersAt(i), ParametersAt(j));
    std::set<std::pair<std::uint32_t, std::uint32_t>>
        unordered;  // Ceres refuses a pair named twice
    for (const PairResult& pair : pairs) {
      if (pair.a != pair.b && unordered.insert(std::minmax(pair.a, pair.b)).second) {
        wanted.emplace_back(PointAt(pair.a), PointAt(pair.b));
      }
    }
    if (!covariance_.Compute(wanted, ceres_problem_.get())) {
      throw UndeterminedError(
          "covariance_method = \"ceres\" finds the equations rank deficient; allowed here: "
          "\"reduced\", which names what is not determined",
          {});
    }
  }

  [[nodiscard]] RowMajor Get(const double* a, int rows, const double* b, int columns) const {
    RowMajor out(rows, columns);
    covariance_.GetCovarianceBlock(a, b, out.data());
    return out;
  }
  [[nodiscard]] Eigen::Matrix3d Point(std::size_t point) const {
    return Get(PointAt(point), 3, PointAt(point), 3);
  }

  void FillPoints(CeresCovariances* out) const {
    out->points.resize(problem_.block.points.size());
    for (std::size_t point = 0; point < out->points.size(); ++point) {
      if (problem_.Solves(point)) {
        out->points[point] = ToEnu(problem_.block.frame, state_.Position(point), Point(point));
      } else {
        out->points[point].fill(std::numeric_limits<double>::quiet_NaN());
      }
    }
  }

  void FillParameters(const std::set<std::pair<int, int>>& pairs, CeresCovariances* out) const {
    for (const auto& [i, j] : pairs) {
      const ParameterBlock& a = BlockOf(i);
      const ParameterBlock& b = BlockOf(j);
      const RowMajor block = Get(ParametersAt(i), a.size, ParametersAt(j), b.size);
      for (int r = 0; r < a.size; ++r) {
        for (int c = i == j ? r : 0; c < b.size; ++c) {
          out->parameters.push_back({static_cast<std::uint32_t>(a.offset + r),
                                     static_cast<std::uint32_t>(b.offset + c),
                                     block(r, c)});
        }
      }
    }
  }

  const AdjustmentProblem& problem_;
  const BlockState& state_;
  // Points, then corrections, in one array: Ceres orders the unknowns by their addresses.
  std::vector<double> unknowns_;
  std::unique_ptr<ceres::Problem> ceres_problem_;
  ceres::Covariance covariance_;
};

}  // namespace

CeresCovariances CovariancesByCeres(
    const AdjustmentProblem& problem,
    const BlockState& state,
    const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs,
    int threads) {
  return CeresRoute(problem, state, threads).Run(pairs);
}

namespace {

PointPairs WantedPairs(const AdjustmentProblem& problem,
                       const BlockState& state,
                       const AdjustOptions& options,
                       const PointPairs& listed) {
  switch (options.pairs) {
    case PairChoice::kNone:
      return {};
    case PairChoice::kNeighbours:
      return NeighbourPairs(problem, state);
    case PairChoice::kAll:
      return AllPairs(problem);
    case PairChoice::kDistances:
      return DistancePairs(problem, state);
    case PairChoice::kList:
      break;
  }
  return listed;
}

/// An inner datum takes out motions that points and paths share: nothing is left to hold.
bool HasFixedPaths(const AdjustmentProblem& problem, const AdjustOptions& options) {
  return problem.layout.size() > 0 && options.datum == Datum::kGiven;
}

void FillCovarianceByCeres(const AdjustmentProblem& problem,
                           const BlockState& state,
                           const AdjustOptions& options,
                           const PointPairs& pairs,
                           AdjustResult* result) {
  CeresCovariances found = CovariancesByCeres(
      problem, state, WantedPairs(problem, state, options, pairs), options.threads);
  result->points.covariance_m2 = std::move(found.points);
  result->pairs = std::move(found.pairs);
  result->parameter_covariance = std::move(found.parameters);
  if (HasFixedPaths(problem, options)) {
    result->points.fixed_path_covariance_m2 =
        SweepPoints(problem, state, nullptr, false, nullptr).covariance_m2;
  }
  for (const ParameterCovariance& c : result->parameter_covariance) {
    if (c.a == c.b) result->parameters[c.a].sigma = std::sqrt(c.covariance);
  }
}

}  // namespace

void RequireCovarianceMethod(const AdjustmentProblem& problem, const AdjustOptions& options) {
  if (Resolve(options.covariance_method) != CovarianceMethod::kCeres) return;
  const std::size_t unknowns = CountProblem(problem).parameters;
  if (unknowns <= kMaxCeresUnknowns) return;
  throw InputError("adjust.covariance_method",
                   "'ceres' is for blocks of at most " + std::to_string(kMaxCeresUnknowns) +
                       " unknowns, this one has " + std::to_string(unknowns) +
                       "; allowed: auto, reduced");
}

void FillCovariance(const AdjustmentProblem& problem,
                    const BlockState& state,
                    const ReducedSystem& system,
                    const std::optional<DatumTransform>& datum,
                    const AdjustOptions& options,
                    const PointPairs& pairs,
                    ProgressSink* progress,
                    AdjustResult* result) {
  if (options.covariance == CovarianceLevel::kNone) return;
  if (Resolve(options.covariance_method) == CovarianceMethod::kCeres) {
    FillCovarianceByCeres(problem, state, options, pairs, result);
    return;
  }
  const bool block_level = (options.covariance == CovarianceLevel::kBlock ||
                            options.covariance == CovarianceLevel::kMonteCarlo) &&
                           problem.layout.size() > 0;
  std::optional<CorrectionCovariance> inverse;
  if (block_level) {
    inverse = system.SelectedInverse();
    result->parameter_covariance = ParameterCovariances(system, *inverse);
    if (datum) datum->Transform(&result->parameter_covariance);
    for (const ParameterCovariance& c : result->parameter_covariance) {
      if (c.a == c.b) result->parameters[c.a].sigma = std::sqrt(c.covariance);
    }
  }
  const bool rigorous = options.covariance != CovarianceLevel::kLeberl;
  if (rigorous) {
    PointSweep sweep =
        SweepPoints(problem, state, inverse ? &*inverse : nullptr, true, progress, system.kept());
    if (datum && block_level) {
      datum->Transform(problem, state, &sweep.covariance_m2);
      for (std::vector<float>& shift_m : sweep.quality.shift_m) {
        std::fill(shift_m.begin(), shift_m.end(), std::numeric_limits<float>::quiet_NaN());
      }
    }
    result->control_quality = ControlQualities(problem, state, sweep.covariance_m2);
    result->points.covariance_m2 = std::move(sweep.covariance_m2);
    result->points.redundancy = std::move(sweep.redundancy);
    if (block_level && HasFixedPaths(problem, options)) {
      result->points.fixed_path_covariance_m2 = std::move(sweep.fixed_path_covariance_m2);
    }
    result->quality = std::move(sweep.quality);
  }
  if (options.pairs == PairChoice::kNone) return;
  const PointPairs wanted = WantedPairs(problem, state, options, pairs);
  result->pairs =
      rigorous ? PairCovariances(problem, state, block_level ? &system : nullptr, wanted, progress)
               : PairDifferences(problem, state, wanted);
  if (datum && block_level) datum->Transform(problem, state, &result->pairs);
}

}  // namespace sarblock
