// SPDX-License-Identifier: Apache-2.0
#include "terrain.h"

#include "sarblock/core/statistics.h"

#include <cmath>
#include <numbers>

#include "streams.h"

namespace sarblock {

Terrain::Terrain(const SceneTerrain& terrain, std::uint64_t seed) : mean_m_(terrain.height_m) {
  if (terrain.kind == SceneTerrain::Kind::kFlat || !(terrain.relief_m > 0.0)) return;
  const bool rugged = terrain.kind == SceneTerrain::Kind::kRugged;
  const int octaves = rugged ? 4 : 1;
  const int waves_per_octave = rugged ? 32 : 64;
  double square_sum = 0.0;
  for (int octave = 0; octave < octaves; ++octave) square_sum += std::pow(0.25, octave);
  RandomStream random(seed, MixStream(kTerrainStream, 0));
  for (int octave = 0; octave < octaves; ++octave) {
    const double correlation_m = terrain.correlation_m * std::pow(0.5, octave);
    const double octave_rms_m = terrain.relief_m * std::pow(0.5, octave) / std::sqrt(square_sum);
    for (int i = 0; i < waves_per_octave; ++i) {
      const double kx = random.Normal() * std::numbers::sqrt2 / correlation_m;
      const double ky = random.Normal() * std::numbers::sqrt2 / correlation_m;
      waves_.push_back({{kx, ky},
                        2.0 * std::numbers::pi * random.Uniform(),
                        octave_rms_m * std::sqrt(2.0 / waves_per_octave)});
    }
  }
}

double Terrain::HeightAt(const Eigen::Vector2d& plane_m) const {
  double height_m = mean_m_;
  for (const Wave& wave : waves_) {
    height_m += wave.amplitude_m * std::cos(wave.wave_rad_per_m.dot(plane_m) + wave.phase_rad);
  }
  return height_m;
}

}  // namespace sarblock
