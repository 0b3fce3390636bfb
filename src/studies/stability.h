// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/progress.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"
#include "sarblock/simulate/scene.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/problem.h"
#include "study.h"
#include "tables/toml.h"
#include <Eigen/Core>

namespace sarblock {

/// One pass of a block of the stability study; it looks at the middle of the area.
struct PlannedPass {
  LookSide side = LookSide::kLeft;
  double heading_rad = 0.0;     ///< of the flight, from x or east towards north
  double ground_range_m = 0.0;  ///< from below the antenna to the middle of the area
  double height_m = 0.0;        ///< of the antenna above the middle of the area
  double squint_rad = 0.0;
  double range_sigma_factor = 1.0;
};

/// A small block by its geometry and weights, with noise of its own standard deviations.
struct StabilityPlan {
  bool orbit =
      false;  ///< circular orbits about a body that does not turn, geocentric; else straight
  double body_radius_m = 0.0;  ///< orbit: radius of a sphere; 0: WGS84
  std::vector<PlannedPass> passes;
  std::size_t points = 10;
  double along_m = 3900.0, across_m = 3900.0;  ///< half the area, along x or east and across it
  double relief_m = 640.0;
  double speed_mps = 173.4;
  double swing_m = 5.3;               ///< of the antenna about its straight line
  double doppler_wavelength_m = 0.0;  ///< > 0: the cone is written as a Doppler centroid
  LookSigma sigma{0.83, 1.21, AzimuthUnit::kMetres};
  double noise = 1.0;  ///< drawn, in standard deviations
  std::vector<std::size_t> control_points;
  std::array<double, 3> control_sigma_m{};  ///< east, north, up
  double control_correlation = 0.0;         ///< of east and north
  double control_spread = 1.0;              ///< < 1: control points drawn together about the middle
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();  ///< added to all coordinates (not orbit)
  double time_origin_s = 391.7;
  std::size_t states = 41;     ///< of a path that is not recorded, and of the planned flight
  double time_margin_s = 0.0;  ///< by which paths are longer at either end
  /// The flight is recorded with errors, at a rate that is needed, and its looks are those of the
  /// true flight, which has trajectory errors.
  std::optional<SceneRecorder> recorder;
  SceneTrajectoryError trajectory_error;
  double strip_factor = 0.0;   ///< > 0: strip spans given, this many times the looks' own
  double start_error_m = 0.0;  ///< > 0: points get start coordinates this far off
  double blunder = 0.0;        ///< added to the first range, in standard deviations
  double path_error_m = 0.0;   ///< by which the first pass is shifted in all axes
  AdjustOptions options;
  std::uint64_t seed = 1978;

  [[nodiscard]] bool IsControl(std::size_t point) const;
};

/// The id of a pass of the block, "A1" for index 0.
[[nodiscard]] std::string StabilityPassId(std::size_t pass);

/// Throws InputError where a pass of the plan cannot see its area.
[[nodiscard]] Block MakeStabilityBlock(const StabilityPlan& plan);

/// `count` values from `from` to `to` with equal ratios.
[[nodiscard]] std::vector<double> Ratios(double from, double to, int count);

/// A family of small blocks that one number pushes from comfortable to impossible.
struct StabilityFamily {
  std::string name;       ///< "intersection-angle"
  std::string parameter;  ///< what the number is, with its unit: "angle_deg"
  std::string about;      ///< one sentence for people
  std::vector<double> values;
  bool whole = false;  ///< the number counts something
  std::function<StabilityPlan(double value)> plan;
};

/// The families of the program, in the order they are run, with the values they are run with by
/// default (datasets/studies/stability_families.toml).
[[nodiscard]] const std::vector<StabilityFamily>& StabilityFamilies();

/// The text of that file, "stability_families.toml", which is compiled into the program.
[[nodiscard]] std::string_view FamiliesText(std::string_view name);

/// The text of a study, from which the plan of a family is read anew for each value.
struct FamilyText {
  std::string text, file;
  std::vector<std::string> overrides;

  [[nodiscard]] toml::table Parsed() const;
};

/// The family of a study's `[[family]]` number `index`, from 0, whose block it says itself. Throws
/// InputError with FILE:LINE: field for all that is wrong at any of its values.
[[nodiscard]] StabilityFamily FamilyOfStudy(SceneTable* table,
                                            std::size_t index,
                                            const std::shared_ptr<const FamilyText>& study);

/// Outcome for one block.
enum class StabilityOutcome {
  kOk,       ///< accepted without a warning, and right
  kWarned,   ///< not accepted, or with a warning; where digits are missing the warning says so
  kRefused,  ///< exit code 3 or 4 with words
  kWrong,    ///< claims more than it has
};
[[nodiscard]] const char* NameOf(StabilityOutcome outcome);  ///< "ok", "warned", ...

/// A result whose sigmas and 3 x 3 covariances have fewer digits than this is wrong unless it warns
/// of that itself,
inline constexpr double kMinDigits = 6.0;
/// and one whose positions or corrections are off by more than this part of their sigma.
inline constexpr double kMaxError = 1e-3;

/// One step of a family: the production adjustment compared with the same one in 50 digits. Digits
/// are -log10 of the largest relative error, 0 to 16; NaN where there is no result or nothing to
/// compare with.
struct StabilityRow {
  std::string family, parameter;
  double value = 0.0;                                           ///< of the parameter
  double condition = std::numeric_limits<double>::quiet_NaN();  ///< of the column-scaled Jacobian
  StabilityOutcome outcome = StabilityOutcome::kRefused;
  int exit_code = 0;
  /// Digits of the worst 3 x 3 covariance of a point (Frobenius norm).
  double covariance_digits = std::numeric_limits<double>::quiet_NaN();
  double sigma_digits = std::numeric_limits<double>::quiet_NaN();  ///< points and corrections
  /// Digits of the worst position, relative to its shortest slant range.
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

/// The outcome of a row whose other fields are filled in. Missing digits count as warned of if a
/// warning is about convergence, weak directions, open directions or rounding; a warning that
/// points were left out says nothing of the others.
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
