// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/files/scene_file.h"
#include "sarblock/model/options.h"
#include "sarblock/simulate/scene.h"

#include <cstddef>
#include <string>
#include <vector>

namespace sarblock {

/// The two-dimensional net of passes that benchmarks are measured on: so many lines of so many
/// segments from both sides, 7.2 and 5 km apart as its scene has them.
inline SimulatedBlock MakeNetwork(const std::string& scene_file,
                                  int lines,
                                  int segments,
                                  const std::string& points) {
  const std::string north = std::to_string(13500 + 7200 * (lines - 1) + 11000);
  const std::string east = std::to_string(500 + 5000 * segments);
  return Simulate(files::ReadScene(scene_file,
                                   {"points.count=" + points,
                                    "flight.0.count=" + std::to_string(lines),
                                    "flight.1.count=" + std::to_string(lines),
                                    "flight.0.segments=" + std::to_string(segments),
                                    "flight.1.segments=" + std::to_string(segments),
                                    "points.east_m=[500, " + east + "]",
                                    "points.north_m=[13500, " + north + "]"}));
}

/// Positions of every pass as polynomials of this degree, with priors.
inline std::vector<CorrectionGroup> NetworkCorrections(int degree) {
  std::vector<double> sigma_m(static_cast<std::size_t>(degree) + 1, 1.0);
  sigma_m[0] = 10.0;
  if (degree > 0) sigma_m[1] = 5.0;
  PositionCorrection position;
  position.degree = degree;
  position.prior_sigma_m.fill(sigma_m);
  return {{"position", position, {}, false}};
}

}  // namespace sarblock
