// SPDX-License-Identifier: Apache-2.0
#include "sarblock/model/result.h"

#include <cmath>

namespace sarblock {

const char* NameOf(PointStatus status) {
  switch (status) {
    case PointStatus::kAdjusted:
      return "adjusted";
    case PointStatus::kIntersected:
      return "intersected";
    case PointStatus::kPredicted:
      return "predicted";
    case PointStatus::kNotSeen:
      return "not-seen";
    case PointStatus::kTooFewLooks:
      return "too-few-looks";
    case PointStatus::kApart:
      return "circles-apart";
    case PointStatus::kUndetermined:
      return "undetermined";
  }
  return "undetermined";
}

const char* NameOf(RejectReason reason) {
  switch (reason) {
    case RejectReason::kNone:
      return "";
    case RejectReason::kGiven:
      return "given";
    case RejectReason::kNoValue:
      return "no-value";
    case RejectReason::kRobust:
      return "robust";
    case RejectReason::kBlunder:
      return "blunder";
    case RejectReason::kSuspect:
      return "suspect";
  }
  return "";
}

bool IsSolved(PointStatus status) {
  return status == PointStatus::kAdjusted || status == PointStatus::kIntersected ||
         status == PointStatus::kPredicted;
}

double CovarianceFactor(const AdjustOptions& options, const AdjustResult& result) {
  return options.scale_by_posterior && std::isfinite(result.sigma0_squared) ? result.sigma0_squared
                                                                            : 1.0;
}

const char* NameOf(Verdict verdict) {
  switch (verdict) {
    case Verdict::kAccepted:
      return "accepted";
    case Verdict::kTestsFailed:
      return "converged, tests failed";
    case Verdict::kNotAccepted:
      return "not accepted";
  }
  return "not accepted";
}

void Refuse(AdjustResult* result, const std::string& reason) {
  result->assessment.reasons.push_back(reason);
}

void Warn(AdjustResult* result, const std::string& text) { result->warnings.push_back(text); }

}  // namespace sarblock
