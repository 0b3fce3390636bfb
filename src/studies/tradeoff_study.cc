// SPDX-License-Identifier: Apache-2.0
#include "sarblock/files/block_file.h"
#include "sarblock/files/scene_file.h"
#include "sarblock/geometry/path.h"
#include "sarblock/simulate/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <memory>
#include <set>
#include <utility>

#include "study.h"
#include "tables/toml.h"
#include "tradeoff.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr int kMaxRepeats = 1000;

std::vector<std::string> Texts(SceneTable* table, const std::string& key) {
  std::vector<std::string> texts;
  if (const auto taken = table->Take(key)) {
    for (const TomlValue& entry : taken->Entries()) texts.push_back(entry.Text());
  }
  return texts;
}

void Whole(SceneTable* table, const std::string& key, int most, int* value) {
  if (const auto taken = table->Take(key)) *value = taken->Integer(1, most);
}

/// True where "STAGE" or "STAGE.CHOICE" means this choice.
bool Means(const std::string& name, const TradeoffEntry& entry) {
  const std::string stage = NameOf(entry.choice.stage);
  return name == stage || name == stage + "." + entry.choice.name;
}

bool AnyMeans(const std::vector<std::string>& names, const TradeoffEntry& entry) {
  return std::any_of(
      names.begin(), names.end(), [&](const std::string& name) { return Means(name, entry); });
}

TradeoffSkip ReadSkip(SceneTable table) {
  TradeoffSkip skip;
  skip.rows = Texts(&table, "rows");
  table.Text("reason", &skip.reason);
  if (skip.rows.empty()) throw InputError(table.PlaceOf("rows"), "must be given, a list of rows");
  if (skip.reason.empty()) throw InputError(table.PlaceOf("reason"), "must be given");
  table.Finish();
  return skip;
}

TradeoffSize ReadSize(SceneTable table, std::string_view scene_text, const std::string& scene) {
  TradeoffSize size;
  table.Count("points", &size.points);
  if (size.points == 0) throw InputError(table.PlaceOf("points"), "must be given, 1 or more");
  Whole(&table, "repeats", kMaxRepeats, &size.repeats);
  if (const auto taken = table.Take("longest_s")) size.longest_s = taken->Positive();
  for (SceneTable& skip : table.Tables("skip")) size.skips.push_back(ReadSkip(std::move(skip)));
  const std::vector<std::string> set = Texts(&table, "set");
  table.Finish();
  size.scene = files::ParseScene(scene_text, scene, set);
  return size;
}

TradeoffEntry ReadChoice(SceneTable table) {
  using Run = TradeoffChoice::Run;
  TradeoffEntry entry;
  if (!table.Has("stage")) throw InputError(table.PlaceOf("stage"), "must be given");
  constexpr std::array kStages{
      TradeoffStage::kModel, TradeoffStage::kSolver, TradeoffStage::kCovariance};
  table.Choice("stage", kStages, &entry.choice.stage);
  table.Text("name", &entry.choice.name);
  if (entry.choice.name.empty()) throw InputError(table.PlaceOf("name"), "must be given");
  table.Truth("reference", &entry.reference);
  table.Choice<Run>(
      "run",
      {{"adjust", Run::kAdjust}, {"intersect", Run::kIntersect}, {"two-looks", Run::kTwoLooks}},
      &entry.choice.run);
  if (table.Has("through")) {
    if (entry.choice.run != Run::kAdjust) {
      throw InputError(table.PlaceOf("through"), "goes with run = \"adjust\" only");
    }
    table.Choice("through", kPathsThrough, &entry.choice.through.emplace());
  }
  table.Count("most_points", &entry.most_points);
  table.Text("reason", &entry.reason);
  Whole(&table, "threads", 1024, &entry.threads);
  Whole(&table, "repeats", kMaxRepeats, &entry.repeats);
  entry.set = Texts(&table, "set");
  table.Finish();
  return entry;
}

void ReadTradeoffGoal(SceneTable& table, TradeoffGoal* goal) {
  table.Number("position_sigma", &goal->position_error);
  table.Number("covariance", &goal->covariance_error);
  table.Finish();
}

/// One reference a stage, names once a stage.
void RequireReferences(const TradeoffStudy& study, const std::string& file) {
  for (const TradeoffEntry& entry : study.choices) {
    int references = 0, named = 0;
    for (const TradeoffEntry& other : study.choices) {
      if (other.choice.stage != entry.choice.stage) continue;
      references += other.reference ? 1 : 0;
      named += other.choice.name == entry.choice.name ? 1 : 0;
    }
    const std::string stage = NameOf(entry.choice.stage);
    if (references != 1) {
      throw InputError(FilePlace{file, 0, "choice"},
                       "stage " + stage + " has " + std::to_string(references) +
                           " choices with reference = true, it needs one");
    }
    if (named != 1) {
      throw InputError(FilePlace{file, 0, "choice"},
                       "stage " + stage + " has two choices named " + entry.choice.name);
    }
  }
}

