// SPDX-License-Identifier: Apache-2.0
#include "print_result.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>

#include "core/text.h"
#include "quality/assess.h"
#include "terminal.h"
#include <fmt/core.h>

namespace sarblock::cli {
namespace {

using Out = std::back_insert_iterator<std::string>;

std::string Headline(const AdjustResult& result) {
  switch (result.status) {
    case AdjustStatus::kConverged:
    case AdjustStatus::kNotConverged:
      return NameOf(result.assessment.verdict);
    case AdjustStatus::kIntersected:
      return std::string("intersected, flight paths fixed") +
             (result.assessment.verdict == Verdict::kTestsFailed ? ": tests failed" : "");
    case AdjustStatus::kPredicted:
      return "predicted from geometry and weights";
  }
  return "";
}

void PrintTest(const AdjustResult& result, const AdjustOptions& options, Out out) {
  const double f = result.test_redundancy;
  if (std::isnan(result.sigma0_squared)) return;
  fmt::format_to(out,
                 "  variance factor s0^2 {:.4f}, {:.4f} to {:.4f} expected ({:g} % for all tests): "
                 "{}\n",
                 result.sigma0_squared,
                 result.chi_square.lower / f,
                 result.chi_square.upper / f,
                 100.0 * options.test_level,
                 result.chi_square_passed ? "passed" : "FAILED");
  if (result.assessment.groups.empty()) return;
  fmt::format_to(out, "  groups {:>16} {:>12} {:>18}   expected\n", "v'Pv", "redundancy", "factor");
  for (const ObservationGroup& group : result.assessment.groups) {
    fmt::format_to(out,
                   "    {:<8} {:>12.1f} {:>12.1f} {:>18}   {:.3f} to {:.3f}\n",
                   group.name,
                   group.square_sum,
                   group.redundancy,
                   ValueWithSigma(group.factor(), group.factor_deviation()),
                   group.band.lower,
                   group.band.upper);
  }
}

/// The terms of all passes together; by pass they are in summary.json.
void PrintReductions(const AdjustResult& result, Out out) {
  const std::vector<ReductionTerm>& terms = result.reductions.terms;
  if (terms.empty()) return;
  struct Row {
    std::string term, unit;
    double sum = 0.0, passes = 0.0, least = 0.0, largest = 0.0;
  };
  std::vector<Row> rows;
  for (const ReductionTerm& term : terms) {
    auto row = std::find_if(rows.begin(), rows.end(), [&](const Row& other) {
      return other.term == term.term && other.unit == term.unit;
    });
    if (row == rows.end()) {
      row = rows.insert(rows.end(), {term.term, term.unit, 0.0, 0.0, term.least, term.largest});
    }
    row->sum += term.mean;
    row->passes += 1.0;
    row->least = std::min(row->least, term.least);
    row->largest = std::max(row->largest, term.largest);
  }
  fmt::format_to(out,
                 "  taken off measured values {:>12} {:>12} {:>12}  passes\n",
                 "mean",
                 "least",
                 "largest");
  for (const Row& row : rows) {
    fmt::format_to(out,
                   "    {:<23} {:>12.5g} {:>12.5g} {:>12.5g}  {}\n",
                   row.term + (row.unit == "m" ? " [m of range]" : " [s of time]"),
                   row.sum / row.passes,
                   row.least,
                   row.largest,
                   row.passes);
  }
}

void PrintSigmas(const Block& block, const AdjustResult& result, Out out) {
  if (result.points.covariance_m2.empty()) return;
  std::array<std::vector<double>, 3> sigma_m;
  std::array<std::size_t, 3> worst{};
  std::array<double, 3> largest{};
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    if (!IsSolved(result.points.status[point])) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      const double sigma = std::sqrt(result.points.covariance_m2[point][i]);
      sigma_m[i].push_back(sigma);
      if (sigma > largest[i]) {
        largest[i] = sigma;
        worst[i] = point;
      }
    }
  }
  if (sigma_m[0].empty()) return;
  const bool local = block.frame.kind() == FrameKind::kLocal;
  fmt::format_to(out,
                 "  sigma of points [m]  {:>10} {:>10} {:>10}\n",
                 local ? "x" : "east",
                 local ? "y" : "north",
                 local ? "z" : "up");
  fmt::format_to(out,
                 "    median             {:10.4g} {:10.4g} {:10.4g}\n",
                 Median(sigma_m[0]),
                 Median(sigma_m[1]),
                 Median(sigma_m[2]));
  fmt::format_to(out,
                 "    largest            {:10.4g} {:10.4g} {:10.4g}   at {}, {}, {}\n",
                 largest[0],
                 largest[1],
                 largest[2],
                 block.points.ids[worst[0]],
                 block.points.ids[worst[1]],
                 block.points.ids[worst[2]]);
}

