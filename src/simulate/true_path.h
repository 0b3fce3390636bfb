// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/geometry/path.h"
#include "sarblock/simulate/scene.h"
#include "sarblock/simulate/simulated_block.h"

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "geometry/basis.h"
#include "wander.h"

namespace sarblock {

/// Draws the errors of pass number `pass_index` from its own streams of `seed`.
[[nodiscard]] PassError DrawPassError(const SceneNavigation& navigation,
                                      const Frame& frame,
                                      const Pass& pass,
                                      std::size_t pass_index,
                                      std::uint64_t seed);

/// True path of a pass: s(t) = f(t) + A(t) c(t) + PassError::frame_m, A the track axes of the path
/// f that is flown as far as the recorder knows: the path of `pass`, or where flights wander
/// FlownPath. Velocity and acceleration are exact derivatives, the turning of the axes included
/// (but for the third derivative of the planned path's axes times the wander, in the acceleration
/// alone). Holds references: frame, pass, error and wander must outlive it.
class TruePath {
 public:
  TruePath(const Frame& frame,
           const Pass& pass,
           const PassError& error,
           double knot_spacing_s,
           const Wander* wander = nullptr);
  /// Nothing outside the span of the nominal states. Jerk is left zero.
  [[nodiscard]] std::optional<Motion> At(double time_s) const;
  /// State vectors at the nominal times.
  [[nodiscard]] FlightPath AtNominalTimes() const;

 private:
  const Frame* frame_;
  const Pass* pass_;
  const PassError* error_;
  const Wander* wander_;
  std::optional<UniformSpline> spline_;
  bool turning_ = false;  // errors along the track axes
  bool fixed_ = false;    // errors along the axes of the frame
};

/// The true path of a pass. Holds references into `simulated`.
[[nodiscard]] TruePath TruePathOf(const Scene& scene,
                                  const SimulatedBlock& simulated,
                                  std::size_t pass);

}  // namespace sarblock
