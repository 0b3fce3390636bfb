// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/diagnose/diagnosis.h"

#include <nlohmann/json.hpp>

namespace sarblock {

/// The array `diagnosis` of summary.json: one object an explanation, the most likely first.
[[nodiscard]] nlohmann::ordered_json DiagnosisSection(const Diagnosis& diagnosis);

}  // namespace sarblock