void PrintTests(const QualitySummary& summary, const AdjustResult& result, Out out) {
  const ReliabilityFigures& figures = summary.figures;
  fmt::format_to(out,
                 "  tests of {} observations, level {:.3g} each, {:.3g} all: critical |w| {:.2f}, "
                 "delta0 {:.2f}\n",
                 figures.tests,
                 figures.alpha_one,
                 figures.alpha_all,
                 figures.critical_w,
                 figures.delta0);
  if (result.status == AdjustStatus::kPredicted) return;  // nothing was measured
  fmt::format_to(
      out,
      "    above it {} range, {} azimuth, {} control; {:.1f} expected by chance; {} of {} "
      "looks cannot be localised (two looks per point)\n",
      summary.looks_above[0],
      summary.looks_above[1],
      summary.control_above,
      summary.expected_above(),
      summary.looks_not_localisable,
      summary.looks_tested[0]);
}

/// The tests of priors, and the pass that fits worst.
void PrintPriors(const AdjustResult& result, Out out) {
  const PriorSummary& priors = result.assessment.priors;
  if (priors.tested > 0) {
    const ParameterResult& worst = result.parameters[priors.worst];
    fmt::format_to(out,
                   "  tests of {} priors: {} above it, {:.1f} expected by chance; the largest |w| "
                   "{:.2f}, {} {}\n",
                   priors.tested,
                   priors.above,
                   priors.expected_above,
                   std::abs(priors.worst_w),
                   worst.owner,
                   worst.name);
  }
  const std::vector<PassShare>& shares = result.assessment.shares;
  if (shares.size() < 2 || result.status == AdjustStatus::kPredicted) return;
  const auto worst =
      std::max_element(shares.begin(), shares.end(), [](const PassShare& a, const PassShare& b) {
        return std::isnan(a.variance_factor()) || a.variance_factor() < b.variance_factor();
      });
  if (std::isnan(worst->variance_factor())) return;
  fmt::format_to(out,
                 "    the pass that fits worst: {}, s0^2 {:.4g} with redundancy {:.1f}\n",
                 worst->owner,
                 worst->variance_factor(),
                 worst->redundancy + worst->prior_redundancy);
}

/// What of a plan nothing checks, and what a blunder there would do.
void PrintChecked(const Block& block, const QualitySummary& summary, Out out) {
  constexpr std::array kKinds = {"ranges", "azimuths", "control"};
  constexpr std::array kComponents = {"e", "n", "u"};
  constexpr double kShownRedundancy = 1e-6;  // less is rounding of single precision
  fmt::format_to(out,
                 "  checked by others {:>8} {:>14}   the least checked\n",
                 "of",
                 fmt::format("r below {:g}", CheckedObservations::kHardly));
  for (std::size_t k = 0; k < kKinds.size(); ++k) {
    const CheckedObservations& of = summary.checked[k];
    if (of.count == 0) continue;
    const std::string blunder =
        std::isinf(of.blunder_m)
            ? std::string("a blunder of any size goes into the point unseen")
            : fmt::format("a blunder of {:.3g} m may go unseen and move the point by {:.3g} m",
                          of.blunder_m,
                          of.shift_m);
    fmt::format_to(out,
                   "    {:<16} {:>8} {:>14}   {} {}, r {:.2g}\n        {}\n",
                   kKinds[k],
                   of.count,
                   of.hardly,
                   block.points.ids[of.point],
                   k == 2 ? kComponents[of.part] : block.passes[of.part].id.c_str(),
                   of.redundancy > kShownRedundancy ? of.redundancy : 0.0,
                   blunder);
  }
}

