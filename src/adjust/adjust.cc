// SPDX-License-Identifier: Apache-2.0
#include "adjust.h"

#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/model/result.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "adjust_given.h"
#include "block/plausibility.h"
#include "block/read_recorded.h"
#include "block/swath.h"
#include "core/memory.h"
#include "core/text.h"
#include "core/threads.h"
#include "model/priors.h"
#include "quality/assess.h"
#include "quality/covariance.h"
#include "reduction/frames.h"
#include "reduction/reduction.h"
#include "selection/candidates.h"
#include "selection/selection.h"
#include "selection/simplify.h"
#include "solve/inner_datum.h"
#include "solve/reduced_engine.h"
#include "solve/start.h"
#include "solve/structure.h"
#include "solve/weak_directions.h"

namespace sarblock {
namespace {

AdjustResult AdjustInGivenOrder(const Block& block,
                                const AdjustOptions& options,
                                const PointPairs& pairs,
                                ProgressSink* progress) {
  AdjustResult result = options.corrections == CorrectionChoice::kAuto
                            ? AdjustSelected(block, options, pairs, progress)
                            : AdjustGiven(block, options, {}, pairs, nullptr, progress);
  DescribePaths(block, options, &result);
  return result;
}

/// `order`: of the points of `block` meanwhile.
AdjustResult AdjustInOrder(PointOrder order,
                           const AdjustOptions& options,
                           const PointPairs& pairs,
                           ProgressSink* progress,
                           Block* block) {
  std::vector<StageCost> stages;
  std::optional<StageTimer> timer;
  timer.emplace("order", &stages);
  Step(progress, "order", 0, 2, "points by their passes");
  const OrderedPoints ordered(std::move(order), block);
  timer.reset();
  AdjustResult result;
  try {
    result = AdjustInGivenOrder(*block, options, ordered.Pairs(pairs), progress);
    Step(progress, "order", 1, 2, "points as the block lists them");
  } catch (...) {
    ordered.RestoreBlock();
    throw;
  }
  timer.emplace("order", &stages);
  ordered.RestoreResult(options.pairs != PairChoice::kList, &result);
  ordered.RestoreBlock();
  timer.reset();
  result.stages.insert(result.stages.begin(), stages.begin(), stages.end());
  return result;
}

/// Adjusts a block as it is, in the order of its passes where that helps.
AdjustResult AdjustReduced(const Block& block,
                           const AdjustOptions& options,
                           const PointPairs& pairs,
                           ProgressSink* progress) {
  PointOrder order = OrderByPasses(block);
  if (order.empty()) return AdjustInGivenOrder(block, options, pairs, progress);
  Block copy = block;
  return AdjustInOrder(std::move(order), options, pairs, progress, &copy);
}

}  // namespace

std::vector<Eigen::Vector3d> StartPositions(const Block& block, ProgressSink* progress) {
  AdjustmentProblem problem(block, {});
  const BlockState state = ComputeStartValues(&problem, progress).state;
  std::vector<Eigen::Vector3d> position_m;
  position_m.reserve(block.points.size());
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    position_m.push_back(state.Position(point));
  }
  return position_m;
}

AdjustResult SolveReduced(const Block& block,
                          ProgressSink* progress,
                          const std::function<AdjustResult(const Block&)>& solve) {
  constexpr int kMaxSolutions = 5;
  constexpr double kSettled_m = 1e-3;
  ReducedBlock reduced(block);
  if (reduced.HasModels()) reduced.ReduceAt(StartPositions(block, progress));
  AdjustResult result = solve(reduced.block());
  for (int solutions = 1; reduced.HasModels(); ++solutions) {
    const bool last = solutions == kMaxSolutions;
    const double change_m = reduced.ReduceAt(
        result.points.position_m, last ? std::numeric_limits<double>::infinity() : kSettled_m);
    if (!(change_m > kSettled_m)) break;
    if (last) {
      Warn(&result,
           "what is taken off the ranges still changed by " + Digits(change_m, 2) + " m after " +
               std::to_string(kMaxSolutions) + " solutions");
      break;
    }
    std::vector<StageCost> stages = std::move(result.stages);
    result = solve(reduced.block());
    result.stages.insert(result.stages.begin(), stages.begin(), stages.end());
  }
  result.reductions = reduced.Report();
  return result;
}

