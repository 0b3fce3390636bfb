// SPDX-License-Identifier: Apache-2.0
#include "paper/paper_table.h"

#include "sarblock/core/error.h"

#include <array>
#include <cmath>
#include <cstdlib>

#include "paper/stereo_errors.h"
#include "paper_cell.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

using leberl::Signs;
using leberl::StereoConfiguration;
using paper::Cell;
using paper::Quantity;
using paper::RoundsTo;
using paper::Source;

struct PrintedRow {
  Quantity quantity;
  bool is_relative;
  double dy_km;
  double dz_km;
  // aircraft near, aircraft far, VOIR near, VOIR far; in each dy0'' or dB, dz0'' or dH, dr''
  std::array<std::array<const char*, 3>, 4> cells;
};

// Table 1 as the copy prints it, metres; "?" marks a cell that is badly legible. Data, not results.
constexpr std::array<PrintedRow, 6> kPrinted = {{
    {Quantity::kAcross,
     false,
     0.0,
     0.0,
     {{{"-63", "12.5", "-20.5"},
       {"-213", "12.5", "-24.7"},
       {"-8130", "938", "-1240"},
       {"-9630", "938", "-1344"}}}},
    {Quantity::kUp,
     false,
     0.0,
     0.0,
     {{{"81", "16.3", "-26.7"},
       {"531", "31.3", "-61.6"},
       {"-7910", "813", "-1075"},
       {"-10910", "1063", "-1523"}}}},
    {Quantity::kAcross,
     true,
     0.0,
     1.0,
     {{{"0", "1.2", "-0.4"}, {"0", "1.2", "-0.2"}, {"0", "2.5", "0"}, {"0", "2.5", "0"}}}},
    {Quantity::kAcross,
     true,
     1.0,
     1.0,
     {{{"-12.5", "1.2", "0"}, {"-12.5", "1.2", "0"}, {"-25", "2.5", "0"}, {"-2.5 ?", "2.5", "0"}}}},
    {Quantity::kUp,
     true,
     0.0,
     1.0,
     {{{"8.1", "0", "-0.3"}, {"53.1", "0", "-0.3"}, {"21", "0", "0"}, {"29", "0", "0"}}}},
    {Quantity::kUp,
     true,
     1.0,
     1.0,
     {{{"-14.4", "1.2", "0.1"},
       {"9.0 ?", "1.2", "-0.2"},
       {"-25", "2.5", "0"},
       {"-25", "5.5 ?", "0"}}}},
}};

constexpr std::array<const char*, 2> kConfigurations = {"aircraft", "voir"};
constexpr std::array<const char*, 2> kPositions = {"near", "far"};
constexpr std::array<Source, 3> kSources = {
    Source::kAcrossPosition, Source::kUpPosition, Source::kRange};
// Sizes of the three errors: aircraft 100, 10, 10 m; VOIR 1000, 100, 100 m.
constexpr std::array<std::array<double, 3>, 2> kSizes_m = {
    {{100.0, 10.0, 10.0}, {1000.0, 100.0, 100.0}}};

const char* SourceName(Source source, bool is_relative) {
  switch (source) {
    case Source::kAcrossPosition:
      return is_relative ? "dB" : "dy0''";
    case Source::kUpPosition:
      return is_relative ? "dH" : "dz0''";
    case Source::kRange:
      break;
  }
  return "dr''";
}

double PointErrorOf(const Cell& cell, const leberl::PointError& error) {
  return cell.quantity == Quantity::kAcross ? error.dy_m : error.dz_m;
}

double RigorousDerivative(const Cell& cell) {
  return PointErrorOf(cell,
                      cell.is_relative ? DifferenceErrorDerivative(
                                             cell.configuration, ErrorsOf(cell), cell.difference)
                                       : StereoErrorDerivative(cell.configuration, ErrorsOf(cell)));
}

double RigorousExact(const Cell& cell) {
  const auto exact = cell.is_relative
                         ? DifferenceErrorExact(cell.configuration, ErrorsOf(cell), cell.difference)
                         : StereoErrorExact(cell.configuration, ErrorsOf(cell));
  return PointErrorOf(cell, exact.value());  // the paper's errors are far from parting the circles
}

/// 1e-9 relative; a zero against the size of the error that it is the effect of.
bool SameFirstOrder(const Cell& cell, double formula_m, double derivative_m) {
  return std::abs(formula_m - derivative_m) <=
         1e-9 * std::abs(formula_m) + 1e-15 * std::abs(cell.size_m);
}

std::string TruncationNote(double derivative_m, double exact_m) {
  const double truncated_m = exact_m - derivative_m;
  if (truncated_m == 0.0) return "first order leaves out nothing";
  if (derivative_m == 0.0) return fmt::format("first order leaves out {:.3g} m", truncated_m);
  return fmt::format("first order leaves out {:.3g} m ({:.2g} % of it)",
                     truncated_m,
                     100.0 * std::abs(truncated_m / derivative_m));
}

/// Whether two numbers of equal length differ in a single digit; "?" and blanks are ignored.
bool OneDigitApart(std::string_view a, std::string_view printed) {
  const std::string_view b = printed.substr(0, printed.find(' '));
  if (a.size() != b.size()) return false;
  int apart = 0;
  for (std::size_t i = 0; i < a.size(); ++i) apart += a[i] != b[i] ? 1 : 0;
  return apart == 1;
}

