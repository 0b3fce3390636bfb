// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/model/options.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <exception>
#include <string>
#include <vector>

#include "mistakes.h"
#include "quality/covariance.h"
#include "quality/groups.h"
#include "sample.h"
#include "solve/rank.h"

namespace sarblock {
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
