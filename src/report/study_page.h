// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "page.h"

namespace sarblock {

/// A table of a study: the known columns (docs/formats.md), texts and numbers, by row.
struct StudyCsv {
  std::string kind;  ///< "densification", "tradeoff", "stability"
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;  ///< by row and column; empty: not given

  /// Index of a column; columns.size() where the table has none of the name.
  [[nodiscard]] std::size_t Column(const std::string& name) const;
  [[nodiscard]] std::string Text(std::size_t row, const std::string& column) const;
  [[nodiscard]] double Number(std::size_t row, const std::string& column) const;  ///< NaN: none
  /// Different texts of a column in order of appearance.
  [[nodiscard]] std::vector<std::string> Values(const std::string& column) const;
};

/// A picture that the study has drawn.
struct StudyPicture {
  std::string name, svg;
};

struct StudyFolder {
  std::string path;
  std::vector<StudyCsv> tables;
  std::vector<StudyPicture> pictures;  ///< at most 1 MB together
};

[[nodiscard]] StudyFolder ReadStudyFolder(const std::filesystem::path& folder);
[[nodiscard]] Page MakeStudyPage(const StudyFolder& study);

}  // namespace sarblock
