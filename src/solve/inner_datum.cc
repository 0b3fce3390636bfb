// SPDX-License-Identifier: Apache-2.0
#include "inner_datum.h"

#include "sarblock/core/error.h"
#include "sarblock/model/result.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/threads.h"
#include "linear/dense.h"
#include "normals/point.h"
#include "rank.h"

namespace sarblock {
namespace {

constexpr std::size_t kMaxPartials = 16;
/// A move of the datum by less than this changes no figure that is printed.
constexpr double kDatumSettled_m = 1e-6;
/// Datum points whose part of the null space is this near to dependent (ratio of the eigenvalues
/// of G'E G scaled to unit diagonal) fix the datum no better than rounding does.
constexpr double kMinDatumEigenvalue = 1e-12;

/// Factors of one point: R^-1 and R^-1 T over its blocks.
struct DatumTerms {
  PointFactor factor;
  PointColumns columns;
  Eigen::Matrix3d r_inverse = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, Eigen::Dynamic> y;
};

void FactorTerms(const AdjustmentProblem& problem,
                 const BlockState& state,
                 std::size_t point,
                 DatumTerms* out) {
  FactorPoint(problem, state, {}, 0.0, point, &out->factor);
  ProjectColumns(problem, out->factor, &out->columns);
  out->r_inverse = out->factor.r.triangularView<Eigen::Upper>().solve(Eigen::Matrix3d::Identity());
  out->y =
      out->r_inverse * Eigen::Map<const Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>>(
                           out->columns.t.data(), 3, out->columns.width);
}

/// R^-1 T x of a point for columns x over all corrections.
Eigen::Matrix<double, 3, Eigen::Dynamic> Times(const AdjustmentProblem& problem,
                                               const DatumTerms& terms,
                                               const Eigen::MatrixXd& x) {
  Eigen::Matrix<double, 3, Eigen::Dynamic> out =
      Eigen::Matrix<double, 3, Eigen::Dynamic>::Zero(3, x.cols());
  for (std::size_t b = 0; b < terms.columns.blocks.size(); ++b) {
    const ParameterBlock& block =
        problem.layout.blocks[static_cast<std::size_t>(terms.columns.blocks[b])];
    out.noalias() += terms.y.middleCols(terms.columns.begin[b], block.size) *
                     x.middleRows(block.offset, block.size);
  }
  return out;
}

/// S C S' of rows whose parts of G and K are given.
Eigen::Matrix3d Transformed(const Eigen::Matrix3d& covariance,
                            const Eigen::Matrix<double, 3, Eigen::Dynamic>& g,
                            const Eigen::Matrix<double, 3, Eigen::Dynamic>& k,
                            const Eigen::MatrixXd& inner) {
  const Eigen::Matrix3d mixed = g * k.transpose();
  return covariance - mixed - mixed.transpose() + g * inner * g.transpose();
}

/// Sums over ranges of points that do not depend on the number of threads.
struct Sums {
  Eigen::MatrixXd gram, right_side;
};

}  // namespace

void FixDatum(const Eigen::MatrixXd& null_space,
              const Eigen::VectorXd& unit,
              const BlockState& state,
              AdjustmentProblem* problem) {
  problem->fixed.clear();
  if (null_space.cols() == 0) return;
  const Eigen::MatrixXd rows = unit.cwiseInverse().asDiagonal() * null_space;
  const dense::PivotedOrthogonal qr(rows.transpose());
  for (Eigen::Index k = 0; k < null_space.cols(); ++k) {
    const int parameter = qr.Column(k);
    problem->fixed.push_back({parameter, state.corrections[parameter]});
  }
}

DatumTransform::DatumTransform(const AdjustmentProblem& problem,
                               const BlockState& state,
                               const ReducedSystem& system,
                               const Eigen::MatrixXd& null_space,
                               const std::vector<std::uint8_t>& in_datum)
    : in_datum_(in_datum), corrections_g_(null_space) {
  const std::size_t points = problem.block.points.size();
  const Eigen::Index d = null_space.cols(), n = problem.layout.size();
  for (std::size_t point = 0; point < points; ++point) {
    if (!problem.Solves(point)) in_datum_[point] = 0;
  }
  points_g_.setZero(3 * static_cast<Eigen::Index>(points), d);
  points_k_.setZero(3 * static_cast<Eigen::Index>(points), d);

  const std::size_t per_part =
      std::max<std::size_t>(1024, (points + kMaxPartials - 1) / kMaxPartials);
  std::vector<Sums> parts((points + per_part - 1) / per_part);
  ParallelForChunks(points, per_part, [&](std::size_t part, std::size_t begin, std::size_t end) {
    Sums& sums = parts[part];
    sums.gram.setZero(d, d);
    sums.right_side.setZero(n, d);
    DatumTerms terms;
    for (std::size_t point = begin; point < end; ++point) {
      if (!problem.Solves(point)) continue;
      FactorTerms(problem, state, point, &terms);
      const Rows g = -Times(problem, terms, corrections_g_);
      points_g_.middleRows<3>(3 * static_cast<Eigen::Index>(point)) = g;
      if (in_datum_[point] == 0) continue;
      sums.gram.noalias() += g.transpose() * g;
      for (std::size_t b = 0; b < terms.columns.blocks.size(); ++b) {
        const ParameterBlock& block =
            problem.layout.blocks[static_cast<std::size_t>(terms.columns.blocks[b])];
        sums.right_side.middleRows(block.offset, block.size).noalias() -=
            terms.y.middleCols(terms.columns.begin[b], block.size).transpose() * g;
      }
    }
  });
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(d, d), right_side = Eigen::MatrixXd::Zero(n, d);
  for (const Sums& sums : parts) {
    gram += sums.gram;
    right_side += sums.right_side;
  }
  const Eigen::VectorXd unit = gram.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = unit.asDiagonal() * gram * unit.asDiagonal();
  if (!unit.allFinite() || !(dense::SymmetricEigenvalues(scaled)[0] > kMinDatumEigenvalue)) {
    throw UndeterminedError(
        "the datum points do not fix the datum: the block has " + std::to_string(d) +
            " defects, and the coordinates of these points do not distinguish them; name more "
            "points in adjust.datum_points",
        {"datum_points"});
  }
  // G <- G L^-T makes G'E G the identity.
  const dense::Cholesky root(gram);
  const auto normalise = [&](Eigen::MatrixXd* m) {
    *m = root.SolveLower(Eigen::MatrixXd(m->transpose())).transpose();
  };
  normalise(&corrections_g_);
  normalise(&points_g_);
  normalise(&right_side);

  // K = C E G by block elimination: the corrections first, then each point.
  corrections_k_ = system.SolveFor(right_side);
  std::vector<Eigen::MatrixXd> inner_parts(parts.size());
  ParallelForChunks(points, per_part, [&](std::size_t part, std::size_t begin, std::size_t end) {
    Eigen::MatrixXd& sum = inner_parts[part];
    sum.setZero(d, d);
    DatumTerms terms;
    for (std::size_t point = begin; point < end; ++point) {
      if (!problem.Solves(point)) continue;
      FactorTerms(problem, state, point, &terms);
      Rows k = -Times(problem, terms, corrections_k_);
      if (in_datum_[point] != 0) {
        const Rows g = G(point);
        k += terms.r_inverse * (terms.r_inverse.transpose() * g);
        sum.noalias() += g.transpose() * k;
      }
      points_k_.middleRows<3>(3 * static_cast<Eigen::Index>(point)) = k;
    }
  });
  inner_.setZero(d, d);
  for (const Eigen::MatrixXd& part : inner_parts) inner_ += part;
  inner_ = (0.5 * (inner_ + inner_.transpose())).eval();
}

double DatumTransform::Move(const AdjustmentProblem& problem, BlockState* state) const {
  const std::size_t points = problem.block.points.size();
  Eigen::VectorXd along = Eigen::VectorXd::Zero(defects());
  for (std::size_t point = 0; point < points; ++point) {
    if (in_datum_[point] != 0) along += G(point).transpose() * state->displacement_m[point];
  }
  double largest_m = 0.0;
  for (std::size_t point = 0; point < points; ++point) {
    if (!problem.Solves(point)) continue;
    const Eigen::Vector3d move_m = -(G(point) * along);
    state->displacement_m[point] += move_m;
    largest_m = std::max(largest_m, move_m.norm());
  }
  state->corrections -= corrections_g_ * along;
  return largest_m;
}

void DatumTransform::Transform(const AdjustmentProblem& problem,
                               const BlockState& state,
                               std::vector<SymmetricEnu>* covariance_m2) const {
  for (std::size_t point = 0; point < covariance_m2->size(); ++point) {
    if (!problem.Solves(point)) continue;
    const Eigen::Matrix3d e = problem.block.frame.EnuFromFrame(state.Position(point));
    SymmetricEnu& c = (*covariance_m2)[point];
    c = SymmetricOf(Transformed(MatrixOf(c), e * G(point), e * K(point), inner_));
  }
}

void DatumTransform::Transform(std::vector<ParameterCovariance>* covariance) const {
  for (ParameterCovariance& c : *covariance) {
    const auto ga = corrections_g_.row(c.a), gb = corrections_g_.row(c.b);
    c.covariance +=
        -ga.dot(corrections_k_.row(c.b)) - corrections_k_.row(c.a).dot(gb) + (ga * inner_).dot(gb);
  }
}

void DatumTransform::Transform(const AdjustmentProblem& problem,
                               const BlockState& state,
                               std::vector<PairResult>* pairs) const {
  for (PairResult& pair : *pairs) {
    const Eigen::Matrix3d e = problem.block.frame.EnuFromFrame(state.Position(pair.a));
    pair.covariance_m2 = SymmetricOf(Transformed(MatrixOf(pair.covariance_m2),
                                                 e * (G(pair.b) - G(pair.a)),
                                                 e * (K(pair.b) - K(pair.a)),
                                                 inner_));
  }
}

void RequireInnerOffered(const AdjustOptions& options) {
  if (options.datum != Datum::kInner) {
    if (options.datum_points.empty()) return;
    throw InputError("adjust.datum_points",
                     "names points of an inner datum; datum = \"inner\" asks for one");
  }
  const auto refuse = [](const char* key, const char* value) {
    throw InputError(std::string("adjust.") + key,
                     std::string("'") + value + "' does not go with datum = \"inner\"");
  };
  if (options.engine == Engine::kCeres) refuse("engine", "ceres");
  if (options.covariance_method == CovarianceMethod::kCeres) refuse("covariance_method", "ceres");
  if (options.covariance == CovarianceLevel::kMonteCarlo) refuse("covariance", "montecarlo");
  if (options.corrections == CorrectionChoice::kAuto) refuse("corrections", "auto");
}

std::vector<std::uint8_t> DatumPoints(const Block& block, const AdjustOptions& options) {
  const std::size_t points = block.points.size();
  if (options.datum_points.empty()) return std::vector<std::uint8_t>(points, 1);
  std::vector<std::uint8_t> out(points, 0);
  for (const std::string& id : options.datum_points) {
    const std::uint32_t point = block.points.ids.Find(id);
    if (point == IdTable::kNone) {
      throw InputError(
          "adjust.datum_points",
          "the block has no point '" + id + "'" + DidYouMean(block.points.ids.Nearest(id)));
    }
    out[point] = 1;
  }
  return out;
}

bool FixDatumIfFloating(const BlockState& state, AdjustmentProblem* problem) {
  problem->fixed.clear();
  ReducedSystem open(*problem);
  open.Form(state, {}, nullptr);
  if (!open.weak_points().empty()) return false;  // reported by name elsewhere
  FixDatum(NullSpace(&open), open.Unit(), state, problem);
  return !problem->fixed.empty();
}

DatumTransform SettleInnerDatum(const AdjustOptions& options,
                                const std::function<void()>& solve,
                                AdjustmentProblem* problem,
                                BlockState* state) {
  constexpr int kMaxRounds = 20;
  const std::vector<std::uint8_t> in_datum = DatumPoints(problem->block, options);
  for (int round = 1;; ++round) {
    problem->fixed.clear();
    ReducedSystem open(*problem);
    open.Form(*state, {}, nullptr);
    const Eigen::MatrixXd null_space = NullSpace(&open);
    FixDatum(null_space, open.Unit(), *state, problem);
    ReducedSystem system(*problem);
    system.Form(*state, {}, nullptr);
    FactorRegular(&system);
    DatumTransform datum(*problem, *state, system, null_space, in_datum);
    const double moved_m = datum.Move(*problem, state);
    for (FixedParameter& fixed : problem->fixed) fixed.value = state->corrections[fixed.parameter];
    if (moved_m <= kDatumSettled_m || round == kMaxRounds) return datum;
    solve();
  }
}

}  // namespace sarblock
