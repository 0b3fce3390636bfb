// SPDX-License-Identifier: Apache-2.0
#include "plants.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "plants_control.h"
#include "plants_draw.h"
#include "plants_ids.h"
#include "plants_path.h"

namespace sarblock::test {
namespace {

// ---- time

double DrawClock(RandomStream* random) {
  if (random->Uniform() < 0.5) return DrawSign(random) * DrawOf({1.0, 18.0, 19.0, 37.0}, random);
  return DrawSign(random) * DrawSize(0.3, 50.0, random);
}

Planted ConstantTime(Block* block, RandomStream* random) {
  const std::uint32_t pass = DrawPass(*block, random);
  const double late_s = DrawClock(random);
  EditLooks(block, pass, [&](std::size_t i) { block->looks.time_s[i] += late_s; });
  return PlantInPass(*block, pass, "time.constant");
}

Planted ConstantTimeOfAll(Block* block, RandomStream* random) {
  const double late_s = DrawClock(random);
  EditLooks(block, {}, [&](std::size_t i) { block->looks.time_s[i] += late_s; });
  return PlantEverywhere("time.constant");
}

Planted ReversedTimes(Block* block, RandomStream* random) {
  const std::uint32_t pass = DrawPass(*block, random);
  double first_s = 1e300, last_s = -1e300;
  EditLooks(block, pass, [&](std::size_t i) {
    first_s = std::min(first_s, block->looks.time_s[i]);
    last_s = std::max(last_s, block->looks.time_s[i]);
  });
  EditLooks(block, pass, [&](std::size_t i) {
    block->looks.time_s[i] = first_s + last_s - block->looks.time_s[i];
  });
  return PlantInPass(*block, pass, "time.reversed");
}

Planted ScaledTimes(Block* block, RandomStream* random) {
  const std::uint32_t pass = DrawPass(*block, random);
  const double factor = DrawOf({1e3, 1e6}, random);
  EditLooks(block, pass, [&](std::size_t i) { block->looks.time_s[i] *= factor; });
  return PlantInPass(*block, pass, "time.scale");
}

/// A look of any point that has looks.
std::optional<std::size_t> DrawLook(const Block& block,
                                    RandomStream* random,
                                    std::uint32_t* point) {
  for (int attempt = 0; attempt < 1000; ++attempt) {
    *point =
        static_cast<std::uint32_t>(random->Uniform() * static_cast<double>(block.points.size()));
    const std::size_t begin = block.looks.offsets[*point], end = block.looks.offsets[*point + 1];
    if (begin == end) continue;
    return begin + static_cast<std::size_t>(random->Uniform() * static_cast<double>(end - begin));
  }
  return std::nullopt;
}

Planted PlantInLook(const Block& block, std::uint32_t point, const char* cause) {
  return {true, {cause, "ids.look", "ids.point"}, {}, {std::string(block.points.ids[point])}, ""};
}

Planted OneTime(Block* block, RandomStream* random) {
  std::uint32_t point = 0;
  const auto look = DrawLook(*block, random, &point);
  if (!look) return {};
  block->looks.time_s[*look] += DrawSign(random) * DrawSize(0.5, 5.0, random);
  return PlantInLook(*block, point, "time.one");
}

Planted OneRange(Block* block, RandomStream* random) {
  std::uint32_t point = 0;
  const auto look = DrawLook(*block, random, &point);
  if (!look) return {};
  block->looks.range_m[*look] += DrawSign(random) * DrawSize(0.01, 0.1, random) * MeanRange(*block);
  return PlantInLook(*block, point, "range.one");
}

Planted DriftingClock(Block* block, RandomStream* random) {
  const std::uint32_t pass = DrawPass(*block, random);
  const double rate = DrawSign(random) * DrawSize(1e-3, 1e-2, random);
  EditLooks(block, pass, [&](std::size_t i) {
    block->looks.time_s[i] += rate * (block->looks.time_s[i] - block->passes[pass].start_s);
  });
  // What a drift along the track would do as well is told of one or the other.
  return {true, {"time.drift", "model.degree", "model.priors", "model.missing"}, {}, {}, ""};
}

/// Looks of the second half of a pass with seconds of the day that begin again.
Planted WrappedTimes(Block* block, RandomStream* random) {
  const std::uint32_t pass = DrawPass(*block, random);
  const double middle_s = 0.5 * (block->passes[pass].start_s + block->passes[pass].end_s);
  std::size_t before = 0, after = 0;
  EditLooks(block, pass, [&](std::size_t i) {
    double& time_s = block->looks.time_s[i];
    ++(time_s > middle_s ? after : before);
    if (time_s > middle_s) time_s -= 86400.0;
  });
  if (before == 0 || after == 0) return {};
  return PlantInPass(*block, pass, "time.wrap");
}

// ---- range

Planted ScaledRanges(Block* block, RandomStream* random) {
  const std::uint32_t pass = DrawPass(*block, random);
  const double factor = DrawOf({2.0, 1e-3, 2e6 / 299792458.0, 1e6 / 299792458.0}, random);
  EditLooks(block, pass, [&](std::size_t i) { block->looks.range_m[i] *= factor; });
  return PlantInPass(*block, pass, "range.scale");
}

Planted ScaledRangesOfAll(Block* block, RandomStream* random) {
  const double factor = DrawOf({2.0, 1e-3, 2e6 / 299792458.0}, random);
  EditLooks(block, {}, [&](std::size_t i) { block->looks.range_m[i] *= factor; });
  return PlantEverywhere("range.scale");
}

Planted RangeBias(Block* block, RandomStream* random) {
  const std::uint32_t pass = DrawPass(*block, random);
  const double longer_m = DrawSign(random) * DrawSize(0.003, 0.05, random) * MeanRange(*block);
  EditLooks(block, pass, [&](std::size_t i) { block->looks.range_m[i] += longer_m; });
  return PlantInPass(*block, pass, "range.bias");
}

Planted RangeBiasOfAll(Block* block, RandomStream* random) {
  const double longer_m = DrawSign(random) * DrawSize(0.003, 0.05, random) * MeanRange(*block);
  EditLooks(block, {}, [&](std::size_t i) { block->looks.range_m[i] += longer_m; });
  return PlantEverywhere("range.bias");
}

Planted GroundRanges(Block* block, RandomStream* random) {
  const std::uint32_t pass = DrawPass(*block, random);
  const bool sphere = block->frame.kind() == FrameKind::kGeocentric;
  const auto height = [&](const Eigen::Vector3d& p_m) { return sphere ? p_m.norm() : p_m.z(); };
  double ground_m = 0.0;
  for (const KnownPosition& known : block->points.known) {
    ground_m += height(block->points.given_m[known.point]) /
                static_cast<double>(block->points.known.size());
  }
  if (block->points.known.empty()) return {};
  const auto& states = block->passes[pass].path.states();
  const double antenna_m = height(states[states.size() / 2].position_m);
  EditLooks(block, pass, [&](std::size_t i) {
    double& range_m = block->looks.range_m[i];
    const double square = range_m * range_m;
    range_m = sphere ? ground_m * std::acos((antenna_m * antenna_m + ground_m * ground_m - square) /
                                            (2.0 * antenna_m * ground_m))
                     : std::sqrt(std::max(1.0, square - std::pow(antenna_m - ground_m, 2)));
  });
  return PlantInPass(*block, pass, "range.ground");
}

// ---- side and cone

Planted WrongSide(Block* block, RandomStream* random) {
  const std::uint32_t pass = DrawPass(*block, random);
  LookSide& side = block->passes[pass].side;
  side = side == LookSide::kLeft ? LookSide::kRight : LookSide::kLeft;
  return PlantInPass(*block, pass, "side");
}

bool HasCone(const Block& block, std::uint32_t pass, bool doppler) {
  bool has = false;
  for (std::size_t i = 0; i < block.looks.size() && !block.looks.cone.empty(); ++i) {
    const bool is_doppler = (block.looks.flags[i] & Looks::kDoppler) != 0;
    has =
        has || (block.looks.pass[i] == pass && is_doppler == doppler && block.looks.cone[i] != 0.0);
  }
  return has;
}

Planted ConeSign(Block* block, RandomStream* random) {
  const std::uint32_t pass = DrawPass(*block, random);
  if (!HasCone(*block, pass, false) && !HasCone(*block, pass, true)) return {};
  EditLooks(block, pass, [&](std::size_t i) { block->looks.cone[i] *= -1.0; });
  return PlantInPass(*block, pass, "cone.sign");
}

Planted ConeRadians(Block* block, RandomStream* random) {
  const std::uint32_t pass = DrawPass(*block, random);
  if (!HasCone(*block, pass, false)) return {};
  EditLooks(block, pass, [&](std::size_t i) { block->looks.cone[i] *= kRadOfDeg; });
  return PlantInPass(*block, pass, "cone.unit");
}

Planted ConeLeftOut(Block* block, RandomStream* random) {
  const std::uint32_t pass = DrawPass(*block, random);
  if (!HasCone(*block, pass, false)) return {};
  EditLooks(block, pass, [&](std::size_t i) { block->looks.cone[i] = 0.0; });
  return PlantInPass(*block, pass, "cone.squint");
}

/// Looks measured at a squint that changes by some degrees from near to far, read as none: the
/// times and ranges of known and tie points at that squint.
Planted NativeDoppler(Block* block, RandomStream* random) {
  const std::uint32_t index = DrawPass(*block, random);
  if (HasCone(*block, index, false) || HasCone(*block, index, true)) return {};
  const Pass& pass = block->passes[index];
  double near_m = 1e300, far_m = 0.0;
  EditLooks(block, index, [&](std::size_t i) {
    near_m = std::min(near_m, block->looks.range_m[i]);
    far_m = std::max(far_m, block->looks.range_m[i]);
  });
  if (!(far_m > near_m)) return {};
  const double change_rad = DrawSign(random) * DrawSize(1e-3, 1e-2, random);
  EditLooks(block, index, [&](std::size_t i) {
    double& range_m = block->looks.range_m[i];
    const double squint_rad = change_rad * (0.3 + (range_m - near_m) / (far_m - near_m));
    // Straight flight by the point: at this squint it is as much behind as the range is longer.
    const double speed_mps = pass.path.At(block->looks.time_s[i])->velocity_mps.norm();
    block->looks.time_s[i] -= range_m * std::tan(squint_rad) / speed_mps;
    range_m /= std::cos(squint_rad);
  });
  return PlantInPass(*block, index, "cone.native");
}

/// Places of the points of a pass read in its image after that was resampled to another one.
Planted Coregistered(Block* block, RandomStream* random) {
  const std::uint32_t index = DrawPass(*block, random);
  const Pass& pass = block->passes[index];
  const auto other = static_cast<std::uint32_t>((index + 1) % block->passes.size());
  Looks& looks = block->looks;
  std::size_t shared = 0;
  for (std::uint32_t point = 0; point < block->points.size(); ++point) {
    std::size_t own = looks.size(), others = looks.size();
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      if (looks.pass[i] == index) own = i;
      if (looks.pass[i] == other) others = i;
    }
    if (own == looks.size() || others == looks.size()) continue;
    const double time_s = pass.start_s + looks.time_s[others] - block->passes[other].start_s;
    if (time_s > pass.end_s) continue;
    looks.time_s[own] = time_s;
    looks.range_m[own] =
        looks.range_m[others] + 0.3 * block->SigmaOf(own).range_m * random->Normal();
    ++shared;
  }
  if (shared < 20) return {};
  return {true, {"range.coregistered"}, {pass.id, block->passes[other].id}, {}, ""};
}

/// A squinted pass with its cone as Doppler centroids and the wavelength in another unit.
Planted Wavelength(Block* block, RandomStream* random) {
  const std::uint32_t index = DrawPass(*block, random);
  if (!HasCone(*block, index, false)) return {};
  Pass& pass = block->passes[index];
  pass.wavelength_m = 0.031;
  EditLooks(block, index, [&](std::size_t i) {
    const auto motion = pass.path.At(block->looks.time_s[i]);
    const double speed_mps = motion->velocity_mps.norm();
    block->looks.cone[i] = 2.0 * speed_mps * std::sin(block->looks.cone[i]) / pass.wavelength_m;
    block->looks.flags[i] |= Looks::kDoppler;
  });
  pass.wavelength_m *= DrawOf({100.0, 1000.0}, random);
  return PlantInPass(*block, index, "cone.wavelength");
}

// ---- standard deviations

void ScaleSigmas(double range, double azimuth, Block* block) {
  for (Pass& pass : block->passes) {
    pass.sigma.range_m *= range;
    pass.sigma.azimuth *= azimuth;
  }
  for (double& sigma : block->looks.range_sigma_m) sigma *= range;
  for (double& sigma : block->looks.azimuth_sigma) sigma *= azimuth;
}

Planted SigmasTooSmall(Block* block, RandomStream*) {
  ScaleSigmas(0.01, 0.01, block);
  return {true, {"sigma.all"}, {}, {}, ""};
}
Planted SigmasTooLarge(Block* block, RandomStream*) {
  ScaleSigmas(100.0, 100.0, block);
  return {true, {"sigma.all"}, {}, {}, ""};
}
Planted AzimuthThousand(Block* block, RandomStream* random) {
  ScaleSigmas(1.0, DrawOf({1e-3, 1e3}, random), block);
  return {true, {"sigma.azimuth", "sigma.all"}, {}, {}, ""};
}
Planted Variance(Block* block, RandomStream*) {
  const LookSigma sigma = block->passes[0].sigma;
  const double factor = std::min(sigma.range_m, sigma.azimuth);
  if (factor > 0.75 && factor < 1.34) return {};
  for (Pass& pass : block->passes) {
    pass.sigma.range_m *= pass.sigma.range_m;
    pass.sigma.azimuth *= pass.sigma.azimuth;
  }
  return {true, {"sigma.variance", "sigma.all", "sigma.range", "sigma.azimuth"}, {}, {}, ""};
}

// ---- errors correlated in time

/// A smooth error along the strip of a pass, of about the root mean square 1.
class TrajectoryError {
 public:
  TrajectoryError(const Pass& pass, RandomStream* random) : pass_(pass) {
    for (Wave& wave : waves_) {
      wave = {DrawSize(1.2, 4.0, random), 2.0 * std::numbers::pi * random->Uniform()};
    }
  }
  [[nodiscard]] double At(double time_s) const {
    const double part = (time_s - pass_.start_s) / (pass_.end_s - pass_.start_s);
    double sum = 0.0;
    for (const Wave& wave : waves_) {
      sum += std::sin(2.0 * std::numbers::pi * wave.periods * part + wave.phase_rad);
    }
    return sum * std::sqrt(2.0 / static_cast<double>(waves_.size()));
  }

