// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"
#include "sarblock/geometry/path.h"
#include "sarblock/model/options.h"
#include "sarblock/model/result.h"
#include "sarblock/simulate/scene.h"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "study.h"
#include <Eigen/Core>

namespace sarblock {

/// The study of speed against accuracy (docs/studies/tradeoff.md): what a user can choose, one
/// stage at a time, each choice compared with the reference of its stage on blocks of known truth.
enum class TradeoffStage { kModel, kSolver, kCovariance };
[[nodiscard]] const char* NameOf(TradeoffStage stage);  ///< "model", "solver", ...

/// How speed is measured. CPU time, of all threads, is for a machine that does other work too; it
/// does not show the gain by threads.
enum class TradeoffClock { kWall, kCpu };
[[nodiscard]] const char* NameOf(TradeoffClock clock);  ///< "wall", "cpu"

/// One row to measure.
struct TradeoffChoice {
  enum class Run {
    kAdjust,     ///< Adjust() with `options`
    kIntersect,  ///< IntersectBlock(): all looks of a point, flight paths fixed
    kTwoLooks,   ///< the same of the two looks of each point that intersect best
  };
  TradeoffStage stage = TradeoffStage::kModel;
  std::string name;
  Run run = Run::kAdjust;
  AdjustOptions options;  ///< threads included
  /// kAdjust: how the recorded flights are read, the time of it included; nothing: as they are in
  /// the block, before the clock runs.
  std::optional<PathThrough> through;
};

/// Result of a choice for the points of a block.
struct TradeoffAnswer {
  std::vector<Eigen::Vector3d> position_m;  ///< by point, frame axes; NaN where it has none
  std::vector<SymmetricEnu> covariance_m2;  ///< by point; empty: none
  /// Standard deviations across and up of the closed form, and the direction of across clockwise
  /// from north; empty with any other covariance.
  std::vector<double> sigma_across_m, sigma_up_m, across_azimuth_rad;
  bool accepted = false;
  int iterations = 0;
  std::size_t corrections = 0;  ///< parameters of the passes
  std::string note;             ///< for people: what was chosen, why not accepted
};

/// Errors of an answer relative to the best one and to the truth, over the tie points.
struct AnswerErrors {
  double position_error = kNotGiven;   ///< largest sqrt(d' Q^-1 d), Q of the best answer
  double position_median = kNotGiven;  ///< median of the same
  /// Largest |C - Q| / |Q| (Frobenius) of a 3 x 3; of a closed form that of its diagonal 2 x 2
  /// across and up against the same part of Q. NaN without covariance.
  double covariance_error = kNotGiven;
  double covariance_median = kNotGiven;
  double rms_error_m = kNotGiven;  ///< root mean square length of the errors against the truth
  /// Mean of e' C^-1 e over its dimension, e the errors against the truth: 1 where C is realistic.
  double nees = kNotGiven;
  std::size_t points_missing = 0;   ///< that have a position in the best answer alone
  std::size_t points_unjudged = 0;  ///< that have a position here but no covariance
};
[[nodiscard]] AnswerErrors CompareAnswers(const Block& block,
                                          const TradeoffAnswer& answer,
                                          const TradeoffAnswer& best,
                                          const std::vector<Eigen::Vector3d>& truth_m);

/// A row of tradeoff.csv.
struct TradeoffRow {
  TradeoffStage stage = TradeoffStage::kModel;
  std::string choice;
  std::size_t points = 0;  ///< asked for of the scene
  std::size_t looks = 0;
  std::size_t corrections = 0;  ///< parameters of the passes
  int threads = 1;              ///< that it might use
  double wall_s = kNotGiven;    ///< median of the runs, of the whole call
  double cpu_s = kNotGiven;     ///< the same, of all threads
  /// Largest resident memory of the run above that of the process before (block, truth, answers to
  /// compare with); median. NaN if the system does not give it.
  double peak_mib = kNotGiven;
  TradeoffClock clock = TradeoffClock::kWall;  ///< of the speeds
  double speed_ratio = kNotGiven;  ///< reference / this: median over pairs of neighbouring runs
  double speed_low = kNotGiven;    ///< smallest and largest of these ratios
  double speed_high = kNotGiven;
  int repeats = 0;  ///< 0: not run, for the reason that `note` has
  int iterations = 0;
  bool accepted = false;
  bool reference = false;
  bool pareto = false;
  AnswerErrors errors;
  std::string note;
};

/// Differences that do not count when rows are compared: times of repeated runs differ by as much,
/// and below the step of 1e-6 sigmas that the solver may leave errors have no meaning.
inline constexpr double kSameSpeed = 0.1;      ///< of the ratio
inline constexpr double kSamePosition = 1e-6;  ///< sigmas
inline constexpr double kSameCovariance = 1e-6;

/// Marks in each stage of each size the rows that no other beats: none is faster without being less
/// accurate in position or covariance, nor more accurate without being slower. A row without the
/// covariance of every point counts as the worst of all in covariance; rows that are not accepted
/// or lack points are not marked and beat no other row.
void MarkPareto(std::vector<TradeoffRow>* rows);

/// Newton decrement of the best answer, in sigmas over all unknowns.
inline constexpr double kBestTolerance = 1e-9;

/// Accuracy that suffices for a recommendation.
struct TradeoffGoal {
  double position_error = 0.1;     ///< largest shift, in sigmas
  double covariance_error = 0.05;  ///< largest relative error of a 3 x 3
};
/// One sentence a size: the fastest solver and covariance that are on the Pareto set and good
/// enough, with the time of the adjustment and its threads; then, for comparison, gains and losses
/// of the row `leberl` of the models; for a study of models alone the fastest of them that is good
/// enough. "100000 points: reduced, double, block: 0.30 s on 2 threads, ...; leberl is 40 times
/// faster, ...".
[[nodiscard]] std::string Recommend(const std::vector<TradeoffRow>& rows,
                                    std::size_t points,
                                    const TradeoffGoal& goal);

/// The row of a choice that is left out of a size.
[[nodiscard]] TradeoffRow NotRun(const TradeoffChoice& choice,
                                 std::size_t points,
                                 TradeoffClock clock,
                                 const std::string& reason);

/// Number of runs of a choice.
struct TradeoffRepeats {
  int repeats = 5;  ///< at most
  /// Wall time of all runs of the row, including those of the reference, after which no run is
  /// started except the reference that belongs to the last one.
  double longest_s = std::numeric_limits<double>::infinity();
};

/// A simulated block to measure choices on. Holds its own copies.
class TradeoffBench {
 public:
  /// Solves the block once with `reference`, to kBestTolerance instead of its own: the best
  /// answer.
  TradeoffBench(SimulatedBlock simulated,
                std::size_t points,
                const TradeoffChoice& reference,
                ProgressSink* progress);
  ~TradeoffBench();
  TradeoffBench(const TradeoffBench&) = delete;
  TradeoffBench& operator=(const TradeoffBench&) = delete;

