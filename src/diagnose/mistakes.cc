// SPDX-License-Identifier: Apache-2.0
#include "mistakes.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/geometry/look_equations.h"
#include "sarblock/model/options.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include "core/text.h"
#include "linear/dense.h"
#include "normals/point.h"
#include "normals/reduced_system.h"
#include "quality/covariance.h"
#include "quality/point_sweep.h"
#include "quality/verdict_tests.h"
#include "sample.h"
#include "solve/rank.h"
#include "solve/reduced_engine.h"
#include "solve/start.h"

namespace sarblock {
namespace {

template <typename... Values>
std::string Print(const char* format, Values... values) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

std::string Joined(const std::vector<std::string>& names) {
  constexpr std::size_t kNamed = 4;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kNamed); ++i) {
    text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  }
  if (names.size() > kNamed) text += " and " + std::to_string(names.size() - kNamed) + " more";
  return text;
}

/// Never 100 % unless nothing is left.
std::string Percent(double part) {
  return Print("%.2f", std::min(99.99, 100.0 * std::max(0.0, part))) + " %";
}

}  // namespace

std::string Short(double value) { return Digits(value, 4); }

std::string InFiles(double value, double sigma) {
  constexpr int kFewest = 4, kExact = 10, kMost = 16;
  if (!(sigma > 0.0) || !std::isfinite(sigma) || value == 0.0) return Digits(value, kExact);
  const auto order = [](double x) { return static_cast<int>(std::floor(std::log10(std::abs(x)))); };
  return Digits(value, std::clamp(order(value) - order(sigma) + 2, kFewest, kMost));
}

Size SizeOf(double value, double sigma, const std::string& unit) {
  const bool none = unit.empty() || unit == "1";
  return {value, sigma, ValueWithSigma(value, sigma) + (none ? "" : " " + unit)};
}

std::string Equals(const std::vector<KnownNumber>& numbers, double value, double sigma) {
  const double tolerance = std::max(sigma > 0.0 ? 4.0 * sigma : 0.0, 1e-3 * std::abs(value));
  if (!(tolerance < 0.1 * std::abs(value))) return "";
  const KnownNumber* nearest = nullptr;
  for (const KnownNumber& number : numbers) {
    const double off = std::abs(value - number.value);
    if (off > tolerance) continue;
    if (nearest == nullptr || off < std::abs(value - nearest->value)) nearest = &number;
  }
  return nearest == nullptr ? "" : nearest->text;
}

std::string PassWords(const std::vector<std::string>& passes) {
  if (passes.empty()) return "all passes";
  return (passes.size() == 1 ? "pass " : "passes ") + Joined(passes);
}

std::string PassesPhrase(const std::vector<std::string>& passes) {
  return "of " + (passes.empty() ? std::string("all passes") : Joined(passes));
}

std::string SentenceOf(const Hypothesis& hypothesis,
                       const Size& size,
                       const std::string& detail,
                       const Explanation& explanation) {
  std::string text = hypothesis.says(size);
  if (!explanation.equals.empty()) text += " (" + explanation.equals + ")";
  if (!detail.empty()) text += ", " + detail;
  if (hypothesis.kind != MistakeKind::kSigma || explanation.part > 0.0) {
    text += ": takes " + Percent(explanation.part) + " of v'Pv";
  }
  if (explanation.looks_lost_before > explanation.looks_lost_after) {
    text += Print(" and finds a place for %zu looks",
                  explanation.looks_lost_before - explanation.looks_lost_after);
  }
  const double left = explanation.square_sum_after / explanation.redundancy_after;
  if (left > 2.0 || explanation.looks_lost_after > 0) {
    text += " but does not explain all (v'Pv over redundancy " + Short(left) + " is left)";
  }
  const Explanation::Cure& cure = explanation.cure;
  if (cure.tried) {
    text += cure.cures ? "; with it the whole block is sound: s0^2 of looks and control "
                       : "; of the whole block it is a part: s0^2 of looks and control ";
    text += Short(cure.factor) + " (" + Short(cure.lower) + " to " + Short(cure.upper) +
            " is expected)";
    if (std::isfinite(cure.priors_factor)) text += ", of priors " + Short(cure.priors_factor);
  }
  return text + "; " + explanation.change;
}