void RequireRow(const TradeoffStudy& study, const std::string& name, const FilePlace& place) {
  if (std::none_of(study.choices.begin(), study.choices.end(), [&](const auto& entry) {
        return Means(name, entry);
      })) {
    throw InputError(place, "'" + name + "' is no STAGE or STAGE.CHOICE of the study");
  }
}

/// Rows that a size does without are rows, and those left have their reference.
void RequireSkips(const TradeoffStudy& study, const SceneTable& table) {
  for (const TradeoffSize& size : study.sizes) {
    for (const TradeoffSkip& skip : size.skips) {
      for (const std::string& name : skip.rows) RequireRow(study, name, table.PlaceOf("size"));
    }
    for (const TradeoffEntry& entry : study.choices) {
      const TradeoffEntry& reference = study.ReferenceOf(entry.choice.stage);
      if (study.WhyNotRun(reference, size).empty() || !study.WhyNotRun(entry, size).empty()) {
        continue;
      }
      throw InputError(table.PlaceOf("size"),
                       std::to_string(size.points) + " points: '" + entry.choice.name +
                           "' has no reference to be measured with, '" + reference.choice.name +
                           "' is not run");
    }
  }
}

/// What `only` and `only_points` name is there, and one choice at least adjusts as a reference.
void RequireKnown(const TradeoffStudy& study, const SceneTable& table) {
  for (const std::string& name : study.only) RequireRow(study, name, table.PlaceOf("only"));
  for (const std::size_t points : study.only_points) {
    if (std::none_of(study.sizes.begin(), study.sizes.end(), [&](const TradeoffSize& size) {
          return size.points == points;
        })) {
      throw InputError(table.PlaceOf("only_points"),
                       std::to_string(points) + " is no size of the study");
    }
  }
  if (std::none_of(study.choices.begin(), study.choices.end(), [](const TradeoffEntry& entry) {
        return entry.reference && entry.choice.run == TradeoffChoice::Run::kAdjust;
      })) {
    throw InputError(table.PlaceOf("choice"),
                     "no reference adjusts: there is nothing to compare with");
  }
}

}  // namespace

const TradeoffEntry& TradeoffStudy::ReferenceOf(TradeoffStage stage) const {
  return *std::find_if(choices.begin(), choices.end(), [&](const TradeoffEntry& entry) {
    return entry.choice.stage == stage && entry.reference;
  });
}

bool TradeoffStudy::Wants(const TradeoffEntry& entry, std::size_t points) const {
  const bool named = only.empty() || AnyMeans(only, entry);
  const bool sized = only_points.empty() ||
                     std::find(only_points.begin(), only_points.end(), points) != only_points.end();
  return named && sized;
}

std::string TradeoffStudy::WhyNotRun(const TradeoffEntry& entry, const TradeoffSize& size) const {
  if (size.points > entry.most_points) {
    return entry.reason.empty() ? "above " + std::to_string(entry.most_points) + " points"
                                : entry.reason;
  }
  for (const TradeoffSkip& skip : size.skips) {
    if (AnyMeans(skip.rows, entry)) return skip.reason;
  }
  return "";
}

int TradeoffEntry::ThreadsOf(int session) const {
  return threads > 0 ? std::min(threads, session) : session;
}

TradeoffStudy ParseTradeoffStudy(
    std::string_view text,
    const std::string& file,
    const std::vector<std::string>& overrides,
    const std::function<std::string(const std::string& name)>& scene_text) {
  const toml::table root = ParseToml(text, file, overrides);
  SceneTable table{TomlTable(root, "")};
  TradeoffStudy study;
  if (table.Has("seed")) {
    throw InputError(table.PlaceOf("seed"), "does not go with tradeoff: the scene has its own");
  }
  study.heading = TakeStudyHeading("tradeoff", &table);
  std::string scene;
  table.Text("scene", &scene);
  if (scene.empty()) throw InputError(table.PlaceOf("scene"), "must be given, a scene file");
  study.scene_file = std::filesystem::path(file).parent_path() / scene;
  const std::string scene_toml = scene_text(scene);
  Whole(&table, "repeats", kMaxRepeats, &study.repeats);
  table.Choice<TradeoffClock>("clock",
                              {{NameOf(TradeoffClock::kWall), TradeoffClock::kWall},
                               {NameOf(TradeoffClock::kCpu), TradeoffClock::kCpu}},
                              &study.clock);
  study.only = Texts(&table, "only");
  if (const auto sizes = table.Take("only_points")) {
    for (const TomlValue& entry : sizes->Entries()) study.only_points.push_back(entry.Count());
  }
  if (auto goal = table.Table("goal")) ReadTradeoffGoal(*goal, &study.goal);
  for (SceneTable& size : table.Tables("size")) {
    study.sizes.push_back(ReadSize(std::move(size), scene_toml, study.scene_file.string()));
  }
  if (study.sizes.empty()) throw InputError(table.PlaceOf("size"), "must be given once at least");
  for (SceneTable& choice : table.Tables("choice")) {
    study.choices.push_back(ReadChoice(std::move(choice)));
  }
  if (study.choices.empty()) {
    throw InputError(table.PlaceOf("choice"), "must be given once at least");
  }
  table.Finish();
  RequireReferences(study, file);
  RequireKnown(study, table);
  RequireSkips(study, table);
  study.identity = TextOf(root) + SceneAsComment(scene, scene_toml);
  return study;
}

