// SPDX-License-Identifier: Apache-2.0
#include "consensus.h"

#include "sarblock/core/statistics.h"
#include "sarblock/geometry/intersection.h"
#include "sarblock/geometry/look_equations.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include "core/threads.h"
#include "linear/dense.h"
#include "normals/point.h"
#include "reduced_engine.h"
#include "solve_block.h"
#include "start.h"
#include "structure.h"
#include <Eigen/LU>

namespace sarblock {
namespace {

constexpr std::size_t kPointsAChunk = 512;
/// Looks that a look of a point is compared with: all up to twice as many, else so many neighbours.
constexpr std::size_t kMaxPartners = 4;
/// Common points below which a pair of passes says nothing of one of them, and below which their
/// differences are compared with a constant alone.
constexpr std::size_t kMinCommon = 4;
constexpr std::size_t kMinForSlopes = 8;
/// Common points from which second powers are fitted too.
constexpr std::size_t kMinForSquares = 24;
/// Minimal sets of three points; with every second point wrong one of eight is clean.
constexpr int kTrials = 60;
/// Length of a difference that still agrees, squared, in robust standard deviations; terrain is not
/// normal, and what is left out here is judged again later.
constexpr double kAgrees = 36.0;
/// A pair in which fewer of the points agree has no consensus.
constexpr double kMinAgreeing = 0.5;
constexpr std::uint64_t kSeed = 20261122;

/// A point that two passes see.
struct Common {
  std::uint32_t pass_a = 0, pass_b = 0;
  std::uint64_t look_a = 0, look_b = 0;
  Eigen::Vector2d difference_m = Eigen::Vector2d::Zero();  // east, north
  bool agrees = true, known = false;
};

using Terms = Eigen::Matrix<double, 6, 1>;
using Fit = Eigen::Matrix<double, 6, 2>;

class PairFit {
 public:
  PairFit(const Looks& looks, Common* begin, Common* end) : begin_(begin), end_(end) {
    const auto limits = [&](const std::vector<double>& column) {
      std::array<double, 2> out = {HUGE_VAL, -HUGE_VAL};
      for (const Common* c = begin; c != end; ++c) {
        out = {std::min(out[0], column[c->look_a]), std::max(out[1], column[c->look_a])};
      }
      return out;
    };
    const std::array<double, 2> time = limits(looks.time_s), range = limits(looks.range_m);
    // Looks of one time differ along track in their Dopplers.
    const bool by_doppler = time[0] == time[1] && !looks.cone.empty();
    const std::vector<double>& along = by_doppler ? looks.cone : looks.time_s;
    const std::array<double, 2> from_to = by_doppler ? limits(looks.cone) : time;
    const auto scaled = [](double value, const std::array<double, 2>& span) {
      const double half = 0.5 * (span[1] - span[0]);
      return half > 0.0 ? (value - 0.5 * (span[0] + span[1])) / half : 0.0;
    };
    for (const Common* c = begin; c != end; ++c) {
      const double t = scaled(along[c->look_a], from_to);
      const double r = scaled(looks.range_m[c->look_a], range);
      Terms& terms = terms_.emplace_back();
      terms << 1.0, t, r, t * t, t * r, r * r;
    }
  }

  /// Judges every common point of a pair with enough of them; returns the variance of what agrees,
  /// both components together.
  double Judge(std::uint64_t stream) {
    FitLeastMedian(stream);
    Eigen::Matrix2d covariance = InnerCovariance();
    for (const int columns : {3, 3, 6, 6}) {
      if (columns == 3 || terms_.size() >= kMinForSquares) Refine(columns, &covariance);
    }
    JudgeBy(covariance);
    return covariance.trace();
  }

  /// The same of few common points: their own median, and a variance that other pairs have.
  void JudgeFew(double variance_m2) {
    FitMedian();
    JudgeBy(AddFloor(variance_m2 * Eigen::Matrix2d::Identity()));
  }

