// SPDX-License-Identifier: Apache-2.0
#include "basis.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace sarblock {

void LegendreValues(double x, BasisValues out) {
  for (std::size_t k = 0; k < std::min<std::size_t>(3, out.third.size()); ++k) out.third[k] = 0.0;
  for (std::size_t k = 0; k < out.value.size(); ++k) {
    if (k == 0) {
      out.value[0] = 1.0;
      out.first[0] = 0.0;
      out.second[0] = 0.0;
    } else if (k == 1) {
      out.value[1] = x;
      out.first[1] = 1.0;
      out.second[1] = 0.0;
    } else {
      const auto n = static_cast<double>(k - 1);  // from P_n-1 and P_n to P_n+1
      const double odd = 2.0 * n + 1.0;
      out.value[k] = (odd * x * out.value[k - 1] - n * out.value[k - 2]) / (n + 1.0);
      out.first[k] = out.first[k - 2] + odd * out.value[k - 1];
      out.second[k] = out.second[k - 2] + odd * out.first[k - 1];
      if (k > 2 && !out.third.empty()) {
        out.third[k] = out.third[k - 2] + odd * out.second[k - 1];
      }
    }
  }
}

UniformSpline::UniformSpline(double start_s, double end_s, double knot_spacing_s)
    : start_s_(start_s) {
  if (!(std::isfinite(start_s) && std::isfinite(end_s) && end_s > start_s)) {
    throw InputError("spline span",
                     "from " + std::to_string(start_s) + " s to " + std::to_string(end_s) +
                         " s must be finite and longer than 0");
  }
  if (!(std::isfinite(knot_spacing_s) && knot_spacing_s > 0.0)) {
    throw InputError("knot_spacing_s",
                     std::to_string(knot_spacing_s) + " must be finite and greater than 0");
  }
  const double span_s = end_s - start_s;
  // A span of three spacings to within rounding is three pieces, not four.
  const double pieces = std::max(1.0, std::ceil(span_s / knot_spacing_s * (1.0 - 1e-12)));
  if (!(pieces <= static_cast<double>(kMaxPieces))) {
    throw InputError("knot_spacing_s",
                     std::to_string(knot_spacing_s) + " would divide " + std::to_string(span_s) +
                         " s into more than " + std::to_string(kMaxPieces) + " pieces");
  }
  pieces_ = static_cast<std::size_t>(pieces);
  spacing_s_ = span_s / pieces;
}

std::size_t UniformSpline::PieceOf(double time_s) const {
  const double u = (time_s - start_s_) / spacing_s_;
  const auto last = static_cast<double>(pieces_ - 1);
  return u > 0.0 ? static_cast<std::size_t>(std::min(std::floor(u), last)) : 0;
}

std::size_t UniformSpline::Evaluate(double time_s, BasisValues four) const {
  const std::size_t piece = PieceOf(time_s);
  EvaluatePiece(piece, time_s, four);
  return piece;
}

void UniformSpline::EvaluatePiece(std::size_t piece, double time_s, BasisValues four) const {
  const double x = (time_s - start_s_) / spacing_s_ - static_cast<double>(piece);
  const double y = 1.0 - x;
  const double h = spacing_s_;
  four.value[0] = y * y * y / 6.0;
  four.value[1] = ((3.0 * x - 6.0) * x * x + 4.0) / 6.0;
  four.value[2] = ((3.0 * y - 6.0) * y * y + 4.0) / 6.0;
  four.value[3] = x * x * x / 6.0;
  four.first[0] = -0.5 * y * y / h;
  four.first[1] = (1.5 * x - 2.0) * x / h;
  four.first[2] = -(1.5 * y - 2.0) * y / h;
  four.first[3] = 0.5 * x * x / h;
  four.second[0] = y / (h * h);
  four.second[1] = (3.0 * x - 2.0) / (h * h);
  four.second[2] = (3.0 * y - 2.0) / (h * h);
  four.second[3] = x / (h * h);
  if (four.third.empty()) return;
  const double cube_per_s3 = 1.0 / (h * h * h);
  four.third[0] = -cube_per_s3;
  four.third[1] = 3.0 * cube_per_s3;
  four.third[2] = -3.0 * cube_per_s3;
  four.third[3] = cube_per_s3;
}

}  // namespace sarblock
