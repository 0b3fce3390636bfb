// SPDX-License-Identifier: Apache-2.0
#include "newton_polynomial.h"

#include <algorithm>

namespace sarblock {

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
      // Of a node that stands twice the difference is the derivative: the given velocity.
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

}  // namespace sarblock
