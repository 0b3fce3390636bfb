// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/simulate/scene.h"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "study.h"
#include "tradeoff.h"

namespace sarblock {

/// Rows that a size does without.
struct TradeoffSkip {
  std::vector<std::string> rows;  ///< "STAGE" or "STAGE.CHOICE"
  std::string reason;             ///< for people, in the row's note
};

/// One size of the scene that choices are measured on.
struct TradeoffSize {
  std::size_t points = 0;  ///< how it is called; `set` of the file makes it so
  int repeats = 0;         ///< 0: the study's
  double longest_s = std::numeric_limits<double>::infinity();  ///< TradeoffRepeats
  std::vector<TradeoffSkip> skips;
  Scene scene;
};

/// A choice before it is bound to a block.
struct TradeoffEntry {
  TradeoffChoice choice;  ///< options not filled
  bool reference = false;
  std::size_t most_points = std::numeric_limits<std::size_t>::max();  ///< not run above
  std::string reason;                                                 ///< why not above, for people
  int threads = 0;                                                    ///< 0: those of the session
  int repeats = 0;                                                    ///< 0: the size's
  std::vector<std::string> set;  ///< overrides of the scene's `[adjust]`, KEY=VALUE

  /// Threads that it gets in a session with so many.
  [[nodiscard]] int ThreadsOf(int session) const;
};

/// STUDY.toml of `study tradeoff` (docs/studies.md).
struct TradeoffStudy {
  std::filesystem::path scene_file;
  StudyHeading heading;
  int repeats = 5;
  TradeoffClock clock = TradeoffClock::kWall;
  TradeoffGoal goal;
  std::vector<TradeoffSize> sizes;
  std::vector<TradeoffEntry> choices;
  std::string identity;  ///< the effective text of the study and of its scene
  /// What is measured of it: "STAGE" or "STAGE.CHOICE", and sizes; empty: all.
  std::vector<std::string> only;
  std::vector<std::size_t> only_points;

  /// The reference of a stage; every stage with a choice has one.
  [[nodiscard]] const TradeoffEntry& ReferenceOf(TradeoffStage stage) const;
  /// True where the row is asked for.
  [[nodiscard]] bool Wants(const TradeoffEntry& entry, std::size_t points) const;
  /// Why the row is not run at this size; empty: it is.
  [[nodiscard]] std::string WhyNotRun(const TradeoffEntry& entry, const TradeoffSize& size) const;
};

/// Reads a study; `overrides` are KEY=VALUE with dotted keys. Throws InputError with file, line and
/// key for everything that is not allowed.
[[nodiscard]] TradeoffStudy ReadTradeoffStudy(const std::filesystem::path& file,
                                              const std::vector<std::string>& overrides = {});

/// The same from text; `file` names it in messages, `scene_text` gives the text of a scene by the
/// name that the study gives.
[[nodiscard]] TradeoffStudy ParseTradeoffStudy(
    std::string_view text,
    const std::string& file,
    const std::vector<std::string>& overrides,
    const std::function<std::string(const std::string& name)>& scene_text);

/// Keys of the study file with their dotted names, for `--set`, lists by their first element.
[[nodiscard]] std::vector<std::string> TradeoffKeys();

/// The choice with the options it has on a block of the scene.
[[nodiscard]] TradeoffChoice BindChoice(const TradeoffEntry& entry,
                                        const Scene& scene,
                                        const Block& block,
                                        int threads);

/// The rows as a Markdown page: a recommendation and a table for every size, rows of the Pareto set
/// in bold. Sizes ascending, stages in their order, rows as given.
[[nodiscard]] std::string TradeoffPage(const std::vector<TradeoffRow>& rows,
                                       const TradeoffGoal& goal);

/// Sizes of the rows, ascending, each once.
[[nodiscard]] std::vector<std::size_t> SizesOf(const std::vector<TradeoffRow>& rows);

}  // namespace sarblock