 private:
  struct Wave {
    double periods = 0.0, phase_rad = 0.0;
  };
  const Pass& pass_;
  std::array<Wave, 3> waves_;
};

Planted TimeCorrelatedRanges(Block* block, RandomStream* random) {
  const std::uint32_t pass = DrawPass(*block, random);
  const double size = DrawSize(8.0, 40.0, random);
  const TrajectoryError trajectory_error(block->passes[pass], random);
  EditLooks(block, pass, [&](std::size_t i) {
    block->looks.range_m[i] +=
        size * block->SigmaOf(i).range_m * trajectory_error.At(block->looks.time_s[i]);
  });
  return PlantInPass(*block, pass, "range.wander");
}

Planted TimeCorrelatedTimes(Block* block, RandomStream* random) {
  const std::uint32_t index = DrawPass(*block, random);
  const Pass& pass = block->passes[index];
  const double size = DrawSize(8.0, 40.0, random);
  const TrajectoryError trajectory_error(pass, random);
  const double speed_mps = pass.path.At(pass.start_s)->velocity_mps.norm();
  EditLooks(block, index, [&](std::size_t i) {
    const double sigma_s = block->ApproximateAzimuthSigma_m(i, speed_mps) / speed_mps;
    block->looks.time_s[i] += size * sigma_s * trajectory_error.At(block->looks.time_s[i]);
  });
  return PlantInPass(*block, index, "time.wander");
}

// ---- errors without a name

Planted RandomIds(Block* block, RandomStream* random) {
  const std::uint32_t pass = DrawPass(*block, random);
  std::vector<std::size_t> rows;
  EditLooks(block, pass, [&](std::size_t i) { rows.push_back(i); });
  for (std::size_t k = rows.size(); k > 1; --k) {
    SwapValues(rows[k - 1],
               rows[static_cast<std::size_t>(random->Uniform() * static_cast<double>(k))],
               &block->looks);
  }
  return {true, {}, {}, {}, ""};
}

Planted MirroredEast(Block* block, RandomStream*) {
  for (const KnownPosition& known : block->points.known) {
    block->points.given_m[known.point].x() *= -1.0;
  }
  return {!block->points.known.empty(), {}, {}, {}, ""};
}

}  // namespace

