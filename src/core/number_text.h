// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace sarblock {

/// So many significant digits, without trailing zeros: Digits(0.1234, 2) is "0.12".
[[nodiscard]] std::string Digits(double value, int digits);

/// A value and its standard deviation, both rounded to the second digit of the latter: "-0.99978
/// +- 0.00031", "1234570 +- 120"; as powers of ten where a billion and more or very small. Without
/// a standard deviation above 0: six digits of the value alone.
[[nodiscard]] std::string ValueWithSigma(double value, double sigma);

}  // namespace sarblock
