// SPDX-License-Identifier: Apache-2.0
#include "tradeoff.h"

#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/geometry/intersection.h"
#include "sarblock/model/result.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <fstream>
#include <limits>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "block/read_recorded.h"
#include "core/threads.h"
#include "linear/dense.h"
#include "solve/start.h"
#include <fmt/core.h>
#include <malloc.h>
#include <sys/resource.h>

namespace sarblock {
namespace {

constexpr std::size_t kPointsPerChunk = 512;

double Median(std::vector<double> values) {
  if (values.empty()) return kNotGiven;
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

/// Standard deviations of the closed form: noise and, where corrections have priors, the path.
void FillClosedForm(const PointResults& points, TradeoffAnswer* out) {
  const auto total = [](const std::vector<double>& noise_m, const std::vector<double>& path_m) {
    std::vector<double> sigma_m(noise_m);
    for (std::size_t i = 0; i < path_m.size(); ++i) sigma_m[i] = std::hypot(noise_m[i], path_m[i]);
    return sigma_m;
  };
  out->sigma_across_m = total(points.sigma_leberl_across_m, points.sigma_leberl_path_across_m);
  out->sigma_up_m = total(points.sigma_leberl_up_m, points.sigma_leberl_path_up_m);
  out->across_azimuth_rad = points.leberl_across_azimuth_rad;
}

/// Names of the corrections a selection chose, each once: "position.along.1".
std::string Chosen(const SelectionReport& selection) {
  std::set<std::string> names;
  for (const CandidateResult& candidate : selection.candidates) {
    if (candidate.kept) names.insert(candidate.name);
  }
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "chose " : " ") + name;
  return text.empty() && !selection.empty() ? "chose none" : text;
}

TradeoffAnswer AnswerOf(AdjustResult result, CovarianceLevel level) {
  TradeoffAnswer out;
  out.accepted = result.usable();
  out.iterations = result.iterations;
  out.corrections = result.parameters.size();
  out.note = result.usable() ? Chosen(result.selection) : result.assessment.reasons.front();
  if (level == CovarianceLevel::kLeberl) FillClosedForm(result.points, &out);
  if (result.montecarlo) {
    out.covariance_m2 = std::move(result.montecarlo->sample_m2);
  } else {
    out.covariance_m2 = std::move(result.points.covariance_m2);
  }
  for (std::size_t i = 0; i < result.points.status.size(); ++i) {
    const PointStatus status = result.points.status[i];
    if (!IsSolved(status) && status != PointStatus::kApart) {
      result.points.position_m[i].setConstant(kNotGiven);
    }
  }
  out.position_m = std::move(result.points.position_m);
  return out;
}

/// The block with the two looks of each point left whose intersection has the smallest variance.
Block TwoLooksOf(const Block& block) {
  Block out = block;
  const AdjustmentProblem problem(block, {});
  ParallelForChunks(
      block.points.size(), kPointsPerChunk, [&](std::size_t, std::size_t begin, std::size_t end) {
        std::vector<FixedPathLook> observations;
        std::vector<std::size_t> looks;
        for (std::size_t point = begin; point < end; ++point) {
          observations.clear();
          looks.clear();
          for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1];
               ++i) {
            const auto observation = problem.model.FixPath(i, Eigen::VectorXd());
            if (!observation || block.looks.rejected(i)) continue;
            observations.push_back(*observation);
            looks.push_back(i);
          }
          double least_m2 = std::numeric_limits<double>::infinity();
          std::array<std::size_t, 2> best{0, 1};
          for (std::size_t a = 0; a < observations.size(); ++a) {
            for (std::size_t b = a + 1; b < observations.size(); ++b) {
              const std::array<FixedPathLook, 2> pair{observations[a], observations[b]};
              const Intersection met = Intersect(pair, block.frame);
              if (met.outcome != IntersectionOutcome::kDetermined) continue;
              if (met.covariance_m2.trace() >= least_m2) continue;
              least_m2 = met.covariance_m2.trace();
              best = {a, b};
            }
          }
          for (std::size_t k = 0; k < looks.size(); ++k) {
            if (k != best[0] && k != best[1]) out.looks.flags[looks[k]] |= Looks::kRejected;
          }
        }
      });
  return out;
}

