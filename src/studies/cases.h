// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/core/error.h"
#include "sarblock/core/progress.h"
#include "sarblock/core/statistics.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"
#include "sarblock/simulate/scene.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "study.h"
#include "tables/toml.h"
#include <Eigen/Core>

namespace sarblock {

/// The blocks of a study over scenes: axes of values and listed cases, and their scenes and options
/// (docs/studies.md).

/// Most cases of one study, listed and as products.
inline constexpr std::size_t kMaxStudyCases = 10000;

/// One block of a study.
struct StudyCase {
  std::string layout;   ///< of its control, "corners", ...; "none" without any
  std::string variant;  ///< its other choices, "tie strips: none"; may be empty
  Scene scene;
  AdjustOptions adjust;
};

/// What one value of an axis, or a listed case, changes in the scene.
struct CaseChoice {
  std::string label;  ///< empty: not given (control layout and count have columns of their own)
  std::optional<std::string> scene;
  std::optional<std::vector<std::string>> flights;
  std::vector<std::string> set;
  FilePlace place;
  std::string value;  ///< of an axis: the value, its label or the name of the case
  double number =
      kNotGiven;  ///< of a value that is a number or a list of one, of a case its `number`

  /// Appends the changes of another choice.
  void Add(const CaseChoice& other);
};

/// One [[axis]]: its values, by `key` or several `keys` that take the same one, or its cases.
struct CaseAxis {
  std::string name;
  std::vector<CaseChoice> choices;
};
[[nodiscard]] CaseAxis ReadAxis(SceneTable table);

/// `set`, `scene` and `flights` of a table.
[[nodiscard]] CaseChoice TakeChanges(SceneTable* table);

/// The product of the axes, the last one fastest. Throws InputError at `place` for more than
/// kMaxStudyCases.
[[nodiscard]] std::vector<CaseChoice> Product(const CaseChoice& base,
                                              const std::vector<CaseAxis>& axes,
                                              const FilePlace& place);

/// Makes cases of choices: reads each scene once, applies the overrides, checks. What cannot be
/// predicted (corrections = "auto", ...) is refused.
class CaseMaker {
 public:
  /// `file` is the study's name for messages, `scene_text` gives the text of a scene by the name
  /// that the study gives.
  CaseMaker(std::string file, std::function<std::string(const std::string&)> scene_text)
      : file_(std::move(file)), scene_text_(std::move(scene_text)) {}

  /// Texts of the scenes so far, by name.
  [[nodiscard]] const std::map<std::string, std::string>& texts() const { return texts_; }
  [[nodiscard]] StudyCase Make(const CaseChoice& choice);

 private:
  [[nodiscard]] StudyCase MakeUnnamed(const CaseChoice& choice);

  std::string file_;
  std::function<std::string(const std::string&)> scene_text_;
  std::map<std::string, std::string> texts_;
};

/// Whether the block of a row was determined (column `determined`).
[[nodiscard]] bool IsDetermined(const StudyTable& table, std::size_t row);

/// The scene's block as planned: paths as planned, looks at the nominal times, nothing measured.
[[nodiscard]] SimulatedBlock PlannedBlock(const Scene& scene);

/// Predictions of a study compared with drawn and adjusted blocks (docs/studies.md).

/// Monte Carlo verification of some cases of a study.
struct VerificationOptions {
  int runs = 0;           ///< of each case verified; 0: none
  std::size_t every = 1;  ///< the first case and every so many after it
  double level = 0.99;    ///< simultaneous level of all bounds if the predictions are right
  /// Standard deviations from which flight path and measurement errors are drawn: those of the
  /// corrections' priors, which a prediction assumes, or of the scene's [navigation].
  enum class Navigation { kPriors, kScene };
  Navigation navigation = Navigation::kPriors;

  /// Whether a case is verified.
  [[nodiscard]] bool Covers(std::size_t index) const { return runs > 0 && index % every == 0; }
  /// Level of one bound where those of a study of so many cases hold together at `level` (Sidak).
  [[nodiscard]] double LevelOfOne(std::size_t cases) const;
};

/// Table [verify] of a study. Throws InputError naming the key.
[[nodiscard]] VerificationOptions ReadVerification(SceneTable& table);

/// Points that a study counts: solved and not control.
[[nodiscard]] std::vector<std::uint32_t> PointsCounted(const Block& block,
                                                       const PointResults& points);

/// Navigation errors with the standard deviations of the priors, as a prediction assumes them.
/// Throws InputError for priors of kinds that a scene cannot draw (splines, frame axes, degrees
/// above 2, velocity, troposphere, single passes). What has no prior is drawn as in `scene`.
[[nodiscard]] SceneNavigation NavigationFromPriors(const AdjustOptions& options,
                                                   const SceneNavigation& scene);

/// Errors of adjustments of drawn blocks against a predicted covariance.
struct Verification {
  int runs = 0;                   ///< compared
  int failed = 0;                 ///< not converged, or a point not solved
  std::string why;                ///< of the first that failed
  std::array<double, 3> rms_m{};  ///< along the axes, over all points and runs
  double nees = 0.0;              ///< mean of e' Q^-1 e / 3
  Interval bound;                 ///< that holds nees with probability `level`
};

/// Rows: three directions at a point, in east, north and up, along which its errors are counted.
using ErrorAxes = std::function<Eigen::Matrix3d(std::uint32_t point)>;

/// Draws noise, paths and control `runs` times about the same nominal block, adjusts each draw and
/// compares. Points without coordinates of their own start where they are planned, because the
/// covariance is verified and not the start values. Runs go side by side; the result does not
/// depend on the number of threads. The bound is that of a chi-square with runs times
/// SquareFreedom() degrees over these degrees: points of one run are correlated, runs are not.
/// Without `axes` errors are counted east, north and up.
[[nodiscard]] Verification Verify(const Scene& scene,
                                  const SimulatedBlock& simulated,
                                  const AdjustOptions& options,
                                  const AdjustResult& predicted,
                                  int runs,
                                  std::uint64_t seed,
                                  double level,
                                  ProgressSink* progress,
                                  const ErrorAxes& axes = {});

/// The scene whose draws a case is verified with: its paths as the options say.
[[nodiscard]] Scene SceneToDraw(const StudyCase& of, const VerificationOptions& options);

/// Refuses cases that are verified and cannot be drawn; InputError as NavigationFromPriors().
void CheckVerification(const VerificationOptions& options, const std::vector<StudyCase>& cases);

/// Sets runs, nees, its bounds, agrees, montecarlo_rms_AXIS_m by the names of the axes, and the
/// message where runs failed.
void SetVerification(const Verification& verified,
                     const std::array<std::string, 3>& axes,
                     StudyRowMaker* row);

/// A sentence on the verified rows of a table, none without such; `name_of` names a row.
[[nodiscard]] std::vector<std::string> DescribeVerification(
    const VerificationOptions& options,
    const StudyTable& table,
    const std::function<std::string(std::size_t row)>& name_of);

}  // namespace sarblock
