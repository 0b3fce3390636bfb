// SPDX-License-Identifier: Apache-2.0
#include "table1.h"

#include "sarblock/core/error.h"
#include "sarblock/leberl/formulas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>

#include "rigorous.h"
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

/// Added to a substitution whose digits are cut: the same mistake.
constexpr const char* kDigitsCut = ", digits cut instead of rounded";

std::string WrongSignOf(const char* equation) {
  return fmt::format("wrong sign of the Dz term in {}", equation);
}

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

/// Which substitutions reproduce the printed digits, at most three of them; all go to `causes`.
std::string Reproductions(const Cell& cell,
                          const std::string& printed,
                          std::vector<std::string>* causes) {
  const auto list = Substitutions(cell, printed);
  std::string text;
  int found = 0;
  const paper::Substitution* nearest = nullptr;
  const double number = std::strtod(printed.c_str(), nullptr);
  for (const auto& s : list) {
    if (nearest == nullptr || std::abs(s.value_m - number) < std::abs(nearest->value_m - number)) {
      nearest = &s;
    }
    if (!RoundsTo(s.value_m, printed)) continue;
    causes->push_back(s.what.substr(0, s.what.find(kDigitsCut)));
    if (found == 3) continue;
    text += fmt::format("{}{} gives {:.4g}", found++ == 0 ? "" : "; ", s.what, s.value_m);
  }
  if (found > 0) return text;
  const double formula_m = Formula(cell, Signs::kPrinted);
  causes->emplace_back("not explained");
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

/// Judges a cell. `causes` gets what may explain a slip, nothing for other verdicts.
void Judge(const Cell& cell, Table1Cell* out, std::vector<std::string>* causes) {
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
    out->note += fmt::format("{} gives {:.4g}; {}",
                             EquationOf(cell),
                             out->formula_m,
                             Reproductions(cell, printed, causes));
  } else if (illegible) {
    out->note += fmt::format("{} gives the same digits", EquationOf(cell));
  } else {
    out->note += fmt::format("printed digits follow {}", EquationOf(cell));
    causes->push_back(WrongSignOf(EquationOf(cell)));
  }
  if (!same) out->note += "; " + SignNote(cell, out->formula_m, out->derivative_m);
  if (illegible) causes->clear();
}

/// Gives each slip the cause that explains most of the slips which are left without one.
void AssignCauses(std::vector<std::vector<std::string>> causes, std::vector<Table1Cell>* cells) {
  while (true) {
    std::map<std::string, int> explained;
    for (const auto& of_cell : causes) {
      for (const std::string& cause : std::set<std::string>(of_cell.begin(), of_cell.end())) {
        ++explained[cause];
      }
    }
    const auto most =
        std::max_element(explained.begin(), explained.end(), [](const auto& a, const auto& b) {
          return a.second < b.second;
        });
    if (most == explained.end()) return;
    for (std::size_t i = 0; i < causes.size(); ++i) {
      if (std::find(causes[i].begin(), causes[i].end(), most->first) == causes[i].end()) continue;
      (*cells)[i].cause = most->first;
      causes[i].clear();
    }
  }
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
  std::vector<std::vector<std::string>> causes;
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
        Judge(cell, &out, &causes.emplace_back());
        cells.push_back(std::move(out));
      }
    }
  }
  AssignCauses(std::move(causes), &cells);
  return cells;
}

std::vector<SlipCause> CountCauses(const std::vector<std::string>& causes) {
  std::vector<SlipCause> counts;
  for (const std::string& cause : causes) {
    if (cause.empty()) continue;
    const auto known = std::find_if(
        counts.begin(), counts.end(), [&](const SlipCause& c) { return c.cause == cause; });
    if (known == counts.end()) {
      counts.push_back({cause, 1});
    } else {
      ++known->count;
    }
  }
  std::stable_sort(counts.begin(), counts.end(), [](const SlipCause& a, const SlipCause& b) {
    return a.count > b.count;
  });
  return counts;
}

}  // namespace sarblock

