// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "headline.h"
#include "page.h"
#include "result_folder.h"
#include "shown.h"

namespace sarblock {

/// The sections of a result's report in the order of reading, each with a sentence in place of what
/// the result does not have.
[[nodiscard]] PageSection CountsSection(const ResultFolder& result);
[[nodiscard]] PageSection TestSection(const ResultFolder& result);
[[nodiscard]] PageSection KnownPointsSection(const ResultFolder& result);
[[nodiscard]] PageSection MapSection(const ResultFolder& result, const AccuracyFigures& accuracy);
[[nodiscard]] PageSection ProfileSection(const ResultFolder& result);
[[nodiscard]] PageSection ResidualSection(const ResultFolder& result);
[[nodiscard]] PageSection WorstLooksSection(const ResultFolder& result);
[[nodiscard]] PageSection CorrectionSection(const ResultFolder& result);
[[nodiscard]] PageSection ModelSection(const ResultFolder& result);
[[nodiscard]] PageSection CostSection(const ResultFolder& result);
[[nodiscard]] PageSection OriginSection(const ResultFolder& result);

/// The whole page of a result.
[[nodiscard]] Page MakeResultPage(const ResultFolder& result);
/// Two results side by side.
[[nodiscard]] Page MakeComparisonPage(const ResultFolder& a, const ResultFolder& b);

}  // namespace sarblock
