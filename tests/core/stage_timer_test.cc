// SPDX-License-Identifier: Apache-2.0
#include <vector>

#include "core/threads.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

TEST(StageTimerTest, AddsUpWhatAStageTakesInParts) {
  std::vector<StageCost> costs;
  { const StageTimer solve("solve", &costs); }
  { const StageTimer covariance("covariance", &costs); }
  ASSERT_EQ(costs.size(), 2U);
  costs[0].wall_s = 100.0;
  { const StageTimer solve("solve", &costs); }
  ASSERT_EQ(costs.size(), 2U);
  EXPECT_EQ(costs[0].stage, "solve");
  EXPECT_GE(costs[0].wall_s, 100.0);
  EXPECT_GE(costs[0].peak_mib, costs[1].peak_mib);
}

}  // namespace
}  // namespace sarblock
