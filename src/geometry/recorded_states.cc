// SPDX-License-Identifier: Apache-2.0
#include "recorded_states.h"

#include "sarblock/core/statistics.h"
#include "sarblock/geometry/path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/text.h"
#include "smooth_path.h"
#include <Eigen/Geometry>

namespace sarblock {

// ---- what is wrong with them

std::optional<CloseStates> FindCloseStates(std::span<const StateVector> states) {
  if (states.size() < 2) return std::nullopt;
  std::vector<double> intervals_s;
  for (std::size_t k = 1; k < states.size(); ++k) {
    intervals_s.push_back(states[k].time_s - states[k - 1].time_s);
  }
  std::vector<double> sorted_s = intervals_s;
  const auto upper = sorted_s.begin() + static_cast<std::ptrdiff_t>(sorted_s.size() * 3 / 4);
  std::nth_element(sorted_s.begin(), upper, sorted_s.end());
  constexpr std::size_t kMinIntervals = 4;
  const double usual_s = sorted_s.size() < kMinIntervals ? 0.0 : *upper;
  constexpr double kPart = 1e-3, kAcceleration_mps2 = 1.0;
  constexpr double kRounding = std::numeric_limits<double>::epsilon();
  for (std::size_t k = 1; k < states.size(); ++k) {
    const double size_m = states[k - 1].position_m.norm() + states[k].position_m.norm();
    const double rounding_s = std::sqrt(6.0 * kRounding * size_m / kAcceleration_mps2);
    if (intervals_s[k - 1] >= std::max(kPart * usual_s, rounding_s)) continue;
    return CloseStates{k, intervals_s[k - 1], usual_s};
  }
  return std::nullopt;
}

std::string Describe(const CloseStates& close) {
  return Digits(close.apart_s, 3) + " s apart: their difference is rounding and noise, no motion" +
         (close.usual_s > 0.0 ? " (states are usually " + Digits(close.usual_s, 3) + " s apart)"
                              : "") +
         "; remove one of them, or one of two merged orbits";
}

namespace {

constexpr std::size_t kDifferenceOrder = 8, kMinDifferences = 12;

/// Weights of the divided difference of nine times, the sum of their absolute values one; of an
/// alternation of +-1 they make +-1.
std::array<double, kDifferenceOrder + 1> DifferenceWeights(std::span<const StateVector> nine) {
  std::array<double, kDifferenceOrder + 1> weights{};
  const double scale_s = (nine[kDifferenceOrder].time_s - nine[0].time_s) / kDifferenceOrder;
  double sum = 0.0;
  for (std::size_t i = 0; i <= kDifferenceOrder; ++i) {
    weights[i] = 1.0;
    for (std::size_t j = 0; j <= kDifferenceOrder; ++j) {
      if (j != i) weights[i] *= scale_s / (nine[i].time_s - nine[j].time_s);
    }
    sum += std::abs(weights[i]);
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

/// A sum over the differences: with alternating signs, and of squares.
struct AlternatingSum {
  Eigen::Vector3d alternating = Eigen::Vector3d::Zero();
  double square = 0.0;

  void Add(const Eigen::Vector3d& difference, double sign) {
    alternating += sign * difference;
    square += difference.squaredNorm();
  }
  /// Twice the mean, if it is more than chance and noise make; else 0.
  [[nodiscard]] double Significant(double count, double noise, double least) const {
    constexpr double kPart = 0.8, kNoises = 3.0;
    const double mean = alternating.norm() / count;
    if (!(mean * mean > kPart * square / count)) return 0.0;
    return mean > kNoises * noise && 2.0 * mean > least ? 2.0 * mean : 0.0;
  }
};

}  // namespace

std::optional<Alternation> FindAlternation(std::span<const StateVector> states) {
  if (states.size() < kMinDifferences + kDifferenceOrder) return std::nullopt;
  AlternatingSum positions, velocities;
  const std::size_t count = states.size() - kDifferenceOrder;
  for (std::size_t k = 0; k < count; ++k) {
    const std::span<const StateVector> nine = states.subspan(k, kDifferenceOrder + 1);
    const auto weights = DifferenceWeights(nine);
    Eigen::Vector3d position = Eigen::Vector3d::Zero(), velocity = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i <= kDifferenceOrder; ++i) {
      position += weights[i] * (nine[i].position_m - nine[0].position_m);
      velocity += weights[i] * (nine[i].velocity_mps - nine[0].velocity_mps);
    }
    const double sign = k % 2 == 0 ? 1.0 : -1.0;
    positions.Add(position, sign);
    velocities.Add(velocity, sign);
  }
  std::array<std::vector<StateVector>, 2> halves;
  for (std::size_t k = 0; k < states.size(); ++k) halves[k % 2].push_back(states[k]);
  const StateNoise even = EstimateStateNoise(halves[0]), odd = EstimateStateNoise(halves[1]);
  constexpr double kLeast_m = 1e-3, kLeast_mps = 1e-4;
  const Alternation found{
      positions.Significant(
          static_cast<double>(count), std::max(even.position_m, odd.position_m), kLeast_m),
      velocities.Significant(
          static_cast<double>(count), std::max(even.velocity_mps, odd.velocity_mps), kLeast_mps)};
  if (found.position_m == 0.0 && found.velocity_mps == 0.0) return std::nullopt;
  return found;
}

std::string Describe(const Alternation& alternation) {
  std::string off;
  if (alternation.position_m > 0.0) off = Digits(alternation.position_m, 3) + " m";
  if (alternation.velocity_mps > 0.0) {
    off += (off.empty() ? "" : " and ") + Digits(alternation.velocity_mps, 3) + " m/s";
  }
  return "its states alternate between two solutions: every second state is " + off +
         " from the flight of the others; keep the states of one of them";
}

double WrapOf_s(const FlightPath& path, double time_s) {
  for (const double shift_s : {0.0, 86400.0, -86400.0, 604800.0, -604800.0}) {
    const double shifted_s = time_s + shift_s;
    if (shifted_s >= path.start_s() && shifted_s <= path.end_s()) return shift_s;
  }
  return 0.0;
}

namespace {

using Eigen::Vector3d;

/// Mean acceleration from the first to the last state less that of the model, whose axes turn at
/// this rate about z.
Vector3d Unexplained_mps2(std::span<const StateVector> states, double gm, double rate) {
  const Vector3d turning = rate * Vector3d::UnitZ();
  const auto model_mps2 = [&](const StateVector& state) -> Vector3d {
    const Vector3d& p_m = state.position_m;
    return -gm / std::pow(p_m.norm(), 3) * p_m - 2.0 * turning.cross(state.velocity_mps) -
           turning.cross(turning.cross(p_m));
  };
  Vector3d change_mps = states.back().velocity_mps - states.front().velocity_mps;
  for (std::size_t k = 1; k < states.size(); ++k) {
    const double interval_s = states[k].time_s - states[k - 1].time_s;
    change_mps -= 0.5 * interval_s * (model_mps2(states[k - 1]) + model_mps2(states[k]));
  }
  return change_mps / (states.back().time_s - states.front().time_s);
}

}  // namespace

std::optional<InertialMotion> FindInertialMotion(std::span<const StateVector> states,
                                                 const Body& body) {
  constexpr double kDecides = 0.1;
  if (states.size() < 3 || body.rotation == 0.0) return std::nullopt;
  InertialMotion worst{0.0, std::numeric_limits<double>::infinity()};
  const std::size_t half = states.size() / 2;
  for (const auto part : {states.first(half + 1), states.subspan(half)}) {
    worst.in_fixed_axes_mps2 =
        std::max(worst.in_fixed_axes_mps2, Unexplained_mps2(part, body.gm, 0.0).norm());
    worst.in_turning_axes_mps2 =
        std::min(worst.in_turning_axes_mps2, Unexplained_mps2(part, body.gm, body.rotation).norm());
  }
  if (!(worst.in_fixed_axes_mps2 < kDecides * worst.in_turning_axes_mps2)) return std::nullopt;
  return worst;
}

std::string Describe(const InertialMotion& motion) {
  return "its states move as in axes that do not turn with the body: gravity leaves " +
         Digits(motion.in_fixed_axes_mps2, 2) +
         " m/s^2 of their acceleration unexplained there, and " +
         Digits(motion.in_turning_axes_mps2, 2) + " m/s^2 in axes that turn with it";
}

// ---- the path that they give

namespace {

/// States beyond the strip on either side that still speak of it.
constexpr std::size_t kMargin = 10;
/// Times of an interval at which polynomials are compared, and intervals of a strip.
constexpr std::array<double, 4> kInInterval{0.125, 0.375, 0.625, 0.875};
constexpr std::size_t kMaxIntervals = 64;
/// Fewer states hardly show what is noise of theirs and what the flight did between them.
constexpr std::size_t kFewStates = 10;

double Square(double x) { return x * x; }

/// Whether a sum of squares of two components over `intervals` is more than noise makes of it.
bool IsMoreThanNoise(double square, double noise, double intervals) {
  constexpr double kLevel = 0.9999;
  const double freedom = 2.0 * intervals;
  return square * freedom > noise * ChiSquareQuantile(kLevel, freedom);
}

/// How an error of one in the states comes out of a polynomial, mean squares over an interval.
struct Gains {
  double rate_of_position = 0.0, rate_of_velocity = 0.0;  ///< of independent errors
  double position_of_position = 0.0, position_of_velocity = 0.0;
  double rate_of_all_velocities = 0.0;  ///< of one error in all velocities alike
};

/// Squares of the differences of two motions, summed over intervals.
struct Differences {
  double rate = 0.0, place = 0.0, count = 0.0;

