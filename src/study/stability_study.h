// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "study/stability.h"
#include "study/stability_families.h"
#include "study/study_table.h"

namespace sarblock {

/// Families with the values they are to be run with (docs/studies.md).
struct StabilityStudy {
  StudyHeading heading;
  std::vector<StabilityFamily> families;
};

/// The study as tasks, one a step; columns in docs/studies.md.
[[nodiscard]] StudyPlan PlanStability(const StabilityStudy& study);

/// In sentences: how often each outcome came, in all and by family; the worst of the rows that are
/// ok; digits of each method by the condition; every row that is wrong.
[[nodiscard]] std::vector<std::string> DescribeStability(const StabilityStudy& study,
                                                         const StudyTable& table);

}  // namespace sarblock
