// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "headline.h"
#include "page.h"
#include "result_folder.h"

namespace sarblock {

/// The sections of a result's report in the order of reading, each with a sentence in place of what
/// the result does not have.
[[nodiscard]] PageSection CountsSection(const ResultFolder& result);
[[nodiscard]] PageSection TestSection(const ResultFolder& result);
[[nodiscard]] PageSection KnownPointsSection(const ResultFolder& result);
[[nodiscard]] PageSection MapSection(const ResultFolder& result, const AccuracyFigures& accuracy);
[[nodiscard]] PageSection ProfileSection(const ResultFolder& result);
[[nodiscard]] PageSection ResidualSection(const ResultFolder& result);
[[nodiscard]] PageSection WorstLooksSection(const ResultFolder& result);
[[nodiscard]] PageSection CorrectionSection(const ResultFolder& result);
[[nodiscard]] PageSection ModelSection(const ResultFolder& result);
[[nodiscard]] PageSection CostSection(const ResultFolder& result);
[[nodiscard]] PageSection OriginSection(const ResultFolder& result);

/// The whole page of a result.
[[nodiscard]] Page MakeResultPage(const ResultFolder& result);
/// Two results side by side.
[[nodiscard]] Page MakeComparisonPage(const ResultFolder& a, const ResultFolder& b);

/// The time at which a pass looked at a place: where the line from the nearest to the farthest
/// ground of a station (strips.csv; without it the plane across the track) passes over the place,
/// linear between stations. NaN more than one station's distance before or after the strip. Good
/// to a small part of the strip, which is enough for a chart.
[[nodiscard]] double StripTimeOf_s(std::span<const StripStation> strip,
                                   const MapPlane& plane,
                                   const std::array<double, 2>& place_m);

/// Residuals of the looks in use of one pass against the time along its strip.
struct StripResiduals {
  std::uint32_t pass = 0;
  std::vector<std::size_t> looks;  ///< rows of ResultLooks, by time
  std::vector<double> time_s;
  std::array<std::vector<double>, 2> residual_m;  ///< range, azimuth
  /// Largest |correlation with time| sqrt(n) of the two: about a normal deviate without a trend.
  [[nodiscard]] double Trend() const;
};
[[nodiscard]] std::vector<StripResiduals> ResidualsAlongStrips(const ResultFolder& result);

/// A chart a pass, or a sentence in place of what the result does not have.
[[nodiscard]] std::vector<PageItem> StripResidualItems(const ResultFolder& result);

/// What was written.
struct ReportFile {
  std::filesystem::path file;
  std::string kind;     ///< "result", "comparison", "densification", "tradeoff" or "stability"
  std::string verdict;  ///< "Accepted"
  std::size_t bytes = 0;
};

/// Writes a report of a folder as one HTML file that needs no other and no network
/// (docs/report.md): of a result of adjust, intersect or predict (a folder with summary.json, or an
/// HDF5 file), or of a study (a folder with densification.csv, design.csv, tradeoff.csv or
/// stability.csv). An empty `out` means report.html in the folder (FileOf() of tables/output.h).
/// The same folder gives the same bytes. Throws InputError for a folder that is neither, or whose
/// files are damaged. Large blocks are sampled, which the page says: it stays below 5 MB.
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
