// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/geometry/intersection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "arithmetic.h"
#include "block/read_recorded.h"
#include "core/threads.h"
#include "run_cost.h"
#include "solve/start.h"
#include "study/tradeoff.h"

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
  out.accepted = result.accepted();
  out.iterations = result.iterations;
  out.corrections = result.parameters.size();
  out.note = result.accepted() ? Chosen(result.selection) : result.assessment.reasons.front();
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
        std::vector<Sight> sights;
        std::vector<std::size_t> looks;
        for (std::size_t point = begin; point < end; ++point) {
          sights.clear();
          looks.clear();
          for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1];
               ++i) {
            const auto sight = problem.model.SightOf(i, Eigen::VectorXd());
            if (!sight || block.looks.rejected(i)) continue;
            sights.push_back(*sight);
            looks.push_back(i);
          }
          double least_m2 = std::numeric_limits<double>::infinity();
          std::array<std::size_t, 2> best{0, 1};
          for (std::size_t a = 0; a < sights.size(); ++a) {
            for (std::size_t b = a + 1; b < sights.size(); ++b) {
              const std::array<Sight, 2> pair{sights[a], sights[b]};
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
    case TradeoffStage::kPrecision:
      return "precision";
  }
  return "";
}

const char* NameOf(TradeoffClock clock) { return clock == TradeoffClock::kWall ? "wall" : "cpu"; }

struct TradeoffBench::Impl {
  SimulatedBlock simulated;
  std::size_t points = 0;
  TradeoffAnswer best;
  std::optional<TradeoffAnswer> best_arithmetic;
  std::optional<Block> two_looks;
  AdjustOptions options;  // of the reference
  /// For arithmetic: the problem at its start, made when first needed.
  std::unique_ptr<AdjustmentProblem> problem;
  BlockState start;
  std::vector<LookWeights> weights;

  void Prepare(const TradeoffChoice& choice, ProgressSink* progress) {
    if (choice.run == TradeoffChoice::Run::kTwoLooks && !two_looks) {
      const ThreadLimit limit(choice.options.threads);
      two_looks = TwoLooksOf(simulated.block);
    }
    if (choice.run != TradeoffChoice::Run::kArithmetic || problem != nullptr) return;
    const ThreadLimit limit(options.threads);
    problem = std::make_unique<AdjustmentProblem>(
        simulated.block, options.groups, Simplified{}, options.priors);
    start = ComputeStartValues(problem.get(), progress).state;
    weights = problem->weights;
    best_arithmetic = RunArithmetic(Arithmetic::kExtended, Elimination::kQr, progress);
  }

  [[nodiscard]] TradeoffAnswer RunArithmetic(Arithmetic arithmetic,
                                             Elimination elimination,
                                             ProgressSink* progress) {
    problem->weights = weights;
    ArithmeticSolution solution =
        SolveInArithmetic(arithmetic, elimination, start, problem.get(), progress);
    TradeoffAnswer out;
    out.accepted = solution.solved;
    out.iterations = solution.iterations;
    out.corrections = problem->layout.parameters.size();
    out.note = std::move(solution.problem);
    out.covariance_m2 = std::move(solution.covariance_m2);
    out.position_m.assign(simulated.block.points.size(), Eigen::Vector3d::Constant(kNotGiven));
    for (std::size_t i = 0; i < out.position_m.size(); ++i) {
      if (solution.solved && problem->Solves(i)) out.position_m[i] = solution.state.Position(i);
    }
    return out;
  }

  [[nodiscard]] TradeoffAnswer Run(const TradeoffChoice& choice, ProgressSink* progress) {
    switch (choice.run) {
      case TradeoffChoice::Run::kIntersect:
        return AnswerOf(IntersectBlock(simulated.block, choice.options, progress),
                        choice.options.covariance);
      case TradeoffChoice::Run::kTwoLooks:
        return AnswerOf(IntersectBlock(*two_looks, choice.options, progress),
                        choice.options.covariance);
      case TradeoffChoice::Run::kArithmetic:
        return RunArithmetic(choice.arithmetic, choice.elimination, progress);
      default:
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
  impl_->options = reference.options;
  TradeoffChoice tight = reference;
  tight.options.tolerance_1 = kBestTolerance_1;
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
  std::vector<double> wall_s, cpu_s, peak_mib, own_s, ratio_1;
  TradeoffAnswer answer;
  try {
    impl_->Prepare(choice, progress);
    impl_->Prepare(reference, progress);
    const auto run_choice = [&] {
      answer = {};  // what it held is not the next run's
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
        ratio_1.push_back(row.reference ? 1.0 : reference_s / own_s[i]);
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
  row.speed_ratio_1 = Median(ratio_1);
  row.speed_low_1 = *std::min_element(ratio_1.begin(), ratio_1.end());
  row.speed_high_1 = *std::max_element(ratio_1.begin(), ratio_1.end());
  row.iterations = answer.iterations;
  row.corrections = answer.corrections;
  row.accepted = answer.accepted;
  row.note = answer.note;
  const bool arithmetic = choice.run == TradeoffChoice::Run::kArithmetic;
  row.errors = CompareAnswers(impl_->simulated.block,
                              answer,
                              arithmetic ? *impl_->best_arithmetic : impl_->best,
                              impl_->simulated.truth.points_m);
  return row;
}

}  // namespace sarblock