 private:
  void JudgeBy(const Eigen::Matrix2d& covariance) {
    std::size_t agreeing = 0;
    for (std::size_t i = 0; i < terms_.size(); ++i) {
      begin_[i].agrees = Distance(i, covariance) <= kAgrees;
      agreeing += begin_[i].agrees ? 1U : 0U;
    }
    const bool consensus =
        static_cast<double>(agreeing) >= kMinAgreeing * static_cast<double>(terms_.size());
    for (Common* c = begin_; c != end_; ++c) c->known = consensus;
  }

  [[nodiscard]] Eigen::Vector2d Rest(std::size_t i) const {
    return begin_[i].difference_m - fit_.transpose() * terms_[i];
  }
  [[nodiscard]] double Distance(std::size_t i, const Eigen::Matrix2d& covariance) const {
    const Eigen::Vector2d rest = Rest(i);
    return rest.dot(covariance.inverse() * rest);
  }

  [[nodiscard]] double MedianSquare(std::vector<double>* squares) const {
    squares->clear();
    for (std::size_t i = 0; i < terms_.size(); ++i) squares->push_back(Rest(i).squaredNorm());
    return MedianInPlace(squares);
  }

  /// The median of each component.
  void FitMedian() {
    std::vector<double> values;
    for (int axis = 0; axis < 2; ++axis) {
      values.clear();
      for (const Common* c = begin_; c != end_; ++c) values.push_back(c->difference_m[axis]);
      fit_(0, axis) = MedianInPlace(&values);
    }
  }

  /// Rousseeuw (1984): the plane through three points whose median square is least.
  void FitLeastMedian(std::uint64_t stream) {
    RandomStream random(kSeed, stream);
    const auto draw = [&] {
      const auto count = static_cast<double>(terms_.size());
      return std::min(terms_.size() - 1, static_cast<std::size_t>(random.Uniform() * count));
    };
    std::vector<double> squares;
    Fit best = Fit::Zero();
    double least = HUGE_VAL;
    for (int trial = 0; trial < kTrials; ++trial) {
      const std::array<std::size_t, 3> chosen = {draw(), draw(), draw()};
      Eigen::Matrix3d a;
      Eigen::Matrix<double, 3, 2> d;
      for (int k = 0; k < 3; ++k) {
        const std::size_t i = chosen[static_cast<std::size_t>(k)];
        a.row(k) = terms_[i].head<3>().transpose();
        d.row(k) = begin_[i].difference_m.transpose();
      }
      if (!(std::abs(a.determinant()) > 1e-2)) continue;
      fit_.setZero();
      fit_.topRows<3>() = a.inverse() * d;
      const double median = MedianSquare(&squares);
      if (median < least) {
        least = median;
        best = fit_;
      }
    }
    fit_ = best;
  }

  /// Covariance from the half that fits best, scaled to represent all of a normal distribution.
  [[nodiscard]] Eigen::Matrix2d InnerCovariance() const {
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < terms_.size(); ++i) order.emplace_back(Rest(i).squaredNorm(), i);
    std::sort(order.begin(), order.end());
    Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
    const std::size_t half = order.size() / 2 + 1;
    for (std::size_t k = 0; k < half; ++k) {
      const Eigen::Vector2d rest = Rest(order[k].second);
      sum += rest * rest.transpose();
    }
    // E |x|^2 of the inner half of a line's normal distribution is 0.143, of a plane's 0.307.
    // A fit to few points comes nearer to them than they are spread (Rousseeuw and Leroy 1987).
    const double few = 1.0 + 5.0 / (static_cast<double>(order.size()) - 3.0);
    return AddFloor(few * few * sum / (0.143 * static_cast<double>(half)));
  }

  [[nodiscard]] static Eigen::Matrix2d AddFloor(const Eigen::Matrix2d& covariance) {
    return covariance + (1e-6 + 1e-12 * covariance.trace()) * Eigen::Matrix2d::Identity();
  }

