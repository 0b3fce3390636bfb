// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/model/result.h"

#include <string>
#include <vector>

#include "model/problem.h"

namespace sarblock {

/// Numbers that the points are eliminated and the reduced matrix is factored in: float, double, or
/// long double (64 bits of mantissa, 19 digits, on x86; no more than double elsewhere).
enum class Arithmetic { kSingle, kDouble, kExtended };
[[nodiscard]] const char* NameOf(Arithmetic arithmetic);  ///< "single", "double", "extended"

/// How a point leaves the equations [J_p | J_c | e]:
///     kQr       J_p = Q R,  S += M'M,  M = (I - QQ') J_c             (what the library does)
///     kNormals  V = J_p'J_p,  S += J_c'J_c - W V^-1 W',  W = J_c'J_p  (the textbook)
enum class Elimination { kQr, kNormals };
[[nodiscard]] const char* NameOf(Elimination elimination);  ///< "qr", "normals"

struct ArithmeticSolution {
  bool solved = false;
  std::string problem;  ///< why not, else empty
  int iterations = 0;
  double remaining_step = kNotGiven;  ///< Newton decrement, in sigmas over all unknowns
  BlockState state;
  std::vector<SymmetricEnu> covariance_m2;  ///< by point; NaN where not solved
};

/// The adjustment in another arithmetic, to measure the effect of its rounding: undamped
/// Gauss-Newton from `start`, dense reduced matrix scaled to unit diagonal, covariances of all
/// points. Equations are evaluated in double and positions kept in double for every arithmetic: a
/// range of 1e6 m in single precision is known to 6 cm. Ends when the Newton decrement is below
/// 1e-6 sigmas or no longer halves, where it is rounding of the arithmetic.
///
/// A measuring instrument, not a solver: one thread, time and memory grow with the square and cube
/// of the number of corrections, no damping, no robust loss, no rank analysis. A factor that does
/// not exist in the arithmetic is an outcome (`problem`). Forms the weights of `problem` anew at
/// every state. Throws Interrupted.
[[nodiscard]] ArithmeticSolution SolveInArithmetic(Arithmetic arithmetic,
                                                   Elimination elimination,
                                                   BlockState start,
                                                   AdjustmentProblem* problem,
                                                   ProgressSink* progress);

}  // namespace sarblock
