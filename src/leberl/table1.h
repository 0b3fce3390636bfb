// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/leberl/formulas.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sarblock {

/// How a printed number of Leberl (1979) compares with its formula and the rigorous solution.
enum class PaperVerdict {
  kAgrees,      ///< printed = formula = derivative, and the exact value rounds to it as well
  kTruncation,  ///< printed = formula = derivative; the exact value differs by the finite size
  kSlip,        ///< the printed digits or their formula do not follow from the geometry
  kIllegible,   ///< the copy cannot be read with certainty
};
[[nodiscard]] const char* NameOf(PaperVerdict verdict);  ///< "agrees", "truncation", ...

/// One cell of Table 1. Verdicts are computed: "=" between printed and a value means that the
/// value rounds to the printed digits (half a unit of the last digit that is not a trailing zero
/// of an integer, ties either way), between formula and derivative 1e-9 relative.
struct Table1Cell {
  std::string configuration;    ///< aircraft, voir
  std::string position;         ///< near, far
  std::string quantity;         ///< dy, dz, ddy, ddz
  std::optional<double> dy_km;  ///< coordinate difference; empty for dy and dz
  std::optional<double> dz_km;
  std::string source;  ///< dy0'', dz0'', dr'', dB, dH
  double size_m = 0.0;
  std::string printed_text;         ///< as transcribed, "?" marks a bad copy
  std::optional<double> printed_m;  ///< empty where illegible
  double formula_m = 0.0;           ///< the paper's equation as it prints it
  double derivative_m = 0.0;        ///< rigorous, first order
  double exact_m = 0.0;             ///< rigorous, finite size
  PaperVerdict verdict = PaperVerdict::kSlip;
  std::string note;  ///< size of the truncation, or what reproduces the printed digits
  /// What explains a slip: of all mistakes that reproduce its printed digits the one that explains
  /// most slips of the table. Empty for other verdicts.
  std::string cause;
};

/// All 72 cells of Table 1, in the order of the printed rows.
[[nodiscard]] std::vector<Table1Cell> PaperTable1();

/// The four geometries of Table 1: "aircraft" (B = 8 km, H = 10 km) or "voir" (40 km, 375 km),
/// "near", "far" or "centre" (mean of near and far). Throws InputError for another name.
[[nodiscard]] leberl::StereoConfiguration PaperConfiguration(std::string_view configuration,
                                                             std::string_view position);

/// A number the paper quotes outside Table 1. Values in `unit`.
struct QuotedExample {
  std::string name;
  std::string unit;
  double printed = 0.0;
  std::string printed_text;
  double formula = 0.0;
  std::optional<double> derivative;  ///< empty where the quantity has no first order
  std::optional<double> exact;
  PaperVerdict verdict = PaperVerdict::kSlip;
  std::string note;
  std::string cause;  ///< of a slip
};

/// All quoted examples: errors in the model centre, noise, exaggerations, intersection angles, the
/// viewing guidance, and what the text says of these numbers beside each other.
[[nodiscard]] std::vector<QuotedExample> PaperExamples();

/// A cause and how many of the slips it explains.
struct SlipCause {
  std::string cause;
  int count = 0;
};
/// Causes of slips, each once, the most frequent first.
[[nodiscard]] std::vector<SlipCause> CountCauses(const std::vector<std::string>& causes);

}  // namespace sarblock

namespace sarblock::paper {

// What a cell of the paper's Table 1 asks, and substitutions that may explain its printed digits.

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