  /// Least squares and covariance of what agrees.
  void Refine(int columns, Eigen::Matrix2d* covariance) {
    Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
    Fit right = Fit::Zero();
    std::vector<std::size_t> inliers;
    for (std::size_t i = 0; i < terms_.size(); ++i) {
      if (Distance(i, *covariance) > kAgrees) continue;
      inliers.push_back(i);
      normal += terms_[i] * terms_[i].transpose();
      right += terms_[i] * begin_[i].difference_m.transpose();
    }
    if (inliers.size() < kMinForSlopes) return;
    // A direction without a spread of points keeps no slope.
    normal.diagonal().array() += 1e-9 * static_cast<double>(inliers.size());
    fit_.setZero();
    const Eigen::MatrixXd of_columns = right.topRows(columns);
    fit_.topRows(columns) =
        dense::PivotedCholesky(normal.topLeftCorner(columns, columns)).Solve(of_columns);
    Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
    for (const std::size_t i : inliers) sum += Rest(i) * Rest(i).transpose();
    *covariance = AddFloor(sum / (static_cast<double>(inliers.size()) - columns));
  }

  Common* begin_;
  Common* end_;
  std::vector<Terms> terms_;
  Fit fit_ = Fit::Zero();
};

/// Leaves the looks of a point that contradict most others, one after the other; of several that
/// contradict as many all are left out: none can be identified as wrong.
void JudgePoint(std::size_t begin,
                std::size_t end,
                const std::vector<std::pair<std::uint64_t, std::uint64_t>>& contradictions,
                std::vector<std::uint8_t>* agrees) {
  std::vector<int> count(end - begin, 0);
  for (;;) {
    std::fill(count.begin(), count.end(), 0);
    for (const auto& [a, b] : contradictions) {
      if ((*agrees)[a] == 0 || (*agrees)[b] == 0) continue;
      ++count[a - begin];
      ++count[b - begin];
    }
    const int most = *std::max_element(count.begin(), count.end());
    if (most == 0) return;
    for (std::size_t i = begin; i < end; ++i) {
      if (count[i - begin] == most) (*agrees)[i] = 0;
    }
  }
}

}  // namespace

