// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "html.h"
#include "sections.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

const char* KindOf(const ReportSummary& summary) {
  if (summary.command == "intersect") return "Intersection";
  if (summary.command == "predict") return "Prediction";
  return "Block adjustment";
}

std::vector<PageFact> VerdictFacts(const ResultFolder& result, const AccuracyFigures& accuracy) {
  std::vector<PageFact> out;
  const std::array<const char*, 3> axes = AxisNames(result.summary);
  if (accuracy.points > 0) {
    const auto weak = static_cast<std::size_t>(accuracy.weakest);
    out.push_back(
        {"Median sigma " + std::string(axes[0]) + ", " + axes[1] + ", " + axes[2],
         fmt::format("{}, {}, {} m",
                     Shown(accuracy.median_m[0], 3),
                     Shown(accuracy.median_m[1], 3),
                     Shown(accuracy.median_m[2], 3)),
         fmt::format("of {} points", ReadableCount(static_cast<double>(accuracy.points)))});
    out.push_back({"Weakest point",
                   fmt::format("{} m {}", Shown(accuracy.largest_m[weak], 3), axes[weak]),
                   "at " + accuracy.largest_point[weak]});
  }
  const GlobalTestFigures& test = result.summary.test;
  if (test.given()) {
    out.push_back({"Variance factor",
                   Shown(test.sigma0_squared),
                   fmt::format("{}: {} to {} allowed",
                               test.passed ? "passed" : "failed",
                               Shown(test.lower / test.redundancy, 3),
                               Shown(test.upper / test.redundancy, 3))});
  }
  if (const auto& checks = result.summary.checks; checks && checks->components_1 > 0.0) {
    out.push_back({"Check points, error over sigma",
                   Shown(checks->error_ratio_1, 3),
                   fmt::format("{} point{}, {}",
                               checks->points_1,
                               checks->points_1 == 1.0 ? "" : "s",
                               checks->realistic ? "realistic" : "not realistic")});
  }
  out.push_back({"Observations, unknowns",
                 fmt::format("{}, {}",
                             ReadableCount(result.summary.Count("observations")),
                             ReadableCount(result.summary.Count("parameters"))),
                 fmt::format("redundancy {}", ReadableCount(result.summary.Count("redundancy")))});
  return out;
}

}  // namespace

std::string Shown(double value, int digits) { return ReadableNumber(value, digits); }

std::string ShownPercent(double part) {
  return std::isnan(part) ? "-" : ReadableNumber(100.0 * part, 3) + " %";
}

std::string ShownWithSigma(double value, double sigma) {
  return std::isnan(sigma) ? Shown(value) : Shown(value) + " \xc2\xb1 " + Shown(sigma, 2);
}

std::string Capital(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') {
    text[0] = static_cast<char>(text[0] - 'a' + 'A');
  }
  return text;
}

Page MakeResultPage(const ResultFolder& result) {
  const AccuracyFigures accuracy = DescribeAccuracy(result);
  Page page;
  page.title = result.summary.block.empty() ? "Result" : result.summary.block;
  page.kind = KindOf(result.summary);
  page.subtitle = fmt::format(
      "{} passes, {} points, {} looks; {}",
      ReadableCount(result.summary.Count("passes")),
      ReadableCount(result.summary.Count("points")),
      ReadableCount(result.summary.Count("looks")),
      result.summary.geocentric ? "geocentric frame, " + result.summary.ellipsoid : "local frame");
  page.verdict = JudgeResult(result, accuracy);
  page.facts = VerdictFacts(result, accuracy);
  page.sections = {CountsSection(result),
                   TestSection(result),
                   KnownPointsSection(result),
                   MapSection(result, accuracy),
                   ProfileSection(result),
                   ResidualSection(result),
                   WorstLooksSection(result),
                   CorrectionSection(result),
                   ModelSection(result),
                   CostSection(result),
                   OriginSection(result)};
  return page;
}

}  // namespace sarblock
