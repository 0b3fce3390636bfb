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

#include "sarblock/cost/corrected_flight.h"

#include <cstddef>
#include <memory>

#include <Eigen/Core>
#include <ceres/cost_function.h>

namespace sarblock {

using CostPointer = std::unique_ptr<ceres::CostFunction>;

// What all cost functions here have in common.
//
// Blocks: the point [3, m, frame axes], p = origin_m + block, then those of the corrections, as
// CorrectedFlight::Blocks() gives them. Residuals are in standard deviations, predicted less
// measured: standard normal where the model is true. Jacobians are analytic; of those that Ceres
// does not ask for nothing is written. Losses, manifolds, constant blocks and bounds are the
// Problem's.
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
/// look whose Doppler was measured. Of a look whose time was measured it is not: there the range is
/// that at the predicted time.
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
/// parameter that has one; null if none has. Of a spline one for each of its blocks is needed; they
/// are alike. Add it once for each array, not once for each flight that shares it.
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
