// SPDX-License-Identifier: Apache-2.0
#include "recorded_path.h"

#include "sarblock/core/statistics.h"
#include "sarblock/geometry/path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "smooth_path.h"

namespace sarblock {
namespace {

/// States beyond the strip on either side that still speak of it.
constexpr std::size_t kMargin = 10;
/// Times of an interval at which polynomials are compared, and intervals of a strip.
constexpr std::array<double, 4> kInInterval{0.125, 0.375, 0.625, 0.875};
constexpr std::size_t kMaxIntervals = 64;

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

/// Of the polynomial through `with` states less that through `without` (0: alone).
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
  if (states_.size() == 2) {  // a circle with their curvature has s'''' = |a|^3/|v|^2
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
  return errors;
}

PathErrors Recording::ErrorsOfPolynomials(PathThrough way) const {
  const OrbitThrough through =
      way == PathThrough::kOrbit ? OrbitThrough::kStates : OrbitThrough::kPositions;
  const std::size_t taken = StatesOf(through);
  // Against a polynomial of up to four degrees more; of four less where there are no more states.
  const std::size_t more = through == OrbitThrough::kStates ? 2 : 4;
  const std::size_t other =
      states_.size() > taken ? std::min(states_.size(), taken + more) : taken - more;
  const std::size_t step = (last_ - first_ + kMaxIntervals) / kMaxIntervals;
  const double p2 = Square(noise_.position_m), v2 = Square(noise_.velocity_mps);
  const double b2 = Square(contradiction_mps_);
  double rate = 0.0, place = 0.0, contradiction = 0.0, count = 0.0;
  double difference = 0.0, difference_place = 0.0, expected = 0.0;
  for (std::size_t k = first_; k <= last_; k += step) {
    const Gains own = GainsOf(states_, k, through, taken, 0);
    const Gains of_difference = GainsOf(states_, k, through, taken, other);
    rate += own.rate_of_position * p2 + own.rate_of_velocity * v2;
    place += own.position_of_position * p2 + own.position_of_velocity * v2;
    // A path through velocities alone is off by the contradiction itself; between states less.
    contradiction += own.rate_of_all_velocities * b2;
    expected += 2.0 * (of_difference.rate_of_position * p2 + of_difference.rate_of_velocity * v2) +
                of_difference.rate_of_all_velocities * b2;
    const NewtonPolynomial a(StatesAround(states_, k, taken), through);
    const NewtonPolynomial b(StatesAround(states_, k, other), through);
    for (const double fraction : kInInterval) {
      const double at_s =
          states_[k].time_s + fraction * (states_[k + 1].time_s - states_[k].time_s);
      const StateVector in_a = a.At(at_s), in_b = b.At(at_s);
      const Eigen::Vector3d across =
          Across(in_a.velocity_mps - in_b.velocity_mps, in_b.velocity_mps);
      difference += across.squaredNorm() / kInInterval.size();
      difference_place += (in_a.position_m - in_b.position_m).squaredNorm() / kInInterval.size();
    }
    count += 1.0;
  }
  PathErrors errors;
  errors.noise = {std::sqrt(place / count), std::sqrt(rate / count)};
  errors.contradiction_mps = std::sqrt(contradiction / count);
  if (IsMoreThanNoise(difference, expected, count)) {
    const double kept = (difference - expected) / difference;
    errors.interpolation_mps = std::sqrt(kept * difference / count);
    errors.interpolation_m = std::sqrt(kept * difference_place / count);
  }
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
  const bool polynomials = through == PathThrough::kOrbit || through == PathThrough::kPositions;
  return polynomials ? ErrorsOfPolynomials(through) : ErrorsOfCubic();
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
      out.errors = ErrorsOfCubic();
      break;
    case PathThrough::kOrbit:
    case PathThrough::kPositions:
      out.path = FlightPath(ResampleOrbit(
          states_,
          DenseStep_s(through, direction_rad),
          through == PathThrough::kOrbit ? OrbitThrough::kStates : OrbitThrough::kPositions));
      out.errors = ErrorsOfPolynomials(through);
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
