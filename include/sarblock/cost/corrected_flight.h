// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/options.h"

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace sarblock {

/// What one look measured. Standard deviations are constants: they do not move with the point.
struct LookMeasurement {
  double time_s = kNotGiven;            ///< azimuth time, as the flight path counts it
  double range_m = kNotGiven;           ///< one-way slant range
  Cone cone;                            ///< zero Doppler unless set
  double range_sigma_m = kNotGiven;     ///< of the range
  double time_sigma_s = kNotGiven;      ///< of the time; or:
  double doppler_sigma_hz = kNotGiven;  ///< of a measured Doppler (cone.kind kDoppler): the time is
                                        ///< then exact
  double wavelength_m = kNotGiven;      ///< with doppler_sigma_hz
};

/// One correction of a flight. Its priors are not part of the cost of a look (PriorCost).
struct FlightCorrection {
  Correction model;
  /// Knots of a spline; not given: the strip. Flights that share a spline need the same.
  std::optional<TimeSpan> knots_s = {};
};

/// How a flight path is read.
struct FlightOptions {
  /// Polynomials run from -1 to 1 over the strip; first_s < last_s.
  TimeSpan strip_s;
  /// The value that a TimeCorrection will take, roughly: the path is read there and continued from
  /// there by its acceleration and jerk, so that no step of a solver meets the jumps of the
  /// acceleration at the states. Some milliseconds need not be given.
  double time_bias_s = 0.0;
};

/// A flight with its corrections: what all looks of one pass share.
///
/// Each correction has one parameter block; a spline has one for each coefficient, side by side in
/// one array of the caller. Passes share a correction by sharing the array. Corrections of one kind
/// add up, so a pass can have a range bias of its own and one that all passes share. In units of
/// ParameterNames(); equations: docs/theory/flight_path.md and observations.md.
///
/// Immutable: any number of threads may use one flight. Copies what it is given.
class CorrectedFlight {
 public:
  /// Throws InputError for a path without states, a strip that ends before it starts, a correction
  /// that Adjust() refuses, more than 192 parameters at one look, and a path that is vertical or
  /// turns too fast where corrections are in track axes.
  CorrectedFlight(const Frame& frame,
                  const FlightPath& path,
                  const FlightOptions& options,
                  std::vector<FlightCorrection> corrections);
  /// The flight of a pass of a block, read as Adjust() reads it: where the noise of its states
  /// turns the Doppler cone of its looks noticeably, with the acceleration without that noise.
  CorrectedFlight(const Block& block,
                  std::size_t pass,
                  std::vector<FlightCorrection> corrections,
                  double time_bias_s = 0.0);
  ~CorrectedFlight();
  CorrectedFlight(const CorrectedFlight&) = delete;
  CorrectedFlight& operator=(const CorrectedFlight&) = delete;

  [[nodiscard]] std::size_t correction_count() const;
  [[nodiscard]] int BlockSize(std::size_t correction) const;  ///< parameters of one block
  /// Blocks of a correction: 1, or the coefficients of a spline.
  [[nodiscard]] std::size_t BlockCount(std::size_t correction) const;
  /// "position.along.0 [m]", "range.scale [1]", ... of all blocks in order: BlockSize() times
  /// BlockCount() names, as a ParameterResult has them.
  [[nodiscard]] std::vector<std::string> ParameterNames(std::size_t correction) const;

  /// The parameter blocks of a look measured at `time_s`, in the order of its cost function: the
  /// point's [3], then those of the corrections that are no splines, then of each spline the four
  /// that act at this time. `arrays` has one pointer for each correction, to BlockSize() times
  /// BlockCount() doubles. Throws InputError if their number is another.
  [[nodiscard]] std::vector<double*> Blocks(double* point,
                                            std::span<double* const> arrays,
                                            double time_s) const;

  /// The corrected antenna at a measured time, read at that time plus the time bias; frame axes.
  /// Nothing outside the path.
  [[nodiscard]] std::optional<Motion> At(double time_s, std::span<double* const> arrays) const;

  /// Metres along track at the target per unit of the azimuth measurement, the speed at which the
  /// look passes over it [m/s] or |de_d/df| [m/Hz], for a point at p: a standard deviation in
  /// metres over this is time_sigma_s. The acceleration of the corrections is left out of it.
  /// `arrays` empty: all corrections zero, which changes it by a few 1e-5. NaN where the look has
  /// no value. The range is not used.
  [[nodiscard]] double AzimuthUnit_m(const LookMeasurement& look,
                                     const Eigen::Vector3d& p_m,
                                     std::span<double* const> arrays = {}) const;

  /// What the cost functions read, and a flight made of it: for the library's own solver.
  struct Parts;
  explicit CorrectedFlight(std::unique_ptr<const Parts> parts);
  [[nodiscard]] const Parts& parts() const { return *parts_; }

 private:
  std::unique_ptr<const Parts> parts_;
};
using FlightPointer = std::shared_ptr<const CorrectedFlight>;

/// A look of a block. A standard deviation in metres at the target becomes seconds for a point near
/// `near_m` [m, frame axes] and corrections `arrays` (AzimuthUnit_m); Adjust() does the same at its
/// solution. Throws InputError where the look has no value there.
[[nodiscard]] LookMeasurement MeasurementOf(const Block& block,
                                            std::size_t look,
                                            const CorrectedFlight& flight,
                                            const Eigen::Vector3d& near_m,
                                            std::span<double* const> arrays = {});

}  // namespace sarblock
