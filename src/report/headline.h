// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "accuracy.h"
#include "headline_struct.h"

namespace sarblock {

[[nodiscard]] Headline HeadlineOf(const ResultFolder& result, const AccuracyFigures& accuracy);

}  // namespace sarblock