void PrintDifferences(const std::vector<DifferenceClass>& differences, Out out) {
  if (differences.empty()) return;
  fmt::format_to(out,
                 "  sigma of differences [m]   distance  pairs {:>10} {:>10} {:>10}\n",
                 "along",
                 "across",
                 "up");
  for (const DifferenceClass& of : differences) {
    fmt::format_to(out,
                   "    {:<19} {:>11.4g} {:>6} {:10.4g} {:10.4g} {:10.4g}\n",
                   of.along ? "along the track" : "across the track",
                   of.distance_m,
                   of.pairs,
                   of.sigma_along_m,
                   of.sigma_across_m,
                   of.sigma_up_m);
  }
}

void PrintQuality(const Block& block, const AdjustResult& result, Out out) {
  if (!result.quality.empty()) {
    PrintTests(result.assessment.tests, result, out);
    if (result.status == AdjustStatus::kPredicted) {
      PrintChecked(block, result.assessment.tests, out);
    }
    PrintPriors(result, out);
  }
  if (!result.snooping) return;
  const std::vector<BlunderFinding>& findings = result.snooping->findings;
  fmt::format_to(out,
                 "  search for blunders: {} findings in {} rounds\n",
                 findings.size(),
                 result.snooping->rounds);
  constexpr std::size_t kShown = 10;
  for (std::size_t i = 0; i < std::min(kShown, findings.size()); ++i) {
    fmt::format_to(out, "    {}\n", DescribeFinding(block, findings[i]));
  }
  if (findings.size() > kShown) {
    fmt::format_to(out, "    and {} more in summary.json\n", findings.size() - kShown);
  }
}

void PrintChecks(const AdjustResult& result, double level, Out out) {
  if (result.checks.empty()) return;
  const CheckSummary& summary = result.assessment.checks;
  std::string rms;  // of what the points give: heights alone, say
  for (const double rms_m : summary.rms_m) {
    rms += std::isnan(rms_m) ? fmt::format(" {:>10}", "-") : fmt::format(" {:10.4g}", rms_m);
  }
  fmt::format_to(out, "  {:4} check points rms{}\n", summary.points, rms);
  const std::string verdict = DescribeChecks(summary, level);
  if (!verdict.empty()) fmt::format_to(out, "    {}\n", verdict);
}

void PrintCorrections(const AdjustResult& result, Out out) {
  if (result.parameters.empty()) return;
  std::vector<const ParameterResult*> order;
  for (const ParameterResult& p : result.parameters) {
    if (!std::isnan(p.sigma)) order.push_back(&p);
  }
  if (order.empty()) return;
  const auto significance = [&](const ParameterResult* p) { return std::abs(p->value) / p->sigma; };
  constexpr std::size_t kShown = 6;
  if (result.status == AdjustStatus::kPredicted) {
    std::sort(order.begin(), order.end(), [](const auto* a, const auto* b) {
      return a->sigma > b->sigma;
    });
    fmt::format_to(out, "  corrections, the least certain of {}:\n", order.size());
    for (std::size_t i = 0; i < std::min(kShown, order.size()); ++i) {
      fmt::format_to(out,
                     "    {:<12} {:<20} sigma {:.3g} {}{}\n",
                     order[i]->owner,
                     order[i]->name,
                     order[i]->sigma,
                     order[i]->unit,
                     std::isnan(order[i]->prior_sigma)
                         ? std::string(", no prior")
                         : fmt::format(", prior {:.3g}", order[i]->prior_sigma));
    }
    return;
  }
  std::sort(order.begin(), order.end(), [&](const auto* a, const auto* b) {
    return significance(a) > significance(b);
  });
  fmt::format_to(out, "  corrections, the most significant of {}:\n", order.size());
  for (std::size_t i = 0; i < std::min(kShown, order.size()); ++i) {
    fmt::format_to(out,
                   "    {:<12} {:<20} {:>20} {} ({:.1f} sigma)\n",
                   order[i]->owner,
                   order[i]->name,
                   ValueWithSigma(order[i]->value, order[i]->sigma),
                   order[i]->unit,
                   significance(order[i]));
  }
}