AdjustResult Adjust(const Block& block,
                    const AdjustOptions& asked,
                    const PointPairs& pairs,
                    ProgressSink* progress) {
  return CallInLibrary(asked.threads, progress, [&] {
    const AdjustOptions options = UsableOptions(block, asked, pairs, LookUse::kMeasured);
    AdjustResult result = SolveReduced(block, progress, [&](const Block& reduced) {
      return AdjustReduced(reduced, options, pairs, progress);
    });
    ScaleByPosterior(options, &result);
    WarnOfCurvatures(&result);
    return result;
  });
}

AdjustResult Adjust(Block* block,
                    const AdjustOptions& asked,
                    const PointPairs& pairs,
                    ProgressSink* progress) {
  return CallInLibrary(asked.threads, progress, [&] {
    const AdjustOptions options = UsableOptions(*block, asked, pairs, LookUse::kMeasured);
    AdjustResult result = SolveReduced(*block, progress, [&](const Block& reduced) {
      if (&reduced != block) return AdjustReduced(reduced, options, pairs, progress);
      PointOrder order = OrderByPasses(*block);
      return order.empty() ? AdjustInGivenOrder(*block, options, pairs, progress)
                           : AdjustInOrder(std::move(order), options, pairs, progress, block);
    });
    ScaleByPosterior(options, &result);
    WarnOfCurvatures(&result);
    return result;
  });
}

std::vector<std::string> MakePaths(Block* block) {
  Validate(*block);
  return ReadRecordedFlights(block);
}

namespace {

BlockCheck Checked(const Block& block, const AdjustOptions& options, ProgressSink* progress) {
  const CorrectionModel given = GivenCorrections(options);
  AdjustmentProblem problem(block, given.groups, {}, given.priors);
  BlockCheck check;
  check.corrections = problem.layout.size();
  const StartReport start = ComputeStartValues(&problem, progress);
  const PointDefects defects = FindPointDefects(problem, start.state);
  LeaveOutOpenPoints(defects, &problem);
  for (const Finding& finding : ExamineStructure(problem, start.state)) {
    check.findings.push_back(finding.text);
  }
  for (const Finding& finding : DescribePoints(problem, defects)) {
    check.findings.push_back(finding.text);
  }
  for (const std::string& remark : FindCopies(block).remarks) check.findings.push_back(remark);
  if (std::string doubt = DoubtOfPlates(block); !doubt.empty()) {
    check.findings.push_back(std::move(doubt));
  }
  // Where points are known: paths with errors intersect them far from where they are.
  for (std::string& text : FindLooksOutsideSwath(block, block.points.given_m, problem.look_used)) {
    check.findings.push_back(std::move(text));
  }
  ReducedSystem system(problem);
  check.needs = PredictNeeds(problem, options, &system);
  if (const std::string text = ProblemOfMemory(check.needs, options); !text.empty()) {
    check.findings.push_back(text);
  }
  return check;
}

}  // namespace

BlockCheck CheckBlock(const Block& block, const AdjustOptions& options, ProgressSink* progress) {
  return CallInLibrary(options.threads, progress, [&] {
    AdjustOptions used = options;
    if (used.threads <= 0) used.threads = ThreadsAllowed();
    Validate(block);
    ReducedBlock reduced(block);
    if (reduced.HasModels()) reduced.ReduceAt(StartPositions(block, progress));
    return Checked(reduced.block(), used, progress);
  });
}

namespace {

/// A datum by inner constraints moves with everything, and without covariance a robust solution has
/// no length to compare a step with: what was taken could not be verified.
bool CanVerify(const AdjustOptions& options) {
  const bool covariance = options.covariance != CovarianceLevel::kNone &&
                          options.covariance != CovarianceLevel::kLeberl;
  return options.datum == Datum::kGiven && (covariance || options.robust == RobustLoss::kNone);
}

}  // namespace

