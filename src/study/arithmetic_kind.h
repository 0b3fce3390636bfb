// SPDX-License-Identifier: Apache-2.0
#pragma once

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

}  // namespace sarblock
