// SPDX-License-Identifier: Apache-2.0
#include "sarblock/model/result.h"

#include "sarblock/core/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include "core/text.h"

namespace sarblock {

FlightPath StraightenedPath(const Pass& pass) {
  const FlightPath& path = pass.path;
  if (path.IsStraight()) return path;
  constexpr int kSteps = 16;
  const double start_s = std::clamp(pass.start_s, path.start_s(), path.end_s());
  const double end_s = std::clamp(pass.end_s, path.start_s(), path.end_s());
  const double middle_s = 0.5 * (start_s + end_s);
  const double step_s = (end_s - start_s) / kSteps;
  Eigen::Vector3d mean_m = Eigen::Vector3d::Zero(), moment_ms = Eigen::Vector3d::Zero();
  double moment_s2 = 0.0, mean_speed_mps = 0.0;
  for (int k = 0; k <= kSteps; ++k) {
    const double from_middle_s = (k - 0.5 * kSteps) * step_s;
    Motion motion;
    if (!path.Evaluate(std::clamp(middle_s + from_middle_s, start_s, end_s), &motion)) return path;
    mean_m += motion.position_m / (kSteps + 1);
    mean_speed_mps += motion.velocity_mps.norm() / (kSteps + 1);
    moment_ms += from_middle_s * motion.position_m;
    moment_s2 += from_middle_s * from_middle_s;
  }
  const Eigen::Vector3d velocity_mps = moment_ms / moment_s2;
  if (!(velocity_mps.norm() > 0.5 * mean_speed_mps)) return path;
  const Eigen::Vector3d first_m = mean_m + (path.start_s() - middle_s) * velocity_mps;
  const Eigen::Vector3d last_m = first_m + (path.end_s() - path.start_s()) * velocity_mps;
  return FlightPath(std::vector<StateVector>{{path.start_s(), first_m, velocity_mps},
                                             {path.end_s(), last_m, velocity_mps}});
}

bool LeavesOut(const BlunderFinding& finding) {
  return finding.action == BlunderFinding::Action::kRejected ||
         finding.action == BlunderFinding::Action::kPointLeftOut ||
         finding.action == BlunderFinding::Action::kControlReleased;
}

double VarianceComponent::sigma_after() const { return std::sqrt(factor) * sigma_before; }

double VarianceComponent::sigma_deviation() const {
  return 0.5 * sigma_after() * factor_deviation / factor;
}

std::vector<std::array<double, 2>> SigmaFactors(const std::vector<VarianceComponent>& components,
                                                std::size_t passes) {
  std::vector<std::array<double, 2>> factor(passes, {1.0, 1.0});
  for (const VarianceComponent& component : components) {
    for (const std::size_t pass : component.passes) {
      factor[pass][static_cast<std::size_t>(component.component)] = std::sqrt(component.factor);
    }
  }
  return factor;
}

namespace {

constexpr double kConfidence = 0.99;

}  // namespace

double RunMean::lower() const {
  return mean - NormalQuantile(0.5 + 0.5 * kConfidence) * standard_error;
}
double RunMean::upper() const {
  return mean + NormalQuantile(0.5 + 0.5 * kConfidence) * standard_error;
}
bool RunMean::Agrees() const { return lower() <= expected && expected <= upper(); }

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

std::string DescribeNeeds(const ResourceNeeds& needs) {
  const auto work = [](double operations) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.1e", operations);
    return std::string(text.data());
  };
  const std::string files =
      needs.scratch_bytes > 0
          ? ", " + Mebibytes(static_cast<double>(needs.scratch_bytes)) + " MiB in scratch files"
          : "";
  return "memory " + Mebibytes(static_cast<double>(needs.peak_bytes)) + " MiB" + files +
         " (looks " + Mebibytes(static_cast<double>(needs.looks_bytes)) + ", points " +
         Mebibytes(static_cast<double>(needs.points_bytes)) + ", S " +
         Mebibytes(static_cast<double>(needs.matrix_bytes)) + ", partial sums " +
         Mebibytes(static_cast<double>(needs.partial_sums_bytes)) + ", factor " +
         Mebibytes(static_cast<double>(needs.factor_bytes)) + ", fronts " +
         Mebibytes(static_cast<double>(needs.fronts_bytes)) + ", inverse " +
         Mebibytes(static_cast<double>(needs.inverse_bytes)) + "); operations: S " +
         work(needs.sum_operations) + ", factor " + work(needs.factor_operations);
}

}  // namespace sarblock
