// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"

#include <cstddef>
#include <filesystem>
#include <string>

namespace sarblock {

/// What was written.
struct ReportFile {
  std::filesystem::path file;
  std::string kind;     ///< "result", "comparison", "densification", "tradeoff" or "stability"
  std::string verdict;  ///< "Accepted"
  std::size_t bytes = 0;
};

/// Writes a report of a folder as one HTML file that needs no other and no network
/// (docs/report.md): of a result of adjust, intersect or predict (a folder with summary.json, or an
/// HDF5 file), or of a study (a folder with densification.csv, tradeoff.csv or stability.csv). An
/// empty `out` means report.html in the folder (FileOf() of tables/output.h). The same folder gives
/// the same bytes. Throws InputError for a folder that is neither, or whose files are damaged.
/// Large blocks are sampled, which the page says: it stays below 5 MB.
ReportFile WriteReport(const std::filesystem::path& folder,
                       const std::filesystem::path& out = {},
                       ProgressSink* progress = nullptr);

/// Two results of the same or of similar blocks side by side: what changed from a to b. Points and
/// passes are matched by name. An empty `out` means comparison.html in `b`.
ReportFile WriteComparison(const std::filesystem::path& a,
                           const std::filesystem::path& b,
                           const std::filesystem::path& out = {},
                           ProgressSink* progress = nullptr);

}  // namespace sarblock
