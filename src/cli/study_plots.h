// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "studies/densification.h"
#include "studies/design.h"
#include "studies/study.h"

namespace sarblock::cli {

/// Plots that studies of control and of design leave in their folders, two at most
/// (docs/studies.md).

/// Name and content.
using StudyFile = std::pair<std::string, std::string>;

/// densification_worst.svg: the worst sigma_u and sigma_h of each variant against the number of
/// control points, a line a layout. densification_relative.svg: positions beside differences of
/// neighbours, and the verified rows with their bounds.
[[nodiscard]] std::vector<StudyFile> PlotsOf(const DensificationStudy& study,
                                             const StudyTable& table);

/// design_curve.svg of one axis, design_maps.svg of two: the accuracy, and where there are prices
/// against cost. design_law.svg (design_verified.svg without laws): laws of growth and the verified
/// rows. `table` as MarkPareto() leaves it.
[[nodiscard]] std::vector<StudyFile> PlotsOf(const DesignStudy& study, const StudyTable& table);

}  // namespace sarblock::cli
