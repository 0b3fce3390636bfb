// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/geometry/path.h"
#include "sarblock/model/options.h"
#include "sarblock/simulate/scene.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "geometry/basis.h"
#include <Eigen/Core>

namespace sarblock {

/// A function of time with a continuous second derivative: a polynomial of degree 5 between nodes
/// that give value and two derivatives, straight beyond the first and the last node. Without nodes
/// it is zero.
class SmoothCurve {
 public:
  struct Node {
    double time_s = 0.0;
    double value = 0.0, first = 0.0, second = 0.0;
  };
  SmoothCurve() = default;
  /// Times strictly increase.
  explicit SmoothCurve(std::vector<Node> nodes) : nodes_(std::move(nodes)) {}
  /// Natural cubic spline through values at increasing times, two or more.
  [[nodiscard]] static SmoothCurve Natural(const std::vector<double>& times_s,
                                           const std::vector<double>& values);

  /// Value and three derivatives; the third jumps at the nodes.
  [[nodiscard]] std::array<double, 4> At(double time_s) const;
  [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; }

 private:
  std::vector<Node> nodes_;
};

/// Offsets of a flight from its planned path, along, across, up.
class TrajectoryError {
 public:
  struct Offset {
    Eigen::Vector3d value_m, first_mps, second_mps2, third_mps3;
  };
  /// Draws that of pass number `pass_index` from its own streams of `seed`, for the span of the
  /// planned path.
  TrajectoryError(const SceneTrajectoryError& scene,
                  const Pass& planned,
                  std::size_t pass_index,
                  std::uint64_t seed);
  [[nodiscard]] Offset At(double time_s) const;

 private:
  double start_s_ = 0.0;                // from which the table counts
  std::array<SmoothCurve, 3> process_;  // by axis
  std::array<SmoothCurve, 3> table_;
};

/// A third-order Gauss-Markov process at nodes T/64 apart from `start_s` on both ways until they
/// cover [from_s, to_s], which contains start_s. Each step is exact
/// (docs/theory/trajectory_error.md, eqs. (5) to (8)); between the nodes the curve differs from the
/// process by 5e-7 of its rms. The draw is a function of seed and stream: a longer span continues a
/// shorter one.
[[nodiscard]] SmoothCurve DrawGaussMarkov(double rms,
                                          double time_constant_s,
                                          double start_s,
                                          double from_s,
                                          double to_s,
                                          std::uint64_t seed,
                                          std::uint64_t stream);

/// Draws the joint errors of pass number `pass_index` from its own stream of `seed` and adds them.
void AddJointErrors(const std::vector<JointPrior>& joint,
                    const Frame& frame,
                    const Pass& pass,
                    std::size_t pass_index,
                    std::uint64_t seed,
                    PassError* error);

/// Draws the errors of pass number `pass_index` from its own streams of `seed`.
[[nodiscard]] PassError DrawPassError(const SceneNavigation& navigation,
                                      const Frame& frame,
                                      const Pass& pass,
                                      std::size_t pass_index,
                                      std::uint64_t seed);

/// True path of a pass: s(t) = f(t) + A(t) c(t) + PassError::frame_m, A the track axes of the path
/// f that is flown as far as the recorder knows: the path of `pass`, or FlownPath if there are
/// trajectory errors. Velocity and acceleration are exact derivatives, including the turning of the
/// axes (except, in the acceleration alone, for the third derivative of the planned path's axes
/// times the trajectory error). Keeps references: frame, pass, error and `trajectory_error` must
/// outlive it.
class TruePath {
 public:
  TruePath(const Frame& frame,
           const Pass& pass,
           const PassError& error,
           double knot_spacing_s,
           const TrajectoryError* trajectory_error = nullptr);
  /// Nothing outside the span of the nominal states. Jerk is left zero.
  [[nodiscard]] std::optional<Motion> At(double time_s) const;
  /// State vectors at the nominal times.
  [[nodiscard]] FlightPath AtNominalTimes() const;

 private:
  const Frame* frame_;
  const Pass* pass_;
  const PassError* error_;
  const TrajectoryError* trajectory_error_;
  std::optional<UniformSpline> spline_;
  bool turning_ = false;  // errors along the track axes
  bool fixed_ = false;    // errors along the axes of the frame
};

/// The true path of a pass. Holds references into `simulated`.
[[nodiscard]] TruePath TruePathOf(const Scene& scene,
                                  const SimulatedBlock& simulated,
                                  std::size_t pass);

/// The motion of a flight at `time_s`: f = p + A w, A the track axes of the planned path p. Nothing
/// outside the planned path; `trajectory_error` null: the planned motion. The jerk lacks A''' w.
[[nodiscard]] std::optional<Motion> FlownMotion(const Frame& frame,
                                                const FlightPath& planned,
                                                const TrajectoryError* trajectory_error,
                                                double time_s);

/// The path that the recorder writes: states of the flown motion at start_s + k spacing of the
/// strip, whole k, as far as the planned path reaches, with the recorder's errors drawn from
/// streams of pass and state.
[[nodiscard]] FlightPath RecordFlight(const Frame& frame,
                                      const SceneRecorder& recorder,
                                      double spacing_s,
                                      const Pass& planned,
                                      const TrajectoryError* trajectory_error,
                                      std::size_t pass_index,
                                      std::uint64_t seed);

}  // namespace sarblock