namespace {

constexpr int kQuicklyFormed = 6, kMaxFormations = 16;
/// Steps of an intersection to start from: circles far from each other creep.
constexpr int kStepsToStart = 12;
/// Newton decrement in sigmas: v'Pv to its square.
constexpr double kSettledDecrement = 0.03;

/// Looks of the sample that ought to have a place: not rejected, of control or of points with two
/// looks. A check point is solved like a tie point.
bool Counts(const Block& sample, std::size_t point, std::size_t look) {
  if (sample.looks.rejected(look)) return false;
  if (sample.points.role[point] == PointRole::kControl) return true;
  std::size_t looks = 0;
  for (std::size_t i = sample.looks.offsets[point]; i < sample.looks.offsets[point + 1]; ++i) {
    looks += sample.looks.rejected(i) ? 0U : 1U;
  }
  return looks >= 2;
}

void CountPlaces(const AdjustmentProblem& problem, Fit* fit) {
  const Block& sample = problem.block;
  WhitenedLook at;
  for (std::size_t point = 0; point < sample.points.size(); ++point) {
    for (std::size_t i = sample.looks.offsets[point]; i < sample.looks.offsets[point + 1]; ++i) {
      if (!Counts(sample, point, i)) continue;
      bool placed = problem.Solves(point) && problem.look_used[i] != 0;
      if (placed) {
        const auto observation = problem.model.FixPath(i, fit->state.corrections);
        placed = observation &&
                 LiesWhereItLooks(sample.frame, *observation, fit->state.Position(point)) &&
                 EvaluateWhitened(problem, fit->state, {}, point, i, &at);
      }
      ++(placed ? fit->looks : fit->lost);
    }
  }
}

/// Start values from a state of the same points. What has no place there is left out.
BlockState Continue(const BlockState& warm, AdjustmentProblem* problem) {
  BlockState state = warm;
  if (state.corrections.size() != problem->layout.size()) {
    state.corrections = Eigen::VectorXd::Zero(problem->layout.size());
  }
  const auto& offsets = problem->block.looks.offsets;
  for (std::size_t point = 0; point < problem->block.points.size(); ++point) {
    if (!state.Position(point).allFinite()) {
      problem->LeaveOut(point, PointStatus::kUndetermined, "no place");
      continue;
    }
    for (std::size_t i = offsets[point]; i < offsets[point + 1]; ++i) {
      if (problem->look_used[i] != 0 && !problem->model.FixPath(i, state.corrections)) {
        problem->look_used[i] = 0;
      }
    }
    if (const auto lacks = problem->LacksEquations(point)) {
      problem->LeaveOut(point, *lacks, "no place");
    }
  }
  UpdateWeights(state, problem);
  return state;
}

}  // namespace

bool IsNear(const Fit& fit) {
  constexpr double kNear = 30.0;
  return fit.solved && fit.lost == 0 && fit.square_sum < kNear * fit.redundancy;
}

double Fit::SquareSum() const { return square_sum + kLost * static_cast<double>(lost); }

Fit SolveSample(const Block& sample,
                const CorrectionModel& corrections,
                const FitOptions& asked,
                ProgressSink* progress) {
  Fit fit;
  try {
    AdjustmentProblem problem(sample, corrections.groups, {}, corrections.priors);
    const bool fits = asked.warm != nullptr && asked.warm->start_m.size() == sample.points.size();
    fit.state = fits ? Continue(*asked.warm, &problem)
                     : std::move(ComputeStartValues(&problem, progress, kStepsToStart).state);
    SolveOptions options;
    options.useless_above = asked.useless_above;
    options.max_formed = asked.effort == Effort::kQuick ? kQuicklyFormed : kMaxFormations;
    options.settle_below = kSettledDecrement;
    ReducedSystem system(problem);
    const SolveReport report = SolveReduced(problem, {}, options, &system, &fit.state, progress);
    fit.formed = report.formed;
    fit.settled = report.converged;
    UpdateWeights(fit.state, &problem);
    system.Form(fit.state, {}, progress);
    fit.square_sum = 2.0 * system.cost();
    fit.counts = CountProblem(problem);
    fit.redundancy = fit.counts.redundancy();
    CountPlaces(problem, &fit);
    fit.solved = std::isfinite(fit.square_sum) && fit.looks > 0;
  } catch (const Interrupted&) {
    throw;
  } catch (const std::exception&) {  // what cannot be solved explains nothing
    fit.solved = false;
  }
  if (!fit.solved) {
    fit.square_sum = 0.0;
    fit.lost = sample.looks.size();
  }
  return fit;
}

