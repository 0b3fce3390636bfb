// SPDX-License-Identifier: Apache-2.0
#include "option_checks.h"

#include "sarblock/core/error.h"

#include <string>

#include "solve/inner_datum.h"
#include "solve/reduced_engine.h"

namespace sarblock {

void RequireOffered(const AdjustOptions& options) {
  RequireInnerOffered(options);
  if (options.corrections == CorrectionChoice::kAuto && !options.priors.empty()) {
    throw InputError("adjust.prior", kNoAutomaticPriors);
  }
  if (options.quality.snooping != Snooping::kNone && options.robust != RobustLoss::kNone) {
    throw InputError("adjust.quality.snooping",
                     "tests least-squares residuals and stands beside a robust loss; \"robust\" = "
                     "\"none\" is allowed with it, and snooping = \"robust\" starts from one");
  }
  if (options.ceres_solver != CeresSolver::kAuto && Resolve(options.engine) != Engine::kCeres) {
    throw InputError("adjust.ceres_solver",
                     "is a choice within engine = \"ceres\", which is not asked for");
  }
  if (Resolve(options.covariance_method) == CovarianceMethod::kCeres &&
      options.covariance != CovarianceLevel::kBlock) {
    throw InputError("adjust.covariance_method",
                     "'ceres' forms the covariance of level 'block' only; allowed: auto, reduced");
  }
}

void RefuseRepetition(const AdjustOptions& options, const char* command, AdjustResult* result) {
  if (options.covariance == CovarianceLevel::kMonteCarlo) {
    throw InputError("adjust.covariance",
                     std::string("'montecarlo' repeats an adjustment, which ") + command +
                         " does not make; none, leberl, intersection or block is allowed");
  }
  if (options.variance_components != VarianceComponents::kNone) {
    Warn(result, std::string("variance components are not estimated by ") + command);
  }
}

}  // namespace sarblock
