// SPDX-License-Identifier: Apache-2.0
#include "sicd_priors.h"

#include "sarblock/geometry/frame.h"

#include <utility>

#include "model/priors.h"
#include "sicd_projection.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

// Seconds from the start of the collection.
double CentreTime_s(const SicdImage& sicd) {
  return sicd.aperture_time_s.empty() ? ValueOf(sicd.closest_time_s, 0.0)
                                      : ValueOf(sicd.aperture_time_s, 0.0, 0.0);
}

// Unit vectors of the axes of PosVelErr as columns, earth-fixed.
Eigen::Matrix3d AxesAt(const SicdImage& sicd, SicdErrorStatistics::Axes axes) {
  using Axes = SicdErrorStatistics::Axes;
  if (axes == Axes::kEcf) return Eigen::Matrix3d::Identity();
  const SicdMotion motion = MotionOf(sicd, CentreTime_s(sicd));
  const double rotation_rad_per_s = axes == Axes::kRicEci ? FindBody("WGS84")->rotation : 0.0;
  return RicAxes(motion.position_m, motion.velocity_mps, rotation_rad_per_s);
}

void AddPath(const SicdImage& sicd,
             const ImagePass& image,
             const SicdErrorStatistics::PositionAndVelocity& path,
             SicdPriors* out) {
  const double shift_s = SecondsBetween(WholeSecond(image.first_line), sicd.start);
  const auto [start_s, end_s] = *image.span_s;
  const double half_s = 0.5 * (end_s - start_s);
  const double since_centre_s = 0.5 * (start_s + end_s) - (CentreTime_s(sicd) + shift_s);
  const bool drift = path.sigma[3] > 0.0 || path.sigma[4] > 0.0 || path.sigma[5] > 0.0;
  const Eigen::Matrix3d axes = AxesAt(sicd, path.axes);
  Eigen::MatrixXd t = Eigen::MatrixXd::Zero(drift ? 6 : 3, 6);
  t.topLeftCorner<3, 3>() = axes;
  if (drift) {
    t.topRightCorner<3, 3>() = since_centre_s * axes;
    t.bottomRightCorner<3, 3>() = half_s * axes;
  }
  const Eigen::Map<const Eigen::Matrix<double, 6, 1>> sigma(path.sigma.data());
  const Eigen::MatrixXd given = sigma.asDiagonal() * path.correlation * sigma.asDiagonal();
  JointPrior prior;
  prior.name = image.pass.id;
  prior.passes = {image.pass.id};
  for (int degree = 0; degree <= (drift ? 1 : 0); ++degree) {
    for (const char* axis : {"x", "y", "z"}) {
      prior.parameters.push_back(fmt::format("position.{}.{}", axis, degree));
    }
  }
  const Eigen::MatrixXd turned = t * given * t.transpose();
  prior.covariance = 0.5 * (turned + turned.transpose());
  if (const auto problem = FindCovarianceProblem(prior.parameters, prior.covariance)) {
    out->warnings.push_back(
        fmt::format("{}: SICD.ErrorStatistics.Components.PosVelErr is no prior of the path, which "
                    "counts as exact: {}",
                    sicd.file,
                    *problem));
    return;
  }
  PositionCorrection position;
  position.degree = drift ? 1 : 0;
  position.axes = PositionCorrection::Axes::kFrame;
  out->corrections.push_back({"position", position, {image.pass.id}, false});
  out->priors.push_back(std::move(prior));
  out->says += fmt::format(
      "path {:.3g}, {:.3g}, {:.3g} m{}",
      path.sigma[0],
      path.sigma[1],
      path.sigma[2],
      drift ? fmt::format(
                  " and {:.3g}, {:.3g}, {:.3g} m/s", path.sigma[3], path.sigma[4], path.sigma[5])
            : std::string());
}

void Say(const std::string& text, std::string* says) {
  *says += (says->empty() ? "" : ", ") + text;
}

}  // namespace

SicdPriors PriorsOfSicd(const SicdImage& sicd, const ImagePass& image) {
  SicdPriors out;
  if (!sicd.errors) {
    out.says = "no ErrorStatistics: its path and its ranges count as exact but for noise";
    return out;
  }
  if (sicd.offsets) {
    out.says =
        "no priors: its ErrorStatistics are those of the path before its "
        "AdjustableParameterOffsets, which are applied; path and ranges count as exact but for "
        "noise";
    return out;
  }
  const SicdErrorStatistics& errors = *sicd.errors;
  if (errors.path) AddPath(sicd, image, *errors.path, &out);
  const std::vector<std::string> passes{image.pass.id};
  if (errors.range_bias_m.value_or(0.0) > 0.0) {
    RangeCorrection range;
    range.bias = true;
    range.bias_prior_sigma_m = *errors.range_bias_m;
    out.corrections.push_back({"range", range, passes, false});
    Say(fmt::format("range bias {:.3g} m", *errors.range_bias_m), &out.says);
  }
  if (errors.zenith_delay_m.value_or(0.0) > 0.0) {
    TroposphereCorrection air;
    air.zenith_prior_sigma_m = *errors.zenith_delay_m;
    out.corrections.push_back({"troposphere", air, passes, false});
    Say(fmt::format("zenith delay {:.3g} m", *errors.zenith_delay_m), &out.says);
  }
  out.says = out.says.empty()
                 ? "ErrorStatistics gives no prior: its path and its ranges count as exact but for "
                   "noise"
                 : "priors of ErrorStatistics: " + out.says;
  if (!errors.not_used.empty()) {
    std::string names;
    for (const std::string& name : errors.not_used) names += (names.empty() ? "" : ", ") + name;
    out.says += "; not used: " + names;
  }
  return out;
}

}  // namespace sarblock
