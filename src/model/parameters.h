// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/model/options.h"

#include <array>
#include <string>
#include <vector>

#include "geometry/basis.h"
#include "priors.h"
#include <Eigen/Core>

namespace sarblock {

/// Parameters that always occur together: one column block of the normal matrix.
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
  std::vector<JointPriorTerm> joint_priors;

  /// More columns than any look may touch.
  static constexpr int kMaxLocalColumns = 192;
  /// Terms of one pass: its own and those of shared groups.
  static constexpr std::size_t kMaxPolynomials = 4;
  static constexpr std::size_t kMaxSplines = 4;
  static constexpr std::size_t kMaxTroposphere = 4;
  [[nodiscard]] int size() const { return static_cast<int>(parameters.size()); }
  /// "A1 position.along.0", for messages.
  [[nodiscard]] std::string Describe(int parameter) const;
  /// Deviations c - c0 of the parameters of a joint prior from its values.
  [[nodiscard]] Eigen::VectorXd FromPrior(const JointPriorTerm& prior,
                                          const Eigen::VectorXd& corrections) const;
  /// Step of a coefficient of a process: its c - c0 less the carried part of the c - c0 of the
  /// coefficient before.
  [[nodiscard]] double StepOf(std::size_t parameter, const Eigen::VectorXd& corrections) const;
  /// The sum of a pass's time biases in all corrections of the block.
  [[nodiscard]] double TimeBias_s(std::size_t pass, const Eigen::VectorXd& corrections) const;
};

/// Connects the parameters of a correction that is no spline, from local column `column` on in the
/// order of ParametersOf, to what they correct of a pass.
void BindCorrection(const Correction& correction, int column, PassCorrections* pass);

/// The spline of a correction over a span; its first block is not set. Throws InputError for knots
/// that UniformSpline refuses.
[[nodiscard]] SplineTerm MakeSplineTerm(const PositionCorrection& position,
                                        double start_s,
                                        double end_s);

/// Throws InputError, its key beginning with "correction." and the group's name, for a position
/// correction with a degree that is not allowed, no component or priors of the wrong number, and
/// for a standard deviation of a prior or a scale height that is not finite and positive.
void CheckCorrection(const CorrectionGroup& group);

/// Throws InputError where a pass has more terms or local columns than a look may touch.
void CheckLimits(const std::string& pass_id, const PassCorrections& pass);

/// One whitened equation of a prior, the sum of weight (c - c0) over its terms.
struct PriorRow {
  struct Term {
    int parameter = 0;
    double weight = 0.0;
  };
  std::vector<Term> terms;
};

/// The equations of all priors of a parameter block: one per parameter that has its own prior or
/// follows another one in a process, in their order, then those of its joint priors
/// (docs/theory/adjustment.md, eq. (3a) and (3c)). The parameter that one follows is in the block
/// before.
[[nodiscard]] std::vector<PriorRow> PriorRowsOf(const ParameterLayout& layout, int block);

/// Builds the layout. Throws InputError for an unknown pass, an empty group, priors of the wrong
/// number, a degree above PositionCorrection::kMaxDegree, two groups for one pass that are both
/// not shared and Overlap(), or a joint prior that does not fit (BindJointPriors).
[[nodiscard]] ParameterLayout MakeParameterLayout(const Block& block,
                                                  const std::vector<CorrectionGroup>& groups,
                                                  const std::vector<JointPrior>& priors = {});

}  // namespace sarblock
