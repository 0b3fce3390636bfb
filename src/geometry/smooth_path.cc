// SPDX-License-Identifier: Apache-2.0
#include "smooth_path.h"

#include "sarblock/core/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace sarblock {
namespace {

constexpr std::size_t kMinDifference = 3, kMaxDifference = 10;
constexpr std::size_t kMaxWindows = 256;
/// White noise keeps its size from one order to the next; a flight that the states can follow loses
/// at least half.
constexpr double kStillFalling = 0.7;

struct Squares {
  double position = 0.0, velocity = 0.0;
};

/// Mean square of an element of the divided differences through `order + 1` states, scaled so that
/// white noise of one comes out as one.
Squares DifferenceSquares(std::span<const StateVector> states, std::size_t order) {
  const std::size_t windows = states.size() - order;
  const std::size_t step = (windows + kMaxWindows - 1) / kMaxWindows;
  Squares sum;
  double count = 0.0;
  for (std::size_t first = 0; first < windows; first += step) {
    std::array<double, kMaxDifference + 1> weight{};
    double square = 0.0;
    const double scale_s =
        (states[first + order].time_s - states[first].time_s) / static_cast<double>(order);
    for (std::size_t i = 0; i <= order; ++i) {
      weight[i] = 1.0;
      for (std::size_t j = 0; j <= order; ++j) {
        if (j != i) weight[i] *= scale_s / (states[first + i].time_s - states[first + j].time_s);
      }
      square += weight[i] * weight[i];
    }
    Eigen::Vector3d position = Eigen::Vector3d::Zero(), velocity = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i <= order; ++i) {
      position += weight[i] * (states[first + i].position_m - states[first].position_m);
      velocity += weight[i] * (states[first + i].velocity_mps - states[first].velocity_mps);
    }
    sum.position += position.squaredNorm() / square;
    sum.velocity += velocity.squaredNorm() / square;
    count += 3.0;
  }
  return {sum.position / count, sum.velocity / count};
}

/// The first order whose mean square is not significantly above the least: among orders that show
/// noise alone, the one with most windows.
double NoiseOf(const std::vector<double>& squares, std::size_t states) {
  const std::size_t n = squares.size();
  constexpr double kFalling = kStillFalling * kStillFalling;
  const bool unresolved = n < 2 || (squares[n - 1] < kFalling * squares[n - 2] &&
                                    (n < 3 || squares[n - 2] < kFalling * squares[n - 3]));
  if (unresolved) return 0.0;
  const double least = *std::min_element(squares.begin(), squares.end());
  const auto windows = static_cast<double>(std::min(kMaxWindows, states));
  const double most = least * (1.0 + 2.0 / std::sqrt(windows));
  return std::sqrt(*std::find_if(
      squares.begin(), squares.end(), [most](double square) { return square <= most; }));
}

/// Nine weights of the derivative at the middle one of nine times, of their polynomial.
std::array<double, 9> DerivativeWeights(std::span<const StateVector> nine) {
  constexpr std::size_t kMiddle = 4;
  std::array<double, 9> weight{};
  const double scale_s = (nine[8].time_s - nine[0].time_s) / 8.0;
  const auto barycentric = [&](std::size_t i) {
    double product = 1.0;
    for (std::size_t j = 0; j < 9; ++j) {
      if (j != i) product *= scale_s / (nine[i].time_s - nine[j].time_s);
    }
    return product;
  };
  const double middle = barycentric(kMiddle);
  for (std::size_t i = 0; i < 9; ++i) {
    if (i == kMiddle) continue;
    weight[i] = barycentric(i) / middle / (nine[kMiddle].time_s - nine[i].time_s);
    weight[kMiddle] -= weight[i];
  }
  return weight;
}

/// The velocity in the middle less the derivative of the polynomial through the positions.
Eigen::Vector3d ContradictionOf(std::span<const StateVector> nine,
                                const std::array<double, 9>& weight) {
  Eigen::Vector3d difference = nine[4].velocity_mps;
  for (std::size_t i = 0; i < nine.size(); ++i) {
    difference -= weight[i] * (nine[i].position_m - nine[4].position_m);
  }
  return difference;
}

}  // namespace

