// SPDX-License-Identifier: Apache-2.0
#include "result_quality.h"

#include "sarblock/io/adjust_table.h"

#include "adjust_table.h"
#include "quality/assess.h"

namespace sarblock {
namespace {

using Json = nlohmann::ordered_json;

const char* ComponentName(bool azimuth) { return azimuth ? "azimuth" : "range"; }

Json WorstJson(const Block& block, const QualitySummary& summary) {
  Json worst = Json::array();
  for (const TestedLook& look : summary.worst) {
    worst.push_back({{"pass", block.passes[block.looks.pass[look.look]].id},
                     {"point", std::string(block.points.ids[look.point])},
                     {"component", ComponentName(look.azimuth)},
                     {"w", look.w_1},
                     {"redundancy", look.redundancy_1}});
  }
  return worst;
}

Json PriorsJson(const AdjustResult& result) {
  const PriorSummary& summary = result.assessment.priors;
  Json json = {{"priors", summary.priors},
               {"redundancy", summary.redundancy_1},
               {"tested", summary.tested},
               {"above_critical", summary.above},
               {"expected_above", summary.expected_above_1}};
  if (summary.tested > 0) {
    const ParameterResult& worst = result.parameters[summary.worst];
    json["worst"] = {{"pass", worst.owner}, {"parameter", worst.name}, {"w", summary.worst_w_1}};
  }
  return json;
}

Json SharesJson(const std::vector<PassShare>& all) {
  Json shares = Json::array();
  for (const PassShare& share : all) {
    shares.push_back({{"pass", share.owner},
                      {"looks", share.looks},
                      {"square_sum", share.square_sum_1},
                      {"redundancy", share.redundancy_1},
                      {"prior_square_sum", share.prior_square_sum_1},
                      {"prior_redundancy", share.prior_redundancy_1},
                      {"sigma0_squared", share.variance_factor()}});
  }
  return shares;
}

}  // namespace

Json QualityJson(const Block& block, const AdjustOptions& options, const AdjustResult& result) {
  const QualitySummary& summary = result.assessment.tests;
  const ReliabilityFigures& figures = summary.figures;
  return {
      {"alpha", options.quality.alpha_1},
      {"power", options.quality.power_1},
      {"family_wise", NameOfChoice("quality.family_wise", options)},
      {"test", NameOfChoice("quality.test", options)},
      {"tests", figures.tests},
      {"alpha_one", figures.alpha_one_1},
      {"alpha_all", figures.alpha_all_1},
      {"critical_w", figures.critical_w_1},
      {"critical_tau", figures.critical_tau_1},
      {"delta0", figures.delta0_1},
      {"median_redundancy",
       {{"range", summary.median_redundancy_1[0]}, {"azimuth", summary.median_redundancy_1[1]}}},
      {"above_critical",
       {{"range", summary.looks_above[0]},
        {"azimuth", summary.looks_above[1]},
        {"control", summary.control_above}}},
      {"expected_above", summary.expected_above_1()},
      {"looks_not_localisable", summary.looks_not_localisable},
      {"worst", WorstJson(block, summary)},
      {"priors", PriorsJson(result)},
      {"passes", SharesJson(result.assessment.shares)}};
}

Json SnoopingJson(const Block& block, const SnoopingReport& report) {
  Json findings = Json::array();
  for (const BlunderFinding& finding : report.findings) {
    Json passes = Json::array();
    for (const std::uint64_t look : finding.looks) {
      passes.push_back(block.passes[block.looks.pass[look]].id);
    }
    findings.push_back({{"round", finding.round},
                        {"point", std::string(block.points.ids[finding.point])},
                        {"passes", passes},
                        {"control", finding.control},
                        {"component", ComponentName(finding.azimuth)},
                        {"w", finding.w_1},
                        {"located", finding.located()},
                        {"action", NameOf(finding.action)},
                        {"note", finding.note}});
  }
  return {{"rounds", report.rounds},
          {"left_out_by_robust_start", report.robust.size()},
          {"findings", findings}};
}

Json CheckPointsJson(const CheckSummary& summary, double level) {
  Json json = {{"points", summary.points},
               {"points_without_sigma", summary.points_without_sigma},
               {"rms_e_m", summary.rms_m[0]},
               {"rms_n_m", summary.rms_m[1]},
               {"rms_u_m", summary.rms_m[2]},
               {"components", summary.components},
               {"chi_square", summary.chi_square}};
  if (summary.components == 0) return json;
  json["freedom"] = summary.freedom_1;
  json["lower"] = summary.chi_square_interval.lower;
  json["upper"] = summary.chi_square_interval.upper;
  json["level"] = level;
  json["realistic"] = summary.realistic();
  json["error_ratio"] = summary.error_ratio_1;
  json["points_outside"] = summary.points_outside;
  json["says"] = DescribeChecks(summary, level);
  return json;
}

}  // namespace sarblock
