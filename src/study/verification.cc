// SPDX-License-Identifier: Apache-2.0
#include "verification.h"

#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/model/result.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "accuracy.h"
#include "core/threads.h"
#include "study/block_covariance.h"
#include <Eigen/Cholesky>

namespace sarblock {
namespace {

/// Square sums of one run over the points.
struct RunSums {
  std::string why_not = {};  // not empty: not compared
  std::array<double, 3> square_m2{};
  double whitened_1 = 0.0;
};

/// What a point's errors are compared with.
struct Reference {
  std::uint32_t point = 0;
  Eigen::Matrix3d enu_from_frame;
  Eigen::Matrix3d whiten;  // inverse Cholesky factor of the covariance
};

RunSums Compare(const SimulatedBlock& drawn,
                const AdjustResult& result,
                const std::vector<Reference>& references) {
  RunSums sums;
  if (!result.accepted()) {
    sums.why_not = "not converged";
    return sums;
  }
  for (const Reference& reference : references) {
    if (!IsSolved(result.points.status[reference.point])) {
      sums.why_not = "point " + std::string(drawn.block.points.ids[reference.point]) + " " +
                     NameOf(result.points.status[reference.point]);
      return sums;
    }
    const Eigen::Vector3d e_m =
        reference.enu_from_frame *
        (result.points.position_m[reference.point] - drawn.truth.points_m[reference.point]);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      sums.square_m2[axis] +=
          e_m[static_cast<Eigen::Index>(axis)] * e_m[static_cast<Eigen::Index>(axis)];
    }
    sums.whitened_1 += (reference.whiten * e_m).squaredNorm();
  }
  return sums;
}

}  // namespace

Verification Verify(const Scene& scene,
                    const SimulatedBlock& simulated,
                    const AdjustOptions& options,
                    const AdjustResult& predicted,
                    int runs,
                    std::uint64_t seed,
                    double level,
                    ProgressSink* progress) {
  const std::vector<Eigen::Vector3d>& truth_m = simulated.truth.points_m;
  std::vector<Reference> references;
  for (const std::uint32_t point : PointsCounted(simulated.block, predicted.points)) {
    const SymmetricEnu& q = predicted.points.covariance_m2[point];
    const Eigen::Matrix3d matrix = MatrixOf(q);
    const Eigen::LLT<Eigen::Matrix3d> factor(matrix);
    if (factor.info() != Eigen::Success) continue;
    references.push_back({point,
                          simulated.block.frame.EnuFromFrame(truth_m[point]),
                          factor.matrixL().solve(Eigen::Matrix3d::Identity())});
  }
  AdjustOptions adjust = options;
  adjust.covariance = CovarianceLevel::kNone;
  adjust.pairs = PairChoice::kNone;
  std::vector<RunSums> sums(static_cast<std::size_t>(runs));
  ParallelForChunks(sums.size(), 1, [&](std::size_t run, std::size_t, std::size_t) {
    RunIsolated([&] {
      if (progress != nullptr && progress->Cancelled()) throw Interrupted("study");
      SimulatedBlock drawn = simulated;
      Redraw(scene, MixStream(seed, run), RedrawChoice{}, &drawn);
      std::vector<Eigen::Vector3d>& start_m = drawn.block.points.given_m;
      for (std::size_t point = 0; point < start_m.size(); ++point) {
        if (!start_m[point].allFinite()) start_m[point] = truth_m[point];  // where it was planned
      }
      try {
        sums[run] = Compare(drawn, Adjust(drawn.block, adjust), references);
      } catch (const UndeterminedError& error) {
        sums[run].why_not = error.what();
      }
    });
  });

  Verification out;
  double whitened_1 = 0.0;
  std::array<double, 3> square_m2{};
  for (const RunSums& run : sums) {
    if (!run.why_not.empty()) {
      if (++out.failed == 1) out.why = run.why_not;
      continue;
    }
    ++out.runs;
    whitened_1 += run.whitened_1;
    for (std::size_t axis = 0; axis < 3; ++axis) square_m2[axis] += run.square_m2[axis];
  }
  if (out.runs == 0 || references.empty()) return out;
  const double count = static_cast<double>(out.runs) * static_cast<double>(references.size());
  out.nees_1 = whitened_1 / (3.0 * count);
  for (std::size_t axis = 0; axis < 3; ++axis) out.rms_m[axis] = std::sqrt(square_m2[axis] / count);
  const BlockCovariance covariance(simulated.block, options, truth_m, predicted.points.status);
  std::vector<std::size_t> chosen;
  std::size_t at = 0;
  for (const Reference& reference : references) {
    while (covariance.points()[at] != reference.point) ++at;
    chosen.push_back(at);
  }
  const double degrees = out.runs * covariance.SquareFreedom(chosen);
  const Interval square = ChiSquareInterval(level, degrees);
  out.bound = {square.lower / degrees, square.upper / degrees};
  return out;
}

}  // namespace sarblock