Block ReadThrough(PathThrough through, Block block) {
  for (Pass& pass : block.passes) pass.recorded.asked.through = through;
  static_cast<void>(ReadRecordedFlights(&block));
  return block;
}

}  // namespace

const char* NameOf(TradeoffStage stage) {
  switch (stage) {
    case TradeoffStage::kModel:
      return "model";
    case TradeoffStage::kSolver:
      return "solver";
    case TradeoffStage::kCovariance:
      return "covariance";
  }
  return "";
}

const char* NameOf(TradeoffClock clock) { return clock == TradeoffClock::kWall ? "wall" : "cpu"; }

struct TradeoffBench::Impl {
  SimulatedBlock simulated;
  std::size_t points = 0;
  TradeoffAnswer best;
  std::optional<Block> two_looks;

  void Prepare(const TradeoffChoice& choice) {
    if (choice.run != TradeoffChoice::Run::kTwoLooks || two_looks) return;
    RunInLibrary(
        choice.options.threads, nullptr, [this] { two_looks = TwoLooksOf(simulated.block); });
  }

  [[nodiscard]] TradeoffAnswer Run(const TradeoffChoice& choice, ProgressSink* progress) {
    switch (choice.run) {
      case TradeoffChoice::Run::kIntersect:
        return AnswerOf(IntersectBlock(simulated.block, choice.options, progress),
                        choice.options.covariance);
      case TradeoffChoice::Run::kTwoLooks:
        return AnswerOf(IntersectBlock(*two_looks, choice.options, progress),
                        choice.options.covariance);
      case TradeoffChoice::Run::kAdjust:
        break;
    }
    const Block& block = simulated.block;
    if (!choice.through) {
      return AnswerOf(Adjust(block, choice.options, {}, progress), choice.options.covariance);
    }
    const Block read = ReadThrough(*choice.through, block);
    return AnswerOf(Adjust(read, choice.options, {}, progress), choice.options.covariance);
  }
};

TradeoffBench::TradeoffBench(SimulatedBlock simulated,
                             std::size_t points,
                             const TradeoffChoice& reference,
                             ProgressSink* progress)
    : impl_(std::make_unique<Impl>()) {
  impl_->simulated = std::move(simulated);
  impl_->points = points;
  TradeoffChoice tight = reference;
  tight.options.tolerance = kBestTolerance;
  impl_->best = impl_->Run(tight, progress);
  if (!impl_->best.accepted || impl_->best.covariance_m2.empty()) {
    throw InputError(
        "reference",
        "'" + reference.name +
            "' gives no accepted solution with a covariance to compare with: " + impl_->best.note);
  }
}

TradeoffBench::~TradeoffBench() = default;

TradeoffRow NotRun(const TradeoffChoice& choice,
                   std::size_t points,
                   TradeoffClock clock,
                   const std::string& reason) {
  TradeoffRow row;
  row.stage = choice.stage;
  row.choice = choice.name;
  row.points = points;
  row.threads = choice.options.threads;
  row.clock = clock;
  row.note = "not run: " + reason;
  return row;
}

const Block& TradeoffBench::block() const { return impl_->simulated.block; }

