// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Version of these headers as a number to compare, 0.1.0 is 100: major * 10000 + minor * 100 +
/// patch.
#define SARBLOCK_VERSION 100

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

/// What this library throws, beside std::bad_alloc and what a ProgressSink of the caller throws.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Input that cannot be used: a file, a table or a value a caller handed over.
/// what() reads `FILE:LINE: field: what is wrong, what is allowed`. The program's exit code is 3.
class InputError : public Error {
 public:
  InputError(FilePlace place, std::string problem);
  /// For data that does not come from a file: `field: what is wrong, what is allowed`.
  InputError(std::string field, std::string problem);
  /// Its `field` alone is set for data that does not come from a file: "looks.pass[5]".
  [[nodiscard]] const FilePlace& place() const { return place_; }
  /// What is wrong, what is allowed: what() without the place.
  [[nodiscard]] const std::string& problem() const { return problem_; }

 private:
  FilePlace place_;
  std::string problem_;
};

/// A block, or a part of it that was asked for, that its observations do not determine. The
/// program's exit code is 4. `names` are the parameters (`A1 position.across.0`) or points that
/// cannot be known.
class UndeterminedError : public Error {
 public:
  UndeterminedError(const std::string& problem, std::vector<std::string> names);
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }

 private:
  std::vector<std::string> names_;
};

/// A ProgressSink asked to stop; nothing is left half written. The program's exit code is 1.
class Interrupted : public Error {
 public:
  explicit Interrupted(std::string stage);
  /// What was going on.
  [[nodiscard]] const std::string& stage() const { return stage_; }

 private:
  std::string stage_;
};

/// Angles are radians inside and degrees at the edges (files, messages).
inline constexpr double kRadPerDeg = std::numbers::pi / 180.0;
inline constexpr double kDegPerRad = 180.0 / std::numbers::pi;

/// Speed of light in vacuum, exact (SI).
inline constexpr double kSpeedOfLight_mps = 299792458.0;

/// A number that is not there.
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Version of this build, "0.1.0"; that of the headers: SARBLOCK_VERSION.
[[nodiscard]] const char* Version();

}  // namespace sarblock