GroundConsensus FindGroundConsensus(const AdjustmentProblem& problem, double reference_height_m) {
  const Block& block = problem.block;
  const auto& offsets = block.looks.offsets;
  const std::size_t points = block.points.size();
  GroundConsensus out;
  out.place_m.assign(block.looks.size(), Eigen::Vector3d::Constant(kNotGiven));
  out.agrees.assign(block.looks.size(), 1);
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(problem.layout.size());
  ParallelForChunks(points, kPointsAChunk, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t point = begin; point < end; ++point) {
      const bool control = problem.control_of[point] >= 0;
      const double height_m = control ? block.frame.VerticalAt(block.points.given_m[point]).height_m
                                      : reference_height_m;
      for (std::size_t i = offsets[point]; i < offsets[point + 1]; ++i) {
        if (block.looks.rejected(i)) continue;
        const std::optional<FixedPathLook> observation = problem.model.FixPath(i, none);
        if (!observation) continue;
        const Intersection met = IntersectWithHeight(*observation, block.frame, height_m);
        if (met.outcome == IntersectionOutcome::kDetermined) out.place_m[i] = met.position_m;
      }
    }
  });

  std::vector<Common> common;
  for (std::size_t point = 0; point < points; ++point) {
    const std::size_t begin = offsets[point], count = offsets[point + 1] - begin;
    const std::size_t partners = count <= 2 * kMaxPartners + 1 ? count : kMaxPartners;
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t k = 1; k <= partners; ++k) {
        std::size_t a = begin + i, b = begin + (i + k) % count;
        const bool once = partners < count || i + k < count;
        if (!once || a == b || !out.place_m[a].allFinite() || !out.place_m[b].allFinite()) continue;
        if (a > b) std::swap(a, b);
        if (block.looks.pass[a] == block.looks.pass[b]) continue;
        const Eigen::Vector3d d_m =
            block.frame.EnuFromFrame(out.place_m[a]) * (out.place_m[b] - out.place_m[a]);
        common.push_back({block.looks.pass[a], block.looks.pass[b], a, b, d_m.head<2>()});
      }
    }
  }
  std::stable_sort(common.begin(), common.end(), [](const Common& x, const Common& y) {
    return std::pair(x.pass_a, x.pass_b) < std::pair(y.pass_a, y.pass_b);
  });
  std::vector<std::size_t> pair_begin;
  for (std::size_t i = 0; i < common.size(); ++i) {
    const bool first = i == 0 || common[i].pass_a != common[i - 1].pass_a ||
                       common[i].pass_b != common[i - 1].pass_b;
    if (first) pair_begin.push_back(i);
  }
  pair_begin.push_back(common.size());
  const std::size_t pairs = pair_begin.size() - 1;
  std::vector<double> variances_m2(pairs, kNotGiven);
  const auto fit_of = [&](std::size_t pair) {
    return PairFit(
        block.looks, common.data() + pair_begin[pair], common.data() + pair_begin[pair + 1]);
  };
  const auto count_of = [&](std::size_t pair) { return pair_begin[pair + 1] - pair_begin[pair]; };
  ParallelForChunks(pairs, 1, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t pair = begin; pair < end; ++pair) {
      if (count_of(pair) < kMinForSlopes) continue;
      const Common& first = common[pair_begin[pair]];
      variances_m2[pair] = fit_of(pair).Judge(MixStream(first.pass_a, first.pass_b));
    }
  });
  std::vector<double> known_m2;
  for (const double variance_m2 : variances_m2) {
    if (std::isfinite(variance_m2)) known_m2.push_back(variance_m2);
  }
  if (!known_m2.empty()) {
    const auto upper = known_m2.begin() + static_cast<std::ptrdiff_t>(3 * known_m2.size() / 4);
    std::nth_element(known_m2.begin(), upper, known_m2.end());
    const double variance_m2 = *upper;
    for (std::size_t pair = 0; pair < pairs; ++pair) {
      const bool few = count_of(pair) >= kMinCommon && count_of(pair) < kMinForSlopes;
      if (few) fit_of(pair).JudgeFew(variance_m2);
    }
  }

  std::sort(common.begin(), common.end(), [](const Common& x, const Common& y) {
    return std::pair(x.look_a, x.look_b) < std::pair(y.look_a, y.look_b);
  });
  std::vector<std::pair<std::uint64_t, std::uint64_t>> contradictions;
  std::size_t next = 0;
  for (std::size_t point = 0; point < points; ++point) {
    contradictions.clear();
    for (; next < common.size() && common[next].look_a < offsets[point + 1]; ++next) {
      if (!common[next].known || common[next].agrees) continue;
      contradictions.emplace_back(common[next].look_a, common[next].look_b);
    }
    if (contradictions.empty()) continue;
    JudgePoint(offsets[point], offsets[point + 1], contradictions, &out.agrees);
  }
  return out;
}

namespace {

constexpr double kMeet = 0.999;
/// Pairs that are tried, those of looks far apart in the order of passes first.
constexpr std::size_t kMaxPairs = 36;

bool Meets(const Frame& frame,
           const std::vector<FixedPathLook>& observations,
           double variance,
           Intersection* met) {
  *met = Intersect(observations, frame);
  if (met->outcome != IntersectionOutcome::kDetermined &&
      met->outcome != IntersectionOutcome::kCirclesDoNotMeet) {
    return false;
  }
  const double freedom = 2.0 * static_cast<double>(observations.size()) - 3.0;
  return met->weighted_square_sum <= variance * ChiSquareQuantile(kMeet, freedom) &&
         std::all_of(
             observations.begin(), observations.end(), [&](const FixedPathLook& observation) {
               return LiesWhereItLooks(frame, observation, met->position_m);
             });
}

/// All pairs of `count` looks, those farthest apart first.
std::vector<std::pair<std::size_t, std::size_t>> PairsOf(std::size_t count) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t apart = count - 1; apart > 0; --apart) {
    for (std::size_t i = 0; i + apart < count && pairs.size() < kMaxPairs; ++i) {
      pairs.emplace_back(i, i + apart);
    }
  }
  return pairs;
}

}  // namespace