  [[nodiscard]] const Block& block() const;

  /// Runs `choice` as often as `times` says and between each two of them `reference` (of the same
  /// stage), so that every run of the choice has one of the reference as its neighbour, and
  /// compares. A choice that the library refuses (InputError, UndeterminedError) is a row with its
  /// words as note. The reference itself runs alone; its ratio is 1. Throws Interrupted.
  [[nodiscard]] TradeoffRow Measure(const TradeoffChoice& choice,
                                    const TradeoffChoice& reference,
                                    const TradeoffRepeats& times,
                                    TradeoffClock clock,
                                    ProgressSink* progress);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Columns of tradeoff.csv (docs/studies.md).
[[nodiscard]] const std::vector<StudyColumn>& TradeoffColumns();

/// A row as cells, without `pareto`: that needs the other rows.
[[nodiscard]] StudyRow CellsOf(const TradeoffRow& row);

/// The rows of a table with these columns, every number to the bit. Throws std::logic_error for an
/// unknown stage or clock.
[[nodiscard]] std::vector<TradeoffRow> TradeoffRowsOf(const StudyTable& table);

/// The table of all rows, with `pareto` as the rows have it.
[[nodiscard]] StudyTable TradeoffTable(const std::vector<TradeoffRow>& rows);

/// What one call cost.
struct RunCost {
  double wall_s = 0.0;
  double cpu_s = 0.0;     ///< all threads
  double peak_mib = 0.0;  ///< NaN if the system does not give it
};

/// Runs `work` and measures it. The peak is that of the resident set during the call less what was
/// resident before it. Freed memory is given back first (malloc_trim); the process's high-water
/// mark, which otherwise only grows, is set back by /proc/self/clear_refs (Linux).
[[nodiscard]] RunCost MeasureRun(const std::function<void()>& work);

/// Rows that are not run for a size.
struct TradeoffSkip {
  std::vector<std::string> rows;  ///< "STAGE" or "STAGE.CHOICE"
  std::string reason;             ///< for people, in the row's note
};

/// One size of the scene that choices are measured on.
struct TradeoffSize {
  std::size_t points = 0;  ///< used as its name; `set` of the file must lead to this number
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
  /// The part of the study that is measured: "STAGE" or "STAGE.CHOICE", and sizes; empty: all.
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

/// The study as tasks, one a choice and size, measured one by one: each beside its reference, on a
/// block that is simulated when the first row of its size is measured. `threads` are those of the
/// session. `study` must outlive the plan.
[[nodiscard]] StudyPlan PlanTradeoff(const TradeoffStudy& study, int threads);

/// The rows as a Markdown page: a recommendation and a table for every size, rows of the Pareto set
/// in bold. Sizes ascending, stages in their order, rows as given.
[[nodiscard]] std::string TradeoffPage(const std::vector<TradeoffRow>& rows,
                                       const TradeoffGoal& goal);

/// Sizes of the rows, ascending, each once.
[[nodiscard]] std::vector<std::size_t> SizesOf(const std::vector<TradeoffRow>& rows);

}  // namespace sarblock
