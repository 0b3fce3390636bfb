// SPDX-License-Identifier: Apache-2.0
#include "consensus_search.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "blunder_search.h"
#include "model/problem.h"
#include "normals/point.h"
#include "solve/consensus.h"
#include "solve/rank.h"
#include "solve/solve_block.h"

namespace sarblock {
namespace {

/// Above this variance factor no error of the standard deviations is likely.
constexpr double kGross = 10.0;
/// Level of the global test where what is wrong was to be left out.
constexpr double kTest = 0.999;
/// Looks that a consensus leaves out by chance, and what each takes off v'Pv.
constexpr double kFew = 0.01, kSquareOfOne = 20.0;
/// Sigmas of its prior that no correction is away: careless priors are two or three times too
/// small.
constexpr double kFarFromPrior = 8.0;

/// What a trial changes.
struct Snapshot {
  explicit Snapshot(const Solution& solution)
      : participation(*solution.problem),
        state(*solution.state),
        solve(*solution.solve),
        defects(*solution.defects) {}
  void Restore(const Solution& solution) {
    participation.Restore(solution.problem);
    *solution.state = std::move(state);
    *solution.solve = std::move(solve);
    *solution.defects = std::move(defects);
  }
  Participation participation;
  BlockState state;
  SolveReport solve;
  PointDefects defects;
};

std::vector<BlunderFinding> FindingsOf(const ConsensusReport& report) {
  std::vector<BlunderFinding> findings;
  for (const ConsensusReport::PointRejection& of : report.left_out) {
    BlunderFinding finding;
    finding.point = static_cast<std::uint32_t>(of.point);
    finding.w = of.distance;
    finding.azimuth = of.azimuth;
    finding.action = of.contradiction ? BlunderFinding::Action::kPointLeftOut
                                      : BlunderFinding::Action::kRejected;
    if (of.contradiction) {
      finding.looks.assign(of.looks.begin(), of.looks.end());
      findings.push_back(std::move(finding));
      continue;
    }
    for (const std::size_t look : of.looks) {
      finding.looks.assign(1, look);
      findings.push_back(finding);
    }
  }
  return findings;
}

/// The first pass whose control decides nothing.
std::optional<std::size_t> FirstUndecided(const std::vector<LookCounts>& by_pass) {
  for (std::size_t pass = 0; pass < by_pass.size(); ++pass) {
    if (!by_pass[pass].Decide()) return pass;
  }
  return std::nullopt;
}

/// Sums for the test of the solution; under a loss over the looks that it would keep.
struct Remainder {
  double redundancy = 0.0;
  double square_sum = 0.0;
  std::size_t looks = 0, dropped = 0;
  std::size_t control = 0, control_dropped = 0;  ///< control points; those that keep no look
  std::vector<LookCounts> control_looks = {};    ///< by pass; only under a loss
  std::vector<PassLooks> by_pass = {};           ///< only under a loss
};

Remainder RemainderOf(const AdjustOptions& options, const Solution& solution) {
  const AdjustmentProblem& problem = *solution.problem;
  const ProblemCounts counts = CountProblem(problem);
  Remainder rest{counts.redundancy(), 2.0 * (*solution.system)->cost(), counts.looks};
  if (options.robust == RobustLoss::kNone) return rest;
  std::vector<std::uint8_t> look_used = problem.look_used;
  rest.control_looks.resize(problem.block.passes.size());
  const double limit = FarSquare();
  const auto& offsets = problem.block.looks.offsets;
  WhitenedLook at;
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (!problem.Solves(point)) continue;
    double near_square = 0.0, far_square = 0.0;
    std::size_t near = 0, far = 0;
    for (std::size_t i = offsets[point]; i < offsets[point + 1]; ++i) {
      if (problem.look_used[i] == 0) continue;
      if (!EvaluateWhitened(problem, *solution.state, {}, point, i, &at)) continue;
      const bool is_far = at.whitened_error.squaredNorm() > limit;
      (is_far ? far_square : near_square) += at.whitened_error.squaredNorm();
      ++(is_far ? far : near);
      if (is_far) look_used[i] = 0;
      if (problem.control_of[point] < 0) continue;
      LookCounts& of_pass = rest.control_looks[problem.block.looks.pass[i]];
      ++(is_far ? of_pass.lost : of_pass.kept);
    }
    if (problem.control_of[point] >= 0) {
      ++rest.control;
      rest.control_dropped += near == 0 ? 1U : 0U;
    }
    const bool lost = near < 2 && problem.control_of[point] < 0 && far > 0;  // with all its looks
    if (lost) {
      for (std::size_t i = offsets[point]; i < offsets[point + 1]; ++i) look_used[i] = 0;
    }
    rest.dropped += lost ? near + far : far;
    rest.square_sum -= lost ? near_square + far_square : far_square;
    rest.redundancy -=
        lost ? 2.0 * static_cast<double>(near + far) - 3.0 : 2.0 * static_cast<double>(far);
  }
  rest.by_pass = CountPassLooks(problem.block, look_used);
  return rest;
}

bool FailsTest(const Remainder& rest, double limit) {
  return rest.redundancy > 0.0 && rest.square_sum > limit;
}

/// Takes back what a search left out of the looks at control points, and of what it reports.
void TakeControlBack(AdjustmentProblem* problem, SnoopingReport* report) {
  const Block& block = problem->block;
  std::erase_if(report->findings, [&](const BlunderFinding& finding) {
    const bool left_out = finding.action == BlunderFinding::Action::kRejected ||
                          finding.action == BlunderFinding::Action::kPointLeftOut;
    if (!left_out || block.points.role[finding.point] != PointRole::kControl) return false;
    std::vector<std::size_t> looks;
    for (const std::uint64_t look : finding.looks) {
      if (!block.looks.rejected(look)) looks.push_back(look);
    }
    problem->TakeBack(finding.point, looks);
    return true;
  });
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    if (block.points.role[point] != PointRole::kControl) continue;
    for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      if (std::erase(report->robust, i) > 0) problem->TakeBack(point, {i});
    }
  }
}

