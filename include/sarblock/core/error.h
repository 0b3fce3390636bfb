// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

namespace sarblock {

/// Where in a file something is wrong. `line` counts from 1; 0 means the file as a whole.
struct FilePlace {
  std::string file;
  std::size_t line = 0;
  std::string field;  ///< column name or dotted TOML key; may be empty
};

/// Input that cannot be used: a file, a table or a value a caller handed over.
/// what() reads `FILE:LINE: field: what is wrong, what is allowed`. Exit code 3.
class InputError : public std::runtime_error {
 public:
  InputError(const FilePlace& place, const std::string& problem);
  /// For data that does not come from a file: `field: what is wrong, what is allowed`.
  InputError(const std::string& field, const std::string& problem);
};

/// A block, or a part of it that was asked for, that its observations do not determine. Exit
/// code 4. `names` are the parameters (`A1 position.across.0`) or points that cannot be known.
class UndeterminedError : public std::runtime_error {
 public:
  UndeterminedError(const std::string& problem, std::vector<std::string> names);
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }

 private:
  std::vector<std::string> names_;
};

/// The user interrupted (Ctrl-C); nothing is left half written. Exit code 1.
class Interrupted : public std::runtime_error {
 public:
  explicit Interrupted(const std::string& stage);
};

/// Angles are radians inside and degrees at the edges (files, messages).
inline constexpr double kRadPerDeg = std::numbers::pi / 180.0;
inline constexpr double kDegPerRad = 180.0 / std::numbers::pi;

/// Speed of light in vacuum, exact (SI).
inline constexpr double kSpeedOfLight_mps = 299792458.0;

/// A number that is not there.
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Version of this build, "0.1.0".
[[nodiscard]] const char* Version();

}  // namespace sarblock
