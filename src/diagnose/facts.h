// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/corrections.h"

#include <vector>

#include "fit.h"
#include "hypothesis.h"
#include "sample.h"
#include "sightings.h"
#include <Eigen/Core>

namespace sarblock {

/// What hypotheses are made of.
struct Facts {
  const Sample& sample;
  const std::vector<PassSightings>& passes;  ///< of the sample's known points
  const CorrectionModel& corrections;
  const Fit& before;                 ///< the sample as it is
  const SampleResiduals& residuals;  ///< of `before`
};

using Hypotheses = std::vector<Hypothesis>;

}  // namespace sarblock
