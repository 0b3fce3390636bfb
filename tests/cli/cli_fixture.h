// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "support/folder_test.h"
#include "support/run_program.h"

namespace sarblock::test {

/// A folder of its own with simulated blocks in it.
class CliTest : public FolderTest {
 protected:
  using Path = std::filesystem::path;

  /// Simulates a shipped scene into `folder_ / name`.
  Path Simulated(const std::string& scene,
                 const std::string& name,
                 const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {
        "simulate",
        std::string(SARBLOCK_DATASETS) + "/scenes/" + scene + ".toml",
        "-o",
        folder_ / name,
        "--force"};  // over what a test edited
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramRun run = RunProgram(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return folder_ / name;
  }

  /// `command` on a block, result in `folder_ / result`.
  ProgramRun Run(const std::string& command,
                 const Path& block,
                 const std::string& result,
                 const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {command, block, "-o", folder_ / result};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  }

  /// Names in a folder, without the note of the checksums of a block.
  static std::set<std::string> FilesOf(const Path& folder) {
    std::set<std::string> names;
    if (!std::filesystem::exists(folder)) return names;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      names.insert(entry.path().filename());
    }
    names.erase(".sarblock-written");
    return names;
  }

  /// Replaces the first `from` in a file.
  static void Edit(const Path& file, const std::string& from, const std::string& to) {
    std::string text = Content(file);
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from << " is not in " << file;
    text.replace(at, from.size(), to);
    std::ofstream(file, std::ios::binary) << text;
  }
};

/// Cells of a table without quoted cells, header first.
inline std::vector<std::vector<std::string>> RowsOf(const std::string& text) {
  std::vector<std::vector<std::string>> rows;
  std::vector<std::string> row(1);
  for (const char c : text) {
    if (c == ',') {
      row.emplace_back();
    } else if (c == '\n') {
      rows.push_back(row);
      row.assign(1, "");
    } else {
      row.back() += c;
    }
  }
  return rows;
}

/// Index of a column of RowsOf().
inline std::size_t ColumnOf(const std::vector<std::vector<std::string>>& rows,
                            const std::string& name) {
  for (std::size_t i = 0; i < rows.at(0).size(); ++i) {
    if (rows[0][i] == name) return i;
  }
  ADD_FAILURE() << "no column " << name;
  return 0;
}

}  // namespace sarblock::test
