// SPDX-License-Identifier: Apache-2.0
#include "prior_quality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>

#include "model/priors.h"
#include "quality_summary.h"
#include "reliability.h"
#include <Eigen/Core>

namespace sarblock {
namespace {

/// Chance that a block whose priors hold is warned of.
constexpr double kWarnLevel_1 = 0.001;

bool IsMeasured(const AdjustResult& result) { return result.status != AdjustStatus::kPredicted; }

/// Of a prior that is independent of all others.
PriorTest TestOfPrior(const AdjustResult& result, const ParameterResult& parameter) {
  PriorTest out;
  const double ratio_1 = parameter.sigma / parameter.prior_sigma;
  if (std::isnan(ratio_1)) return out;
  out.redundancy_1 = std::max(0.0, 1.0 - ratio_1 * ratio_1);
  if (!IsMeasured(result) || out.redundancy_1 <= kLeastRedundancy_1) return out;
  out.w_1 = parameter.value / (parameter.prior_sigma * std::sqrt(out.redundancy_1));
  out.square_1 = out.w_1 * out.w_1 * out.redundancy_1;
  return out;
}

/// Covariances of the result within each joint prior.
std::vector<Eigen::MatrixXd> CovariancesOfJointPriors(const AdjustResult& result) {
  struct Place {
    std::size_t prior = 0;
    Eigen::Index row = 0;
  };
  std::vector<Eigen::MatrixXd> out;
  std::vector<std::optional<Place>> places(result.parameters.size());
  for (std::size_t p = 0; p < result.joint_priors.size(); ++p) {
    const std::vector<std::uint32_t>& parameters = result.joint_priors[p].parameters;
    const auto size = static_cast<Eigen::Index>(parameters.size());
    out.emplace_back(Eigen::MatrixXd::Constant(size, size, kNotGiven));
    for (Eigen::Index i = 0; i < size; ++i) {
      places[parameters[static_cast<std::size_t>(i)]] = Place{p, i};
    }
  }
  for (const ParameterCovariance& entry : result.parameter_covariance) {
    const auto &a = places[entry.a], &b = places[entry.b];
    if (!a || !b || a->prior != b->prior) continue;
    out[a->prior](a->row, b->row) = out[a->prior](b->row, a->row) = entry.covariance;
  }
  return out;
}

void TestJointPriors(const AdjustResult& result, std::vector<PriorTest>* tests) {
  const std::vector<Eigen::MatrixXd> covariances = CovariancesOfJointPriors(result);
  for (std::size_t p = 0; p < covariances.size(); ++p) {
    const JointPriorResult& prior = result.joint_priors[p];
    const Eigen::MatrixXd& c = covariances[p];
    JointPriorTerm term;
    term.Set(prior.covariance);
    const Eigen::Index size = c.rows();
    Eigen::VectorXd value(size);
    for (Eigen::Index i = 0; i < size; ++i) {
      value[i] = result.parameters[prior.parameters[static_cast<std::size_t>(i)]].value;
    }
    const Eigen::VectorXd weighted = term.information * value;
    // N by whitened rows: I - W C W' loses no more digits than 1 - sigma^2 / sigma0^2 does.
    const Eigen::MatrixXd left =
        Eigen::MatrixXd::Identity(size, size) - term.whitening * c * term.whitening.transpose();
    const Eigen::VectorXd n = (term.whitening.transpose() * left * term.whitening).diagonal();
    for (Eigen::Index i = 0; i < size; ++i) {
      PriorTest& test = (*tests)[prior.parameters[static_cast<std::size_t>(i)]];
      test = {};
      if (!c.allFinite()) continue;
      test.redundancy_1 = (term.factor * left * term.whitening)(i, i);
      const double least = kLeastRedundancy_1 * term.information(i, i);
      if (!IsMeasured(result)) continue;
      test.square_1 = value[i] * weighted[i];
      if (n[i] > least) test.w_1 = weighted[i] / std::sqrt(n[i]);
    }
  }
}

}  // namespace

std::vector<PriorTest> TestsOfPriors(const AdjustResult& result) {
  std::vector<PriorTest> out;
  out.reserve(result.parameters.size());
  for (const ParameterResult& parameter : result.parameters) {
    out.push_back(TestOfPrior(result, parameter));
  }
  if (!result.joint_priors.empty()) TestJointPriors(result, &out);
  return out;
}

std::string ContradictedPriors(const AdjustResult& result) {
  std::vector<double> w_1;
  std::size_t tested = 0;
  for (const PriorTest& test : TestsOfPriors(result)) {
    w_1.push_back(std::abs(test.w_1));
    tested += std::isnan(w_1.back()) ? 0U : 1U;
  }
  QualityOptions all;
  all.alpha_1 = kWarnLevel_1;
  all.family_wise = FamilyWise::kBonferroni;
  const double critical_1 = MakeReliability(all, tested, result.redundancy()).critical_w_1;
  std::size_t above = 0, worst = 0;
  for (std::size_t i = 0; i < w_1.size(); ++i) {
    if (!(w_1[i] > critical_1)) continue;
    if (above++ == 0 || w_1[i] > w_1[worst]) worst = i;
  }
  if (above == 0) return {};
  const ParameterResult& p = result.parameters[worst];
  std::array<char, 160> figures{};
  std::snprintf(
      figures.data(),
      figures.size(),
      "%.4g %s beside a standard deviation of %.4g %s, |w| %.1f; beyond %.2f is no chance",
      p.value,
      p.unit.c_str(),
      p.prior_sigma,
      p.unit.c_str(),
      w_1[worst],
      critical_1);
  return "priors: the observations contradict those of " + std::to_string(above) + " of " +
         std::to_string(tested) + " corrections, most that of " + p.owner + " " + p.name + " (" +
         figures.data() +
         "): a path that belongs to another pass, a prior that is too tight, or blunders in looks "
         "or control";
}

PriorSummary SummarisePriors(const AdjustOptions& options, const AdjustResult& result) {
  PriorSummary out;
  const ReliabilityFigures figures = ReliabilityOf(options, result);
  const bool tau = options.quality.test == BlunderTest::kTau;
  const std::vector<PriorTest> tests = TestsOfPriors(result);
  for (std::size_t i = 0; i < tests.size(); ++i) {
    const PriorTest& test = tests[i];
    if (std::isnan(test.redundancy_1)) continue;
    out.redundancy_1 = (out.priors++ == 0 ? 0.0 : out.redundancy_1) + test.redundancy_1;
    if (std::isnan(test.w_1)) continue;
    ++out.tested;
    const double statistic = std::abs(tau ? TauOf(test.w_1, result) : test.w_1);
    out.above += statistic > (tau ? figures.critical_tau_1 : figures.critical_w_1) ? 1U : 0U;
    if (out.tested == 1 || std::abs(test.w_1) > std::abs(out.worst_w_1)) {
      out.worst = i;
      out.worst_w_1 = test.w_1;
    }
  }
  out.expected_above_1 = figures.alpha_one_1 * static_cast<double>(out.tested);
  return out;
}

std::vector<PassShare> SharesOf(const Block& block, const AdjustResult& result) {
  std::vector<PassShare> out;
  if (result.quality.empty()) return out;
  std::map<std::string, std::size_t> index;
  const auto share_of = [&](const std::string& owner) -> PassShare& {
    const auto [found, added] = index.emplace(owner, out.size());
    if (added) {
      out.emplace_back();
      out.back().owner = owner;
    }
    return out[found->second];
  };
  for (const Pass& pass : block.passes) share_of(pass.id);
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    PassShare& share = out[block.looks.pass[i]];
    bool counts = false;
    for (std::size_t k = 0; k < 2; ++k) {
      const auto r_1 = static_cast<double>(result.quality.redundancy_1[k][i]);
      const auto w_1 = static_cast<double>(result.quality.w_1[k][i]);
      if (std::isnan(r_1)) continue;
      counts = true;
      share.redundancy_1 += r_1;
      // v^2 = w^2 r in units of sigma; without redundancy there is no residual either.
      if (!std::isnan(w_1)) share.square_sum_1 += w_1 * w_1 * r_1;
    }
    share.looks += counts ? 1U : 0U;
  }
  const std::vector<PriorTest> tests = TestsOfPriors(result);
  for (std::size_t i = 0; i < tests.size(); ++i) {
    const PriorTest& test = tests[i];
    if (std::isnan(test.redundancy_1)) continue;
    PassShare& share = share_of(result.parameters[i].owner);
    share.prior_redundancy_1 += test.redundancy_1;
    if (!std::isnan(test.square_1)) share.prior_square_sum_1 += test.square_1;
  }
  return out;
}

}  // namespace sarblock