PointConsensus FindPointConsensus(const AdjustmentProblem& problem,
                                  const BlockState& state,
                                  std::size_t point,
                                  double variance) {
  const Block& block = problem.block;
  PointConsensus out;
  std::vector<FixedPathLook> observations;
  for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
    if (block.looks.rejected(i)) continue;
    if (const auto observation = problem.model.FixPath(i, state.corrections)) {
      observations.push_back(*observation);
      out.looks.push_back(i);
    }
  }
  if (observations.size() < 2) return out;
  Intersection met;
  if (Meets(block.frame, observations, variance, &met)) {
    out.outcome = PointConsensus::Outcome::kAgree;
    out.position_m = met.position_m;
    out.weighted_square_sum = met.weighted_square_sum;
    return out;
  }
  out.position_m = met.position_m;
  out.weighted_square_sum = met.weighted_square_sum;
  out.outcome = met.outcome == IntersectionOutcome::kCirclesCoincide ||
                        met.outcome == IntersectionOutcome::kCirclesTouch ||
                        met.outcome == IntersectionOutcome::kAmbiguous
                    ? PointConsensus::Outcome::kOpen
                    : PointConsensus::Outcome::kContradict;
  if (observations.size() == 2) return out;

  std::vector<std::size_t> best;
  Intersection best_met;
  bool alone = true;
  for (const auto& [a, b] : PairsOf(observations.size())) {
    std::vector<FixedPathLook> set = {observations[a], observations[b]};
    Intersection at;
    if (!Meets(block.frame, set, variance, &at)) continue;
    std::vector<std::size_t> members = {a, b};
    for (std::size_t k = 0; k < observations.size(); ++k) {
      if (k == a || k == b) continue;
      set.push_back(observations[k]);
      Intersection with;
      if (Meets(block.frame, set, variance, &with)) {
        members.push_back(k);
        at = with;
      } else {
        set.pop_back();
      }
    }
    std::sort(members.begin(), members.end());
    if (members.size() < best.size() || members == best) continue;
    alone = members.size() > best.size();
    if (!alone) continue;
    best = members;
    best_met = at;
  }
  if (best.empty() || !alone) return out;
  std::vector<std::size_t> kept;
  for (const std::size_t k : best) kept.push_back(out.looks[k]);
  out.outcome = PointConsensus::Outcome::kMajority;
  out.looks = std::move(kept);
  out.position_m = best_met.position_m;
  out.weighted_square_sum = best_met.weighted_square_sum;
  return out;
}

namespace {

constexpr std::size_t kJudgedPerChunk = 256;
/// Last scale of Cauchy's loss: 95 percent efficiency at the normal distribution.
constexpr double kLastScale = 2.385;
/// From one scale of the graduated loss to the next.
constexpr double kScaleStep = 3.0;
constexpr int kMaxStepsOfScale = 12, kMaxLastSteps = 40;
constexpr int kMaxJudgements = 8;
/// Looks of a control point this far (squared) from where it is known to be are left out.
constexpr double kFar = 0.999;
constexpr double kMaxPartOfPass = 0.5;

/// Takes everything in again that has equations enough.
void TakeAll(AdjustmentProblem* problem) {
  const Block& block = problem->block;
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(problem->layout.size());
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    const PointStatus status = problem->point_status[point];
    if (status == PointStatus::kNotSeen || status == PointStatus::kTooFewLooks) continue;
    std::vector<std::size_t> looks;
    for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      problem->look_used[i] = 0;
      if (!block.looks.rejected(i) && problem->model.FixPath(i, none)) looks.push_back(i);
    }
    problem->TakeBack(point, looks);
  }
}

/// The median height of the control, else of the start positions, else of the ellipsoid.
double ReferenceHeight_m(const AdjustmentProblem& problem, const BlockState& state) {
  std::vector<double> heights_m;
  for (const ControlEquations& control : problem.control) {
    heights_m.push_back(problem.block.frame.VerticalAt(control.known_m).height_m);
  }
  if (heights_m.empty()) {
    for (const Eigen::Vector3d& start_m : state.start_m) {
      if (start_m.allFinite()) {
        heights_m.push_back(problem.block.frame.VerticalAt(start_m).height_m);
      }
    }
  }
  const double median_m = MedianInPlace(&heights_m);
  return std::isfinite(median_m) ? median_m : 0.0;
}