  /// `a` and `b` give a state at a time of the interval.
  template <typename A, typename B>
  void Add(const StateVector& from, const StateVector& to, const A& a, const B& b) {
    for (const double fraction : kInInterval) {
      const double at_s = from.time_s + fraction * (to.time_s - from.time_s);
      const StateVector in_a = a.At(at_s), in_b = b.At(at_s);
      rate += Across(in_a.velocity_mps - in_b.velocity_mps, in_b.velocity_mps).squaredNorm() /
              kInInterval.size();
      place += (in_a.position_m - in_b.position_m).squaredNorm() / kInInterval.size();
    }
    count += 1.0;
  }
  /// Root mean squares without what noise makes of them, 0 where they are not more than that.
  [[nodiscard]] StateNoise Without(double noise_of_rate) const {
    if (!IsMoreThanNoise(rate, noise_of_rate, count)) return {0.0, 0.0};
    const double kept = (rate - noise_of_rate) / rate;
    return {std::sqrt(kept * place / count), std::sqrt(kept * rate / count)};
  }
};

/// The circular flight with the mean speed and the turning rate of some states, in the plane of
/// their first and last velocity; its position in the middle of their times is the origin.
class Circle {
 public:
  explicit Circle(std::span<const StateVector> states)
      : middle_s_(0.5 * (states.front().time_s + states.back().time_s)) {
    double angle = 0.0;
    for (std::size_t k = 0; k < states.size(); ++k) {
      speed_mps_ += states[k].velocity_mps.norm() / static_cast<double>(states.size());
      if (k == 0) continue;
      const Eigen::Vector3d &v = states[k - 1].velocity_mps, &w = states[k].velocity_mps;
      angle += std::atan2(v.cross(w).norm(), v.dot(w));
    }
    rate_radps_ = angle / (states.back().time_s - states.front().time_s);
    const Eigen::Vector3d &first = states.front().velocity_mps, &last = states.back().velocity_mps;
    along_ = (first.normalized() + last.normalized()).normalized();
    inward_ = Across(last.normalized() - first.normalized(), along_).normalized();
    for (const StateVector& state : states) states_.push_back(At(state.time_s));
  }
  [[nodiscard]] StateVector At(double time_s) const {
    const double x_s = time_s - middle_s_;
    if (!(rate_radps_ > 0.0)) return {time_s, speed_mps_ * x_s * along_, speed_mps_ * along_};
    const double angle = rate_radps_ * x_s, radius_m = speed_mps_ / rate_radps_;
    const double rise_m = 2.0 * radius_m * Square(std::sin(0.5 * angle));  // no small difference
    return {time_s,
            radius_m * std::sin(angle) * along_ + rise_m * inward_,
            speed_mps_ * (std::cos(angle) * along_ + std::sin(angle) * inward_)};
  }
  [[nodiscard]] std::span<const StateVector> states() const { return states_; }
  /// From the first state to the last.
  [[nodiscard]] double angle_rad() const {
    return rate_radps_ * (states_.back().time_s - states_.front().time_s);
  }

