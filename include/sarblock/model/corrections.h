// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"

#include <array>
#include <string>
#include <variant>
#include <vector>

namespace sarblock {

/// Prior standard deviation of one parameter; NaN (kNotGiven) means no prior.
using PriorSigma = double;

/// Correction of the antenna position, delta(t) (model.md, section 3; docs/theory/flight_path.md).
struct PositionCorrection {
  enum class Basis { kPolynomial, kSpline };
  enum class Axes { kTrack, kFrame };
  Basis basis = Basis::kPolynomial;
  int degree = 0;                     ///< polynomial: Legendre 0..degree, <= kMaxDegree
  double knot_spacing_s = kNotGiven;  ///< spline
  Axes axes = Axes::kTrack;
  std::array<bool, 3> components{true, true, true};  ///< along, across, up or x, y, z
  /// Per axis: empty = no prior; one value = for every degree or spline coefficient; else one a
  /// degree (polynomial only, size degree + 1).
  std::array<std::vector<double>, 3> prior_sigma_m;
  static constexpr int kMaxDegree = 15;
};

/// Error of the velocity direction in the cone only: v/|v| + c_across across + c_up up.
struct VelocityCorrection {
  std::array<bool, 2> components{true, true};                   ///< across, up
  std::array<PriorSigma, 2> prior_sigma{kNotGiven, kNotGiven};  ///< dimensionless
};

/// R = rho + bias + scale rho.
struct RangeCorrection {
  bool bias = false;
  PriorSigma bias_prior_sigma_m = kNotGiven;
  bool scale = false;
  PriorSigma scale_prior_sigma = kNotGiven;  ///< dimensionless (the file gives ppm)
};

/// The path is read at t + bias.
struct TimeCorrection {
  PriorSigma bias_prior_sigma_s = kNotGiven;
};

/// tau + bias in the Doppler cone.
struct SquintCorrection {
  PriorSigma bias_prior_sigma_rad = kNotGiven;
};

/// Adds zenith * exp(-h / scale_height) / cos(incidence at the target) to the range.
struct TroposphereCorrection {
  PriorSigma zenith_prior_sigma_m = kNotGiven;
  double scale_height_m = 7000.0;
};

/// One group of corrections for some passes.
struct CorrectionGroup {
  std::string name;  ///< as it stands in the file ("position", "range"); owner of shared parameters
  std::variant<PositionCorrection,
               VelocityCorrection,
               RangeCorrection,
               TimeCorrection,
               SquintCorrection,
               TroposphereCorrection>
      model;
  std::vector<std::string> passes;  ///< empty: all
  bool shared = false;              ///< one set of parameters for all of `passes`
};

/// True where two groups that are not shared cannot stand for one pass: both of one kind, position
/// groups only where they have a component in common or stand in different axes.
[[nodiscard]] bool Overlap(const CorrectionGroup& a, const CorrectionGroup& b);

}  // namespace sarblock
