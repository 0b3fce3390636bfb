// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cases.h"
#include "study.h"

namespace sarblock {

/// Design studies: one or two keys of a scene are swept, each block is predicted, and the accuracy
/// is compared with goals and with what the block costs (docs/studies.md).

/// Prices that make up the cost of a block; a price that is not given is 0.
struct DesignPrices {
  std::string currency;  ///< for people; may be empty
  double pass = 0.0;
  double kilometre = 0.0;  ///< of flight, within the strips
  double control_point = 0.0;
  [[nodiscard]] bool Given() const { return pass > 0.0 || kilometre > 0.0 || control_point > 0.0; }
};

/// At most this value of a column of the table: a median or largest sigma, that of a difference, or
/// the cost.
struct DesignGoal {
  std::string column;
  double limit = 0.0;
};

/// One [[axis]] of the study, for its matrix and curves.
struct DesignAxis {
  std::string name;
  std::vector<std::string> values;  ///< as the table shows them
};

/// Directions of the accuracy, in the order of all arrays of three.
inline constexpr std::array<const char*, 3> kDesignDirections = {"along", "across", "up"};

/// Table [law]: the accuracy as a power of what an axis sweeps, sigma = c x^p (design_law.h).
struct DesignLaw {
  enum class Part {
    kPaths,  ///< what the paths add to the noise of a point's own looks
    kAll,
  };
  std::size_t axis = 0;  ///< all its values have numbers above 0
  Part part = Part::kPaths;
  /// Exponents along, across and up that theory gives, by the values of the other axis (without
  /// one: a single entry); NaN where it gives none.
  std::vector<std::array<double, 3>> derived;
};

struct DesignStudy {
  StudyHeading heading;
  std::vector<DesignAxis> axes;  ///< one or two
  /// By axes, the last one fastest, and their choices of each axis.
  std::vector<StudyCase> cases;
  std::vector<std::vector<CaseChoice>> choices;
  std::vector<DesignGoal> goals;
  double difference_m = kNotGiven;  ///< distance over which differences are predicted
  DesignPrices prices;
  VerificationOptions verify;
  std::optional<DesignLaw> law;
};

/// A design study as read, every case's scene and options made and checked.
struct DesignFile {
  DesignStudy study;
  std::string identity;  ///< the study's effective text and those of its scenes
};

/// Reads a study; `overrides` are `KEY=VALUE`. Throws InputError with FILE:LINE: field for syntax,
/// unknown keys, wrong types and values, for no axis or more than two, and for a case that cannot
/// be made.
[[nodiscard]] DesignFile ReadDesign(const std::filesystem::path& path,
                                    const std::vector<std::string>& overrides = {});

/// The same from text; `file` names it in messages, `scene_text` gives the text of a scene by the
/// name that the study gives.
[[nodiscard]] DesignFile ParseDesign(
    std::string_view text,
    const std::string& file,
    const std::vector<std::string>& overrides,
    const std::function<std::string(const std::string& name)>& scene_text);

/// Keys of the study file with their dotted names, for `--set`.
[[nodiscard]] std::vector<std::string> DesignKeys();

/// Columns of design.csv.
[[nodiscard]] const std::vector<StudyColumn>& DesignColumns();

/// One task a case: the scene's block as planned is predicted with Predict(). Along and across are
/// by the track of the first pass that sees a point, level; points counted are those that are
/// solved and not control. The part of the paths is the covariance less that with paths known
/// exactly (PointLinearization); empty without corrections. Verified cases are drawn and adjusted
/// (Verify), errors counted along, across and up. A block that cannot be made or determined gives a
/// row with determined 0 and the reason as message. `study` must outlive the plan.
[[nodiscard]] StudyPlan PlanDesign(const DesignStudy& study);

/// The column used as accuracy in the Pareto set and the matrix: the first that is a goal among up,
/// across and along of the worst point, then of the median; without a goal max_sigma_up_m.
[[nodiscard]] std::string DesignQuantity(const DesignStudy& study);

/// The table with `pareto`: 1 where no other case is at most as expensive and at least as accurate,
/// and better in one of the two; empty without prices.
[[nodiscard]] StudyTable MarkPareto(const DesignStudy& study, const StudyTable& table);

/// Text for a terminal from a table with `pareto`: the matrix of two axes or the table of one, and
/// the cases of the Pareto set by cost, in lines of at most 80 columns where labels allow.
[[nodiscard]] std::vector<std::string> DesignTables(const DesignStudy& study,
                                                    const StudyTable& table);

/// Index of each axis' choice in a case.
[[nodiscard]] std::vector<std::size_t> DesignPlaces(const DesignStudy& study, std::size_t index);

/// Summary in sentences: how many cases reach all goals and the cheapest of them, or the nearest,
/// with its numbers and the goals; the best case; how many cases give no block; whether drawn
/// errors agree.
[[nodiscard]] std::vector<std::string> DescribeDesign(const DesignStudy& study,
                                                      const StudyTable& table);

}  // namespace sarblock
