// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "html.h"
#include "sections.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

const char* KindOf(const ResultSummary& summary) {
  if (summary.command == "intersect") return "Intersection";
  if (summary.command == "predict") return "Prediction";
  return "Block adjustment";
}

std::vector<PageFact> HeadlineFacts(const ResultFolder& result,
                                    const AccuracyFigures& accuracy,
                                    const Headline& headline) {
  std::vector<PageFact> out;
  const std::array<const char*, 3> axes = AxisNames(result.file.frame);
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
    if (!headline.would_help.empty()) {
      out.push_back({"Would help most",
                     headline.would_help,
                     std::string("for ") + axes[weak] + ", the weakest component"});
    }
  }
  if (const auto& test = result.file.summary.chi_square) {
    out.push_back({"Variance factor",
                   Shown(test->sigma0_squared),
                   fmt::format("{}: {} to {} allowed",
                               test->passed ? "passed" : "failed",
                               Shown(test->lower / test->redundancy, 3),
                               Shown(test->upper / test->redundancy, 3))});
  }
  if (const auto& checks = result.file.summary.checks; checks && checks->components > 0) {
    out.push_back({"Check points, error over sigma",
                   Shown(checks->error_ratio_1, 3),
                   fmt::format("{} point{}, {}",
                               checks->points,
                               checks->points == 1 ? "" : "s",
                               checks->realistic ? "realistic" : "not realistic")});
  }
  out.push_back(
      {"Observations, unknowns",
       fmt::format("{}, {}",
                   ReadableCount(result.file.summary.Count("observations")),
                   ReadableCount(result.file.summary.Count("parameters"))),
       fmt::format("redundancy {}", ReadableCount(result.file.summary.Count("redundancy")))});
  return out;
}

}  // namespace

Page MakeResultPage(const ResultFolder& result) {
  const AccuracyFigures accuracy = DescribeAccuracy(result);
  const Frame& frame = result.file.frame;
  Page page;
  page.title = result.file.summary.block.empty() ? "Result" : result.file.summary.block;
  page.kind = KindOf(result.file.summary);
  page.subtitle = fmt::format("{} passes, {} points, {} looks; {}",
                              ReadableCount(result.file.summary.Count("passes")),
                              ReadableCount(result.file.summary.Count("points")),
                              ReadableCount(result.file.summary.Count("looks")),
                              frame.kind() == FrameKind::kGeocentric
                                  ? "geocentric frame, " + frame.ellipsoid().name
                                  : "local frame");
  page.headline = HeadlineOf(result, accuracy);
  page.facts = HeadlineFacts(result, accuracy, page.headline);
  page.sections = {MapSection(result, accuracy),
                   KnownPointsSection(result),
                   TestSection(result),
                   ResidualSection(result),
                   WorstLooksSection(result),
                   ProfileSection(result),
                   CorrectionSection(result),
                   ModelSection(result),
                   CountsSection(result),
                   CostSection(result),
                   OriginSection(result)};
  return page;
}

}  // namespace sarblock
