// SPDX-License-Identifier: Apache-2.0
#include "ranks.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <span>

#include "text.h"
#include <glog/logging.h>

namespace sarblock {
namespace {

thread_local Ranks* t_ranks = nullptr;

/// All come for the same: else the ranks took different decisions.
template <typename Notes>
void RequireOnePurpose(const Notes& notes) {
  for (const auto& note : notes) {
    CHECK(note.purpose == notes.front().purpose) << "the ranks of the job went different ways";
  }
}

/// The lowest rank that comes with a failure.
template <typename Notes>
int LowestFailed(const Notes& notes) {
  for (std::size_t r = 0; r < notes.size(); ++r) {
    if (notes[r].words > 0) return static_cast<int>(r);
  }
  return -1;
}

}  // namespace

void AddPart(std::span<std::byte> bytes, int rank, std::vector<RankPart>* parts) {
  if (bytes.empty()) return;
  if (!parts->empty()) {
    RankPart& last = parts->back();
    const bool to_all = last.rank == rank && last.to == RankPart::kAllRanks;
    if (to_all && last.data + last.bytes == bytes.data()) {
      last.bytes += bytes.size();
      return;
    }
  }
  parts->push_back({.data = bytes.data(), .bytes = bytes.size(), .rank = rank});
}

std::vector<Ranks::Note> Ranks::Learn(Note own, const Ending* failure) {
  if (failure != nullptr) {
    own.exit_code = failure->exit_code;
    own.words = failure->words.size();
  }
  std::vector<Note> notes = Meet(own, failure);
  const int failed = LowestFailed(notes);
  if (failed < 0) return notes;
  const Note& reported = notes[static_cast<std::size_t>(failed)];
  Ending known{reported.exit_code, std::string(reported.words, ' ')};
  if (failed == rank()) known.words = failure->words;
  const auto bytes = std::as_writable_bytes(std::span(known.words.data(), known.words.size()));
  Exchange(std::vector<RankPart>{{.data = bytes.data(), .bytes = bytes.size(), .rank = failed}});
  failure_ = std::move(known);
  return notes;
}

void Ranks::Share(std::span<const RankPart> parts) {
  std::size_t bytes = 0;
  for (const RankPart& part : parts) bytes += part.bytes;
  const std::vector<Note> notes = Learn({.purpose = Purpose::kShare, .content = bytes}, nullptr);
  if (failure_) throw OtherRankFailed(*failure_);
  RequireOnePurpose(notes);
  for (const Note& note : notes) {
    if (note.content != bytes)
      throw std::logic_error("the ranks of the job share different arrays");
  }
  Exchange(parts);
}

void Ranks::RequireSame(std::span<const std::byte> bytes) {
  const std::uint64_t fingerprint = Fnv1a(bytes);
  const std::vector<Note> notes =
      Learn({.purpose = Purpose::kCompare, .content = fingerprint}, nullptr);
  if (failure_) throw OtherRankFailed(*failure_);
  RequireOnePurpose(notes);
  for (const Note& note : notes) {
    if (note.content == notes.front().content) continue;
    throw InputError(
        FilePlace{},
        "the ranks of the job computed different numbers from the same ones: their "
        "processors or libraries do not round alike; machines of one kind are allowed");
  }
}

std::optional<Ending> Ranks::Agree(const Ending* own) {
  if (failure_) return failure_;
  const std::vector<Note> notes = Learn({.purpose = Purpose::kAgree}, own);
  if (!failure_) RequireOnePurpose(notes);
  return failure_;
}

Ending Ranks::Conclude(const Ending& own) {
  const Note note{.purpose = Purpose::kConclude, .exit_code = own.exit_code};
  while (true) {
    const bool news = own.failed() && !failure_;
    const std::vector<Note> notes = Learn(note, news ? &own : nullptr);
    const bool all = std::all_of(notes.begin(), notes.end(), [](const Note& one) {
      return one.purpose == Purpose::kConclude;
    });
    if (!all && !failure_) RequireOnePurpose(notes);
    if (!all) continue;  // the others learned of a failure and are on their way
    return failure_ ? *failure_ : Ending{notes.front().exit_code, {}};
  }
}

RanksScope::RanksScope(Ranks* ranks) : outer_(std::exchange(t_ranks, ranks)) {}
RanksScope::~RanksScope() { t_ranks = outer_; }

Ranks* RanksScope::Current() {
  return t_ranks != nullptr && t_ranks->size() > 1 ? t_ranks : nullptr;
}

}  // namespace sarblock
