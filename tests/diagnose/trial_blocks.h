// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/diagnose/diagnose.h"
#include "sarblock/model/options.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "plants.h"

namespace sarblock::test {

/// A block to plant mistakes in, drawn anew for every seed where it is simulated.
struct TrialBlock {
  Block block;
  AdjustOptions options;
  Truth truth;  ///< empty where the block is not simulated
};

/// Names of the blocks: the shipped scenes that can be solved (single-flight-squint is made to be
/// refused), those of recorded flights as "recorded/NAME", and
/// "cabeus-minirf" where its data are.
[[nodiscard]] std::vector<std::string> TrialNames();
[[nodiscard]] TrialBlock MakeTrialBlock(const std::string& name, std::uint64_t seed);

enum class Outcome {
  kNotApplicable,  ///< the block does not have what the mistake needs
  kFirst,          ///< the right sentence stands first
  kTied,           ///< it stands after others from which the sample does not tell it
  kListed,         ///< it stands after another one
  kWrong,          ///< other sentences alone
  kSilent,         ///< the block is seen to contradict itself, and nothing is said
  kUnseen,         ///< nothing contradicts: the mistake passes every test
};

struct TrialResult {
  Outcome outcome = Outcome::kNotApplicable;
  Planted planted;
  Diagnosis diagnosis;
  double diagnosis_s = 0.0;  ///< processor time, one thread
};

/// Processor time of one adjustment of the block without a mistake, one thread, the least of five.
[[nodiscard]] double AdjustmentTime_s(const std::string& name);

/// A block with a mistake planted in it and what is to be said of it.
struct PlantedBlock {
  TrialBlock made;
  Planted planted;
};
[[nodiscard]] PlantedBlock PlantIn(const std::string& name, const Plant& plant, std::uint64_t seed);

/// Plants a mistake in a block and diagnoses it.
[[nodiscard]] TrialResult RunTrial(const std::string& name, const Plant& plant, std::uint64_t seed);

}  // namespace sarblock::test
