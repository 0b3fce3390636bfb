// SPDX-License-Identifier: Apache-2.0
#include "needs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "core/memory.h"
#include "core/text.h"

namespace sarblock {
namespace {

constexpr double kMiB = 1024.0 * 1024.0;
/// Less than this is not looked for: there is always as much.
constexpr std::uint64_t kAlwaysThere = std::uint64_t{64} << 20;

/// Bytes of arrays.
struct ArrayBytes {
  std::uint64_t all = 0;
  std::uint64_t large = 0;  ///< of arrays that may be in scratch files

  void Add(std::uint64_t bytes) {
    all += bytes;
    if (bytes >= kScratchMinBytes) large += bytes;
  }
};

/// Adds vectors that are filled.
template <typename... Vectors>
void AddFilled(ArrayBytes* to, const Vectors&... vectors) {
  (to->Add(vectors.size() * sizeof(vectors[0])), ...);
}

/// Adds vectors that will be filled with so many elements.
template <typename... Vectors>
void AddPlanned(std::uint64_t count, ArrayBytes* to, const Vectors&... vectors) {
  (to->Add(count * sizeof(vectors[0])), ...);
}

void AddAsRead(const Looks& looks, ArrayBytes* to) {
  AddFilled(to, looks.offsets);
  Looks::ForColumns([&](const char*, auto column, auto...) { AddFilled(to, looks.*column); });
}

void AddAsRead(const Points& points, ArrayBytes* to) { AddFilled(to, points.role, points.given_m); }

ArrayBytes LooksBytes(const AdjustmentProblem& problem, const AdjustOptions& options) {
  const Looks& looks = problem.block.looks;
  const std::uint64_t count = looks.size();
  const LookResults results;
  const LookQuality quality;
  ArrayBytes bytes;
  AddAsRead(looks, &bytes);
  AddFilled(&bytes, problem.look_used, problem.weights);
  AddPlanned(count, &bytes, results.range_residual_m, results.azimuth_residual_m, results.rejected);
  if (options.robust != RobustLoss::kNone) AddPlanned(count, &bytes, results.weight);
  if (options.covariance != CovarianceLevel::kNone) {
    for (const std::size_t k : {0U, 1U}) {
      AddPlanned(count, &bytes, quality.redundancy[k], quality.w[k], quality.shift_m[k]);
    }
  }
  return bytes;
}

ArrayBytes PointsBytes(const AdjustmentProblem& problem, const AdjustOptions& options) {
  const Points& points = problem.block.points;
  const std::uint64_t count = points.size();
  const PointResults results;
  const BlockState state;
  ArrayBytes bytes;
  AddAsRead(points, &bytes);
  AddFilled(
      &bytes, problem.point_status, problem.point_reason, problem.mirrored, problem.control_of);
  AddPlanned(count,
             &bytes,
             state.start_m,
             state.displacement_m,
             results.status,
             results.looks,
             results.position_m,
             results.intersection_rad);
  if (options.covariance != CovarianceLevel::kNone) {
    AddPlanned(count, &bytes, results.covariance_m2, results.fixed_path_covariance_m2);
    for (const auto figure : kAccuracyFigures) AddPlanned(count, &bytes, results.*figure);
  }
  return bytes;
}

std::uint64_t Doubles(std::size_t count) { return sizeof(double) * count; }

}  // namespace

ResourceNeeds PredictNeeds(const AdjustmentProblem& problem,
                           const AdjustOptions& options,
                           ReducedSystem* system) {
  const SystemNeeds system_needs = system->Needs(options.threads);
  const FactorNeeds& factor = system_needs.factor;
  ResourceNeeds needs;
  const bool scratch = ScratchScope::Current() != nullptr;
  const ArrayBytes looks = LooksBytes(problem, options);
  const ArrayBytes points = PointsBytes(problem, options);
  ArrayBytes block;
  AddAsRead(problem.block.looks, &block);
  AddAsRead(problem.block.points, &block);
  needs.looks_bytes = looks.all;
  needs.points_bytes = points.all;
  needs.large_bytes = looks.large + points.large;
  needs.scratch_bytes = scratch ? needs.large_bytes : 0;
  needs.block_bytes = block.all - (scratch ? block.large : 0);
  needs.matrix_bytes = 2 * Doubles(system_needs.matrix + system_needs.border);
  needs.partial_sums_bytes = Doubles(system_needs.partial_sums);
  needs.factor_bytes = Doubles(factor.factor);
  needs.fronts_bytes = Doubles(factor.waiting);
  needs.sum_operations = system_needs.operations;
  needs.factor_operations = factor.operations;
  if (options.covariance == CovarianceLevel::kBlock ||
      options.covariance == CovarianceLevel::kMonteCarlo) {
    needs.inverse_bytes =
        Doubles(system_needs.matrix + system_needs.border + factor.inverse_fronts);
  }
  needs.peak_bytes = needs.looks_bytes + needs.points_bytes - needs.scratch_bytes +
                     needs.matrix_bytes + needs.factor_bytes +
                     std::max({needs.partial_sums_bytes, needs.fronts_bytes, needs.inverse_bytes});
  return needs;
}

std::string ProblemOfMemory(const ResourceNeeds& needs, const AdjustOptions& options) {
  const bool asked = options.memory_mib > 0.0;
  if (!asked && needs.peak_bytes <= kAlwaysThere) return {};
  // The block itself is in memory already.
  const std::uint64_t more = asked ? needs.peak_bytes : needs.peak_bytes - needs.block_bytes;
  const double limit_mib = asked ? options.memory_mib : AvailableMemory_bytes() / kMiB;
  if (static_cast<double>(more) <= limit_mib * kMiB) return {};
  std::string text = "the adjustment needs " + Mebibytes(static_cast<double>(more)) + " MiB" +
                     (asked ? "" : " more than the block as it was read") + ", " +
                     Mebibytes(limit_mib * kMiB) + " MiB are " + (asked ? "allowed" : "free") +
                     ": " + DescribeNeeds(needs) +
                     "; less is needed with fewer parameters per pass";
  if (options.covariance != CovarianceLevel::kNone) text += ", with covariance = \"none\"";
  if (needs.large_bytes > needs.scratch_bytes) {
    text += ", with looks and points in files (--scratch)";
  }
  text += " or for a part of the block; --memory sets another limit";
  return text;
}

}  // namespace sarblock
