// SPDX-License-Identifier: Apache-2.0
#include "sarblock/geometry/path.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace sarblock {
namespace {

void Check(const std::vector<StateVector>& states) {
  if (states.size() < 2) {
    throw InputError("states",
                     std::to_string(states.size()) + " given, a flight path needs two or more");
  }
  for (std::size_t k = 0; k < states.size(); ++k) {
    const StateVector& state = states[k];
    const std::string which = "state " + std::to_string(k + 1);  // people count from 1
    if (!std::isfinite(state.time_s) || !state.position_m.allFinite() ||
        !state.velocity_mps.allFinite()) {
      throw InputError(which, "time, position and velocity must be finite");
    }
    if (!(state.velocity_mps.norm() > 0.0)) {
      throw InputError(which, "velocity is zero; an antenna at rest has no track");
    }
    if (k > 0 && !(state.time_s > states[k - 1].time_s)) {
      throw InputError(which,
                       "time " + std::to_string(state.time_s) + " s must be later than " +
                           std::to_string(states[k - 1].time_s) + " s of the state before");
    }
  }
}

// The mean spacing if every time lies within a hundredth of it of the equally spaced one, else 0.
// Not exact equality: times read from a file are rounded, and At() steps to the right neighbour.
double EqualSpacing_s(const std::vector<StateVector>& states) {
  const auto pieces = static_cast<double>(states.size() - 1);
  const double spacing_s = (states.back().time_s - states.front().time_s) / pieces;
  for (std::size_t k = 0; k < states.size(); ++k) {
    const double equal_s = static_cast<double>(k) * spacing_s;
    if (std::abs(states[k].time_s - states.front().time_s - equal_s) > 0.01 * spacing_s) return 0.0;
  }
  return spacing_s;
}

// Whether `to` lies where a straight flight from `from` at its velocity comes to, but for rounding.
bool ContinuesStraight(const StateVector& from, const StateVector& to) {
  constexpr double kRounding = std::numeric_limits<double>::epsilon();
  const Eigen::Vector3d moved_m = (to.time_s - from.time_s) * from.velocity_mps;
  const Eigen::Vector3d off_m = to.position_m - (from.position_m + moved_m);
  const Eigen::Vector3d off_mps = to.velocity_mps - from.velocity_mps;
  const double size_m = from.position_m.norm() + to.position_m.norm() + moved_m.norm() +
                        (std::abs(from.time_s) + std::abs(to.time_s)) * from.velocity_mps.norm();
  return off_m.norm() <= 4.0 * kRounding * size_m &&
         off_mps.norm() <= 2.0 * kRounding * from.velocity_mps.norm();
}

}  // namespace

FlightPath::FlightPath(std::vector<StateVector> states) {
  Check(states);
  spacing_s_ = EqualSpacing_s(states);
  states_ = std::move(states);
  start_s_ = states_.front().time_s;
  end_s_ = states_.back().time_s;
  pieces_.reserve(states_.size() - 1);
  for (std::size_t k = 0, next = 0; k + 1 < states_.size(); k = next) {
    const StateVector& from = states_[k];
    next = k;
    while (next + 1 < states_.size() && ContinuesStraight(from, states_[next + 1])) ++next;
    if (next > k) {
      pieces_.push_back({from.time_s,
                         states_[next].time_s,
                         from.position_m,
                         from.velocity_mps,
                         Eigen::Vector3d::Zero(),
                         Eigen::Vector3d::Zero()});
      continue;
    }
    const StateVector& to = states_[++next];
    const double h = to.time_s - from.time_s;
    const Eigen::Vector3d mean = (to.position_m - from.position_m) / h;
    pieces_.push_back({from.time_s,
                       to.time_s,
                       from.position_m,
                       from.velocity_mps,
                       (3.0 * mean - 2.0 * from.velocity_mps - to.velocity_mps) / h,
                       (from.velocity_mps + to.velocity_mps - 2.0 * mean) / (h * h)});
  }
  if (pieces_.size() + 1 < states_.size()) {  // joined: no longer equally long
    spacing_s_ = 0.0;
    pieces_.shrink_to_fit();
  }
  FillAccelerations();
}