TradeoffStudy ReadTradeoffStudy(const std::filesystem::path& file,
                                const std::vector<std::string>& overrides) {
  const std::string text = ReadTomlText(file, "a study");
  return ParseTradeoffStudy(text, file.string(), overrides, ScenesOf(file, text));
}

std::vector<std::string> TradeoffKeys() {
  std::vector<std::string> keys = {
      "name", "purpose", "scene", "repeats", "clock", "only", "only_points"};
  for (const char* key :
       {"points", "repeats", "longest_s", "set", "skip.0.rows", "skip.0.reason"}) {
    keys.push_back(std::string("size.0.") + key);
  }
  for (const char* key : {"stage",
                          "name",
                          "reference",
                          "run",
                          "most_points",
                          "reason",
                          "threads",
                          "repeats",
                          "set"}) {
    keys.push_back(std::string("choice.0.") + key);
  }
  const toml::table empty;
  SceneTable goal{TomlTable(empty, "goal")};
  TradeoffGoal none;
  ReadTradeoffGoal(goal, &none);
  for (const std::string& key : goal.known()) keys.push_back("goal." + key);
  return keys;
}

namespace {

/// The choice with the options it has on a block of the scene.
TradeoffChoice BindChoice(const TradeoffEntry& entry,
                          const Scene& scene,
                          const Block& block,
                          int threads) {
  std::vector<std::string> passes;
  for (const Pass& pass : block.passes) passes.push_back(pass.id);
  TradeoffChoice choice = entry.choice;
  choice.options =
      files::ReadAdjustTable(scene.adjust_toml, "choice " + entry.choice.name, passes, entry.set);
  choice.options.threads = entry.ThreadsOf(threads);
  return choice;
}

/// Measures rows; holds the block of the size at hand, simulated when its first row is measured.
class Bench {
 public:
  /// `study` must outlive it.
  Bench(const TradeoffStudy& study, int threads) : study_(study), threads_(threads) {}

  std::vector<StudyRow> Measure(const TradeoffSize& size,
                                const TradeoffEntry& entry,
                                ProgressSink* progress) {
    const std::string reason = study_.WhyNotRun(entry, size);
    if (!reason.empty()) {
      TradeoffChoice choice = entry.choice;
      choice.options.threads = entry.ThreadsOf(threads_);
      return {CellsOf(NotRun(choice, size.points, study_.clock, reason))};
    }
    Prepare(size, progress);
    const int repeats = entry.repeats > 0  ? entry.repeats
                        : size.repeats > 0 ? size.repeats
                                           : study_.repeats;
    return {CellsOf(
        bench_->Measure(Bound(entry, size, bench_->block()),
                        Bound(study_.ReferenceOf(entry.choice.stage), size, bench_->block()),
                        {repeats, size.longest_s},
                        study_.clock,
                        progress))};
  }

 private:
  [[nodiscard]] TradeoffChoice Bound(const TradeoffEntry& entry,
                                     const TradeoffSize& size,
                                     const Block& block) const {
    return BindChoice(entry, size.scene, block, threads_);
  }

  void Prepare(const TradeoffSize& size, ProgressSink* progress) {
    if (bench_ != nullptr && points_ == size.points) return;
    bench_.reset();
    SimulatedBlock simulated = Simulate(size.scene, progress);
    // The best answer: the first reference that adjusts. The reader has seen to it that one does.
    const auto best =
        std::find_if(study_.choices.begin(), study_.choices.end(), [](const TradeoffEntry& entry) {
          return entry.reference && entry.choice.run == TradeoffChoice::Run::kAdjust;
        });
    const TradeoffChoice tight = Bound(*best, size, simulated.block);
    bench_ = std::make_unique<TradeoffBench>(std::move(simulated), size.points, tight, progress);
    points_ = size.points;
  }

  const TradeoffStudy& study_;
  int threads_ = 1;
  std::unique_ptr<TradeoffBench> bench_;
  std::size_t points_ = 0;
};

}  // namespace

