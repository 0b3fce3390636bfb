// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/options.h"

#include <string>
#include <vector>

#include "block_builder.h"
#include "product/sicd.h"

namespace sarblock {

/// What the error statistics of one image become.
struct SicdPriors {
  std::vector<CorrectionGroup> corrections;  ///< of the pass alone
  std::vector<JointPrior> priors;            ///< named as the pass
  std::string says;                          ///< what was taken, for people
  std::vector<std::string> warnings;         ///< what was not
};

/// PosVelErr becomes a position correction of degree 1 in frame axes with a joint prior, RangeBias
/// one of the range bias, TropoRangeVertical one of the zenith delay:
///     c_0 = dP + (t_m - t_SCP) dV,   c_1 = h dV
/// t_m the middle of the strip of `image`, h half its length, t_SCP the aperture of the scene
/// centre, where RIC axes are taken too. Velocities of 0 leave degree 0. docs/import_sicd.md.
[[nodiscard]] SicdPriors PriorsOfSicd(const SicdImage& sicd, const ImagePass& image);

}  // namespace sarblock
