// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "cases.h"
#include "study.h"

namespace sarblock {

/// Design studies: one or two keys of a scene are swept, each block is predicted, and the accuracy
/// is compared with goals and with what the block costs (docs/studies.md).

/// What a block costs; a price that is not given counts nothing.
struct DesignPrices {
  std::string currency;  ///< for people; may be empty
  double pass = 0.0;
  double kilometre = 0.0;  ///< of flight, within the strips
  double control_point = 0.0;
  [[nodiscard]] bool Given() const { return pass > 0.0 || kilometre > 0.0 || control_point > 0.0; }
};

/// At most this value of a column of the table: a median or largest sigma, or the cost.
struct DesignGoal {
  std::string column;
  double limit = 0.0;
};

/// One [[axis]] of the study, for its matrix and curves.
struct DesignAxis {
  std::string name;
  std::vector<std::string> values;  ///< as the table shows them
};

struct DesignStudy {
  StudyHeading heading;
  std::vector<DesignAxis> axes;  ///< one or two
  /// By axes, the last one fastest, and their choices of each axis.
  std::vector<StudyCase> cases;
  std::vector<std::vector<CaseChoice>> choices;
  std::vector<DesignGoal> goals;
  DesignPrices prices;
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
/// solved and not control. A block that cannot be made or determined gives a row with determined 0
/// and the reason as message. `study` must outlive the plan.
[[nodiscard]] StudyPlan PlanDesign(const DesignStudy& study);

/// The column by which accuracy is traded for cost and the matrix is shown: the first that is a
/// goal, of the worst point up, across and along, then of the median; without one max_sigma_up_m.
[[nodiscard]] std::string DesignQuantity(const DesignStudy& study);

/// The table with `pareto`: 1 where no other case costs as little or less and is as accurate or
/// more (one of both really); empty without prices.
[[nodiscard]] StudyTable MarkPareto(const DesignStudy& study, const StudyTable& table);

/// Of a table with `pareto`. For a terminal: the matrix of two axes or the table of one, and the
/// cases of the Pareto set by cost, in lines of at most 80 columns where labels allow.
[[nodiscard]] std::vector<std::string> DesignTables(const DesignStudy& study,
                                                    const StudyTable& table);

/// In sentences: how many cases reach all goals and the cheapest of them, or the nearest, with its
/// numbers beside the goals; the case that is best; how many give no block.
[[nodiscard]] std::vector<std::string> DescribeDesign(const DesignStudy& study,
                                                      const StudyTable& table);

}  // namespace sarblock