TradeoffRow TradeoffBench::Measure(const TradeoffChoice& choice,
                                   const TradeoffChoice& reference,
                                   const TradeoffRepeats& times,
                                   TradeoffClock clock,
                                   ProgressSink* progress) {
  TradeoffRow row;
  row.stage = choice.stage;
  row.choice = choice.name;
  row.points = impl_->points;
  row.looks = impl_->simulated.block.looks.size();
  row.clock = clock;
  const auto time_s = [clock](const RunCost& cost) {
    return clock == TradeoffClock::kWall ? cost.wall_s : cost.cpu_s;
  };
  row.threads = choice.options.threads;
  row.repeats = 1;  // of a choice that is refused
  row.reference = choice.name == reference.name;
  std::vector<double> wall_s, cpu_s, peak_mib, own_s, ratio;
  TradeoffAnswer answer;
  try {
    impl_->Prepare(choice);
    impl_->Prepare(reference);
    const auto run_choice = [&] {
      answer = {};  // its memory does not count in the next run
      const RunCost cost = MeasureRun([&] { answer = impl_->Run(choice, progress); });
      wall_s.push_back(cost.wall_s);
      cpu_s.push_back(cost.cpu_s);
      peak_mib.push_back(cost.peak_mib);
      own_s.push_back(time_s(cost));
      return cost.wall_s;
    };
    double spent_s = 0.0;
    const auto more = [&] {
      return static_cast<int>(own_s.size()) < times.repeats && spent_s < times.longest_s;
    };
    // Choice, reference, choice: every run of the choice has one of the reference as its neighbour.
    while (own_s.empty() || more()) {
      const std::size_t first = own_s.size();
      spent_s += run_choice();
      double reference_s = kNotGiven;
      if (!row.reference) {
        const RunCost cost =
            MeasureRun([&] { static_cast<void>(impl_->Run(reference, progress)); });
        reference_s = time_s(cost);
        spent_s += cost.wall_s;
      }
      if (more()) spent_s += run_choice();
      for (std::size_t i = first; i < own_s.size(); ++i) {
        ratio.push_back(row.reference ? 1.0 : reference_s / own_s[i]);
      }
    }
    row.repeats = static_cast<int>(own_s.size());
  } catch (const InputError& refused) {
    row.note = refused.what();
    return row;
  } catch (const UndeterminedError& refused) {
    row.note = refused.what();
    return row;
  }
  row.wall_s = Median(wall_s);
  row.cpu_s = Median(cpu_s);
  row.peak_mib = Median(peak_mib);
  row.speed_ratio = Median(ratio);
  row.speed_low = *std::min_element(ratio.begin(), ratio.end());
  row.speed_high = *std::max_element(ratio.begin(), ratio.end());
  row.iterations = answer.iterations;
  row.corrections = answer.corrections;
  row.accepted = answer.accepted;
  row.note = answer.note;
  row.errors =
      CompareAnswers(impl_->simulated.block, answer, impl_->best, impl_->simulated.truth.points_m);
  return row;
}

namespace {

constexpr char kPareto[] = "pareto";

/// Calls visit(name, value) for every column in the order of the file. One list for both ways.
template <typename Row, typename Visit>
void VisitColumns(Row& row, const Visit& visit) {
  visit("stage", row.stage);
  visit("choice", row.choice);
  visit("points", row.points);
  visit("looks", row.looks);
  visit("wall_s", row.wall_s);
  visit("peak_mib", row.peak_mib);
  visit("speed_ratio", row.speed_ratio);
  visit("position_error_sigma", row.errors.position_error);
  visit("covariance_error", row.errors.covariance_error);
  visit(kPareto, row.pareto);
  visit("reference", row.reference);
  visit("accepted", row.accepted);
  visit("corrections", row.corrections);
  visit("iterations", row.iterations);
  visit("repeats", row.repeats);
  visit("threads", row.threads);
  visit("cpu_s", row.cpu_s);
  visit("clock", row.clock);
  visit("speed_low", row.speed_low);
  visit("speed_high", row.speed_high);
  visit("position_median_sigma", row.errors.position_median);
  visit("covariance_median", row.errors.covariance_median);
  visit("rms_error_m", row.errors.rms_error_m);
  visit("nees", row.errors.nees);
  visit("points_missing", row.errors.points_missing);
  visit("points_unjudged", row.errors.points_unjudged);
  visit("note", row.note);
}

template <typename Value>
constexpr bool kIsNamed =
    std::is_same_v<Value, TradeoffStage> || std::is_same_v<Value, TradeoffClock>;

StudyCell Cell(double value) {
  // Infinity is no number of a table: what is beyond all measure is not given.
  return std::isfinite(value) ? StudyCell(value) : StudyCell();
}
StudyCell Cell(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return text.empty() ? StudyCell() : StudyCell(std::move(text));
}
StudyCell Cell(TradeoffStage stage) { return std::string(NameOf(stage)); }
StudyCell Cell(TradeoffClock clock) { return std::string(NameOf(clock)); }
template <typename Integer>
requires std::is_integral_v<Integer> StudyCell Cell(Integer value) {
  return static_cast<std::int64_t>(value);
}

/// True for a count that a row which was not run has no value of.
bool IsOfARun(std::string_view name, const TradeoffRow& row) {
  constexpr std::array<std::string_view, 5> kCounts{
      "looks", "corrections", "iterations", "points_missing", "points_unjudged"};
  return row.repeats == 0 && std::find(kCounts.begin(), kCounts.end(), name) != kCounts.end();
}

template <typename Named>
void Find(std::initializer_list<Named> all, const std::string& name, Named* out) {
  for (const Named one : all) {
    if (name == NameOf(one)) {
      *out = one;
      return;
    }
  }
  throw std::logic_error("'" + name + "' is no name of a tradeoff table");
}

void Read(const StudyTable& table, std::size_t row, std::string_view name, TradeoffStage* stage) {
  Find({TradeoffStage::kModel, TradeoffStage::kSolver, TradeoffStage::kCovariance},
       table.Text(row, name),
       stage);
}
void Read(const StudyTable& table, std::size_t row, std::string_view name, TradeoffClock* clock) {
  Find({TradeoffClock::kWall, TradeoffClock::kCpu}, table.Text(row, name), clock);
}
void Read(const StudyTable& table, std::size_t row, std::string_view name, std::string* text) {
  *text = table.Text(row, name);
}
void Read(const StudyTable& table, std::size_t row, std::string_view name, double* value) {
  *value = table.Number(row, name);
}
template <typename Integer>
void Read(const StudyTable& table, std::size_t row, std::string_view name, Integer* value) {
  const double number = table.Number(row, name);
  *value = std::isnan(number) ? Integer{} : static_cast<Integer>(number);
}

}  // namespace