PriorSums PriorsOf(const Block& sample, const CorrectionModel& corrections, const Fit& fit) {
  if (!fit.solved) return {};
  try {
    AdjustmentProblem problem(sample, corrections.groups, {}, corrections.priors);
    if (problem.layout.size() == 0) return {};
    const BlockState state = Continue(fit.state, &problem);
    ReducedSystem system(problem);
    system.Form(state, {}, nullptr);
    FactorRegular(&system);
    return SumPriors(
        problem.layout, state.corrections, ParameterCovariances(system, system.SelectedInverse()));
  } catch (const Interrupted&) {
    throw;
  } catch (const std::exception&) {  // no covariance where directions are open
    return {};
  }
}

SampleResiduals ResidualsOf(const Block& sample,
                            const CorrectionModel& corrections,
                            const Fit& fit) {
  const auto looks = static_cast<Eigen::Index>(sample.looks.size());
  SampleResiduals out{Eigen::MatrixX2d::Constant(looks, 2, kNotGiven),
                      Eigen::MatrixX2d::Constant(looks, 2, kNotGiven),
                      0.0,
                      0.0};
  if (!fit.solved) return out;
  AdjustmentProblem problem(sample, corrections.groups, {}, corrections.priors);
  UpdateWeights(fit.state, &problem);
  WhitenedLook at;
  PointLinearization linearized(problem, fit.state, nullptr, false);
  for (std::size_t point = 0; point < sample.points.size(); ++point) {
    if (!fit.state.Position(point).allFinite()) continue;
    for (std::size_t i = sample.looks.offsets[point]; i < sample.looks.offsets[point + 1]; ++i) {
      if (sample.looks.rejected(i)) continue;
      if (EvaluateWhitened(problem, fit.state, {}, point, i, &at)) {
        out.whitened_errors.row(static_cast<Eigen::Index>(i)) = at.whitened_error.transpose();
      }
    }
    if (!problem.Solves(point)) continue;
    const PointResiduals residuals = linearized.At(point).Information();
    for (Eigen::Index k = 0; k < residuals.size(); ++k) {
      const double redundancy = 1.0 - residuals.information.row(k).squaredNorm();
      const auto look = static_cast<std::size_t>(k / 2);
      if (look < residuals.looks.size()) {
        out.redundancy(static_cast<Eigen::Index>(residuals.looks[look]), k % 2) = redundancy;
      } else {
        out.known_redundancy += redundancy;
        out.known_square += residuals.v[k] * residuals.v[k];
      }
    }
  }
  return out;
}

namespace {

constexpr int kQuickRounds = 2, kMaxRounds = 6;
/// A size counts as found when it moves by less than this part of its standard deviation.
constexpr double kFound = 0.05;

bool CanFixPoint(const KnownPosition& known) {
  int fixed = 0;
  for (const bool component : known.fixed) fixed += component ? 1 : 0;
  if (fixed < 3) return fixed > 0;
  return dense::LowerFactor(known.covariance_enu_m2).has_value();
}

/// Sum of r ln sigma^2 of all measurements.
double LogSigmas(const Block& block, const Eigen::MatrixX2d& redundancy) {
  double sum = 0.0;
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    const LookSigma sigma = block.SigmaOf(i);
    const auto r = redundancy.row(static_cast<Eigen::Index>(i));
    sum += 2.0 * (r[0] * std::log(sigma.range_m) + r[1] * std::log(sigma.azimuth));
  }
  return sum;
}

void FixCheckPoints(Block* block) {
  for (const KnownPosition& known : block->points.known) {
    PointRole& role = block->points.role[known.point];
    if (role == PointRole::kCheck && CanFixPoint(known)) role = PointRole::kControl;
  }
}

constexpr double kMaxLogMove = 3.0;
/// Largest decrease of the cost held possible, in multiples of that of the parabola through three
/// solutions.
constexpr double kPromised = 4.0;

}  // namespace

Trials::Trials(const Block& sample, CorrectionModel corrections, Work work, ProgressSink* progress)
    : sample_(sample),
      given_(sample),
      corrections_(std::move(corrections)),
      work_(work),
      progress_(progress) {
  FixCheckPoints(&given_);
  for (const Pass& pass : sample_.passes) states_ += pass.RecordedStates().size();
}

