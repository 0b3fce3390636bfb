// SPDX-License-Identifier: Apache-2.0
#include "ranks.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <optional>
#include <thread>
#include <utility>

#include "cli/session.h"
#include "core/threads.h"
#include <mpi.h>
#include <sched.h>

namespace sarblock::mpi {
namespace {

using Clock = std::chrono::steady_clock;

/// How long a rank that failed waits for others, which may be in the middle of a long loop.
constexpr std::chrono::seconds kPatience(5);
/// A rank that waits asks again at once so long, then after pauses.
constexpr std::chrono::milliseconds kAwake(1);
constexpr std::chrono::microseconds kPause(200);
/// Bytes of one block of a message: MPI counts them by int.
constexpr std::size_t kMaxPartOfBlock = std::size_t{1} << 30;

bool Done(std::vector<MPI_Request>* requests) {
  int done = 0;
  MPI_Testall(static_cast<int>(requests->size()), requests->data(), &done, MPI_STATUSES_IGNORE);
  return done != 0;
}

/// Waits for the other ranks, `until` at most; false where they did not come.
bool WaitForRanks(std::vector<MPI_Request>* requests, std::optional<Clock::time_point> until) {
  const Clock::time_point begin = Clock::now();
  for (;;) {
    if (Done(requests)) return true;
    const Clock::time_point now = Clock::now();
    if (until && now > *until) return false;
    if (now - begin > kAwake) {
      std::this_thread::sleep_for(kPause);
    } else {
      std::this_thread::yield();
    }
  }
}

/// Bytes of several places as one message.
class Message {
 public:
  void Add(const RankPart& part) {
    for (std::size_t at = 0; at < part.bytes; at += kMaxPartOfBlock) {
      sizes_.push_back(static_cast<int>(std::min(kMaxPartOfBlock, part.bytes - at)));
      MPI_Get_address(part.data + at, &places_.emplace_back());
    }
  }
  [[nodiscard]] MPI_Datatype Type() const {
    MPI_Datatype type = MPI_DATATYPE_NULL;
    MPI_Type_create_hindexed(
        static_cast<int>(sizes_.size()), sizes_.data(), places_.data(), MPI_BYTE, &type);
    MPI_Type_commit(&type);
    return type;
  }

 private:
  std::vector<int> sizes_;
  std::vector<MPI_Aint> places_;
};

/// Cores of this process, divided by the ranks of this machine that may use any of them.
int CoresOfRank() {
  MPI_Comm machine = MPI_COMM_NULL;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  int ranks = 1;
  MPI_Comm_size(machine, &ranks);
  cpu_set_t own;
  CPU_ZERO(&own);
  sched_getaffinity(0, sizeof(own), &own);
  std::vector<cpu_set_t> all(static_cast<std::size_t>(ranks));
  constexpr int kBytes = static_cast<int>(sizeof(cpu_set_t));
  MPI_Allgather(&own, kBytes, MPI_BYTE, all.data(), kBytes, MPI_BYTE, machine);
  MPI_Comm_free(&machine);
  const auto sharing = std::count_if(all.begin(), all.end(), [&](const cpu_set_t& other) {
    cpu_set_t common;
    CPU_AND(&common, &own, &other);
    return CPU_COUNT(&common) > 0;
  });
  return std::max(1, AvailableCores() / std::max(1, static_cast<int>(sharing)));
}

}  // namespace

MpiRanks::MpiRanks() {
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &size_);
  cores_ = CoresOfRank();
}

std::vector<Ranks::Note> MpiRanks::Meet(const Note& own, const Ending* hasty) {
  std::vector<Note> notes(static_cast<std::size_t>(size_));
  constexpr int kBytes = static_cast<int>(sizeof(Note));
  std::vector<MPI_Request> requests(1, MPI_REQUEST_NULL);
  MPI_Iallgather(
      &own, kBytes, MPI_BYTE, notes.data(), kBytes, MPI_BYTE, MPI_COMM_WORLD, requests.data());
  std::optional<Clock::time_point> until;
  if (hasty != nullptr) until = Clock::now() + kPatience;
  if (!WaitForRanks(&requests, until)) {
    cli::PrintError("sarblock: " + hasty->words);
    MPI_Abort(MPI_COMM_WORLD, hasty->exit_code);
  }
  return notes;
}

void MpiRanks::Exchange(std::span<const RankPart> parts) {
  // By who makes and who gets them, in one order on all ranks: two messages of a rank to another,
  // one for all and one for it alone, arrive as they were sent.
  std::map<std::pair<int, int>, Message> messages;
  for (const RankPart& part : parts) {
    const bool gets = part.to == RankPart::kAllRanks || part.to == rank_;
    if (part.bytes > 0 && (gets || part.rank == rank_)) messages[{part.rank, part.to}].Add(part);
  }
  std::vector<MPI_Request> requests;
  std::vector<MPI_Datatype> types;
  constexpr int kTag = 0;
  for (const auto& [ends, message] : messages) {
    const auto [from, receiver] = ends;
    const MPI_Datatype type = types.emplace_back(message.Type());
    if (from != rank_) {
      MPI_Irecv(MPI_BOTTOM, 1, type, from, kTag, MPI_COMM_WORLD, &requests.emplace_back());
      continue;
    }
    for (int to = 0; to < size_; ++to) {
      if (to == rank_ || (receiver != RankPart::kAllRanks && receiver != to)) continue;
      MPI_Isend(MPI_BOTTOM, 1, type, to, kTag, MPI_COMM_WORLD, &requests.emplace_back());
    }
  }
  // All ranks are here, and bytes move only where somebody asks for them.
  while (!Done(&requests)) std::this_thread::yield();
  for (MPI_Datatype& type : types) MPI_Type_free(&type);
}

}  // namespace sarblock::mpi