StateNoise EstimateStateNoise(std::span<const StateVector> states) {
  std::vector<double> positions, velocities;
  for (std::size_t order = kMinDifference; order <= kMaxDifference && order + 2 <= states.size();
       ++order) {
    const Squares squares = DifferenceSquares(states, order);
    positions.push_back(squares.position);
    velocities.push_back(squares.velocity);
  }
  return {NoiseOf(positions, states.size()), NoiseOf(velocities, states.size())};
}

double Contradiction_mps(std::span<const StateVector> states, const StateNoise& noise) {
  constexpr std::size_t kNine = 9, kWindows = 16;
  constexpr double kLevel = 1.0 - 1e-6;
  if (states.size() < kNine) return 0.0;
  const std::size_t centres = states.size() - kNine + 1;
  const std::size_t length = (centres + kWindows - 1) / kWindows;
  double square = 0.0, expected = 0.0, whitened = 0.0, windows = 0.0;
  std::vector<double> of_position;
  for (std::size_t begin = 0; begin < centres; begin += length) {
    const std::size_t end = std::min(centres, begin + length);
    const auto count = static_cast<double>(end - begin);
    // Weights of neighbouring centres cancel: a mean knows velocities better than its members do.
    of_position.assign(end - begin + kNine - 1, 0.0);
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (std::size_t k = begin; k < end; ++k) {
      const std::span<const StateVector> nine = states.subspan(k, kNine);
      const std::array<double, 9> weight = DerivativeWeights(nine);
      for (std::size_t i = 0; i < kNine; ++i) of_position[k - begin + i] += weight[i] / count;
      mean += Across(ContradictionOf(nine, weight), nine[4].velocity_mps) / count;
    }
    double variance = noise.velocity_mps * noise.velocity_mps / count;
    for (const double weight : of_position) {
      variance += std::pow(weight * noise.position_m, 2);
    }
    square += mean.squaredNorm();
    expected += 2.0 * variance;
    whitened += variance > 0.0 ? mean.squaredNorm() / variance : 0.0;
    windows += 1.0;
  }
  const bool noiseless = !(expected > 0.0);
  if (!noiseless && whitened <= ChiSquareQuantile(kLevel, 2.0 * windows)) return 0.0;
  return std::sqrt(std::max(0.0, square - expected) / windows);
}

double LargestContradiction_mps(std::span<const StateVector> states) {
  constexpr std::size_t kNine = 9;
  double largest_mps = 0.0;
  for (std::size_t first = 0; first + kNine <= states.size(); ++first) {
    const std::span<const StateVector> nine = states.subspan(first, kNine);
    largest_mps = std::max(largest_mps, ContradictionOf(nine, DerivativeWeights(nine)).norm());
  }
  return largest_mps;
}

namespace {

constexpr std::size_t kOrder = 4;  // cubic B-splines, four of them not zero

/// The four basis functions of one time with their derivatives, the first of index `first`.
struct BasisAt {
  std::size_t first = 0;
  std::array<double, kOrder> value{}, rate{};
};

/// Cubic B-splines on knots with the ends repeated.
class SplineBasis {
 public:
  explicit SplineBasis(std::vector<double> knots_s) : intervals_(knots_s.size() - 1) {
    padded_s_.assign(kOrder - 1, knots_s.front());
    padded_s_.insert(padded_s_.end(), knots_s.begin(), knots_s.end());
    padded_s_.insert(padded_s_.end(), kOrder - 1, knots_s.back());
  }
  [[nodiscard]] std::size_t size() const { return intervals_ + kOrder - 1; }
  [[nodiscard]] std::size_t intervals() const { return intervals_; }
  [[nodiscard]] double Knot_s(std::size_t k) const { return padded_s_[k + kOrder - 1]; }

