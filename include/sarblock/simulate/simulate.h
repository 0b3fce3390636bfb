// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/simulate/scene.h"

#include <cstdint>

namespace sarblock {

/// Simulates a scene: nominal paths, terrain, points, visibility, then Redraw() of everything with
/// the scene's seed. The same scene gives the same bytes.
///
/// A point is seen by a pass when the cone equation on the nominal path has its solution inside the
/// strip's time and the point then lies inside the swath on the look side (docs/scenes.md), and,
/// with SceneTerrain::hides, neither in shadow nor in layover. SimulatedBlock::coverage counts what
/// is lost. Times and ranges come from the true path (model.md, section 4):
///
///     e_d(t) = 0 with squint tau + b_tau  ->  t;      t_measured = t - b_t + sigma_t n
///     R_measured = (1 + kappa) |p - s(t)| + b_r + sigma_R n_2
///
/// A look whose Doppler is measured has the time t - b_t exactly and sigma_f n on its Doppler.
///
/// Order of points: control (C...), check (K...), tie (T...). Throws InputError (Validate) and
/// Interrupted.
[[nodiscard]] SimulatedBlock Simulate(const Scene& scene, ProgressSink* progress = nullptr);

/// What Redraw() draws anew; the rest stays as it is.
struct RedrawChoice {
  bool measurements = true;  ///< noise and blunders of the looks
  bool navigation = true;  ///< true paths, their recording and biases about the same planned paths
  bool control = true;     ///< errors of control and check coordinates
};

/// Draws random errors anew from `seed`, for seeded statistics: points, nominal paths and the list
/// of looks stay, so that a draw costs one cone solution a look (navigation) or two random numbers.
/// The result depends on scene, seeds and choice alone, not on earlier draws. `scene` must be the
/// one `simulated` was made from. Throws InputError if a true look leaves its nominal path's span.
void Redraw(const Scene& scene,
            std::uint64_t seed,
            const RedrawChoice& choice,
            SimulatedBlock* simulated);

}  // namespace sarblock
