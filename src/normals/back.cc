// SPDX-License-Identifier: Apache-2.0
#include "back.h"

#include <algorithm>
#include <limits>
#include <span>

#include "core/ranks.h"
#include "core/threads.h"
#include "point.h"
#include <Eigen/Core>

namespace sarblock {

KeptFactors::KeptFactors(std::size_t points, std::size_t parts, std::size_t bytes)
    : places_(points), parts_(parts) {
  for (Part& part : parts_) part.numbers.reserve(bytes / sizeof(double) / parts);
}

void KeptFactors::Keep(std::size_t part,
                       std::size_t point,
                       const PointFactor& factor,
                       const PointColumns& columns) {
  constexpr std::size_t kMax = std::numeric_limits<std::uint16_t>::max();
  if (factor.looks_not_evaluated > 0 || columns.blocks.size() > kMax ||
      static_cast<std::size_t>(factor.look_count) > kMax) {
    return;
  }
  std::vector<double>& numbers = parts_[part].numbers;
  if (numbers.empty()) numbers.push_back(0.0);
  std::vector<int>& blocks = parts_[part].blocks;
  places_[point] = {numbers.size(),
                    blocks.size(),
                    static_cast<std::uint32_t>(part),
                    static_cast<std::uint16_t>(factor.look_count),
                    static_cast<std::uint16_t>(columns.blocks.size())};
  blocks.insert(blocks.end(), columns.blocks.begin(), columns.blocks.end());
  const auto put = [&numbers](const double* from, std::size_t count) {
    numbers.insert(numbers.end(), from, from + count);
  };
  put(factor.r.data(), 9);
  put(columns.t.data(), columns.t.size());
  numbers.push_back(factor.row_count);
  put(factor.q.data(), factor.q.size());
  put(factor.e.data(), factor.e.size());
  for (int k = 0; k < factor.look_count; ++k) {
    const WhitenedLook& look = factor.looks[static_cast<std::size_t>(k)];
    for (const auto& row : look.row) {
      put(row.data(), static_cast<std::size_t>(look.columns.column_count));
    }
  }
}

void KeptFactors::Share(const PointPieces& pieces, const std::vector<int>& rank_of_part) {
  Ranks* const ranks = RanksScope::Current();
  if (ranks == nullptr) return;
  struct Sizes {
    std::size_t numbers = 0, blocks = 0;
  };
  std::vector<Sizes> sizes;
  for (const Part& part : parts_) sizes.push_back({part.numbers.size(), part.blocks.size()});
  std::vector<RankPart> reported, kept;
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    AddPart(std::as_writable_bytes(std::span(&sizes[k], 1)), rank_of_part[k], &reported);
  }
  ranks->Share(reported);
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    Part& part = parts_[k];
    const int rank = rank_of_part[k];
    part.numbers.resize(sizes[k].numbers);
    part.blocks.resize(sizes[k].blocks);
    AddPart(std::as_writable_bytes(std::span(part.numbers)), rank, &kept);
    AddPart(std::as_writable_bytes(std::span(part.blocks)), rank, &kept);
    for (std::size_t place = pieces[k].begin; place < pieces[k].end; ++place) {
      AddPart(std::as_writable_bytes(std::span(&places_[pieces.PointAt(place)], 1)), rank, &kept);
    }
  }
  ranks->Share(kept);
}

const double* KeptFactors::Restore(const AdjustmentProblem& problem,
                                   std::size_t point,
                                   Eigen::Matrix3d* r,
                                   PointColumns* columns) const {
  const Place& place = places_[point];
  if (place.number == kNone || problem.CountLooks(point) != place.looks) return nullptr;
  const double* number = parts_[place.part].numbers.data() + place.number;
  std::copy_n(number, 9, r->data());
  const auto block = parts_[place.part].blocks.begin() + static_cast<std::ptrdiff_t>(place.block);
  columns->blocks.assign(block, block + place.blocks);
  PlaceColumns(problem.layout, columns);
  return number + 9;
}

