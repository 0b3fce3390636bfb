// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "session.h"
#include "studies/study.h"

namespace sarblock::cli {

/// What a study says beside its table.
struct StudyAnswer {
  std::vector<std::string> words;   ///< lines for people, also written to NAME.txt
  std::vector<std::string> tables;  ///< lines printed above them: tables for a terminal
  /// Further files of the folder, name and content: plots, more tables.
  std::vector<std::pair<std::string, std::string>> files;
  /// The table with the columns that need all rows, where the kind has such: written in place of
  /// the one that grew.
  std::optional<StudyTable> table;
};

/// A study read from its file, ready to run.
struct PreparedStudy {
  StudyPlan plan;
  /// Everything that the rows are a function of, as text: EffectiveStudyText and the texts of the
  /// scenes it names. A folder with rows of another identity is not resumed.
  std::string identity;
  std::function<StudyAnswer(const StudyTable& table, ProgressSink* progress)> conclude;
};

/// One kind of study: `sarblock study NAME STUDY.toml -o DIR` writes DIR/NAME.csv. Everything but
/// these two functions is common: the options, the threads, resuming, the files.
struct StudyKind {
  const char* name;
  const char* help;
  /// `threads` are those of the session, for tasks that run one by one.
  PreparedStudy (*prepare)(const std::string& file,
                           const std::vector<std::string>& overrides,
                           int threads);
  /// Dotted keys of the study file that `--set` may name.
  std::vector<std::string> (*keys)();
  bool divisible;  ///< whether parts of it may be computed apart
};

/// Keys of the kind of study that this command runs, "study densification".
[[nodiscard]] std::vector<std::string> StudyKeys(const std::string& command_path);

/// Adds `study` with every kind there is.
void AddStudy(CLI::App* app, Session* session);

[[nodiscard]] PreparedStudy PrepareDensification(const std::string& file,
                                                 const std::vector<std::string>& overrides,
                                                 int threads);
[[nodiscard]] PreparedStudy PrepareDesign(const std::string& file,
                                          const std::vector<std::string>& overrides,
                                          int threads);
[[nodiscard]] PreparedStudy PrepareTradeoff(const std::string& file,
                                            const std::vector<std::string>& overrides,
                                            int threads);
[[nodiscard]] PreparedStudy PrepareStability(const std::string& file,
                                             const std::vector<std::string>& overrides,
                                             int threads);

}  // namespace sarblock::cli
