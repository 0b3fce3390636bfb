// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace sarblock {

/// A number with four significant digits; a probability or a part of one as percent.
[[nodiscard]] std::string Shown(double value, int digits = 4);
[[nodiscard]] std::string ShownPercent(double part);
/// "1.2 +- 0.3"
[[nodiscard]] std::string ShownWithSigma(double value, double sigma);
/// The first letter in capitals.
[[nodiscard]] std::string Capital(std::string text);

}  // namespace sarblock
