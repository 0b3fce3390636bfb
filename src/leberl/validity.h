// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/leberl/formulas.h"

#include <optional>
#include <string>
#include <vector>

namespace sarblock {

/// Where the paper's first-order formulas are valid. The figure is
///     |formula - exact| / |exact|   of the vector (dy, dz),
/// formula: Eq. 14 and 15 of the datum point (y, 0); exact: the finite intersection at (y, z). It
/// depends on ratios only: look angle theta', B/H, error/H and z/H.
/// docs/theory/leberl.md, section 6.
enum class ValiditySource { kAcrossPosition, kUpPosition, kRange };  ///< of station ''
[[nodiscard]] const char* NameOf(ValiditySource source);             ///< dy0'', dz0'', dr''

struct ValidityCase {
  ValiditySource source = ValiditySource::kAcrossPosition;
  leberl::Arrangement arrangement = leberl::Arrangement::kSameSide;
  double look_rad = 0.0;       ///< theta', in (0, pi/2)
  double base_ratio = 0.0;     ///< B/H > 0
  double terrain_ratio = 0.0;  ///< z/H, < 1
};

/// The relative difference for an error of `error_ratio` H. Empty where the arrangement has no
/// such geometry (theta' inside or outside the base) or the perturbed circles do not meet.
[[nodiscard]] std::optional<double> RelativeDifference(const ValidityCase& v, double error_ratio);

/// Smallest error/H at which the relative difference reaches `level` (0.01, 0.05, 0.20), found by
/// steps of 10^(1/8) from 1e-7 to 1 and bisection to 1e-6 of itself. 0 where terrain alone
/// exceeds the level; empty where there is no geometry or the level is not reached. Accuracy
/// 1e-6 relative of the ratio.
[[nodiscard]] std::optional<double> ErrorRatioAtLevel(const ValidityCase& v, double level);

struct ValidityOptions {
  std::vector<double> look_deg = {20, 25, 30, 35, 40, 45, 50, 55, 60, 65, 70};
  std::vector<double> base_ratio = {0.05, 0.1, 0.2, 0.4, 0.8};
  std::vector<double> terrain_ratio = {0.0, 0.005, 0.02};
  std::vector<double> error_ratio = {1e-5, 1e-4, 1e-3, 1e-2};
};

/// One row of the map: the relative difference for one size of error.
struct ValidityRow {
  ValidityCase of;
  double error_ratio = 0.0;
  std::optional<double> relative_difference;  ///< [1]
};
/// One point of the lines where the first order is off by 1, 5 and 20 percent.
struct ValidityLine {
  ValidityCase of;
  std::optional<double> error_ratio_1_percent;  ///< error/H where 1 percent is reached
  std::optional<double> error_ratio_5_percent;
  std::optional<double> error_ratio_20_percent;
};
[[nodiscard]] std::vector<ValidityRow> ValidityMap(const ValidityOptions& options);
[[nodiscard]] std::vector<ValidityLine> ValidityLines(const ValidityOptions& options);

}  // namespace sarblock
