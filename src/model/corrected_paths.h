// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/result.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "geometry/track_axes.h"
#include "parameters.h"
#include <Eigen/Core>

namespace sarblock {

/// Speed at which noise of the states moves the cone of a pass at its farthest point, over the
/// speed |v| at which the cone passes over that point: |a_cubic - a_velocities| R / v^2 at the
/// worse end of each piece of its path from its first look to its last.
struct ConeTurning {
  /// That is the length of a difference of accelerations. Only its part along the line of sight
  /// turns the cone, half of the length in the mean over directions and ends: from 2 on the cone
  /// turns back in every other piece, from kFolding on in most.
  static constexpr double kFolding = 3.0;
  double largest = 0.0, median = 0.0;
  double range_m = 0.0;                ///< largest measured
  std::size_t pieces = 0, folded = 0;  ///< those above kFolding
};

/// One term of the position corrections at a time: its basis functions with derivatives by time.
/// Function k of the axis that is the rank-th one corrected has the local column
/// column + rank by_axis + k by_function. Left unset until it is read: it is large.
struct TermAtTime {
  PositionCorrection::Axes axes;
  std::array<bool, 3> components;
  int column, by_axis, by_function;
  std::size_t functions;
  bool bends;  ///< whether second and third are not all 0; where not, they are not set
  std::array<double, PositionCorrection::kMaxDegree + 1> value, first, second, third;

  void Read(const PassCorrections& pass, const PolynomialTerm& term, double t_s);
  /// The four spline functions of the piece that holds the measured time, at the path's time t.
  void Read(const SplineTerm& term, int first_column, double measured_s, double t_s);
};

/// Everything about the corrected path at the measured time that both observation equations need.
struct PathReading {
  PathReading() = default;
  PathReading(const PathReading&) = delete;  // it points to itself
  PathReading& operator=(const PathReading&) = delete;
  Motion motion;                          ///< corrected; the jerk lacks A''' delta
  Eigen::Vector3d given_mps, given_mps2;  ///< velocity and acceleration without the corrections
  const Eigen::Matrix3d* axes = nullptr;  ///< track axes, where a correction needs them
  std::optional<TrackAxes> turning;       ///< the same with their derivatives, where they turn
  std::size_t term_count = 0;
  std::array<TermAtTime, ParameterLayout::kMaxPolynomials + ParameterLayout::kMaxSplines> terms;

  [[nodiscard]] bool Bends() const {
    return std::any_of(terms.begin(), terms.begin() + term_count, [](const TermAtTime& term) {
      return term.bends;
    });
  }
};

/// Figures of the looks of a pass that decide how its path is read.
struct PathUse {
  double first_s = std::numeric_limits<double>::infinity(), last_s = -first_s;  ///< none: empty
  double range_m = 0.0;                ///< largest measured
  double azimuth_sigma_m = kNotGiven;  ///< of one of them, metres at the target
};

/// The flight path of a pass under its corrections. It is read at a time; from there the antenna
/// moves on with its acceleration and jerk (EvaluateMeasuredLook). Holds references to the frame,
/// the path and the corrections, which must outlive it. Thread-safe but for Anchor.
class CorrectedPath {
 public:
  /// Throws InputError where track axes are needed and the path has none.
  CorrectedPath(const Frame& frame,
                const FlightPath& path,
                const PassCorrections& corrections,
                const PathUse& use,
                const Simplified& simplified);

  /// Part of the speed at which the cone passes over a point; where noise of the states turns the
  /// cone by more, the antenna moves on along the path without that noise (IsNoisy).
  static constexpr double kMaxTurn = 0.01;
  /// The same where a time bias moves the antenna far along its path. The recorded orbits of
  /// datasets/scenes have 1e-6 to 1e-5, its recorded flights 5e-3 and more.
  static constexpr double kSteadyTurn = 1e-3;

  [[nodiscard]] const FlightPath& path() const { return *path_; }
  [[nodiscard]] const PassCorrections& corrections() const { return *corrections_; }