namespace sarblock::paper {
namespace {

using leberl::Difference;
using leberl::Signs;
using leberl::StereoConfiguration;

double Pick(const Cell& cell, const Difference& value) {
  return cell.quantity == Quantity::kAcross ? value.dy_m : value.dz_m;
}

double AbsoluteFormula(const Cell& cell, const leberl::StereoErrors& errors) {
  return cell.quantity == Quantity::kAcross ? AcrossError(cell.configuration, errors)
                                            : HeightError(cell.configuration, errors);
}

/// Eq. 24 with printed signs and given slant ranges, for rounded intermediates.
Difference WarpWithRanges(const Cell& cell, double error_m, double first_m, double second_m) {
  const StereoConfiguration& c = cell.configuration;
  const double base_m = c.base_m, height_m = c.height_m, y_m = c.ground_range_m;
  const double back_m = y_m - base_m, height2_m2 = height_m * height_m;
  const leberl::Warp warp{
      .a = y_m / first_m - back_m / second_m,
      .f = height_m / first_m - height_m / second_m,
      .c = (first_m - second_m) / height_m + y_m * back_m / height_m * (1 / first_m - 1 / second_m),
      .d = back_m / first_m - back_m * first_m / height2_m2 - y_m / second_m +
           y_m * second_m / height2_m2,
  };
  const Difference of = warp.Apply(cell.difference);
  return {of.dy_m * error_m / base_m, of.dz_m * error_m / base_m};
}

void AddAbsolute(const Cell& cell, double formula_m, std::vector<Substitution>* list) {
  const StereoConfiguration& c = cell.configuration;
  const leberl::StereoErrors errors = ErrorsOf(cell);
  const leberl::StereoErrors first{.first = errors.second, .second = {}};
  const double y_m = c.ground_range_m, back_m = y_m - c.base_m;
  const double first_m = FirstSlantRange(c), second_m = SecondSlantRange(c);
  const double of_first_m = AbsoluteFormula(cell, first);
  if (cell.source == Source::kRange) {
    list->push_back({"r' in place of r''", formula_m * first_m / second_m});
  }
  list->push_back({"y - B in place of y", formula_m * back_m / y_m});
  list->push_back({"the opposite sign", -formula_m});
  list->push_back({"the error at station ' instead of ''", of_first_m});
  list->push_back({"the error at station ' with the opposite sign", -of_first_m});
  list->push_back({"y in place of y - B", formula_m * y_m / back_m});
  list->push_back({"the same error at both stations", of_first_m + formula_m});
  if (cell.source == Source::kRange) {
    list->push_back(
        {"a ground range error instead of a slant range error", formula_m * back_m / second_m});
  }
  Cell turned = cell;
  turned.configuration.height_m = std::abs(y_m);
  turned.configuration.ground_range_m = c.height_m;
  list->push_back({"y and H interchanged (sine for cosine)", AbsoluteFormula(turned, errors)});
}

void AddRelativeRange(const Cell& cell, std::vector<Substitution>* list) {
  const StereoConfiguration& c = cell.configuration;
  const double e_m = cell.size_m;
  const auto warp = [&](double first_m, double second_m, Signs signs) {
    return Pick(cell, RangeWarp(c, first_m, second_m, signs).Apply(cell.difference));
  };
  const auto rounded_km = [](double range_m) { return 1e3 * std::round(range_m / 1e3); };
  list->push_back(
      {"the same range error in both images (dr' = dr'')", warp(e_m, e_m, Signs::kPrinted)});
  list->push_back(
      {"dr' = dr'' with the derived signs of F and D", warp(e_m, e_m, Signs::kDerived)});
  list->push_back(
      {"dr' = dr'' and slant ranges rounded to whole kilometres",
       Pick(cell,
            WarpWithRanges(
                cell, e_m, rounded_km(FirstSlantRange(c)), rounded_km(SecondSlantRange(c))))});
  list->push_back({"dr' instead of dr''", warp(e_m, 0.0, Signs::kPrinted)});
  list->push_back({"dr' = -dr''", warp(-e_m, e_m, Signs::kPrinted)});
  const leberl::StationErrors one{.dr_m = e_m};
  const auto exact = DifferenceErrorExact(c, {.first = one, .second = one}, cell.difference);
  if (exact) {
    list->push_back({"dr' = dr'' in the exact intersection",
                     cell.quantity == Quantity::kAcross ? exact->dy_m : exact->dz_m});
  }
}

void AddRelative(const Cell& cell, double formula_m, std::vector<Substitution>* list) {
  if (cell.source == Source::kRange) AddRelativeRange(cell, list);
  list->push_back({"the derived signs", Formula(cell, Signs::kDerived)});
  list->push_back({"the opposite sign", -formula_m});
  Cell part = cell;
  part.difference.dz_m = 0.0;
  list->push_back({"the Dy term alone", Formula(part, Signs::kPrinted)});
  part.difference = {.dy_m = 0.0, .dz_m = cell.difference.dz_m};
  list->push_back({"the Dz term alone", Formula(part, Signs::kPrinted)});
  Cell swapped = cell;
  swapped.quantity = cell.quantity == Quantity::kAcross ? Quantity::kUp : Quantity::kAcross;
  list->push_back({"the equation of the other coordinate", Formula(swapped, Signs::kPrinted)});
  if (cell.source == Source::kAcrossPosition) {
    swapped = cell;
    swapped.source = Source::kUpPosition;
    list->push_back({"Eq. 22-23 instead of Eq. 18-19", Formula(swapped, Signs::kPrinted)});
  } else if (cell.source == Source::kUpPosition) {
    swapped = cell;
    swapped.source = Source::kAcrossPosition;
    list->push_back({"Eq. 18-19 instead of Eq. 22-23", Formula(swapped, Signs::kPrinted)});
  }
}

/// "0.6" for "9.0": the printed text read upside down; NaN where a digit has no such reading.
double UpsideDown(double value, double unit) {
  const int decimals = unit < 1.0 ? 1 : 0;
  std::string text = std::to_string(std::abs(value));
  text.resize(text.find('.') + (decimals > 0 ? 2 : 0));
  std::reverse(text.begin(), text.end());
  for (char& digit : text) {
    if (digit == '6') {
      digit = '9';
    } else if (digit == '9') {
      digit = '6';
    } else if (digit != '0' && digit != '8' && digit != '.') {
      return std::nan("");
    }
  }
  return std::strtod(text.c_str(), nullptr);
}

}  // namespace

leberl::StereoErrors ErrorsOf(const Cell& cell) {
  leberl::StereoErrors errors;
  switch (cell.source) {
    case Source::kAcrossPosition:
      errors.second.dy0_m = cell.size_m;
      break;
    case Source::kUpPosition:
      errors.second.dz0_m = cell.size_m;
      break;
    case Source::kRange:
      errors.second.dr_m = cell.size_m;
      break;
  }
  return errors;
}

double Formula(const Cell& cell, Signs signs) {
  if (!cell.is_relative) return AbsoluteFormula(cell, ErrorsOf(cell));
  const StereoConfiguration& c = cell.configuration;
  switch (cell.source) {
    case Source::kAcrossPosition:
      return Pick(cell, DifferenceErrorOfBase(c, cell.difference, cell.size_m, signs));
    case Source::kUpPosition:
      return Pick(cell, DifferenceErrorOfHeight(c, cell.difference, cell.size_m, signs));
    case Source::kRange:
      break;
  }
  return Pick(cell, RangeWarp(c, 0.0, cell.size_m, signs).Apply(cell.difference));
}

const char* EquationOf(const Cell& cell) {
  const bool across = cell.quantity == Quantity::kAcross;
  if (!cell.is_relative) return across ? "Eq. 14" : "Eq. 15";
  switch (cell.source) {
    case Source::kAcrossPosition:
      return across ? "Eq. 18" : "Eq. 19";
    case Source::kUpPosition:
      return across ? "Eq. 22" : "Eq. 23";
    case Source::kRange:
      break;
  }
  return "Eq. 24";
}

double RoundingUnit(std::string_view printed) {
  const std::size_t end = printed.find_last_of("0123456789");
  const std::string_view number = printed.substr(0, end + 1);
  const std::size_t point = number.find('.');
  if (point != std::string_view::npos) {
    return std::pow(10.0, -static_cast<double>(number.size() - point - 1));
  }
  double unit = 1.0;
  for (std::size_t i = number.size(); i-- > 1 && number[i] == '0' && number[i - 1] != '-';) {
    unit *= 10.0;
  }
  return unit;
}

bool RoundsTo(double value, std::string_view printed) {
  const double number = std::strtod(std::string(printed).c_str(), nullptr);
  constexpr double kTie = 1e-9;  // a tie computed in double may fall on either side
  return std::abs(value - number) <= RoundingUnit(printed) * (0.5 + kTie);
}

std::vector<Substitution> Substitutions(const Cell& cell, std::string_view printed) {
  const double formula_m = Formula(cell, Signs::kPrinted);
  std::vector<Substitution> list;
  if (cell.is_relative) {
    AddRelative(cell, formula_m, &list);
  } else {
    AddAbsolute(cell, formula_m, &list);
  }
  Cell other = cell;
  other.configuration = cell.other_position;
  list.push_back({"the geometry of the other position", Formula(other, Signs::kPrinted)});
  const double unit = RoundingUnit(printed);
  const std::vector<Substitution> plain = list;
  for (const Substitution& s : plain) {
    if (s.what.find("dr' = dr''") == std::string::npos) continue;
    list.push_back({s.what + kDigitsCut, std::trunc(s.value_m / unit) * unit});
  }
  if (printed.find('?') != std::string_view::npos) {
    list.push_back({"a decimal point read into the number", formula_m / 10.0});
    const double turned = UpsideDown(std::round(formula_m / unit) * unit, unit);
    if (std::isfinite(turned)) list.push_back({"the rounded formula read upside down", turned});
  }
  return list;
}

}  // namespace sarblock::paper