  /// `interval` is moved on to the one that holds the time; times come in order.
  [[nodiscard]] BasisAt At(double time_s, std::size_t* interval) const {
    while (*interval + 1 < intervals_ && time_s >= Knot_s(*interval + 1)) ++*interval;
    BasisAt at;
    at.first = *interval;
    const double* const knot = &padded_s_[*interval + kOrder - 1];  // the interval's own
    // Cox and de Boor: from the constant to the cubic, the quadratics give the derivatives.
    std::array<double, kOrder> b{1.0, 0.0, 0.0, 0.0};
    for (std::ptrdiff_t degree = 1; degree < static_cast<std::ptrdiff_t>(kOrder); ++degree) {
      double carried = 0.0;
      std::array<double, kOrder> next{};
      for (std::ptrdiff_t k = 0; k < degree; ++k) {
        const double right_s = knot[k + 1], left_s = knot[k + 1 - degree];
        const auto i = static_cast<std::size_t>(k);
        const double part = b[i] / (right_s - left_s);
        next[i] = carried + (right_s - time_s) * part;
        carried = (time_s - left_s) * part;
        if (degree + 1 == static_cast<std::ptrdiff_t>(kOrder)) {
          at.rate[i] -= static_cast<double>(degree) * part;
          at.rate[i + 1] += static_cast<double>(degree) * part;
        }
      }
      next[static_cast<std::size_t>(degree)] = carried;
      b = next;
    }
    at.value = b;
    return at;
  }

 private:
  std::size_t intervals_;
  std::vector<double> padded_s_;
};

/// Symmetric matrix of a bandwidth of three, by rows: [i][d] is the element (i, i - d).
using Band = std::vector<std::array<double, kOrder>>;

/// Cholesky factor in place. False where the matrix is not positive definite.
bool Factor(Band* band) {
  Band& l = *band;
  for (std::size_t i = 0; i < l.size(); ++i) {
    for (std::size_t d = std::min(i, kOrder - 1) + 1; d-- > 0;) {
      double sum = l[i][d];
      for (std::size_t k = d + 1; k < kOrder && k <= i; ++k) sum -= l[i][k] * l[i - d][k - d];
      if (d > 0) {
        l[i][d] = sum / l[i - d][0];
      } else if (sum > 0.0) {
        l[i][0] = std::sqrt(sum);
      } else {
        return false;
      }
    }
  }
  return true;
}

using Columns = std::vector<Eigen::Vector3d>;

void SolveInPlace(const Band& l, Columns* x) {
  for (std::size_t i = 0; i < l.size(); ++i) {
    for (std::size_t k = 1; k < kOrder && k <= i; ++k) (*x)[i] -= l[i][k] * (*x)[i - k];
    (*x)[i] /= l[i][0];
  }
  for (std::size_t i = l.size(); i-- > 0;) {
    for (std::size_t k = 1; k < kOrder && i + k < l.size(); ++k)
      (*x)[i] -= l[i + k][k] * (*x)[i + k];
    (*x)[i] /= l[i][0];
  }
}

/// The band of the inverse (Takahashi's recursion): [i][d] is the element (i, i + d).
Band InverseBand(const Band& l) {
  const std::size_t n = l.size();
  Band z(n, std::array<double, kOrder>{});
  const auto at = [&z](std::size_t i, std::size_t j) {
    return z[std::min(i, j)][(i > j ? i - j : j - i) % kOrder];
  };
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t d = std::min(kOrder - 1, n - 1 - i) + 1; d-- > 0;) {
      double sum = d == 0 ? 1.0 / l[i][0] : 0.0;
      for (std::size_t k = 1; k < kOrder && i + k < n; ++k) sum -= l[i + k][k] * at(i + k, i + d);
      z[i][d] = sum / l[i][0];
    }
  }
  return z;
}

/// b' Z b over a band.
double Variance(const Band& z, std::size_t first, const std::array<double, kOrder>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < kOrder; ++i) {
    sum += b[i] * b[i] * z[first + i][0];
    for (std::size_t j = i + 1; j < kOrder; ++j) sum += 2.0 * b[i] * b[j] * z[first + i][j - i];
  }
  return sum;
}

Eigen::Vector3d Sum(const Columns& coefficients,
                    std::size_t first,
                    const std::array<double, kOrder>& b) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < kOrder; ++i) sum += b[i] * coefficients[first + i];
  return sum;
}

/// A recording less its mean motion, which a spline has without an error.
struct Recorded {
  std::vector<double> time_s;
  Columns position_m, velocity_mps;
  Eigen::Vector3d origin_m, mean_mps;
  [[nodiscard]] std::size_t size() const { return time_s.size(); }
};

