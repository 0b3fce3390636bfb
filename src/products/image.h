// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/block/image_grid.h"
#include "sarblock/geometry/frame.h"
#include "sarblock/geometry/look_equations.h"
#include "sarblock/geometry/path.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/utc.h"
#include <Eigen/Core>

namespace sarblock {

class XmlElement;

/// Two-way time to one-way range.
inline constexpr double kRangePerTime_mps = 0.5 * kSpeedOfLight_mps;

/// The time of an id: 20221016T015044.
[[nodiscard]] std::string CompactTime(const UtcTime& time);

/// One state vector as a product or an orbit file gives it: earth-fixed axes, velocities relative
/// to the turning Earth.
struct OrbitState {
  UtcTime time;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
};

/// What is wrong with a state that follows another one (null: the first), as the rest of a sentence
/// that begins with its place: times that do not increase and states that no satellite has. Nothing
/// where it is good.
[[nodiscard]] std::optional<std::string> ProblemOfState(const OrbitState* before,
                                                        const OrbitState& state);

/// States with times from `epoch`.
[[nodiscard]] std::vector<StateVector> StatesFrom(const std::vector<OrbitState>& states,
                                                  const UtcTime& epoch);

/// The path through the states of an orbit, with a state every `step_s` (0: as given). States more
/// than five minutes apart are refused; velocities that contradict the motion of the positions are
/// a warning, and a path that is off by more than 0.1 m along track between the states around
/// `image_s`. `file` is for messages.
[[nodiscard]] FlightPath PathThroughOrbit(const std::string& file,
                                          const std::vector<StateVector>& states,
                                          const TimeSpan& image_s,
                                          double step_s,
                                          OrbitThrough through,
                                          std::vector<std::string>* warnings);

/// The states of the children of `list` called `name`, each read by `read`. Refuses, by their
/// lines, states that make no path: ProblemOfState(), states too close to each other, fewer than
/// two.
[[nodiscard]] std::vector<OrbitState> ReadStates(
    const XmlElement& list,
    const char* name,
    const std::function<OrbitState(const XmlElement&)>& read);
/// The numbers of three children.
[[nodiscard]] Eigen::Vector3d ReadVector(const XmlElement& element,
                                         const char* x,
                                         const char* y,
                                         const char* z);
/// The states of children that have a time called `time` and posX to velZ.
[[nodiscard]] std::vector<OrbitState> ReadFlatStates(const XmlElement& list,
                                                     const char* name,
                                                     const char* time);
/// Which of the two texts it is; refuses others.
[[nodiscard]] LookSide ReadSide(const XmlElement& element,
                                const std::string& left,
                                const std::string& right);

/// Ground range polynomial of a product, see GroundRangePolynomial.
struct ProductGroundRange {
  UtcTime time;
  double origin_m = 0.0;             ///< gr0
  std::vector<double> coefficients;  ///< grsrCoefficients, m^(1-k)
};

/// A zero-Doppler image as a product gives it, with its orbit.
struct ZeroDopplerImage {
  std::string file;
  LookSide side = LookSide::kLeft;
  double wavelength_m = 0.0;
  std::size_t lines = 0, samples = 0;
  UtcTime first_line, last_line;  ///< zero-Doppler times of the centres of lines
  double line_interval_s = 0.0;
  double near_range_m = 0.0;  ///< one way, of the centre of the first sample; ground range: often 0
  double range_spacing_m = 0.0;
  std::vector<ProductGroundRange> ground_range;  ///< empty: in slant range
  std::vector<OrbitState> orbit;                 ///< two or more, times increasing
};
/// Where a zero-Doppler look meets the height; nothing where it does not or its time is outside the
/// path.
[[nodiscard]] std::optional<Eigen::Vector3d> GroundOf(const FlightPath& path,
                                                      LookSide side,
                                                      const Frame& frame,
                                                      const RadarCoordinates& radar,
                                                      double height_m);

/// What is wrong with a grid point.
enum class GridFault {
  kPosition,  ///< time and position contradict each other: its look is rejected
  kHeight,    ///< fits once the height changes: latitude and longitude belong to another height
};

/// The faulty points of one kind in one row of a geolocation grid.
struct FaultyRow {
  std::string file;
  std::size_t file_line = 0;  ///< of the first faulty point's element; 0: the file has no lines
  GridFault fault = GridFault::kPosition;
  int line = 0;             ///< image line of the row
  std::size_t row = 0;      ///< from 1
  bool same_time = false;   ///< the row's time is that of the row before
  bool used = true;         ///< the grid's points become points of the block
  std::size_t points = 0;   ///< faulty ones
  std::size_t of = 0;       ///< all in the row
  double along_m[2] = {};   ///< smallest and largest e_d
  double range_m[2] = {};   ///< smallest and largest e_r
  double height_m[2] = {};  ///< kHeight: smallest and largest change that makes the range fit
};
/// `FILE:LINE: geolocationGrid line 13652 (row 10): ...`, one line of text.
[[nodiscard]] std::string Describe(const FaultyRow& row);

/// One place of a geolocation grid, with the time and range at which it is seen.
struct GridPoint {
  double time_s = 0.0;
  double range_m = 0.0;
  Geodetic place;
  Cone cone{};  ///< zero Doppler, or the Doppler measured at the time
};

/// How one grid point fits the orbit.
struct GridFit {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< as the product gives it
  double range_error_m = 0.0;                            ///< e_r
  double along_error_m = 0.0;                            ///< e_d
  double height_change_m = 0.0;    ///< what makes e_r vanish; 0 unless the fault is kHeight
  std::optional<GridFault> fault;  ///< none: good
  LookSide side = LookSide::kRight;
};

/// Fit of a grid point; nothing where its time is outside the path.
[[nodiscard]] std::optional<GridFit> FitGridPoint(const GridPoint& point,
                                                  const Frame& frame,
                                                  const FlightPath& path,
                                                  double max_misfit_m);

/// Collects the faulty points of a grid by row and fault, rows in the order in which they come.
class FaultyRows {
 public:
  explicit FaultyRows(std::string file) : file_(std::move(file)) {}
  /// A new row at an image line; `same_time` says that its time is that of the row before.
  void Begin(int line, bool same_time);
  /// The next point of the row; `file_line` is the line of its element, 0 where there is none.
  void Add(const GridFit& fit, std::size_t file_line);
  [[nodiscard]] std::vector<FaultyRow> Take();

