// SPDX-License-Identifier: Apache-2.0
#include "cli/terminal.h"
#include <gtest/gtest.h>

namespace sarblock::cli {
namespace {

const std::string kTen = "123456789 ";  // nine characters and a space

TEST(FitColumnsTest, BreaksAtTheLastSpaceThatFitsAndIndentsByFourMore) {
  std::string eight;
  for (int i = 0; i < 8; ++i) eight += kTen;
  const std::string exact = eight.substr(0, 79) + "x";  // 80 columns
  EXPECT_EQ(FitColumns(exact + "\n"), exact + "\n");
  EXPECT_EQ(FitColumns("  " + exact), "  " + eight.substr(0, 69) + "\n      " + exact.substr(70));
}

TEST(FitColumnsTest, LeavesTablesAndLongWordsAsTheyAre) {
  const std::string row = "  " + std::string(50, 'a') + "   " + std::string(50, 'b');
  EXPECT_EQ(FitColumns(row), row);
  const std::string word(100, 'w');
  EXPECT_EQ(FitColumns("see " + word + " there"), "see\n    " + word + "\n    there");
  EXPECT_EQ(FitColumns("\n\n"), "\n\n");
  EXPECT_EQ(FitColumns(""), "");
}

TEST(FitHelpTest, GoesOnBelowTheDescription) {
  std::string eight;
  for (int i = 0; i < 8; ++i) eight += kTen;
  EXPECT_EQ(
      FitHelp("  --force     " + eight),
      "  --force     " + eight.substr(0, 59) + "\n" + std::string(14, ' ') + eight.substr(60, 19));
  EXPECT_EQ(FitHelp("  --force     " + kTen), "  --force     " + kTen);
}

TEST(FitColumnsTest, CountsCharactersNotBytes) {
  std::string text;
  for (int i = 0; i < 80; ++i) text += "\xC3\xA4";  // a-umlaut
  EXPECT_EQ(FitColumns(text + " b"), text + "\n    b");
}

}  // namespace
}  // namespace sarblock::cli