Recorded LessMeanMotion(std::span<const StateVector> states) {
  Recorded out;
  const double begin_s = states.front().time_s;
  out.origin_m = states.front().position_m;
  out.mean_mps = (states.back().position_m - out.origin_m) / (states.back().time_s - begin_s);
  for (const StateVector& state : states) {
    const double x_s = state.time_s - begin_s;
    out.time_s.push_back(x_s);
    out.position_m.emplace_back(state.position_m - out.origin_m - x_s * out.mean_mps);
    out.velocity_mps.emplace_back(state.velocity_mps - out.mean_mps);
  }
  return out;
}

/// A spline fitted on some knots.
struct Fit {
  SplineBasis basis;
  Band factor;
  Columns coefficients;
  double position_square_m2 = 0.0, velocity_square_m2ps2 = 0.0;  ///< of all residuals
  double score = std::numeric_limits<double>::infinity();
};

/// Times of the states nearest to equally spaced ones.
std::vector<double> KnotsAtStates(const std::vector<double>& time_s, std::size_t intervals) {
  std::vector<double> knots_s{time_s.front()};
  for (std::size_t k = 1; k < intervals; ++k) {
    const double wanted_s = time_s.back() * static_cast<double>(k) / static_cast<double>(intervals);
    auto after = std::lower_bound(time_s.begin() + 1, time_s.end() - 1, wanted_s);
    if (after - time_s.begin() > 1 && wanted_s - *(after - 1) < *after - wanted_s) --after;
    if (*after > knots_s.back() && *after < time_s.back()) knots_s.push_back(*after);
  }
  knots_s.push_back(time_s.back());
  return knots_s;
}

Fit FitOn(const Recorded& data, std::size_t intervals, const StateNoise& sigmas) {
  Fit fit{SplineBasis(KnotsAtStates(data.time_s, intervals)), {}, {}};
  const double position_weight = 1.0 / (sigmas.position_m * sigmas.position_m);
  const double velocity_weight = 1.0 / (sigmas.velocity_mps * sigmas.velocity_mps);
  const std::size_t n = fit.basis.size();
  fit.factor.assign(n, std::array<double, kOrder>{});
  fit.coefficients.assign(n, Eigen::Vector3d::Zero());
  // A second round solves for the residuals of the first: the rounding of the normal equations.
  for (int round = 0; round < 2; ++round) {
    Columns right(n, Eigen::Vector3d::Zero());
    std::size_t interval = 0;
    for (std::size_t k = 0; k < data.size(); ++k) {
      const BasisAt at = fit.basis.At(data.time_s[k], &interval);
      const Eigen::Vector3d p = data.position_m[k] - Sum(fit.coefficients, at.first, at.value);
      const Eigen::Vector3d v = data.velocity_mps[k] - Sum(fit.coefficients, at.first, at.rate);
      for (std::size_t i = 0; i < kOrder; ++i) {
        const double by_p = position_weight * at.value[i], by_v = velocity_weight * at.rate[i];
        right[at.first + i] += by_p * p + by_v * v;
        for (std::size_t j = 0; round == 0 && j <= i; ++j) {
          fit.factor[at.first + i][i - j] += by_p * at.value[j] + by_v * at.rate[j];
        }
      }
    }
    if (round == 0 && !Factor(&fit.factor)) return fit;
    SolveInPlace(fit.factor, &right);
    for (std::size_t i = 0; i < n; ++i) fit.coefficients[i] += right[i];
  }
  std::size_t interval = 0;
  for (std::size_t k = 0; k < data.size(); ++k) {
    const BasisAt at = fit.basis.At(data.time_s[k], &interval);
    fit.position_square_m2 +=
        (data.position_m[k] - Sum(fit.coefficients, at.first, at.value)).squaredNorm();
    fit.velocity_square_m2ps2 +=
        (data.velocity_mps[k] - Sum(fit.coefficients, at.first, at.rate)).squaredNorm();
  }
  // Generalised cross validation (Craven and Wahba 1979), which needs the ratio of the sigmas only.
  const double rest = 1.0 - static_cast<double>(n) / (2.0 * static_cast<double>(data.size()));
  const double square =
      position_weight * fit.position_square_m2 + velocity_weight * fit.velocity_square_m2ps2;
  if (rest > 0.0) fit.score = square / (rest * rest);
  return fit;
}

