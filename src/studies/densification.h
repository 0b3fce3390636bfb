// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/result.h"

#include <array>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "cases.h"
#include "placement.h"
#include "study.h"

namespace sarblock {

/// Accuracy of a block in a few numbers [m]; axes east, north, up.
struct Accuracy {
  std::array<double, 3> median_sigma_m{};
  std::array<double, 3> rms_sigma_m{};
  double median_sigma_h_m = 0.0;
  double max_sigma_h_m = 0.0;
  double max_sigma_u_m = 0.0;
  double median_distance_m = 0.0;  ///< of neighbours; NaN without any
  std::array<double, 3> median_difference_sigma_m{};
};

/// Covariances of points and of differences of neighbours, with the distances of those.
[[nodiscard]] Accuracy SummariseAccuracy(const std::vector<SymmetricEnu>& points_m2,
                                         const std::vector<SymmetricEnu>& differences_m2,
                                         const std::vector<double>& distances_m);

[[nodiscard]] double MedianOf(std::vector<double> values);  ///< NaN of none

/// How much control a block needs, and where (docs/studies.md).

/// Greedy placement on one block, improved by exchanging its points one by one.
struct PlacementCase {
  enum class Candidates { kTie, kCheck, kAll };
  enum class Exchange { kOn, kOff };
  StudyCase start;
  PlacementCriterion criterion = PlacementCriterion::kMeanVariance;
  std::size_t count = 4;                     ///< control points to add
  Candidates candidates = Candidates::kTie;  ///< kCheck: the scene's check points, a grid if wanted
  Exchange exchange = Exchange::kOn;         ///< of the points placed, once all are there
  std::array<double, 3> sigma_m{};           ///< e, n, u of an added point, > 0
};

struct DensificationGoal {
  double sigma_h_m = kNotGiven;  ///< not given: any
  double sigma_u_m = kNotGiven;
  enum class Of { kWorstPoint, kMedian };
  Of of = Of::kWorstPoint;
};

struct DensificationStudy {
  StudyHeading heading;
  std::vector<StudyCase> cases;
  std::vector<PlacementCase> placements;
  VerificationOptions verify;
  DensificationGoal goal;
};

/// The study as tasks: one a case, then one a placement, whose rows are the steps. Columns in
/// docs/studies.md. `study` must outlive the plan.
///
/// A case is predicted with Predict() at the true positions, times and ranges of the nominal paths:
/// geometry and weights alone. Verified, it is then drawn and adjusted `runs` times (Redraw,
/// Adjust) and the errors are compared with the predicted covariance. Points counted are those that
/// are not control; sigma_h is sqrt(sigma_e^2 + sigma_n^2). A block that cannot be determined gives
/// a row with determined 0 and the reason as message.
[[nodiscard]] StudyPlan PlanDensification(const DensificationStudy& study);

/// Columns of densification.csv (docs/studies.md).
[[nodiscard]] const std::vector<StudyColumn>& DensificationColumns();

/// Summary of the table in sentences: the smallest layout that reaches the goal, for each variant;
/// where the next points help most; whether the verified rows agree.
[[nodiscard]] std::vector<std::string> DescribeDensification(const DensificationStudy& study,
                                                             const StudyTable& table);

/// A densification study as read, every case's scene and options made and checked.
struct DensificationFile {
  DensificationStudy study;
  std::string identity;  ///< the study's effective text and those of its scenes
};

/// Reads a study (docs/studies.md). `overrides` are `KEY=VALUE` as for a scene. Throws InputError
/// with FILE:LINE: field for syntax, unknown keys, wrong types and values, and for a case whose
/// scene or [adjust] cannot be made, naming the case.
[[nodiscard]] DensificationFile ReadDensification(const std::filesystem::path& path,
                                                  const std::vector<std::string>& overrides = {});

/// The same from text; `file` names it in messages, `scene_text` gives the text of a scene by the
/// name that the study gives.
[[nodiscard]] DensificationFile ParseDensification(
    std::string_view text,
    const std::string& file,
    const std::vector<std::string>& overrides,
    const std::function<std::string(const std::string& name)>& scene_text);

/// Keys of the study file with their dotted names, for `--set`: those outside its lists of tables
/// and those of the first [[placement]]; those of the scene inside `set` not among them.
[[nodiscard]] std::vector<std::string> DensificationKeys();

}  // namespace sarblock
