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

#include "page.h"

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

/// Figures of the looks for a report: by component, for the looks in use that have a figure.
struct ReportLooks {
  std::array<std::vector<float>, 2> w, residual_m, redundancy, mdb_m, influence_m;
  std::size_t rejected = 0;
  std::vector<std::pair<std::string, std::size_t>> rejected_by_reason;
  /// Largest |w| first, at most kMaxWorst, none with a redundancy below kMinTested, since such a w
  /// does not test the observation itself.
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

/// How well the points of a result are known, and what limits it.
struct AccuracyFigures {
  std::size_t points = 0;                                     ///< solved, with standard deviations
  std::array<double, 3> median_m{kAbsent, kAbsent, kAbsent};  ///< east, north, up
  std::array<double, 3> most_m{kAbsent, kAbsent, kAbsent};    ///< 95 % are at or below it
  std::array<double, 3> largest_m{kAbsent, kAbsent, kAbsent};
  std::array<std::string, 3> largest_point;
  int weakest = 2;  ///< component with the largest median
  /// The figures below are for points that are determined by geometry: not control, two looks at
  /// least. Points determined by control or a single look do not show what would help.
  std::size_t free_points = 0;
  /// Median part of the variance of the weakest component that comes from the flight paths; the
  /// rest comes from the looks. NaN if the result does not give it.
  double path_part = kAbsent;
  double median_intersection_deg = kAbsent;
  /// Mean square of the cosine between the weakest component and the tracks of the passes, each
  /// with its looks: 1 along track, 0 across or up. NaN for plan components without strips.csv.
  double along_track = kAbsent;
  /// The twentieth of the points that is weakest in that component, against all.
  struct Group {
    std::size_t points = 0;
    double median_intersection_deg = kAbsent;
    double median_looks = kAbsent;
    double outside_control = kAbsent;  ///< part outside the hull of the control points
  };
  Group weak, all;
};
[[nodiscard]] AccuracyFigures DescribeAccuracy(const ResultFolder& result);

/// Names of east, north and up in a result: in a local frame x, y and z.
[[nodiscard]] std::array<const char*, 3> AxisNames(const Frame& frame);

/// Places in a horizontal plane [m]: east and north of the middle of the solved points, or x and y.
class MapPlane {
 public:
  explicit MapPlane(const ResultFolder& result);
  [[nodiscard]] std::array<double, 2> Place(const Eigen::Vector3d& position_m) const;
  /// "10.1234, 45.6789": the middle in degrees; empty for a local frame.
  [[nodiscard]] const std::string& middle() const { return middle_; }
  [[nodiscard]] const Eigen::Vector3d& origin_m() const { return origin_m_; }
  /// The position that lies in the plane at a place.
  [[nodiscard]] Eigen::Vector3d PositionAt(const std::array<double, 2>& place_m) const {
    return origin_m_ + axes_.transpose() * Eigen::Vector3d(place_m[0], place_m[1], 0.0);
  }

 private:
  Eigen::Vector3d origin_m_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes_ = Eigen::Matrix3d::Identity();
  std::string middle_;
};

/// What limits the accuracy, and what would improve it; empty where control or a single look
/// decides every point.
struct Advice {
  std::string would_help;  ///< "azimuth accuracy, more looks"
  std::string sentence;
};

/// The advice follows from three numbers of the points that geometry decides (AccuracyFigures):
/// the flight paths' part of the variance of the weakest component (above 0.6: control or better
/// paths; below 0.4: better looks; between: both), the direction of that component (along track,
/// where azimuth measures it, above 0.7; across track or up, which ranges measure, below 0.3), and
/// the angle of intersection (larger ones are advised below 60 degrees only).
[[nodiscard]] Advice AdviceOf(const AccuracyFigures& accuracy, const Frame& frame);

[[nodiscard]] Headline HeadlineOf(const ResultFolder& result, const AccuracyFigures& accuracy);

}  // namespace sarblock
