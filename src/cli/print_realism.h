// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/result.h"

#include <string>

namespace sarblock::cli {

/// Variance components and Monte Carlo runs of a result for people, where it has some.
[[nodiscard]] std::string DescribeVarianceComponents(const AdjustResult& result);
[[nodiscard]] std::string DescribeMonteCarlo(const AdjustResult& result);

}  // namespace sarblock::cli
