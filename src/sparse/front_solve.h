// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "front_division.h"
#include <Eigen/Core>

namespace sarblock::sparse {

/// x = (L L')^-1 x, rows in elimination order, the same on all ranks before and afterwards.
/// `factor` are the own panels. Throws OtherRankFailed.
void SolveFronts(const OwnFronts& own, const double* factor, Eigen::MatrixXd* x);

}  // namespace sarblock::sparse
