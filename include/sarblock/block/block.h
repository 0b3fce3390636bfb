// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/image_grid.h"
#include "sarblock/core/error.h"
#include "sarblock/core/id_table.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/geometry/look_equations.h"
#include "sarblock/geometry/path.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// What the recording of a flight does to the points of a pass: errors of its path along track at
/// the target, root mean square over the strip at the largest range, beside the standard deviation
/// of azimuth. An error of the velocity across the flight turns the Doppler cone: dv R/|v|.
/// docs/theory/flight_path.md#recorded-flights.
struct RecordingEffect {
  PathThrough through = PathThrough::kStates;  ///< how the path was made; not kAuto
  double noise_m = 0.0;                        ///< by noise of the states
  double contradiction_m = 0.0;  ///< by velocities that are not those of the positions
  double interpolation_m = 0.0;  ///< by what the path between states cannot follow
  /// Mean of the looks; NaN where no look gives a range and one.
  double azimuth_sigma_m = std::numeric_limits<double>::quiet_NaN();
  StateNoise noise{0.0, 0.0};      ///< of the states, as given or estimated
  std::optional<FitOfStates> fit;  ///< of a smoothed path
  std::string why;                 ///< kAuto: which way was taken and why; else empty

  [[nodiscard]] double Total_m() const {
    return std::hypot(noise_m, contradiction_m, interpolation_m);
  }
  /// True from a tenth of sigma on, which is warned of: such an error adds 0.5 % to the sigma of
  /// one look, but looks near each other share it.
  [[nodiscard]] bool Matters() const { return Total_m() > 0.1 * azimuth_sigma_m; }
};

/// How the flight of a pass was recorded, and in which way its path is made of that: by
/// ReadBlock(), or for a block in memory by MakePaths() (adjust/adjust.h).
struct RecordedFlight {
  TrajectoryOptions asked;
  std::vector<StateVector> states;  ///< as recorded; empty: the states of the path
  RecordingEffect effect;
};

/// "Not given" in a column of doubles.
inline constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();

/// Side of the flight direction the antenna looks to; left is +across.
enum class LookSide : std::int8_t { kLeft = +1, kRight = -1 };

/// Unit of the standard deviation of the azimuth measurement: metres at the target or seconds of a
/// measured time, or hertz of a measured Doppler, whose time then is exact.
enum class AzimuthUnit : std::uint8_t { kMetres, kSeconds, kHertz };
struct LookSigma {
  double range_m = kNotGiven;
  double azimuth = kNotGiven;  ///< [m], [s] or [Hz], see azimuth_unit
  AzimuthUnit azimuth_unit = AzimuthUnit::kMetres;
};

/// Quantity that bounds the swath beside the track: a pass sees positions for which it lies between
/// near and far. d = p - s, in the track axes of the flight path at the time of the look.
enum class SwathKind : std::uint8_t {
  kLookAngle,    ///< atan2(|d.across|, -d.up) off nadir [rad]
  kGroundRange,  ///< |d.across| [m], Leberl's y
  kSlantRange,   ///< |d| [m]
};
struct Swath {
  SwathKind kind = SwathKind::kLookAngle;
  std::array<double, 2> limits{};  ///< near, far [rad] or [m]; 0 <= near < far, angles below pi/2
};

/// How files name a swath, in the order of SwathKind.
struct SwathKey {
  const char* key;
  double factor;  ///< from the two numbers of a file to radians or metres
};
inline constexpr std::array<SwathKey, 3> kSwathKeys = {
    {{"swath_look_deg", kRadPerDeg}, {"swath_ground_m", 1.0}, {"swath_range_m", 1.0}}};

/// What is wrong with a swath ("must be near and far, 0 <= near < far, got 5 and 3"), in the unit
/// of its key. Nothing where it is good.
[[nodiscard]] std::optional<std::string> ProblemOf(const Swath& swath);

/// How the delay of the troposphere is modelled (docs/theory/reductions.md).
enum class TroposphereModel : std::uint8_t {
  kNone,
  kStandard,  ///< the mean of the Earth's atmosphere
  kWeather,   ///< after Saastamoinen, from the weather that is given
};
/// Weather at a height above the ellipsoid.
struct Weather {
  double pressure_hpa = 0.0;
  double temperature_k = 0.0;
  double humidity = 0.0;  ///< relative, 0 to 1
  double height_m = 0.0;
  friend bool operator==(const Weather&, const Weather&) = default;
};
/// Free electrons above a place.
struct Ionosphere {
  double tec_tecu = 0.0;  ///< vertical, 1e16 electrons a square metre
  double share = 1.0;     ///< of them below the antenna
  friend bool operator==(const Ionosphere&, const Ionosphere&) = default;
};

/// Delays in the measured ranges and times of a pass that are to be subtracted, as models that
/// depend on the position of the point, and as constants.
struct ReductionModels {
  TroposphereModel troposphere = TroposphereModel::kNone;
  Weather weather;  ///< of kWeather
  std::optional<Ionosphere> ionosphere;
  /// Positions are free of the solid Earth tide, which moved the points when they were seen.
  bool solid_tide = false;
  double range_m = 0.0;  ///< measured range less geometric range
  double time_s = 0.0;   ///< measured time less geometric time
  friend bool operator==(const ReductionModels&, const ReductionModels&) = default;
};