AdjustResult AdjustSelected(const Block& block,
                            const AdjustOptions& options,
                            const PointPairs& pairs,
                            ProgressSink* progress) {
  std::vector<StageCost> stages;
  SelectionReport report;
  Simplified simplified;
  const AtSelection simplify =
      [&](const AdjustmentProblem& problem, const BlockState& state, SelectionReport* selected) {
        const double max_shift = options.selection.simplify;
        selected->simplifications = BoundSimplifications(problem, state, max_shift);
        if (!CanVerify(options)) {
          for (SimplificationBound& bound : selected->simplifications) {
            if (bound.allowed) bound.verdict = "allowed, not taken: it could not be verified";
          }
          return;
        }
        simplified = ChooseSimplified(problem, state, max_shift, &selected->simplifications);
        if (simplified.any()) {
          selected->simplified_gain = MeasureGain(problem, state, simplified);
        }
      };
  {
    const StageTimer timer("select", &stages);
    report = SelectCorrections(block, options, simplify, progress);
  }
  AdjustOptions chosen = options;
  chosen.corrections = report.groups.empty() ? CorrectionChoice::kNone : CorrectionChoice::kGiven;
  chosen.groups = report.groups;
  AdjustResult result = AdjustSimplified(block, chosen, simplified, pairs, &report, progress);
  result.stages.insert(result.stages.begin(), stages.begin(), stages.end());
  for (ParameterResult& parameter : result.parameters) {
    parameter.kept = KeptText(report, parameter.owner, parameter.name);
  }
  if (options.selection.mode == SelectionOptions::Mode::kPerPass) {
    Warn(&result,
         "corrections were chosen for every pass by itself (selection.mode = \"per-pass\"): "
         "standard deviations take the choice of those that are kept for certain and are up to a "
         "fifth too small in simulated blocks; \"common\" states them realistically");
  }
  if (report.certain) {
    Warn(&result,
         "corrections that are not kept were left out: the solution does not converge with them; "
         "standard deviations take the choice for certain");
  }
  if (!report.settled) {
    Warn(&result,
         "the choice of corrections still changed after " + std::to_string(report.rounds) +
             " rounds");
  }
  result.selection = std::move(report);
  return result;
}

AdjustResult AdjustSimplified(const Block& block,
                              const AdjustOptions& options,
                              const Simplified& simplified,
                              const PointPairs& pairs,
                              SelectionReport* report,
                              ProgressSink* progress) {
  const double max_shift = options.selection.simplify;
  Simplified used = simplified;
  std::vector<SimplificationBound> bounds;
  double shift = kNotGiven;
  const AtSolution examine =
      [&](const AdjustmentProblem& problem, const BlockState& state, AdjustResult* result) {
        bounds = BoundSimplifications(problem, state, max_shift);
        if (used.any()) {
          shift = ShiftToFullModel(problem, state, result->points.covariance_m2, progress);
        }
      };
  AdjustResult result = AdjustGiven(block, options, used, pairs, examine, progress);
  std::vector<SimplificationBound>& said = report->simplifications;
  bool holds = true;
  if (simplified.any()) {
    holds = shift <= max_shift && bounds.size() == said.size();
    for (std::size_t k = 0; holds && k < bounds.size(); ++k) {
      holds = bounds[k].allowed || !said[k].taken;
    }
    report->simplified_shift = shift;
  }
  if (holds) {
    report->simplified = simplified;
  } else {
    used = {};
    std::vector<StageCost> stages = std::move(result.stages);
    result = AdjustGiven(block, options, used, pairs, examine, progress);
    result.stages.insert(result.stages.begin(), stages.begin(), stages.end());
  }
  for (std::size_t k = 0; k < bounds.size() && k < said.size(); ++k) {
    bounds[k].gain = said[k].gain;
    bounds[k].taken = said[k].taken && holds;
    if (said[k].taken && !holds) {
      bounds[k].verdict = "taken first and given up: the full model moved a point by " +
                          Digits(shift, 2) + " sigma";
    } else if (bounds[k].allowed && said[k].allowed) {
      bounds[k].verdict = said[k].verdict;
    } else if (bounds[k].allowed) {
      bounds[k].verdict = "allowed, not taken: it was above the limit before the adjustment";
    }
  }
  said = std::move(bounds);
  return result;
}

