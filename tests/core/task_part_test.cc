// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/progress.h"

#include <gtest/gtest.h>

namespace sarblock {
namespace {

// Hand values.
TEST(TaskPartTest, IsReadFromZeroOrFromOne) {
  EXPECT_EQ(TaskPartOf("3/8"), (TaskPart{3, 8}));
  EXPECT_EQ(TaskPartOf("0/8"), (TaskPart{0, 8}));
  EXPECT_EQ(TaskPartOf("8/8"), (TaskPart{0, 8}));
  EXPECT_EQ(NameOf(TaskPart{0, 8}), "part 8/8");
  EXPECT_EQ(NameOf(TaskPart{3, 8}), "part 3/8");
  for (const char* text :
       {"9/8", "3", "/8", "3/", "3/0", "-1/8", "+1/8", "1/1000001", "1/8 ", ""}) {
    EXPECT_FALSE(TaskPartOf(text)) << text;
  }
}

// Every task belongs to one part, and the counts of the parts are what they hold.
TEST(TaskPartTest, PartsHoldEveryTaskOnce) {
  for (const std::size_t count : {1U, 3U, 7U, 20U}) {
    std::size_t together = 0;
    for (std::size_t index = 0; index < count; ++index) {
      const TaskPart part{index, count};
      std::size_t held = 0;
      for (std::size_t task = 0; task < 13; ++task) held += part.Holds(task) ? 1U : 0U;
      EXPECT_EQ(part.TasksOf(13), held);
      together += held;
    }
    EXPECT_EQ(together, 13U);
  }
}

}  // namespace
}  // namespace sarblock
