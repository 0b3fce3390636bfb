// SPDX-License-Identifier: Apache-2.0
#include "sarblock/flight/resample.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>

namespace sarblock {
namespace {

constexpr std::size_t kHermiteStates = 4;   // degree 7: what states 10 s apart need in a low orbit
constexpr std::size_t kPositionStates = 8;  // degree 7
constexpr std::size_t kContradictionHalf = 4;  // nine positions, centred

/// Newton's form of an interpolation polynomial: nodes with repetitions and divided differences,
/// docs/theory/flight_path.md, eq. (14)-(15).
class NewtonPolynomial {
 public:
  NewtonPolynomial(std::span<const StateVector> states, OrbitThrough through)
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
        // Of a node that stands twice the difference is the derivative: the given velocity.
        column[i] = span_s == 0.0 ? states[i / repeat].velocity_mps
                                  : Eigen::Vector3d((column[i + 1] - column[i]) / span_s);
      }
      coefficients_.push_back(column[0]);
    }
  }

  [[nodiscard]] StateVector At(double time_s) const {
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

 private:
  Eigen::Vector3d origin_m_;  // keeps the differences small
  std::vector<double> node_s_;
  std::vector<Eigen::Vector3d> coefficients_;
};

// `count` states around the interval that begins at state k, all if there are fewer.
std::span<const StateVector> Around(const std::vector<StateVector>& states,
                                    std::size_t k,
                                    std::size_t count) {
  count = std::min(count, states.size());
  const std::size_t before = count / 2 - 1;
  const std::size_t first = std::min(k > before ? k - before : 0, states.size() - count);
  return std::span(states).subspan(first, count);
}

}  // namespace

std::vector<StateVector> ResampleOrbit(const std::vector<StateVector>& states,
                                       double step_s,
                                       OrbitThrough through) {
  if (!(step_s > 0.0)) {
    throw InputError("step_s", std::to_string(step_s) + " is not allowed, a number above 0 is");
  }
  const FlightPath checked(states);  // refuses what is no path
  const bool keep = through == OrbitThrough::kStates;
  const std::size_t count = keep ? kHermiteStates : kPositionStates;
  std::vector<StateVector> dense;
  for (std::size_t k = 0; k + 1 < states.size(); ++k) {
    const NewtonPolynomial polynomial(Around(states, k, count), through);
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

double VelocityContradiction_mps(const std::vector<StateVector>& states) {
  constexpr std::size_t kCount = 2 * kContradictionHalf + 1;
  double largest_mps = 0.0;
  for (std::size_t first = 0; first + kCount <= states.size(); ++first) {
    const std::span<const StateVector> nine(&states[first], kCount);
    const NewtonPolynomial polynomial(nine, OrbitThrough::kPositions);
    const StateVector& middle = states[first + kContradictionHalf];
    largest_mps = std::max(
        largest_mps, (polynomial.At(middle.time_s).velocity_mps - middle.velocity_mps).norm());
  }
  return largest_mps;
}

}  // namespace sarblock
