// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sarblock::dense {

// The kernels of large fronts cut into tiles that idle threads take up (front_schedule.h). The
// tiles depend on the sizes alone, so that every sum is formed in the same order on any number of
// threads. Conventions of dense_kernels.h; a matrix of one tile goes to those kernels whole.

/// Columns eliminated at a time within a front.
inline constexpr int kBlockColumns = 256;

/// The first `columns` columns of a, height x columns: the lower triangle of the top becomes L, the
/// rows below it b L'^-1. Returns the number of the first pivot that is not positive, from 1; 0 if
/// none (the columns before it are then not complete below the block of the pivot).
[[nodiscard]] int FactorPanel(int height, int columns, double* a, int lda);

/// Lower triangle of c -= a a', a n x k.
void SubtractSquareTiled(int n, int k, const double* a, int lda, double* c, int ldc);

/// One step of the selected inverse. z is height x height with the lower triangle of Z_RR in place
/// behind the first `columns`, and panel holds L_JJ and L_RJ: fills Z_RJ and the lower triangle of
/// Z_JJ, kBlockColumns at a time from the last to the first.
void InvertPanel(int height, int columns, const double* panel, double* z);

}  // namespace sarblock::dense