 private:
  void End();
  std::string file_;
  std::vector<FaultyRow> rows_;
  std::vector<FaultyRow> current_;  // one a fault
  std::size_t count_ = 0;           // of rows
  std::size_t points_ = 0;          // of the current row
};

/// Standard deviations that ISIS jigsaw gives the measures of a Mini-RF image, from the resolutions
/// in its label and 1.4 pixels.
struct JigsawSigma {
  double range_m = 0.0;
  double doppler_hz = 0.0;  ///< of the Doppler shift, its second measurement
};

/// A radar image in ground range as a cube of ISIS or an ISD describes it: zero-Doppler, times in
/// ephemeris time (TDB, seconds past J2000), flight path in body-fixed axes.
struct RadarImage {
  std::string file;
  std::string serial;  ///< serial number of ISIS; empty where the file has none (ISD)
  std::string target;  ///< name of the body as given; empty where the file has none (ISD)
  Ellipsoid ellipsoid;
  LookSide side = LookSide::kRight;
  double wavelength_m = 0.0;
  std::uint64_t lines = 0, samples = 0;
  double first_line_s = 0.0;  ///< ephemeris time of the centre of the first line
  double line_interval_s = 0.0;
  double first_sample_m = 0.0;    ///< ground range of the centre of the first sample
  double sample_spacing_m = 0.0;  ///< in ground range
  std::vector<GroundRangePolynomial> ground_range;  ///< with ephemeris times
  std::vector<StateVector> states;                  ///< with ephemeris times
  std::optional<JigsawSigma> jigsaw;
};

/// The spacing of the states of paths, unless they are given closer: the cubic through states 5 s
/// apart leaves a lunar orbit by less than 0.1 mm.
inline constexpr double kImageStateStep_s = 5.0;

}  // namespace sarblock
