// SPDX-License-Identifier: Apache-2.0
#include "resample.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "newton_polynomial.h"

namespace sarblock {
std::vector<StateVector> ResampleOrbit(const std::vector<StateVector>& states,
                                       double step_s,
                                       OrbitThrough through) {
  if (!(step_s > 0.0)) {
    throw InputError("step_s", std::to_string(step_s) + " is not allowed, a number above 0 is");
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
