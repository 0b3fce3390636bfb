// SPDX-License-Identifier: Apache-2.0
#include "plants_draw.h"

#include <algorithm>
#include <cmath>

namespace sarblock::test {

std::uint32_t DrawPass(const Block& block, RandomStream* random) {
  return static_cast<std::uint32_t>(random->Uniform() * static_cast<double>(block.passes.size()));
}

std::uint32_t DrawPoint(const Block& block, RandomStream* random) {
  return static_cast<std::uint32_t>(random->Uniform() * static_cast<double>(block.points.size()));
}

double DrawSign(RandomStream* random) { return random->Uniform() < 0.5 ? -1.0 : 1.0; }

double DrawSize(double least, double most, RandomStream* random) {
  return least * std::pow(most / least, random->Uniform());
}

double DrawOf(const std::vector<double>& values, RandomStream* random) {
  return values[static_cast<std::size_t>(random->Uniform() * static_cast<double>(values.size()))];
}

Planted PlantInPass(const Block& block, std::uint32_t pass, std::string cause) {
  return {true, {std::move(cause)}, {block.passes[pass].id}, {}, ""};
}

Planted PlantEverywhere(std::string cause) { return {true, {std::move(cause)}, {}, {}, ""}; }

Planted PlantAtPoints(const Block& block,
                      const std::vector<std::uint32_t>& points,
                      std::string cause) {
  Planted planted = PlantEverywhere(std::move(cause));
  for (const std::uint32_t point : points) {
    planted.points.emplace_back(block.points.ids[point]);
  }
  return planted;
}

double MeanRange(const Block& block) {
  double sum_m = 0.0;
  for (const double range_m : block.looks.range_m) sum_m += range_m;
  return sum_m / static_cast<double>(block.looks.size());
}

void SwapValues(std::size_t i, std::size_t j, Looks* looks) {
  std::swap(looks->time_s[i], looks->time_s[j]);
  std::swap(looks->range_m[i], looks->range_m[j]);
  if (!looks->cone.empty()) std::swap(looks->cone[i], looks->cone[j]);
}

}  // namespace sarblock::test
