// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdint>
#include <limits>

#include "charts.h"
#include "html.h"
#include "sections.h"
#include "statistics.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr std::size_t kProfileBins = 24;
constexpr std::size_t kLeastInBin = 3;
constexpr std::size_t kMostDots = 1500;

/// Unit vector (east, north) across the direction most of the flight paths have; axes count, not
/// their sense, so angles are doubled.
std::array<double, 2> AcrossDirection(const ResultFolder& result, const MapPlane& plane) {
  double c = 0.0, s = 0.0;
  for (const std::span<const StripStation> strip : StripsOf(result.file)) {
    const auto first = plane.Place(strip.front().antenna_m);
    const auto last = plane.Place(strip.back().antenna_m);
    const double angle = std::atan2(last[1] - first[1], last[0] - first[0]);
    c += std::cos(2.0 * angle);
    s += std::sin(2.0 * angle);
  }
  const double along = 0.5 * std::atan2(s, c);
  std::array<double, 2> across = {-std::sin(along), std::cos(along)};
  // East or north counts positive.
  if (across[0] + across[1] < 0.0) across = {-across[0], -across[1]};
  return across;
}

double AlongAzimuth(const std::vector<SymmetricEnu>& q_m2, std::size_t point, double azimuth_rad) {
  if (q_m2.empty()) return kAbsent;
  const double s = std::sin(azimuth_rad), c = std::cos(azimuth_rad);
  const auto& [ee_m2, nn_m2, uu_m2, en_m2, eu_m2, nu_m2] = q_m2[point];
  return std::sqrt(s * s * ee_m2 + c * c * nn_m2 + 2.0 * s * c * en_m2);
}

/// By point: what is shown of one component.
struct Profile {
  std::vector<double> paper_m, paper_with_path_m, fixed_paths_m, whole_m;
};

struct Profiles {
  std::vector<double> x_km;
  std::vector<std::string> names;
  Profile across, up;
};

/// Points by number of looks: further looks gain what a median over all would hide.
struct LookClass {
  std::uint32_t least = 2, most = 2;
  [[nodiscard]] bool Has(std::uint32_t looks) const { return looks >= least && looks <= most; }
  [[nodiscard]] std::string Name() const {
    if (least == most) return fmt::format("{} look{}", least, least == 1 ? "" : "s");
    return fmt::format("{} looks or more", least);
  }
};
constexpr std::uint32_t kAnyNumber = std::numeric_limits<std::uint32_t>::max();
constexpr LookClass kLookClasses[] = {{1, 1}, {2, 2}, {3, 3}, {4, kAnyNumber}};
constexpr std::size_t kLeastInClass = 10;

Profiles Collect(const ResultFolder& result, const LookClass& looks) {
  const ResultPoints& points = result.file.points;
  const PointResults& figures = points.results;
  const MapPlane plane(result);
  const std::array<double, 2> direction = AcrossDirection(result, plane);
  const double fallback_rad = std::atan2(direction[0], direction[1]);
  Profiles out;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    // A control point is known beforehand: it would say nothing of the geometry.
    if (!IsSolved(figures.status[i]) || points.role[i] == PointRole::kControl ||
        !looks.Has(figures.looks[i]) || std::isnan(SigmaOf(points, i, 0))) {
      continue;
    }
    const auto place = plane.Place(figures.position_m[i]);
    out.x_km.push_back((place[0] * direction[0] + place[1] * direction[1]) / 1000.0);
    out.names.emplace_back(points.ids[i]);
    const double leberl_rad = FigureOf(figures.leberl_across_azimuth_rad, i);
    const double azimuth_rad = std::isnan(leberl_rad) ? fallback_rad : leberl_rad;
    const double across_m = FigureOf(figures.sigma_leberl_across_m, i);
    const double up_m = FigureOf(figures.sigma_leberl_up_m, i);
    out.across.whole_m.push_back(AlongAzimuth(figures.covariance_m2, i, azimuth_rad));
    out.across.fixed_paths_m.push_back(
        AlongAzimuth(figures.fixed_path_covariance_m2, i, azimuth_rad));
    out.across.paper_m.push_back(across_m);
    out.across.paper_with_path_m.push_back(
        std::hypot(across_m, FigureOf(figures.sigma_leberl_path_across_m, i)));
    out.up.whole_m.push_back(SigmaOf(points, i, 2));
    out.up.fixed_paths_m.push_back(FixedPathSigmaOf(points, i, 2));
    out.up.paper_m.push_back(up_m);
    out.up.paper_with_path_m.push_back(
        std::hypot(up_m, FigureOf(figures.sigma_leberl_path_up_m, i)));
  }
  return out;
}