// Mean accelerations of the pieces are those in their middles; a state lies between two of them.
void FlightPath::FillAccelerations() {
  const std::size_t n = pieces_.size();
  std::vector<Eigen::Vector3d> at_state_mps2(n + 1);
  const auto length_s = [&](std::size_t k) { return pieces_[k].end_s - pieces_[k].start_s; };
  const auto mean_mps2 = [&](std::size_t k) -> Eigen::Vector3d {
    const double h = length_s(k);
    return 2.0 * pieces_[k].second_mps2 + (3.0 * h) * pieces_[k].third_mps3;
  };
  for (std::size_t k = 1; k < n; ++k) {
    const double before_s = length_s(k - 1), after_s = length_s(k);
    at_state_mps2[k] =
        (after_s * mean_mps2(k - 1) + before_s * mean_mps2(k)) / (before_s + after_s);
  }
  at_state_mps2[0] = mean_mps2(0);
  at_state_mps2[n] = mean_mps2(n - 1);
  if (n > 1) {  // so that the mean of the first and of the last piece is kept
    at_state_mps2[0] += at_state_mps2[0] - at_state_mps2[1];
    at_state_mps2[n] += at_state_mps2[n] - at_state_mps2[n - 1];
  }
  mean_motions_.reserve(n);
  for (std::size_t k = 0; k < n; ++k) {
    mean_motions_.push_back(
        {at_state_mps2[k], (at_state_mps2[k + 1] - at_state_mps2[k]) / length_s(k)});
  }
}

std::size_t FlightPath::PieceOf(double time_s) const {
  if (spacing_s_ > 0.0) {
    const std::size_t last = pieces_.size() - 1;
    const double before = std::max(0.0, (time_s - start_s_) / spacing_s_);
    std::size_t k = before < static_cast<double>(last) ? static_cast<std::size_t>(before) : last;
    while (k > 0 && time_s < pieces_[k].start_s) --k;
    while (k < last && time_s >= pieces_[k].end_s) ++k;
    return k;
  }
  const auto piece = std::upper_bound(
      pieces_.begin(), pieces_.end() - 1, time_s, [](double t_s, const Piece& candidate) {
        return t_s < candidate.end_s;
      });
  return static_cast<std::size_t>(piece - pieces_.begin());
}

double FlightPath::AccelerationMisfit_mps2(std::size_t index) const {
  const Piece& piece = pieces_[index];
  const double h = piece.end_s - piece.start_s;
  const MeanMotion& mean = mean_motions_[index];
  const Eigen::Vector3d first = 2.0 * piece.second_mps2 - mean.acceleration_mps2;
  const Eigen::Vector3d last = first + h * (6.0 * piece.third_mps3 - mean.jerk_mps3);
  return std::max(first.norm(), last.norm());
}

bool FlightPath::Read(double time_s,
                      Acceleration acceleration,
                      Motion* out,
                      std::size_t* index) const {
  const double most_s = end_s_ - start_s_;
  if (!(time_s >= start_s_ - most_s && time_s <= end_s_ + most_s)) return false;
  const std::size_t k = PieceOf(time_s);
  if (index != nullptr) *index = k;
  const Piece& piece = pieces_[k];
  // Everything relative to the state before: differences of times and of positions are (nearly)
  // exact, so only the final sum rounds at the size of the coordinates (docs/theory/flight_path.md,
  // eqs. (1) to (3)).
  const double x = time_s - piece.start_s;
  const Eigen::Vector3d& c2 = piece.second_mps2;
  const Eigen::Vector3d& c3 = piece.third_mps3;
  out->position_m = piece.position_m + x * (piece.velocity_mps + x * (c2 + x * c3));
  out->velocity_mps = piece.velocity_mps + x * (2.0 * c2 + (3.0 * x) * c3);
  if (acceleration == Acceleration::kOfCubic) {
    out->jerk_mps3 = 6.0 * c3;
    out->acceleration_mps2 = 2.0 * c2 + x * out->jerk_mps3;
  } else {
    out->jerk_mps3 = mean_motions_[k].jerk_mps3;
    out->acceleration_mps2 = mean_motions_[k].acceleration_mps2 + x * out->jerk_mps3;
  }
  return true;
}

bool FlightPath::Evaluate(double time_s, Motion* out) const {
  return time_s >= start_s_ && time_s <= end_s_ && Read(time_s, Acceleration::kOfCubic, out);
}

