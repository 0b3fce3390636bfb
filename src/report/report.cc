// SPDX-License-Identifier: Apache-2.0
#include "report/report.h"

#include "sarblock/core/error.h"
#include "sarblock/tables/output.h"

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

void RequireResultOrStudy(const fs::path& path) {
  const auto fail = [&](const std::string& what) {
    throw InputError(FilePlace{path.string(), 0, ""},
                     what +
                         "; a result or a study is a folder with summary.json (a result) or with "
                         "densification.csv, tradeoff.csv or stability.csv (a study), or an HDF5 "
                         "file of a result");
  };
  if (!fs::exists(path)) fail("does not exist");
  if (!fs::is_directory(path) && !IsContainer(path)) fail("is a file that is no HDF5 file");
  if (fs::exists(path / "block.toml") && !fs::exists(path / "summary.json")) {
    fail("is a block, not a result or a study");
  }
}

}  // namespace

ReportFile WriteReport(const fs::path& folder, const fs::path& out, ProgressSink* progress) {
  const fs::path file = out.empty() ? FileOf(folder, "report.html") : out;
  RequireResultOrStudy(folder);
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