/// Whether most points that no control holds lie where their looks do not see them: a solution that
/// ended there without converging has no way back.
bool MostAreMirrorSolutions(const Solution& solution) {
  const AdjustmentProblem& problem = *solution.problem;
  const auto lost = MirrorSolutions(problem, *solution.state, **solution.system).size();
  std::size_t points = 0;
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    points += problem.Solves(point) && problem.control_of[point] < 0 ? 1U : 0U;
  }
  return 2 * lost > points;
}

bool Converged(const AdjustOptions& options, const Solution& solution, ProgressSink* progress) {
  if (solution.solve->converged) return true;
  if (options.robust == RobustLoss::kNone) return false;
  return NewtonDecrementUnderLoss({options.robust, RobustScale(options)},
                                  *solution.problem,
                                  *solution.state,
                                  progress) <= kRemainingRobustStepAccepted;
}

}  // namespace

std::optional<std::size_t> PassThatLosesControl(const AdjustmentProblem& problem) {
  const Block& block = problem.block;
  std::vector<LookCounts> by_pass(block.passes.size());
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    if (block.points.role[point] != PointRole::kControl) continue;
    for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      if (block.looks.rejected(i)) continue;
      LookCounts& of_pass = by_pass[block.looks.pass[i]];
      ++(problem.look_used[i] != 0 ? of_pass.kept : of_pass.lost);
    }
  }
  return FirstUndecided(by_pass);
}

bool ContradictsPriors(const AdjustmentProblem& problem, const BlockState& state) {
  for (std::size_t i = 0; i < problem.layout.parameters.size(); ++i) {
    const Parameter& parameter = problem.layout.parameters[i];
    const double value = state.corrections[static_cast<Eigen::Index>(i)];
    if (parameter.has_prior() &&
        std::abs(value - parameter.prior_value) > kFarFromPrior * parameter.prior_sigma) {
      return true;
    }
    if (parameter.before >= 0 && std::abs(problem.layout.StepOf(i, state.corrections)) >
                                     kFarFromPrior * parameter.step_sigma) {
      return true;
    }
  }
  // Each parameter beside the others of its prior, normal as it is alone.
  for (const JointPriorTerm& prior : problem.layout.joint_priors) {
    const Eigen::VectorXd x = problem.layout.FromPrior(prior, state.corrections);
    const Eigen::VectorXd w =
        (prior.information * x).cwiseQuotient(prior.information.diagonal().cwiseSqrt());
    if (w.cwiseAbs().maxCoeff() > kFarFromPrior) return true;
  }
  return false;
}

Contradiction FindContradiction(const AdjustOptions& options, const Solution& solution) {
  const AdjustmentProblem& problem = *solution.problem;
  const bool mirrored =
      std::find(problem.mirrored.begin(), problem.mirrored.end(), 1) != problem.mirrored.end();
  if (mirrored) return Contradiction::kGross;
  if (!Converged(options, solution, nullptr)) {
    // A lowered limit is a wish to see where the steps end.
    const bool limited = options.max_iterations < AdjustOptions{}.max_iterations;
    return limited ? Contradiction::kNone : Contradiction::kUnsolved;
  }
  if (ContradictsPriors(problem, *solution.state)) return Contradiction::kGross;
  Remainder rest = RemainderOf(options, solution);
  const bool many =
      static_cast<double>(rest.dropped) > kMaxLeftOut * static_cast<double>(rest.looks);
  // A loss or a search that lets go of the control, of all of it or of that of a pass, has settled
  // somewhere else.
  const bool leaves_out =
      options.robust != RobustLoss::kNone || options.quality.snooping != Snooping::kNone;
  if (leaves_out && rest.by_pass.empty()) {
    rest.by_pass = CountPassLooks(problem.block, problem.look_used);
  }
  const bool adrift = 2 * rest.control_dropped > rest.control ||
                      FirstUndecided(rest.control_looks) || PassThatLosesControl(problem) ||
                      (leaves_out && UndecidedPass(rest.by_pass));
  const bool gross = !options.scale_by_posterior && FailsTest(rest, kGross * rest.redundancy);
  if (many || adrift || gross) return Contradiction::kGross;
  if (!leaves_out || !(rest.redundancy > 0.0)) return Contradiction::kNone;
  return PassThatLosesMore(rest.by_pass) ||
                 FailsTest(rest, ChiSquareQuantile(kTest, rest.redundancy))
             ? Contradiction::kTest
             : Contradiction::kNone;
}

