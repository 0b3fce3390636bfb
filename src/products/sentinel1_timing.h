// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/block/image_grid.h"
#include "sarblock/geometry/path.h"

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/utc.h"
#include "xml.h"
#include <Eigen/Core>

namespace sarblock {

/// Pulses of one sub-swath from a time on (`downlinkInformation`).
struct Sentinel1Pulses {
  std::string swath;
  UtcTime from;
  double listening_s = 0.0;          ///< rank times PRI: from a pulse to the window of its echo
  double chirp_rate_hz_per_s = 0.0;  ///< K_r; negative: frequencies fall
};

/// A Doppler [Hz] or a Doppler rate [Hz/s] as a polynomial of the two-way time less `origin_s`,
/// about an azimuth time.
struct Sentinel1Polynomial {
  UtcTime time;
  double origin_s = 0.0;
  std::vector<double> coefficients;  ///< one or more, by rising powers of seconds

  [[nodiscard]] double At(double two_way_s) const;
};

/// First and last line and pixel of one sub-swath in an image of merged sub-swaths.
struct Sentinel1Part {
  std::string swath;
  std::array<int, 2> lines{}, pixels{};
};

/// One pixel of the geolocation grid.
struct Sentinel1GridPlace {
  ImageCoordinates place;
  RadarCoordinates radar;  ///< the grid's own, time from the pass's epoch
  double height_m = 0.0;
};

/// Pulses of an annotation, and the parameters with which its Dopplers were focused. All are
/// optional: a list is empty where the file has none or an invalid one, and its `problem` says
/// which.
struct Sentinel1Radar {
  bool bistatic_corrected = true;  ///< bistaticDelayCorrectionApplied; left out: true
  std::optional<double> steering_rad_per_s;
  std::vector<Sentinel1Pulses> pulses;
  std::vector<Sentinel1Polynomial> doppler;  ///< centroid: dataDcPolynomial
  std::vector<Sentinel1Polynomial> fm_rate;
  std::vector<Sentinel1Part> parts;  ///< of merged images, else empty
  std::string steering_problem, pulses_problem, doppler_problem, fm_rate_problem, parts_problem;
};

/// Reads it; `root` is the element `product`.
[[nodiscard]] Sentinel1Radar ReadSentinel1Radar(const XmlElement& root);

/// Delays in time and range of a place: measured minus geometric.
struct Sentinel1Delay {
  double bistatic_s = 0.0;      ///< the whole residual
  double fm_rate_s = 0.0;       ///< by focusing with the rate of another height
  double pulse_motion_m = 0.0;  ///< by motion of the antenna within the pulse

  [[nodiscard]] double Time_s() const { return bistatic_s + fm_rate_s; }
};

/// Delays of a Sentinel-1 image by place (docs/import.md#what-its-times-and-ranges-hold):
///
///     bistatic      -(tau_mid/2 + tau/2 - rank PRI)
///     pulse motion  -f c / (2 K_r)
///     FM rate       f (1/k_geo - 1/k_a),   k_geo = -2 (|v|^2 + (s - p).a) / (lambda |s - p|)
///
/// with the two-way time tau of the place and f the Doppler at which it was seen: that of the
/// centroid polynomial, in bursts plus k_t (t - t_burst - t_ref), k_t = k_a k_s / (k_a - k_s), k_s
/// = 2 |v| / lambda times the steering rate, t_ref = f_dc/k_a in the middle of the swath less that
/// of the place. tau_mid is that of the reference sub-swath: the geolocation grid has the part of
/// the bistatic residual that is linear in range, grid time less raster time = (tau - tau_mid)/2.
/// Sources: Gisinger et al. (2021), IEEE TGRS 59, 1126 (whole residual, FM rate); Piantanida et al.
/// (2018), EUSAR (motion within the pulse); Miranda (2017), COPE-GSEG-EOPG-TN-14-0025 (f).
class Sentinel1Timing {
 public:
  /// `pass` has the raster and the path, with times from `epoch`; `samples` of the image, 0: not
  /// known; `grid` by line, then pixel. Delays that the annotation does not determine are 0,
  /// left_out() says which and why.
  Sentinel1Timing(Sentinel1Radar radar,
                  std::string swath,
                  std::size_t samples,
                  const Pass& pass,
                  const UtcTime& epoch,
                  const std::vector<Sentinel1GridPlace>& grid);

  [[nodiscard]] bool HasBistatic() const { return bistatic_; }
  [[nodiscard]] bool HasFmRate() const { return fm_rate_; }
  [[nodiscard]] bool HasPulseMotion() const { return pulse_motion_; }
  /// "the bistatic residual (no downlinkInformationList); ..."; empty: nothing is left out.
  [[nodiscard]] const std::string& left_out() const { return left_out_; }

  /// Delays at a place with the raster's time and range for a point at p_m (the block's frame,
  /// geocentric).
  [[nodiscard]] Sentinel1Delay At(const ImageCoordinates& place,
                                  const RadarCoordinates& raster,
                                  const Eigen::Vector3d& p_m) const;

  /// Where the ground is that a place with this time and range shows, at the height that the
  /// geolocation grid has about there; nothing where the look does not meet it.
  [[nodiscard]] std::optional<Eigen::Vector3d> GroundAt(const ImageCoordinates& place,
                                                        const RadarCoordinates& radar) const;

 private:
  struct Rates;
  [[nodiscard]] std::string FitMiddle(const std::vector<Sentinel1GridPlace>& grid);
  [[nodiscard]] std::string CheckPulses(const std::vector<Sentinel1GridPlace>& grid) const;
  [[nodiscard]] std::string CheckDoppler(const std::vector<Sentinel1GridPlace>& grid) const;
  [[nodiscard]] const Sentinel1Pulses* PulsesAt(const ImageCoordinates& place, double time_s) const;
  [[nodiscard]] Rates RatesAt(const ImageCoordinates& place, const RadarCoordinates& raster) const;
  [[nodiscard]] double FmRateOf_hz_per_s(double time_s, const Eigen::Vector3d& p_m) const;
  [[nodiscard]] double HeightAt(const ImageCoordinates& place) const;

  Sentinel1Radar radar_;
  std::string swath_;
  UtcTime epoch_;
  ImageGrid raster_;
  FlightPath path_;
  double wavelength_m_ = 0.0;
  LookSide side_ = LookSide::kRight;
  double reference_s_ = 0.0;  ///< tau_mid
  double middle_s_ = 0.0;     ///< two-way time in the middle of the image's own swath
  bool bistatic_ = false, pulse_motion_ = false, fm_rate_ = false;
  std::string left_out_;
  struct HeightRow {
    double line_px = 0.0;
    std::vector<std::array<double, 2>> pixel_and_height;  ///< pixels increasing
  };
  std::vector<HeightRow> heights_;  ///< lines increasing
};

}  // namespace sarblock
