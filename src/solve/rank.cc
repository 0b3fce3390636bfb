// SPDX-License-Identifier: Apache-2.0
#include "rank.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "core/threads.h"
#include "linear/dense.h"
#include "normals/point.h"
#include "normals/reduced_system.h"
#include "weak_directions.h"

namespace sarblock {
namespace {

/// The same start on every machine: std::mt19937_64 is specified bit by bit.
Eigen::MatrixXd StartColumns(Eigen::Index rows, Eigen::Index columns) {
  std::mt19937_64 engine(19790801);
  Eigen::MatrixXd x(rows, columns);
  for (Eigen::Index c = 0; c < columns; ++c) {
    for (Eigen::Index r = 0; r < rows; ++r) {
      x(r, c) = static_cast<double>(engine() >> 11) * 0x1p-53 - 0.5;
    }
  }
  return x;
}

void Orthonormalise(Eigen::MatrixXd* x) { *x = dense::Orthogonal(*x).Q(x->cols()); }

/// Rotates the columns to the Ritz vectors of `matrix`; returns the Ritz values.
Eigen::VectorXd Ritz(const BorderedMatrix& matrix, Eigen::MatrixXd* x) {
  const Eigen::MatrixXd h = x->transpose() * matrix.Multiply(*x);
  const dense::Eigenpairs eigen = dense::SymmetricEigenpairs(0.5 * (h + h.transpose()));
  *x = *x * eigen.vectors;
  return eigen.values;
}

}  // namespace

LeastEigenpairs FindLeastEigenpairs(const BorderedMatrix& matrix,
                                    const BorderedCholesky& factor,
                                    const LeastEigenpairOptions& options) {
  LeastEigenpairs pairs;
  const Eigen::Index n = matrix.rows(), k = std::min<Eigen::Index>(n, options.count);
  if (k == 0) return pairs;
  pairs.vectors = StartColumns(n, k);
  Orthonormalise(&pairs.vectors);
  pairs.values = Eigen::VectorXd::Constant(k, 1.0);
  const auto settled = [&](const Eigen::VectorXd& now) {
    for (Eigen::Index i = 0; i < k; ++i) {
      if ((i > 0 && !(now[i] < options.settle_below)) || now[i] < options.rounding) continue;
      if (std::abs(now[i] - pairs.values[i]) > options.relative_change * now[i]) return false;
    }
    return true;
  };
  for (int step = 0; step < options.most_steps; ++step) {
    factor.Solve(pairs.vectors);
    Orthonormalise(&pairs.vectors);
    const Eigen::VectorXd now = Ritz(matrix, &pairs.vectors);
    const bool done = settled(now) && step > 0;
    pairs.values = now;
    if (done) break;
  }
  return pairs;
}

double LargestEigenvalue(const BorderedMatrix& matrix) {
  constexpr int kSteps = 200;
  constexpr double kRelativeChange = 1e-3;
  Eigen::VectorXd x = StartColumns(matrix.rows(), 1).col(0).normalized();
  double largest = 0.0;
  for (int step = 0; step < kSteps && x.size() > 0; ++step) {
    const Eigen::VectorXd next = matrix.Multiply(x);
    const double value = x.dot(next);
    x = next.normalized();
    const double change = std::abs(value - largest);
    largest = value;
    if (change <= kRelativeChange * value) break;
  }
  return largest;
}

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kLift = 1e-9;
/// Added to the unit diagonal of a singular S so that it can be factored.
constexpr double kNullSpaceLift = 1e-9;
/// Eigenpairs above this are not looked at: a parameter a hundred times worse than it would be with
/// all others known is nothing unusual.
constexpr double kLooked = 1e-4;
constexpr int kFirstPairs = 6, kMaxEigenpairs = 48;
/// Parameters with less than this part of the largest share are not named.
constexpr double kNamedShare = 0.1;
/// Least movement of a point by a direction, as a part of the effect of its parameters; less is
/// rounding.
constexpr double kMovesPoints = 1e-6;
/// More directions than this are not described one by one.
constexpr std::size_t kDescribed = 12;

/// Everything that judging and naming of directions reads.
struct Context {
  const AdjustmentProblem& problem;
  const BorderedMatrix& scaled;
  const VectorXd& scale;
  const BlockState* state;
  const BorderedCholesky& factor;
  bool singular;  // the factor is that of a lifted matrix
  std::vector<int> pass_of;
  TargetEffects effects;

