// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/model/result.h"

#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "model/problem.h"
#include "stability_plan.h"
#include "study.h"

namespace sarblock {

/// What came of one block.
enum class StabilityOutcome {
  kOk,       ///< accepted without a warning, and right
  kWarned,   ///< not accepted, or with a warning; where digits are missing the warning says so
  kRefused,  ///< exit code 3 or 4 with words
  kWrong,    ///< claims more than it has
};
[[nodiscard]] const char* NameOf(StabilityOutcome outcome);  ///< "ok", "warned", ...

/// A result whose sigmas and 3 x 3 covariances have fewer digits than this is wrong unless it says
/// so itself,
inline constexpr double kMinDigits = 6.0;
/// and one whose positions or corrections are off by more than this part of their sigma.
inline constexpr double kMaxError = 1e-3;

/// One step of a family: the production adjustment beside the same one in 50 digits. Digits are
/// -log10 of the largest relative error, 0 to 16; NaN where there is no result or nothing to
/// compare with.
struct StabilityRow {
  std::string family, parameter;
  double value = 0.0;                                           ///< of the parameter
  double condition = std::numeric_limits<double>::quiet_NaN();  ///< of the column-scaled Jacobian
  StabilityOutcome outcome = StabilityOutcome::kRefused;
  int exit_code = 0;
  /// Of the worst 3 x 3 covariance of a point (Frobenius).
  double covariance_digits = std::numeric_limits<double>::quiet_NaN();
  double sigma_digits = std::numeric_limits<double>::quiet_NaN();  ///< points and corrections
  /// Of the worst position, relative to its shortest slant range.
  double position_digits = std::numeric_limits<double>::quiet_NaN();
  /// Largest error of a position, sqrt(e' Q^-1 e), or of a correction, in sigmas.
  double error_sigma = std::numeric_limits<double>::quiet_NaN();
  /// Covariance digits by other ways: all normal equations in double and in single precision, and
  /// engine and covariance method "ceres".
  double normal_digits = std::numeric_limits<double>::quiet_NaN();
  double single_digits = std::numeric_limits<double>::quiet_NaN();
  double ceres_digits = std::numeric_limits<double>::quiet_NaN();
  std::string message;  ///< the words of a refusal, the warnings, or why nothing was compared
};

/// The outcome of a row whose other fields are filled in. Warnings count as said where they speak
/// of convergence, of weak directions, of open directions or of rounding: that points were left out
/// says nothing of the others.
[[nodiscard]] StabilityOutcome JudgeStability(const StabilityRow& row,
                                              const std::vector<std::string>& warnings);

/// Runs one step. Throws Interrupted where `progress` is cancelled during an adjustment.
[[nodiscard]] StabilityRow RunStabilityStep(const StabilityFamily& family,
                                            double value,
                                            int threads,
                                            ProgressSink* progress = nullptr);

/// Covariances of points by the textbook's way: all normal equations J'J of points and corrections,
/// scaled to unit diagonal, a Cholesky factor and its inverse, in double or in single precision.
/// Empty where the matrix has no factor.
enum class Precision { kSingle, kDouble };
[[nodiscard]] std::vector<SymmetricEnu> CovariancesByNormals(const AdjustmentProblem& problem,
                                                             const BlockState& state,
                                                             Precision precision);

/// Largest relative error of a 3 x 3 block in Frobenius' norm; infinite where one is missing.
[[nodiscard]] double CovarianceError(const std::vector<SymmetricEnu>& computed,
                                     const std::vector<SymmetricEnu>& exact);

/// Families with the values they are to be run with (docs/studies.md).
struct StabilityStudy {
  StudyHeading heading;
  std::vector<StabilityFamily> families;
};

/// Columns of stability.csv (docs/studies.md).
[[nodiscard]] const std::vector<StudyColumn>& StabilityColumns();

/// The study as tasks, one per step.
[[nodiscard]] StudyPlan PlanStability(const StabilityStudy& study);

/// In sentences: how often each outcome came, in all and by family; the worst of the rows that are
/// ok; digits of each method by the condition; every row that is wrong.
[[nodiscard]] std::vector<std::string> DescribeStability(const StabilityStudy& study,
                                                         const StudyTable& table);

/// Reads a stability study (docs/studies.md): `families` lists names, each with the values it has
/// by default; `[[family]]` gives `name` and `values`, or with `block` a family of the study's own.
/// Without either: all families. Throws InputError with FILE:LINE: field for syntax, unknown keys,
/// wrong types, families that do not exist or are given twice, values outside the range a family
/// has by default, and families of its own that are no blocks.
[[nodiscard]] StabilityStudy ReadStability(const std::filesystem::path& path,
                                           const std::vector<std::string>& overrides = {});

/// The same from text; `file` is its name in messages.
[[nodiscard]] StabilityStudy ParseStability(std::string_view text,
                                            const std::string& file,
                                            const std::vector<std::string>& overrides = {});

/// Dotted keys that overrides may name.
[[nodiscard]] std::vector<std::string> StabilityKeys();

}  // namespace sarblock
