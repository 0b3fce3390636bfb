// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/flight/path_through.h"

#include <array>

namespace sarblock {

/// Every way that a file may ask for (NameOf()).
inline constexpr std::array kPathsThrough{PathThrough::kStates,
                                          PathThrough::kOrbit,
                                          PathThrough::kPositions,
                                          PathThrough::kSmooth,
                                          PathThrough::kAuto};

}  // namespace sarblock
