// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace sarblock {

/// A family of small blocks that one number pushes from comfortable to impossible.
struct StabilityFamily {
  std::string name;       ///< "intersection-angle"
  std::string parameter;  ///< what the number is, with its unit: "angle_deg"
  std::string about;      ///< one sentence for people
  std::vector<double> values;
  bool whole = false;  ///< the number counts something
};

/// All families with the values they are run with by default (docs/studies/stability.md).
[[nodiscard]] std::vector<StabilityFamily> StabilityFamilies();

}  // namespace sarblock