const std::vector<StudyColumn>& TradeoffColumns() {
  static const std::vector<StudyColumn> kColumns = [] {
    std::vector<StudyColumn> columns;
    const TradeoffRow row;
    InReport report = InReport::kNeeded;  // stage and choice; what is shown comes first
    VisitColumns(row, [&](std::string_view name, const auto& value) {
      if (name == "points") report = InReport::kYes;
      using Value = std::decay_t<decltype(value)>;
      const StudyCellKind kind = std::is_same_v<Value, double> ? StudyCellKind::kNumber
                                 : std::is_same_v<Value, std::string> || kIsNamed<Value>
                                     ? StudyCellKind::kText
                                     : StudyCellKind::kInteger;
      columns.push_back({std::string(name), kind, report});
      if (name == kPareto) report = InReport::kNo;
    });
    return columns;
  }();
  return kColumns;
}

StudyRow CellsOf(const TradeoffRow& row) {
  StudyRow cells;
  VisitColumns(row, [&](std::string_view name, const auto& value) {
    cells.push_back(name == kPareto || IsOfARun(name, row) ? StudyCell() : Cell(value));
  });
  return cells;
}

std::vector<TradeoffRow> TradeoffRowsOf(const StudyTable& table) {
  std::vector<TradeoffRow> rows(table.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    VisitColumns(rows[i],
                 [&](std::string_view name, auto& value) { Read(table, i, name, &value); });
  }
  return rows;
}

StudyTable TradeoffTable(const std::vector<TradeoffRow>& rows) {
  std::vector<StudyRow> cells;
  for (const TradeoffRow& row : rows) {
    StudyRow& line = cells.emplace_back();
    VisitColumns(row, [&](std::string_view name, const auto& value) {
      line.push_back(IsOfARun(name, row) ? StudyCell() : Cell(value));
    });
  }
  return {TradeoffColumns(), std::move(cells)};
}

