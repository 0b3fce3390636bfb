// SPDX-License-Identifier: Apache-2.0
#include "sarblock/geometry/sight.h"

namespace sarblock {

const char* NameOf(IntersectionOutcome outcome) {
  switch (outcome) {
    case IntersectionOutcome::kDetermined:
      return "determined";
    case IntersectionOutcome::kTooFewLooks:
      return "too-few-looks";
    case IntersectionOutcome::kCirclesDoNotMeet:
      return "circles-do-not-meet";
    case IntersectionOutcome::kCirclesTouch:
      return "circles-touch";
    case IntersectionOutcome::kCirclesCoincide:
      return "circles-coincide";
    case IntersectionOutcome::kWrongSide:
      return "wrong-side";
    case IntersectionOutcome::kAmbiguous:
      return "ambiguous";
    case IntersectionOutcome::kNotConverged:
      return "not-converged";
  }
  return "unknown";
}

const char* Explain(IntersectionOutcome outcome) {
  switch (outcome) {
    case IntersectionOutcome::kDetermined:
      return "The looks determine one point.";
    case IntersectionOutcome::kTooFewLooks:
      return "Fewer than two looks: one look confines the point to a circle only.";
    case IntersectionOutcome::kCirclesDoNotMeet:
      return "The circles of the looks stay apart by more than their standard deviations explain: "
             "look for a blunder, a path error or standard deviations that are too small.";
    case IntersectionOutcome::kCirclesTouch:
      return "The circles of the looks meet tangentially: one direction is not determined.";
    case IntersectionOutcome::kCirclesCoincide:
      return "The circles of the looks are the same within the noise (zero base, or squinted "
             "stereo "
             "from a single flight line): the direction around the flight axis is not determined.";
    case IntersectionOutcome::kWrongSide:
      return "The circles meet, but not on the side the antennas look to: check the look sides.";
    case IntersectionOutcome::kAmbiguous:
      return "Two points satisfy the looks and their sides equally well: a third look or control "
             "has to decide.";
    case IntersectionOutcome::kNotConverged:
      return "The iteration did not converge.";
  }
  return "";
}

}  // namespace sarblock
