// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/model/options.h"

#include <cstdint>
#include <functional>
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
  /// Whether a mistake in the rows of these points alone may be told: without all of them, which no
  /// change of them beats, v'Pv falls by as much as an explanation is to take.
  const std::function<bool(const std::vector<std::uint32_t>& points)>& may_explain;
};

using Hypotheses = std::vector<Hypothesis>;

}  // namespace sarblock
