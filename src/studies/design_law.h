// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "design.h"
#include "study.h"

namespace sarblock {

/// Laws of growth: how accuracy follows from the number of strips, the noise, the ties
/// (docs/theory/growth.md).

/// y = factor x^exponent.
struct PowerLaw {
  double factor = std::numeric_limits<double>::quiet_NaN();
  double exponent = std::numeric_limits<double>::quiet_NaN();
  /// Standard error of the exponent by the scatter about the line, n - 2 degrees of freedom; NaN of
  /// two values. Predicted values have no noise: for them it measures how straight the line is.
  double exponent_sigma = std::numeric_limits<double>::quiet_NaN();
  double last_exponent = std::numeric_limits<double>::quiet_NaN();  ///< of the last two values
  std::size_t values = 0;
};

/// The line of least squares through log y against log x. Values that are not finite or not above
/// 0 are left out; NaN where fewer than two different x are left. x ascends.
[[nodiscard]] PowerLaw FitPowerLaw(const std::vector<std::array<double, 2>>& values);

/// The law of one direction for one value of the other axis.
struct FittedLaw {
  std::string value;                          ///< of the other axis; empty without one
  std::size_t place = 0;                      ///< its index
  std::size_t axis = 0;                       ///< along, across, up
  std::string column;                         ///< of design.csv that was fitted
  double derived = kNotGiven;                 ///< exponent by the study file
  std::vector<std::array<double, 2>> values;  ///< what was swept, and sigma [m]
  PowerLaw law;
};

/// Laws of the worst point, then of the median; each by the value of the other axis, then along,
/// across, up. None where the study asks for none.
[[nodiscard]] std::vector<FittedLaw> FitLaws(const DesignStudy& study, const StudyTable& table);

/// The laws as design_law.csv (docs/studies.md).
[[nodiscard]] StudyTable LawTable(const DesignStudy& study, const std::vector<FittedLaw>& laws);

/// For a terminal: exponents of the worst point, found beside derived, a line a direction.
[[nodiscard]] std::vector<std::string> LawLines(const DesignStudy& study,
                                                const std::vector<FittedLaw>& laws);

/// The same in sentences, one a value of the other axis.
[[nodiscard]] std::vector<std::string> DescribeLaws(const DesignStudy& study,
                                                    const std::vector<FittedLaw>& laws);

}  // namespace sarblock
