// SPDX-License-Identifier: Apache-2.0
// Radar looks as cost functions of a ceres::Problem of the caller. CMake: sarblock::cost, the only
// target that brings Ceres.
//
//     auto flight = std::make_shared<sarblock::CorrectedFlight>(
//         frame, path, sarblock::FlightOptions{.strip_s = {0.0, 40.0}},
//         std::vector<sarblock::FlightCorrection>{{position}, {range}});
//     double* arrays[] = {shift_of_this_pass, range_bias_of_all};  // the caller's memory
//     sarblock::LookMeasurement look;
//     look.time_s = 12.345;
//     look.range_m = 8765.4;
//     look.range_sigma_m = 0.5;
//     look.time_sigma_s = 0.5 / flight->AzimuthUnit_m(look, origin_m);  // half a metre
//     Eigen::Vector3d point = Eigen::Vector3d::Zero();                  // from origin_m
//     problem.AddResidualBlock(sarblock::RangeDopplerCost(flight, look, origin_m).release(),
//                              new ceres::HuberLoss(1.5),
//                              flight->Blocks(point.data(), arrays, look.time_s));
//
// docs/own_problem.md goes through a whole program.
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
#include <ceres/cost_function.h>

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
  /// metres over this is time_sigma_s. Velocity and acceleration are those of the given path
  /// (docs/theory/observations.md, eq. (10b)). `arrays` empty: all corrections zero, which moves
  /// the line of sight alone. NaN where the look has no value. The range is not used.
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

using CostPointer = std::unique_ptr<ceres::CostFunction>;

// What all cost functions here have in common.
//
// Blocks: the point [3, m, frame axes], p = origin_m + block, then those of the corrections, as
// CorrectedFlight::Blocks() gives them. Residuals are in standard deviations, predicted less
// measured: standard normal where the model is true. Jacobians are analytic; only those that Ceres
// asks for are written. Losses, manifolds, constant blocks and bounds are the Problem's.
//
// Absolute coordinates are a trap: Ceres ends where a step is small beside the norm of all blocks.
// Its parameter_tolerance of 1e-8 times 6.4e6 m times the square root of the number of points is
// metres. In a geocentric frame give an origin near the point and let its block begin at zero.
//
// Evaluate() returns FALSE where the model has no value:
//     the time plus its bias lies beyond an end of the path by more than the path's length;
//     the antenna is within 1 mm of the point;
//     the cone never passes over the point, or does so with less than a fiftieth of the speed;
//     a Doppler is measured and the point lies on the line of flight;
//     the line of sight is level or rises at the target, with a troposphere;
//     an argument or a result is not finite.
// Ceres then shortens its step. At the start it gives up: call Evaluate() first, and leave such a
// look out. It may also end at such an edge and report convergence: look at the gradient.
//
// Evaluate() is const, allocates nothing and never throws; any number of threads may call it. Each
// cost function keeps its flight alive. release() hands it to a Problem, which by default deletes
// it.
//
// Making one throws InputError for a measurement, a standard deviation or a time that cannot be
// meant: not finite, not positive, outside the path.

/// Both measurements of a look, as Adjust() has them: 2 residuals (docs/theory/observations.md,
/// eqs. (9) to (11d)),
///
///     (R_p - R) / sigma_R,   (t_p - t) / sigma_t,
///
/// t_p the time at which the cone holds the point, R_p the range there. With doppler_sigma_hz the
/// time is exact: R_p is the range at t, and the second residual (f_p - f) / sigma_f.
[[nodiscard]] CostPointer RangeDopplerCost(
    FlightPointer flight,
    const LookMeasurement& look,
    const Eigen::Vector3d& origin_m = Eigen::Vector3d::Zero());

/// The range at the measured time alone, which is exact: 1 residual, (rho(t) + corrections - R) /
/// sigma_R. For transponders and altimeters; with DopplerConeCost() it is RangeDopplerCost() of a
/// look whose Doppler was measured. For a look whose time was measured the two are not the same:
/// there the range is that at the predicted time.
[[nodiscard]] CostPointer RangeSphereCost(
    FlightPointer flight,
    const LookMeasurement& look,
    const Eigen::Vector3d& origin_m = Eigen::Vector3d::Zero());

/// The azimuth measurement alone: 1 residual, the second of RangeDopplerCost(). The range is not
/// used.
[[nodiscard]] CostPointer DopplerConeCost(
    FlightPointer flight,
    const LookMeasurement& look,
    const Eigen::Vector3d& origin_m = Eigen::Vector3d::Zero());

/// The priors of one block of a correction, value over standard deviation, one residual for each
/// parameter that has one; null if none has. A spline needs one for each of its blocks; they are
/// alike. Add it once for each array, not once for each flight that shares it.
[[nodiscard]] CostPointer PriorCost(const CorrectedFlight& flight, std::size_t correction);

/// A known position as Adjust() has it: up to three residuals, L^-1 (E (p - p_known)) of the fixed
/// components, L L' their covariance, E to east, north, up at p_known; of a height alone in a
/// geocentric frame that above the ellipsoid (docs/theory/adjustment.md). One block, the point.
/// Throws InputError if no component is fixed, p_known is not finite or the covariance is not
/// positive definite.
[[nodiscard]] CostPointer KnownPositionCost(
    const Frame& frame,
    const KnownPosition& known,
    const Eigen::Vector3d& known_m,
    const Eigen::Vector3d& origin_m = Eigen::Vector3d::Zero());

}  // namespace sarblock
