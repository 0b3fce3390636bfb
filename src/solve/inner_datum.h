// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/options.h"
#include "sarblock/model/result.h"

#include <cstdint>
#include <functional>
#include <vector>

#include "model/problem.h"
#include "normals/reduced_system.h"
#include <Eigen/Core>

namespace sarblock {

/// Fixes as many corrections of a floating block as it has defects, at their present values, so
/// that one solution among many is found: a minimal constraint, which changes no residual.
/// `null_space` has the defects' directions as columns, by parameter (ReducedSystem::NullSpace).
/// `unit` the parameters' units (ReducedSystem::Unit), in which metres and seconds compare. The
/// parameters are those that distinguish the directions best (column-pivoted QR).
void FixDatum(const Eigen::MatrixXd& null_space,
              const Eigen::VectorXd& unit,
              const BlockState& state,
              AdjustmentProblem* problem);

/// The transformation of a minimally constrained solution to another datum of the same block
/// (S-transformation, Baarda 1973; docs/theory/datum.md). With G the null space of the normal
/// matrix over all unknowns and E the selection of the datum points' coordinates,
///
///     x -> S x,   C -> S C S',   S = I - G (G'E G)^-1 G'E
///
/// gives the solution nearest to the start values at the datum points, sum |p - p0|^2 smallest, and
/// the covariance whose trace over these points is smallest. Any C of the block's minimal
/// constraints gives the same result. Memory: 6 numbers per defect and point.
class DatumTransform {
 public:
  /// `system`: formed and factored at `state` with the problem's fixed parameters. `in_datum`: by
  /// point, whether it counts in E; points that are not solved never do. Throws UndeterminedError
  /// where the datum points do not determine the datum (one point alone and a rotation).
  DatumTransform(const AdjustmentProblem& problem,
                 const BlockState& state,
                 const ReducedSystem& system,
                 const Eigen::MatrixXd& null_space,
                 const std::vector<std::uint8_t>& in_datum);

  [[nodiscard]] int defects() const { return static_cast<int>(corrections_g_.cols()); }

  /// Moves the state to the least square sum of displacements at the datum points; returns the
  /// largest move of a point [m]. First order: repeat with a solution in between.
  [[nodiscard]] double Move(const AdjustmentProblem& problem, BlockState* state) const;

  /// Transforms point covariances (east-north-up at the point).
  void Transform(const AdjustmentProblem& problem,
                 const BlockState& state,
                 std::vector<SymmetricEnu>* covariance_m2) const;
  /// Transforms covariances of corrections.
  void Transform(std::vector<ParameterCovariance>* covariance) const;
  /// Transforms covariances of differences (east-north-up at the first point).
  void Transform(const AdjustmentProblem& problem,
                 const BlockState& state,
                 std::vector<PairResult>* pairs) const;

 private:
  using Rows = Eigen::Matrix<double, 3, Eigen::Dynamic>;
  [[nodiscard]] Rows G(std::size_t point) const {
    return points_g_.middleRows<3>(3 * static_cast<Eigen::Index>(point));
  }
  [[nodiscard]] Rows K(std::size_t point) const {
    return points_k_.middleRows<3>(3 * static_cast<Eigen::Index>(point));
  }

  std::vector<std::uint8_t> in_datum_;
  // G with G'E G = I, K = C E G, both by unknown, and G'E C E G.
  Eigen::MatrixXd points_g_, points_k_, corrections_g_, corrections_k_, inner_;
};

/// Refuses options that do not go with an inner datum.
void RequireInnerOffered(const AdjustOptions& options);

/// By point: named by options.datum_points, or all where none is named. Throws InputError for a
/// point the block does not have.
[[nodiscard]] std::vector<std::uint8_t> DatumPoints(const Block& block,
                                                    const AdjustOptions& options);

/// Fixes the datum at a state where the block has none (FixDatum); false where it has one.
[[nodiscard]] bool FixDatumIfFloating(const BlockState& state, AdjustmentProblem* problem);

/// Moves a solved state to the inner datum, solving again by `solve` until it stays, and returns
/// the transformation of covariances there. The problem's fixed parameters follow.
[[nodiscard]] DatumTransform SettleInnerDatum(const AdjustOptions& options,
                                              const std::function<void()>& solve,
                                              AdjustmentProblem* problem,
                                              BlockState* state);

}  // namespace sarblock