  /// The nominal path read at read_s for a look measured at measured_s: position and velocity as
  /// recorded, acceleration and jerk as the antenna moves on from there. For a noisy pass, position
  /// and velocity are those recorded at measured_s, and from there to read_s the antenna moves as
  /// the path without noise does (docs/theory/observations.md, eq. (11e)). False too far beyond the
  /// path's ends. `piece`, where given, becomes the index of the piece.
  [[nodiscard]] bool ReadNominal(double measured_s,
                                 double read_s,
                                 Motion* out,
                                 std::size_t* piece = nullptr) const;
  /// Whether noise of its states makes the antenna move on along the path without that noise.
  [[nodiscard]] bool IsNoisy() const { return smooth_.has_value(); }
  /// Whether a look reads the path where it sees its point, not near its measured time: along the
  /// path without noise that is one smooth curve, however far a time bias goes.
  [[nodiscard]] bool ReadsAtCrossing() const {
    return IsNoisy() && !corrections_->time_bias.empty();
  }
  /// Where the path is read first for a look whose time with its bias is path_s.
  [[nodiscard]] double ReadingTime_s(double measured_s, double path_s) const {
    return ReadsAtCrossing() ? path_s : measured_s + anchor_s_;
  }
  /// Sets the anchor, a whole number of steps of a grid, to the nearest of a time bias; returns
  /// whether it changed. If the reading moved with a time bias, it would jump from one piece of the
  /// path to the next, and the solver would not converge there; a fixed reading is continued by its
  /// derivatives over the rest of the bias, less than half a step. The anchor stays while the bias
  /// is within 0.5 + `slack` steps of it.
  bool Anchor(double bias_s, double slack = 0.0);
  /// Takes the anchor of another reading of the same pass.
  void AnchorLike(const CorrectedPath& other) { anchor_s_ = other.anchor_s_; }
  /// Reads this much after the measured times.
  void AnchorAt(double anchor_s) { anchor_s_ = anchor_s; }
  [[nodiscard]] const ConeTurning& turning() const { return turning_; }
  [[nodiscard]] bool AxesTurn() const { return axes_ == TrackAxesUse::kTurning; }
  /// The vertical that tropospheric delays see at a point.
  [[nodiscard]] Vertical DelayVerticalAt(const Eigen::Vector3d& p_m) const;

  /// Reads the path at read_s under its local corrections `x`, measured_s choosing the pieces of
  /// splines. False too far beyond the path's ends or where corrections overflow.
  [[nodiscard]] bool Read(double measured_s,
                          double read_s,
                          const double* x,
                          PathReading* out) const;

 private:
  enum class TrackAxesUse { kNone, kConstant, kTurning };
  /// The tangent plane of a flat frame.
  struct Plane {
    Vertical middle;
    Eigen::Vector3d middle_m;
  };
  [[nodiscard]] double AnchorStep_s(double sigma_m) const;
  const Frame* frame_;
  const FlightPath* path_;
  const PassCorrections* corrections_;
  TrackAxesUse axes_ = TrackAxesUse::kNone;
  Eigen::Matrix3d constant_axes_ = Eigen::Matrix3d::Identity();  // kConstant
  VerticalTable verticals_;                                      // kTurning
  ConeTurning turning_;
  std::optional<FlightPath> smooth_;  // without noise; unset: not used
  std::optional<Plane> plane_;
  double anchor_step_s_ = 0.0;  // 0: the anchor stays 0
  double anchor_s_ = 0.0;
};

/// PathUse of each pass of a block.
[[nodiscard]] std::vector<PathUse> PathUsesOf(const Block& block);

/// The flight paths of a block under corrections. Holds references to the block and the layout,
/// which must outlive it.
class CorrectedPaths {
 public:
  /// Throws InputError naming a pass that needs track axes and has none.
  CorrectedPaths(const Block& block, const ParameterLayout& layout, const Simplified& simplified);
  CorrectedPaths(const CorrectedPaths&) = delete;  // a path refers to those that are straightened
  CorrectedPaths& operator=(const CorrectedPaths&) = delete;

  [[nodiscard]] const CorrectedPath& operator[](std::size_t pass) const { return paths_[pass]; }
  /// Sets the anchors to the time biases in all corrections `x` of the block; returns whether one
  /// changed (CorrectedPath::Anchor).
  bool Anchor(const Eigen::VectorXd& x, double slack = 0.0);
  /// Takes the anchors of other corrections of the same passes.
  void AnchorLike(const CorrectedPaths& other);

 private:
  const ParameterLayout& layout_;
  std::vector<FlightPath> straightened_;  // by pass; empty: the block's
  std::vector<CorrectedPath> paths_;      // by pass
};

}  // namespace sarblock