void KeptFactors::RestoreLooks(const AdjustmentProblem& problem,
                               std::size_t point,
                               PointFactor* out) const {
  const Place& place = places_[point];
  const Part& part = parts_[place.part];
  const double* number = part.numbers.data() + place.number;
  std::copy_n(number, 9, out->r.data());
  number += 9;
  for (std::size_t k = 0; k < place.blocks; ++k) {
    const auto block = static_cast<std::size_t>(part.blocks[place.block + k]);
    number += 3 * problem.layout.blocks[block].size;
  }
  const auto take = [&number](std::size_t count, double* to) {
    std::copy_n(number, count, to);
    number += count;
  };
  out->row_count = static_cast<int>(*number++);
  const auto m = static_cast<std::size_t>(out->row_count);
  out->q.resize(3 * m);
  out->e.resize(m);
  take(3 * m, out->q.data());
  take(m, out->e.data());
  const Looks& looks = problem.block.looks;
  const std::size_t begin = looks.offsets[point], end = looks.offsets[point + 1];
  if (out->looks.size() < end - begin) out->looks.resize(end - begin);
  out->look_count = 0;
  out->looks_not_evaluated = 0;
  for (std::size_t i = begin; i < end; ++i) {
    if (problem.look_used[i] == 0) continue;
    const auto k = static_cast<std::size_t>(out->look_count++);
    WhitenedLook& look = out->looks[k];
    look.look = i;
    problem.model.ColumnsOf(i, &look.columns);
    look.whitened_error = {out->e[2 * k], out->e[2 * k + 1]};
    for (auto& row : look.row) {
      take(static_cast<std::size_t>(look.columns.column_count), row.data());
    }
  }
}

namespace {

constexpr std::size_t kPointsPerChunk = 1024;

/// The step of a point and the decrease of the cost that the quadratic model predicts of it.
struct PointStep {
  Eigen::Vector3d step_m = Eigen::Vector3d::Zero();
  double predicted_decrease = 0.0;
};

double PredictedDecrease(const Eigen::Vector3d& gradient,
                         const Eigen::Vector3d& square,
                         double damping,
                         const Eigen::Vector3d& step_m) {
  return 0.5 * (-gradient.dot(step_m) + damping * step_m.cwiseAbs2().dot(square));
}

/// One state with a step of its corrections.
struct BackSubstitution {
  const AdjustmentProblem& problem;
  const BlockState& state;
  const Weighting& weighting;
  double damping;
  const Eigen::VectorXd& dx;

  /// J_c dx of two rows over the columns of a look.
  template <typename Rows>
  [[nodiscard]] Eigen::Vector2d Along(const LookColumns& columns, const Rows& rows) const {
    Eigen::Vector2d along = Eigen::Vector2d::Zero();
    std::size_t local = 0;
    for (int b = 0; b < columns.block_count; ++b) {
      const ParameterBlock& block =
          problem.layout
              .blocks[static_cast<std::size_t>(columns.block[static_cast<std::size_t>(b)])];
      for (int c = 0; c < block.size; ++c, ++local) {
        along[0] += rows[0][local] * dx[block.offset + c];
        along[1] += rows[1][local] * dx[block.offset + c];
      }
    }
    return along;
  }