  [[nodiscard]] const Parameter& At(Index i) const {
    return problem.layout.parameters[static_cast<std::size_t>(i)];
  }
};

/// Figures of a unit direction v of the scaled parameters.
WeakDirection Judge(const Context& context, const VectorXd& v) {
  WeakDirection out;
  out.eigenvalue = std::max(0.0, v.dot(context.scaled.Multiply(v).col(0)));
  double priors = 0.0, effect_m = 0.0;
  for (Index i = 0; i < v.size(); ++i) {
    const double moved = v[i] * context.scale[i];
    if (context.At(i).has_prior()) {
      if (context.At(i).joint >= 0) continue;
      const Index from = context.At(i).before;
      const double part = from < 0
                              ? moved / context.At(i).prior_sigma
                              : (moved - context.At(i).carried * v[from] * context.scale[from]) /
                                    context.At(i).step_sigma;
      priors += part * part;
    } else {
      effect_m = std::max(effect_m, std::abs(moved) * context.effects.metres[i]);
    }
  }
  for (const JointPriorTerm& prior : context.problem.layout.joint_priors) {
    const VectorXd moved = v(prior.parameters).cwiseProduct(context.scale(prior.parameters));
    priors += (prior.whitening * moved).squaredNorm();
  }
  out.undetermined = !(out.eigenvalue > kMinEigenvalue);
  const double length = std::sqrt(out.eigenvalue);
  out.prior_part = length > 0.0 ? std::min(1.0, priors / out.eigenvalue) : 0.0;
  out.effect_m = length > 0.0 ? effect_m / length : std::numeric_limits<double>::infinity();
  // A direction that priors constrain is determined by them, at any accuracy.
  if (out.prior_part < 0.5 && out.effect_m > kOpenEffectPart * context.effects.range_m) {
    out.undetermined = true;
  }
  const double most = v.cwiseAbs().maxCoeff();
  for (Index i = 0; i < v.size(); ++i) {
    if (std::abs(v[i]) < kNamedShare * most) continue;
    out.parameters.push_back({static_cast<int>(i), v[i]});
  }
  std::stable_sort(out.parameters.begin(), out.parameters.end(), [](const auto& a, const auto& b) {
    return std::abs(a.share) > std::abs(b.share) * (1.0 + 1e-9);
  });
  return out;
}

bool IsNearly(const Context& context, const WeakDirection& direction) {
  return direction.eigenvalue < kNearEigenvalue ||
         (direction.prior_part < 0.5 &&
          direction.effect_m > kNearEffectPart * context.effects.range_m);
}

/// Exact posterior sigmas of the parameters named and the correlation of the first two, by
/// solutions on the factor.
void AddSigmas(const Context& context, WeakDirection* direction) {
  constexpr std::size_t kSolved = 4;
  const auto count = static_cast<Index>(std::min(kSolved, direction->parameters.size()));
  MatrixXd columns = MatrixXd::Zero(context.scale.size(), count);
  for (Index k = 0; k < count; ++k) {
    columns(direction->parameters[static_cast<std::size_t>(k)].index, k) = 1.0;
  }
  context.factor.Solve(columns);
  for (std::size_t k = 0; k < direction->parameters.size(); ++k) {
    WeakParameter& parameter = direction->parameters[k];
    const double variance = k < kSolved ? columns(parameter.index, static_cast<Index>(k))
                                        : parameter.share * parameter.share / direction->eigenvalue;
    parameter.sigma = context.scale[parameter.index] * std::sqrt(std::max(0.0, variance));
  }
  if (count < 2) return;
  const int a = direction->parameters[0].index, b = direction->parameters[1].index;
  direction->correlation = columns(a, 1) / std::sqrt(columns(a, 0) * columns(b, 1));
}

/// The tie point each direction moves most, dp = -R^-1 T dc; none where parameters that compensate
/// each other leave the points where they are.
void AddMovedPoints(const Context& context,
                    const MatrixXd& directions,
                    std::vector<WeakDirection>* report) {
  if (context.state == nullptr || report->empty()) return;
  const AdjustmentProblem& problem = context.problem;
  const std::size_t points = problem.block.points.size();
  const auto count = static_cast<Index>(report->size());
  constexpr std::size_t kMovedPerChunk = 1024;
  struct Most {
    double square = -1.0;
    std::size_t point = 0;
  };
  std::vector<std::vector<Most>> parts((points + kMovedPerChunk - 1) / kMovedPerChunk);
  ParallelForChunks(
      points, kMovedPerChunk, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
        std::vector<Most>& most = parts[chunk];
        most.resize(report->size());
        PointFactor factor;
        PointColumns columns;
        for (std::size_t point = begin; point < end; ++point) {
          if (!problem.Solves(point) || problem.control_of[point] >= 0) continue;
          FactorPoint(problem, *context.state, {}, 0.0, point, &factor);
          if (!(factor.reciprocal_condition >= kMinPointCondition)) continue;
          ProjectColumns(problem, factor, &columns);
          if (columns.width == 0) continue;
          MatrixXd local(columns.width, count);
          for (std::size_t b = 0; b < columns.blocks.size(); ++b) {
            const ParameterBlock& block =
                problem.layout.blocks[static_cast<std::size_t>(columns.blocks[b])];
            local.middleRows(columns.begin[b], block.size) =
                directions.middleRows(block.offset, block.size);
          }
          const Eigen::Map<const Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>> t(
              columns.t.data(), 3, columns.width);
          const MatrixXd moved = factor.r.triangularView<Eigen::Upper>().solve(t * local);
          for (Index k = 0; k < count; ++k) {
            const double square = moved.col(k).squaredNorm();
            Most& best = most[static_cast<std::size_t>(k)];
            if (square > best.square * (1.0 + 1e-9)) best = {square, point};
          }
        }
      });
  for (std::size_t k = 0; k < report->size(); ++k) {
    Most best;
    for (const std::vector<Most>& part : parts) {
      if (part[k].square > best.square * (1.0 + 1e-9)) best = part[k];
    }
    const double of_parameters_m = directions.col(static_cast<Index>(k))
                                       .cwiseProduct(context.effects.metres)
                                       .cwiseAbs()
                                       .maxCoeff();
    if (!(std::sqrt(best.square) > kMovesPoints * of_parameters_m)) continue;
    (*report)[k].moved_point = static_cast<std::uint32_t>(best.point);
    (*report)[k].moved_m = std::sqrt(best.square);
  }
}