/// One line a kept candidate.
void PrintSelection(const SelectionReport& selection, Out out) {
  if (selection.empty()) return;
  const auto count = [&](bool CandidateResult::*is) {
    return std::count_if(selection.candidates.begin(),
                         selection.candidates.end(),
                         [is](const CandidateResult& c) { return c.*is; });
  };
  const auto kept = count(&CandidateResult::kept);
  fmt::format_to(out,
                 "  corrections chosen: {} of {} candidates, {} held by priors, in {} steps, {} "
                 "rounds\n",
                 kept,
                 selection.candidates.size(),
                 count(&CandidateResult::held),
                 selection.steps,
                 selection.rounds);
  constexpr int kShown = 12;
  int shown = 0;
  for (const CandidateResult& c : selection.candidates) {
    if (!c.kept) continue;
    if (++shown > kShown) {
      fmt::format_to(out, "    and {} more, see selection.csv\n", kept - kShown);
      break;
    }
    fmt::format_to(out,
                   "    {:<28} {:<12.12} F {:<10.4g} delta BIC {:.4g}\n",
                   c.name,
                   c.passes,
                   c.f,
                   c.delta_bic);
  }
  for (const SimplificationBound& bound : selection.simplifications) {
    fmt::format_to(
        out,
        "  simplification {}: moves points by at most {:.2g} sigma; {}{}\n",
        bound.name,
        bound.fraction,
        bound.verdict,
        std::isnan(bound.gain) ? "" : fmt::format(" (looks {:.2f} times as fast)", bound.gain));
  }
  if (selection.simplified.any()) {
    fmt::format_to(out,
                   "  simplified model: looks evaluated {:.2f} times as fast; the full model would "
                   "move no point by more than {:.2g} sigma\n",
                   selection.simplified_gain,
                   selection.simplified_shift);
  }
}

}  // namespace

std::string DescribeResult(const Block& block,
                           const AdjustOptions& options,
                           const AdjustResult& result) {
  std::string text;
  const Out out(text);
  const auto solved = std::count_if(
      result.points.status.begin(), result.points.status.end(), [](auto s) { return IsSolved(s); });
  fmt::format_to(out, "{}: {}\n", block.name, Headline(result));
  for (const std::string& reason : result.assessment.reasons) {
    fmt::format_to(out, "  - {}\n", reason);
  }
  fmt::format_to(out,
                 "  passes {}, points {} ({} solved), looks {} ({} used)\n",
                 block.passes.size(),
                 block.points.size(),
                 solved,
                 block.looks.size(),
                 result.looks_used);
  if (result.status == AdjustStatus::kPredicted) {
    std::vector<std::size_t> points_by_looks;
    for (const std::uint32_t looks : result.points.looks) {
      if (points_by_looks.size() <= looks) points_by_looks.resize(looks + 1, 0);
      ++points_by_looks[looks];
    }
    fmt::format_to(out, "  {}\n", DescribeLooksPerPoint(points_by_looks));
  }
  fmt::format_to(out,
                 "  observations {}, parameters {}, redundancy {:.0f}\n",
                 result.observation_count,
                 result.parameter_count,
                 result.redundancy());
  if (result.datum_defects > 0) {
    fmt::format_to(out, "  inner datum for {} defects\n", result.datum_defects);
  }
  if (result.status == AdjustStatus::kConverged || result.status == AdjustStatus::kNotConverged) {
    fmt::format_to(out,
                   "  iterations {}, cost {:.6g} -> {:.6g}, Newton decrement {:.1e} sigma\n",
                   result.iterations,
                   result.initial_cost,
                   result.final_cost,
                   result.remaining_step);
  }
  PrintReductions(result, out);
  text += DescribeVarianceComponents(result);
  PrintTest(result, options, out);
  PrintSelection(result.selection, out);
  if (!result.parameters.empty()) {
    fmt::format_to(out, "  condition of the reduced matrix {:.2g}\n", result.condition);
  }
  PrintSigmas(block, result, out);
  text += DescribeMonteCarlo(result);
  PrintChecks(result, LevelOfOneTest(options.test_level), out);
  PrintQuality(block, result, out);
  PrintDifferences(result.assessment.differences, out);
  PrintCorrections(result, out);
  for (const std::string& warning : result.warnings) {
    fmt::format_to(out, "  warning: {}\n", warning);
  }
  return text;
}

