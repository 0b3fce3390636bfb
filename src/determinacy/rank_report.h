// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace sarblock {

/// Least eigenvalue of the reduced matrix scaled to unit diagonal that still counts as regular; its
/// own rounding is about 1e-15.
inline constexpr double kLeastEigenvalue_1 = 1e-13;
/// Below this an eigenvalue is always warned of: six digits of the covariance are not certain. The
/// rounding of S, 1.1e-16 of its diagonal, comes back in S^-1 divided by the eigenvalue; up to
/// twice that is met in covariances (docs/studies/stability.md), which leaves 4.4e-7 here.
inline constexpr double kNearEigenvalue_1 = 5e-10;
/// A standard deviation of a correction without a prior, as movement at the target, beyond these
/// parts of the mean slant range is warned of, and is refused: nothing linear holds there.
inline constexpr double kNearEffectPart_1 = 0.01;
inline constexpr double kOpenEffectPart_1 = 0.5;

/// A parameter that takes part in a weak direction.
struct WeakParameter {
  int index = 0;
  double share_1 = 0.0;  ///< component of the unit direction, parameters in conditional sigmas
  /// Posterior standard deviation in the parameter's unit; infinite where undetermined.
  double sigma = std::numeric_limits<double>::infinity();
};

/// Parameters that move together and change (almost) no observation.
struct WeakDirection {
  double eigenvalue_1 = 0.0;  ///< v'Sv, |v| = 1, S scaled to unit diagonal
  double prior_part_1 = 0.0;  ///< how much of it the priors give, 0 to 1
  bool undetermined = false;  ///< to be refused; else nearly undetermined
  double effect_m = 0.0;      ///< largest movement at the target, parameters without prior, 1 sigma
  double correlation_1 = 0.0;  ///< of the two parameters with the largest shares; 0 if undetermined
  std::vector<WeakParameter> parameters;     ///< the largest share first
  std::string motion;                        ///< "translation of the whole block in y", or empty
  std::optional<std::uint32_t> moved_point;  ///< the tie point it moves most, where known
  double moved_m = 0.0;                      ///< by how much per sigma
  std::string text;                          ///< all of it in words, with what would remove it
};

/// What S does not determine (model.md, section 9; docs/theory/rank.md).
struct RankReport {
  std::vector<WeakDirection> undetermined;
  std::vector<WeakDirection> nearly;
  bool more = false;         ///< there are more weak directions than were looked for
  double condition_1 = 1.0;  ///< ratio of the extreme eigenvalues of the scaled S
  [[nodiscard]] bool regular() const { return undetermined.empty(); }
};

}  // namespace sarblock