namespace {

double TakeMedian(std::vector<double>* values) {
  if (values->empty()) return kNotGiven;
  const auto middle = values->begin() + static_cast<std::ptrdiff_t>(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

double Largest(const std::vector<double>& values) {
  return values.empty() ? kNotGiven : *std::max_element(values.begin(), values.end());
}

/// Rows across and up of an answer in closed form, in east-north-up.
Eigen::Matrix<double, 2, 3> AcrossUp(double azimuth_rad) {
  Eigen::Matrix<double, 2, 3> rows;
  rows << std::sin(azimuth_rad), std::cos(azimuth_rad), 0.0, 0.0, 0.0, 1.0;
  return rows;
}

/// What an answer says of one point: rows that it speaks of, and their covariance.
struct Claim {
  Eigen::MatrixXd rows;
  Eigen::MatrixXd covariance_m2;
  [[nodiscard]] bool holds() const { return covariance_m2.size() > 0; }
};

Claim ClaimOf(const TradeoffAnswer& answer, std::size_t point) {
  Claim claim;
  if (!answer.covariance_m2.empty()) {
    if (!std::isfinite(answer.covariance_m2[point][0])) return claim;
    claim.rows = Eigen::Matrix3d::Identity();
    claim.covariance_m2 = MatrixOf(answer.covariance_m2[point]);
  } else if (!answer.sigma_across_m.empty()) {
    const Eigen::Vector2d sigma_m(answer.sigma_across_m[point], answer.sigma_up_m[point]);
    if (!sigma_m.allFinite() || !std::isfinite(answer.across_azimuth_rad[point])) return claim;
    claim.rows = AcrossUp(answer.across_azimuth_rad[point]);
    claim.covariance_m2 = sigma_m.cwiseAbs2().asDiagonal();
  }
  return claim;
}

}  // namespace

AnswerErrors CompareAnswers(const Block& block,
                            const TradeoffAnswer& answer,
                            const TradeoffAnswer& best,
                            const std::vector<Eigen::Vector3d>& truth_m) {
  AnswerErrors out;
  std::vector<double> shift, covariance;
  double square_m2 = 0.0, normalised = 0.0, dimension = 0.0;
  std::size_t solved = 0;
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    if (block.points.role[point] != PointRole::kTie) continue;
    if (!best.position_m[point].allFinite()) continue;
    if (!answer.position_m[point].allFinite()) {
      ++out.points_missing;
      continue;
    }
    const Eigen::Matrix3d enu = block.frame.EnuFromFrame(best.position_m[point]);
    const Eigen::Matrix3d q = MatrixOf(best.covariance_m2[point]);
    const Eigen::Vector3d shift_m = enu * (answer.position_m[point] - best.position_m[point]);
    shift.push_back(std::sqrt(dense::InverseForm(q, shift_m)));
    const Eigen::Vector3d error_m = enu * (answer.position_m[point] - truth_m[point]);
    square_m2 += error_m.squaredNorm();
    ++solved;
    const Claim claim = ClaimOf(answer, point);
    if (!claim.holds()) {
      ++out.points_unjudged;
      continue;
    }
    const Eigen::MatrixXd same = claim.rows * q * claim.rows.transpose();
    covariance.push_back((claim.covariance_m2 - same).norm() / same.norm());
    const Eigen::VectorXd e = claim.rows * error_m;
    normalised += e.dot(dense::Cholesky(claim.covariance_m2).Solve(e));
    dimension += static_cast<double>(e.size());
  }
  out.position_error = Largest(shift);
  out.position_median = TakeMedian(&shift);
  out.covariance_error = Largest(covariance);
  out.covariance_median = TakeMedian(&covariance);
  if (solved > 0) out.rms_error_m = std::sqrt(square_m2 / static_cast<double>(solved));
  if (dimension > 0.0) out.nees = normalised / dimension;
  return out;
}

namespace {

/// A line `NAME: n kB` of /proc/self/status; NaN where it is not there.
double StatusMib(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(name + ":")) return std::stod(line.substr(name.size() + 1)) / 1024.0;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

/// False where the mark cannot be set back.
bool ResetHighWater() {
  std::ofstream refs("/proc/self/clear_refs");
  refs << "5";
  return static_cast<bool>(refs.flush());
}

double CpuSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

}  // namespace

RunCost MeasureRun(const std::function<void()>& work) {
  malloc_trim(0);
  const bool peak = ResetHighWater();
  const double before_mib = StatusMib("VmRSS");
  const double cpu_s = CpuSeconds();
  const auto begin = std::chrono::steady_clock::now();
  work();
  RunCost cost;
  cost.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  cost.cpu_s = CpuSeconds() - cpu_s;
  cost.peak_mib = peak ? std::max(0.0, StatusMib("VmHWM") - before_mib)
                       : std::numeric_limits<double>::quiet_NaN();
  return cost;
}

namespace {

double Position(const TradeoffRow& row) {
  return std::max(row.errors.position_error, kSamePosition);
}

double Covariance(const TradeoffRow& row) {
  const bool whole = std::isfinite(row.errors.covariance_error) && row.errors.points_unjudged == 0;
  return whole ? std::max(row.errors.covariance_error, kSameCovariance)
               : std::numeric_limits<double>::infinity();
}

bool Competes(const TradeoffRow& row) {
  return row.accepted && row.errors.points_missing == 0 && std::isfinite(row.speed_ratio) &&
         std::isfinite(row.errors.position_error);
}

bool Faster(const TradeoffRow& a, const TradeoffRow& b) {
  return a.speed_ratio > (1.0 + kSameSpeed) * b.speed_ratio;
}

bool Beats(const TradeoffRow& a, const TradeoffRow& b) {
  if (Faster(b, a) || Position(a) > Position(b) || Covariance(a) > Covariance(b)) return false;
  return Faster(a, b) || Position(a) < Position(b) || Covariance(a) < Covariance(b);
}

/// The fastest row of a stage that is on the Pareto set and good enough; the reference among
/// equals.
const TradeoffRow* Fastest(const std::vector<TradeoffRow>& rows,
                           TradeoffStage stage,
                           std::size_t points,
                           const TradeoffGoal& goal) {
  const TradeoffRow* best = nullptr;
  for (const TradeoffRow& row : rows) {
    if (row.stage != stage || row.points != points || !row.pareto) continue;
    if (Position(row) > goal.position_error || Covariance(row) > goal.covariance_error) continue;
    if (best == nullptr || Faster(row, *best) || (row.reference && !Faster(*best, row))) {
      best = &row;
    }
  }
  return best;
}

const TradeoffRow* Named(const std::vector<TradeoffRow>& rows,
                         TradeoffStage stage,
                         std::size_t points,
                         const char* name) {
  for (const TradeoffRow& row : rows) {
    if (row.stage == stage && row.points == points && row.choice == name) return &row;
  }
  return nullptr;
}

/// "2.3 times faster", "1.4 times slower", "as fast".
std::string Pace(double ratio) {
  if (ratio > 1.0 + kSameSpeed) return fmt::format("{:.2g} times faster", ratio);
  if (ratio * (1.0 + kSameSpeed) < 1.0) return fmt::format("{:.2g} times slower", 1.0 / ratio);
  return "as fast";
}

}  // namespace

void MarkPareto(std::vector<TradeoffRow>* rows) {
  for (TradeoffRow& row : *rows) {
    row.pareto = Competes(row) && std::none_of(rows->begin(), rows->end(), [&](const auto& other) {
                   return other.stage == row.stage && other.points == row.points &&
                          Competes(other) && Beats(other, row);
                 });
  }
}

std::string Recommend(const std::vector<TradeoffRow>& rows,
                      std::size_t points,
                      const TradeoffGoal& goal) {
  const TradeoffRow* solver = Fastest(rows, TradeoffStage::kSolver, points, goal);
  const TradeoffRow* covariance = Fastest(rows, TradeoffStage::kCovariance, points, goal);
  std::string text = fmt::format("{} points: ", points);
  const bool models_alone = std::all_of(rows.begin(), rows.end(), [&](const TradeoffRow& row) {
    return row.points != points || row.stage == TradeoffStage::kModel;
  });
  if (models_alone) {
    const TradeoffRow* model = Fastest(rows, TradeoffStage::kModel, points, goal);
    if (model == nullptr) return text + "no model is good enough";
    return text + fmt::format("the fastest that is good enough is {}, {:.2g} s on {} thread{}",
                              model->choice,
                              model->wall_s,
                              model->threads,
                              model->threads == 1 ? "" : "s");
  }
  if (solver == nullptr || covariance == nullptr) return text + "no choice is good enough";
  text += fmt::format(
      "the fastest that are good enough are {}, double, {}: {:.2g} s on {} thread{}, {:.0f} MiB "
      "beyond the block",
      solver->choice,
      covariance->choice,
      solver->wall_s,
      solver->threads,
      solver->threads == 1 ? "" : "s",
      solver->peak_mib);
  const TradeoffRow* closed = Named(rows, TradeoffStage::kModel, points, "leberl");
  if (closed != nullptr && Competes(*closed)) {
    text += fmt::format(
        "; leberl is {}, its positions up to {:.2g} sigmas off, errors {:.2g} times as large as it "
        "says",
        Pace(closed->speed_ratio),
        closed->errors.position_error,
        std::sqrt(closed->errors.nees));
  }
  return text;
}

}  // namespace sarblock
