// SPDX-License-Identifier: Apache-2.0
#include "result_realism.h"

#include <cmath>

namespace sarblock {
namespace {

using Json = nlohmann::ordered_json;

Json TestSection(const GlobalTest& test, double level) {
  return {{"sigma0_squared", test.sigma0_squared},
          {"redundancy", test.redundancy_1},
          {"value", test.sigma0_squared * test.redundancy_1},
          {"lower", test.chi_square.lower},
          {"upper", test.chi_square.upper},
          {"level", level},
          {"passed", test.passed}};
}

Json MeanSection(const RunMean& mean) {
  return {{"expected", mean.expected_1},
          {"mean", mean.mean_1},
          {"lower", mean.lower()},
          {"upper", mean.upper()},
          {"agrees", mean.Agrees()}};
}

}  // namespace

Json VarianceComponentsSection(const AdjustOptions& options, const AdjustResult& result) {
  const VarianceComponentReport& report = *result.variance_components;
  Json section;
  section["iterations"] = report.iterations;
  section["converged"] = report.converged;
  section["before"] = TestSection(report.before, options.test_level);
  section["after"] = TestSection(
      {result.sigma0_squared, result.redundancy(), result.chi_square, result.chi_square_passed},
      options.test_level);
  section["components"] = Json::array();
  for (const VarianceComponent& c : report.components) {
    section["components"].push_back({{"group", c.group},
                                     {"component", c.component == 0 ? "range" : "azimuth"},
                                     {"looks", c.looks},
                                     {"redundancy", c.redundancy_1},
                                     {"estimated", c.estimated},
                                     {"factor", c.factor_1},
                                     {"factor_sigma", c.factor_deviation_1},
                                     {"sigma_before", c.sigma_before},
                                     {"sigma_after", c.sigma_after()},
                                     {"sigma_after_sigma", c.sigma_deviation()},
                                     {"unit", c.unit},
                                     {"note", c.note}});
  }
  return section;
}

Json MonteCarloSection(const MonteCarloReport& report) {
  Json section;
  section["runs"] = report.runs;
  section["failed"] = report.failed;
  section["seed"] = report.seed;
  section["points"] = report.points;
  section["confidence"] = 0.99;
  section["normalised_square"] = MeanSection(report.square_ratio);
  section["variance_ratio_e"] = MeanSection(report.variance_ratio[0]);
  section["variance_ratio_n"] = MeanSection(report.variance_ratio[1]);
  section["variance_ratio_u"] = MeanSection(report.variance_ratio[2]);
  section["coverage_50"] = MeanSection(report.coverage[0]);
  section["coverage_90"] = MeanSection(report.coverage[1]);
  section["coverage_99"] = MeanSection(report.coverage[2]);
  section["points_outside"] = report.points_outside;
  section["verdict"] = report.sentence;
  return section;
}

void WriteMonteCarloTable(TableSink* sink, const ResultView& view) {
  const auto table = sink->Open("montecarlo", kMonteCarloColumns);
  TableWriter& out = *table;
  const MonteCarloReport& report = *view.result.montecarlo;
  for (std::uint32_t point = 0; point < report.square_1.size(); ++point) {
    if (report.runs == 0 || std::isnan(report.square_1[point])) continue;
    out.Id(view.block.points.ids[point], point);
    const std::array<double, 6>& sample_m2 = report.sample_m2[point];
    const SymmetricEnu& rigorous_m2 = view.result.points.covariance_m2[point];
    for (std::size_t i = 0; i < 3; ++i) out.Number(std::sqrt(view.factor * sample_m2[i]));
    for (std::size_t i = 0; i < 3; ++i) out.Number(std::sqrt(view.factor * rigorous_m2[i]));
    for (std::size_t i = 0; i < 3; ++i) out.Number(std::sqrt(sample_m2[i] / rigorous_m2[i]));
    out.Number(report.square_1[point]);
    for (const std::vector<std::uint32_t>& inside : report.inside) {
      out.Number(static_cast<double>(inside[point]) / report.runs);
    }
    out.EndRow();
  }
  out.Commit();
}

}  // namespace sarblock
