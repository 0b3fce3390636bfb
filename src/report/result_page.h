// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/progress.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "page.h"
#include "shown_result.h"

namespace sarblock {

/// The sections of a result's report in the order of reading; a sentence replaces content that the
/// result does not have.
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

/// One chart per pass, or a sentence if the result has no residuals or stations for it.
[[nodiscard]] std::vector<PageItem> StripResidualItems(const ResultFolder& result);

/// A box of the map plane.
struct MapBox {
  std::array<double, 2> low_m{kAbsent, kAbsent}, high_m{kAbsent, kAbsent};
  void Add(const std::array<double, 2>& place_m);
  /// With a margin on all sides.
  [[nodiscard]] MapBox Widened(double margin_m) const;
};

/// Meridians and parallels of round degrees across the box `drawn`, so close that three to eight of
/// each cross the box `seen` in it (meridians 30 degrees apart where they meet in it), named
/// "45.5° N"; places in metres. Drawn at the height of the plane's origin. None in a local frame.
[[nodiscard]] std::vector<MapChart::Line> GraticuleOf(const Frame& frame,
                                                      const MapPlane& plane,
                                                      const MapBox& seen,
                                                      const MapBox& drawn);

/// The map of a result and its caption. Points are coloured from the 2nd to the
/// 98th percentile of the points that are not control; ellipses belong to these points too, since
/// those of points fixed at their control coordinates say nothing about the block.
struct BlockMap {
  MapChart chart;
  std::size_t placed = 0;   ///< points with a position; 0: there is no map
  std::size_t sampled = 0;  ///< of these, in the chart
  std::size_t passes = 0;   ///< of the chart
};
[[nodiscard]] BlockMap MapOf(const ResultFolder& result, const AccuracyFigures& accuracy);

/// What changed from one result to another, points matched by name.
struct ResultDifference {
  struct Point {
    std::uint32_t a = 0, b = 0;       ///< indices in the two results
    std::array<double, 3> shift_m{};  ///< b - a in east, north, up (local: x, y, z)
    double shift_length_m = 0.0;
    /// Largest of the three components in units of the larger of the two standard deviations; NaN
    /// where neither result has one.
    double shift_sigmas = kAbsent;
    std::array<double, 3> sigma_ratio{kAbsent, kAbsent, kAbsent};  ///< b over a
  };
  std::vector<Point> common;  ///< solved in both
  std::size_t only_in_a = 0, only_in_b = 0;
  struct Parameter {
    std::uint32_t a = 0, b = 0;
    double change = 0.0;             ///< b - a, in the parameter's unit
    double change_sigmas = kAbsent;  ///< in units of the larger standard deviation
  };
  std::vector<Parameter> parameters;  ///< in both
  std::size_t parameters_only_in_a = 0, parameters_only_in_b = 0;
  /// Keys of the configuration whose values differ: key, value in a, value in b ("" : not there).
  std::vector<std::array<std::string, 3>> settings;
  /// Input files that differ, by name.
  std::vector<std::string> inputs;
};
[[nodiscard]] ResultDifference CompareResults(const ResultFolder& a, const ResultFolder& b);

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
