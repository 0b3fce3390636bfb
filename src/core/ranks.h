// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace sarblock {

/// How the work of a rank ended: the program's exit code and, of an error, its words.
struct Ending {
  int exit_code = 0;
  std::string words;  ///< empty: no error

  [[nodiscard]] bool failed() const { return !words.empty(); }
};

/// Another rank failed: what this one computes is of no use any more.
class OtherRankFailed : public std::exception {
 public:
  explicit OtherRankFailed(Ending ending) : ending_(std::move(ending)) {}
  [[nodiscard]] const Ending& ending() const { return ending_; }
  [[nodiscard]] const char* what() const noexcept override { return ending_.words.c_str(); }

 private:
  Ending ending_;
};

/// Bytes made by one rank and sent to all ranks or to one other.
struct RankPart {
  static constexpr int kAllRanks = -1;
  std::byte* data = nullptr;  ///< null on a rank that neither makes nor gets them
  std::size_t bytes = 0;
  int rank = 0;        ///< that makes them
  int to = kAllRanks;  ///< that gets them; another one than `rank`
};

/// Adds a part for all ranks; one that continues the last in memory and is of the same rank becomes
/// part of it.
void AddPart(std::span<std::byte> bytes, int rank, std::vector<RankPart>* parts);

/// Processes that adjust one block together. Every rank holds the whole block and takes the same
/// decisions on the same numbers; what is work by point is divided (threads.h) and its
/// outcome shared, so that each rank holds the bytes of a process alone.
///
/// All ranks call Share, RequireSame, Agree and Conclude in one order, each from the one thread
/// that opened the RanksScope. A rank that fails on its own leaves that order: it comes with its
/// error to the next of these calls (Agree or Conclude), where the others learn of it.
class Ranks {
 public:
  virtual ~Ranks() = default;
  [[nodiscard]] virtual int rank() const = 0;
  [[nodiscard]] virtual int size() const = 0;
  [[nodiscard]] bool first() const { return rank() == 0; }

  /// Afterwards every rank holds the parts that it gets. All ranks name all parts in one order; a
  /// sequence of parts from one rank to another may be cut otherwise there, its bytes are the same.
  /// Throws OtherRankFailed.
  void Share(std::span<const RankPart> parts);
  /// Throws InputError on every rank if the bytes are not the same on all: processors that do not
  /// round alike. Throws OtherRankFailed.
  void RequireSame(std::span<const std::byte> bytes);
  /// The failure of the lowest rank that failed, the same on all ranks; none if no rank failed.
  /// `own`: the error of this rank, or null.
  [[nodiscard]] std::optional<Ending> Agree(const Ending* own);
  /// The last call: the failure that is known, else that of the lowest rank that failed, else the
  /// ending of the first rank.
  [[nodiscard]] Ending Conclude(const Ending& own);

 protected:
  /// Why a rank comes to a meeting.
  enum class Purpose : std::int32_t { kShare, kCompare, kAgree, kConclude };
  /// Note that ranks exchange whenever they meet.
  struct Note {
    Purpose purpose = Purpose::kShare;
    std::int32_t exit_code = 0;
    std::uint64_t words = 0;    ///< bytes of the words of a failure; 0: none
    std::uint64_t content = 0;  ///< bytes shared, or the fingerprint of what must be the same
  };
  /// The notes of all ranks, by rank. With `hasty` the others are waited for a few seconds only:
  /// then the failure of this rank ends all of them (`failure`), which does not return.
  [[nodiscard]] virtual std::vector<Note> Meet(const Note& own, const Ending* hasty) = 0;
  /// Brings every part to the ranks that get it.
  virtual void Exchange(std::span<const RankPart> parts) = 0;

 private:
  /// Meets, and takes the words of the lowest rank that failed, if the failure is new.
  std::vector<Note> Learn(Note own, const Ending* failure);

  std::optional<Ending> failure_;  // known to all ranks
};

/// The ranks among which this thread's divided loops are divided while it lives; null: none, as
/// without a scope. Loops inside a loop (threads.h) are not divided.
class RanksScope {
 public:
  explicit RanksScope(Ranks* ranks);
  ~RanksScope();
  RanksScope(const RanksScope&) = delete;
  RanksScope& operator=(const RanksScope&) = delete;

  /// The ranks of the innermost scope of this thread if there are two or more, else null.
  [[nodiscard]] static Ranks* Current();

 private:
  Ranks* outer_;
};

/// `own` of every rank one after the other, in the order of ranks. Throws OtherRankFailed.
template <typename T>
[[nodiscard]] std::vector<T> JoinedOfRanks(std::vector<T> own) {
  Ranks* const ranks = RanksScope::Current();
  if (ranks == nullptr) return own;
  const auto count = static_cast<std::size_t>(ranks->size());
  std::vector<std::size_t> sizes(count, own.size());
  std::vector<RankPart> parts;
  for (std::size_t r = 0; r < count; ++r) {
    AddPart(std::as_writable_bytes(std::span(&sizes[r], 1)), static_cast<int>(r), &parts);
  }
  ranks->Share(parts);
  std::size_t before = 0, all = 0;
  for (std::size_t r = 0; r < count; ++r) {
    if (static_cast<int>(r) < ranks->rank()) before += sizes[r];
    all += sizes[r];
  }
  std::vector<T> out(all);
  for (std::size_t i = 0; i < own.size(); ++i) out[before + i] = own[i];
  parts.clear();
  std::span<T> rest(out);
  for (std::size_t r = 0; r < count; ++r) {
    AddPart(std::as_writable_bytes(rest.first(sizes[r])), static_cast<int>(r), &parts);
    rest = rest.subspan(sizes[r]);
  }
  ranks->Share(parts);
  return out;
}

}  // namespace sarblock