ChartSeries MedianLine(const std::string& label,
                       const std::string& style,
                       const std::string& color,
                       const std::vector<double>& x,
                       const std::vector<double>& values) {
  ChartSeries series{label, style, color, {}, {}, {}, {}, {}};
  for (const BinnedMedian& bin : MedianInBins(x, values, kProfileBins, kLeastInBin)) {
    series.x.push_back(bin.x);
    series.y.push_back(bin.value);
  }
  return series;
}

PageFigure ProfileFigure(const Profiles& profiles,
                         const Profile& profile,
                         const std::string& id,
                         const std::string& title,
                         const std::string& whole) {
  XyChart chart;
  chart.x.label = "distance across the flight direction [km]";
  chart.y.label = "sigma [m]";
  chart.y.logarithmic = true;
  ChartSeries dots{whole + ", single points", "points", "pale", {}, {}, {}, {}, {}};
  for (const std::uint32_t i : SampleIndices(profiles.x_km.size(), kMostDots)) {
    dots.x.push_back(profiles.x_km[i]);
    dots.y.push_back(profile.whole_m[i]);
    dots.names.push_back(profiles.names[i]);
  }
  chart.series.push_back(std::move(dots));
  const std::vector<double>& x = profiles.x_km;
  for (ChartSeries series :
       {MedianLine(
            "1979 paper, with priors of paths", "dash", "purple", x, profile.paper_with_path_m),
        MedianLine("1979 paper, range noise", "dash", "orange", x, profile.paper_m),
        MedianLine("rigorous intersection, paths exact", "line", "green", x, profile.fixed_paths_m),
        MedianLine(whole, "line", "blue", x, profile.whole_m)}) {
    if (!series.x.empty()) chart.series.push_back(std::move(series));
  }
  return {id, title, "", "half", ChartJson(id, chart)};
}

}  // namespace

PageSection ProfileSection(const ResultFolder& result) {
  PageSection section{"profiles", "Sigma across the flight direction", {}};
  const std::string whole =
      result.file.summary.command == "intersect" ? "rigorous intersection" : "whole block";
  std::vector<std::string> few;
  std::size_t shown = 0;
  for (const LookClass& looks : kLookClasses) {
    const Profiles profiles = Collect(result, looks);
    const std::size_t count = profiles.x_km.size();
    if (count == 0) continue;
    if (count < kLeastInClass) {
      few.push_back(fmt::format("{} with {}", count, looks.Name()));
      continue;
    }
    ++shown;
    const std::string title = fmt::format(", {} ({} points)", looks.Name(), ReadableCount(count));
    PageFigures figures;
    figures.figures.push_back(ProfileFigure(profiles,
                                            profiles.across,
                                            fmt::format("profile-across-{}", looks.least),
                                            "Sigma across track" + title,
                                            whole));
    figures.figures.push_back(ProfileFigure(profiles,
                                            profiles.up,
                                            fmt::format("profile-up-{}", looks.least),
                                            "Sigma in height" + title,
                                            whole));
    section.items.emplace_back(std::move(figures));
  }
  if (shown == 0) {
    section.items.emplace_back(
        PageText{few.empty() ? "No standard deviations were computed, or all points are control."
                             : "There are too few points for profiles.",
                 "note"});
    return section;
  }
  std::string note =
      "Medians of the points in strips of equal distance, by number of looks, control points left "
      "out. The intersection takes the flight paths as exact and is what the 1979 closed form (Eq. "
      "25) approximates for the best pair of looks; what the block lies above it is what the "
      "flight paths add, what it lies below the closed form is gained by further looks.";
  for (std::size_t i = 0; i < few.size(); ++i) {
    note += (i == 0 ? " Not drawn, too few: " : ", ") + few[i] + (i + 1 == few.size() ? "." : "");
  }
  section.items.emplace_back(PageText{note, "note"});
  return section;
}

}  // namespace sarblock
