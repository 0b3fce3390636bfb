// SPDX-License-Identifier: Apache-2.0
#include "study/stability.h"

#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "exact_adjustment.h"
#include "family_plan.h"
#include "stability_methods.h"
#include "study/stability_families.h"

namespace sarblock {
namespace {

double DigitsOf(double relative_error) {
  if (std::isnan(relative_error)) return 0.0;
  return std::clamp(-std::log10(relative_error), 0.0, 16.0);
}

/// The problem of a result, points and looks in use as it left them, at its solution.
void Restore(const AdjustResult& result, AdjustmentProblem* problem, BlockState* state) {
  const std::size_t points = problem->block.points.size();
  for (std::size_t point = 0; point < points; ++point) {
    if (!IsSolved(result.points.status[point])) {
      problem->LeaveOut(point, result.points.status[point], {});
    }
  }
  for (std::size_t i = 0; i < result.looks.rejected.size(); ++i) {
    if (result.looks.rejected[i] != 0) problem->look_used[i] = 0;
  }
  state->start_m = result.points.position_m;
  state->displacement_m.assign(points, Eigen::Vector3d::Zero());
  state->corrections.resize(problem->layout.size());
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    state->corrections[static_cast<Eigen::Index>(i)] = result.parameters[i].value;
  }
  UpdateWeights(*state, problem);
}

/// Words of a warning that the numbers are not to be trusted to their digits. A warning of points
/// that were left out says nothing of the others.
bool TellsOfDigits(const std::string& warning) {
  constexpr std::array<const char*, 5> kWords = {"not converged",
                                                 "sigmas are still to go",
                                                 "nearly undetermined",
                                                 "more than half their range",
                                                 "rounding"};
  return std::any_of(kWords.begin(), kWords.end(), [&](const char* word) {
    return warning.find(word) != std::string::npos;
  });
}

std::string Joined(const std::vector<std::string>& texts) {
  std::string out;
  for (const std::string& text : texts) out += (out.empty() ? "" : " | ") + text;
  return out;
}

void FillComparison(const Block& block,
                    const AdjustOptions& options,
                    const AdjustResult& result,
                    ProgressSink* progress,
                    StabilityRow* row) {
  AdjustmentProblem problem(block, options.groups, {}, options.priors);
  BlockState state;
  Restore(result, &problem, &state);
  const ExactComparison exact = CompareWithExact(problem, result);
  if (!exact.failure.empty()) {
    row->message += (row->message.empty() ? "" : " | ") + ("oracle: " + exact.failure);
    return;
  }
  row->condition = exact.condition_1;
  row->covariance_digits_1 = DigitsOf(exact.covariance_error_1);
  row->sigma_digits_1 = DigitsOf(exact.sigma_error_1);
  row->position_digits_1 = DigitsOf(exact.position_error_1);
  row->error_sigma_1 = exact.error_sigma_1;
  const auto by_normals = [&](Precision precision) {
    return DigitsOf(
        CovarianceError(CovariancesByNormals(problem, state, precision), exact.covariance_m2));
  };
  row->normal_digits_1 = by_normals(Precision::kDouble);
  row->single_digits_1 = by_normals(Precision::kSingle);
  AdjustOptions ceres = options;
  ceres.engine = Engine::kCeres;
  ceres.threads = 1;  // the order of its sums, and so the last digits, follow from the number
  ceres.covariance_method = CovarianceMethod::kCeres;
  try {
    row->ceres_digits_1 = DigitsOf(CovarianceError(
        Adjust(block, ceres, {}, progress).points.covariance_m2, exact.covariance_m2));
  } catch (const UndeterminedError&) {
    // Stays without digits.
  }
}

}  // namespace

const char* NameOf(StabilityOutcome outcome) {
  switch (outcome) {
    case StabilityOutcome::kOk:
      return "ok";
    case StabilityOutcome::kWarned:
      return "warned";
    case StabilityOutcome::kRefused:
      return "refused";
    case StabilityOutcome::kWrong:
      break;
  }
  return "wrong";
}

StabilityOutcome JudgeStability(const StabilityRow& row, const std::vector<std::string>& warnings) {
  if (row.exit_code > 1) return StabilityOutcome::kRefused;
  // Written so that what could not be compared is not right.
  const bool right = row.error_sigma_1 <= kMostError_1 && row.sigma_digits_1 >= kLeastDigits_1 &&
                     row.covariance_digits_1 >= kLeastDigits_1;
  const bool said = std::any_of(warnings.begin(), warnings.end(), TellsOfDigits);
  if (!right && !said) return StabilityOutcome::kWrong;
  return row.exit_code == 0 && warnings.empty() ? StabilityOutcome::kOk : StabilityOutcome::kWarned;
}

StabilityRow RunStabilityStep(const std::string& family,
                              double value,
                              int threads,
                              ProgressSink* progress) {
  StabilityPlan plan = PlanOf(family, value);
  StabilityRow row;
  row.family = family;
  for (const StabilityFamily& known : StabilityFamilies()) {
    if (known.name == family) row.parameter = known.parameter;
  }
  row.value = value;
  plan.options.threads = threads;
  AdjustResult result;
  const Block block = MakeStabilityBlock(plan);
  try {
    result = Adjust(block, plan.options, {}, progress);
  } catch (const UndeterminedError& error) {
    row.exit_code = 4;
    row.message = error.what();
    return row;
  } catch (const InputError& error) {
    row.exit_code = 3;
    row.message = error.what();
    return row;
  }
  row.exit_code = result.accepted() ? 0 : 1;
  std::vector<std::string> said;
  if (!result.accepted()) said = result.assessment.reasons;
  said.insert(said.end(), result.warnings.begin(), result.warnings.end());
  row.message = Joined(said);
  FillComparison(block, plan.options, result, progress, &row);
  row.outcome = JudgeStability(row, said);
  return row;
}

}  // namespace sarblock
