// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/image_grid.h"

#include <optional>

#include "product/sicd.h"
#include <Eigen/Core>

namespace sarblock {

/// What a place in a SICD image measured: range and its rate at an exact time, the centre of the
/// aperture (COA).
struct ApertureLook {
  double time_s = 0.0;  ///< from SicdImage::start
  double range_m = 0.0;
  double range_rate_mps = 0.0;  ///< positive: the range grows
};

/// The look of a row and column (0, 0 is the middle of the first pixel of the file), by the image
/// projections of NGA.STND.0024-3, SICD volume 3. Nothing where the polynomials give no range above
/// 0, a range rate that is not below the speed, or no finite numbers.
[[nodiscard]] std::optional<ApertureLook> LookOfPlace(const SicdImage& image,
                                                      double row_px,
                                                      double column_px);

/// Standard deviations of range and range rate of a look whose row and column have these. The time
/// is held: what an error of it does to range and rate, it does to those predicted too.
struct ApertureSigma {
  double range_m = 0.0;
  double range_rate_mps = 0.0;
};
[[nodiscard]] std::optional<ApertureSigma> SigmaOfPlace(const SicdImage& image,
                                                        double row_px,
                                                        double column_px,
                                                        double row_sigma_px,
                                                        double column_sigma_px);

/// Row (line_px) and column (pixel_px) at which an earth-fixed place is seen, by Newton's method
/// from the scene centre. Nothing where it finds none.
[[nodiscard]] std::optional<ImageCoordinates> PlaceInSicd(const SicdImage& image,
                                                          const Eigen::Vector3d& p_m);

/// Position and velocity of the antenna: MotionOf() as the polynomials give them,
/// AdjustedMotionOf() with the file's offsets. Projections form ranges and rates of the first and
/// hold them against the second.
struct SicdMotion {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
};
[[nodiscard]] SicdMotion MotionOf(const SicdImage& image, double time_s);
[[nodiscard]] SicdMotion AdjustedMotionOf(const SicdImage& image, double time_s);

}  // namespace sarblock
