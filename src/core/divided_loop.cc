// SPDX-License-Identifier: Apache-2.0
#include "divided_loop.h"

#include <algorithm>

#include "parallel.h"

namespace sarblock {

PiecesOfRank PiecesOf(std::size_t count, int rank, int ranks) {
  const auto r = static_cast<std::size_t>(rank), n = static_cast<std::size_t>(ranks);
  const auto begin = [&](std::size_t k) { return count / n * k + count % n * k / n; };
  return {begin(r), begin(r + 1)};
}

std::span<std::byte> SharedArray::Bytes(std::size_t begin,
                                        std::size_t end,
                                        const PiecesOfRank& chunks) const {
  const auto elements = [this](std::size_t from, std::size_t to) {
    return bytes_.subspan(from * element_bytes_, (to - from) * element_bytes_);
  };
  if (bytes_.empty()) return {};
  switch (kind_) {
    case Kind::kChunk:
      return elements(chunks.first, chunks.last);
    case Kind::kRange:
      return elements(offsets_[begin], offsets_[end]);
    case Kind::kItem:
      break;
  }
  return elements(begin, end);
}

void ForChunksOfRanks(std::size_t count,
                      std::size_t chunk_size,
                      std::initializer_list<SharedArray> arrays,
                      const std::function<void(std::size_t, std::size_t, std::size_t)>& work) {
  Ranks* const ranks = RanksScope::Current();
  if (ranks == nullptr) {
    ParallelForChunks(count, chunk_size, work);
    return;
  }
  const std::size_t chunks = (count + chunk_size - 1) / chunk_size;
  const auto item = [&](std::size_t chunk) { return std::min(count, chunk * chunk_size); };
  const PiecesOfRank own = PiecesOf(chunks, ranks->rank(), ranks->size());
  const std::size_t before = item(own.first);
  ParallelForChunks(item(own.last) - before,
                    chunk_size,
                    [&](std::size_t chunk, std::size_t begin, std::size_t end) {
                      work(own.first + chunk, before + begin, before + end);
                    });
  std::vector<RankPart> parts;
  for (const SharedArray& array : arrays) {
    for (int r = 0; r < ranks->size(); ++r) {
      const PiecesOfRank its = PiecesOf(chunks, r, ranks->size());
      AddPart(array.Bytes(item(its.first), item(its.last), its), r, &parts);
    }
  }
  ranks->Share(parts);
}

int ThreadsOfRanks() {
  int sum = 0;
  for (const int threads : JoinedOfRanks(std::vector<int>{ThreadsAllowed()})) sum += threads;
  return sum;
}

}  // namespace sarblock
