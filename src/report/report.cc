// SPDX-License-Identifier: Apache-2.0
#include "sarblock/report/report.h"

#include "sarblock/core/error.h"
#include "sarblock/io/atomic_file.h"

#include <utility>

#include "result_folder.h"
#include "sections.h"
#include "study_page.h"

namespace sarblock {
namespace {

namespace fs = std::filesystem;

ReportFile WritePage(const Page& page,
                     std::string kind,
                     const fs::path& file,
                     ProgressSink* progress) {
  Step(progress, "write", 0, 0, file.filename().string());
  const std::string html = RenderPage(page);
  if (file.has_parent_path()) MakeFolder(file.parent_path());
  AtomicFile out(file);
  out.Write(html);
  out.Commit();
  return {file, std::move(kind), page.headline.word, html.size()};
}

}  // namespace

ReportFile WriteReport(const fs::path& folder, const fs::path& out, ProgressSink* progress) {
  const fs::path file = out.empty() ? FileOf(folder, "report.html") : out;
  if (!fs::exists(folder)) {
    throw InputError(FilePlace{folder.string(), 0, ""},
                     "does not exist; a result or a study is needed");
  }
  if (!fs::is_directory(folder) || fs::exists(folder / "summary.json")) {
    return WritePage(MakeResultPage(ReadResultFolder(folder, progress)), "result", file, progress);
  }
  const StudyFolder study = ReadStudyFolder(folder);
  if (study.tables.empty()) {
    throw InputError(FilePlace{folder.string(), 0, ""},
                     "has no summary.json (a result) and no densification.csv, tradeoff.csv or "
                     "stability.csv (a study)");
  }
  return WritePage(MakeStudyPage(study), study.tables.front().kind, file, progress);
}

ReportFile WriteComparison(const fs::path& a,
                           const fs::path& b,
                           const fs::path& out,
                           ProgressSink* progress) {
  const fs::path file = out.empty() ? FileOf(b, "comparison.html") : out;
  const ResultFolder first = ReadResultFolder(a, progress);
  const ResultFolder second = ReadResultFolder(b, progress);
  return WritePage(MakeComparisonPage(first, second), "comparison", file, progress);
}

}  // namespace sarblock
