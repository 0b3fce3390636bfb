// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace sarblock {

/// First argument of MixStream for each kind of random thing of a scene; the second is its index.
/// The numbers are part of the reproducibility of a seed: never renumber.
enum StreamKind : std::uint64_t {
  kTerrainStream = 1,
  kTieStream = 2,
  kControlPlaceStream = 3,
  kCheckPlaceStream = 4,
  kPassStream = 5,
  kBiasStream = 6,
  kLookStream = 7,
  kKnownStream = 8,
  kWanderStream = 9,
  kRecorderStream = 10,
  kJointStream = 11,
};

}  // namespace sarblock