namespace {

/// A row whose first cell is the name of a pass; a name too long for its column has a line of its
/// own above the others.
std::string RowOf(const std::string& pass, std::size_t width, const std::string& cells) {
  std::string row = fmt::format("  {:<{}} {}\n", pass, width, cells);
  if (row.size() <= kColumns + 1) return row;
  return fmt::format("  {}\n      {}\n", pass, cells);
}

/// Effect of the recordings on a point, if it differs from that of ideal ones.
void PrintRecordings(const Block& block, Out out) {
  constexpr double kReported = 1e-3;  // of the sigma of azimuth
  constexpr std::size_t kShown = 40;
  std::size_t reported = 0;
  for (const Pass& pass : block.passes) {
    const RecordingEffect& effect = pass.recorded.effect;
    const bool ideal = !(effect.Total_m() > kReported * effect.azimuth_sigma_m);
    if (ideal && pass.recorded.asked.through == PathThrough::kStates) continue;
    if (++reported > kShown) continue;
    if (reported == 1) {
      fmt::format_to(out,
                     "  orbit error at the ground, along track [m]\n"
                     "  {:<14} {:<9} {:>9} {:>13} {:>14} {:>13}\n",
                     "pass",
                     "through",
                     "noise",
                     "contradiction",
                     "between states",
                     "azimuth sigma");
    }
    fmt::format_to(out,
                   "{}",
                   RowOf(pass.id,
                         14,
                         fmt::format("{:<9} {:9.4g} {:13.4g} {:14.4g} {:13.4g}",
                                     NameOf(effect.through),
                                     effect.noise_m,
                                     effect.contradiction_m,
                                     effect.interpolation_m,
                                     effect.azimuth_sigma_m)));
    if (!effect.why.empty()) fmt::format_to(out, "    {}\n", effect.why);
  }
  if (reported > kShown) fmt::format_to(out, "  and {} passes more\n", reported - kShown);
}

}  // namespace

std::string DescribeLooksPerPoint(const std::vector<std::size_t>& points_by_looks) {
  std::string text;
  for (std::size_t looks = 0; looks < points_by_looks.size(); ++looks) {
    if (points_by_looks[looks] == 0) continue;
    text += fmt::format("{}{} with {}",
                        text.empty() ? "" : ", ",
                        points_by_looks[looks],
                        looks == 0 ? "none" : std::to_string(looks));
  }
  return "looks per point: " + text;
}