const std::vector<Plant>& Plants() {
  static const std::vector<Plant> plants = [] {
    std::vector<Plant> all{{"times of a pass late or early", ConstantTime},
                           {"times of all passes late or early", ConstantTimeOfAll},
                           {"times of a pass reversed", ReversedTimes},
                           {"times of a pass in ms or us", ScaledTimes},
                           {"a clock that drifts", DriftingClock},
                           {"seconds of the day at midnight", WrappedTimes},
                           {"time of one look", OneTime},
                           {"ranges of a pass two-way, km, us", ScaledRanges},
                           {"ranges of all two-way, km, us", ScaledRangesOfAll},
                           {"range bias of a pass", RangeBias},
                           {"range bias of all", RangeBiasOfAll},
                           {"range of one look", OneRange},
                           {"ground for slant range", GroundRanges},
                           {"wrong side of a pass", WrongSide},
                           {"squint or Doppler of the wrong sign", ConeSign},
                           {"squint in radians", ConeRadians},
                           {"squint left out", ConeLeftOut},
                           {"native Doppler read as zero", NativeDoppler},
                           {"an image coregistered to another", Coregistered},
                           {"wavelength in cm", Wavelength}};
    const std::vector<Plant> sigmas{{"sigmas 100 times too small", SigmasTooSmall},
                                    {"sigmas 100 times too large", SigmasTooLarge},
                                    {"azimuth sigma 1000 times off", AzimuthThousand},
                                    {"variances for sigmas", Variance}};
    const std::vector<Plant> has_trajectory_error{{"ranges of a pass wander", TimeCorrelatedRanges},
                                                  {"times of a pass wander", TimeCorrelatedTimes}};
    for (const std::vector<Plant>& some :
         {PathPlants(), ControlPlants(), IdPlants(), sigmas, has_trajectory_error}) {
      all.insert(all.end(), some.begin(), some.end());
    }
    return all;
  }();
  return plants;
}

const Plant& PlantNamed(const std::string& name) {
  for (const Plant& plant : Plants()) {
    if (plant.name == name) return plant;
  }
  throw InputError("plant", "none is called " + name);
}

const std::vector<Plant>& UnlistedErrors() {
  static const std::vector<Plant> plants{{"ids of a pass at random", RandomIds},
                                         {"control mirrored", MirroredEast}};
  return plants;
}

}  // namespace sarblock::test
