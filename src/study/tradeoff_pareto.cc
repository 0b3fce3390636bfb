// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "study/tradeoff.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

double Position(const TradeoffRow& row) {
  return std::max(row.errors.position_error_1, kSamePosition_1);
}

double Covariance(const TradeoffRow& row) {
  const bool whole =
      std::isfinite(row.errors.covariance_error_1) && row.errors.points_unjudged == 0;
  return whole ? std::max(row.errors.covariance_error_1, kSameCovariance_1)
               : std::numeric_limits<double>::infinity();
}

bool Competes(const TradeoffRow& row) {
  return row.accepted && row.errors.points_missing == 0 && std::isfinite(row.speed_ratio_1) &&
         std::isfinite(row.errors.position_error_1);
}

bool Faster(const TradeoffRow& a, const TradeoffRow& b) {
  return a.speed_ratio_1 > (1.0 + kSameSpeed_1) * b.speed_ratio_1;
}

bool Beats(const TradeoffRow& a, const TradeoffRow& b) {
  if (Faster(b, a) || Position(a) > Position(b) || Covariance(a) > Covariance(b)) return false;
  return Faster(a, b) || Position(a) < Position(b) || Covariance(a) < Covariance(b);
}

/// The fastest row of a stage that is on the Pareto set and good enough; the reference among
/// equals.
const TradeoffRow* Fastest(const std::vector<TradeoffRow>& rows,
                           TradeoffStage stage,
                           std::size_t points,
                           const TradeoffGoal& goal) {
  const TradeoffRow* best = nullptr;
  for (const TradeoffRow& row : rows) {
    if (row.stage != stage || row.points != points || !row.pareto) continue;
    if (Position(row) > goal.position_1 || Covariance(row) > goal.covariance_1) continue;
    if (best == nullptr || Faster(row, *best) || (row.reference && !Faster(*best, row))) {
      best = &row;
    }
  }
  return best;
}

const TradeoffRow* Named(const std::vector<TradeoffRow>& rows,
                         TradeoffStage stage,
                         std::size_t points,
                         const char* name) {
  for (const TradeoffRow& row : rows) {
    if (row.stage == stage && row.points == points && row.choice == name) return &row;
  }
  return nullptr;
}

/// "2.3 times faster", "1.4 times slower", "as fast".
std::string Pace(double ratio_1) {
  if (ratio_1 > 1.0 + kSameSpeed_1) return fmt::format("{:.2g} times faster", ratio_1);
  if (ratio_1 * (1.0 + kSameSpeed_1) < 1.0)
    return fmt::format("{:.2g} times slower", 1.0 / ratio_1);
  return "as fast";
}

}  // namespace

void MarkPareto(std::vector<TradeoffRow>* rows) {
  for (TradeoffRow& row : *rows) {
    row.pareto = Competes(row) && std::none_of(rows->begin(), rows->end(), [&](const auto& other) {
                   return other.stage == row.stage && other.points == row.points &&
                          Competes(other) && Beats(other, row);
                 });
  }
}

std::string Recommend(const std::vector<TradeoffRow>& rows,
                      std::size_t points,
                      const TradeoffGoal& goal) {
  const TradeoffRow* solver = Fastest(rows, TradeoffStage::kSolver, points, goal);
  const TradeoffRow* covariance = Fastest(rows, TradeoffStage::kCovariance, points, goal);
  std::string text = fmt::format("{} points: ", points);
  const bool models_alone = std::all_of(rows.begin(), rows.end(), [&](const TradeoffRow& row) {
    return row.points != points || row.stage == TradeoffStage::kModel;
  });
  if (models_alone) {
    const TradeoffRow* model = Fastest(rows, TradeoffStage::kModel, points, goal);
    if (model == nullptr) return text + "no model is good enough";
    return text + fmt::format("the fastest that is good enough is {}, {:.2g} s on {} thread{}",
                              model->choice,
                              model->wall_s,
                              model->threads,
                              model->threads == 1 ? "" : "s");
  }
  if (solver == nullptr || covariance == nullptr) return text + "no choice is good enough";
  text += fmt::format(
      "the fastest that are good enough are {}, double, {}: {:.2g} s on {} thread{}, {:.0f} MiB "
      "beyond the block",
      solver->choice,
      covariance->choice,
      solver->wall_s,
      solver->threads,
      solver->threads == 1 ? "" : "s",
      solver->peak_mib);
  const TradeoffRow* closed = Named(rows, TradeoffStage::kModel, points, "leberl");
  if (closed != nullptr && Competes(*closed)) {
    text += fmt::format(
        "; leberl is {}, its positions up to {:.2g} sigmas off, errors {:.2g} times as large as it "
        "says",
        Pace(closed->speed_ratio_1),
        closed->errors.position_error_1,
        std::sqrt(closed->errors.nees_1));
  }
  const TradeoffRow* single = Named(rows, TradeoffStage::kPrecision, points, "single");
  if (single != nullptr && Competes(*single)) {
    text += fmt::format("; single precision would be {} and {:.1g} sigmas off",
                        Pace(single->speed_ratio_1),
                        single->errors.position_error_1);
  }
  return text;
}

}  // namespace sarblock
