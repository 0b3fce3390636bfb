// SPDX-License-Identifier: Apache-2.0
#include "front_ranks.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "dense.h"
#include <glog/logging.h>

namespace sarblock::sparse {
namespace {

/// Splits of a subtree that are tried, for each rank.
constexpr std::size_t kSplitsPerRank = 8;

/// Operations of the factor: sum of h^2 over the columns.
double Operations(const Front& front) {
  double sum = 0.0;
  for (int c = 0; c < front.eliminated; ++c) {
    const auto height = static_cast<double>(front.height() - c);
    sum += height * height;
  }
  return sum;
}

/// Stages from the owners.
void SetStages(const std::vector<Front>& fronts, FrontDivision* division) {
  std::vector<int>& stage = division->stage;
  stage.assign(fronts.size(), 0);
  for (std::size_t f = 0; f < fronts.size(); ++f) {
    for (const int child : fronts[f].children) {
      const int after = division->Crosses(fronts[At(child)], At(child)) ? 1 : 0;
      stage[f] = std::max(stage[f], stage[At(child)] + after);
    }
    division->stages = std::max(division->stages, stage[f] + 1);
  }
}

/// The fronts of one rank, or of all.
StageLists GroupByStage(const FrontDivision& division, int rank = -1) {
  StageLists lists(At(division.stages));
  for (std::size_t f = 0; f < division.stage.size(); ++f) {
    if (rank < 0 || division.owner[f] == rank) lists[At(division.stage[f])].push_back(f);
  }
  return lists;
}

class Divider {
 public:
  Divider(const std::vector<Front>& fronts, int ranks)
      : fronts_(fronts), ranks_(ranks), own_(fronts.size()), below_(fronts.size()) {
    for (std::size_t f = 0; f < fronts.size(); ++f) {
      own_[f] = Operations(fronts[f]);
      below_[f] += own_[f];
      all_ += own_[f];
      if (fronts[f].parent >= 0) below_[At(fronts[f].parent)] += below_[f];
    }
  }

  [[nodiscard]] FrontDivision Best() const {
    std::vector<std::size_t> subtrees;
    for (std::size_t f = 0; f < fronts_.size(); ++f) {
      if (fronts_[f].parent < 0) subtrees.push_back(f);
    }
    const auto larger = [this](std::size_t a, std::size_t b) {
      return below_[a] != below_[b] ? below_[a] > below_[b] : a < b;
    };
    FrontDivision alone;
    alone.owner.assign(fronts_.size(), 0);
    SetStages(fronts_, &alone);
    const auto alone_doubles = static_cast<double>(MaxDoubles(NeedsOfRanks(fronts_, alone)[0]));
    FrontDivision best;
    double least = 0.0;
    std::vector<bool> split(fronts_.size(), false);
    for (std::size_t k = 0; k <= kSplitsPerRank * At(ranks_) && !subtrees.empty(); ++k) {
      std::sort(subtrees.begin(), subtrees.end(), larger);
      FrontDivision division = Assign(subtrees, split);
      const double cost = Slowest(division) / std::max(1.0, all_) +
                          Largest(division) / std::max(1.0, alone_doubles);
      if (k == 0 || cost < least) {
        least = cost;
        best = std::move(division);
      }
      const std::size_t top = subtrees.front();
      if (fronts_[top].children.empty()) break;
      subtrees.erase(subtrees.begin());
      split[top] = true;
      for (const int child : fronts_[top].children) subtrees.push_back(At(child));
    }
    return best;
  }