  /// By the square V of the point's equations; false where V has lost digits that they have.
  [[nodiscard]] bool StepByNormals(PointFactor* factor, std::size_t point, PointStep* out) const {
    PointSums sums, along_sums;
    for (int k = 0; k < factor->look_count; ++k) {
      const WhitenedLook& look = factor->looks[static_cast<std::size_t>(k)];
      sums.Add(look.d_point, look.whitened_error);
      along_sums.AddGradient(look.d_point, Along(look.columns, look.row));
    }
    if (problem.control_of[point] >= 0) {
      const ControlEquations& equations =
          problem.control[static_cast<std::size_t>(problem.control_of[point])];
      sums.Add(EvaluateControl(
          problem.block.frame, equations, state.start_m[point], state.displacement_m[point]));
    }
    const Eigen::Vector3d gradient = sums.Gradient();
    Eigen::Vector3d square = sums.Diagonal();
    if (damping > 0.0) square = square.cwiseMax(kMinColumnPart * square.maxCoeff());
    Eigen::Matrix3d r;
    Eigen::Vector3d inverse;
    if (!FactorSquare(
            (1.0 + damping) * square, sums.Above(), damping > 0.0, factor, &r, &inverse)) {
      return false;
    }
    for (int k = 0; k < factor->curved_count; ++k) {
      const CurvedRows& rows = factor->curved[static_cast<std::size_t>(k)];
      const Eigen::Vector2d along = Along(*rows.columns, rows.row);
      along_sums.AddGradient(rows.d_point, rows.sign.cwiseProduct(along));
    }
    const Eigen::Vector3d moved = gradient + along_sums.Gradient();
    // V dp = R' R dp = -J_p' (e + J_c dx)
    Eigen::Vector3d y;
    y[0] = moved[0] * inverse[0];
    y[1] = (moved[1] - r(0, 1) * y[0]) * inverse[1];
    y[2] = (moved[2] - r(0, 2) * y[0] - r(1, 2) * y[1]) * inverse[2];
    out->step_m[2] = -y[2] * inverse[2];
    out->step_m[1] = (-y[1] - r(1, 2) * out->step_m[2]) * inverse[1];
    out->step_m[0] = (-y[0] - r(0, 1) * out->step_m[1] - r(0, 2) * out->step_m[2]) * inverse[0];
    out->predicted_decrease = PredictedDecrease(gradient, square, damping, out->step_m);
    return true;
  }

  /// By the QR factors of the point, however thin its intersection.
  [[nodiscard]] PointStep StepByFactors(std::size_t point, PointFactor* factor) const {
    FactorPoint(problem, state, weighting, damping, point, factor);
    for (int k = 0; k < factor->look_count; ++k) {  // the right side becomes e + J_c dx
      const WhitenedLook& look = factor->looks[static_cast<std::size_t>(k)];
      const Eigen::Vector2d along = Along(look.columns, look.row);
      factor->e[static_cast<std::size_t>(2 * k)] += along[0];
      factor->e[static_cast<std::size_t>(2 * k + 1)] += along[1];
    }
    PointStep out;
    out.step_m = -factor->r.triangularView<Eigen::Upper>().solve(Project(*factor, factor->e));
    out.predicted_decrease =
        PredictedDecrease(factor->gradient, factor->square, damping, out.step_m);
    return out;
  }
};

}  // namespace

PointSteps SubstituteBack(const AdjustmentProblem& problem,
                          const BlockState& state,
                          const Weighting& weighting,
                          double damping,
                          const Eigen::VectorXd& dx) {
  const std::size_t points = problem.block.points.size();
  PointSteps out;
  out.displacement_m = state.displacement_m;
  std::vector<double> predicted((points + kPointsPerChunk - 1) / kPointsPerChunk, 0.0);
  const BackSubstitution substitution{problem, state, weighting, damping, dx};
  ForChunksOfRanks(points,
                   kPointsPerChunk,
                   {SharedArray::ByItem(&out.displacement_m), SharedArray::ByChunk(&predicted)},
                   [&](std::size_t chunk, std::size_t begin, std::size_t end) {
                     PointFactor factor;
                     for (std::size_t point = begin; point < end; ++point) {
                       if (!problem.Solves(point)) continue;
                       EvaluateLooks(problem, state, weighting, point, &factor);
                       PointStep step;
                       if (!substitution.StepByNormals(&factor, point, &step)) {
                         step = substitution.StepByFactors(point, &factor);
                       }
                       if (!step.step_m.allFinite()) continue;
                       out.displacement_m[point] += step.step_m;
                       predicted[chunk] += step.predicted_decrease;
                     }
                   });
  for (const double part : predicted) out.predicted_decrease += part;
  return out;
}

