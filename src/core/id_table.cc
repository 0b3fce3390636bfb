// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/id_table.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace sarblock {
namespace {

// FNV-1a over the bytes, then the finaliser of SplitMix64: without it the low bits of ids that
// differ in their last digit only would fill neighbouring slots.
std::uint64_t Hash(std::string_view id) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char c : id) {
    hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  }
  hash = (hash ^ (hash >> 30)) * 0xbf58476d1ce4e5b9u;
  hash = (hash ^ (hash >> 27)) * 0x94d049bb133111ebu;
  return hash ^ (hash >> 31);
}

char Lower(char c) { return 'A' <= c && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

// Levenshtein distance without regard to ASCII case; `bound` as soon as it cannot be less.
std::size_t EditDistance(std::string_view a,
                         std::string_view b,
                         std::size_t bound,
                         std::vector<std::size_t>* row) {
  const std::size_t gap = std::max(a.size(), b.size()) - std::min(a.size(), b.size());
  if (gap >= bound) return bound;
  row->resize(b.size() + 1);
  std::iota(row->begin(), row->end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = (*row)[0];
    (*row)[0] = i;
    std::size_t least = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = (*row)[j];
      const std::size_t changed = diagonal + (Lower(a[i - 1]) == Lower(b[j - 1]) ? 0 : 1);
      (*row)[j] = std::min({above + 1, (*row)[j - 1] + 1, changed});
      diagonal = above;
      least = std::min(least, (*row)[j]);
    }
    if (least >= bound) return bound;  // distances never shrink from one row to the next
  }
  return std::min(row->back(), bound);
}

// Index of the candidate nearest to `id` among the first `count`, closer than `bound`; or `count`.
template <typename Candidate>
std::size_t NearestIndex(std::string_view id,
                         std::size_t count,
                         std::size_t bound,
                         const Candidate& candidate) {
  std::vector<std::size_t> row;
  std::size_t best = count;
  for (std::size_t i = 0; i < count && bound > 0; ++i) {
    // As many edits as the longer one has letters: they have nothing in common.
    const std::size_t apart = std::max(id.size(), std::string_view(candidate(i)).size());
    const std::size_t least = std::min(bound, apart);
    const std::size_t distance = EditDistance(id, candidate(i), least, &row);
    if (distance == least) continue;
    if (distance < bound) {
      bound = distance;
      best = i;
    }
  }
  return best;
}

constexpr std::size_t kNoBound = std::numeric_limits<std::size_t>::max();

}  // namespace

std::uint32_t IdTable::Append(std::string_view id) {
  ascending_ = ascending_ && OrderToLast(id) > 0;
  return AppendInOrder(id);
}

std::uint32_t IdTable::AppendInOrder(std::string_view id) {
  const std::size_t end = text_.size() + id.size();
  if (end >= kNone || size() + 1 >= kNone) {
    throw InputError("ids", "more than 4 GB of ids in one table");
  }
  const auto index = static_cast<std::uint32_t>(size());
  text_.append(id);
  begin_.push_back(static_cast<std::uint32_t>(end));
  if (Slots* const slots = index_.get()) {
    if (2 * size() > slots->size()) {
      *slots = MakeIndex();
    } else {
      const std::size_t slot = SlotOf((*this)[index], *slots);
      if ((*slots)[slot] == kNone) (*slots)[slot] = index;  // else a duplicate: the first one stays
    }
  }
  return index;
}

int IdTable::OrderToLast(std::string_view id) const {
  if (size() == 0) return 1;
  const std::string_view last = (*this)[size() - 1];
  if (id.empty() || last.empty()) return id.size() == last.size() ? 0 : -1;
  if (id.front() != last.front()) return id.front() > last.front() ? 1 : -1;
  if (id.size() != last.size()) return id.size() > last.size() ? 1 : -1;
  return id.compare(last);
}

std::uint32_t IdTable::FindOrAppend(std::string_view id) {
  if (index_.get() == nullptr && ascending_) {
    const int order = OrderToLast(id);
    if (order == 0) return static_cast<std::uint32_t>(size() - 1);
    if (order > 0) return AppendInOrder(id);
  }
  const std::uint32_t found = Find(id);
  return found != kNone ? found : Append(id);
}

std::uint32_t IdTable::Find(std::string_view id) const {
  const Slots* slots = index_.get();
  if (slots == nullptr) slots = index_.Offer(MakeIndex());
  return (*slots)[SlotOf(id, *slots)];
}

std::size_t IdTable::SlotOf(std::string_view id, const Slots& slots) const {
  const std::size_t mask = slots.size() - 1;
  std::size_t slot = Hash(id) & mask;
  while (slots[slot] != kNone && (*this)[slots[slot]] != id) slot = (slot + 1) & mask;
  return slot;
}

// A power of two of slots, a quarter to a half of them filled, so that the next rebuild comes after
// as many appends as there are ids: the work per append is bounded on average.
IdTable::Slots IdTable::MakeIndex() const {
  std::size_t count = 16;
  while (count < 2 * size() + 1) count *= 2;
  Slots slots(count, kNone);
  for (std::size_t i = 0; i < size(); ++i) {
    const std::size_t slot = SlotOf((*this)[i], slots);
    if (slots[slot] == kNone) slots[slot] = static_cast<std::uint32_t>(i);
  }
  return slots;
}

std::string IdTable::Nearest(std::string_view id) const {
  constexpr std::size_t kSearchedWholly = 2000;    // any distance
  constexpr std::size_t kSearchedNearby = 200000;  // at most three edits: a slip of the finger
  const auto candidate = [this](std::size_t i) { return (*this)[i]; };
  if (size() > kSearchedWholly) {
    const std::size_t count = std::min(size(), kSearchedNearby);
    const std::size_t nearby = NearestIndex(id, count, 4, candidate);
    if (nearby < count) return std::string((*this)[nearby]);
  }
  const std::size_t count = std::min(size(), kSearchedWholly);
  const std::size_t nearest = NearestIndex(id, count, kNoBound, candidate);
  return nearest < count ? std::string((*this)[nearest]) : std::string();
}

void IdTable::DropIndex() { index_.Set(nullptr); }

std::string NearestName(std::string_view name, const std::vector<std::string>& allowed) {
  const auto candidate = [&allowed](std::size_t i) { return std::string_view(allowed[i]); };
  const std::size_t nearest = NearestIndex(name, allowed.size(), kNoBound, candidate);
  return nearest < allowed.size() ? allowed[nearest] : std::string();
}

std::string DidYouMean(const std::string& nearest) {
  return nearest.empty() ? "" : "; did you mean " + nearest + "?";
}

}  // namespace sarblock
