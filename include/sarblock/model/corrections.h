// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"

#include <array>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Core>

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

/// One prior of several corrections of a pass, with their full covariance
/// (docs/theory/adjustment.md, eq. (3a)). Every pass draws its own; the parameters are those of the
/// pass itself, neither shared by passes nor coefficients of a spline, and have no standard
/// deviation of their own.
struct JointPrior {
  /// Axes in which the position parameters are named and their covariance is given.
  enum class Axes {
    kCorrection,   ///< those of the pass's position correction
    kTrack,        ///< along, across, up
    kFrame,        ///< x, y, z
    kRic,          ///< radial, in-track, cross-track, of the velocity in the block's frame
    kRicInertial,  ///< the same, of the velocity that does not turn with the body
  };
  std::string name;
  std::vector<std::string> passes;  ///< empty: all that have the parameters
  /// As results name them ("position.along.0", "range.bias"); in axes other than those of the
  /// correction all three of a degree, which are turned at the middle of the strip.
  std::vector<std::string> parameters;
  Axes axes = Axes::kCorrection;
  /// Symmetric, positive definite, in the order of `parameters`: products of their units (m, s,
  /// rad, 1). Or empty, with standard deviations and, unless they are independent, correlations in
  /// its place.
  Eigen::MatrixXd covariance;
  Eigen::VectorXd sigma;
  Eigen::MatrixXd correlation;

  /// The covariance, however it was given.
  [[nodiscard]] Eigen::MatrixXd Covariance() const;
};

/// True where two groups that are not shared cannot stand for one pass: both of one kind, position
/// groups only where they have a component in common or stand in different axes.
[[nodiscard]] bool Overlap(const CorrectionGroup& a, const CorrectionGroup& b);

}  // namespace sarblock
