// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/path.h"

#include <string>
#include <string_view>
#include <vector>

#include "bytes.h"
#include "image.h"
#include "pvl.h"
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace sarblock {

/// Reads a cube of ISIS with Mini-RF geometry (LRO, Chandrayaan-1), level 1, after spiceinit: its
/// label and the tables InstrumentPosition and BodyRotation. Pixels are not read, so a cube costs
/// the memory of its label and tables. A crop or reduction is undone by the label's AlphaCube:
/// lines and samples are those of the cube itself. Throws InputError with file, line and key, or
/// the table, for what is missing or makes no sense. docs/import_isis.md.
[[nodiscard]] RadarImage ReadIsisCube(const std::string& file);
/// The same of bytes in memory; `file` is for messages.
[[nodiscard]] RadarImage ParseIsisCube(std::string_view bytes, const std::string& file);

/// A table of a cube whose fields are doubles, row by row.
struct CubeTable {
  const PvlObject* label = nullptr;
  std::vector<std::vector<double>> rows;
};

/// The object `Table` of this name, or null.
[[nodiscard]] const PvlObject* FindCubeTable(const PvlObject& root, std::string_view name);

/// Reads a table that holds exactly `fields`, in this order, 64 MiB at most. `remedy` ends the
/// message where it does not.
[[nodiscard]] CubeTable ReadCubeTable(ByteSource* source,
                                      const PvlObject& label,
                                      const std::vector<std::string_view>& fields,
                                      const char* remedy);

/// Attitude of a body at a time: rotation from inertial to (its time-dependent) body axes and
/// angular velocity in inertial axes.
struct BodyAttitude {
  double time_s = 0.0;
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d rate_radps = Eigen::Vector3d::Zero();
};

/// A flight in inertial axes (J2000) above a turning body, as cubes of ISIS and ISDs give it.
struct InertialOrbit {
  std::string file;                 ///< for messages
  std::vector<StateVector> states;  ///< times increasing, the cubic of two is the flight
  std::vector<BodyAttitude> body;   ///< times increasing; between two: the shortest rotation
  Eigen::Matrix3d constant = Eigen::Matrix3d::Identity();  ///< body-fixed of the attitude's axes
};

/// The flight in body-fixed axes, velocity relative to the body:
///
///     p = C R(q) r,  v = C R(q) (v_inertial - omega x r)
///
/// at the times of the states and between them, every interval cut into equal parts of at most
/// `step_s`. Throws InputError where times do not increase, a number is not finite or a quaternion
/// is not one of a rotation.
[[nodiscard]] std::vector<StateVector> BodyFixedStates(const InertialOrbit& orbit, double step_s);

}  // namespace sarblock
