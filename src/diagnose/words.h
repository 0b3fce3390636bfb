// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/diagnose/diagnosis.h"

#include <string>
#include <vector>

#include "hypothesis.h"

namespace sarblock {

/// Four digits, without trailing zeros.
[[nodiscard]] std::string Short(double value);

/// "18.000 +- 0.001 s": both to the second digit of sigma; without a sigma six digits.
[[nodiscard]] Size SizeOf(double value, double sigma, const std::string& unit);

/// The text of the number that a size equals within four of its sigmas and a thousandth; empty
/// where none or where the sigma is so large that it says nothing.
[[nodiscard]] std::string Equals(const std::vector<KnownNumber>& numbers,
                                 double value,
                                 double sigma);

/// "pass A", "passes A and B", "all passes" for none.
[[nodiscard]] std::string PassWords(const std::vector<std::string>& passes);
/// "of A", "of A and B", "of all passes" for none.
[[nodiscard]] std::string OfPasses(const std::vector<std::string>& passes);

/// The sentence of an explanation whose other members stand.
[[nodiscard]] std::string SentenceOf(const Hypothesis& hypothesis,
                                     const Size& size,
                                     const Explanation& explanation);

}  // namespace sarblock
