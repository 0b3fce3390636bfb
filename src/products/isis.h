// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/geometry/path.h"

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bytes.h"
#include "image.h"
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace sarblock {

/// `Name = value <unit>` of a label. A list is its values in order, inner lists one after another.
struct PvlKey {
  std::string name;
  std::vector<std::string> values;
  std::size_t inner_lists = 0;
  std::string unit;  ///< that of the last value
  std::size_t line = 0;
};

/// An object or a group of a label (Parameter Value Language as ISIS writes it). What is missing or
/// makes no sense throws InputError with file, line and path (`IsisCube.Instrument.StartTime`).
class PvlObject {
 public:
  [[nodiscard]] const PvlObject* Find(std::string_view name) const;
  [[nodiscard]] const PvlObject& Child(std::string_view name) const;
  [[nodiscard]] const std::vector<PvlObject>& children() const { return children_; }
  [[nodiscard]] const std::string& name() const { return name_; }

  [[nodiscard]] const PvlKey* FindKey(std::string_view name) const;
  [[nodiscard]] const PvlKey& Key(std::string_view name) const;
  [[nodiscard]] const std::vector<PvlKey>& keys() const { return keys_; }
  [[nodiscard]] std::string Text(std::string_view key) const;  ///< of a single value
  [[nodiscard]] double Number(std::string_view key) const;
  [[nodiscard]] double Positive(std::string_view key) const;
  /// An integer of `least` to 2^53.
  [[nodiscard]] std::uint64_t Count(std::string_view key, std::uint64_t least) const;
  [[nodiscard]] std::vector<double> Numbers(std::string_view key, std::size_t count) const;
  [[nodiscard]] double NumberOf(const PvlKey& key, std::size_t index) const;

  [[noreturn]] void Fail(std::string_view key, const std::string& problem) const;

 private:
  friend class PvlParser;
  std::string file_, name_, path_;
  std::size_t line_ = 0;
  std::vector<PvlKey> keys_;
  std::vector<PvlObject> children_;
};

/// Whether two names are equal without regard to case, as in labels.
[[nodiscard]] bool SameName(std::string_view a, std::string_view b);

/// The label at the beginning of a file, up to its line `End`; the root has no name. It is read in
/// pieces, 8 MiB at most.
[[nodiscard]] PvlObject ReadPvlLabel(ByteSource* source);

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