/// Points start on the ground, at the mean of the places of their looks that agree; what agrees
/// takes part. False where nothing is left.
void StartOnGround(const GroundConsensus& ground, AdjustmentProblem* problem, BlockState* state) {
  const Block& block = problem->block;
  for (std::size_t point = 0; point < block.points.size(); ++point) {
    if (!problem->Solves(point)) continue;
    const bool known = problem->control_of[point] >= 0 && block.points.given_m[point].allFinite();
    Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
    int used = 0;
    for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
      if (problem->look_used[i] == 0) continue;
      if (ground.agrees[i] == 0 || !ground.place_m[i].allFinite()) {
        problem->look_used[i] = 0;
        continue;
      }
      sum_m += ground.place_m[i];
      ++used;
    }
    state->displacement_m[point].setZero();
    if (known) {
      state->start_m[point] = block.points.given_m[point];
    } else if (used >= 2) {
      state->start_m[point] = sum_m / used;
    } else {
      problem->LeaveOut(point, PointStatus::kUndetermined, "");
    }
  }
}

/// Whitened lengths of all looks in use.
std::vector<double> LengthsOf(const AdjustmentProblem& problem, const BlockState& state) {
  std::vector<double> lengths;
  WhitenedLook at;
  const auto& offsets = problem.block.looks.offsets;
  for (std::size_t point = 0; point < problem.block.points.size(); ++point) {
    if (!problem.Solves(point)) continue;
    for (std::size_t i = offsets[point]; i < offsets[point + 1]; ++i) {
      if (problem.look_used[i] == 0) continue;
      if (EvaluateWhitened(problem, state, {}, point, i, &at)) {
        lengths.push_back(at.whitened_error.norm());
      }
    }
  }
  return lengths;
}

int SolveAt(double scale,
            int most_steps,
            const AdjustOptions& options,
            AdjustmentProblem* problem,
            BlockState* state,
            ProgressSink* progress) {
  SolveOptions solve;
  solve.max_iterations = most_steps;
  solve.threads = options.threads;
  solve.settle_below = 0.1;
  // Under a loss with many minima a point that settles on a path far off takes the nearest one.
  solve.points_follow = false;
  const Weighting weighting{RobustLoss::kCauchy, scale};
  return SolveReduced(*problem, weighting, solve, state, progress).iterations;
}

/// Priors of a problem as long as looks count as so many times less accurate than they are: what is
/// believed of a look is then no more than what is believed of a path.
class TemperedPriors {
 public:
  explicit TemperedPriors(AdjustmentProblem* problem)
      : parameters_(problem->layout.parameters),
        joint_(problem->layout.joint_priors),
        given_(joint_) {
    for (const Parameter& parameter : parameters_) {
      sigma_.push_back({parameter.prior_sigma, parameter.step_sigma});
    }
  }
  ~TemperedPriors() { Divide(1.0); }
  TemperedPriors(const TemperedPriors&) = delete;
  TemperedPriors& operator=(const TemperedPriors&) = delete;
  void Divide(double factor) {
    for (std::size_t i = 0; i < sigma_.size(); ++i) {
      parameters_[i].prior_sigma = sigma_[i][0] / factor;
      parameters_[i].step_sigma = sigma_[i][1] / factor;
    }
    for (std::size_t i = 0; i < joint_.size(); ++i) {
      joint_[i] = given_[i];
      if (factor != 1.0) joint_[i].Set(given_[i].covariance / (factor * factor));
    }
  }

 private:
  std::vector<Parameter>& parameters_;
  std::vector<JointPriorTerm>& joint_;
  std::vector<JointPriorTerm> given_;
  std::vector<std::array<PriorSigma, 2>> sigma_;  // of the prior and of the step of a process
};

