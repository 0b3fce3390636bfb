// SPDX-License-Identifier: Apache-2.0
#include "sarblock/geometry/look_equations.h"

#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <array>
#include <cmath>
#include <limits>

#include "geometry/fifty_digits.h"
#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using test::Exact;
using test::InnerProduct;
using test::Real;
using test::RealVector;

struct RealErrors {
  Real rho;
  Real doppler;
};

// The two equations as model.md writes them, by the angle itself, in 50 digits.
RealErrors Twin(const RealVector& p,
                const RealVector& s,
                const RealVector& v,
                const Cone& cone,
                const Real& b) {
  const RealVector d = {p[0] - s[0], p[1] - s[1], p[2] - s[2]};
  const Real rho = sqrt(InnerProduct(d, d));
  const Real speed = sqrt(InnerProduct(v, v));
  const Real tau = cone.kind == Cone::Kind::kSquint ? Real(cone.squint_rad)
                                                    : asin(Real(cone.closing_mps) / speed);
  return {rho, InnerProduct(v, d) / speed - rho * sin(tau + b)};
}

RealVector Moved(RealVector v, std::size_t axis, const Real& by) {
  v[axis] += by;
  return v;
}

const Real kStep("1e-12");

double Slope(const Real& ahead, const Real& behind) {
  return static_cast<double>((ahead - behind) / (2 * kStep));
}

struct Case {
  Eigen::Vector3d p, s, v, a;
  Cone cone;
  double bias;
};

Case RandomCase(std::uint64_t seed) {
  RandomStream random(20790117, seed);
  const auto vector = [&random](double size) -> Eigen::Vector3d {
    return {size * random.Normal(), size * random.Normal(), size * random.Normal()};
  };
  const bool orbit = seed % 3 == 0;
  Case c;
  c.p = vector(orbit ? 4e6 : 3e3);
  c.s = c.p + vector(orbit ? 4e5 : 6e3);
  c.v = vector(orbit ? 4300.0 : 97.0);
  c.a = vector(orbit ? 5.1 : 0.7);
  const double sin_tau = 1.7 * (random.Uniform() - 0.5);
  if (seed % 2 == 0) {
    c.cone.squint_rad = std::asin(sin_tau);
  } else {
    c.cone.kind = Cone::Kind::kDoppler;
    c.cone.closing_mps = sin_tau * c.v.norm();
  }
  c.bias = 0.02 * random.Normal();
  return c;
}

TEST(LookEquationsTest, GivesHandValuesOfAPythagoreanLook) {
  // d = (2, 3, -6) m x 1000, rho = 7000 m; u = (3, 0, 4)/5, so u.d = (6 - 24)/5 km = -3600 m.
  LookEquations look;
  ASSERT_TRUE(EvaluateLookEquations(
      {2001.25, 3002.5, -5996.25}, {1.25, 2.5, 3.75}, {150.0, 0.0, 200.0}, Cone{}, 0.0, &look));
  EXPECT_NEAR(look.rho_m, 7000.0, 1e-11);
  EXPECT_EQ(look.sin_tau, 0.0);
  EXPECT_NEAR(look.doppler_error_m, -3600.0, 1e-11);
  EXPECT_NEAR(look.drho_dp[0], 2.0 / 7.0, 1e-15);
  EXPECT_NEAR(look.drho_dp[2], -6.0 / 7.0, 1e-15);
  EXPECT_NEAR(look.ded_dp[0], 0.6, 1e-15);
  EXPECT_NEAR(look.ded_dp[2], 0.8, 1e-15);
  EXPECT_NEAR(look.ded_dtau_m, -7000.0, 1e-11);
  // (d - (u.d) u)/|v| = (2000 + 2160, 3000, -6000 + 2880)/250.
  EXPECT_NEAR(look.ded_dv[0], 16.64, 1e-13);
  EXPECT_NEAR(look.ded_dv[1], 12.0, 1e-13);
  EXPECT_NEAR(look.ded_dv[2], -12.48, 1e-13);
}

TEST(LookEquationsTest, GivesHandValuesOfADopplerCentroid) {
  // closing/|v| = 0.28, so the error is -3600 - 0.28 * 7000 = -5560 m.
  Cone cone;
  cone.kind = Cone::Kind::kDoppler;
  cone.closing_mps = 70.0;
  LookEquations look;
  ASSERT_TRUE(EvaluateLookEquations(
      {2000.0, 3000.0, -6000.0}, Eigen::Vector3d::Zero(), {150.0, 0.0, 200.0}, cone, 0.0, &look));
  EXPECT_NEAR(look.sin_tau, 0.28, 1e-15);
  EXPECT_NEAR(look.doppler_error_m, -5560.0, 1e-11);
  EXPECT_NEAR(look.ded_dtau_m, -7000.0 * 0.96, 1e-11);
}

