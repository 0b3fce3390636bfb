// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "look_model.h"
#include <Eigen/Core>

namespace sarblock {

/// Whitened partials of a look by the columns of its StraightPass, given those by the point.
inline void FillStraightRows(const StraightPass& straight,
                             const PassCorrections& c,
                             double time_s,
                             const LookEquations& eq,
                             const Whitening& w,
                             const Eigen::Matrix<double, 2, 3>& by_point,
                             LookRows rows) {
  if (!c.polynomials.empty()) {
    const PolynomialTerm& term = c.polynomials[0];
    const double rate = 1.0 / c.half_length_s;
    const double basis_1 = (time_s - c.middle_s) * rate;
    const Eigen::RowVector3d by_rate = (w.w11 * rate) * eq.ded_dv;
    double* range = rows.range + term.column;
    double* doppler = rows.doppler + term.column;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      if (!term.components[static_cast<std::size_t>(axis)]) continue;
      const auto along = straight.axes_1.col(axis);
      const double r = -by_point.row(0).dot(along), d = -by_point.row(1).dot(along);
      *range++ = r;
      *doppler++ = d;
      if (term.degree == 0) continue;
      *range++ = r * basis_1;
      *doppler++ = d * basis_1 + by_rate.dot(along);
    }
  }
  for (const int column : c.range_bias) {
    rows.range[column] = w.w00;
    rows.doppler[column] = w.w10;
  }
  for (const int column : c.range_scale) {
    rows.range[column] = w.w00 * eq.rho_m;
    rows.doppler[column] = w.w10 * eq.rho_m;
  }
}

}  // namespace sarblock
