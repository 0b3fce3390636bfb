// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/files/result.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace sarblock {

/// Numbers that a result does not give.
inline constexpr double kAbsent = kNotGiven;
inline constexpr double kHighCorrelation = 0.95;

/// Components of a look, as results name them.
inline constexpr std::array kLookComponents{"range", "azimuth"};

/// Two parameters with a high correlation.
struct ReportCorrelation {
  std::uint32_t a = 0, b = 0;  ///< indices into the parameters
  double correlation = 0.0;
};

/// One observation of a look: index of the look and component, 0 range and 1 azimuth.
struct ReportLook {
  std::size_t look = 0;
  std::size_t component = 0;
};

/// What a report shows of the looks: by component, the figures of the looks in use that have one.
struct ReportLooks {
  std::array<std::vector<float>, 2> w, residual_m, redundancy, mdb_m, influence_m;
  std::size_t rejected = 0;
  std::vector<std::pair<std::string, std::size_t>> rejected_by_reason;
  /// Largest |w| first, at most kMaxWorst, none with a redundancy below kMinTested: its w
  /// says nothing of the observation alone.
  std::vector<ReportLook> worst;
  std::vector<ReportLook> left_out;  ///< rejected ones, largest residual first, at most kMaxWorst
  static constexpr std::size_t kMaxWorst = 300;
  static constexpr double kMinTested = 0.01;
};

/// A result as it was read, and what is counted and sorted once for all sections of its report.
struct ResultFolder {
  std::string path;
  files::ResultFile file;
  std::vector<std::uint32_t> unsolved;          ///< points
  std::vector<ReportCorrelation> correlations;  ///< |.| above kHighCorrelation, largest first
  std::size_t correlation_count = 0;            ///< of them in all; the list holds at most 40
  ReportLooks looks;
};

/// Counts and sorts what a result holds.
[[nodiscard]] ResultFolder Arrange(std::string path, files::ResultFile file);
/// Reads a result (ReadResult) for its report. Memory: about 400 bytes per point and 150 per look.
[[nodiscard]] ResultFolder ReadResultFolder(const std::filesystem::path& folder,
                                            ProgressSink* progress = nullptr);

/// Standard deviation of a point east, north or up; NaN where it is not known.
[[nodiscard]] double SigmaOf(const files::ResultPoints& points,
                             std::size_t point,
                             std::size_t axis);
/// The same with the flight paths known exactly.
[[nodiscard]] double FixedPathSigmaOf(const files::ResultPoints& points,
                                      std::size_t point,
                                      std::size_t axis);
/// A figure by point that a result may lack as a whole.
[[nodiscard]] double FigureOf(const std::vector<double>& of_points, std::size_t point);
[[nodiscard]] double IntersectionOf_deg(const files::ResultPoints& points, std::size_t point);

/// The stations of each pass that has some, in the order of the passes.
[[nodiscard]] std::vector<std::span<const StripStation>> StripsOf(const files::ResultFile& file);

}  // namespace sarblock
