// SPDX-License-Identifier: Apache-2.0
#include "study/arithmetic_kind.h"

namespace sarblock {

const char* NameOf(Arithmetic arithmetic) {
  switch (arithmetic) {
    case Arithmetic::kSingle:
      return "single";
    case Arithmetic::kDouble:
      return "double";
    case Arithmetic::kExtended:
      return "extended";
  }
  return "";
}

const char* NameOf(Elimination elimination) {
  return elimination == Elimination::kQr ? "qr" : "normals";
}

}  // namespace sarblock