Fit Trials::Solve(const Block& block,
                  const CorrectionModel& corrections,
                  const FitOptions& options) {
  ++solutions_;
  Fit fit = SolveSample(block, corrections, options, progress_);
  if (fit.solved) fit.redundancy -= empty_priors_;
  const auto start = options.warm == nullptr ? Work::Start::kCold : Work::Start::kWarm;
  work_.AddSolution(block.looks.size(), fit, start, states_);
  return fit;
}

Fit Trials::SolveGiven() { return Solve(given_, corrections_, {}); }

Fit Trials::SolveWithout(const std::vector<std::uint32_t>& points, const FitOptions& options) {
  std::vector<std::uint8_t>& flags = given_.looks.flags;
  const std::vector<std::uint8_t> before = flags;
  for (const std::uint32_t point : points) {
    for (std::size_t i = given_.looks.offsets[point]; i < given_.looks.offsets[point + 1]; ++i) {
      flags[i] |= Looks::kRejected;
    }
  }
  Fit fit = Solve(given_, corrections_, options);
  flags = before;
  return fit;
}

Fit Trials::With(const Hypothesis& hypothesis, double value, const FitOptions& options) {
  Block block = sample_;
  hypothesis.undo(&block, value);
  FitStrips(&block);
  FixCheckPoints(&block);
  work_.AddSmoothed(hypothesis.smoothed_states);
  CorrectionModel corrections = corrections_;
  if (hypothesis.remodel) hypothesis.remodel(&corrections, value);
  Fit fit = Solve(block, corrections, options);
  fit.log_sigmas = hypothesis.log_cost * value;
  if (block.looks.size() == static_cast<std::size_t>(redundancy_.rows())) {
    fit.log_sigmas += LogSigmas(block, redundancy_) - LogSigmas(sample_, redundancy_);
  }
  return fit;
}

Solved SearchSize(const Hypothesis& hypothesis,
                  const Fit& first,
                  const SearchOptions& options,
                  Trials* trials) {
  Solved best{hypothesis.value, kNotGiven, first};
  if (!hypothesis.free || !first.solved) return best;
  double step = hypothesis.step;
  const auto at = [&](double value) {
    return trials->With(hypothesis, value, {.warm = &best.fit.state, .effort = options.effort});
  };
  const int rounds = options.effort == Effort::kQuick ? kQuickRounds : kMaxRounds;
  for (int round = 0; round < rounds; ++round) {
    if (!trials->work().Allows(options.part_of_work)) break;
    Fit above = at(best.value + step), below = at(best.value - step);
    const double cost_here = best.fit.Cost();
    const double slope = (above.Cost() - below.Cost()) / (2.0 * step);
    const double curvature = (above.Cost() - 2.0 * cost_here + below.Cost()) / (step * step);
    const auto take = [&best](double value, Fit fit) {
      if (!fit.solved || !(fit.Cost() < best.fit.Cost())) return false;
      best.fit = std::move(fit);
      best.value = value;
      return true;
    };
    if (!(curvature > 0.0) || !std::isfinite(curvature)) {
      const double from = best.value;
      if (!take(from + step, std::move(above))) take(from - step, std::move(below));
      step *= 4.0;
      continue;
    }
    best.sigma = std::sqrt(2.0 / curvature);
    const double promised = 0.5 * slope * slope / curvature;
    if (cost_here - kPromised * promised > options.useless_above) break;
    double move = -slope / curvature;
    // Standard deviations far off bend the cost: a parabola is good for a few powers of e.
    if (hypothesis.logarithm) move = std::clamp(move, -kMaxLogMove, kMaxLogMove);
    bool moved = false;
    for (int shorter = 0; shorter < 3 && !moved; ++shorter, move *= 0.25) {
      if (!trials->work().Allows(options.part_of_work)) break;
      moved = take(best.value + move, at(best.value + move));
      if (std::abs(move) < kFound * best.sigma) break;
    }
    const bool fine = step < 5.0 * best.sigma && step > 0.2 * best.sigma;
    if (fine && (std::abs(slope / curvature) < kFound * best.sigma || !moved)) break;
    step = hypothesis.logarithm ? std::min(best.sigma, 1.0) : best.sigma;
  }
  return best;
}

