// SPDX-License-Identifier: Apache-2.0
#include "back_substitution.h"

#include <optional>

#include "core/parallel.h"
#include "model/straight_motion.h"
#include "point_terms.h"
#include <Eigen/Core>

namespace sarblock {
namespace {

constexpr std::size_t kPointsPerChunk = 1024;

/// The step of a point and what it promises.
struct PointStep {
  Eigen::Vector3d step_m = Eigen::Vector3d::Zero();
  double promised_1 = 0.0;
};

double Promised(const Eigen::Vector3d& gradient,
                const Eigen::Vector3d& square_1,
                double damping_1,
                const Eigen::Vector3d& step_m) {
  return 0.5 * (-gradient.dot(step_m) + damping_1 * step_m.cwiseAbs2().dot(square_1));
}

/// One state with a step of its corrections.
class BackSubstitution {
 public:
  BackSubstitution(const AdjustmentProblem& problem,
                   const BlockState& state,
                   const Weighting& weighting,
                   double damping_1,
                   const Eigen::VectorXd& dx)
      : problem_(problem),
        state_(state),
        weighting_(weighting),
        damping_1_(damping_1),
        dx_(dx),
        motions_(problem.model, state.corrections),
        steps_(motions_.StepsFor(dx)) {}

  /// By the path's own change; nothing where a look's path is not straight or V is too thin. `look`
  /// is scratch.
  [[nodiscard]] std::optional<PointStep> Along(std::size_t point, WhitenedLook* look) const {
    const Looks& looks = problem_.block.looks;
    PointSums sums;
    Eigen::Array2d along[3] = {
        Eigen::Array2d::Zero(), Eigen::Array2d::Zero(), Eigen::Array2d::Zero()};
    look->columns.column_count = 1;  // J_c dx stands in for J_c
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      if (problem_.look_used[i] == 0) continue;
      const std::size_t pass = looks.pass[i];
      if (!motions_.Apply(pass)) return std::nullopt;
      Eigen::Vector2d along_1;
      if (!motions_.EvaluateAlong(i,
                                  state_.start_m[point],
                                  state_.displacement_m[point],
                                  steps_[pass],
                                  problem_.whitening[i],
                                  &look->error_m,
                                  &look->by_point,
                                  &along_1)) {
        continue;
      }
      look->row[0][0] = along_1[0];
      look->row[1][0] = along_1[1];
      WeighLook(problem_.whitening[i], weighting_, look);
      if (weighting_.second_order) BendAlongResidual(look);
      sums.Add(look->by_point, look->error_1);
      const Eigen::Array2d moved(look->row[0][0], look->row[1][0]);
      for (Eigen::Index c = 0; c < 3; ++c) along[c] += look->by_point.col(c).array() * moved;
    }
    if (problem_.control_of[point] >= 0) {
      const ControlEquations& equations =
          problem_.control[static_cast<std::size_t>(problem_.control_of[point])];
      sums.Add(EvaluateControl(
          problem_.block.frame, equations, state_.start_m[point], state_.displacement_m[point]));
    }
    const Eigen::Vector3d gradient = sums.Gradient(), above = sums.Above();
    const Eigen::Vector3d moved_gradient =
        gradient + Eigen::Vector3d(along[0].sum(), along[1].sum(), along[2].sum());
    Eigen::Vector3d square = sums.Diagonal();
    if (damping_1_ > 0.0) square = square.cwiseMax(kLeastColumnPart_1 * square.maxCoeff());
    Eigen::Matrix3d r;
    Eigen::Vector3d inverse;
    if (!FactorNormal((1.0 + damping_1_) * square, above, damping_1_ > 0.0, &r, &inverse)) {
      return std::nullopt;
    }
    // V dp = R' R dp = -J_p' (e + J_c dx)
    Eigen::Vector3d y;
    y[0] = moved_gradient[0] * inverse[0];
    y[1] = (moved_gradient[1] - r(0, 1) * y[0]) * inverse[1];
    y[2] = (moved_gradient[2] - r(0, 2) * y[0] - r(1, 2) * y[1]) * inverse[2];
    PointStep out;
    out.step_m[2] = -y[2] * inverse[2];
    out.step_m[1] = (-y[1] - r(1, 2) * out.step_m[2]) * inverse[1];
    out.step_m[0] = (-y[0] - r(0, 1) * out.step_m[1] - r(0, 2) * out.step_m[2]) * inverse[0];
    out.promised_1 = Promised(gradient, square, damping_1_, out.step_m);
    return out;
  }

  /// By the factors of the point, for every path and intersection.
  [[nodiscard]] PointStep ByFactors(std::size_t point, PointFactor* factor) const {
    FactorPoint(problem_, state_, weighting_, damping_1_, point, factor, &motions_);
    // The corrections' step moves to the right side: e + J_c dx.
    for (int k = 0; k < factor->look_count; ++k) {
      const WhitenedLook& look = factor->looks[static_cast<std::size_t>(k)];
      double range = 0.0, doppler = 0.0;
      std::size_t local = 0;
      for (int b = 0; b < look.columns.block_count; ++b) {
        const ParameterBlock& block =
            problem_.layout
                .blocks[static_cast<std::size_t>(look.columns.block[static_cast<std::size_t>(b)])];
        for (int c = 0; c < block.size; ++c, ++local) {
          range += look.row[0][local] * dx_[block.offset + c];
          doppler += look.row[1][local] * dx_[block.offset + c];
        }
      }
      factor->e[static_cast<std::size_t>(2 * k)] += range;
      factor->e[static_cast<std::size_t>(2 * k + 1)] += doppler;
    }
    PointStep out;
    out.step_m = -factor->r.triangularView<Eigen::Upper>().solve(Project(*factor, factor->e));
    out.promised_1 = Promised(factor->gradient, factor->square_1, damping_1_, out.step_m);
    return out;
  }

 private:
  const AdjustmentProblem& problem_;
  const BlockState& state_;
  const Weighting& weighting_;
  double damping_1_;
  const Eigen::VectorXd& dx_;
  StraightMotions motions_;
  std::vector<StraightStep> steps_;  // by pass
};

}  // namespace

PointSteps SubstituteBack(const AdjustmentProblem& problem,
                          const BlockState& state,
                          const Weighting& weighting,
                          double damping_1,
                          const Eigen::VectorXd& dx) {
  const std::size_t points = problem.block.points.size();
  PointSteps out;
  out.displacement_m = state.displacement_m;
  std::vector<double> promised((points + kPointsPerChunk - 1) / kPointsPerChunk, 0.0);
  const BackSubstitution substitution(problem, state, weighting, damping_1, dx);
  ParallelForChunks(
      points, kPointsPerChunk, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
        WhitenedLook look;
        PointFactor factor;
        for (std::size_t point = begin; point < end; ++point) {
          if (!problem.Solves(point)) continue;
          const std::optional<PointStep> along = substitution.Along(point, &look);
          const PointStep step = along ? *along : substitution.ByFactors(point, &factor);
          if (!step.step_m.allFinite()) continue;
          out.displacement_m[point] += step.step_m;
          promised[chunk] += step.promised_1;
        }
      });
  for (const double part : promised) out.promised_1 += part;
  return out;
}

}  // namespace sarblock