ConsensusOutcome SearchByConsensus(const AdjustOptions& asked,
                                   const Solution& solution,
                                   ProgressSink* progress) {
  Snapshot before(solution);
  const bool was_one = solution.solve->converged && *solution.system;
  const double square_sum_before = was_one ? 2.0 * (*solution.system)->cost() : 0.0;
  AdjustOptions options = asked;
  options.robust = RobustLoss::kNone;
  AdjustmentProblem* problem = solution.problem;
  BlockState* state = solution.state;
  const auto form = [&] {
    solution.system->emplace(*problem, KeptFactors::kMaxBytes);
    (*solution.system)->Form(*state, {}, progress);
  };
  const auto recover = [&] {
    RecoverMirrorSolutions(
        options, problem, state, solution.solve, solution.system, solution.defects, progress);
  };
  ConsensusOutcome outcome;
  const auto try_it = [&]() -> std::optional<SnoopingReport> {
    const ConsensusReport consensus = SolveByConsensus(options, problem, state, progress);
    if (!consensus.scattered) return std::nullopt;
    RequireSolvable(*problem);
    solution.solve->iterations += consensus.iterations;
    SolveOnce(options, problem, state, solution.solve, solution.system, progress);
    if (!solution.solve->converged && MostAreMirrorSolutions(solution)) return std::nullopt;
    recover();
    if (!solution.solve->converged) return std::nullopt;
    // The same solution, even if tests fail: priors are too tight, or noise is larger than
    // stated.
    const auto left_out = static_cast<double>(consensus.left_out.size());
    outcome.agreed =
        was_one && left_out <= kFew * static_cast<double>(problem->look_used.size()) &&
        2.0 * (*solution.system)->cost() > square_sum_before - kSquareOfOne * (1.0 + left_out);
    if (outcome.agreed) return std::nullopt;
    const auto again = [&](RobustLoss loss) {
      AdjustOptions with_loss = options;
      with_loss.robust = loss;
      SolveOnce(with_loss, problem, state, solution.solve, nullptr, progress);
    };
    std::optional<SnoopingReport> report =
        SearchBlunders(options, again, problem, state, progress, FindingsOf(consensus));
    if (report && PassThatLosesControl(*problem)) {
      // Without the errors among the tie points control may determine the path that it belongs to.
      TakeControlBack(problem, &*report);
      again(RobustLoss::kNone);
      const std::vector<std::uint64_t> robust = std::move(report->robust);
      report =
          SearchBlunders(options, again, problem, state, progress, std::move(report->findings));
      if (report) report->robust.insert(report->robust.begin(), robust.begin(), robust.end());
    }
    if (!report) return std::nullopt;
    form();
    recover();
    const Remainder rest = RemainderOf(options, solution);
    const bool fails =
        rest.redundancy > 0.0 && FailsTest(rest, ChiSquareQuantile(kTest, rest.redundancy));
    if (!solution.solve->converged || fails || PassThatLosesControl(*problem)) return std::nullopt;
    return report;
  };
  try {
    outcome.adopted = try_it();
  } catch (const UndeterminedError&) {
    outcome.adopted.reset();
  }
  outcome.agreed = outcome.agreed || outcome.adopted.has_value();
  if (!outcome.adopted) {
    before.Restore(solution);
    form();
  }
  return outcome;
}

std::string DescribeConsensus(const AdjustmentProblem& problem, const SnoopingReport& report) {
  std::size_t looks = 0, points = 0, first = problem.block.points.size();
  for (const BlunderFinding& finding : report.findings) {
    if (finding.action == BlunderFinding::Action::kRejected) looks += finding.looks.size();
    if (finding.action != BlunderFinding::Action::kPointLeftOut) continue;
    ++points;
    first = std::min<std::size_t>(first, finding.point);
  }
  std::string text = "the block contradicts itself as it was given and was solved by consensus: ";
  if (looks + points == 0) return text + "nothing had to be left out";
  text += std::to_string(looks) + " looks that disagree with the others of their point";
  if (points > 0) {
    text += " and " + std::to_string(points) +
            " points whose looks contradict each other, the first is " +
            std::string(problem.block.points.ids[first]) + ",";
  }
  return text + " are left out";
}

}  // namespace sarblock
