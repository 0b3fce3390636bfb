// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "dense.h"
#include "front_ranks.h"
#include "symbolic.h"

namespace sarblock {

/// What a Cholesky factorisation met.
struct FactorOutcome {
  bool positive_definite = false;
  int failed_row = -1;                ///< row of S (original order) whose pivot was not positive
  double smallest_pivot_ratio = 0.0;  ///< least pivot / diagonal element, 1 for a diagonal S
  int smallest_pivot_row = -1;
};

}  // namespace sarblock

namespace sarblock::sparse {

/// Which way the tree of fronts is walked.
enum class Walk {
  kUp,    ///< children before their parent
  kDown,  ///< a parent before its children
};

/// Calls work(f) once for every front of `some` (ascending), in the order that `walk` demands, on
/// the threads ThreadLimit allows; what they need from other fronts is there. Among the fronts that
/// are ready, the next in postorder (kUp) or in its reverse (kDown) goes first, so that the
/// matrices that wait are those of one thread and of one more branch of the tree for each further
/// thread. The result of `work` must not depend on what runs at the same time.
void ForFronts(const std::vector<Front>& fronts,
               const std::vector<std::size_t>& some,
               Walk walk,
               const std::function<void(std::size_t)>& work);

/// Calls work(0) ... work(count - 1) on idle threads, from within a front's work or outside one.
/// The caller takes up no other front while it waits for the last piece.
void ForPieces(std::size_t count, const std::function<void(std::size_t)>& work);

}  // namespace sarblock::sparse

namespace sarblock::dense {

// The kernels of large fronts cut into tiles that idle threads take up (fronts.h). The
// tiles depend on the sizes alone, so that every sum is formed in the same order on any number of
// threads. Conventions of dense.h; a matrix of one tile goes to those kernels whole.

/// Columns eliminated at a time within a front.
inline constexpr int kBlockColumns = 256;

/// The first `columns` columns of a, height x columns: the lower triangle of the top becomes L, the
/// rows below it b L'^-1. Returns the number of the first pivot that is not positive, from 1; 0 if
/// none (the columns before it are then not complete below the block of the pivot).
[[nodiscard]] int FactorPanel(int height, int columns, double* a, int lda);

/// Lower triangle of c -= a a', a n x k.
void SubtractSquareTiled(int n, int k, const double* a, int lda, double* c, int ldc);

/// One step of the selected inverse. z is height x height with the lower triangle of Z_RR in place
/// behind the first `columns`, and panel holds L_JJ and L_RJ: fills Z_RJ and the lower triangle of
/// Z_JJ, kBlockColumns at a time from the last to the first.
void InvertPanel(int height, int columns, const double* panel, double* z);

}  // namespace sarblock::dense

namespace sarblock {
class Ranks;
}

namespace sarblock::sparse {

/// One factorisation: every own front into its panel, its update matrix passed to its parent, which
/// may be on another rank.
class FrontFactorisation {
 public:
  /// `values` of S on every rank; `factor` has room for the own panels.
  FrontFactorisation(const OwnFronts& own, std::span<const double> values, double* factor);

  /// The same on every rank. Throws OtherRankFailed.
  [[nodiscard]] FactorOutcome Run();
  /// Doubles of this rank.
  [[nodiscard]] std::size_t most_waiting() const { return memory_.most_taken(); }

 private:
  /// The least pivot of a front, or the one that failed, with ratio 0.
  struct Pivot {
    double ratio = 1.0;
    std::int64_t row = -1;  // in elimination order
  };

  void Work(std::size_t f);
  void RecordPivots(std::size_t f,
                    const std::vector<double>& diagonal,
                    const double* panel,
                    int failed);
  /// Update matrices of a stage go to the ranks of their parents.
  void MoveUpdates(int stage, Ranks* ranks);
  /// The first failed front of all ranks becomes known to all.
  void ShareFailure(Ranks* ranks);
  void SharePivots(Ranks* ranks);
  [[nodiscard]] LowerTriangle Update(std::size_t f) const;

  const OwnFronts& own_;
  const std::vector<Front>& fronts_;
  std::span<const double> values_;
  double* factor_;
  FrontMemory memory_;
  std::vector<FrontMemory::Place> updates_;  // waiting for their parents; packed if they came
  std::vector<Pivot> pivots_;
  std::atomic<std::size_t> failed_front_;  // the first in postorder
};

/// The blocks of S^-1 on the pattern of S, to `values`, which all ranks have afterwards. `factor`
/// holds this rank's panels. Returns the most doubles that the fronts of this rank took at once.
/// Throws OtherRankFailed.
std::size_t InvertFronts(const OwnFronts& own, const double* factor, std::span<double> values);

}  // namespace sarblock::sparse
