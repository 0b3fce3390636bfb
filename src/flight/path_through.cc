// SPDX-License-Identifier: Apache-2.0
#include "sarblock/flight/path_through.h"

namespace sarblock {

const char* NameOf(PathThrough through) {
  switch (through) {
    case PathThrough::kStates:
      return "states";
    case PathThrough::kOrbit:
      return "orbit";
    case PathThrough::kPositions:
      return "positions";
    case PathThrough::kSmooth:
      return "smooth";
    case PathThrough::kAuto:
      return "auto";
  }
  return "";
}

}  // namespace sarblock
