// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

namespace sarblock {

/// Values of basis functions at one time, with first, second and, unless empty, third derivatives
/// by the argument.
struct BasisValues {
  std::span<double> value;
  std::span<double> first;
  std::span<double> second;
  std::span<double> third = {};
};

/// Legendre polynomials P_0..P_n of x, by Bonnet's recursion and its derivatives
/// (docs/theory/flight_path.md, eq. (5)); n + 1 = out.value.size(). Orthogonal on [-1, 1]; values
/// slightly outside are continued.
void LegendreValues(double x, BasisValues out);

/// A uniform cubic B-spline on [start_s, end_s]: `count()` coefficients, knots `spacing_s` apart
/// where spacing is the largest that divides the span and does not exceed the one asked for.
/// Four functions are not zero at a time; they sum to one. Outside the span the first or last
/// polynomial piece is continued.
class UniformSpline {
 public:
  /// More pieces than this are taken for a mistake in the unit of the spacing.
  static constexpr std::size_t kMaxPieces = 1000000;

  UniformSpline() = default;
  /// Throws InputError unless end_s > start_s and knot_spacing_s > 0, all finite, with at most
  /// kMaxPieces pieces.
  UniformSpline(double start_s, double end_s, double knot_spacing_s);

  [[nodiscard]] std::size_t count() const { return pieces_ + 3; }
  [[nodiscard]] double spacing_s() const { return spacing_s_; }
  /// The four functions not zero at `time_s`, derivatives by time; returns the first one's index.
  [[nodiscard]] std::size_t Evaluate(double time_s, BasisValues four) const;
  /// Piece (interval between knots) that holds a time, the first or last one outside the span.
  [[nodiscard]] std::size_t PieceOf(double time_s) const;
  /// Functions piece .. piece + 3 by the polynomials of that piece, continued to any time.
  void EvaluatePiece(std::size_t piece, double time_s, BasisValues four) const;

 private:
  double start_s_ = 0.0;
  double spacing_s_ = 1.0;
  std::size_t pieces_ = 1;
};

}  // namespace sarblock