/// One image strip with one flight path.
struct Pass {
  std::string id;
  LookSide side = LookSide::kLeft;
  double wavelength_m = kNotGiven;  ///< needed for Doppler input only
  FlightPath path;
  LookSigma sigma;                 ///< of looks that give none; [sigma] already applied
  double start_s = 0.0;            ///< strip-normalised time -1 (model.md, section 3)
  double end_s = 0.0;              ///< strip-normalised time +1; start_s < end_s
  std::string epoch_utc;           ///< time of time_s = 0, for people ("2022-10-16T01:50:44Z")
  std::optional<ImageGrid> image;  ///< the raster, for looks given by line and pixel
  RecordedFlight recorded;         ///< how `path` was made of its states
  std::optional<Swath> swath;      ///< not given: all that lies on the look side
  double squint_rad = 0.0;    ///< of looks that give no cone, and of looks planned by Predict()
  ReductionModels reduction;  ///< of its looks, beside what these give themselves

  /// The states as they were recorded.
  [[nodiscard]] const std::vector<StateVector>& RecordedStates() const {
    return recorded.states.empty() ? path.states() : recorded.states;
  }
};

/// All looks of a block in flat arrays, sorted by point and, within a point, by pass index.
/// Looks of point j are the indices offsets[j] .. offsets[j+1]-1. A column that no look uses is
/// empty; NaN in a used one means "not given".
struct Looks {
  enum Flag : std::uint8_t {
    kRejected = 1,        ///< kept in the file, left out of the adjustment
    kDoppler = 2,         ///< `cone` is a Doppler centroid [Hz], else a squint angle [rad]
    kAzimuthSeconds = 4,  ///< `azimuth_sigma` is in seconds, else in metres at the target
    kAzimuthHertz = 8,    ///< `azimuth_sigma` is in hertz: the Doppler is measured, the time exact
  };
  std::vector<std::uint64_t> offsets{0};  ///< points + 1
  std::vector<std::uint32_t> pass;        ///< index into Block::passes
  std::vector<std::uint8_t> flags;        ///< Flag bits
  std::vector<double> time_s;             ///< azimuth time
  std::vector<double> range_m;            ///< one-way slant range, > 0
  std::vector<double> cone;               ///< squint [rad] or Doppler [Hz]; empty: all 0
  std::vector<double> range_sigma_m;      ///< empty or NaN: the pass's
  std::vector<double> azimuth_sigma;      ///< empty or NaN: the pass's
  /// Delays that were subtracted from the measured values; `range_m` and `time_s` no longer contain
  /// them. Empty: nothing.
  std::vector<double> range_delay_m;
  std::vector<double> time_shift_s;

  [[nodiscard]] std::size_t size() const { return pass.size(); }
  [[nodiscard]] bool rejected(std::size_t look) const { return (flags[look] & kRejected) != 0; }
  /// The point of a look below size(), found by bisection.
  [[nodiscard]] std::size_t PointOf(std::size_t look) const;

  /// Calls visit(name, column) for each column but `offsets`, as a pointer to member, and
  /// visit(name, column, standard) where it may be empty: all looks then have that value.
  template <typename Visit>
  static void ForColumns(const Visit& visit) {
    visit("looks.pass", &Looks::pass);
    visit("looks.flags", &Looks::flags);
    visit("looks.time_s", &Looks::time_s);
    visit("looks.range_m", &Looks::range_m);
    visit("looks.cone", &Looks::cone, 0.0);
    visit("looks.range_sigma_m", &Looks::range_sigma_m, kNotGiven);
    visit("looks.azimuth_sigma", &Looks::azimuth_sigma, kNotGiven);
    visit("looks.range_delay_m", &Looks::range_delay_m, 0.0);
    visit("looks.time_shift_s", &Looks::time_shift_s, 0.0);
  }
};

enum class PointRole : std::uint8_t { kTie, kControl, kCheck };

/// Known position of a point with its uncertainty, for control and check points.
struct KnownPosition {
  std::uint32_t point = 0;
  std::array<bool, 3> fixed{};                                  ///< e, n, u
  Eigen::Matrix3d covariance_enu_m2 = Eigen::Matrix3d::Zero();  ///< rows of free components are 0
  /// Motion in the frame, its axes; the given position is that at Block::epoch_year.
  Eigen::Vector3d velocity_mpy = Eigen::Vector3d::Zero();
};

/// Points of a block; index = order of first appearance (points.csv, then observations.csv).
struct Points {
  IdTable ids;
  std::vector<PointRole> role;
  std::vector<Eigen::Vector3d> given_m;  ///< frame axes; NaN where the files give none.
                                         ///< Tie: a start value and nothing more.
  std::vector<KnownPosition> known;      ///< of control and check points, sorted by point
  [[nodiscard]] std::size_t size() const { return role.size(); }
  /// Entry of `known` for a point, or null.
  [[nodiscard]] const KnownPosition* FindKnown(std::uint32_t point) const;
};

