// SPDX-License-Identifier: Apache-2.0
#include "result_covariance.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "ceres_covariance.h"
#include "covariance.h"
#include "neighbours.h"
#include "point_sweep.h"
#include "solve/reduced_engine.h"

namespace sarblock {
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
    case PairChoice::kList:
      break;
  }
  return listed;
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
  for (const ParameterCovariance& c : result->parameter_covariance) {
    if (c.a == c.b) result->parameters[c.a].sigma = std::sqrt(c.covariance);
  }
}

}  // namespace

void RequireCovarianceMethod(const AdjustmentProblem& problem, const AdjustOptions& options) {
  if (Resolve(options.covariance_method) != CovarianceMethod::kCeres) return;
  const std::size_t unknowns = CountProblem(problem).parameters;
  if (unknowns <= kMostCeresUnknowns) return;
  throw InputError("adjust.covariance_method",
                   "'ceres' is for blocks of at most " + std::to_string(kMostCeresUnknowns) +
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