/// Directions of a weak subspace as sparse as they come, judged, rigid motions named.
std::vector<WeakDirection> Name(const Context& context, const MatrixXd& weak, bool undetermined) {
  struct Judged {
    VectorXd vector;
    WeakDirection direction;
  };
  std::vector<Judged> basis;
  for (NamedDirection& named :
       NameableBasis(context.problem, context.pass_of, context.scale, weak)) {
    WeakDirection direction = Judge(context, named.vector);
    direction.undetermined = undetermined;
    direction.motion = std::move(named.motion);
    basis.push_back({std::move(named.vector), std::move(direction)});
  }
  // Motions first, as they come; of them those of fewer parameters, which are easier to read.
  std::stable_sort(basis.begin(), basis.end(), [](const Judged& a, const Judged& b) {
    if (a.direction.motion.empty() || b.direction.motion.empty()) {
      return !a.direction.motion.empty() && b.direction.motion.empty();
    }
    return a.direction.parameters.size() < b.direction.parameters.size();
  });
  std::vector<WeakDirection> out;
  MatrixXd moved(weak.rows(), static_cast<Index>(basis.size()));
  for (Judged& judged : basis) {
    WeakDirection& direction = judged.direction;
    const double length = std::sqrt(std::max(direction.eigenvalue, kMinEigenvalue));
    moved.col(static_cast<Index>(out.size())) =
        context.scale.cwiseProduct(judged.vector) / (undetermined ? 1.0 : length);
    // The factor of a lifted matrix says nothing of sigmas, nor does an eigenvalue that is
    // rounding.
    if (!context.singular && !undetermined) AddSigmas(context, &direction);
    out.push_back(std::move(direction));
  }
  AddMovedPoints(context, moved, &out);
  for (std::size_t k = 0; k < std::min(out.size(), kDescribed); ++k) {
    out[k].text = DescribeDirection(context.problem, context.pass_of, out[k]);
  }
  return out;
}

void Lift(double lift, BlockSymmetricMatrix* matrix) {
  for (int b = 0; b < matrix->block_count(); ++b) {
    matrix->Block(b, b).diagonal().array() += lift;
  }
}

