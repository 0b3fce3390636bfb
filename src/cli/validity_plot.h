// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "leberl/validity.h"

namespace sarblock::cli {

/// An SVG of the lines where the first order of `source` is off by 1, 5 and 20 percent: look angle
/// against log10(error/H), one colour a base-to-height ratio, the case of `terrain_ratio` z/H.
[[nodiscard]] std::string PlotValidity(const std::vector<ValidityLine>& lines,
                                       ValiditySource source,
                                       double terrain_ratio);

}  // namespace sarblock::cli