// Two routes: the code against the model's own formula in 50 digits, both cone kinds, aircraft and
// orbit, with a squint bias.
TEST(LookEquationsTest, AgreesWithFiftyDigits) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const Case c = RandomCase(seed);
    LookEquations look;
    ASSERT_TRUE(EvaluateLookEquations(c.p, c.s, c.v, c.cone, c.bias, &look)) << seed;
    const RealErrors twin = Twin(Exact(c.p), Exact(c.s), Exact(c.v), c.cone, Real(c.bias));
    // A few roundings of the range (1e6 m: 1e-10 m each).
    const double tolerance_m = 2e-15 * look.rho_m;
    EXPECT_NEAR(look.rho_m, static_cast<double>(twin.rho), tolerance_m) << seed;
    EXPECT_NEAR(look.doppler_error_m, static_cast<double>(twin.doppler), tolerance_m) << seed;
  }
}

// Central differences with a step of 1e-12 in 50 digits: their own error is below 1e-20.
TEST(LookEquationsTest, PartialsAgreeWithFiftyDigitDifferences) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const Case c = RandomCase(seed);
    LookEquations look;
    ASSERT_TRUE(EvaluateLookEquations(c.p, c.s, c.v, c.cone, c.bias, &look)) << seed;
    const RealVector p = Exact(c.p), s = Exact(c.s), v = Exact(c.v);
    const Real b(c.bias);
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Index k = static_cast<Eigen::Index>(i);
      const RealErrors p_ahead = Twin(Moved(p, i, kStep), s, v, c.cone, b);
      const RealErrors p_behind = Twin(Moved(p, i, -kStep), s, v, c.cone, b);
      EXPECT_NEAR(look.drho_dp[k], Slope(p_ahead.rho, p_behind.rho), 1e-13) << seed;
      EXPECT_NEAR(look.ded_dp[k], Slope(p_ahead.doppler, p_behind.doppler), 1e-13) << seed;
      const RealErrors v_ahead = Twin(p, s, Moved(v, i, kStep), c.cone, b);
      const RealErrors v_behind = Twin(p, s, Moved(v, i, -kStep), c.cone, b);
      const double scale_s = look.rho_m / c.v.norm();
      EXPECT_NEAR(look.ded_dv[k], Slope(v_ahead.doppler, v_behind.doppler), 1e-13 * scale_s)
          << seed;
    }
    const double dtau_m =
        Slope(Twin(p, s, v, c.cone, b + kStep).doppler, Twin(p, s, v, c.cone, b - kStep).doppler);
    EXPECT_NEAR(look.ded_dtau_m, dtau_m, 1e-13 * look.rho_m) << seed;
  }
}

// The rates are derivatives along the accelerated path, v turning with it (no squint bias).
TEST(LookEquationsTest, TimeRatesAgreeWithFiftyDigitDifferences) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const Case c = RandomCase(seed);
    const auto at = [&c](const Real& t) {
      RealVector s = Exact(c.s), v = Exact(c.v);
      for (std::size_t i = 0; i < 3; ++i) {
        const Real a(c.a[static_cast<Eigen::Index>(i)]);
        s[i] += v[i] * t + a * t * t / 2;
        v[i] += a * t;
      }
      return Twin(Exact(c.p), s, v, c.cone, Real(0));
    };
    const RealErrors ahead = at(kStep), behind = at(-kStep);
    const TimeRates rates = LookTimeRates(c.p, c.s, c.v, c.a, c.cone);
    const double tolerance_mps =
        1e-13 * (c.v.norm() + (c.p - c.s).norm() * c.a.norm() / c.v.norm());
    EXPECT_NEAR(rates.range_mps, Slope(ahead.rho, behind.rho), tolerance_mps) << seed;
    EXPECT_NEAR(rates.doppler_mps, Slope(ahead.doppler, behind.doppler), tolerance_mps) << seed;
  }
}

