// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/image_grid.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "image.h"
#include "isis.h"
#include "tables/json.h"
#include <Eigen/Core>

namespace sarblock {

/// Numbers of JSON files; each refuses what is not finite, with file and key.
[[nodiscard]] double FiniteNumber(const JsonValue& value);
[[nodiscard]] double PositiveNumber(const JsonValue& value);
[[nodiscard]] std::vector<double> FiniteNumbers(const JsonValue& list);
/// Refuses a list of another length.
[[nodiscard]] std::vector<double> FiniteNumbers(const JsonValue& list, std::size_t count);
/// Three numbers.
[[nodiscard]] Eigen::Vector3d FiniteVector(const JsonValue& list);
/// An integer of 1 or more.
[[nodiscard]] std::uint64_t CountOfOne(const JsonValue& value);

/// The times of the states in a model state of USGSCSM, evenly spaced.
struct CsmStateTimes {
  double first_s = 0.0;  ///< ephemeris time, m_t0Ephem
  double step_s = 0.0;   ///< m_dtEphem
  std::size_t count = 0;
  [[nodiscard]] double At(std::size_t k) const { return first_s + static_cast<double>(k) * step_s; }
};

/// Content of an ISD or a model state of USGSCSM's SAR model, as far as a model state needs it.
struct CsmModel {
  RadarImage image;
  /// Times of the states: a model state's own; for an ISD those of its states, evenly spaced as
  /// USGSCSM makes them, closer where they are more than kLongestStep_s apart, and kBeyond more at
  /// both ends: USGSCSM interpolates with eight states only where four are on both sides, linearly
  /// at the ends.
  CsmStateTimes times;
  double centre_s = 0.0, end_s = 0.0;  ///< ephemeris times of the image
  double least_height_m = 0.0, most_height_m = 0.0;
  std::string image_id, sensor, platform;
  std::vector<double> sun_position_m, sun_velocity_mps;  ///< body-fixed, empty where not given
  Eigen::Vector3d reference_m = Eigen::Vector3d::Zero();

  static constexpr double kLongestStep_s = 0.5;
  static constexpr std::size_t kBeyond = 4;
};

/// The text of an ISD or a model state, 256 MiB at most; throws InputError with the file.
[[nodiscard]] std::string ReadCsmText(const std::string& file);
/// Reads an ISD or a model state, known by how it begins. Throws InputError with file and key.
[[nodiscard]] CsmModel ReadCsmModel(const std::string& file);
[[nodiscard]] CsmModel ParseCsmModel(std::string_view text, const std::string& file);

/// The same of a model state alone: the name of the model, a new line, JSON. Positions take their
/// parameters (m_currentParameterValue); parameters of the velocity, and velocities that contradict
/// the motion of the positions, turn the Doppler cone without moving the path and are refused.
[[nodiscard]] CsmModel ParseCsmState(std::string_view text, const std::string& file);
/// Whether a text begins as a model state.
[[nodiscard]] bool IsCsmState(std::string_view text);

/// What an adjustment made of a model.
struct AdjustedCsmModel {
  double time_shift_s = 0.0;  ///< added to the times of the image and of its polynomials
  std::vector<GroundRangePolynomial> ground_range;  ///< times of the image before the shift
  std::vector<StateVector> states;                  ///< at CsmModel::times
  Eigen::Vector3d reference_m = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Identity();
};

/// The text of a model state, which says that this program wrote it; numbers read back to the same
/// double. The six parameters are zero: all of the adjustment is in states, times and polynomials.
[[nodiscard]] std::string CsmStateText(const CsmModel& model, const AdjustedCsmModel& adjusted);

/// Name of the one model of USGSCSM that is read.
inline constexpr const char* kCsmModelName = "USGS_ASTRO_SAR_SENSOR_MODEL";

/// The parts of an ISD, for code that reads more of it than its image; they throw InputError as
/// ReadCsmIsd().
[[nodiscard]] InertialOrbit IsdOrbit(const JsonValue& root, const std::string& file);
[[nodiscard]] RadarImage IsdImage(const JsonValue& root, const std::string& file);
/// Refuses another name of a model.
void RequireCsmModel(const JsonValue& name);

/// Reads the image support data of USGSCSM's SAR model, JSON as ALE (isd_generate) writes it, or a
/// model state (*.adjusted_state.json), 256 MiB at most. Throws InputError with file and key for
/// what is missing or makes no sense. docs/import_csm.md.
[[nodiscard]] RadarImage ReadCsmIsd(const std::string& file);
/// The same of a text in memory; `file` is for messages.
[[nodiscard]] RadarImage ParseCsmIsd(std::string_view text, const std::string& file);

/// Polynomials at close times; linear interpolation between them gives what USGSCSM computes from
/// the given ones between `start_s` and `end_s`. USGSCSM spaces N polynomials by `span / N` from
/// the time of the first one and interpolates their coefficients with Lagrange's polynomial of up
/// to eight (usgscsm/src/UsgsAstroSarSensorModel.cpp, getRangeCoefficients; Utilities.cpp,
/// lagrangeInterp). 32 polynomials per interval: within 1 mm of it for coefficients as uneven as
/// those of LRO.
[[nodiscard]] std::vector<GroundRangePolynomial> AsUsgscsmReads(
    const std::vector<GroundRangePolynomial>& given, double start_s, double end_s);

/// The row at `place`, counted in rows from the first one, as USGSCSM interpolates in a table of
/// evenly spaced rows: Lagrange's polynomial of up to eight. Two rows or more, equally long.
[[nodiscard]] std::vector<double> AsUsgscsmInterpolates(
    const std::vector<std::vector<double>>& rows, double place);

/// The reverse of AsUsgscsmReads(): polynomials from which USGSCSM computes, between `start_s` and
/// `end_s`, the given ones at their own times, linear in between; a reader that uses them at their
/// own times gets the same. They are close together, four beyond both ends.
[[nodiscard]] std::vector<GroundRangePolynomial> ForUsgscsm(
    const std::vector<GroundRangePolynomial>& given, double start_s, double end_s);

}  // namespace sarblock