 private:
  [[nodiscard]] FrontDivision Assign(const std::vector<std::size_t>& subtrees,
                                     const std::vector<bool>& split) const {
    FrontDivision division;
    division.ranks = ranks_;
    division.owner.assign(fronts_.size(), -1);
    std::vector<double> load(At(ranks_), 0.0);
    for (const std::size_t top : subtrees) {
      const auto least = std::min_element(load.begin(), load.end());
      division.owner[top] = static_cast<int>(least - load.begin());
      *least += below_[top];
    }
    for (std::size_t f = 0; f < fronts_.size(); ++f) {
      if (!split[f]) continue;
      int rank = -1;
      for (const int child : fronts_[f].children) {
        const int its = division.owner[At(child)];
        if (rank < 0 || load[At(its)] < load[At(rank)]) rank = its;
      }
      division.owner[f] = rank;
      load[At(rank)] += own_[f];
    }
    for (std::size_t f = fronts_.size(); f-- > 0;) {  // within the subtrees
      if (division.owner[f] < 0) division.owner[f] = division.owner[At(fronts_[f].parent)];
    }
    SetStages(fronts_, &division);
    return division;
  }

  /// Operations of the slowest rank of each stage.
  [[nodiscard]] double Slowest(const FrontDivision& division) const {
    std::vector<double> work(At(division.stages) * At(ranks_), 0.0);
    for (std::size_t f = 0; f < fronts_.size(); ++f) {
      work[At(division.stage[f]) * At(ranks_) + At(division.owner[f])] += own_[f];
    }
    double sum = 0.0;
    for (auto of_stage = work.begin(); of_stage != work.end(); of_stage += ranks_) {
      sum += *std::max_element(of_stage, of_stage + ranks_);
    }
    return sum;
  }

  [[nodiscard]] double Largest(const FrontDivision& division) const {
    std::size_t most = 0;
    for (const FactorNeeds& needs : NeedsOfRanks(fronts_, division)) {
      most = std::max(most, MaxDoubles(needs));
    }
    return static_cast<double>(most);
  }

  const std::vector<Front>& fronts_;
  int ranks_;
  std::vector<double> own_, below_;  // operations of a front, of its subtree
  double all_ = 0.0;
};

/// Doubles in the memory of each rank, and their maximum so far.
class Held {
 public:
  explicit Held(int ranks) : held_(At(ranks), 0), most_(At(ranks), 0) {}
  void Take(int rank, std::size_t count) {
    held_[At(rank)] += FrontMemory::Rounded(count);
    most_[At(rank)] = std::max(most_[At(rank)], held_[At(rank)]);
  }
  void Give(int rank, std::size_t count) { held_[At(rank)] -= FrontMemory::Rounded(count); }
  [[nodiscard]] std::size_t most(std::size_t rank) const { return most_[rank]; }