void RequireUsable(const Block& block, const PointPairs& pairs, LookUse use) {
  Validate(block);
  RequireAboveGround(block);
  RequireBodyFixedStates(block);
  const Looks& looks = block.looks;
  for (std::size_t i = 0; use == LookUse::kMeasured && i < looks.size(); ++i) {
    if (looks.rejected(i) || !(std::isnan(looks.time_s[i]) || std::isnan(looks.range_m[i])))
      continue;
    throw InputError(
        (std::isnan(looks.time_s[i]) ? "looks.time_s[" : "looks.range_m[") + std::to_string(i) +
            "]",
        "is not given; every look needs a time and a range, only Predict() fills them in");
  }
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto [a, b] = pairs[k];
    const std::size_t points = block.points.size();
    if (a != b && a < points && b < points) continue;
    throw InputError("pairs[" + std::to_string(k) + "]",
                     "must be two points below " + std::to_string(points) + ", got " +
                         std::to_string(a) + " and " + std::to_string(b));
  }
}

AdjustOptions UsableOptions(const Block& block,
                            const AdjustOptions& options,
                            const PointPairs& pairs,
                            LookUse use) {
  RequireUsable(block, pairs, use);
  RequireOffered(options);
  AdjustOptions out = options;
  if (out.threads <= 0) out.threads = ThreadsAllowed();
  if (pairs.empty()) return out;
  if (options.pairs != PairChoice::kNone && options.pairs != PairChoice::kList) {
    throw InputError("pairs",
                     "are listed, and the options ask for pairs of another choice; a list, or "
                     "options.pairs, is allowed");
  }
  out.pairs = PairChoice::kList;
  return out;
}

void RequireOffered(const AdjustOptions& options) {
  RequireInnerOffered(options);
  if (options.corrections == CorrectionChoice::kAuto && !options.priors.empty()) {
    throw InputError("adjust.prior", kNoAutomaticPriors);
  }
  for (const CorrectionGroup& group : options.groups) {
    if (options.corrections != CorrectionChoice::kAuto || !HasProcess(group)) continue;
    throw InputError("adjust.correction." + group.name + ".process", kNoAutomaticPriors);
  }
  if (options.quality.snooping != Snooping::kNone && options.robust != RobustLoss::kNone) {
    throw InputError("adjust.quality.snooping",
                     "tests least-squares residuals and excludes a robust loss; \"robust\" = "
                     "\"none\" is allowed with it, and snooping = \"robust\" starts from one");
  }
  if (options.ceres_solver != CeresSolver::kAuto && Resolve(options.engine) != Engine::kCeres) {
    throw InputError("adjust.ceres_solver",
                     "is a choice within engine = \"ceres\", which is not asked for");
  }
  if (Resolve(options.covariance_method) == CovarianceMethod::kCeres &&
      options.covariance != CovarianceLevel::kBlock) {
    throw InputError("adjust.covariance_method",
                     "'ceres' forms the covariance of level 'block' only; allowed: auto, reduced");
  }
}

void RefuseRepetition(const AdjustOptions& options, const char* command, AdjustResult* result) {
  if (options.covariance == CovarianceLevel::kMonteCarlo) {
    throw InputError("adjust.covariance",
                     std::string("'montecarlo' repeats an adjustment, which ") + command +
                         " does not make; none, leberl, intersection or block is allowed");
  }
  if (options.variance_components != VarianceComponents::kNone) {
    Warn(result, std::string("variance components are not estimated by ") + command);
  }
}

