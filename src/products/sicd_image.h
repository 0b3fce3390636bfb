// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/options.h"

#include <string>
#include <vector>

#include "block_builder.h"
#include "image.h"
#include "sicd.h"

namespace sarblock {

/// Whether the columns are evenly spaced zero-Doppler times.
[[nodiscard]] bool HasRaster(const SicdImage& image);
/// With a raster where columns are evenly spaced zero-Doppler times, to 1e-9 s; with ImagePass's
/// `aperture` for all other images. Its id is the file's name without ending.
[[nodiscard]] ImagePass PassOfSicd(const SicdImage& image);

/// A place that the metadata of a SICD image give both in the image and on the ground.
struct SicdPoint {
  std::string name;
  GridPoint point;  ///< times from `start_s`, that of CollectStart
};

/// The scene centre, "SCP". Throws InputError where the image gives it no look.
[[nodiscard]] SicdPoint CentreOfSicd(const SicdImage& image, double start_s);

/// The corners of this file's pixels, "FRFC", "FRLC", "LRLC" and "LRFC" (first or last row, first
/// or last column), at the height of the scene centre. Throws InputError where the file does not
/// place all four, or a corner has no look.
[[nodiscard]] std::vector<SicdPoint> CornersOfSicd(const SicdImage& image, double start_s);

/// What the error statistics of one image become.
struct SicdPriors {
  std::vector<CorrectionGroup> corrections;  ///< of the pass alone
  std::vector<JointPrior> priors;            ///< named as the pass
  std::string says;                          ///< what was taken, for people
  std::vector<std::string> warnings;         ///< what was not
};

/// PosVelErr becomes a position correction of degree 1 in frame axes with a joint prior, RangeBias
/// one of the range bias, TropoRangeVertical one of the zenith delay:
///     c_0 = dP + (t_m - t_SCP) dV,   c = h dV
/// t_m the middle of the strip of `image`, h half its length, t_SCP the aperture of the scene
/// centre, where RIC axes are taken too. Velocities of 0 leave degree 0. docs/import_sicd.md.
[[nodiscard]] SicdPriors PriorsOfSicd(const SicdImage& sicd, const ImagePass& image);

}  // namespace sarblock