 private:
  double middle_s_, speed_mps_ = 0.0, rate_radps_ = 0.0;
  Eigen::Vector3d along_, inward_;
  std::vector<StateVector> states_;
};

/// Whether the highest derivative that positions and velocities of two to four states show is that
/// of the circle: then the next ones, which they do not show, are taken to be.
bool FollowCircle(std::span<const StateVector> states, const Circle& circle) {
  constexpr double kTolerance = 0.5;
  const NewtonPolynomial own(states, OrbitThrough::kStates);
  const NewtonPolynomial of_circle(circle.states(), OrbitThrough::kStates);
  const double off = (own.HighestDifference() - of_circle.HighestDifference()).norm();
  return off < kTolerance * of_circle.HighestDifference().norm();
}

/// A path that Differences can read.
struct Followed {
  const FlightPath& path;
  [[nodiscard]] StateVector At(double time_s) const {
    const Motion motion = path.At(time_s).value();  // within the path: between two states
    return {time_s, motion.position_m, motion.velocity_mps};
  }
};

/// Gains of the polynomial through `with` states less those of the one through `without` states (0:
/// nothing is subtracted).
Gains GainsOf(std::span<const StateVector> states,
              std::size_t interval,
              OrbitThrough through,
              std::size_t with,
              std::size_t without) {
  // States that no polynomial here reaches are left away.
  const std::size_t begin = interval > kMargin ? interval - kMargin : 0;
  const std::size_t near = interval - begin;
  std::vector<StateVector> unit(std::min(states.size() - begin, near + kMargin + 2));
  for (std::size_t i = 0; i < unit.size(); ++i) unit[i].time_s = states[begin + i].time_s;
  const std::span<const StateVector> used = StatesAround(unit, near, std::max(with, without));
  const auto first = static_cast<std::size_t>(used.data() - unit.data());
  const double from_s = unit[near].time_s, span_s = unit[near + 1].time_s - from_s;
  Gains gains;
  const auto add = [&](double* rate, double* position) {
    const NewtonPolynomial a(StatesAround(unit, near, with), through);
    std::optional<NewtonPolynomial> b;
    if (without > 0) b.emplace(StatesAround(unit, near, without), through);
    for (const double fraction : kInInterval) {
      StateVector at = a.At(from_s + fraction * span_s);
      if (b) {
        const StateVector less = b->At(at.time_s);
        at.position_m -= less.position_m;
        at.velocity_mps -= less.velocity_mps;
      }
      *rate += Square(at.velocity_mps.x()) / kInInterval.size();
      if (position != nullptr) *position += Square(at.position_m.x()) / kInInterval.size();
    }
  };
  for (std::size_t i = first; i < first + used.size(); ++i) {
    unit[i].position_m.x() = 1.0;
    add(&gains.rate_of_position, &gains.position_of_position);
    unit[i].position_m.x() = 0.0;
    if (through == OrbitThrough::kPositions) continue;
    unit[i].velocity_mps.x() = 1.0;
    add(&gains.rate_of_velocity, &gains.position_of_velocity);
    unit[i].velocity_mps.x() = 0.0;
  }
  if (through == OrbitThrough::kStates) {
    for (StateVector& state : unit) state.velocity_mps.x() = 1.0;
    add(&gains.rate_of_all_velocities, nullptr);
  }
  return gains;
}

}  // namespace

Recording::Recording(std::vector<StateVector> states,
                     const StateNoise& given,
                     const TimeSpan& strip_s)
    : states_(std::move(states)), given_(given), noise_(given), strip_s_(strip_s) {
  const auto interval_of = [this](double time_s) {
    const auto after = std::upper_bound(
        states_.begin() + 1, states_.end() - 1, time_s, [](double t_s, const StateVector& state) {
          return t_s < state.time_s;
        });
    return static_cast<std::size_t>(after - states_.begin()) - 1;
  };
  first_ = interval_of(strip_s.first_s);
  last_ = interval_of(strip_s.last_s);
  const std::size_t begin = first_ > kMargin ? first_ - kMargin : 0;
  const std::size_t end = std::min(states_.size(), last_ + 2 + kMargin);
  const std::span<const StateVector> near = std::span(states_).subspan(begin, end - begin);
  if (std::isnan(given.position_m) || std::isnan(given.velocity_mps)) {
    const StateNoise estimated = EstimateStateNoise(near);
    if (std::isnan(given.position_m)) noise_.position_m = estimated.position_m;
    if (std::isnan(given.velocity_mps)) noise_.velocity_mps = estimated.velocity_mps;
  }
  contradiction_mps_ = Contradiction_mps(near, noise_);
  // States far apart in an orbit contradict the derivatives of polynomials a little.
  constexpr double kWide_rad = 0.1;
  if (contradiction_mps_ > 0.0) {
    const Circle circle(near);
    if (circle.angle_rad() > kWide_rad * static_cast<double>(near.size() - 1) &&
        contradiction_mps_ < LargestContradiction_mps(circle.states())) {
      contradiction_mps_ = 0.0;
    }
  }
  unresolved_mps_ = Unresolved();
  if (unresolved_mps_ > 0.0) {  // no noise: the flight itself
    if (std::isnan(given.position_m)) noise_.position_m = 0.0;
    if (std::isnan(given.velocity_mps)) noise_.velocity_mps = 0.0;
  }
}

PathErrors Recording::ErrorsOfCubic() const {
  PathErrors errors;
  // Jerks of neighbouring pieces differ by s'''' times the distance of their middles, and by noise.
  double rate_square = 0.0, place_square = 0.0, rate_noise = 0.0, count = 0.0, noise_count = 0.0;
  const auto jerk = [this](std::size_t k) -> Eigen::Vector3d {
    const StateVector &a = states_[k], &b = states_[k + 1];
    const double h = b.time_s - a.time_s;
    const Eigen::Vector3d mean = (b.position_m - a.position_m) / h;
    return 6.0 / (h * h) * (a.velocity_mps + b.velocity_mps - 2.0 * mean);
  };
  const std::size_t begin = first_ > 0 ? first_ - 1 : 0;
  double noise_rate = 0.0, noise_place = 0.0;
  for (std::size_t k = begin; k <= last_; ++k) {
    const double h = states_[k + 1].time_s - states_[k].time_s;
    noise_rate +=
        12.0 / 5.0 * Square(noise_.position_m / h) + 4.0 / 15.0 * Square(noise_.velocity_mps);
    noise_place +=
        26.0 / 35.0 * Square(noise_.position_m) + 2.0 / 105.0 * Square(h * noise_.velocity_mps);
    noise_count += 1.0;
    if (k + 2 >= states_.size()) continue;
    const double mean_h = 0.5 * (states_[k + 2].time_s - states_[k].time_s);
    const Eigen::Vector3d fourth =
        Across((jerk(k + 1) - jerk(k)) / mean_h, states_[k + 1].velocity_mps);
    const double h3 = mean_h * mean_h * mean_h;
    rate_square += fourth.squaredNorm() * Square(h3) / (144.0 * 210.0);
    place_square += fourth.squaredNorm() * Square(h3 * mean_h) / (576.0 * 630.0);
    // Two components of variance 72/h^6 (sigma_v^2 + 12 sigma_p^2/h^2).
    rate_noise += 2.0 * 72.0 / (144.0 * 210.0) *
                  (Square(noise_.velocity_mps) + 12.0 * Square(noise_.position_m / mean_h));
    count += 1.0;
  }
  const bool circle = CubicsFollowCircle();
  if (states_.size() == 2 && circle) {  // a circle with their curvature has s'''' = |a|^3/|v|^2
    const StateVector &first = states_[0], &last = states_[1];
    const double h = last.time_s - first.time_s;
    const Eigen::Vector3d bend_mps2 =
        Across((last.velocity_mps - first.velocity_mps) / h, first.velocity_mps);
    const double fourth = std::pow(bend_mps2.norm(), 3) / first.velocity_mps.squaredNorm();
    rate_square = Square(fourth * h * h * h) / (144.0 * 210.0);
    place_square = Square(fourth * Square(h * h)) / (576.0 * 630.0);
    count = 1.0;
  }
  errors.noise = {std::sqrt(noise_place / noise_count), std::sqrt(noise_rate / noise_count)};
  errors.contradiction_mps = contradiction_mps_ / std::sqrt(5.0);  // rms of 1 - 6u + 6u^2
  if (count > 0.0 && IsMoreThanNoise(rate_square, rate_noise, count)) {
    const double kept = (rate_square - rate_noise) / rate_square;
    errors.interpolation_mps = std::sqrt(kept * rate_square / count);
    errors.interpolation_m = std::sqrt(kept * place_square / count);
  }
  if (states_.size() < kFewStates && !circle) AddDifferenceToParabolas(&errors);
  return errors;
}

bool Recording::CubicsFollowCircle() const {
  for (std::size_t k = first_; k <= last_; ++k) {
    const std::span<const StateVector> two = StatesAround(states_, k, 2);
    if (!FollowCircle(two, Circle(two))) return false;
  }
  return true;
}

void Recording::AddDifferenceToParabolas(PathErrors* errors) const {
  // c (t - t_k)^2 (t - t_k+1) is a cubic less the parabola through one of its velocities, c a sixth
  // of its jerk.
  Differences sum;
  double noise = 0.0;
  for (std::size_t k = first_; k <= last_; ++k) {
    const StateVector& from = states_[k];
    const double h2 = Square(states_[k + 1].time_s - from.time_s);
    const NewtonPolynomial cubic(StatesAround(states_, k, 2), OrbitThrough::kStates);
    const Eigen::Vector3d c = Across(cubic.HighestDifference(), from.velocity_mps);
    sum.rate += 2.0 / 15.0 * Square(h2) * c.squaredNorm();
    sum.place += 1.0 / 105.0 * Square(h2) * h2 * c.squaredNorm();
    sum.count += 1.0;
    noise += 2.0 * 2.0 / 15.0 *
             (2.0 * Square(noise_.velocity_mps) + 8.0 * Square(noise_.position_m) / h2);
  }
  const StateNoise unknown = sum.Without(noise);
  errors->interpolation_m = std::hypot(errors->interpolation_m, unknown.position_m);
  errors->interpolation_mps = std::hypot(errors->interpolation_mps, unknown.velocity_mps);
}

StateNoise Recording::Unchecked(OrbitThrough through) const {
  const std::size_t n = states_.size();
  const Circle circle(states_);
  Differences difference;
  double noise = 0.0;
  if (through == OrbitThrough::kStates && FollowCircle(states_, circle)) {
    const NewtonPolynomial polynomial(circle.states(), through);
    for (std::size_t k = first_; k <= last_; ++k) {
      difference.Add(states_[k], states_[k + 1], polynomial, circle);
    }
    return difference.Without(0.0);
  }
  const NewtonPolynomial all(states_, through);
  for (std::size_t k = first_; k <= last_; ++k) {
    const NewtonPolynomial fewer(StatesAround(states_, k, n - 1), through);
    difference.Add(states_[k], states_[k + 1], all, fewer);
    const Gains gains = GainsOf(states_, k, through, n, n - 1);
    noise += 2.0 * (gains.rate_of_position * Square(noise_.position_m) +
                    gains.rate_of_velocity * Square(noise_.velocity_mps));
  }
  return difference.Without(noise);
}

double Recording::Unresolved() const {
  if (states_.size() >= kFewStates || CubicsFollowCircle()) return 0.0;
  const auto known = [](double sigma) { return std::isnan(sigma) ? 0.0 : Square(sigma); };
  double scatter = 0.0, of_mean = 0.0, noise = 0.0;
  for (std::size_t k = 1; k < states_.size(); ++k) {
    const StateVector &a = states_[k - 1], &b = states_[k];
    const double h = b.time_s - a.time_s;
    const Eigen::Vector3d chord_mps = (b.position_m - a.position_m) / h;
    const Eigen::Vector3d before = Across(a.velocity_mps - chord_mps, a.velocity_mps);
    const Eigen::Vector3d after = Across(b.velocity_mps - chord_mps, a.velocity_mps);
    scatter += 0.5 * (before.squaredNorm() + after.squaredNorm());
    of_mean += 0.25 * (before + after).squaredNorm();
    noise += 2.0 * (known(given_.velocity_mps) + 2.0 * known(given_.position_m) / Square(h));
  }
  // In a wave of angular frequency w the means are w h/6 of the scatter: 0.2 is five states a
  // period. In a single interval that ratio is small by chance in one flight of twenty-five.
  const double resolved = states_.size() == 2 ? 0.05 : 0.2;
  if (of_mean < Square(resolved) * scatter || scatter <= noise) return 0.0;
  return std::sqrt((scatter - noise) / static_cast<double>(states_.size() - 1));
}

template <typename Path>
StateNoise Recording::DifferenceToOrbit(const Path& path, double noise_of_rate) const {
  Differences difference;
  const std::size_t step = (last_ - first_ + kMaxIntervals) / kMaxIntervals;
  double noise = 0.0;
  for (std::size_t k = first_; k <= last_; k += step) {
    const NewtonPolynomial orbit(StatesAround(states_, k, StatesOf(OrbitThrough::kStates)),
                                 OrbitThrough::kStates);
    difference.Add(states_[k], states_[k + 1], path, orbit);
    const Gains gains = GainsOf(states_, k, OrbitThrough::kStates, 4, 0);
    noise += 2.0 * (gains.rate_of_position * Square(noise_.position_m) +
                    gains.rate_of_velocity * Square(noise_.velocity_mps) + noise_of_rate);
  }
  const StateNoise to_orbit = difference.Without(noise);
  const PathErrors of_orbit = ErrorsOf(PathThrough::kOrbit);
  return {std::hypot(to_orbit.position_m, of_orbit.interpolation_m),
          std::hypot(to_orbit.velocity_mps, of_orbit.interpolation_mps)};
}

PathErrors Recording::ErrorsOfPolynomials(PathThrough way) const {
  const OrbitThrough through =
      way == PathThrough::kOrbit ? OrbitThrough::kStates : OrbitThrough::kPositions;
  const std::size_t taken = StatesOf(through);
  const bool checked = states_.size() > taken;
  // Against a polynomial of up to four degrees more.
  const std::size_t more = through == OrbitThrough::kStates ? 2 : 4;
  const std::size_t other = checked ? std::min(states_.size(), taken + more) : 0;
  const std::size_t step = (last_ - first_ + kMaxIntervals) / kMaxIntervals;
  const double p2 = Square(noise_.position_m), v2 = Square(noise_.velocity_mps);
  const double b2 = Square(contradiction_mps_);
  double rate = 0.0, place = 0.0, contradiction = 0.0, count = 0.0, expected = 0.0;
  Differences difference;
  for (std::size_t k = first_; k <= last_; k += step) {
    const Gains own = GainsOf(states_, k, through, taken, 0);
    rate += own.rate_of_position * p2 + own.rate_of_velocity * v2;
    place += own.position_of_position * p2 + own.position_of_velocity * v2;
    // A path through velocities alone is off by the contradiction itself; between states less.
    contradiction += own.rate_of_all_velocities * b2;
    count += 1.0;
    if (!checked) continue;
    const Gains of_difference = GainsOf(states_, k, through, taken, other);
    expected += 2.0 * (of_difference.rate_of_position * p2 + of_difference.rate_of_velocity * v2) +
                of_difference.rate_of_all_velocities * b2;
    difference.Add(states_[k],
                   states_[k + 1],
                   NewtonPolynomial(StatesAround(states_, k, taken), through),
                   NewtonPolynomial(StatesAround(states_, k, other), through));
  }
  PathErrors errors;
  errors.noise = {std::sqrt(place / count), std::sqrt(rate / count)};
  errors.contradiction_mps = std::sqrt(contradiction / count);
  StateNoise interpolation;
  if (checked) {
    interpolation = difference.Without(expected);
  } else if (through == OrbitThrough::kStates || (unresolved_mps_ > 0.0 && states_.size() > 2)) {
    interpolation = Unchecked(through);
  } else {
    interpolation = DifferenceToOrbit(NewtonPolynomial(states_, through), rate / count);
  }
  errors.interpolation_m = interpolation.position_m;
  errors.interpolation_mps = interpolation.velocity_mps;
  return errors;
}

double Recording::DenseStep_s(PathThrough way, double direction_rad) const {
  const OrbitThrough through =
      way == PathThrough::kOrbit ? OrbitThrough::kStates : OrbitThrough::kPositions;
  constexpr double kMaxParts = 64.0;
  const double span_s = states_.back().time_s - states_.front().time_s;
  double step_s = span_s;
  for (std::size_t k = first_; k <= last_; ++k) {
    const double from_s = states_[k].time_s, h = states_[k + 1].time_s - from_s;
    // s'''' of the polynomial, by the third difference of its velocities.
    const NewtonPolynomial polynomial(StatesAround(states_, k, StatesOf(through)), through);
    std::array<Eigen::Vector3d, 4> v;
    for (std::size_t i = 0; i < 4; ++i) {
      v[i] = polynomial.At(from_s + h * static_cast<double>(i) / 3.0).velocity_mps;
    }
    const double third = Across(v[3] - 3.0 * v[2] + 3.0 * v[1] - v[0], v[0]).norm();
    const double fourth_mps4 = 27.0 * third / (h * h * h);
    const double allowed_mps = direction_rad * v[0].norm();
    if (!(fourth_mps4 > 0.0)) continue;
    step_s = std::min(step_s, std::cbrt(216.0 / std::sqrt(3.0) * allowed_mps / fourth_mps4));
  }
  return std::max(step_s, span_s / (kMaxParts * static_cast<double>(states_.size() - 1)));
}

PathErrors Recording::ErrorsOf(PathThrough through) const {
  // The polynomial of degree 7 of two states is their cubic.
  const bool cubic = through == PathThrough::kOrbit && states_.size() == 2;
  const bool polynomials = through == PathThrough::kOrbit || through == PathThrough::kPositions;
  PathErrors errors = polynomials && !cubic ? ErrorsOfPolynomials(through) : ErrorsOfCubic();
  errors.interpolation_mps = std::hypot(errors.interpolation_mps, unresolved_mps_);
  return errors;
}

RecordedPath Recording::Read(PathThrough through, double direction_rad) const {
  RecordedPath out;
  out.through = through;
  out.noise = noise_;
  switch (through) {
    case PathThrough::kAuto:
    case PathThrough::kStates:
      out.through = PathThrough::kStates;
      out.path = FlightPath(states_);
      out.errors = ErrorsOf(through);
      break;
    case PathThrough::kOrbit:
    case PathThrough::kPositions:
      out.path = FlightPath(ResampleOrbit(
          states_,
          DenseStep_s(through, direction_rad),
          through == PathThrough::kOrbit ? OrbitThrough::kStates : OrbitThrough::kPositions));
      out.errors = ErrorsOf(through);
      break;
    case PathThrough::kSmooth: {
      SmoothedPath smooth = SmoothPath(states_, given_, strip_s_);
      out.path = FlightPath(std::move(smooth.states));
      out.noise = smooth.sigmas;
      out.errors.noise = smooth.remaining;
      // A constant contradiction stays at the ends, for as long as positions need to outweigh
      // velocities (eq. (23)).
      const double length_s = smooth.sigmas.position_m / smooth.sigmas.velocity_mps;
      const double span_s = out.path.end_s() - out.path.start_s();
      out.errors.contradiction_mps =
          contradiction_mps_ * std::sqrt(std::min(1.0, length_s / span_s));
      out.errors.interpolation_mps = smooth.unfollowed_mps;
      // Where all states are knots, or few, there is no finer spline to compare with.
      if (out.path.states().size() == states_.size() || states_.size() < kFewStates) {
        const bool known = !std::isnan(given_.position_m) && !std::isnan(given_.velocity_mps);
        const StateNoise unfollowed = DifferenceToOrbit(
            Followed{out.path}, known ? Square(smooth.remaining.velocity_mps) : 0.0);
        out.errors.interpolation_m = unfollowed.position_m;
        out.errors.interpolation_mps = unfollowed.velocity_mps;
      }
      if (std::isnan(given_.position_m) && std::isnan(given_.velocity_mps)) break;
      out.fit = FitOfStates{smooth.positions.chi_square / smooth.positions.freedom,
                            smooth.positions.freedom,
                            smooth.velocities.chi_square / smooth.velocities.freedom,
                            smooth.velocities.freedom};
      break;
    }
  }
  return out;
}

}  // namespace sarblock