// The cone is moved on by dt, the target by w dt so that range and cone hold it still: the speed is
// u.w. A straight flight carries its target along: w = v, at every squint.
TEST(LookEquationsTest, ALookPassesOverItsTargetAtTheSpeedOfAStraightFlight) {
  const Eigen::Vector3d v(171.3, 21.7, -2.9), abeam(-2130.0, 16813.0, -9000.0);
  const Eigen::Vector3d u = v.normalized();
  const double across_m = (abeam - u.dot(abeam) * u).norm();
  for (int squint_deg = 0; squint_deg <= 60; squint_deg += 10) {
    Cone cone;
    cone.squint_rad = squint_deg * kRadPerDeg;
    const Eigen::Vector3d s(13.1, -7.3, 9010.0);
    const Eigen::Vector3d p =
        s + (abeam - u.dot(abeam) * u) + across_m * std::tan(cone.squint_rad) * u;
    const TimeRates rates = LookTimeRates(p, s, v, Eigen::Vector3d::Zero(), cone);
    EXPECT_NEAR(rates.along_mps, v.norm(), 1e-9) << squint_deg;
    const double cosine = std::cos(cone.squint_rad);
    EXPECT_NEAR(rates.doppler_mps, -v.norm() * cosine * cosine, 1e-9) << squint_deg;
  }
}

// A circular orbit turns everything about the body's centre: w = omega x p.
TEST(LookEquationsTest, ALookPassesOverItsTargetAtTheTurnOfACircularOrbit) {
  const Eigen::Vector3d omega(0.0, 1.07e-3, 0.0);  // flies along +x above +z
  for (const double squint_deg : {0.0, 17.0, -33.0}) {
    const double angle_rad = -squint_deg * kRadPerDeg * 0.2;
    const Eigen::Vector3d s =
        7.07e6 * Eigen::Vector3d(std::sin(angle_rad), 0.0, std::cos(angle_rad));
    const Eigen::Vector3d p(0.0, 4.9e5, 6.35e6);
    const Eigen::Vector3d v = omega.cross(s), a = omega.cross(omega.cross(s));
    Cone cone;
    cone.squint_rad = std::asin(v.normalized().dot((p - s).normalized()));
    const TimeRates rates = LookTimeRates(p, s, v, a, cone);
    EXPECT_NEAR(rates.along_mps, v.normalized().dot(omega.cross(p)), 1e-8) << squint_deg;
  }
}

TEST(LookEquationsTest, RefusesALineOfSightThatVanishes) {
  const Eigen::Vector3d s(12.5, -7.25, 3.125);
  LookEquations look;
  EXPECT_FALSE(EvaluateLookEquations(s, s, {91.0, 2.0, 0.0}, Cone{}, 0.0, &look));
  EXPECT_FALSE(EvaluateLookEquations(
      s + Eigen::Vector3d(9e-4, 0.0, 0.0), s, {91.0, 2.0, 0.0}, Cone{}, 0.0, &look));
  EXPECT_TRUE(EvaluateLookEquations(
      s + Eigen::Vector3d(1.1e-3, 0.0, 0.0), s, {91.0, 2.0, 0.0}, Cone{}, 0.0, &look));
}

TEST(LookEquationsTest, RefusesAStandingAntennaAndAnEmptyCone) {
  const Eigen::Vector3d p(31.0, 42.0, -57.0), s(1.0, 2.0, 3.0);
  LookEquations look;
  EXPECT_FALSE(EvaluateLookEquations(p, s, Eigen::Vector3d::Zero(), Cone{}, 0.0, &look));
  Cone cone;
  cone.kind = Cone::Kind::kDoppler;
  cone.closing_mps = 101.0;
  EXPECT_FALSE(EvaluateLookEquations(p, s, {60.0, 80.0, 0.0}, cone, 0.0, &look));
  cone.closing_mps = -99.9;
  EXPECT_TRUE(EvaluateLookEquations(p, s, {60.0, 80.0, 0.0}, cone, 0.0, &look));
}

TEST(LookEquationsTest, RefusesInputThatIsNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Eigen::Vector3d p(31.0, 42.0, -57.0), s(1.0, 2.0, 3.0), v(60.0, 80.0, 0.0);
  LookEquations look;
  EXPECT_FALSE(EvaluateLookEquations({nan, 0.0, 0.0}, s, v, Cone{}, 0.0, &look));
  EXPECT_FALSE(EvaluateLookEquations(p, {0.0, nan, 0.0}, v, Cone{}, 0.0, &look));
  EXPECT_FALSE(EvaluateLookEquations(p, s, {0.0, 0.0, nan}, Cone{}, 0.0, &look));
  EXPECT_FALSE(EvaluateLookEquations(p, s, v, Cone{}, nan, &look));
  Cone cone;
  cone.squint_rad = nan;
  EXPECT_FALSE(EvaluateLookEquations(p, s, v, cone, 0.0, &look));
}

}  // namespace
}  // namespace sarblock
