// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/leberl/parallax.h"

#include <cmath>
#include <cstdlib>

#include "paper/paper_table.h"
#include "paper/stereo_errors.h"
#include "paper_cell.h"
#include <fmt/core.h>

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
  } else if (paper::RoundsTo(-e->formula, e->printed_text)) {
    e->note = fmt::format(
        "the opposite sign of {} reproduces the digits: a magnitude, or dB = dy0' - dy0''",
        equation);
  } else {
    e->note = fmt::format("{} does not give the printed digits", equation);
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

void AddPlain(const std::string& name,
              const char* unit,
              const char* printed,
              double formula,
              const std::string& note,
              std::vector<QuotedExample>* list) {
  QuotedExample e = Named(name, unit, printed);
  e.formula = formula;
  e.verdict = paper::RoundsTo(formula, printed) ? PaperVerdict::kAgrees : PaperVerdict::kSlip;
  e.note = note;
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
             list);
  }
  for (const char* position : {"near", "far"}) {
    const StereoConfiguration c = PaperConfiguration("voir", position);
    const std::string where = fmt::format("voir {}, ", position);
    AddPlain(where + "exaggeration", "1", "0.6", leberl::Exaggeration(c), "Eq. 11", list);
    AddPlain(where + "dtheta",
             "deg",
             position == std::string_view("near") ? "3.3" : "2.8",
             IntersectionAngle(c) * kDegPerRad,
             "theta' - theta''",
             list);
  }
  // 23 cm format, 60 percent forward overlap, 152 mm lens: Bc/H = 0.4 * 230/152
  AddPlain("aerial photography, exaggeration",
           "1",
           "3",
           leberl::CameraExaggeration(0.4 * 230.0, 152.0),
           "Eq. 9 with 23 cm format, 60 percent overlap, 152 mm lens (not stated in the paper)",
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

}  // namespace

std::vector<QuotedExample> PaperExamples() {
  std::vector<QuotedExample> list;
  AddBaseErrors("aircraft", "261", "237", "-11", &list);
  AddBaseErrors("voir", "935", nullptr, "-2.5", &list);
  AddNoise(&list);
  AddExaggerations(&list);
  AddGuidance(&list);
  return list;
}

}  // namespace sarblock