void FlightPath::Prefetch(double time_s) const {
  if (!(spacing_s_ > 0.0) || !(time_s >= start_s_ && time_s <= end_s_)) return;
  const auto k = static_cast<std::size_t>((time_s - start_s_) / spacing_s_);
  const Piece* piece = &pieces_[std::min(pieces_.size() - 1, k)];
  __builtin_prefetch(piece);
  __builtin_prefetch(&piece->third_mps3);
}

bool FlightPath::IsStraight() const {
  return pieces_.size() == 1 && pieces_[0].second_mps2.isZero(0.0) &&
         pieces_[0].third_mps3.isZero(0.0);
}

std::optional<Motion> FlightPath::At(double time_s) const {
  std::optional<Motion> motion(std::in_place);
  if (!Evaluate(time_s, &*motion)) motion.reset();
  return motion;
}

const char* NameOf(PathThrough through) {
  switch (through) {
    case PathThrough::kStates:
      return "states";
    case PathThrough::kOrbit:
      return "orbit";
    case PathThrough::kPositions:
      return "positions";
    case PathThrough::kSmooth:
      return "smooth";
    case PathThrough::kAuto:
      return "auto";
  }
  return "";
}

NewtonPolynomial::NewtonPolynomial(std::span<const StateVector> states, OrbitThrough through)
    : origin_m_(states.front().position_m) {
  const std::size_t repeat = through == OrbitThrough::kStates ? 2 : 1;
  std::vector<Eigen::Vector3d> column;
  for (const StateVector& state : states) {
    for (std::size_t k = 0; k < repeat; ++k) {
      node_s_.push_back(state.time_s);
      column.emplace_back(state.position_m - origin_m_);
    }
  }
  coefficients_.push_back(column[0]);
  for (std::size_t order = 1; order < node_s_.size(); ++order) {
    for (std::size_t i = 0; i + order < node_s_.size(); ++i) {
      const double span_s = node_s_[i + order] - node_s_[i];
      // For a repeated node the difference is the derivative: the given velocity.
      column[i] = span_s == 0.0 ? states[i / repeat].velocity_mps
                                : Eigen::Vector3d((column[i + 1] - column[i]) / span_s);
    }
    coefficients_.push_back(column[0]);
  }
}

StateVector NewtonPolynomial::At(double time_s) const {
  StateVector state;
  state.time_s = time_s;
  for (std::size_t k = node_s_.size(); k-- > 0;) {
    const double x_s = time_s - node_s_[k];
    state.velocity_mps = (state.velocity_mps * x_s + state.position_m).eval();
    state.position_m = (state.position_m * x_s + coefficients_[k]).eval();
  }
  state.position_m += origin_m_;
  return state;
}

std::span<const StateVector> StatesAround(std::span<const StateVector> states,
                                          std::size_t k,
                                          std::size_t count) {
  count = std::min(count, states.size());
  const std::size_t before = count / 2 - 1;
  const std::size_t first = std::min(k > before ? k - before : 0, states.size() - count);
  return states.subspan(first, count);
}

std::vector<StateVector> ResampleOrbit(const std::vector<StateVector>& states,
                                       double step_s,
                                       OrbitThrough through) {
  if (!(step_s > 0.0)) {
    throw InputError("step_s", "must be a number above 0, got " + std::to_string(step_s));
  }
  const FlightPath checked(states);  // refuses what is no path
  const bool keep = through == OrbitThrough::kStates;
  const std::size_t count = StatesOf(through);
  std::vector<StateVector> dense;
  for (std::size_t k = 0; k + 1 < states.size(); ++k) {
    const NewtonPolynomial polynomial(StatesAround(states, k, count), through);
    const double from_s = states[k].time_s, span_s = states[k + 1].time_s - from_s;
    const double parts = std::max(1.0, std::ceil(span_s / step_s * (1.0 - 1e-9)));
    dense.push_back(keep ? states[k] : polynomial.At(from_s));
    for (double part = 1.0; part < parts; part += 1.0) {
      dense.push_back(polynomial.At(from_s + span_s * part / parts));
    }
    if (k + 2 == states.size()) {
      dense.push_back(keep ? states[k + 1] : polynomial.At(states[k + 1].time_s));
    }
  }
  return dense;
}

}  // namespace sarblock
