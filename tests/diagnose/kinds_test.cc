// SPDX-License-Identifier: Apache-2.0
// Kinds of mistakes that another explanation once stood before, or before which nothing was said;
// what is planted is what is to be named.
#include "sarblock/diagnose/diagnose.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "diagnose/plants.h"
#include "diagnose/trial_blocks.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using test::Outcome;

void ExpectFirst(const std::string& block, const std::string& mistake, std::uint64_t seed) {
  const test::TrialResult result = test::RunTrial(block, test::PlantNamed(mistake), seed);
  std::string all;
  for (const std::string& text : result.diagnosis.Sentences()) all += "\n  " + text;
  EXPECT_EQ(result.outcome, Outcome::kFirst)
      << block << ", " << mistake << ", seed " << seed << all;
}

// A spline of all axes of all passes takes them as well, with five times as many parameters.
TEST(KindsTest, TimesThatWanderInOnePassAreNoErrorsOfAllFlights) {
  for (const char* block : {"different-altitudes", "opposite-side", "leberl-voir"}) {
    for (const std::uint64_t seed : {1U, 2U, 3U})
      ExpectFirst(block, "times of a pass wander", seed);
  }
}

// The known points of such a pass are too few for a line of their squints: its residuals show it.
TEST(KindsTest, NativeDopplerIsSeenByTiePoints) {
  ExpectFirst("venus-magellan", "native Doppler read as zero", 2);
  ExpectFirst("different-altitudes", "native Doppler read as zero", 3);
}

// Of what cures the block the fewest parameters stand first: a constant before a drift.
TEST(KindsTest, FewerParametersThatCureComeFirst) {
  ExpectFirst("recorded/airborne-turbulent", "times of a pass late or early", 1);
}

// Curves of ranges are followed until they take all of the error.
TEST(KindsTest, RangesThatWanderAreNoNoise) {
  ExpectFirst("cross-wise", "ranges of a pass wander", 3);
  ExpectFirst("different-altitudes", "ranges of a pass wander", 2);
  ExpectFirst("leberl-aircraft", "ranges of a pass wander", 2);
}

// Positions corrected by 125 km would cure the block: those are other paths.
TEST(KindsTest, PathsAsFarOffAsTheRangeAreNoMatterOfPriors) {
  for (const std::uint64_t seed : {1U, 3U}) {
    ExpectFirst("earth-same-side", "an image coregistered to another", seed);
  }
}

// Statistics over seeds: sizes found over what was planted, in their standard deviations. Their
// mean has the standard deviation 1 / sqrt(n); with the redundancy of all observations, that of
// priors and control included, in place of that of the looks it is near 1.
TEST(KindsTest, FactorsOfStandardDeviationsAreFreeOfBias) {
  double sum = 0.0;
  int count = 0;
  for (const char* block : {"earth-same-side", "moon-alse", "venus-magellan", "block-12-strips"}) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      const test::TrialResult result =
          test::RunTrial(block, test::PlantNamed("sigmas 100 times too large"), seed);
      ASSERT_EQ(result.outcome, Outcome::kFirst) << block << ", seed " << seed;
      const Explanation& first = result.diagnosis.explanations.front();
      sum += std::log(first.value / 100.0) / (first.sigma / first.value);
      ++count;
    }
  }
  EXPECT_LT(std::abs(sum / count), 3.0 / std::sqrt(count));
}

// 59 m of heights or a shift with 59 m of it up: the sample of this block does not decide.
TEST(KindsTest, TiesAreToldAsTies) {
  const test::TrialResult result =
      test::RunTrial("leberl-aircraft", test::PlantNamed("control shifted by one vector"), 1);
  ASSERT_GE(result.diagnosis.explanations.size(), 2U);
  const auto tied = [](const Explanation& one) {
    return one.sentence.find("; the sample does not tell it from the first; ") != std::string::npos;
  };
  EXPECT_FALSE(tied(result.diagnosis.explanations.front()));
  const auto right = std::find_if(result.diagnosis.explanations.begin(),
                                  result.diagnosis.explanations.end(),
                                  [](const auto& e) { return e.cause == "control.shift"; });
  ASSERT_NE(right, result.diagnosis.explanations.end());
  EXPECT_TRUE(tied(*right)) << right->sentence;
}

}  // namespace
}  // namespace sarblock
