// SPDX-License-Identifier: Apache-2.0
#include "sentinel1_timing.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/geometry/frame.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <utility>

#include "image.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

// What is wrong with a part that may be missing; empty where `read` accepts it.
template <typename Read>
std::string ProblemOfPart(const Read& read) {
  try {
    read();
    return {};
  } catch (const InputError& error) {
    return error.what();
  }
}

XmlElement Descend(XmlElement element, std::initializer_list<const char*> names) {
  for (const char* name : names) element = element.Child(name);
  return element;
}

void ReadPulses(const XmlElement& root, std::vector<Sentinel1Pulses>* all) {
  const XmlElement list = Descend(root, {"generalAnnotation", "downlinkInformationList"});
  std::vector<Sentinel1Pulses> pulses;
  for (const XmlElement& element : list.Children("downlinkInformation")) {
    const XmlElement values = element.Child("downlinkValues");
    Sentinel1Pulses entry;
    entry.swath = element.Child("swath").Text();
    entry.from = element.Child("azimuthTime").Time();
    const XmlElement interval = values.Child("pri"), chirp = values.Child("txPulseRampRate");
    constexpr double kLongest_s = 0.01, kLongestWay_s = 0.05, kSlowest_hz_per_s = 1e9;
    if (!(interval.Positive() < kLongest_s)) interval.Fail("is no pulse repetition interval");
    entry.listening_s = values.Child("rank").Count() * interval.Number();
    if (!(entry.listening_s < kLongestWay_s)) {
      values.Child("rank").Fail("pulse intervals are longer than any echo takes");
    }
    entry.chirp_rate_hz_per_s = chirp.Number();
    if (!(std::abs(entry.chirp_rate_hz_per_s) > kSlowest_hz_per_s)) chirp.Fail("is no chirp rate");
    pulses.push_back(std::move(entry));
  }
  if (pulses.empty()) list.Fail("has no downlinkInformation");
  *all = std::move(pulses);
}

Sentinel1Polynomial ReadPolynomial(const XmlElement& element, const char* name) {
  Sentinel1Polynomial polynomial;
  polynomial.time = element.Child("azimuthTime").Time();
  polynomial.origin_s = element.Child("t0").Number();
  if (const auto list = element.Find(name)) {
    polynomial.coefficients = list->Numbers();
  } else {  // of annotations before 2015
    for (const char* power : {"c0", "c1", "c2"}) {
      polynomial.coefficients.push_back(element.Child(power).Number());
    }
  }
  return polynomial;
}

void ReadPolynomials(const XmlElement& list,
                     const char* entry,
                     const char* name,
                     std::vector<Sentinel1Polynomial>* all) {
  std::vector<Sentinel1Polynomial> polynomials;
  for (const XmlElement& element : list.Children(entry)) {
    polynomials.push_back(ReadPolynomial(element, name));
  }
  if (polynomials.empty()) list.Fail(std::string("has no ") + entry);
  *all = std::move(polynomials);
}

void ReadParts(const XmlElement& root, std::vector<Sentinel1Part>* all) {
  const auto merging = root.Find("swathMerging");
  const auto list = merging ? merging->Find("swathMergeList") : std::nullopt;
  if (!list) return;
  std::vector<Sentinel1Part> parts;
  for (const XmlElement& merge : list->Children("swathMerge")) {
    const std::string swath = merge.Child("swath").Text();
    for (const XmlElement& bounds : merge.Child("swathBoundsList").Children("swathBounds")) {
      parts.push_back(
          {swath,
           {bounds.Child("firstAzimuthLine").Count(), bounds.Child("lastAzimuthLine").Count()},
           {bounds.Child("firstRangeSample").Count(), bounds.Child("lastRangeSample").Count()}});
    }
  }
  *all = std::move(parts);
}

// The entry whose time is nearest.
const Sentinel1Polynomial& Nearest(const std::vector<Sentinel1Polynomial>& all,
                                   const UtcTime& time) {
  return *std::min_element(all.begin(), all.end(), [&](const auto& a, const auto& b) {
    return std::abs(SecondsBetween(a.time, time)) < std::abs(SecondsBetween(b.time, time));
  });
}

constexpr double kTwoWay_s_per_m = 2.0 / kSpeedOfLight_mps;

}  // namespace

double Sentinel1Polynomial::At(double two_way_s) const {
  const double x_s = two_way_s - origin_s;
  double value = 0.0;
  for (auto c = coefficients.rbegin(); c != coefficients.rend(); ++c) value = value * x_s + *c;
  return value;
}