/// Graduated non-convexity: from a scale at which every look that agrees on the ground counts.
int SolveGraduated(const AdjustOptions& options,
                   AdjustmentProblem* problem,
                   BlockState* state,
                   ProgressSink* progress) {
  std::vector<double> lengths = LengthsOf(*problem, *state);
  double scale = std::max(kLastScale, 2.0 * MedianInPlace(&lengths));
  int iterations = 0;
  TemperedPriors priors(problem);
  for (; scale > kLastScale; scale /= kScaleStep) {
    priors.Divide(scale / kLastScale);
    iterations += SolveAt(scale, kMaxStepsOfScale, options, problem, state, progress);
  }
  priors.Divide(1.0);
  return iterations + SolveAt(kLastScale, kMaxLastSteps, options, problem, state, progress);
}

/// How much more than noise keeps the circles of all points apart: the lower quartile of v'Pv over
/// its expectation, which gross errors leave alone, 1 at least.
double VarianceOf(const AdjustmentProblem& problem, const BlockState& state) {
  const Block& block = problem.block;
  std::vector<double> ratios(block.points.size(), kNotGiven);
  ParallelForChunks(
      block.points.size(), kJudgedPerChunk, [&](std::size_t, std::size_t begin, std::size_t end) {
        std::vector<FixedPathLook> observations;
        for (std::size_t point = begin; point < end; ++point) {
          if (!problem.Solves(point)) continue;
          observations.clear();
          for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1];
               ++i) {
            if (problem.look_used[i] == 0) continue;
            const auto observation = problem.model.FixPath(i, state.corrections);
            if (observation) observations.push_back(*observation);
          }
          if (observations.size() < 2) continue;
          const double freedom = 2.0 * static_cast<double>(observations.size()) - 3.0;
          ratios[point] = Intersect(observations, block.frame).weighted_square_sum /
                          ChiSquareQuantile(0.25, freedom);
        }
      });
  std::vector<double> finite;
  for (const double ratio : ratios) {
    if (std::isfinite(ratio)) finite.push_back(ratio);
  }
  if (finite.empty()) return 1.0;
  const auto quarter = finite.begin() + static_cast<std::ptrdiff_t>(finite.size() / 4);
  std::nth_element(finite.begin(), quarter, finite.end());
  return std::max(1.0, *quarter);
}

/// Consensus of a control point whose looks contradict each other: those near its known position;
/// all where none or every one is near. Looks that agree are not judged by the known position,
/// which may be wrong itself: the search for blunders compares them.
PointConsensus ConsensusOfControl(const AdjustmentProblem& problem,
                                  const BlockState& state,
                                  std::size_t point,
                                  double variance) {
  const Block& block = problem.block;
  const double limit = variance * ChiSquareQuantile(kFar, 2.0);
  PointConsensus out = FindPointConsensus(problem, state, point, variance);
  if (out.outcome == PointConsensus::Outcome::kAgree ||
      out.outcome == PointConsensus::Outcome::kMajority) {
    return out;
  }
  out.position_m = state.Position(point);
  out.looks.clear();
  std::vector<std::size_t> all;
  WhitenedLook at;
  for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
    if (block.looks.rejected(i) || !problem.model.FixPath(i, state.corrections)) continue;
    all.push_back(i);
    if (EvaluateWhitened(problem, state, {}, point, i, &at) &&
        at.whitened_error.squaredNorm() <= limit) {
      out.looks.push_back(i);
    }
  }
  const bool every = out.looks.empty() || out.looks.size() == all.size();
  out.outcome = every ? PointConsensus::Outcome::kAgree : PointConsensus::Outcome::kMajority;
  if (every) out.looks = std::move(all);
  return out;
}