namespace {

/// sum += J_c' by of two rows over the columns of a look.
template <typename Rows>
void AddSide(const ParameterLayout& layout,
             const LookColumns& columns,
             const Rows& rows,
             const Eigen::Vector2d& by,
             Eigen::VectorXd* sum) {
  std::size_t local = 0;
  for (int b = 0; b < columns.block_count; ++b) {
    const ParameterBlock& block =
        layout.blocks[static_cast<std::size_t>(columns.block[static_cast<std::size_t>(b)])];
    for (int c = 0; c < block.size; ++c, ++local) {
      (*sum)[block.offset + c] += rows[0][local] * by[0] + rows[1][local] * by[1];
    }
  }
}

/// Nonlinear part of the equations of a point after a step.
class BendOfPoint {
 public:
  explicit BendOfPoint(const BackSubstitution& substitution)
      : by_(substitution), stepped_(substitution.state.corrections + substitution.dx) {}

  /// Finds d of the looks of a factored point, less the part that the point itself absorbs. False
  /// where there is no step.
  [[nodiscard]] bool Find(const PointFactor& factor, std::size_t point) {
    Eigen::Vector3d moved = factor.gradient;  // J_p' (e + J_c dx)
    for (int k = 0; k < factor.look_count; ++k) {
      const WhitenedLook& look = factor.looks[static_cast<std::size_t>(k)];
      moved += look.d_point.transpose() * by_.Along(look.columns, look.row);
    }
    for (int k = 0; k < factor.curved_count; ++k) {
      const CurvedRows& rows = factor.curved[static_cast<std::size_t>(k)];
      const Eigen::Vector2d along = by_.Along(*rows.columns, rows.row);
      moved += rows.d_point.transpose() * rows.sign.cwiseProduct(along);
    }
    const Eigen::Vector3d step_m = -SolveSquare(factor, moved);
    if (!step_m.allFinite()) return false;
    const Eigen::Vector3d stepped_m = by_.state.displacement_m[point] + step_m;
    Eigen::Vector3d side = Eigen::Vector3d::Zero();
    left_.assign(static_cast<std::size_t>(factor.look_count), Eigen::Vector2d::Zero());
    for (int k = 0; k < factor.look_count; ++k) {
      const WhitenedLook& look = factor.looks[static_cast<std::size_t>(k)];
      std::array<double, ParameterLayout::kMaxLocalColumns> local;
      GatherColumns(by_.problem.layout, look.columns, stepped_, local.data());
      const LookState after{
          look.look, look.columns, by_.state.start_m[point], stepped_m, local.data()};
      LookEvaluation there;
      if (!by_.problem.model.Evaluate(after, by_.problem.weights[look.look], &there)) continue;
      Eigen::Vector2d& left = left_[static_cast<std::size_t>(k)];
      left = there.whitened_error - look.whitened_error - look.d_point * step_m -
             by_.Along(look.columns, look.row);
      side += look.d_point.transpose() * left;
    }
    followed_m_ = SolveSquare(factor, side);
    if (!followed_m_.allFinite()) return false;
    for (int k = 0; k < factor.look_count; ++k) {
      const auto at = static_cast<std::size_t>(k);
      left_[at] -= factor.looks[at].d_point * followed_m_;
    }
    return true;
  }

  [[nodiscard]] const Eigen::Vector2d& OfLook(int look) const {
    return left_[static_cast<std::size_t>(look)];
  }
  /// The same for rows of second derivatives, which have no error of their own.
  [[nodiscard]] Eigen::Vector2d OfRows(const CurvedRows& rows) const {
    return -rows.sign.cwiseProduct(rows.d_point * followed_m_);
  }

 private:
  /// V^-1 side, V = R' R.
  [[nodiscard]] static Eigen::Vector3d SolveSquare(const PointFactor& factor,
                                                   const Eigen::Vector3d& side) {
    const Eigen::Vector3d y = factor.r.triangularView<Eigen::Upper>().transpose().solve(side);
    return factor.r.triangularView<Eigen::Upper>().solve(y);
  }