Sentinel1Radar ReadSentinel1Radar(const XmlElement& root) {
  Sentinel1Radar radar;
  if (const auto processing = root.Child("imageAnnotation").Find("processingInformation")) {
    const auto applied = processing->Find("bistaticDelayCorrectionApplied");
    radar.bistatic_corrected = !applied || applied->Text() != "false";
  }
  radar.steering_problem = ProblemOfPart([&] {
    radar.steering_rad_per_s =
        kRadPerDeg *
        Descend(root, {"generalAnnotation", "productInformation", "azimuthSteeringRate"}).Number();
  });
  radar.pulses_problem = ProblemOfPart([&] { ReadPulses(root, &radar.pulses); });
  radar.doppler_problem = ProblemOfPart([&] {
    ReadPolynomials(Descend(root, {"dopplerCentroid", "dcEstimateList"}),
                    "dcEstimate",
                    "dataDcPolynomial",
                    &radar.doppler);
  });
  radar.fm_rate_problem = ProblemOfPart([&] {
    ReadPolynomials(Descend(root, {"generalAnnotation", "azimuthFmRateList"}),
                    "azimuthFmRate",
                    "azimuthFmRatePolynomial",
                    &radar.fm_rate);
  });
  radar.parts_problem = ProblemOfPart([&] { ReadParts(root, &radar.parts); });
  return radar;
}

/// Doppler at which a place was seen, and the rate with which it was focused.
struct Sentinel1Timing::Rates {
  double doppler_hz = 0.0;
  double fm_rate_hz_per_s = kNotGiven;
};

Sentinel1Timing::Sentinel1Timing(Sentinel1Radar radar,
                                 std::string swath,
                                 std::size_t samples,
                                 const Pass& pass,
                                 const UtcTime& epoch,
                                 const std::vector<Sentinel1GridPlace>& grid)
    : radar_(std::move(radar)),
      swath_(std::move(swath)),
      epoch_(epoch),
      raster_(*pass.image),
      path_(pass.path),
      wavelength_m_(pass.wavelength_m),
      side_(pass.side) {
  for (const Sentinel1GridPlace& point : grid) {
    const auto& [line_px, pixel_px] = point.place;
    if (heights_.empty() || heights_.back().line_px != line_px) heights_.push_back({line_px, {}});
    heights_.back().pixel_and_height.push_back({pixel_px, point.height_m});
  }
  if (raster_.presentation == Presentation::kSlant && samples > 0) {
    middle_s_ = kTwoWay_s_per_m * (raster_.near_range_m +
                                   0.5 * static_cast<double>(samples) * raster_.range_spacing_m);
  }
  std::string pulses = radar_.pulses_problem;
  if (pulses.empty()) pulses = CheckPulses(grid);
  const std::string middle = pulses.empty() ? FitMiddle(grid) : pulses;
  const std::string doppler = CheckDoppler(grid);
  const std::string motion = doppler.empty() ? pulses : doppler;
  std::string rate = doppler;
  if (rate.empty()) rate = radar_.fm_rate_problem;
  bistatic_ = middle.empty();
  pulse_motion_ = motion.empty();
  fm_rate_ = rate.empty();
  const auto append = [this](const char* what, const std::string& why) {
    if (why.empty()) return;
    left_out_ += fmt::format("{}{} ({})", left_out_.empty() ? "" : "; ", what, why);
  };
  append("the bistatic residual", middle);
  append("motion within the pulse", motion);
  append("the mismatch of the FM rate", rate);
}

// Estimates tau_mid, which is of the reference sub-swath, from the grid, whose times are rounded to
// a microsecond.
std::string Sentinel1Timing::FitMiddle(const std::vector<Sentinel1GridPlace>& grid) {
  if (!radar_.bistatic_corrected) return "bistaticDelayCorrectionApplied is false";
  std::vector<double> middles_s;
  for (const Sentinel1GridPlace& point : grid) {
    const auto raster = RadarFromImage(raster_, point.place);
    if (!raster) continue;
    const double late_s = point.radar.time_s - raster->time_s;
    middles_s.push_back(kTwoWay_s_per_m * point.radar.range_m - 2.0 * late_s);
  }
  const std::string contradiction =
      "times of the geolocation grid less those of the image do not grow by half the travel time";
  if (middles_s.empty()) return contradiction;
  reference_s_ = Median(middles_s);
  for (double& middle_s : middles_s) middle_s = std::abs(0.5 * (middle_s - reference_s_));
  constexpr double kRounding_s = 2e-6;
  return Median(std::move(middles_s)) < kRounding_s ? "" : contradiction;
}