/// Every point and look is judged again on the paths of the state and takes part accordingly;
/// true where that changed anything.
bool JudgePoints(AdjustmentProblem* problem, BlockState* state, ConsensusReport* report) {
  const Block& block = problem->block;
  const double variance = VarianceOf(*problem, *state);
  const std::size_t points = block.points.size();
  std::vector<PointConsensus> found(points);
  const auto takes_part = [&](std::size_t point) {
    const PointStatus status = problem->point_status[point];
    return status != PointStatus::kNotSeen && status != PointStatus::kTooFewLooks;
  };
  ParallelForChunks(points, kJudgedPerChunk, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t point = begin; point < end; ++point) {
      if (!takes_part(point)) continue;
      found[point] = problem->control_of[point] >= 0
                         ? ConsensusOfControl(*problem, *state, point, variance)
                         : FindPointConsensus(*problem, *state, point, variance);
    }
  });
  bool changed = false;
  report->left_out.clear();
  for (std::size_t point = 0; point < points; ++point) {
    if (!takes_part(point)) continue;
    const PointConsensus& of = found[point];
    const std::size_t begin = block.looks.offsets[point], end = block.looks.offsets[point + 1];
    const std::vector<std::uint8_t> before(
        problem->look_used.begin() + static_cast<std::ptrdiff_t>(begin),
        problem->look_used.begin() + static_cast<std::ptrdiff_t>(end));
    const bool control = problem->control_of[point] >= 0;
    const bool agrees = of.outcome == PointConsensus::Outcome::kAgree ||
                        of.outcome == PointConsensus::Outcome::kMajority;
    ConsensusReport::PointRejection entry;
    entry.point = point;
    if (agrees) {
      for (std::size_t i = begin; i < end; ++i) problem->look_used[i] = 0;
      problem->TakeBack(point, of.looks);
      if (!control) {
        state->start_m[point] = of.position_m;
        state->displacement_m[point].setZero();
      }
      for (std::size_t i = begin; i < end; ++i) {
        if (!block.looks.rejected(i) && problem->look_used[i] == 0) entry.looks.push_back(i);
      }
    } else if (of.outcome == PointConsensus::Outcome::kContradict) {
      entry.looks = of.looks;
      entry.contradiction = true;
      state->start_m[point] = of.position_m;
      state->displacement_m[point].setZero();
      std::string text = "its looks contradict each other and none can be identified as wrong: ";
      for (std::size_t k = 0; k < of.looks.size(); ++k) {
        text += (k == 0 ? "" : ", ") + block.passes[block.looks.pass[of.looks[k]]].id;
      }
      problem->LeaveOut(point, PointStatus::kApart, text);
    } else {
      problem->LeaveOut(point, PointStatus::kUndetermined, "its looks leave a direction open");
    }
    if (!entry.looks.empty()) {
      WhitenedLook at;
      for (const std::size_t look : entry.looks) {
        if (!EvaluateWhitened(*problem, *state, {}, point, look, &at)) continue;
        if (at.whitened_error.norm() <= entry.distance) continue;
        entry.distance = at.whitened_error.norm();
        entry.azimuth = std::abs(at.whitened_error[1]) > std::abs(at.whitened_error[0]);
      }
      report->left_out.push_back(std::move(entry));
    }
    changed =
        changed || !std::equal(before.begin(),
                               before.end(),
                               problem->look_used.begin() + static_cast<std::ptrdiff_t>(begin));
  }
  UpdateWeights(*state, problem);
  return changed;
}

}  // namespace

ConsensusReport SolveByConsensus(const AdjustOptions& options,
                                 AdjustmentProblem* problem,
                                 BlockState* state,
                                 ProgressSink* progress) {
  ConsensusReport report;
  TakeAll(problem);
  const PassConnection connection = ConnectPasses(*problem);
  Step(progress, "consensus", 0, 0);
  StartOnGround(FindGroundConsensus(*problem, ReferenceHeight_m(*problem, *state)), problem, state);
  state->corrections.setZero();
  UpdateWeights(*state, problem);
  report.iterations = SolveGraduated(options, problem, state, progress);
  for (int round = 0; round < kMaxJudgements; ++round) {
    bool changed = JudgePoints(problem, state, &report);
    if (round + 1 < kMaxJudgements && RelocatePasses(*problem, state)) {
      changed = JudgePoints(problem, state, &report) || changed;
    }
    if (!changed) break;
    report.iterations += SolveAt(kLastScale, kMaxLastSteps, options, problem, state, progress);
  }
  report.scattered = connection.IsKeptBy(ConnectPasses(*problem));
  for (const PassLooks& of_pass : CountPassLooks(problem->block, problem->look_used)) {
    report.scattered =
        report.scattered && of_pass.all.LostShare() <= kMaxPartOfPass && of_pass.deciding.Decide();
  }
  return report;
}

}  // namespace sarblock
