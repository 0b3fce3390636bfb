// SPDX-License-Identifier: Apache-2.0
#include "sicd_error_reader.h"

#include <array>
#include <cmath>
#include <initializer_list>
#include <string>
#include <vector>

#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr std::array<const char*, 6> kComponents = {"P1", "P2", "P3", "V1", "V2", "V3"};
constexpr double kLargestSigma = 1e9;

double Sigma(const XmlElement& element) {
  const double sigma = element.Number();
  if (!(sigma >= 0.0 && sigma <= kLargestSigma)) {
    element.Fail(fmt::format(
        "{} is not allowed, a standard deviation from 0 to {} is", sigma, kLargestSigma));
  }
  return sigma;
}

// Of looks, which none may be without.
double PositiveSigma(const XmlElement& parent, const char* name) {
  const XmlElement element = parent.Child(name);
  const double sigma = Sigma(element);
  if (!(sigma > 0.0)) element.Fail("is 0, a standard deviation of looks above 0 is allowed");
  return sigma;
}

SicdErrorStatistics::PositionAndVelocity ReadPosVelErr(const XmlElement& element) {
  using Axes = SicdErrorStatistics::Axes;
  SicdErrorStatistics::PositionAndVelocity out;
  const XmlElement frame = element.Child("Frame");
  const std::string name = frame.Text();
  if (name == "ECF") {
    out.axes = Axes::kEcf;
  } else if (name == "RIC_ECF") {
    out.axes = Axes::kRicEcf;
  } else if (name == "RIC_ECI") {
    out.axes = Axes::kRicEci;
  } else {
    frame.Fail("'" + name + "' is not allowed, ECF, RIC_ECF or RIC_ECI is");
  }
  for (std::size_t i = 0; i < 6; ++i) out.sigma[i] = Sigma(element.Child(kComponents[i]));
  const auto coefficients = element.Find("CorrCoefs");
  if (!coefficients) return out;
  out.correlated = true;
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = i + 1; j < 6; ++j) {
      const std::string pair = std::string(kComponents[i]) + kComponents[j];
      const XmlElement coefficient = coefficients->Child(pair.c_str());
      const double r_1 = coefficient.Number();
      if (!(std::abs(r_1) <= 1.0)) coefficient.Fail("is no correlation, -1 to 1 is allowed");
      const auto a = static_cast<Eigen::Index>(i), b = static_cast<Eigen::Index>(j);
      out.correlation(a, b) = out.correlation(b, a) = r_1;
    }
  }
  return out;
}

// Notes the children of an element that stand there and become nothing.
void Note(const XmlElement& element,
          const std::string& path,
          std::initializer_list<const char*> names,
          std::vector<std::string>* not_used) {
  for (const char* name : names) {
    if (element.Find(name)) not_used->push_back(path + name);
  }
}

}  // namespace

std::optional<SicdErrorStatistics> ReadErrorStatistics(const XmlElement& root) {
  const auto element = root.Find("ErrorStatistics");
  if (!element) return std::nullopt;
  SicdErrorStatistics out;
  Note(*element,
       "",
       {"CompositeSCP",
        "BistaticCompositeSCP",
        "BistaticComponents",
        "BistaticAdjustableParameterOffsets"},
       &out.not_used);
  if (const auto rest = element->Find("Unmodeled")) {
    out.row_sigma_m = PositiveSigma(*rest, "Xrow");
    out.column_sigma_m = PositiveSigma(*rest, "Ycol");
    Note(*rest, "Unmodeled.", {"XrowYcol", "UnmodeledDecorr"}, &out.not_used);
  }
  const auto components = element->Find("Components");
  if (!components) return out;
  if (const auto path = components->Find("PosVelErr")) {
    out.path = ReadPosVelErr(*path);
    Note(*path, "PosVelErr.", {"PositionDecorr"}, &out.not_used);
  }
  if (const auto radar = components->Find("RadarSensor")) {
    if (const auto bias = radar->Find("RangeBias")) out.range_bias_m = Sigma(*bias);
    Note(*radar,
         "RadarSensor.",
         {"ClockFreqSF", "TransmitFreqSF", "RangeBiasDecorr"},
         &out.not_used);
  }
  if (const auto air = components->Find("TropoError")) {
    if (const auto vertical = air->Find("TropoRangeVertical")) {
      out.zenith_delay_m = Sigma(*vertical);
    }
    Note(*air, "TropoError.", {"TropoRangeSlant", "TropoRangeDecorr"}, &out.not_used);
  }
  Note(*components, "", {"IonoError"}, &out.not_used);
  return out;
}

}  // namespace sarblock