/// Weak eigenvectors, and with them columns of S^-1 of parameters without a prior that even all
/// others known would leave open.
struct WeakSpaces {
  MatrixXd undetermined, nearly;
  bool more = false;
  double least = 1.0;
};

MatrixXd Columns(Index rows, const std::vector<VectorXd>& columns) {
  MatrixXd out(rows, static_cast<Index>(columns.size()));
  for (std::size_t k = 0; k < columns.size(); ++k) out.col(static_cast<Index>(k)) = columns[k];
  return out;
}

WeakSpaces FindWeak(const Context& context) {
  WeakSpaces out;
  LeastEigenpairOptions options;
  options.settle_below = kLooked;
  std::vector<VectorXd> undetermined, nearly;
  const Index n = context.scale.size();
  for (int count = kFirstPairs;; count = std::min(4 * count, kMaxEigenpairs)) {
    options.count = count;
    undetermined.clear();
    nearly.clear();
    const LeastEigenpairs pairs = FindLeastEigenpairs(context.scaled, context.factor, options);
    out.least = pairs.values[0];
    for (Index k = 0; k < pairs.values.size() && pairs.values[k] < kLooked; ++k) {
      const VectorXd v = pairs.vectors.col(k);
      const WeakDirection direction = Judge(context, v);
      // What the factorisation met is undetermined, however its eigenvalue came out.
      if (direction.undetermined || (context.singular && k == 0)) {
        undetermined.push_back(v);
      } else if (IsNearly(context, direction)) {
        nearly.push_back(v);
      }
    }
    const auto found = static_cast<Index>(undetermined.size() + nearly.size());
    const bool all = found == pairs.values.size() && found < n;
    out.more = all && count >= kMaxEigenpairs;
    if (!all || count >= kMaxEigenpairs) break;
  }
  for (Index i = 0; i < n && nearly.size() < kDescribed; ++i) {
    if (context.At(i).has_prior()) continue;
    const double alone_m = context.scale[i] * context.effects.metres[i];
    if (!(alone_m > kNearEffectPart * context.effects.range_m)) continue;
    VectorXd v = VectorXd::Unit(n, i);
    context.factor.Solve(v);
    v.normalize();
    const bool open = alone_m > kOpenEffectPart * context.effects.range_m;
    (open ? undetermined : nearly).push_back(v);
  }
  out.undetermined = Columns(n, undetermined);
  out.nearly = Columns(n, nearly);
  return out;
}

}  // namespace

RankReport AnalyseRank(const AdjustmentProblem& problem,
                       const BorderedMatrix& scaled,
                       const VectorXd& scale,
                       const BlockState* state,
                       BorderedCholesky* factor) {
  RankReport report;
  if (scaled.rows() == 0) return report;
  const bool singular = !factor->Factorize(scaled);
  BorderedMatrix lifted;
  for (double lift = kLift; singular; lift *= 100.0) {
    lifted = scaled;
    Lift(lift, &lifted.sparse);
    if (factor->Factorize(lifted)) break;
    if (lift > 1.0) {
      throw UndeterminedError("the reduced matrix of the corrections is not finite or indefinite",
                              {});
    }
  }
  Context context{
      problem, scaled, scale, state, *factor, singular, PassOfParameters(problem.layout), {}};
  context.effects = TargetEffectsOf(problem, context.pass_of);
  const WeakSpaces weak = FindWeak(context);
  report.more = weak.more;
  report.condition = LargestEigenvalue(scaled) / std::max(weak.least, 1e-300);
  report.undetermined = Name(context, weak.undetermined, true);
  // Beside what is refused, what is merely weak is no news.
  if (report.regular()) report.nearly = Name(context, weak.nearly, false);
  return report;
}

void RequireRegular(const AdjustmentProblem& problem,
                    const RankReport& report,
                    const std::vector<std::string>& structure) {
  if (report.regular()) return;
  std::string text = "the block does not determine its corrections: ";
  std::vector<std::string> names;
  std::set<int> named;
  std::size_t described = 0;
  for (const WeakDirection& direction : report.undetermined) {
    if (!direction.text.empty()) text += (described++ == 0 ? "" : "; ") + direction.text;
    for (const WeakParameter& parameter : direction.parameters) {
      if (!named.insert(parameter.index).second) continue;
      names.push_back(problem.layout.Describe(parameter.index));
    }
  }
  if (described < report.undetermined.size()) {
    text += "; and " + std::to_string(report.undetermined.size() - described) +
            " more directions like these";
  }
  if (report.more) text += "; and more than were looked for";
  for (const std::string& finding : structure) text += "; " + finding;
  throw UndeterminedError(text + "; these parameters take part", names);
}

