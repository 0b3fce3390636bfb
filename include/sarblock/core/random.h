// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace sarblock {

/// A reproducible stream of random numbers: same (seed, stream) gives the same numbers on every
/// machine, compiler and thread count. One stream per thing that is random (a pass, a point, a
/// look), so that work may be shared among threads without changing a number.
/// Generator: SplitMix64 seeding of xoshiro256++ (Blackman and Vigna, 2019); normals by the
/// inverse distribution function, one uniform each.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t stream);
  [[nodiscard]] std::uint64_t Bits();
  [[nodiscard]] double Uniform();  ///< in the open interval (0, 1)
  [[nodiscard]] double Normal();   ///< mean 0, standard deviation 1

 private:
  std::uint64_t state_[4];
};

/// Mixes numbers (for example a kind and an index) into one stream number.
[[nodiscard]] std::uint64_t MixStream(std::uint64_t a, std::uint64_t b);

}  // namespace sarblock