namespace {

/// Looks from which on a part of the points stands for the block: seconds of work.
constexpr std::size_t kMaxLooksOfCure = 200000;

/// All known points and as many ties, evenly taken, as make a block of at most so many looks.
Block PartForCure(const Block& block) {
  const std::size_t every = block.looks.size() / kMaxLooksOfCure + 1;
  std::vector<std::uint32_t> points;
  for (std::uint32_t point = 0; point < block.points.size(); ++point) {
    const bool known = block.points.role[point] != PointRole::kTie;
    if (known || point % every == 0) points.push_back(point);
  }
  return PartOf(block, points);
}

/// Redundancy numbers while corrections stay, times the part of them that all looks have then.
void AddSums(const Block& block,
             const CorrectionModel& model,
             const Fit& fit,
             const PriorSums& priors,
             const std::vector<std::string>& passes,
             BlockCure* out) {
  const SampleResiduals residuals = ResidualsOf(block, model, fit);
  std::vector<std::uint8_t> concerned(block.passes.size(), 0);
  for (const std::uint32_t pass : PassesOf(block, passes)) concerned[pass] = 1;
  double alone = 0.0;
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    for (const Eigen::Index column : {0, 1}) {
      const double error = residuals.whitened_errors(static_cast<Eigen::Index>(i), column);
      const double part = residuals.redundancy(static_cast<Eigen::Index>(i), column);
      if (!std::isfinite(error) || !std::isfinite(part)) continue;
      const auto add = [&](LookSums* sums) {
        sums->square += error * error;
        sums->redundancy += part;
      };
      add(&out->of_all[static_cast<std::size_t>(column)]);
      if (concerned[block.looks.pass[i]] != 0)
        add(&out->of_passes[static_cast<std::size_t>(column)]);
      alone += part;
    }
  }
  const double of_looks = fit.counts.redundancy() - priors.redundancy - residuals.known_redundancy;
  if (!priors.known || !(of_looks > 0.0) || !(alone > of_looks)) return;
  for (auto* sums : {&out->of_all, &out->of_passes}) {
    for (LookSums& of : *sums) of.redundancy *= of_looks / alone;
  }
}

}  // namespace

bool BearsSigmas(const BlockCure& solved, double test_level) {
  if (!solved.cure.cures) return false;
  return std::all_of(solved.of_all.begin(), solved.of_all.end(), [&](const LookSums& of) {
    if (!(of.redundancy >= 1.0)) return true;
    return of.square >= ChiSquareInterval(LevelOfOneTest(test_level), of.redundancy).lower;
  });
}

BlockCure CureOf(const Block& given,
                 const CorrectionModel& corrections,
                 const Hypothesis& hypothesis,
                 double value,
                 double test_level,
                 ProgressSink* progress) {
  BlockCure tried;
  Explanation::Cure& out = tried.cure;
  try {
    Block block = given.looks.size() > kMaxLooksOfCure ? PartForCure(given) : given;
    hypothesis.undo(&block, value);
    FitStrips(&block);
    CorrectionModel model = corrections;
    if (hypothesis.remodel) hypothesis.remodel(&model, value);
    const Fit fit = SolveSample(block, model, {}, progress);
    if (!fit.solved || fit.lost > 0) return tried;
    const PriorSums priors = PriorsOf(block, model, fit);
    const bool determined = priors.known || model.groups.empty();
    if (!determined) return tried;
    const GlobalTest test =
        TestMeasurements(fit.counts, priors, {.kept = fit.square_sum}, test_level);
    if (!(test.redundancy > 0.0)) return tried;
    out.tried = true;
    out.factor = test.sigma0_squared;
    out.lower = test.chi_square.lower / test.redundancy;
    out.upper = test.chi_square.upper / test.redundancy;
    out.points = block.points.size();
    const bool with_priors = priors.known && priors.redundancy > kMinRedundancy;
    if (with_priors) out.priors_factor = priors.square_sum / priors.redundancy;
    tried.priors_hold = !with_priors || PriorsHold(priors, test_level);
    out.cures = test.passed && tried.priors_hold;
    if (hypothesis.kind == MistakeKind::kSigma) {
      AddSums(block, model, fit, priors, hypothesis.passes, &tried);
    }
  } catch (const Interrupted&) {
    throw;
  } catch (const std::exception&) {  // what cannot be solved cures nothing
    tried = {};
  }
  return tried;
}

}  // namespace sarblock
