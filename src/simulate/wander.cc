// SPDX-License-Identifier: Apache-2.0
#include "wander.h"

#include "sarblock/core/statistics.h"

#include <array>
#include <vector>

#include "gauss_markov.h"
#include "streams.h"

namespace sarblock {

Wander::Wander(const SceneWander& scene,
               const Pass& planned,
               std::size_t pass_index,
               std::uint64_t seed)
    : start_s_(planned.start_s) {
  const std::uint64_t stream = MixStream(kWanderStream, pass_index);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (scene.rms_m[axis] > 0.0) {
      process_[axis] = DrawGaussMarkov(scene.rms_m[axis],
                                       scene.time_constant_s[axis],
                                       planned.start_s,
                                       planned.path.start_s(),
                                       planned.path.end_s(),
                                       seed,
                                       MixStream(stream, axis));
    }
    if (scene.table_time_s.empty()) continue;
    std::vector<double> values_m;
    for (const Eigen::Vector3d& offset_m : scene.table_m) {
      values_m.push_back(offset_m[static_cast<Eigen::Index>(axis)]);
    }
    table_[axis] = SmoothCurve::Natural(scene.table_time_s, values_m);
  }
}

Wander::Offset Wander::At(double time_s) const {
  Offset offset;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const std::array<double, 4> process = process_[i].At(time_s);
    const std::array<double, 4> table = table_[i].At(time_s - start_s_);
    offset.value_m[axis] = process[0] + table[0];
    offset.first_mps[axis] = process[1] + table[1];
    offset.second_mps2[axis] = process[2] + table[2];
    offset.third_mps3[axis] = process[3] + table[3];
  }
  return offset;
}

}  // namespace sarblock