/// Which substitutions reproduce the printed digits, at most three of them.
std::string Reproductions(const Cell& cell, const std::string& printed) {
  const auto list = Substitutions(cell, printed);
  std::string text;
  int found = 0;
  const paper::Substitution* nearest = nullptr;
  const double number = std::strtod(printed.c_str(), nullptr);
  for (const auto& s : list) {
    if (nearest == nullptr || std::abs(s.value_m - number) < std::abs(nearest->value_m - number)) {
      nearest = &s;
    }
    if (!RoundsTo(s.value_m, printed) || found == 3) continue;
    text += fmt::format("{}{} gives {:.4g}", found++ == 0 ? "" : "; ", s.what, s.value_m);
  }
  if (found > 0) return text;
  const double formula_m = Formula(cell, Signs::kPrinted);
  const int decimals = paper::RoundingUnit(printed) < 1.0 ? 1 : 0;
  if (OneDigitApart(fmt::format("{:.{}f}", formula_m, decimals), printed)) {
    return "one misread digit explains the printed number";
  }
  return fmt::format(
      "none of {} substitutions tried gives the printed digits; nearest: {} with {:.4g}",
      list.size(),
      nearest->what,
      nearest->value_m);
}

std::string SignNote(const Cell& cell, double formula_m, double derivative_m) {
  return fmt::format(
      "{} as printed gives {:.4g} but the geometry {:.4g}: its Dz term has the wrong sign (H at a "
      "point of height Dz is H - Dz)",
      EquationOf(cell),
      formula_m,
      derivative_m);
}

void Judge(const Cell& cell, Table1Cell* out) {
  const std::string& printed = out->printed_text;
  const bool illegible = printed.find('?') != std::string::npos;
  const bool follows = RoundsTo(out->formula_m, printed);
  const bool same = SameFirstOrder(cell, out->formula_m, out->derivative_m);
  if (!illegible) out->printed_m = std::strtod(printed.c_str(), nullptr);
  if (follows && same && !illegible) {
    out->verdict =
        RoundsTo(out->exact_m, printed) ? PaperVerdict::kAgrees : PaperVerdict::kTruncation;
    out->note = TruncationNote(out->derivative_m, out->exact_m);
    return;
  }
  out->verdict = illegible ? PaperVerdict::kIllegible : PaperVerdict::kSlip;
  if (illegible) {
    out->note = fmt::format("the copy seems to read {}; ", printed.substr(0, printed.find(' ')));
  }
  if (!follows) {
    out->note += fmt::format(
        "{} gives {:.4g}; {}", EquationOf(cell), out->formula_m, Reproductions(cell, printed));
  } else if (illegible) {
    out->note += fmt::format("{} gives the same digits", EquationOf(cell));
  } else {
    out->note += fmt::format("printed digits follow {}", EquationOf(cell));
  }
  if (!same) out->note += "; " + SignNote(cell, out->formula_m, out->derivative_m);
}

}  // namespace

const char* NameOf(PaperVerdict verdict) {
  switch (verdict) {
    case PaperVerdict::kAgrees:
      return "agrees";
    case PaperVerdict::kTruncation:
      return "truncation";
    case PaperVerdict::kSlip:
      return "slip";
    case PaperVerdict::kIllegible:
      break;
  }
  return "illegible";
}

StereoConfiguration PaperConfiguration(std::string_view configuration, std::string_view position) {
  const bool aircraft = configuration == "aircraft";
  if (!aircraft && configuration != "voir") {
    throw InputError("configuration",
                     "'" + std::string(configuration) + "' is neither aircraft nor voir");
  }
  const double near_m = aircraft ? 13e3 : 365e3;
  const double far_m = aircraft ? 25e3 : 425e3;
  StereoConfiguration c{.base_m = aircraft ? 8e3 : 40e3, .height_m = aircraft ? 10e3 : 375e3};
  if (position == "near") {
    c.ground_range_m = near_m;
  } else if (position == "far") {
    c.ground_range_m = far_m;
  } else if (position == "centre") {
    c.ground_range_m = 0.5 * (near_m + far_m);
  } else {
    throw InputError("position", "'" + std::string(position) + "' is neither near, far nor centre");
  }
  return c;
}

std::vector<Table1Cell> PaperTable1() {
  std::vector<Table1Cell> cells;
  for (const PrintedRow& row : kPrinted) {
    for (std::size_t column = 0; column < 4; ++column) {
      const std::size_t which = column / 2, where = column % 2;
      for (std::size_t k = 0; k < 3; ++k) {
        Cell cell{
            .configuration = PaperConfiguration(kConfigurations[which], kPositions[where]),
            .other_position = PaperConfiguration(kConfigurations[which], kPositions[1 - where]),
            .quantity = row.quantity,
            .source = kSources[k],
            .size_m = kSizes_m[which][k],
            .is_relative = row.is_relative,
            .difference = {.dy_m = 1e3 * row.dy_km, .dz_m = 1e3 * row.dz_km},
        };
        Table1Cell out;
        out.configuration = kConfigurations[which];
        out.position = kPositions[where];
        out.quantity = row.quantity == Quantity::kAcross ? "dy" : "dz";
        if (row.is_relative) {
          out.quantity = "d" + out.quantity;
          out.dy_km = row.dy_km;
          out.dz_km = row.dz_km;
        }
        out.source = SourceName(cell.source, row.is_relative);
        out.size_m = cell.size_m;
        out.printed_text = row.cells[column][k];
        out.formula_m = Formula(cell, Signs::kPrinted) + 0.0;  // no -0 in a table
        out.derivative_m = RigorousDerivative(cell);
        out.exact_m = RigorousExact(cell);
        Judge(cell, &out);
        cells.push_back(std::move(out));
      }
    }
  }
  return cells;
}

}  // namespace sarblock