std::string DescribeBlock(const Block& block) {
  std::string text;
  const Out out(text);
  const bool local = block.frame.kind() == FrameKind::kLocal;
  fmt::format_to(out,
                 "{}: {} frame{}{}\n",
                 block.name,
                 local ? "local" : "geocentric",
                 local ? "" : ", ellipsoid ",
                 local ? "" : block.frame.ellipsoid().name);
  std::array<std::size_t, 3> roles{};
  for (const PointRole role : block.points.role) ++roles[static_cast<std::size_t>(role)];
  std::vector<std::size_t> looks_of_pass(block.passes.size(), 0);
  std::size_t rejected = 0;  // counted once, here
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    const bool taken = !block.looks.rejected(i);
    looks_of_pass[block.looks.pass[i]] += taken ? 1U : 0U;
    rejected += taken ? 0U : 1U;
  }
  fmt::format_to(out,
                 "  points {}: {} tie, {} control, {} check\n  looks {}, {} rejected\n",
                 block.points.size(),
                 roles[0],
                 roles[1],
                 roles[2],
                 block.looks.size(),
                 rejected);
  std::vector<std::size_t> points_by_looks;
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    std::size_t looks = 0;
    for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      looks += block.looks.rejected(i) ? 0U : 1U;
    }
    if (points_by_looks.size() <= looks) points_by_looks.resize(looks + 1, 0);
    ++points_by_looks[looks];
  }
  fmt::format_to(out, "  {}\n", DescribeLooksPerPoint(points_by_looks));
  fmt::format_to(out,
                 "  {:<20} {:<6} {:>8} {:>8} {:>14} {:>14}\n",
                 "pass",
                 "look",
                 "states",
                 "looks",
                 "start_s",
                 "end_s");
  constexpr std::size_t kShown = 40;
  for (std::size_t i = 0; i < std::min(kShown, block.passes.size()); ++i) {
    const Pass& pass = block.passes[i];
    fmt::format_to(out,
                   "{}",
                   RowOf(pass.id,
                         20,
                         fmt::format("{:<6} {:8} {:8} {:14.6f} {:14.6f}",
                                     pass.side == LookSide::kLeft ? "left" : "right",
                                     pass.RecordedStates().size(),
                                     looks_of_pass[i],
                                     pass.start_s,
                                     pass.end_s)));
  }
  if (block.passes.size() > kShown) {
    fmt::format_to(out, "  and {} passes more\n", block.passes.size() - kShown);
  }
  PrintRecordings(block, out);
  return text;
}

std::string DescribeVarianceComponents(const AdjustResult& result) {
  std::string text;
  if (!result.variance_components) return text;
  const auto out = std::back_inserter(text);
  const VarianceComponentReport& report = *result.variance_components;
  fmt::format_to(out,
                 "  variance components, {} iterations; before them s0^2 {:.4f}, acceptance {:.4f} "
                 "to {:.4f}: {}\n    {:<14} {:<7} {:>8} {:>11} {:>11} {:>20}\n",
                 report.iterations,
                 report.before.sigma0_squared,
                 report.before.chi_square.lower / report.before.redundancy,
                 report.before.chi_square.upper / report.before.redundancy,
                 report.before.passed ? "passed" : "FAILED",
                 "group",
                 "",
                 "looks",
                 "redundancy",
                 "sigma given",
                 "sigma estimated");
  constexpr std::size_t kShown = 24;
  for (std::size_t k = 0; k < std::min(kShown, report.components.size()); ++k) {
    const VarianceComponent& c = report.components[k];
    const std::string after =
        c.estimated ? ValueWithSigma(c.sigma_after(), c.sigma_deviation()) + " " + c.unit
                    : std::string("held");
    fmt::format_to(out,
                   "    {:<14} {:<7} {:>8} {:>11.1f} {:>11.4g} {:>20}\n",
                   c.group,
                   c.component == 0 ? "range" : "azimuth",
                   c.looks,
                   c.redundancy,
                   c.sigma_before,
                   after);
  }
  if (report.components.size() > kShown) {
    fmt::format_to(out, "    and {} more in summary.json\n", report.components.size() - kShown);
  }
  return text;
}

std::string DescribeMonteCarlo(const AdjustResult& result) {
  if (!result.montecarlo) return {};
  const MonteCarloReport& report = *result.montecarlo;
  std::string text = fmt::format("  Monte Carlo: {}\n", report.sentence);
  const auto out = std::back_inserter(text);
  if (report.failed > 0) fmt::format_to(out, "    {} runs did not converge\n", report.failed);
  fmt::format_to(out,
                 "    points whose own squared errors leave their 99 % interval: {} of {}\n",
                 report.points_outside,
                 report.points);
  return text;
}

}  // namespace sarblock::cli
