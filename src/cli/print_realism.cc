// SPDX-License-Identifier: Apache-2.0
#include "print_realism.h"

#include <algorithm>
#include <cstddef>
#include <iterator>

#include "core/text.h"
#include <fmt/core.h>

namespace sarblock::cli {

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
                 report.before.chi_square.lower / report.before.redundancy_1,
                 report.before.chi_square.upper / report.before.redundancy_1,
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
                   c.redundancy_1,
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