/// True positions of a simulated block; empty for real data. Never read by the adjustment.
struct Truth {
  std::vector<Eigen::Vector3d> points_m;  ///< by point index; NaN where unknown
  std::vector<FlightPath> paths;          ///< by pass index; states at the nominal times
};

/// Radar images of one area as plain data: what a block folder holds, units SI and radians.
struct Block {
  std::string name;
  Frame frame = Frame::Local();
  std::string realization;        ///< of the frame ("ITRF2014"); empty: not known
  double epoch_year = kNotGiven;  ///< of positions in it (2022.79); NaN: not known
  std::vector<Pass> passes;
  Points points;
  Looks looks;

  /// Time and range of a look as they were measured, nothing subtracted.
  [[nodiscard]] RadarCoordinates Measured(std::size_t look) const {
    RadarCoordinates measured{looks.time_s[look], looks.range_m[look]};
    if (!looks.time_shift_s.empty()) measured.time_s += looks.time_shift_s[look];
    if (!looks.range_delay_m.empty()) measured.range_m += looks.range_delay_m[look];
    return measured;
  }

  /// Standard deviations of a look: its own where given, else its pass's.
  [[nodiscard]] LookSigma SigmaOf(std::size_t look) const;

  /// The cone of a look: its squint, or its Doppler with the wavelength of its pass.
  [[nodiscard]] Cone ConeOf(std::size_t look) const {
    Cone cone;
    if (looks.cone.empty()) return cone;
    if ((looks.flags[look] & Looks::kDoppler) != 0) {
      cone.kind = Cone::Kind::kDoppler;
      cone.closing_mps = 0.5 * passes[looks.pass[look]].wavelength_m * looks.cone[look];
    } else {
      cone.squint_rad = looks.cone[look];
    }
    return cone;
  }

  /// Whether the azimuth measurement of a look is its Doppler, at an exact time: its standard
  /// deviation is in hertz. Else it is the time.
  [[nodiscard]] bool MeasuresDoppler(std::size_t look) const {
    if ((looks.flags[look] & Looks::kDoppler) == 0) return false;
    return looks.azimuth_sigma.empty() || std::isnan(looks.azimuth_sigma[look])
               ? passes[looks.pass[look]].sigma.azimuth_unit == AzimuthUnit::kHertz
               : (looks.flags[look] & Looks::kAzimuthHertz) != 0;
  }

  /// Metres at the target per unit of the azimuth measurement, for an antenna of this speed: |v|
  /// per second, lambda R/(2 |v|) per hertz. For a time, the turn of the flight and the squint are
  /// neglected: a tenth from an orbit.
  [[nodiscard]] double ApproximateAzimuthUnit_m(std::size_t look, double speed_mps) const;
  /// Standard deviation of azimuth in metres at the target, to the same approximation.
  [[nodiscard]] double ApproximateAzimuthSigma_m(std::size_t look, double speed_mps) const;
};

/// Throws InputError naming array, index, what must be and what was got (`looks.pass[5]: must be
/// below 3, the number of passes, got 99`) unless a block filled by hand is what this page says:
///   - passes with ids of their own, a flight path, a side, a span that ends after it starts, a
///     swath (if any) whose far limit is beyond its near one, and a squint below pi/2;
///   - arrays of one length; offsets from 0 to the number of looks that never descend; at most one
///     look of a pass at each point that is not rejected; known flags;
///   - looks with ranges above 0, squints below pi/2, Dopplers with the wavelength of their pass,
///     standard deviations above 0 in a unit that the look can have. Of rejected looks only the
///     arrays are looked at. A time or range of NaN is a planned look's, which Adjust() refuses;
///   - known positions sorted by point, once each, finite, of control or check points, with a
///     covariance: positive definite for control, not negative for check points. Every control
///     point has one.
/// A time outside the path and contradictions with the ground are not errors of form: Adjust()
/// leaves such looks out with a warning, or refuses the block. Linear in looks and points, reads
/// only. Adjust(), Predict(), IntersectBlock() and CheckBlock() begin with it.
void Validate(const Block& block);

/// Sorts looks of any order by point (and pass) into `Looks` order.
/// `point_of_look` gives the point of each look; `looks.offsets` is made. Linear time. Returns the
/// permutation, new position i has old look result[i]; empty if they were in this order.
std::vector<std::uint32_t> SortLooksByPoint(const std::vector<std::uint32_t>& point_of_look,
                                            std::size_t point_count,
                                            Looks* looks);

/// Strip span of each pass: the first and last look, rejected ones included (model.md, section
/// 3). A pass without looks gets its path's span; one whose looks share one time gets 1 s around.
/// `fixed[i]`, where given, is the pass's own start and end and wins.
void SetStripSpans(const std::vector<std::optional<std::array<double, 2>>>& fixed_s, Block* block);

}  // namespace sarblock
