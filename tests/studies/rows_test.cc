// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

#include "studies/study.h"
#include "support/folder_test.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using ::testing::HasSubstr;

class StudyRowsTest : public test::FolderTest {
 protected:
  static StudyIdentity Identity(const std::string& text = "a = 1") {
    return {"squares",
            {{"n", StudyCellKind::kInteger},
             {"square", StudyCellKind::kNumber},
             {"name", StudyCellKind::kText}},
            4,
            text};
  }
  static StudyRow Row(std::int64_t n, double square, const std::string& name) {
    return {n, square, name};
  }
  [[nodiscard]] std::string Table() const { return Content(folder_ / "squares.csv"); }
  [[nodiscard]] std::string Refusal(const StudyIdentity& identity) const {
    try {
      const StudyRows rows(folder_, identity, StudyStart::kResume);
    } catch (const InputError& error) {
      return error.what();
    }
    return {};
  }
};

TEST_F(StudyRowsTest, ListsRowsInTheOrderOfTheStudyAsSoonAsItCan) {
  StudyRows rows(folder_, Identity(), StudyStart::kResume);
  EXPECT_EQ(Table(), "n,square,name\n");
  rows.Keep(1, {Row(1, 1.5, "one, and a half")});
  EXPECT_EQ(Table(), "n,square,name\n");  // task 0 is missing
  rows.Keep(0, {Row(0, 0.1, "zero"), Row(0, 0.2, "")});
  EXPECT_EQ(Table(), "n,square,name\n0,0.1,zero\n0,0.2,\n1,1.5,\"one, and a half\"\n");
  rows.Keep(2, {});
  rows.Keep(3, {StudyRow{StudyCell{}, StudyCell{}, StudyCell{}}});
  EXPECT_THAT(Table(), HasSubstr("half\"\n,,\n"));
}

TEST_F(StudyRowsTest, TheStudyIsWrittenBesideItsRows) {
  const StudyRows rows(folder_, Identity("name = 'squares'"), StudyStart::kResume);
  EXPECT_EQ(Content(folder_ / "squares.study.toml"),
            "# written by sarblock: the study of squares.csv\nname = 'squares'");
}

TEST_F(StudyRowsTest, ALaterRunFindsEveryFinishedTaskAndDropsAHalfWrittenOne) {
  const StudyRow second = Row(2, 0.1 + 0.2, "#2");
  {
    StudyRows rows(folder_, Identity(), StudyStart::kResume);
    rows.Keep(2, {second, second});
    rows.Keep(0, {Row(0, 1e-300, "zero")});
  }
  const auto journal = folder_ / "squares.progress";
  const std::string whole = Content(journal);
  for (const char* torn : {"task 1 rows 1\n1,1,on", "task 1 rows 1\n1,1,one\nend", "tas"}) {
    Put("squares.progress", whole + torn);
    StudyRows rows(folder_, Identity(), StudyStart::kResume);
    EXPECT_EQ(rows.kept(), 2u);
    ASSERT_NE(rows.Find(2), nullptr);
    EXPECT_EQ(*rows.Find(2), (std::vector<StudyRow>{second, second}));
    EXPECT_EQ(rows.Find(1), nullptr);
    EXPECT_EQ(Content(journal), whole);
    EXPECT_EQ(Table(), "n,square,name\n0,1e-300,zero\n");
  }
  StudyRows rows(folder_, Identity(), StudyStart::kResume);
  rows.Keep(1, {Row(1, 1, "one")});
  EXPECT_EQ(Table(),
            "n,square,name\n0,1e-300,zero\n1,1,one\n2,0.30000000000000004,\"#2\"\n"
            "2,0.30000000000000004,\"#2\"\n");
}

// A bit that flips anywhere in a record: the record and what stands behind it are computed anew.
TEST_F(StudyRowsTest, ADamagedRecordIsNotRead) {
  const StudyRow row = Row(2, 4.25, "two");
  {
    StudyRows rows(folder_, Identity(), StudyStart::kResume);
    rows.Keep(2, {row});
    rows.Keep(0, {Row(0, 0.5, "zero")});
  }
  const std::string whole = Content(folder_ / "squares.progress");
  const std::size_t second = whole.find("task 0"), begin = whole.find("task 2");
  for (std::size_t at = begin; at + 1 < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    Put("squares.progress", damaged);
    StudyRows rows(folder_, Identity(), StudyStart::kResume);
    EXPECT_EQ(rows.kept(), at < second ? 0u : 1u) << at;
    EXPECT_EQ(rows.Find(0), nullptr) << at;
    EXPECT_EQ(rows.Find(2) != nullptr, at >= second) << at;
  }
}

TEST_F(StudyRowsTest, AChangedStudyIsRefusedUnlessRestarted) {
  {
    StudyRows rows(folder_, Identity(), StudyStart::kResume);
    rows.Keep(0, {Row(0, 0, "zero")});
  }
  EXPECT_EQ(Refusal(Identity()), "");
  EXPECT_THAT(Refusal(Identity("a = 2")), HasSubstr("belongs to another study"));
  StudyIdentity columns = Identity();
  columns.columns[1].name = "cube";
  EXPECT_THAT(Refusal(columns), HasSubstr("belongs to another study"));
  EXPECT_EQ(Table(), "n,square,name\n0,0,zero\n");  // untouched
  const StudyRows restarted(folder_, Identity("a = 2"), StudyStart::kRestart);
  EXPECT_EQ(restarted.kept(), 0u);
  EXPECT_EQ(Table(), "n,square,name\n");
}

TEST_F(StudyRowsTest, ATableWithoutItsRecordIsNotOverwritten) {
  Put("squares.csv", "mine\n");
  EXPECT_THAT(Refusal(Identity()), HasSubstr("without the record squares.progress"));
  EXPECT_EQ(Table(), "mine\n");
}

TEST_F(StudyRowsTest, TwoRunsDoNotShareAFolder) {
  const StudyRows rows(folder_, Identity(), StudyStart::kResume);
  EXPECT_THAT(Refusal(Identity()), HasSubstr("is in use"));
}

}  // namespace
}  // namespace sarblock
