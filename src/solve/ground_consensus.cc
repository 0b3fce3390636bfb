// SPDX-License-Identifier: Apache-2.0
#include "ground_consensus.h"

#include "sarblock/core/statistics.h"
#include "sarblock/geometry/intersection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "core/threads.h"
#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace sarblock {
namespace {

constexpr std::size_t kPointsAChunk = 512;
/// Looks that a look of a point is compared with: all up to twice as many, else so many neighbours.
constexpr std::size_t kMostPartners = 4;
/// Common points below which a pair of passes says nothing of one of them, and below which their
/// differences are compared with a constant alone.
constexpr std::size_t kLeastCommon = 4;
constexpr std::size_t kLeastForSlopes = 8;
/// Common points from which second powers are fitted too.
constexpr std::size_t kLeastForSquares = 24;
/// Minimal sets of three points; with every second point wrong one of eight is clean.
constexpr int kTrials = 60;
/// Length of a difference that still agrees, squared, in robust standard deviations; terrain is not
/// normal, and what is left out here is judged again later.
constexpr double kAgrees_1 = 36.0;
/// A pair in which fewer of the points agree has no consensus.
constexpr double kLeastAgreeing_1 = 0.5;
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
      if (columns == 3 || terms_.size() >= kLeastForSquares) Refine(columns, &covariance);
    }
    JudgeBy(covariance);
    return covariance.trace();
  }

  /// The same of few common points: their own median, and a variance that other pairs have.
  void JudgeFew(double variance_m2) {
    FitMedian();
    JudgeBy(WithFloor(variance_m2 * Eigen::Matrix2d::Identity()));
  }

 private:
  void JudgeBy(const Eigen::Matrix2d& covariance) {
    std::size_t agreeing = 0;
    for (std::size_t i = 0; i < terms_.size(); ++i) {
      begin_[i].agrees = Distance(i, covariance) <= kAgrees_1;
      agreeing += begin_[i].agrees ? 1U : 0U;
    }
    const bool consensus =
        static_cast<double>(agreeing) >= kLeastAgreeing_1 * static_cast<double>(terms_.size());
    for (Common* c = begin_; c != end_; ++c) c->known = consensus;
  }

  [[nodiscard]] Eigen::Vector2d Rest(std::size_t i) const {
    return begin_[i].difference_m - fit_.transpose() * terms_[i];
  }
  [[nodiscard]] double Distance(std::size_t i, const Eigen::Matrix2d& covariance) const {
    const Eigen::Vector2d rest = Rest(i);
    return rest.dot(covariance.ldlt().solve(rest));
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
      fit_.topRows<3>() = a.partialPivLu().solve(d);
      const double median = MedianSquare(&squares);
      if (median < least) {
        least = median;
        best = fit_;
      }
    }
    fit_ = best;
  }

  /// Of the half that fits best; its squares stand for all of a normal distribution.
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
    return WithFloor(few * few * sum / (0.143 * static_cast<double>(half)));
  }

  [[nodiscard]] static Eigen::Matrix2d WithFloor(const Eigen::Matrix2d& covariance) {
    return covariance + (1e-6 + 1e-12 * covariance.trace()) * Eigen::Matrix2d::Identity();
  }

  /// Least squares and covariance of what agrees.
  void Refine(int columns, Eigen::Matrix2d* covariance) {
    Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
    Fit right = Fit::Zero();
    std::vector<std::size_t> inliers;
    for (std::size_t i = 0; i < terms_.size(); ++i) {
      if (Distance(i, *covariance) > kAgrees_1) continue;
      inliers.push_back(i);
      normal += terms_[i] * terms_[i].transpose();
      right += terms_[i] * begin_[i].difference_m.transpose();
    }
    if (inliers.size() < kLeastForSlopes) return;
    // A direction without a spread of points keeps no slope.
    normal.diagonal().array() += 1e-9 * static_cast<double>(inliers.size());
    fit_.setZero();
    fit_.topRows(columns) =
        normal.topLeftCorner(columns, columns).ldlt().solve(right.topRows(columns));
    Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
    for (const std::size_t i : inliers) sum += Rest(i) * Rest(i).transpose();
    *covariance = WithFloor(sum / (static_cast<double>(inliers.size()) - columns));
  }

  Common* begin_;
  Common* end_;
  std::vector<Terms> terms_;
  Fit fit_ = Fit::Zero();
};

/// Leaves the looks of a point that contradict most others, one after the other; of several that
/// contradict as many all are left out: nothing tells which is wrong.
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
        const std::optional<Sight> sight = problem.model.SightOf(i, none);
        if (!sight) continue;
        const Intersection met = IntersectWithHeight(*sight, block.frame, height_m);
        if (met.outcome == IntersectionOutcome::kDetermined) out.place_m[i] = met.position_m;
      }
    }
  });

  std::vector<Common> common;
  for (std::size_t point = 0; point < points; ++point) {
    const std::size_t begin = offsets[point], count = offsets[point + 1] - begin;
    const std::size_t partners = count <= 2 * kMostPartners + 1 ? count : kMostPartners;
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
      if (count_of(pair) < kLeastForSlopes) continue;
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
      const bool few = count_of(pair) >= kLeastCommon && count_of(pair) < kLeastForSlopes;
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

}  // namespace sarblock
