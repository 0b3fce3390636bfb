// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "study/study_table.h"
#include "study_journal.h"

namespace sarblock {

enum class StudyStart {
  kResume,   ///< keep what an earlier run of the same study finished
  kRestart,  ///< remove it
};

/// The rows of a study in a folder.
///
/// `NAME.csv` is the table. It grows as tasks finish, in the study's order: at every moment it
/// holds whole rows, from the first on. `NAME.progress` beside it holds every finished task in the
/// order they finished (study_journal.h); it is what a later run resumes from. A record that a
/// killed run left half written there is dropped. `NAME.study.toml` is the identity's text: the
/// study as it ran, for reports.
///
/// Of a part both hold the tasks of that part alone, in their order.
///
/// kResume throws InputError where the folder holds rows of another study or of another part, and
/// where NAME.csv stands there without NAME.progress; both modes where another process has the
/// study open.
class StudyRows final : public StudyStore {
 public:
  StudyRows(const std::filesystem::path& folder, StudyIdentity identity, StudyStart start);
  ~StudyRows() override;

  [[nodiscard]] const std::vector<StudyRow>* Find(std::size_t task) const override;
  void Keep(std::size_t task, const std::vector<StudyRow>& rows) override;
  /// Tasks taken over from an earlier run.
  [[nodiscard]] std::size_t kept() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A table as the text of NAME.csv.
[[nodiscard]] std::string StudyTableText(const StudyTable& table);

/// A NAME.csv read back. Throws InputError with file, line and column.
[[nodiscard]] StudyTable ReadStudyTable(const std::filesystem::path& file,
                                        std::vector<StudyColumn> columns);

}  // namespace sarblock