  const BackSubstitution& by_;
  const Eigen::VectorXd stepped_;
  std::vector<Eigen::Vector2d> left_;  // by look of the point
  Eigen::Vector3d followed_m_ = Eigen::Vector3d::Zero();
};

}  // namespace

Eigen::VectorXd BendOfStep(const AdjustmentProblem& problem,
                           const BlockState& state,
                           const Weighting& weighting,
                           double damping,
                           const Eigen::VectorXd& dx) {
  // A sum of as many numbers as there are corrections each.
  constexpr std::size_t kMaxSums = 64;
  const std::size_t points = problem.block.points.size();
  const std::size_t per_sum = std::max(kPointsPerChunk, (points + kMaxSums - 1) / kMaxSums);
  std::vector<Eigen::VectorXd> sums((points + per_sum - 1) / per_sum);
  const BackSubstitution substitution{problem, state, weighting, damping, dx};
  ParallelForChunks(points, per_sum, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    Eigen::VectorXd& sum = sums[chunk];
    sum.setZero(dx.size());
    PointFactor factor;
    BendOfPoint bend(substitution);
    for (std::size_t point = begin; point < end; ++point) {
      if (!problem.Solves(point)) continue;
      FactorPoint(problem, state, weighting, damping, point, &factor);
      if (!bend.Find(factor, point)) continue;
      for (int k = 0; k < factor.look_count; ++k) {
        const WhitenedLook& look = factor.looks[static_cast<std::size_t>(k)];
        AddSide(problem.layout, look.columns, look.row, bend.OfLook(k), &sum);
      }
      for (int k = 0; k < factor.curved_count; ++k) {
        const CurvedRows& rows = factor.curved[static_cast<std::size_t>(k)];
        AddSide(problem.layout, *rows.columns, rows.row, bend.OfRows(rows), &sum);
      }
    }
  });
  Eigen::VectorXd out = Eigen::VectorXd::Zero(dx.size());
  for (const Eigen::VectorXd& sum : sums) out += sum;
  return out;
}

Eigen::VectorXd BendsAlongSteps(const AdjustmentProblem& problem,
                                const BlockState& state,
                                const Eigen::MatrixXd& steps,
                                const std::vector<SampledPoint>& points) {
  constexpr std::size_t kStepsPerChunk = 4;
  const Weighting plain;
  const auto count = static_cast<std::size_t>(steps.cols());
  Eigen::VectorXd out = Eigen::VectorXd::Zero(steps.cols());
  ParallelForChunks(count, kStepsPerChunk, [&](std::size_t, std::size_t begin, std::size_t end) {
    PointFactor factor;
    std::vector<Eigen::VectorXd> dx;
    for (std::size_t k = begin; k < end; ++k) {
      dx.emplace_back(steps.col(static_cast<Eigen::Index>(k)));
    }
    std::vector<BackSubstitution> substitutions;
    substitutions.reserve(dx.size());
    std::vector<BendOfPoint> bends;
    for (const Eigen::VectorXd& step : dx) {
      substitutions.push_back({problem, state, plain, 0.0, step});
      bends.emplace_back(substitutions.back());
    }
    for (const auto& [point, weight] : points) {
      FactorPoint(problem, state, plain, 0.0, point, &factor);
      for (std::size_t k = begin; k < end; ++k) {
        BendOfPoint& bend = bends[k - begin];
        if (!bend.Find(factor, point)) continue;
        for (int i = 0; i < factor.look_count; ++i) {
          const WhitenedLook& look = factor.looks[static_cast<std::size_t>(i)];
          out[static_cast<Eigen::Index>(k)] +=
              weight * substitutions[k - begin].Along(look.columns, look.row).dot(bend.OfLook(i));
        }
      }
    }
  });
  return out;
}

}  // namespace sarblock