std::string Sentinel1Timing::CheckPulses(const std::vector<Sentinel1GridPlace>& grid) const {
  if (!radar_.parts_problem.empty()) return radar_.parts_problem;
  for (const Sentinel1GridPlace& point : grid) {
    if (PulsesAt(point.place, point.radar.time_s) == nullptr) {
      return fmt::format(
          "downlinkInformationList has no pulses of the sub-swath of line {}, pixel {}",
          point.place.line_px,
          point.place.pixel_px);
    }
  }
  return {};
}

std::string Sentinel1Timing::CheckDoppler(const std::vector<Sentinel1GridPlace>& grid) const {
  if (!radar_.doppler_problem.empty()) return radar_.doppler_problem;
  const bool scans = radar_.steering_rad_per_s.value_or(0.0) != 0.0;
  if (raster_.presentation == Presentation::kGround && scans) {
    return "an image in ground range does not say when its bursts began";
  }
  if (!raster_.burst_start_s.empty()) {
    if (!radar_.steering_problem.empty()) return radar_.steering_problem;
    if (scans && !radar_.fm_rate_problem.empty()) return radar_.fm_rate_problem;
    if (scans && !(middle_s_ > 0.0)) return "numberOfSamples is missing";
  }
  constexpr double kMost_hz = 2e4, kAlike = 0.01;  // the relief of the Earth makes 0.001
  for (const Sentinel1GridPlace& point : grid) {
    const auto raster = RadarFromImage(raster_, point.place);
    if (!raster) continue;
    const Rates rates = RatesAt(point.place, *raster);
    if (!(std::abs(rates.doppler_hz) < kMost_hz)) {
      return fmt::format("dataDcPolynomial gives a Doppler of {:.4g} Hz", rates.doppler_hz);
    }
    const auto ground_m = GroundAt(point.place, *raster);
    if (radar_.fm_rate.empty() || !ground_m) continue;
    const double rate_hz_per_s = FmRateOf_hz_per_s(raster->time_s, *ground_m);
    if (!(std::abs(rates.fm_rate_hz_per_s / rate_hz_per_s - 1.0) < kAlike)) {
      return fmt::format("azimuthFmRatePolynomial gives {:.5g} Hz/s, orbit and ground {:.5g}",
                         rates.fm_rate_hz_per_s,
                         rate_hz_per_s);
    }
  }
  return {};
}

// The last ones of the sub-swath before the time, or its first ones.
const Sentinel1Pulses* Sentinel1Timing::PulsesAt(const ImageCoordinates& place,
                                                 double time_s) const {
  const std::string* swath = radar_.parts.empty() ? &swath_ : nullptr;
  for (const Sentinel1Part& part : radar_.parts) {
    const auto within = [](double value_px, const std::array<int, 2>& span) {
      return value_px >= span[0] - 0.5 && value_px <= span[1] + 0.5;
    };
    if (within(place.line_px, part.lines) && within(place.pixel_px, part.pixels)) {
      swath = &part.swath;
    }
  }
  if (swath == nullptr) return nullptr;
  const Sentinel1Pulses* found = nullptr;
  for (const Sentinel1Pulses& pulses : radar_.pulses) {
    if (pulses.swath != *swath) continue;
    if (found == nullptr || SecondsBetween(epoch_, pulses.from) <= time_s) found = &pulses;
  }
  return found;
}