/// Intervals that grow by the square root of two: 1, 2, 3, 4, 6, 8, 12, ...
std::vector<std::size_t> Levels(std::size_t most) {
  std::vector<std::size_t> levels;
  for (std::size_t base = 1; base <= most; base *= 2) {
    levels.push_back(base);
    if (base > 1 && base + base / 2 <= most) levels.push_back(base + base / 2);
  }
  if (levels.back() != most) levels.push_back(most);
  return levels;
}

/// The level of least score: every second one, then the neighbours of the best. With a level chosen
/// before, under other sigmas, that one and its neighbours only.
Fit ChooseFit(const Recorded& data,
              const std::vector<std::size_t>& levels,
              const StateNoise& sigmas,
              std::optional<std::size_t>* chosen) {
  std::optional<Fit> best;
  const auto attempt = [&](std::size_t level) {
    Fit fit = FitOn(data, levels[level], sigmas);
    if (best && !(fit.score < best->score)) return;
    best.emplace(std::move(fit));
    *chosen = level;
  };
  if (*chosen) {
    attempt(**chosen);
  } else {
    for (std::size_t level = 0; level < levels.size(); level += 2) attempt(level);
  }
  const std::size_t middle = **chosen;
  if (middle > 0) attempt(middle - 1);
  if (middle + 1 < levels.size()) attempt(middle + 1);
  return std::move(*best);
}

StateMisfit MisfitOf(double square, double sigma, double leverage, std::size_t states) {
  return {square / (sigma * sigma),
          3.0 * (static_cast<double>(states) - leverage / (sigma * sigma))};
}

/// Sums of b' Z b over all states and over those of the strip.
struct Leverages {
  double position_m2 = 0.0, velocity_m2ps2 = 0.0;              ///< all
  double strip_position_m2 = 0.0, strip_velocity_m2ps2 = 0.0;  ///< of the strip
  std::size_t strip_states = 0;
};

bool Within(const Recorded& data, std::size_t k, const TimeSpan& strip_s) {
  return data.time_s[k] >= strip_s.first_s && data.time_s[k] <= strip_s.last_s;
}

Leverages LeveragesOf(const Recorded& data, const Fit& fit, const TimeSpan& strip_s) {
  const Band z = InverseBand(fit.factor);
  Leverages out;
  std::size_t interval = 0;
  for (std::size_t k = 0; k < data.size(); ++k) {
    const BasisAt at = fit.basis.At(data.time_s[k], &interval);
    const double position_m2 = Variance(z, at.first, at.value);
    const double velocity_m2ps2 = Variance(z, at.first, at.rate);
    out.position_m2 += position_m2;
    out.velocity_m2ps2 += velocity_m2ps2;
    if (!Within(data, k, strip_s)) continue;
    out.strip_position_m2 += position_m2;
    out.strip_velocity_m2ps2 += velocity_m2ps2;
    ++out.strip_states;
  }
  return out;
}

/// Mean square difference of the velocities of two fits at the states of the strip, one axis.
double DifferenceSquare(const Recorded& data, const Fit& a, const Fit& b, const TimeSpan& strip_s) {
  double sum = 0.0, count = 0.0;
  std::size_t in_a = 0, in_b = 0;
  for (std::size_t k = 0; k < data.size(); ++k) {
    const BasisAt at_a = a.basis.At(data.time_s[k], &in_a);
    const BasisAt at_b = b.basis.At(data.time_s[k], &in_b);
    if (!Within(data, k, strip_s)) continue;
    sum += (Sum(a.coefficients, at_a.first, at_a.rate) - Sum(b.coefficients, at_b.first, at_b.rate))
               .squaredNorm();
    count += 1.0;
  }
  return count > 0.0 ? sum / (3.0 * count) : 0.0;
}

/// At the times that the recording gives, to the last bit.
std::vector<StateVector> StatesAtKnots(std::span<const StateVector> recorded,
                                       const Recorded& data,
                                       const Fit& fit) {
  std::vector<StateVector> states;
  std::size_t interval = 0, state = 0;
  for (std::size_t k = 0; k <= fit.basis.intervals(); ++k) {
    const double x_s = fit.basis.Knot_s(k);
    while (data.time_s[state] < x_s) ++state;
    const BasisAt at = fit.basis.At(x_s, &interval);
    states.push_back(
        {recorded[state].time_s,
         data.origin_m + (x_s * data.mean_mps + Sum(fit.coefficients, at.first, at.value)),
         data.mean_mps + Sum(fit.coefficients, at.first, at.rate)});
  }
  return states;
}

}  // namespace