namespace {

void Restore(const PointOrder& back, PointResults* points) {
  Gather(back, &points->status);
  Gather(back, &points->reason);
  Gather(back, &points->looks);
  Gather(back, &points->position_m);
  Gather(back, &points->covariance_m2);
  Gather(back, &points->fixed_path_covariance_m2);
  Gather(back, &points->intersection_rad);
  for (const auto figure : kAccuracyFigures) Gather(back, &(points->*figure));
}

void Restore(const PointOrder& back, MonteCarloReport* report) {
  Gather(back, &report->sample_m2);
  Gather(back, &report->square);
  for (std::vector<std::uint32_t>& inside : report->inside) Gather(back, &inside);
}

/// Restores the points of a list to their order before, and sorts the list by them.
template <typename Listed>
void RestoreListed(const PointOrder& order, std::vector<Listed>* list) {
  for (Listed& listed : *list) listed.point = order[listed.point];
  std::stable_sort(list->begin(), list->end(), [](const Listed& a, const Listed& b) {
    return a.point < b.point;
  });
}

/// A pair the other way round: b - a in the axes at a becomes a - b in those at b.
void TurnRound(const Frame& frame,
               const std::vector<Eigen::Vector3d>& position_m,
               PairResult* pair) {
  const Eigen::Matrix3d turn =
      frame.EnuFromFrame(position_m[pair->b]) * frame.EnuFromFrame(position_m[pair->a]).transpose();
  pair->difference_enu_m = -(turn * pair->difference_enu_m);
  pair->covariance_m2 = SymmetricOf(turn * MatrixOf(pair->covariance_m2) * turn.transpose());
  std::swap(pair->a, pair->b);
}

/// The tests of control change their place in `control_quality`.
void RestoreControl(const PointOrder& order, AdjustResult* result) {
  std::vector<ControlQuality>& tests = result->control_quality;
  if (tests.empty()) return;
  const ControlQuality worst = tests[result->assessment.tests.worst_control];
  RestoreListed(order, &tests);
  const auto found = std::find_if(tests.begin(), tests.end(), [&](const ControlQuality& test) {
    return test.point == order[worst.point] && test.component == worst.component;
  });
  result->assessment.tests.worst_control = static_cast<std::size_t>(found - tests.begin());
}

}  // namespace

OrderedPoints::OrderedPoints(PointOrder order, Block* block)
    : order_(std::move(order)), back_(InverseOf(order_)), block_(block) {
  ReorderPoints(order_, block_);
}

void OrderedPoints::RestoreBlock() const { ReorderPoints(back_, block_); }

PointPairs OrderedPoints::Pairs(PointPairs pairs) const {
  for (auto& [a, b] : pairs) {
    a = back_[a];
    b = back_[b];
  }
  return pairs;
}

void OrderedPoints::RestoreResult(bool sort_pairs, AdjustResult* result) const {
  const std::vector<std::uint64_t>& offsets = block_->looks.offsets;
  const std::vector<std::uint64_t> before = ReorderedOffsets(back_, offsets);
  const auto restore_look = [&](std::uint64_t* look) {
    const std::size_t place = block_->looks.PointOf(*look);
    *look = before[order_[place]] + (*look - offsets[place]);
  };
  const auto by_look = [&](auto* column) { GatherRanges(back_, offsets, before, column); };

  Restore(back_, &result->points);
  if (result->montecarlo) Restore(back_, &*result->montecarlo);
  by_look(&result->looks.range_residual_m);
  by_look(&result->looks.azimuth_residual_m);
  by_look(&result->looks.weight);
  by_look(&result->looks.rejected);
  by_look(&result->looks.reason);
  for (auto* columns :
       {&result->quality.redundancy, &result->quality.w, &result->quality.shift_m}) {
    for (std::vector<float>& column : *columns) by_look(&column);
  }
  RestoreControl(order_, result);
  RestoreListed(order_, &result->checks);
  for (PairResult& pair : result->pairs) {
    pair.a = order_[pair.a];
    pair.b = order_[pair.b];
    if (sort_pairs && pair.a > pair.b) {
      TurnRound(block_->frame, result->points.position_m, &pair);
    }
  }
  if (sort_pairs) {
    std::sort(
        result->pairs.begin(), result->pairs.end(), [](const PairResult& a, const PairResult& b) {
          return std::tie(a.a, a.b) < std::tie(b.a, b.b);
        });
  }
  for (TestedLook& test : result->assessment.tests.worst) {
    restore_look(&test.look);
    test.point = order_[test.point];
  }
  if (!result->snooping) return;
  for (BlunderFinding& finding : result->snooping->findings) {
    finding.point = order_[finding.point];
    for (std::uint64_t& look : finding.looks) restore_look(&look);
  }
  // What a consensus left out, round 0, is in the order of the points, all else as it was
  // found.
  std::vector<BlunderFinding>& findings = result->snooping->findings;
  const auto searched =
      std::find_if(findings.begin(), findings.end(), [](const BlunderFinding& finding) {
        return finding.round > 0;
      });
  std::stable_sort(
      findings.begin(), searched, [](const BlunderFinding& a, const BlunderFinding& b) {
        return a.point < b.point;
      });
  for (std::uint64_t& look : result->snooping->robust) restore_look(&look);
  std::sort(result->snooping->robust.begin(), result->snooping->robust.end());
}

}  // namespace sarblock
