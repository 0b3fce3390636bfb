// SPDX-License-Identifier: Apache-2.0
// Two to nine states: nothing, or little, is left to compare a path with. Oracles are closed forms:
// the flight itself, between the states.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "geometry/recorded_states.h"
#include "geometry/test_flights.h"
#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

constexpr std::array kReadings{
    PathThrough::kStates, PathThrough::kOrbit, PathThrough::kPositions, PathThrough::kSmooth};

/// A Kepler orbit in axes that turn with the Earth, eccentricity 0.001, inclination 97.5 degrees.
class KeplerOrbit {
 public:
  explicit KeplerOrbit(double height_m) : a_m_(6371e3 + height_m) {}

  [[nodiscard]] StateVector operator()(double time_s) const {
    constexpr double kGravity_m3ps2 = 3.986004418e14, kTurn_radps = 7.292115e-5;
    constexpr double kEccentricity = 0.001, kInclination_rad = 1.7017;
    const double n_radps = std::sqrt(kGravity_m3ps2 / (a_m_ * a_m_ * a_m_));
    const double mean = 0.7 + n_radps * time_s;
    double e = mean;
    for (int i = 0; i < 8; ++i) e = mean + kEccentricity * std::sin(e);
    const double rate = n_radps / (1.0 - kEccentricity * std::cos(e));
    const double b_m = a_m_ * std::sqrt(1.0 - kEccentricity * kEccentricity);
    const Eigen::Vector3d in_plane(a_m_ * (std::cos(e) - kEccentricity), b_m * std::sin(e), 0.0);
    const Eigen::Vector3d rate_in_plane(-a_m_ * rate * std::sin(e), b_m * rate * std::cos(e), 0.0);
    const Eigen::Matrix3d turn =
        (Eigen::AngleAxisd(-kTurn_radps * time_s, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(kInclination_rad, Eigen::Vector3d::UnitX()))
            .toRotationMatrix();
    const Eigen::Vector3d p_m = turn * in_plane;
    return {time_s, p_m, turn * rate_in_plane - kTurn_radps * Eigen::Vector3d::UnitZ().cross(p_m)};
  }

 private:
  double a_m_;
};

/// Errors along track at a target, between the states of the strip: reported and true.
struct AlongTrack {
  double reported_m = 0.0, true_m = 0.0;
};

template <typename Flight>
AlongTrack Read(const Flight& flight,
                const Recording& recording,
                const TimeSpan& span_s,
                PathThrough through,
                double range_m) {
  const RecordedPath read = recording.Read(through, 1e-10);
  const double turning_s = range_m / flight(0.0).velocity_mps.norm();
  double rate = 0.0, place = 0.0, count = 0.0;
  const double step_s = (span_s.last_s - span_s.first_s) / 119.3;
  for (double t_s = span_s.first_s; t_s < span_s.last_s; t_s += step_s) {
    const StateVector truth = flight(t_s);
    const Motion motion = *read.path.At(t_s);
    const Eigen::Vector3d u = truth.velocity_mps.normalized();
    const Eigen::Vector3d e = motion.velocity_mps - truth.velocity_mps;
    rate += (e - u * u.dot(e)).squaredNorm();
    place += (motion.position_m - truth.position_m).squaredNorm();
    count += 1.0;
  }
  const PathErrors& errors = read.errors;
  const double rate_mps =
      std::hypot(errors.noise.velocity_mps, errors.contradiction_mps, errors.interpolation_mps);
  return {std::hypot(errors.noise.position_m, errors.interpolation_m, turning_s * rate_mps),
          std::hypot(std::sqrt(place / count), turning_s * std::sqrt(rate / count))};
}

/// Calls `test` with the errors of all ways, for two to nine states 10 to 480 s apart. `whole`: the
/// strip is all of the recording in place of its middle interval.
template <typename Flight, typename Test>
void ForFewStates(const Flight& flight, double range_m, const Test& test) {
  for (const double h_s : {10.0, 30.0, 60.0, 120.0, 240.0, 480.0}) {
    for (std::size_t count = 2; count < 10; ++count) {
      for (const bool whole : {false, true}) {
        std::vector<StateVector> states;
        for (std::size_t k = 0; k < count; ++k) {
          states.push_back(flight(31.25 + h_s * static_cast<double>(k)));
        }
        const std::size_t middle = count / 2 - 1;
        const TimeSpan span_s{states[whole ? 0 : middle].time_s,
                              states[whole ? count - 1 : middle + 1].time_s};
        const Recording recording(
            states, {}, {span_s.first_s + 1e-3 * h_s, span_s.last_s - 1e-3 * h_s});
        std::array<AlongTrack, kReadings.size()> errors;
        for (std::size_t i = 0; i < kReadings.size(); ++i) {
          errors[i] = Read(flight, recording, span_s, kReadings[i], range_m);
        }
        test(errors, h_s, count);
      }
    }
  }
}

/// The true error of the way that reports least, as a multiple of that of the best way.
double ChosenByBest(const std::array<AlongTrack, kReadings.size()>& errors) {
  const auto& chosen =
      *std::min_element(errors.begin(), errors.end(), [](const AlongTrack& a, const AlongTrack& b) {
        return a.reported_m < b.reported_m;
      });
  const auto& best =
      *std::min_element(errors.begin(), errors.end(), [](const AlongTrack& a, const AlongTrack& b) {
        return a.true_m < b.true_m;
      });
  return chosen.true_m / best.true_m;
}

// Closed form. Below a millimetre the states made for the polynomials (1e-10 rad) are what is seen.
TEST(FewStatesTest, OfAnOrbitErrorsOfAllWaysAreKnownWithinAFactorOfTwo) {
  for (const double height_m : {300e3, 800e3}) {
    ForFewStates(KeplerOrbit(height_m), 850e3, [&](const auto& errors, double h_s, auto count) {
      for (std::size_t i = 0; i < errors.size(); ++i) {
        const auto [reported_m, true_m] = errors[i];
        const std::string what = std::string(NameOf(kReadings[i])) + ", " + std::to_string(count) +
                                 " states " + std::to_string(h_s) + " s apart, height " +
                                 std::to_string(height_m);
        EXPECT_GT(reported_m, 0.5 * true_m - 1e-3) << what;
        EXPECT_LT(reported_m, 2.0 * true_m + 1e-3) << what;
      }
      if (count >= 3) {
        EXPECT_LT(ChosenByBest(errors), 1.5) << count << " states " << h_s << " s apart";
      }
    });
  }
}

// Closed form, nine phases of the waves. What the states do not resolve is bounded by their own
// scatter, two to eighteen numbers: a few draws of a hundred are low by chance.
TEST(FewStatesTest, OfAnUnresolvedFlightNoWayReportsAnErrorFarTooSmall) {
  double low = 0.0, poor = 0.0, all = 0.0;
  for (int draw = 0; draw < 9; ++draw) {
    ForFewStates(
        test::Aircraft(1.37 * draw), 7100.0, [&](const auto& errors, double h_s, auto count) {
          for (std::size_t i = 0; i < errors.size(); ++i) {
            const auto [reported_m, true_m] = errors[i];
            EXPECT_GT(reported_m, 0.05 * true_m) << NameOf(kReadings[i]) << count << " " << h_s;
            EXPECT_LT(reported_m, 6.0 * true_m) << NameOf(kReadings[i]) << count << " " << h_s;
            low += reported_m < 0.5 * true_m ? 1.0 : 0.0;
          }
          poor += ChosenByBest(errors) > 1.5 ? 1.0 : 0.0;
          all += 1.0;
        });
  }
  EXPECT_LT(low, 0.02 * all * static_cast<double>(kReadings.size()));
  EXPECT_LT(poor, 0.04 * all);
}

// Velocities that contradict positions, in states too few to say which are wrong: no way is
// reported as right. By hand, a cubic through velocities that are all off by b = 0.145 m/s is off
// by b (1 - 6 u + 6 u^2), b / sqrt(5) = 0.065 m/s in root mean square; a third of it is enough.
TEST(FewStatesTest, ContradictionsOfFewStatesAreNoZero) {
  const KeplerOrbit orbit(693e3);
  std::vector<StateVector> states;
  for (int k = 0; k < 6; ++k) {
    states.push_back(orbit(10.0 * k));
    states.back().velocity_mps += Eigen::Vector3d(0.05, -0.11, 0.08);
  }
  const Recording recording(states, {}, {20.0, 30.0});
  for (const PathThrough through : {PathThrough::kStates, PathThrough::kSmooth}) {
    EXPECT_GT(recording.Read(through, 1e-9).errors.interpolation_mps, 0.02) << NameOf(through);
  }
}

}  // namespace
}  // namespace sarblock
