// SPDX-License-Identifier: Apache-2.0
#include "paper_cell.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "paper/stereo_errors.h"

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
      .a_1 = y_m / first_m - back_m / second_m,
      .f_1 = height_m / first_m - height_m / second_m,
      .c_1 =
          (first_m - second_m) / height_m + y_m * back_m / height_m * (1 / first_m - 1 / second_m),
      .d_1 = back_m / first_m - back_m * first_m / height2_m2 - y_m / second_m +
             y_m * second_m / height2_m2,
  };
  const Difference of = warp.Of(cell.difference);
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
    return Pick(cell, RangeWarp(c, first_m, second_m, signs).Of(cell.difference));
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
  return Pick(cell, RangeWarp(c, 0.0, cell.size_m, signs).Of(cell.difference));
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
    list.push_back(
        {s.what + ", digits cut instead of rounded", std::trunc(s.value_m / unit) * unit});
  }
  if (printed.find('?') != std::string_view::npos) {
    list.push_back({"a decimal point read into the number", formula_m / 10.0});
    const double turned = UpsideDown(std::round(formula_m / unit) * unit, unit);
    if (std::isfinite(turned)) list.push_back({"the rounded formula read upside down", turned});
  }
  return list;
}

}  // namespace sarblock::paper
