// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/model/options.h"

#include <algorithm>
#include <cstdint>
#include <exception>
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

}  // namespace

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
  } catch (const Interrupted&) {
    throw;
  } catch (const std::exception&) {  // what cannot be solved cures nothing
    tried = {};
  }
  return tried;
}

}  // namespace sarblock
