// SPDX-License-Identifier: Apache-2.0
// A program outside the project: one look from 3 km to the side and 4 km up, squint 0, so that
// the range is 5 km and the cone error 0 (hand values); and a quantile, 3.841 at 95 percent and one
// degree of freedom (any statistical table).
#include <cmath>
#include <cstdio>

#include <sarblock/core/statistics.h>
#include <sarblock/geometry/look_equations.h>

int main() {
  sarblock::LookEquations look;
  const bool evaluated = sarblock::EvaluateLookEquations(
      {17.0, 3000.0, 0.0}, {17.0, 0.0, 4000.0}, {123.0, 0.0, 0.0}, sarblock::Cone{}, 0.0, &look);
  const double quantile = sarblock::ChiSquareQuantile(0.95, 1.0);
  std::printf("range %.6f m, cone error %.6f m, chi-square quantile %.6f\n",
              look.rho_m,
              look.doppler_error_m,
              quantile);
  const bool right = evaluated && std::abs(look.rho_m - 5000.0) < 1e-9 &&
                     std::abs(look.doppler_error_m) < 1e-9 && std::abs(quantile - 3.841459) < 1e-6;
  return right ? 0 : 1;
}