Sentinel1Timing::Rates Sentinel1Timing::RatesAt(const ImageCoordinates& place,
                                                const RadarCoordinates& raster) const {
  const double two_way_s = kTwoWay_s_per_m * raster.range_m;
  const bool scans =
      radar_.steering_rad_per_s.value_or(0.0) != 0.0 && !raster_.burst_start_s.empty();
  double about_s = raster.time_s;  // of the polynomials
  if (scans) {
    const auto lines = static_cast<double>(raster_.lines_per_burst);
    const auto last = static_cast<double>(raster_.burst_start_s.size() - 1);
    const double burst = std::clamp(std::floor(place.line_px / lines), 0.0, last);
    about_s = raster_.burst_start_s[static_cast<std::size_t>(burst)] +
              0.5 * (lines - 1.0) * raster_.line_interval_s;
  }
  const UtcTime about = AddSeconds(epoch_, about_s);
  const Sentinel1Polynomial& centroid = Nearest(radar_.doppler, about);
  Rates rates{centroid.At(two_way_s), kNotGiven};
  if (radar_.fm_rate.empty()) return rates;
  const Sentinel1Polynomial& fm_rate = Nearest(radar_.fm_rate, about);
  rates.fm_rate_hz_per_s = fm_rate.At(two_way_s);
  const auto motion = path_.At(about_s);
  if (!scans || !motion) return rates;
  const double steered_hz_per_s =
      2.0 * motion->velocity_mps.norm() / wavelength_m_ * *radar_.steering_rad_per_s;
  const double k_a = rates.fm_rate_hz_per_s;
  const double k_t = k_a * steered_hz_per_s / (k_a - steered_hz_per_s);
  const double zero_s = centroid.At(middle_s_) / fm_rate.At(middle_s_) - rates.doppler_hz / k_a;
  rates.doppler_hz += k_t * (raster.time_s - about_s - zero_s);
  return rates;
}

Sentinel1Delay Sentinel1Timing::At(const ImageCoordinates& place,
                                   const RadarCoordinates& raster,
                                   const Eigen::Vector3d& p_m) const {
  Sentinel1Delay delay;
  const Sentinel1Pulses* const pulses =
      bistatic_ || pulse_motion_ ? PulsesAt(place, raster.time_s) : nullptr;
  if (bistatic_ && pulses != nullptr) {
    delay.bistatic_s =
        pulses->listening_s - 0.5 * (reference_s_ + kTwoWay_s_per_m * raster.range_m);
  }
  if (!pulse_motion_ && !fm_rate_) return delay;
  const Rates rates = RatesAt(place, raster);
  if (pulse_motion_ && pulses != nullptr) {
    delay.pulse_motion_m = -rates.doppler_hz / (pulses->chirp_rate_hz_per_s * kTwoWay_s_per_m);
  }
  if (fm_rate_) {
    delay.fm_rate_s = rates.doppler_hz *
                      (1.0 / FmRateOf_hz_per_s(raster.time_s, p_m) - 1.0 / rates.fm_rate_hz_per_s);
  }
  return delay;
}

// k_geo; infinite where the path does not cover the time.
double Sentinel1Timing::FmRateOf_hz_per_s(double time_s, const Eigen::Vector3d& p_m) const {
  const auto motion = path_.At(time_s);
  if (!motion) return -std::numeric_limits<double>::infinity();
  const Eigen::Vector3d from_point_m = motion->position_m - p_m;
  return -2.0 * (motion->velocity_mps.squaredNorm() + from_point_m.dot(motion->acceleration_mps2)) /
         (wavelength_m_ * from_point_m.norm());
}

std::optional<Eigen::Vector3d> Sentinel1Timing::GroundAt(const ImageCoordinates& place,
                                                         const RadarCoordinates& radar) const {
  if (heights_.empty()) return std::nullopt;
  return GroundOf(path_, side_, Frame::Geocentric(NamedEllipsoid("WGS84")), radar, HeightAt(place));
}

// Linear between the grid's rows and along them; beyond it that of its edge.
double Sentinel1Timing::HeightAt(const ImageCoordinates& place) const {
  const auto between = [](double x, double x0, double y0, double x1, double y1) {
    const double part = x1 > x0 ? std::clamp((x - x0) / (x1 - x0), 0.0, 1.0) : 0.0;
    return y0 + part * (y1 - y0);
  };
  const auto along = [&](const HeightRow& row) {
    const auto& all = row.pixel_and_height;
    const auto after = std::lower_bound(
        all.begin(), all.end(), place.pixel_px, [](const auto& entry, double pixel_px) {
          return entry[0] < pixel_px;
        });
    if (after == all.begin()) return all.front()[1];
    if (after == all.end()) return all.back()[1];
    const auto& before = *(after - 1);
    return between(place.pixel_px, before[0], before[1], (*after)[0], (*after)[1]);
  };
  const auto after = std::lower_bound(
      heights_.begin(), heights_.end(), place.line_px, [](const HeightRow& row, double line_px) {
        return row.line_px < line_px;
      });
  if (after == heights_.begin()) return along(heights_.front());
  if (after == heights_.end()) return along(heights_.back());
  const HeightRow& before = *(after - 1);
  return between(place.line_px, before.line_px, along(before), after->line_px, along(*after));
}

}  // namespace sarblock
