// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "products/sicd.h"
#include <Eigen/Core>

namespace sarblock {

/// Standard deviations of an image in its slant plane at the scene centre: range and azimuth.
struct SicdComposite {
  double range_m = 0.0;
  double azimuth_m = 0.0;
  double correlation = 0.0;
};

/// What an adjustment adds to the metadata of a SICD image (NGA.STND.0024-1,
/// ErrorStatistics.AdjustableParameterOffsets).
struct SicdAdjustment {
  SicdOffsets offsets;  ///< in place of those that the file has
  /// Covariance of ARPPosSCPCOA [m], ARPVel [m/s], TxTimeSCPCOA and RcvTimeSCPCOA [s], in this
  /// order; left out where it is not known.
  std::optional<Eigen::Matrix<double, 8, 8>> covariance;
  std::optional<SicdComposite> composite;  ///< of the adjusted image; none if not estimated
};

struct AdjustedSicd {
  std::string text;
  bool raised = false;  ///< the version was before 1.4.0, which has no offsets
};

/// The XML of a SICD image, given alone or in a NITF file, with AdjustableParameterOffsets as the
/// schema of version 1.4.0 orders them; all else is unchanged. The offset of the ranges goes
/// into RcvTimeSCPCOA. Versions 1.0.0 to 1.3.0 are raised to 1.4.0, to which they conform. Throws
/// InputError with file and line for texts that are no XML and for versions before 1.0.0.
[[nodiscard]] AdjustedSicd AdjustSicd(std::string_view bytes,
                                      const std::string& file,
                                      const SicdAdjustment& adjustment);
/// The same for the bytes of a file.
[[nodiscard]] AdjustedSicd AdjustSicdFile(const std::string& file,
                                          const SicdAdjustment& adjustment);

}  // namespace sarblock
