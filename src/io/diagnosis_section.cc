// SPDX-License-Identifier: Apache-2.0
#include "diagnosis_section.h"

#include <cmath>

namespace sarblock {
namespace {

using Json = nlohmann::ordered_json;

/// null where there is no number.
Json Number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

}  // namespace

Json DiagnosisSection(const Diagnosis& diagnosis) {
  Json section = Json::array();
  for (const Explanation& told : diagnosis.explanations) {
    section.push_back({{"kind", NameOf(told.kind)},
                       {"cause", told.cause},
                       {"sentence", told.sentence},
                       {"passes", told.passes},
                       {"points", told.points},
                       {"value", Number(told.value)},
                       {"sigma", Number(told.sigma)},
                       {"unit", told.unit},
                       {"equals", told.equals},
                       {"change", told.change},
                       {"part", Number(told.part_1)},
                       {"square_sum_before", Number(told.square_sum_before_1)},
                       {"square_sum_after", Number(told.square_sum_after_1)},
                       {"redundancy_before", Number(told.redundancy_before_1)},
                       {"redundancy_after", Number(told.redundancy_after_1)},
                       {"looks_lost_before", told.looks_lost_before},
                       {"looks_lost_after", told.looks_lost_after}});
  }
  return section;
}

}  // namespace sarblock
