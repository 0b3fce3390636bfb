// SPDX-License-Identifier: Apache-2.0
#include "sarblock/diagnose/diagnosis.h"

namespace sarblock {

const char* NameOf(MistakeKind kind) {
  switch (kind) {
    case MistakeKind::kTime:
      return "time";
    case MistakeKind::kRange:
      return "range";
    case MistakeKind::kCone:
      return "cone";
    case MistakeKind::kPath:
      return "path";
    case MistakeKind::kControl:
      return "control";
    case MistakeKind::kIds:
      return "ids";
    case MistakeKind::kSigma:
      return "sigma";
    case MistakeKind::kModel:
      return "model";
  }
  return "";
}

std::vector<std::string> Diagnosis::Sentences() const {
  std::vector<std::string> out;
  for (const Explanation& explanation : explanations) {
    out.push_back((out.empty() ? "most likely: " : "or: ") + explanation.sentence);
  }
  if (out.empty() && !pattern.empty()) {
    out.push_back("no standard deviation explains it, the residuals are no noise: " + pattern);
  }
  return out;
}

}  // namespace sarblock
