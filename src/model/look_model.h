// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/geometry/intersection.h"
#include "sarblock/geometry/look_equations.h"
#include "sarblock/model/result.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "corrected_paths.h"
#include "look_evaluation.h"
#include "parameters.h"
#include <Eigen/Core>

namespace sarblock {

/// Parameter blocks a look touches, in the order of its local columns.
struct LookColumns {
  std::array<int, ParameterLayout::kMaxLocalColumns> block;  ///< the first block_count are set
  int block_count = 0;
  int column_count = 0;
};

/// Where a look is evaluated: its point at start_m + displacement_m, and its local corrections.
struct LookState {
  std::size_t look = 0;
  const LookColumns& columns;
  const Eigen::Vector3d& start_m;
  const Eigen::Vector3d& displacement_m;
  const double* x = nullptr;  ///< column_count values
};

/// The antenna at a time of a pass under corrections.
struct CorrectedMotion {
  Motion motion;             ///< corrected; the jerk lacks A''' delta
  double path_time_s = 0.0;  ///< t + b_t
};

/// The looks of a block under all corrections: EvaluateMeasuredLook() of each with what the block
/// says of it. Thread-safe but for Anchor; holds references to the block and the layout, which must
/// outlive it.
class LookModel {
 public:
  LookModel(const Block& block, const ParameterLayout& layout, const Simplified& simplified = {});

  [[nodiscard]] const Block& block() const { return block_; }
  [[nodiscard]] const ParameterLayout& layout() const { return layout_; }
  [[nodiscard]] const Simplified& simplified() const { return simplified_; }

  [[nodiscard]] const CorrectedPaths& paths() const { return paths_; }

  /// Approximate work of evaluating a look of a pass, in arbitrary units: counts, not times, decide
  /// whether a simplification is worth taking, so that all machines decide alike.
  [[nodiscard]] double WorkOf(std::size_t pass) const;

  /// Standard deviations of a look: the block's times the factors of its pass.
  [[nodiscard]] LookSigma SigmaOf(std::size_t look) const;
  /// Factors on the standard deviations of range and azimuth by pass; empty: 1. The weights do not
  /// follow by themselves (UpdateWeights).
  void ScaleSigmas(std::vector<std::array<double, 2>> factors) {
    sigma_factors_ = std::move(factors);
  }
  [[nodiscard]] const std::vector<std::array<double, 2>>& sigma_factors() const {
    return sigma_factors_;
  }

  void ColumnsOf(std::size_t look, LookColumns* columns) const;
  /// The columns of a look of `pass` measured at `time_s`.
  void ColumnsAt(std::size_t pass, double time_s, LookColumns* columns) const;

  /// What a look of the block measured.
  [[nodiscard]] MeasuredLook MeasuredAt(std::size_t look) const;

  /// EvaluateMeasuredLook() of a look of the block.
  [[nodiscard]] LookValue ValueOf(const LookState& at,
                                  const LookWeights& weights,
                                  LookEvaluation* out,
                                  LookCurvature* curvature = nullptr) const;
  /// The same; false where there is no value.
  [[nodiscard]] bool Evaluate(const LookState& at,
                              const LookWeights& weights,
                              LookEvaluation* out,
                              LookCurvature* curvature = nullptr) const;

  /// Corrected antenna motion of a pass at measured time t with all corrections `x` of the block;
  /// nothing outside the path.
  [[nodiscard]] std::optional<CorrectedMotion> CorrectedMotionAt(std::size_t pass,
                                                                 double time_s,
                                                                 const Eigen::VectorXd& x) const;

  /// The same for a path time given outright, as for the states of the corrected path.
  [[nodiscard]] std::optional<CorrectedMotion> CorrectedMotionAtPathTime(
      std::size_t pass, double measured_s, double path_s, const Eigen::VectorXd& x) const;

  /// A look with fixed path, with corrections `x`, read at its measured time;
  /// nothing outside the path.
  [[nodiscard]] std::optional<FixedPathLook> FixPath(std::size_t look,
                                                     const Eigen::VectorXd& x) const;

  /// Asks the memory for what a look will read of its path.
  void Prefetch(std::size_t look) const {
    paths_[block_.looks.pass[look]].path().Prefetch(block_.looks.time_s[look]);
  }

  /// Reads the paths at the time biases in all corrections `x`; returns whether that changed what a
  /// look reads (CorrectedPath::Anchor).
  bool Anchor(const Eigen::VectorXd& x, double slack = 0.0) { return paths_.Anchor(x, slack); }
  /// Takes the anchors of another model of the same passes.
  void AnchorLike(const LookModel& other) { paths_.AnchorLike(other.paths_); }

 private:
  /// The motion read at read_s and continued to path_s.
  [[nodiscard]] std::optional<CorrectedMotion> ReadMotion(std::size_t pass,
                                                          double measured_s,
                                                          double read_s,
                                                          double path_s,
                                                          const Eigen::VectorXd& x) const;

  const Block& block_;
  const ParameterLayout& layout_;
  Simplified simplified_;
  CorrectedPaths paths_;
  std::vector<std::array<double, 2>> sigma_factors_;
};

/// Local corrections of a look gathered from the block's vector x.
void GatherColumns(const ParameterLayout& layout,
                   const LookColumns& columns,
                   const Eigen::VectorXd& x,
                   double* local);

/// The same in place where they follow each other in x, as those of one block do, else in `local`.
[[nodiscard]] const double* LocalCorrections(
    const ParameterLayout& layout,
    const LookColumns& columns,
    const Eigen::VectorXd& x,
    std::array<double, ParameterLayout::kMaxLocalColumns>* local);

}  // namespace sarblock
