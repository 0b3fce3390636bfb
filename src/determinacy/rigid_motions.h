// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "model/problem.h"
#include <Eigen/Core>

namespace sarblock {

/// The pass whose own parameter each is, -1 for shared ones.
[[nodiscard]] std::vector<int> PassOfParameters(const ParameterLayout& layout);

/// Corrections that move passes as one rigid body (and its size): the directions a block without a
/// datum is free in. Columns are translations east, north, up by 1 m; rotations about these axes
/// through the middle of the passes by 1 rad; a change of size by 1, which only exists where range
/// scales do. Rows are parameters in their own units; what the corrections cannot represent is left
/// out of a column. docs/theory/rank.md, section 4.
inline constexpr int kMotions = 7;
[[nodiscard]] Eigen::MatrixXd RigidMotions(const AdjustmentProblem& problem,
                                           const std::vector<int>& pass_of_parameter,
                                           const std::vector<std::uint32_t>& passes);

/// "translation of the whole block in y", for a mixture of the columns above: `part` in metres,
/// radians and one. `whose` is "the whole block" or an island.
[[nodiscard]] std::string NameMotion(const Eigen::Matrix<double, kMotions, 1>& part,
                                     FrameKind frame,
                                     const std::string& whose);

}  // namespace sarblock