void WarnOfWeakDirections(const RankReport& rank, AdjustResult* result) {
  for (const WeakDirection& direction : rank.nearly) {
    if (direction.text.empty()) continue;
    Warn(result, "nearly undetermined: " + direction.text);
  }
  if (rank.more || (!rank.nearly.empty() && rank.nearly.back().text.empty())) {
    Warn(result, "more directions than were looked for or described are nearly undetermined");
  }
}

RankReport FactorAndAnalyse(ReducedSystem* system, const BlockState* state) {
  if (system->matrix().rows() == 0) return {};
  const BorderedMatrix scaled = system->FormScaled();
  return AnalyseRank(system->problem(), scaled, system->Unit(), state, &system->factor());
}

RankReport FactorRegular(ReducedSystem* system) {
  RankReport report = FactorAndAnalyse(system);
  RequireRegular(system->problem(), report);
  return report;
}

MatrixXd NullSpace(ReducedSystem* system) {
  const RankReport report = FactorAndAnalyse(system);
  if (report.regular()) return MatrixXd(system->matrix().rows(), 0);
  const BorderedMatrix scaled = system->FormScaled();
  BorderedCholesky& factor = system->factor();
  BorderedMatrix lifted = scaled;
  Lift(kNullSpaceLift, &lifted.sparse);
  if (!factor.Factorize(lifted)) RequireRegular(system->problem(), report);
  LeastEigenpairOptions options;
  options.settle_below = 10.0 * kMinEigenvalue;
  options.relative_change = 1e-6;
  for (options.count = 8;; options.count *= 2) {
    const LeastEigenpairs pairs = FindLeastEigenpairs(scaled, factor, options);
    Index defects = 0;
    while (defects < pairs.values.size() && pairs.values[defects] <= kMinEigenvalue) ++defects;
    if (defects == pairs.values.size() && defects < system->matrix().rows()) continue;
    return system->Unit().asDiagonal() * pairs.vectors.leftCols(defects);
  }
}

namespace {

void LeaveOutWeakPoints(const ReducedSystem& system, AdjustmentProblem* problem) {
  for (const WeakPoint& weak : system.weak_points()) {
    problem->LeaveOut(weak.point,
                      PointStatus::kUndetermined,
                      "its looks leave a direction open (their circles touch or coincide)");
  }
}

}  // namespace

void RequireSolvable(const AdjustmentProblem& problem) {
  // Control points are known anyway: a block in which none of the others can be solved has no
  // answer, however well its control fits. A point in no look that takes part asks for none.
  const Block& block = problem.block;
  const std::size_t points = block.points.size();
  const auto asks = [&block](std::size_t point) {
    if (block.points.role[point] == PointRole::kControl) return false;
    for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      if (!block.looks.rejected(i)) return true;
    }
    return false;
  };
  bool only_control = true;
  for (std::size_t point = 0; point < points; ++point) only_control &= !asks(point);
  std::map<std::string, std::vector<std::string>> by_reason;
  for (std::size_t point = 0; point < points; ++point) {
    if (!only_control && !asks(point)) continue;
    if (problem.Solves(point)) return;
    by_reason[problem.point_reason[point]].emplace_back(block.points.ids[point]);
  }
  std::string text = only_control ? "no point of the block can be determined"
                                  : "no tie or check point of the block can be determined";
  std::vector<std::string> names;
  for (const auto& [reason, ids] : by_reason) {
    text += "; " + ids.front();
    if (ids.size() > 1) text += " and " + std::to_string(ids.size() - 1) + " more";
    text += ": " + reason;
    names.insert(names.end(), ids.begin(), ids.end());
  }
  throw UndeterminedError(text, names);
}

void FormDetermined(const BlockState& state,
                    const Weighting& weighting,
                    AdjustmentProblem* problem,
                    std::optional<ReducedSystem>* system,
                    ProgressSink* progress) {
  for (;;) {
    RequireSolvable(*problem);
    system->emplace(*problem, KeptFactors::kMaxBytes);
    (*system)->Form(state, weighting, progress);
    if ((*system)->weak_points().empty()) return;
    LeaveOutWeakPoints(**system, problem);
  }
}

}  // namespace sarblock
