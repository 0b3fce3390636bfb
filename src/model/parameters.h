// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/corrections.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "flight/basis.h"

namespace sarblock {

/// What a prior says of a parameter, in the unit of the parameter.
using PriorValue = double;

/// What a parameter corrects.
enum class ParameterKind : std::uint8_t {
  kPosition,  ///< of the antenna, along one axis
  kVelocityAcross,
  kVelocityUp,
  kRangeBias,
  kRangeScale,
  kTimeBias,
  kSquintBias,
  kZenithDelay,
};

/// One correction parameter of a block. Its name and unit are for people and files; what it does
/// is its kind.
struct Parameter {
  std::string owner;  ///< pass id, or the group's name where shared
  std::string name;   ///< "position.along.0", "range.bias", ...
  std::string unit;   ///< "m", "s", "rad", "1"
  PriorSigma prior_sigma = kNotGiven;
  PriorValue prior_value = 0.0;  ///< in `unit`; what the prior says, drawn anew in a simulation
  ParameterKind kind = ParameterKind::kPosition;
  // Of kPosition:
  PositionCorrection::Axes axes = PositionCorrection::Axes::kTrack;
  int axis = 0;         ///< 0 along or x, 1 across or y, 2 up or z
  int degree = 0;       ///< of the polynomial; of a spline the number of its coefficient
  bool spline = false;  ///< coefficient of a spline
  [[nodiscard]] bool has_prior() const { return prior_sigma == prior_sigma; }
};

/// Parameters that always stand together: one column block of the normal matrix.
struct ParameterBlock {
  int offset = 0;  ///< first parameter
  int size = 0;
  bool shared = false;
};

/// A polynomial position correction of one pass: component i, degree k is the local column
/// column + rank(i) * (degree + 1) + k, rank counting the components that are on.
struct PolynomialTerm {
  PositionCorrection::Axes axes = PositionCorrection::Axes::kTrack;
  std::array<bool, 3> components{};
  int degree = 0;
  int column = 0;
};

/// A spline position correction: coefficient q is the parameter block first_block + q, one entry a
/// component that is on.
struct SplineTerm {
  PositionCorrection::Axes axes = PositionCorrection::Axes::kTrack;
  std::array<bool, 3> components{};
  int component_count = 0;
  UniformSpline spline;
  int first_block = 0;
};

struct TroposphereTerm {
  int column = 0;
  double scale_height_m = 0.0;
};

/// What corrects one pass. A look has local columns: those of `blocks` in order (static), then for
/// each spline term four blocks that depend on the look's time.
struct PassCorrections {
  std::vector<int> blocks;
  int static_columns = 0;
  std::vector<PolynomialTerm> polynomials;
  std::vector<SplineTerm> splines;
  std::vector<int> velocity_across, velocity_up;  ///< local columns; effects of several add
  std::vector<int> range_bias, range_scale, time_bias, squint_bias;
  std::vector<TroposphereTerm> troposphere;
  double middle_s = 0.0;  ///< strip-normalised time is (t - middle) / half
  double half_length_s = 1.0;
  [[nodiscard]] bool NeedsTrackAxes() const;
};

/// All parameters of a block in one vector, cut into blocks, and how each pass uses them.
///
/// Non-shared polynomial, velocity, range, time, squint and troposphere parameters of a pass form
/// one block; a shared group is a block of its own; a spline is one block a coefficient, so that
/// the normal matrix stays banded however many knots there are.
struct ParameterLayout {
  std::vector<Parameter> parameters;
  std::vector<ParameterBlock> blocks;
  std::vector<PassCorrections> passes;  ///< by pass index

  /// More columns than any look may touch.
  static constexpr int kMaxLocalColumns = 192;
  /// Terms of one pass: its own and those of shared groups.
  static constexpr std::size_t kMaxPolynomials = 4;
  static constexpr std::size_t kMaxSplines = 4;
  static constexpr std::size_t kMaxTroposphere = 4;
  [[nodiscard]] int size() const { return static_cast<int>(parameters.size()); }
  /// "A1 position.along.0", for messages.
  [[nodiscard]] std::string Describe(int parameter) const;
};

/// Builds the layout. Throws InputError for an unknown pass, an empty group, priors of the wrong
/// number, a degree above PositionCorrection::kMaxDegree or two groups for one pass that are both
/// not shared and Overlap().
[[nodiscard]] ParameterLayout MakeParameterLayout(const Block& block,
                                                  const std::vector<CorrectionGroup>& groups);

}  // namespace sarblock