namespace sarblock {
namespace {

using leberl::Signs;
using leberl::StereoConfiguration;

constexpr double kBaseError_m = 100.0;
constexpr leberl::Difference kOneKilometre{.dy_m = 1e3, .dz_m = 1e3};

QuotedExample Named(std::string name, std::string unit, std::string printed) {
  QuotedExample example;
  example.name = std::move(name);
  example.unit = std::move(unit);
  example.printed = std::strtod(printed.c_str(), nullptr);
  example.printed_text = std::move(printed);
  return example;
}

/// Verdict of an example with a first order and an exact value, by the rules of Table 1.
void JudgeError(const char* equation, QuotedExample* e) {
  const double derivative = e->derivative.value(), exact = e->exact.value();
  const bool same = std::abs(e->formula - derivative) <= 1e-9 * std::abs(e->formula);
  if (paper::RoundsTo(e->formula, e->printed_text) && same) {
    e->verdict =
        paper::RoundsTo(exact, e->printed_text) ? PaperVerdict::kAgrees : PaperVerdict::kTruncation;
    e->note = fmt::format("first order leaves out {:.3g} m", exact - derivative);
    return;
  }
  e->verdict = PaperVerdict::kSlip;
  if (paper::RoundsTo(e->formula, e->printed_text)) {
    e->note = fmt::format(
        "printed digits follow {}; its Dz term has the wrong sign: {:.4g} by the geometry",
        equation,
        derivative);
    e->cause = WrongSignOf(equation);
  } else if (paper::RoundsTo(-e->formula, e->printed_text)) {
    e->note = fmt::format(
        "the opposite sign of {} reproduces the digits: a magnitude, or dB = dy0' - dy0''",
        equation);
    e->cause = "the opposite sign";
  } else {
    e->note = fmt::format("{} does not give the printed digits", equation);
    e->cause = "not explained";
  }
}

void AddBaseErrors(const char* name,
                   const char* dz,
                   const char* dy,
                   const char* ddz,
                   std::vector<QuotedExample>* list) {
  const StereoConfiguration c = PaperConfiguration(name, "centre");
  const leberl::StereoErrors errors{.second = {.dy0_m = kBaseError_m}};
  const auto derivative = StereoErrorDerivative(c, errors);
  const auto exact = StereoErrorExact(c, errors);
  const auto exact_difference = DifferenceErrorExact(c, errors, kOneKilometre);
  const std::string where = fmt::format("{} centre, dB = 100 m: ", name);

  QuotedExample height = Named(where + "dz", "m", dz);
  height.formula = HeightErrorOfBase(c, kBaseError_m);
  height.derivative = derivative.dz_m;
  height.exact = exact.value().dz_m;
  JudgeError("Eq. 17", &height);
  list->push_back(height);
  if (dy != nullptr) {  // Eq. 16 leaves out its constant, the shift dy0'' itself
    QuotedExample across = Named(where + "dy", "m", dy);
    across.formula = AcrossErrorOfBase(c, kBaseError_m);
    across.derivative = derivative.dy_m - kBaseError_m;
    across.exact = exact.value().dy_m - kBaseError_m;
    JudgeError("Eq. 16", &across);
    list->push_back(across);
  }
  QuotedExample difference = Named(where + "d(Dz) for Dy = Dz = 1 km", "m", ddz);
  difference.formula = DifferenceErrorOfBase(c, kOneKilometre, kBaseError_m, Signs::kPrinted).dz_m;
  difference.derivative = DifferenceErrorDerivative(c, errors, kOneKilometre).dz_m;
  difference.exact = exact_difference.value().dz_m;
  JudgeError("Eq. 19", &difference);
  list->push_back(difference);
}

void AddNoise(std::vector<QuotedExample>* list) {
  const StereoConfiguration c = PaperConfiguration("voir", "centre");
  const leberl::RangeNoise formula = leberl::NoiseOfRange(c, 100.0);
  const leberl::RangeNoise rigorous = StereoRangeNoise(c, 100.0);
  const auto add = [&](const char* name, double formula_m, double rigorous_m) {
    QuotedExample e = Named(fmt::format("voir centre, sigma_r = 100 m: {}", name), "m", "1900");
    e.formula = formula_m;
    e.derivative = rigorous_m;
    e.verdict =
        paper::RoundsTo(formula_m, e.printed_text) ? PaperVerdict::kAgrees : PaperVerdict::kSlip;
    e.note = "the rigorous value is the covariance of the intersection";
    list->push_back(e);
  };
  add("sigma_y", formula.sigma_y_m, rigorous.sigma_y_m);
  add("sigma_z", formula.sigma_z_m, rigorous.sigma_z_m);
}

constexpr const char* kNearEdge = "true at the near edge only";

void AddPlain(const std::string& name,
              const char* unit,
              const char* printed,
              double formula,
              const std::string& note,
              const char* cause_of_slip,
              std::vector<QuotedExample>* list) {
  QuotedExample e = Named(name, unit, printed);
  e.formula = formula;
  const bool agrees = paper::RoundsTo(formula, printed);
  e.verdict = agrees ? PaperVerdict::kAgrees : PaperVerdict::kSlip;
  e.note = note;
  if (!agrees) e.cause = cause_of_slip;
  list->push_back(e);
}

/// Mean look angle at which Eq. 10 gives q for an intersection angle d, same-side:
/// 5 sin d / (sin(m + d/2) sin(m - d/2)) = q with the mean m.
double MeanLook(double intersection_rad, double q) {
  const double cos_double = std::cos(intersection_rad) - 10.0 * std::sin(intersection_rad) / q;
  return 0.5 * std::acos(cos_double);
}

void AddExaggerations(std::vector<QuotedExample>* list) {
  const StereoConfiguration aircraft = PaperConfiguration("aircraft", "centre");
  for (const auto& [intersection_deg, printed] : {std::pair{15.0, "2.3"}, std::pair{12.0, "1.8"}}) {
    // in the aircraft geometry y (y - B) = H B / tan(dtheta) - H^2
    const double intersection_rad = intersection_deg * kRadPerDeg;
    const double hb_m2 = aircraft.height_m * aircraft.base_m;
    StereoConfiguration c = aircraft;
    const double product_m2 =
        hb_m2 / std::tan(intersection_rad) - aircraft.height_m * aircraft.height_m;
    c.ground_range_m =
        0.5 * aircraft.base_m + std::sqrt(0.25 * aircraft.base_m * aircraft.base_m + product_m2);
    const double q = std::strtod(printed, nullptr);
    AddPlain(fmt::format("aircraft, exaggeration at dtheta = {:.0f} deg", intersection_deg),
             "1",
             printed,
             leberl::Exaggeration(c),
             fmt::format("Table 1's aircraft has this dtheta at y = {:.2f} km; Eq. 10 gives the "
                         "printed value at a mean look angle of {:.1f} deg",
                         1e-3 * c.ground_range_m,
                         MeanLook(intersection_rad, q) * kDegPerRad),
             "looks of another pair than Table 1's",
             list);
  }
  for (const char* position : {"near", "far"}) {
    const StereoConfiguration c = PaperConfiguration("voir", position);
    const std::string where = fmt::format("voir {}, ", position);
    AddPlain(
        where + "exaggeration", "1", "0.6", leberl::Exaggeration(c), "Eq. 11", kNearEdge, list);
    AddPlain(where + "dtheta",
             "deg",
             position == std::string_view("near") ? "3.3" : "2.8",
             IntersectionAngle(c) * kDegPerRad,
             "theta' - theta''",
             kNearEdge,
             list);
  }
  // 23 cm format, 60 percent forward overlap, 152 mm lens: Bc/H = 0.4 * 230/152
  AddPlain("aerial photography, exaggeration",
           "1",
           "3",
           leberl::CameraExaggeration(0.4 * 230.0, 152.0),
           "Eq. 9 with 23 cm format, 60 percent overlap, 152 mm lens (not stated in the paper)",
           "another camera",
           list);
}

/// The guidance names intervals: agrees where the aircraft's model centre keeps to it.
void AddGuidance(std::vector<QuotedExample>* list) {
  const leberl::ViewingGuidance centre = CheckViewing(PaperConfiguration("aircraft", "centre"));
  const leberl::ViewingGuidance voir = CheckViewing(PaperConfiguration("voir", "centre"));
  const auto add = [&](const char* name,
                       const char* printed,
                       double value_rad,
                       bool kept,
                       double voir_rad,
                       bool voir_kept) {
    QuotedExample e = Named(name, "deg", printed);
    e.formula = value_rad * kDegPerRad;
    e.verdict = kept ? PaperVerdict::kAgrees : PaperVerdict::kSlip;
    e.note = fmt::format("aircraft centre {}; voir centre with {:.1f} deg {}",
                         kept ? "keeps to it" : "does not keep to it",
                         voir_rad * kDegPerRad,
                         voir_kept ? "keeps to it" : "does not keep to it");
    list->push_back(e);
  };
  add("viewing guidance, look angles (smaller one)",
      "37 to 67",
      centre.second_look_rad,
      centre.looks_within_37_and_67_deg,
      voir.second_look_rad,
      voir.looks_within_37_and_67_deg);
  add("viewing guidance, look angles not below",
      "40",
      centre.second_look_rad,
      centre.looks_not_below_40_deg,
      voir.second_look_rad,
      voir.looks_not_below_40_deg);
  add("viewing guidance, dtheta",
      "12 to 15",
      centre.intersection_rad,
      centre.intersection_within_12_and_15_deg,
      voir.intersection_rad,
      voir.intersection_within_12_and_15_deg);
}

/// Statements of the text on its numbers, compared with Table 1's own geometry.
void AddComparisons(std::vector<QuotedExample>* list) {
  // An error of station '' moves the point along the circle of station ', whose slope is y/H.
  for (const char* name : {"aircraft", "voir"}) {
    const StereoConfiguration c = PaperConfiguration(name, "near");
    const leberl::StereoErrors errors{.second = {.dy0_m = kBaseError_m}};
    QuotedExample e = Named(fmt::format("{} near, dz/dy by an error of ''", name), "1", "< 1");
    e.printed = 1.0;
    e.formula = HeightError(c, errors) / AcrossError(c, errors);
    const leberl::PointError derivative = StereoErrorDerivative(c, errors);
    e.derivative = derivative.dz_m / derivative.dy_m;
    e.verdict = e.formula < 1.0 ? PaperVerdict::kAgrees : PaperVerdict::kSlip;
    e.note = fmt::format("dz/dy = y/H: smaller than 1 below a look angle of 45 deg, here {:.1f}",
                         FirstLookAngle(c) * kDegPerRad);
    if (e.verdict == PaperVerdict::kSlip) e.cause = "true of VOIR only";
    list->push_back(e);
  }
  for (const char* position : {"near", "centre", "far"}) {
    const StereoConfiguration aircraft = PaperConfiguration("aircraft", position);
    const StereoConfiguration voir = PaperConfiguration("voir", position);
    AddPlain(fmt::format("dz by dB, voir over aircraft, {}", position),
             "1",
             "10",
             HeightErrorOfBase(voir, kBaseError_m) / HeightErrorOfBase(aircraft, kBaseError_m),
             "Eq. 17 with the same dB",
             kNearEdge,
             list);
  }
}

}  // namespace

std::vector<QuotedExample> PaperExamples() {
  std::vector<QuotedExample> list;
  AddBaseErrors("aircraft", "261", "237", "-11", &list);
  AddBaseErrors("voir", "935", nullptr, "-2.5", &list);
  AddNoise(&list);
  AddExaggerations(&list);
  AddGuidance(&list);
  AddComparisons(&list);
  return list;
}

}  // namespace sarblock
