// SPDX-License-Identifier: Apache-2.0
#include "shown.h"

#include <cmath>

#include "html.h"

namespace sarblock {

std::string Shown(double value, int digits) { return ReadableNumber(value, digits); }

std::string ShownPercent(double part) {
  return std::isnan(part) ? "-" : ReadableNumber(100.0 * part, 3) + " %";
}

std::string ShownWithSigma(double value, double sigma) {
  return std::isnan(sigma) ? Shown(value) : Shown(value) + " \xc2\xb1 " + Shown(sigma, 2);
}

std::string Capital(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') {
    text[0] = static_cast<char>(text[0] - 'a' + 'A');
  }
  return text;
}

}  // namespace sarblock