 private:
  std::vector<std::size_t> held_, most_;
};

Held WaitingOfRanks(const std::vector<Front>& fronts, const FrontDivision& division) {
  Held held(division.ranks);
  for (const auto& stage : GroupByStage(division)) {
    for (const std::size_t f : stage) {
      const Front& front = fronts[f];
      const int rank = division.owner[f];
      held.Take(rank, Square(front.remaining));
      for (const int child : front.children) {
        const int rows = fronts[At(child)].remaining;
        const bool packed = division.Crosses(fronts[At(child)], At(child));
        held.Give(rank, packed ? PackedSize(rows) : Square(rows));
      }
      if (front.parent < 0) held.Give(rank, Square(front.remaining));
    }
    for (const std::size_t f : stage) {
      if (!division.Crosses(fronts[f], f)) continue;
      held.Take(division.owner[At(fronts[f].parent)], PackedSize(fronts[f].remaining));
    }
    for (const std::size_t f : stage) {
      if (division.Crosses(fronts[f], f)) held.Give(division.owner[f], Square(fronts[f].remaining));
    }
  }
  return held;
}

Held InverseOfRanks(const std::vector<Front>& fronts, const FrontDivision& division) {
  Held held(division.ranks);
  std::vector<std::size_t> unread(fronts.size(), 0);
  for (std::size_t f = 0; f < fronts.size(); ++f) {
    if (fronts[f].parent >= 0 && !division.Crosses(fronts[f], f)) ++unread[At(fronts[f].parent)];
  }
  const StageLists stages = GroupByStage(division);
  for (auto stage = stages.rbegin(); stage != stages.rend(); ++stage) {
    for (auto at = stage->rbegin(); at != stage->rend(); ++at) {
      const Front& front = fronts[*at];
      const int rank = division.owner[*at];
      held.Take(rank, Square(front.height()));
      if (division.Crosses(front, *at)) {
        held.Give(rank, PackedSize(front.remaining));
      } else if (front.parent >= 0 && --unread[At(front.parent)] == 0) {
        held.Give(rank, Square(fronts[At(front.parent)].height()));
      }
      for (const int child : front.children) {
        if (division.Crosses(fronts[At(child)], At(child))) {
          held.Take(rank, PackedSize(fronts[At(child)].remaining));
        }
      }
      if (unread[*at] == 0) held.Give(rank, Square(front.height()));
    }
    const auto for_crossing = [&](const auto& visit) {
      for (const std::size_t f : *stage) {
        for (const int child : fronts[f].children) {
          if (division.Crosses(fronts[At(child)], At(child))) visit(f, At(child));
        }
      }
    };
    for_crossing([&](std::size_t, std::size_t child) {
      held.Take(division.owner[child], PackedSize(fronts[child].remaining));
    });
    for_crossing([&](std::size_t f, std::size_t child) {
      held.Give(division.owner[f], PackedSize(fronts[child].remaining));
    });
  }
  return held;
}

}  // namespace

FrontDivision DivideFronts(const std::vector<Front>& fronts, int ranks) {
  FrontDivision division;
  if (ranks > 1 && !fronts.empty()) return Divider(fronts, ranks).Best();
  division.owner.assign(fronts.size(), 0);
  SetStages(fronts, &division);
  return division;
}

std::vector<FactorNeeds> NeedsOfRanks(const std::vector<Front>& fronts,
                                      const FrontDivision& division) {
  std::vector<FactorNeeds> needs(At(division.ranks));
  for (std::size_t f = 0; f < fronts.size(); ++f) {
    needs[At(division.owner[f])].factor += At(fronts[f].height()) * At(fronts[f].eliminated);
  }
  const Held waiting = WaitingOfRanks(fronts, division);
  const Held inverse = InverseOfRanks(fronts, division);
  for (std::size_t rank = 0; rank < needs.size(); ++rank) {
    needs[rank].waiting = waiting.most(rank);
    needs[rank].inverse_fronts = inverse.most(rank);
  }
  return needs;
}

std::size_t MaxDoubles(const FactorNeeds& needs) {
  return needs.factor + std::max(needs.waiting, needs.inverse_fronts);
}

OwnFronts::OwnFronts(Symbolic of, FrontDivision divided, int own_rank)
    : symbolic(std::move(of)), division(std::move(divided)), rank(own_rank) {
  stages = GroupByStage(division, rank);
  panel.assign(symbolic.fronts.size(), 0);
  for (std::size_t f = 0; f < symbolic.fronts.size(); ++f) {
    if (!Owns(f)) continue;
    panel[f] = panel_entries;
    panel_entries += At(symbolic.fronts[f].height()) * At(symbolic.fronts[f].eliminated);
  }
}

Ranks* RanksOf(const OwnFronts& own) {
  if (!own.divided()) return nullptr;
  Ranks* const ranks = RanksScope::Current();
  CHECK(ranks != nullptr && ranks->size() == own.division.ranks && ranks->rank() == own.rank)
      << "a factor that stands on several ranks is used without them";
  return ranks;
}

void FrontMoves::Add(double* place, std::size_t count, int from, int to) {
  if (count == 0) return;
  const bool here = own_.rank == from || own_.rank == to;
  parts_->push_back({.data = here ? reinterpret_cast<std::byte*>(place) : nullptr,
                     .bytes = count * sizeof(double),
                     .rank = from,
                     .to = to});
}

void FrontMoves::AddTriangle(double* from_place, double* to_place, int rows, int from, int to) {
  if (own_.rank != from) {
    Add(to_place, PackedSize(rows), from, to);
    return;
  }
  for (int c = 0; c < rows; ++c) {
    Add(from_place + At(c) * At(rows) + At(c), At(rows - c), from, to);
  }
}

}  // namespace sarblock::sparse
