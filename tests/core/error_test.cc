// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

#include "sarblock/core/progress.h"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

TEST(InputErrorTest, NamesFileLineAndField) {  // hand value: the documented form
  const InputError error({.file = "looks.csv", .line = 17, .field = "range_m"}, "-3 must be > 0");
  EXPECT_STREQ(error.what(), "looks.csv:17: range_m: -3 must be > 0");
}

TEST(InputErrorTest, LeavesOutWhatIsNotKnown) {
  EXPECT_STREQ(InputError({.file = "b.toml", .line = 0, .field = "datum"}, "no").what(),
               "b.toml: datum: no");
  EXPECT_STREQ(InputError({.file = "looks.csv", .line = 3, .field = ""}, "no").what(),
               "looks.csv:3: no");
  EXPECT_STREQ(InputError("knot_spacing_s", "no").what(), "knot_spacing_s: no");
}

TEST(InputErrorTest, KeepsItsPlace) {  // the definition
  const InputError in_file({.file = "looks.csv", .line = 17, .field = "range_m"}, "-3 must be > 0");
  EXPECT_EQ(in_file.place().file, "looks.csv");
  EXPECT_EQ(in_file.place().line, 17U);
  EXPECT_EQ(in_file.place().field, "range_m");
  EXPECT_EQ(in_file.problem(), "-3 must be > 0");
  const InputError in_memory("looks.pass[5]", "must be below 2");
  EXPECT_EQ(in_memory.place().file, "");
  EXPECT_EQ(in_memory.place().field, "looks.pass[5]");
  EXPECT_EQ(in_memory.problem(), "must be below 2");
}

TEST(ErrorTest, IsWhatAllHaveInCommon) {
  const auto caught = [](const auto& error) {
    try {
      throw error;
    } catch (const Error& base) {
      return std::string(base.what());
    }
  };
  EXPECT_EQ(caught(InputError("a", "b")), "a: b");
  EXPECT_EQ(caught(UndeterminedError("open", {"P"})), "open: P");
  EXPECT_EQ(caught(Interrupted("solve")), "interrupted during solve");
  EXPECT_EQ(Interrupted("solve").stage(), "solve");
}

TEST(VersionTest, OfTheHeadersIsThatOfTheLibrary) {
  const int major = SARBLOCK_VERSION / 10000, minor = SARBLOCK_VERSION / 100 % 100;
  EXPECT_EQ(Version(),
            std::to_string(major) + "." + std::to_string(minor) + "." +
                std::to_string(SARBLOCK_VERSION % 100));
}

TEST(UndeterminedErrorTest, KeepsEveryNameAndShowsTheFirstTen) {
  const std::vector<std::string> names = {
      "P0", "P1", "P2", "P3", "P4", "P5", "P6", "P7", "P8", "P9", "P10", "P11", "P12"};
  const UndeterminedError error("cannot be known", names);
  EXPECT_EQ(error.names(), names);
  EXPECT_STREQ(error.what(), "cannot be known: P0, P1, P2, P3, P4, P5, P6, P7, P8, P9 and 3 more");
}

class RecordingSink final : public ProgressSink {
 public:
  explicit RecordingSink(std::size_t cancel_at) : cancel_at_(cancel_at) {}
  void Update(std::string_view stage,
              std::size_t done,
              std::size_t total,
              std::string_view detail) override {
    last_ = std::string(stage) + " " + std::to_string(done) + "/" + std::to_string(total) + " " +
            std::string(detail);
    done_ = done;
  }
  [[nodiscard]] bool Cancelled() const override { return done_ >= cancel_at_; }
  [[nodiscard]] const std::string& last() const { return last_; }

 private:
  std::size_t cancel_at_;
  std::size_t done_ = 0;
  std::string last_;
};

TEST(StepTest, TellsTheSinkAndStopsWhenCancelled) {
  RecordingSink sink(3);
  Step(&sink, "solve", 2, 9, "cost 1.7");
  EXPECT_EQ(sink.last(), "solve 2/9 cost 1.7");
  try {
    Step(&sink, "solve", 3, 9);
    FAIL() << "a cancelled step went on";
  } catch (const Interrupted& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("solve"));
  }
  EXPECT_EQ(sink.last(), "solve 3/9 ");
}

TEST(StepTest, DoesNothingWithoutASink) { EXPECT_NO_THROW(Step(nullptr, "solve", 1, 2)); }

}  // namespace
}  // namespace sarblock
