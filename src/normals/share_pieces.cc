// SPDX-License-Identifier: Apache-2.0
#include "share_pieces.h"

#include <cstdint>
#include <span>

#include "core/ranks.h"
#include "core/threads.h"

namespace sarblock {
namespace {

/// What the points of a piece made beside its partial sum.
void AddPointParts(const PointPieces& pieces,
                   const PointPiece& piece,
                   const PointEquations& equations,
                   int rank,
                   std::vector<RankPart>* parts) {
  std::vector<LookWeights>* const renewed = equations.weighting.renewed;
  Eigen::MatrixXd& border = *equations.border;
  if (renewed == nullptr && border.rows() == 0) return;
  const std::vector<std::uint64_t>& offsets = equations.problem.block.looks.offsets;
  for (std::size_t place = piece.begin; place < piece.end; ++place) {
    const std::size_t point = pieces.PointAt(place);
    if (renewed != nullptr) {
      const std::size_t begin = offsets[point], count = offsets[point + 1] - begin;
      AddPart(std::as_writable_bytes(std::span(*renewed).subspan(begin, count)), rank, parts);
    }
    const int row = equations.bordered.RowOf(point);
    if (row < 0) continue;
    for (Eigen::Index column = 0; column < border.cols(); ++column) {
      AddPart(std::as_writable_bytes(std::span(&border(row, column), 3)), rank, parts);
    }
  }
}

}  // namespace

std::vector<int> SharePieces(const PointPieces& pieces,
                             const BlockPattern& pattern,
                             const PointEquations& equations,
                             std::size_t first,
                             std::vector<PartialSum>* parts) {
  Ranks* const ranks = RanksScope::Current();
  std::vector<int> rank_of(parts->size(), 0);
  if (ranks == nullptr) return rank_of;
  std::vector<RankPart> sums, of_points;
  for (int r = 0; r < ranks->size(); ++r) {
    const PiecesOfRank its = PiecesOf(parts->size(), r, ranks->size());
    for (std::size_t k = its.first; k < its.last; ++k) {
      rank_of[k] = r;
      PartialSum& part = (*parts)[k];
      const PointPiece& piece = pieces[first + k];
      if (r != ranks->rank()) part.Take(piece, pattern);
      AddPart(std::as_writable_bytes(part.numbers()), r, &sums);
      AddPointParts(pieces, piece, equations, r, &of_points);
    }
  }
  ranks->Share(sums);
  if (!of_points.empty()) ranks->Share(of_points);
  return rank_of;
}

}  // namespace sarblock
