// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace sarblock {

/// What an adjustment takes of a computer, predicted from the block and the pattern of its reduced
/// normal matrix S (docs/theory/covariance.md) before anything of that is allocated. Memory in
/// bytes, of 8 a number; work in operations, a product and its sum. Fronts are those of one thread;
/// each further one may keep a branch of the elimination tree more.
struct ResourceNeeds {
  std::uint64_t looks_bytes = 0;   ///< looks, their weights and what a result says of them
  std::uint64_t points_bytes = 0;  ///< points, their state and what a result says of them
  std::uint64_t block_bytes = 0;   ///< of both, memory that a block takes as it was read
  /// Of both, arrays large enough for scratch files (src/core/memory.h) ...
  std::uint64_t large_bytes = 0;
  std::uint64_t scratch_bytes = 0;  ///< ... and the part of these in scratch files, not in memory
  std::uint64_t matrix_bytes = 0;   ///< S, as formed and scaled
  std::uint64_t partial_sums_bytes = 0;  ///< of S while it is formed
  std::uint64_t factor_bytes = 0;        ///< L of S = L L'
  std::uint64_t fronts_bytes = 0;        ///< while it is formed, update matrices that wait
  std::uint64_t inverse_bytes = 0;       ///< S^-1 on the pattern of S and the fronts it comes from
  double sum_operations = 0.0;           ///< of one sum of S
  double factor_operations = 0.0;        ///< of one factor
  /// The most memory at one time: looks and points always, less scratch files, with S in turn its
  /// partial sums, its factor and its inverse.
  std::uint64_t peak_bytes = 0;
};

/// In words, on one line: "memory 41 MiB (looks 12, ...); operations: S 3.1e+07, factor 2.2e+05";
/// with scratch files "memory 29 MiB, 12 MiB in scratch files (looks 12, ...)".
[[nodiscard]] std::string DescribeNeeds(const ResourceNeeds& needs);

}  // namespace sarblock
