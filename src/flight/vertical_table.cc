// SPDX-License-Identifier: Apache-2.0
#include "vertical_table.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>

namespace sarblock {
namespace {

/// More knots than this in one piece of a path are taken for a path that is no flight.
constexpr double kMostSteps = 1e6;

}  // namespace

VerticalTable::VerticalTable(const Frame& frame, const FlightPath& path) {
  if (frame.kind() == FrameKind::kLocal) return;
  pieces_.resize(path.piece_count());
  knots_.reserve(pieces_.size() + 1);
  const auto knot_at = [&](double time_s) {
    const Motion motion = *path.At(time_s);
    const VerticalMotion vertical =
        frame.VerticalAlong(motion.position_m, motion.velocity_mps, motion.acceleration_mps2);
    return Knot{vertical.up_1, vertical.rate};
  };
  // The vertical and its rate are continuous: the last knot of a piece is the first of the next.
  knots_.push_back(knot_at(path.start_s()));
  for (std::size_t k = 0; k < pieces_.size(); ++k) {
    const double start_s = path.PieceStart_s(k), length_s = path.PieceEnd_s(k) - start_s;
    const Knot last = knot_at(path.PieceEnd_s(k));
    const double turn_rad = length_s * std::max(knots_.back().rate.norm(), last.rate.norm());
    const double steps = std::ceil(turn_rad / kMostTurn_rad);
    if (!(steps <= kMostSteps)) {
      throw InputError("states", "the flight path turns around its body too fast to be tabulated");
    }
    Piece& piece = pieces_[k];
    piece.steps = static_cast<std::uint32_t>(std::max(1.0, steps));
    piece.start_s = start_s;
    piece.step_s = length_s / piece.steps;
    piece.first = static_cast<std::uint32_t>(knots_.size() - 1);
    for (std::uint32_t i = 1; i < piece.steps; ++i) {
      knots_.push_back(knot_at(start_s + i * piece.step_s));
    }
    knots_.push_back(last);
  }
}

VerticalMotion VerticalTable::At(std::size_t index, double time_s) const {
  if (pieces_.empty()) return {};
  const Piece& piece = pieces_[index];
  const double steps = (time_s - piece.start_s) / piece.step_s;
  const std::uint32_t k =
      steps > 0.0 ? std::min(piece.steps - 1, static_cast<std::uint32_t>(steps)) : 0U;
  const Knot& a = knots_[piece.first + k];
  const Knot& b = knots_[piece.first + k + 1];
  const double h = piece.step_s, x = (time_s - piece.start_s) - k * h, inverse = 1.0 / h;
  const Eigen::Vector3d mean = (b.up_1 - a.up_1) * inverse;
  const Eigen::Vector3d c2 = (3.0 * mean - 2.0 * a.rate - b.rate) * inverse;
  const Eigen::Vector3d c3 = (a.rate + b.rate - 2.0 * mean) * (inverse * inverse);
  VerticalMotion out;
  out.up_1 = a.up_1 + x * (a.rate + x * (c2 + x * c3));
  out.rate = a.rate + x * (2.0 * c2 + (3.0 * x) * c3);
  out.acceleration = 2.0 * c2 + (6.0 * x) * c3;
  return out;
}

}  // namespace sarblock
