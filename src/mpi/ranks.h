// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/ranks.h"

namespace sarblock::mpi {

/// The processes of MPI_COMM_WORLD, between MPI_Init_thread and MPI_Finalize. MPI is called by the
/// thread that calls these functions and by no other (MPI_THREAD_FUNNELED). A rank that waits for
/// others sleeps, so that ranks which share cores leave them to those that compute.
class MpiRanks final : public Ranks {
 public:
  MpiRanks();
  [[nodiscard]] int rank() const override { return rank_; }
  [[nodiscard]] int size() const override { return size_; }
  /// Cores that this rank may use without taking them from others on its machine, at least 1: those
  /// it is bound to, divided by the ranks that are bound to any of them.
  [[nodiscard]] int cores() const { return cores_; }

 protected:
  /// A rank that failed waits `kPatience` for the others, prints its error and ends the job.
  [[nodiscard]] std::vector<Note> Meet(const Note& own, const Ending* hasty) override;
  void Exchange(std::span<const RankPart> parts) override;

 private:
  int rank_ = 0, size_ = 1, cores_ = 1;
};

}  // namespace sarblock::mpi