std::vector<StateVector> FitSpline(std::span<const StateVector> states,
                                   std::size_t intervals,
                                   const StateNoise& sigmas) {
  const Recorded data = LessMeanMotion(states);
  const Fit fit = FitOn(data, intervals, sigmas);
  if (!std::isfinite(fit.score)) return {};
  return StatesAtKnots(states, data, fit);
}

SmoothedPath SmoothPath(std::span<const StateVector> states,
                        const StateNoise& given,
                        const TimeSpan& strip_s) {
  const Recorded data = LessMeanMotion(states);
  const double begin_s = states.front().time_s;
  TimeSpan strip{strip_s.first_s - begin_s, strip_s.last_s - begin_s};
  const double spacing_s = data.time_s.back() / static_cast<double>(data.size() - 1);
  SmoothedPath out;
  // Below these a standard deviation is the rounding of the coordinates.
  const double least_m = 1e-15 * (data.origin_m.norm() + data.time_s.back() * data.mean_mps.norm());
  const StateNoise least{std::max(1e-9, least_m), std::max(1e-9, least_m) / spacing_s};
  const bool own_m = std::isnan(given.position_m), own_mps = std::isnan(given.velocity_mps);
  const StateNoise estimated = EstimateStateNoise(states);
  out.sigmas.position_m =
      own_m ? std::max(least.position_m, estimated.position_m) : given.position_m;
  out.sigmas.velocity_mps =
      own_mps ? std::max(least.velocity_mps, estimated.velocity_mps) : given.velocity_mps;

  const std::vector<std::size_t> levels = Levels(data.size() - 1);
  std::optional<std::size_t> level;
  Fit fit = ChooseFit(data, levels, out.sigmas, &level);
  Leverages leverages = LeveragesOf(data, fit, strip);
  const auto take_misfits = [&] {
    out.positions =
        MisfitOf(fit.position_square_m2, out.sigmas.position_m, leverages.position_m2, data.size());
    out.velocities = MisfitOf(
        fit.velocity_square_m2ps2, out.sigmas.velocity_mps, leverages.velocity_m2ps2, data.size());
  };
  take_misfits();
  constexpr int kRounds = 3;  // the estimates settle within per cents
  for (int round = 0; round < kRounds && (own_m || own_mps); ++round) {
    const auto update = [](const StateMisfit& misfit, double least_sigma, double* sigma) {
      if (misfit.freedom < 1.0) return;
      *sigma = std::max(least_sigma, *sigma * std::sqrt(misfit.chi_square / misfit.freedom));
    };
    if (own_m) update(out.positions, least.position_m, &out.sigmas.position_m);
    if (own_mps) update(out.velocities, least.velocity_mps, &out.sigmas.velocity_mps);
    fit = ChooseFit(data, levels, out.sigmas, &level);
    leverages = LeveragesOf(data, fit, strip);
    take_misfits();
  }
  if (leverages.strip_states == 0) {  // a strip between two states
    leverages.strip_position_m2 = leverages.position_m2;
    leverages.strip_velocity_m2ps2 = leverages.velocity_m2ps2;
    leverages.strip_states = data.size();
    strip = {0.0, data.time_s.back()};
  }
  const auto mean = [&leverages](double sum) {
    return sum / static_cast<double>(leverages.strip_states);
  };
  out.remaining = {std::sqrt(mean(leverages.strip_position_m2)),
                   std::sqrt(mean(leverages.strip_velocity_m2ps2))};
  const std::size_t finer = std::min(2 * fit.basis.intervals(), data.size() - 1);
  if (finer > fit.basis.intervals()) {
    const Fit denser = FitOn(data, finer, out.sigmas);
    if (std::isfinite(denser.score)) {
      const Leverages of_denser = LeveragesOf(data, denser, strip);
      const double noise = mean(of_denser.strip_velocity_m2ps2 - leverages.strip_velocity_m2ps2);
      out.unfollowed_mps =
          std::sqrt(std::max(0.0, DifferenceSquare(data, fit, denser, strip) - noise));
    }
  }
  out.states = StatesAtKnots(states, data, fit);
  return out;
}

}  // namespace sarblock
