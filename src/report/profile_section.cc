// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/units.h"

#include <cmath>
#include <numbers>

#include "charts.h"
#include "sections.h"
#include "statistics.h"

namespace sarblock {
namespace {

constexpr std::size_t kProfileBins = 24;
constexpr std::size_t kLeastInBin = 3;
constexpr std::size_t kMostDots = 1500;

/// Unit vector (east, north) across the direction most of the flight paths have; axes count, not
/// their sense, so angles are doubled.
std::array<double, 2> AcrossDirection(const ResultFolder& result, const MapPlane& plane) {
  double c = 0.0, s = 0.0;
  for (const ReportStrip& strip : result.strips) {
    const auto first = plane.Place(strip.antenna_m.front());
    const auto last = plane.Place(strip.antenna_m.back());
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

double AlongAzimuth(double ee_m2, double nn_m2, double en_m2, double azimuth_rad) {
  const double s = std::sin(azimuth_rad), c = std::cos(azimuth_rad);
  return std::sqrt(s * s * ee_m2 + c * c * nn_m2 + 2.0 * s * c * en_m2);
}

/// By point: what is shown of one component.
struct Profile {
  std::vector<double> paper_m, paper_with_path_m, held_m, whole_m;
};

struct Profiles {
  std::vector<double> x_km;
  std::vector<std::string> names;
  Profile across, up;
};

double Together(double noise_m, double path_m) { return std::hypot(noise_m, path_m); }

Profiles Collect(const ResultFolder& result) {
  const ReportPoints& points = result.points;
  const MapPlane plane(result);
  const std::array<double, 2> direction = AcrossDirection(result, plane);
  const double fallback_rad = std::atan2(direction[0], direction[1]);
  Profiles out;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    // A control point is known beforehand: it would say nothing of the geometry.
    if (points.solved[i] == 0 || points.role[i] == ReportRole::kControl ||
        std::isnan(points.sigma_m[i][0])) {
      continue;
    }
    const auto place = plane.Place(points.position_m[i]);
    out.x_km.push_back((place[0] * direction[0] + place[1] * direction[1]) / 1000.0);
    out.names.emplace_back(points.ids[i]);
    const auto leberl_deg = static_cast<double>(points.leberl_azimuth_deg[i]);
    const double azimuth_rad = std::isnan(leberl_deg) ? fallback_rad : leberl_deg * kRadPerDeg;
    const auto square = [](float v) { return static_cast<double>(v) * static_cast<double>(v); };
    const auto& sigma_m = points.sigma_m[i];
    const auto& held_m = points.sigma_held_m[i];
    const auto paper = [&](std::size_t k) { return static_cast<double>(points.leberl_m[i][k]); };
    out.across.whole_m.push_back(AlongAzimuth(square(sigma_m[0]),
                                              square(sigma_m[1]),
                                              static_cast<double>(points.cov_en_m2[i]),
                                              azimuth_rad));
    out.across.held_m.push_back(AlongAzimuth(square(held_m[0]),
                                             square(held_m[1]),
                                             static_cast<double>(points.cov_held_en_m2[i]),
                                             azimuth_rad));
    out.across.paper_m.push_back(paper(0));
    out.across.paper_with_path_m.push_back(Together(paper(0), paper(2)));
    out.up.whole_m.push_back(static_cast<double>(sigma_m[2]));
    out.up.held_m.push_back(static_cast<double>(held_m[2]));
    out.up.paper_m.push_back(paper(1));
    out.up.paper_with_path_m.push_back(Together(paper(1), paper(3)));
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
        MedianLine("rigorous intersection, paths exact", "line", "green", x, profile.held_m),
        MedianLine(whole, "line", "blue", x, profile.whole_m)}) {
    if (!series.x.empty()) chart.series.push_back(std::move(series));
  }
  return {id, title, "", "half", ChartJson(id, chart)};
}

}  // namespace

PageSection ProfileSection(const ResultFolder& result) {
  PageSection section{"profiles", "Sigma across the flight direction", {}};
  const Profiles profiles = Collect(result);
  if (profiles.x_km.empty()) {
    section.items.emplace_back(PageText{"No standard deviations were computed.", "note"});
    return section;
  }
  const std::string whole =
      result.summary.command == "intersect" ? "rigorous intersection" : "whole block";
  PageFigures figures;
  figures.figures.push_back(
      ProfileFigure(profiles, profiles.across, "profile-across", "Sigma across track", whole));
  figures.figures.push_back(
      ProfileFigure(profiles, profiles.up, "profile-up", "Sigma in height", whole));
  section.items.emplace_back(std::move(figures));
  section.items.emplace_back(PageText{
      "Medians of the points in strips of equal distance, control points left out. The "
      "intersection takes the flight paths as exact and is what the 1979 closed form (Eq. 25) "
      "approximates for the best pair of looks; what the block lies above it is what the flight "
      "paths add, what it lies below the closed form is gained by further looks.",
      "note"});
  return section;
}

}  // namespace sarblock
