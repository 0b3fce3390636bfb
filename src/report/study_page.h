// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "page.h"
#include "studies/study.h"

namespace sarblock {

/// A table of a study: those of its columns that a report shows, texts and numbers, by row.
struct StudyCsv {
  std::string kind;  ///< "densification", "design", "tradeoff", "stability"
  std::vector<StudyColumn> columns;
  std::vector<std::vector<std::string>> rows;  ///< by row and column; empty: not given

  /// Index of a column; columns.size() where the table has none of the name.
  [[nodiscard]] std::size_t Column(const std::string& name) const;
  [[nodiscard]] std::string Text(std::size_t row, const std::string& column) const;
  [[nodiscard]] double Number(std::size_t row, const std::string& column) const;  ///< NaN: none
  /// Whether the block of a row was determined; true of tables that do not say.
  [[nodiscard]] bool Determined(std::size_t row) const;
  /// True where some row gives a number.
  [[nodiscard]] bool HasNumbers(const std::string& column) const;
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
  std::string name, purpose;           ///< of the study (KIND.study.toml); may be empty
  std::vector<std::string> answers;    ///< lines of KIND.txt; empty: the study is not finished
  std::vector<StudyPicture> pictures;  ///< at most 1 MB together
};

[[nodiscard]] StudyFolder ReadStudyFolder(const std::filesystem::path& folder);

/// The section of a table, and its summary where the study has none of its own.
struct StudyPart {
  PageSection section;
  std::vector<std::string> sentences, attention;
  std::vector<PageFact> facts;
  HeadlineState state = HeadlineState::kNeutral;
  std::string word;
};
[[nodiscard]] StudyPart DensificationPart(const StudyCsv& table);
[[nodiscard]] StudyPart DesignPart(const StudyCsv& table);
[[nodiscard]] StudyPart TradeoffPart(const StudyCsv& table);
[[nodiscard]] StudyPart StabilityPart(const StudyCsv& table);

/// All rows of a table, numbers shortened, headings in words.
[[nodiscard]] PageTable WholeTable(const StudyCsv& table);
/// "median sigma up [m]" for "median_sigma_u_m".
[[nodiscard]] std::string ColumnPhrase(const std::string& column);
/// Rows of one value of a column, in the order of a number; those without it come last.
[[nodiscard]] std::vector<std::size_t> RowsOf(const StudyCsv& table,
                                              const std::string& column,
                                              const std::string& value,
                                              const std::string& order_by);

[[nodiscard]] Page MakeStudyPage(const StudyFolder& study);

}  // namespace sarblock
