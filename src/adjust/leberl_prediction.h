// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/result.h"

#include "model/problem.h"

namespace sarblock {

/// What Leberl (1979) predicts for every solved point and every pair of `result`, from its best
/// pair of looks alone: no other look, no control, no redundancy. docs/theory/leberl.md, section 8.
///
/// Best pair: among the pairs of looks that leberl::ReducePair reduces to B, H, y, the one with the
/// smallest sigma_y^2 + sigma_z^2 of Eq. 25 with the looks' own range sigmas. Above 6 looks only
/// pairs with the first look or the one seen under the most different angle are tried.
///
/// Noise (points.sigma_leberl_*): Eq. 25. Path (points.sigma_leberl_path_*): Eq. 14 and 15, one
/// prior standard deviation of a position, range or troposphere correction after the other, each
/// through its effect on the two slant ranges, added in squares. Shared corrections act on both
/// looks at once.
/// Pairs: noise of two points is independent, so its sigmas add in squares; a correction common to
/// both points acts by the difference of its effects, which is what Eq. 18, 19, 22, 23 and 24 (with
/// the derived signs) are for close points.
///
/// NaN: no pair can be reduced (single look, squint, crossing tracks, unequal heights, nadir);
/// pairs also where the across directions of the two points differ by more than 10 degrees. Path
/// sigmas are NaN where a correction without a prior moves the point: the paper has no number then.
/// Prior figures: never scaled by the variance factor. Parallel over points.
void FillLeberlPrediction(const AdjustmentProblem& problem,
                          const BlockState& state,
                          AdjustResult* result);

}  // namespace sarblock
