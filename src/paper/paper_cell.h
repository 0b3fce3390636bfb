// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/leberl/point_errors.h"
#include "sarblock/leberl/relative_errors.h"

#include <string>
#include <string_view>
#include <vector>

// What a cell of the paper's Table 1 asks, and substitutions that may explain its printed digits.
namespace sarblock::paper {

enum class Quantity { kAcross, kUp };
enum class Source { kAcrossPosition, kUpPosition, kRange };

/// One question: error of y or z (or of their differences) by one error of station ''.
struct Cell {
  leberl::StereoConfiguration configuration;
  leberl::StereoConfiguration other_position;  ///< the far cell's geometry for a near one
  Quantity quantity = Quantity::kAcross;
  Source source = Source::kAcrossPosition;
  double size_m = 0.0;
  bool is_relative = false;
  leberl::Difference difference;
};

/// Errors of station '' that the cell asks for.
[[nodiscard]] leberl::StereoErrors ErrorsOf(const Cell& cell);
/// The paper's equation.
[[nodiscard]] double Formula(const Cell& cell, leberl::Signs signs);
/// "Eq. 14", "Eq. 19", ...
[[nodiscard]] const char* EquationOf(const Cell& cell);

/// Unit of the last printed digit that counts: trailing zeros of an integer do not.
[[nodiscard]] double RoundingUnit(std::string_view printed);
/// Whether `value` rounds to the printed number, ties either way.
[[nodiscard]] bool RoundsTo(double value, std::string_view printed);

/// A value that a plausible mistake would give.
struct Substitution {
  std::string what;
  double value_m = 0.0;
};
/// Other sign, other station, y for y - B, r' for r'', ground for slant range, other equation,
/// one term alone, the other position, a common range error, rounded or cut intermediates.
[[nodiscard]] std::vector<Substitution> Substitutions(const Cell& cell, std::string_view printed);

}  // namespace sarblock::paper