StudyPlan PlanTradeoff(const TradeoffStudy& study, int threads) {
  const auto bench = std::make_shared<Bench>(study, threads);
  StudyPlan plan;
  plan.columns = TradeoffColumns();
  plan.order = TaskOrder::kOneByOne;
  for (const TradeoffSize& size : study.sizes) {
    for (const TradeoffEntry& entry : study.choices) {
      if (!study.Wants(entry, size.points)) continue;
      plan.tasks.push_back(
          {fmt::format(
               "{} {}, {} points", NameOf(entry.choice.stage), entry.choice.name, size.points),
           [bench, &size, &entry](ProgressSink* progress) {
             return bench->Measure(size, entry, progress);
           }});
    }
  }
  return plan;
}

namespace {

std::string FigureAs(double value, const char* format = "{:.2g}") {
  return std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : "";
}

std::string Seconds(double value_s) {
  if (!std::isfinite(value_s)) return "";
  return value_s < 0.1 ? fmt::format("{:.2g} ms", 1e3 * value_s) : fmt::format("{:.3g} s", value_s);
}

/// "3.1 (2.9 to 3.3)"; one number where nothing was repeated.
std::string Ratio(const TradeoffRow& row) {
  if (!std::isfinite(row.speed_ratio)) return "";
  if (row.reference) return "1";
  if (row.repeats == 1) return FigureAs(row.speed_ratio);
  return fmt::format("{:.2g} ({:.2g} to {:.2g})", row.speed_ratio, row.speed_low, row.speed_high);
}

std::string Missing(const AnswerErrors& errors) {
  if (errors.points_missing > 0)
    return fmt::format("{} points without position", errors.points_missing);
  if (errors.points_unjudged > 0 && std::isfinite(errors.covariance_error)) {
    return fmt::format("{} points without covariance", errors.points_unjudged);
  }
  return "";
}

std::string Remark(const TradeoffRow& row) {
  std::string text;
  for (const std::string& part :
       {std::string(row.reference ? "reference" : ""),
        std::string(row.accepted || row.repeats == 0 ? "" : "not accepted"),
        Missing(row.errors),
        row.note}) {
    if (!part.empty()) text += (text.empty() ? "" : "; ") + part;
  }
  std::replace(text.begin(), text.end(), '|', '/');
  return text;
}

std::string Line(const TradeoffRow& row) {
  const char* mark = row.pareto ? "**" : "";
  return fmt::format("| {} | {}{}{} | {} | {} | {} | {} | {} | {} | {} | {} | {} |\n",
                     NameOf(row.stage),
                     mark,
                     row.choice,
                     mark,
                     row.threads,
                     Seconds(row.wall_s),
                     Seconds(row.cpu_s),
                     Ratio(row),
                     FigureAs(row.peak_mib, "{:.1f}"),
                     FigureAs(row.errors.position_error, "{:.1e}"),
                     FigureAs(row.errors.covariance_error, "{:.1e}"),
                     FigureAs(row.errors.nees),
                     Remark(row));
}

}  // namespace

std::vector<std::size_t> SizesOf(const std::vector<TradeoffRow>& rows) {
  std::set<std::size_t> sizes;
  for (const TradeoffRow& row : rows) sizes.insert(row.points);
  return {sizes.begin(), sizes.end()};
}

std::string TradeoffPage(const std::vector<TradeoffRow>& rows, const TradeoffGoal& goal) {
  std::string page = "# Speed against accuracy: the rows\n\n";
  for (const std::size_t points : SizesOf(rows)) {
    page += "- " + Recommend(rows, points, goal) + ".\n";
  }
  for (const std::size_t points : SizesOf(rows)) {
    std::vector<TradeoffRow> of_size;
    std::copy_if(rows.begin(), rows.end(), std::back_inserter(of_size), [&](const auto& row) {
      return row.points == points;
    });
    std::stable_sort(of_size.begin(), of_size.end(), [](const auto& a, const auto& b) {
      return a.stage < b.stage;
    });
    std::size_t corrections = 0, looks = 0;
    for (const TradeoffRow& row : of_size) {
      if (row.reference) corrections = row.corrections;
      looks = std::max(looks, row.looks);
    }
    page += fmt::format(
        "\n## {} points\n\n{} looks, {} corrections in the reference.\n\n"
        "| stage | choice | threads | wall | CPU | speed by {} time, reference = 1 | MiB | "
        "position, sigmas | covariance | NEES | |\n"
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
        points,
        looks,
        corrections,
        of_size.front().clock == TradeoffClock::kWall ? "wall" : "CPU");
    for (const TradeoffRow& row : of_size) page += Line(row);
  }
  return page;
}

}  // namespace sarblock
