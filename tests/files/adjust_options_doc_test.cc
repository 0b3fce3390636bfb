// SPDX-License-Identifier: Apache-2.0
// docs/adjust_options.md is made of the option table; this test makes it again.
//     SARBLOCK_UPDATE_DOCS=1 files_tests --gtest_filter='AdjustOptionsDocTest.*'
// writes the file.
#include "sarblock/files/block_file.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>

namespace sarblock {
namespace {

constexpr const char* kIntroduction = R"(# Every key of `[adjust]`

Written from the table in the program that also drives reading and `--dump-config`; do not edit.
Keys are dotted, below `adjust` in `block.toml` and as they are given to `--set`. Several correction
groups of one kind are an array of tables; `--set` then takes an index from 0
(`correction.position.0.degree=2`). Any other key is refused, and so is a value that this version
knows by name but does not offer, with a message that says so. What the groups do:
[files and commands](formats.md), [theory](theory/README.md).
)";

std::string Heading(std::string_view key) {
  if (key.starts_with("selection.")) return "`selection`";
  const std::size_t begin = std::string_view("correction.").size();
  if (key.starts_with("quality.")) return "`quality`";
  if (key.starts_with("prior.")) return "`prior.NAME`";
  if (!key.starts_with("correction.")) return "General";
  const std::string_view kind = key.substr(begin, key.find('.', begin) - begin);
  return "`correction." + std::string(kind) + "`";
}

std::string Page() {
  std::string page = kIntroduction;
  std::string heading;
  for (const files::AdjustOption& option : files::AdjustOptionTable()) {
    if (Heading(option.key) != heading) {
      heading = Heading(option.key);
      page += "\n## " + heading +
              "\n\n| key | type | allowed | where left out | meaning |\n"
              "| --- | --- | --- | --- | --- |\n";
    }
    std::string_view key = option.key;
    if (heading != "General") key.remove_prefix(key.rfind('.') + 1);
    page += "| `" + std::string(key) + "`";
    for (const std::string_view cell :
         {option.type, option.allowed, option.standard, option.help}) {
      page += " | " + std::string(cell);
    }
    page += " |\n";
  }
  return page;
}

TEST(AdjustOptionsDocTest, ThePageIsThatOfTheTable) {
  const std::filesystem::path file = std::filesystem::path(SARBLOCK_DOCS) / "adjust_options.md";
  if (std::getenv("SARBLOCK_UPDATE_DOCS") != nullptr) {
    std::ofstream(file, std::ios::binary) << Page();
  }
  std::ifstream stream(file, std::ios::binary);
  const std::string written{std::istreambuf_iterator<char>(stream), {}};
  EXPECT_EQ(written, Page()) << "the options changed; write " << file << " again with\n"
                             << "SARBLOCK_UPDATE_DOCS=1 files_tests "
                                "--gtest_filter='AdjustOptionsDocTest.*'";
}

TEST(AdjustOptionsDocTest, NoCellBreaksTheTable) {
  for (const files::AdjustOption& option : files::AdjustOptionTable()) {
    for (const std::string_view cell :
         {option.key, option.type, option.allowed, option.standard, option.help}) {
      EXPECT_FALSE(cell.empty()) << option.key;
      EXPECT_EQ(cell.find_first_of("|\n"), std::string_view::npos) << option.key;
    }
  }
}

}  // namespace
}  // namespace sarblock
