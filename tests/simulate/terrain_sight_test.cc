// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/simulate/scene.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <vector>

#include "simulate/places.h"
#include "simulate/small_scene.h"
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using Loss = std::optional<LookLoss>;

const Motion kEastward{.position_m = {0.0, 0.0, 9000.0}, .velocity_mps = {100.0, 0.0, 0.0}};

/// Ground in a local frame whose height depends on y alone, seen by kEastward to its left, +y.
class Profile {
 public:
  Profile(std::function<double(double)> height_m, double highest_m, double steepest)
      : height_m_(std::move(height_m)),
        sight_(scene_,
               {[this](const Eigen::Vector2d& p_m) { return height_m_(p_m.y()); },
                -highest_m,
                highest_m,
                steepest,
                20.0}) {}
  /// What hides the ground at y from an antenna that is `back_m` behind it.
  Loss At(double y_m, double back_m = 0.0) const {
    return sight_.Hides(kEastward, LookSide::kLeft, {back_m, y_m, height_m_(y_m)});
  }

 private:
  std::function<double(double)> height_m_;
  Scene scene_;
  TerrainSight sight_;
};

// Hand arithmetic: 12 km beside and 9 km below the antenna the incidence angle is atan(4/3) = 53.13
// degrees and the grazing angle 36.87. The face is 20 m high, so that the range's circle leaves its
// tangent by 25^2/(2 15000) = 0.02 m at its ends, which 0.1 degrees of slope outdo.
TEST(TerrainSightTest, AFacetIsLostBeyondTheIncidenceAndTheGrazingAngle) {
  const double incidence_deg = std::atan2(4.0, 3.0) / kRadPerDeg;
  const auto facet = [](double slope_deg) {
    const double tangent = std::tan(slope_deg * kRadPerDeg);
    const Profile profile(
        [tangent](double y_m) { return std::clamp(tangent * (y_m - 12000.0), -20.0, 20.0); },
        20.0,
        std::abs(tangent));
    return profile.At(12000.0);
  };
  EXPECT_EQ(facet(incidence_deg - 0.2), Loss());
  EXPECT_EQ(facet(incidence_deg + 0.2), Loss(LookLoss::kLayover));
  EXPECT_EQ(facet(80.0), Loss(LookLoss::kLayover));
  EXPECT_EQ(facet(20.0), Loss());
  EXPECT_EQ(facet(-(90.0 - incidence_deg) + 0.01), Loss());
  EXPECT_EQ(facet(-(90.0 - incidence_deg) - 0.01), Loss(LookLoss::kShadow));
  EXPECT_EQ(facet(-80.0), Loss(LookLoss::kShadow));
}

// Hand arithmetic of a ridge 300 m high at y = 10 km with faces of tangent 3. The line from the
// antenna over its crest reaches the ground at 10000 * 9000/8700 = 10344.83 m, which is the height
// times the tangent of the incidence, 10000/8700, behind it. The crest is 13254.81 m away: as far
// as the ground at sqrt(13254.81^2 - 9000^2) = 9730.88 m. The near foot, at 9900 m, is farther than
// the crest and nearer than the far foot.
TEST(TerrainSightTest, ARidgeHasTheShadowOfItsHeightAndTheLayoverOfItsRange) {
  const Profile ridge(
      [](double y_m) { return std::max(0.0, 300.0 - 3.0 * std::abs(y_m - 10000.0)); }, 300.0, 3.0);
  const double shadow_end_m = 10000.0 + 300.0 * 10000.0 / 8700.0;
  const double layover_start_m = std::sqrt(1e8 + 8700.0 * 8700.0 - 9000.0 * 9000.0);
  EXPECT_NEAR(shadow_end_m, 10344.83, 0.005);
  EXPECT_NEAR(layover_start_m, 9730.88, 0.005);
  // The ridge is parallel to the flight: squinted lines end on the same parallel.
  for (const double back_m : {0.0, 4000.0, -9000.0}) {
    EXPECT_EQ(ridge.At(layover_start_m - 0.1, back_m), Loss());
    EXPECT_EQ(ridge.At(layover_start_m + 0.1, back_m), Loss(LookLoss::kLayover));
    EXPECT_EQ(ridge.At(9899.0, back_m), Loss(LookLoss::kLayover));
    EXPECT_EQ(ridge.At(9950.0, back_m), Loss(LookLoss::kLayover));
    EXPECT_EQ(ridge.At(10050.0, back_m), Loss(LookLoss::kShadow));
    EXPECT_EQ(ridge.At(shadow_end_m - 0.1, back_m), Loss(LookLoss::kShadow));
    EXPECT_EQ(ridge.At(shadow_end_m + 0.1, back_m), Loss());
    EXPECT_EQ(ridge.At(5000.0, back_m), Loss());
  }
}

// Closed form on a sphere: a wall at the centre angle g, its top w high, seen from r = a + H. The
// line from the antenna over the top meets the sphere again where line and circle in the plane do;
// the ground at the top's range is at cos = (r^2 + a^2 - R^2)/(2 r a). A plane would put the
// shadow's end 300 km away elsewhere by kilometres. Metres of the tangent plane are 2 percent
// longer than those of the sphere there, slopes that much steeper.
TEST(TerrainSightTest, TheCurvatureOfABodyCounts) {
  Scene scene;
  scene.frame = Frame::Geocentric(NamedEllipsoid("Moon"));
  const double a_m = scene.frame.ellipsoid().a_m, r_m = a_m + 200e3, wall_m = 4000.0;
  const double wall_east_m = 250e3, wall_rad = std::atan2(wall_east_m, a_m);
  const auto height = [&](double east_m) {
    return std::max(0.0, wall_m - 10.0 * std::abs(east_m - wall_east_m));
  };
  const TerrainSight sight(
      scene,
      {[&](const Eigen::Vector2d& p_m) { return height(p_m.x()); }, 0.0, wall_m, 10.5, 300.0});
  const Motion northward{.position_m = {r_m, 0.0, 0.0}, .velocity_mps = {0.0, 0.0, 1600.0}};
  const auto at = [&](double east_m) {
    const Eigen::Vector3d p_m = FrameFromPlane(scene, {east_m, 0.0}, height(east_m));
    return sight.Hides(northward, LookSide::kRight, p_m);
  };
  const Eigen::Vector2d antenna_m(r_m, 0.0);
  const Eigen::Vector2d top_m =
      (a_m + wall_m) * Eigen::Vector2d(std::cos(wall_rad), std::sin(wall_rad));
  const Eigen::Vector2d along = (top_m - antenna_m).normalized();
  const double nearest_m = -antenna_m.dot(along);
  const double to_ground_m = nearest_m - std::sqrt(nearest_m * nearest_m - r_m * r_m + a_m * a_m);
  const Eigen::Vector2d shadow_end_m = antenna_m + to_ground_m * along;
  const double shadow_east_m = a_m * shadow_end_m.y() / shadow_end_m.x();
  EXPECT_GT(shadow_east_m - wall_east_m, 1.2 * wall_m * wall_east_m / (200e3 - wall_m));
  EXPECT_EQ(at(shadow_east_m - 0.5), Loss(LookLoss::kShadow));
  EXPECT_EQ(at(shadow_east_m + 0.5), Loss());
  const double range_m = (top_m - antenna_m).norm();
  const double same_rad =
      std::acos((r_m * r_m + a_m * a_m - range_m * range_m) / (2.0 * r_m * a_m));
  EXPECT_EQ(at(a_m * std::tan(same_rad) - 0.5), Loss());
  EXPECT_EQ(at(a_m * std::tan(same_rad) + 0.5), Loss(LookLoss::kLayover));
}

// Second route, from tables of a profile 2 m apart: in shadow is what lies below the largest look
// angle before it, in layover what is not farther than all before and nearer than all behind. Both
// must agree, but for points that are 5 m from an edge.
TEST(TerrainSightTest, AgreesWithTablesOfAngleAndRange) {
  for (const auto kind : {SceneTerrain::Kind::kRolling, SceneTerrain::Kind::kRugged}) {
    SceneTerrain of;
    of.kind = kind;
    of.height_m = 100.0;
    of.relief_m = 500.0;
    of.correlation_m = kind == SceneTerrain::Kind::kRugged ? 2000.0 : 1000.0;
    const Terrain terrain(of, 5);
    const Scene scene;
    const TerrainSight sight(scene, terrain.AsGround());
    RandomStream random(11, 3);
    int in_shadow = 0, in_layover = 0, beside_edges = 0;
    constexpr int kProfiles = 60, kPointsPerProfile = 10;
    for (int profile = 0; profile < kProfiles; ++profile) {
      const double x_m = 40000.0 * random.Uniform();
      std::vector<double> angles, ranges;
      constexpr double kStep_m = 2.0;
      for (double y_m = 0.0; y_m < 24000.0; y_m += kStep_m) {
        const double z_m = terrain.HeightAt({x_m, y_m});
        angles.push_back(std::atan2(y_m, 9000.0 - z_m));
        ranges.push_back(std::hypot(y_m, 9000.0 - z_m));
      }
      for (std::size_t i = 1; i < angles.size(); ++i)
        angles[i] = std::max(angles[i], angles[i - 1]);
      std::vector<double> farthest(ranges), nearest(ranges);
      for (std::size_t i = 1; i < ranges.size(); ++i) {
        farthest[i] = std::max(farthest[i], farthest[i - 1]);
        const std::size_t k = ranges.size() - 1 - i;
        nearest[k] = std::min(nearest[k], nearest[k + 1]);
      }
      const auto by_tables = [&](double y_m) {
        const double z_m = terrain.HeightAt({x_m, y_m});
        const auto before = static_cast<std::size_t>(y_m / kStep_m);
        if (std::atan2(y_m, 9000.0 - z_m) < angles[before]) return Loss(LookLoss::kShadow);
        const double range_m = std::hypot(y_m, 9000.0 - z_m);
        const bool alone = farthest[before] <= range_m && range_m <= nearest[before + 1];
        return alone ? Loss() : Loss(LookLoss::kLayover);
      };
      for (int i = 0; i < kPointsPerProfile; ++i) {
        const double y_m = 4000.0 + 12000.0 * random.Uniform();
        const Motion motion{.position_m = {x_m, 0.0, 9000.0}, .velocity_mps = {100.0, 0.0, 0.0}};
        const Loss loss =
            sight.Hides(motion, LookSide::kLeft, {x_m, y_m, terrain.HeightAt({x_m, y_m})});
        in_shadow += loss == Loss(LookLoss::kShadow) ? 1 : 0;
        in_layover += loss == Loss(LookLoss::kLayover) ? 1 : 0;
        if (loss == by_tables(y_m)) continue;
        ++beside_edges;
        EXPECT_TRUE(loss == by_tables(y_m - 5.0) || loss == by_tables(y_m + 5.0))
            << x_m << ' ' << y_m;
      }
    }
    EXPECT_GT(in_shadow, 20);
    EXPECT_GT(in_layover, 60);
    EXPECT_LT(in_shadow + in_layover, 550);
    EXPECT_LT(beside_edges, 10);
  }
}

Scene RuggedScene() {
  Scene scene = test::SmallScene();
  scene.terrain.kind = SceneTerrain::Kind::kRugged;
  scene.terrain.relief_m = 500.0;
  scene.terrain.correlation_m = 2500.0;
  scene.points.count = 400;
  scene.points.north_m = {5100.0, 27000.0};
  scene.points.min_looks = 1;
  return scene;
}

// Invariant: hiding takes looks away from those there were, and every look it takes is one that
// the antenna's motion at its time says is hidden.
TEST(TerrainVisibilityTest, LeavesOutTheLooksThatTheGroundHides) {
  Scene scene = RuggedScene();
  scene.points.min_looks = 0;
  const SimulatedBlock all = Simulate(scene);
  scene.terrain.hides = true;
  const SimulatedBlock seen = Simulate(scene);
  const Terrain terrain(scene.terrain, scene.seed);
  const TerrainSight sight(scene, terrain.AsGround());
  const Looks &looks = all.block.looks, &left = seen.block.looks;
  std::size_t next = 0, lost = 0;
  for (std::size_t point = 0; point < all.block.points.size(); ++point) {
    for (std::size_t i = looks.offsets[point]; i < looks.offsets[point + 1]; ++i) {
      const Pass& pass = all.block.passes[looks.pass[i]];
      const Motion motion = *pass.path.At(all.exact.nominal_time_s[i]);
      if (sight.Hides(motion, pass.side, all.truth.points_m[point])) {
        ++lost;
        continue;
      }
      ASSERT_LT(next, left.offsets[point + 1]);
      EXPECT_EQ(left.pass[next], looks.pass[i]);
      EXPECT_EQ(seen.exact.nominal_time_s[next++], all.exact.nominal_time_s[i]);
    }
  }
  EXPECT_EQ(next, left.size());
  EXPECT_GT(lost, 50U);
  const LossCounts& counts = seen.coverage.lost;
  EXPECT_EQ(counts[static_cast<std::size_t>(LookLoss::kShadow)] +
                counts[static_cast<std::size_t>(LookLoss::kLayover)],
            lost);
}

// Hand arithmetic on flat ground: strips at y = 300 and 7600 see 5200 to 26000 m beside them and
// from x = -500 to 20500.
TEST(CoverageTest, CountsWhatHappensToEveryPairOfPointAndPass) {
  Scene scene = test::SmallScene();
  scene.points.count = 300;
  scene.points.east_m = {-2000.0, 21000.0};
  scene.points.north_m = {-3000.0, 34000.0};
  scene.points.min_looks = 2;
  const SimulatedBlock simulated = Simulate(scene);
  const SceneCoverage& coverage = simulated.coverage;
  const PointPlan plan(scene);
  LossCounts lost{}, of_left_out{};
  std::vector<std::size_t> by_looks(3, 0);
  for (std::size_t i = 0; i < plan.size(); ++i) {
    const Eigen::Vector2d p_m = plan.At(i).plane_m;
    LossCounts own{};
    std::size_t looks = 0;
    for (const double station_m : {300.0, 7600.0}) {
      const double across_m = p_m.y() - station_m;
      const auto add = [&](LookLoss loss) { ++own[static_cast<std::size_t>(loss)]; };
      if (p_m.x() < -500.0 || p_m.x() > 20500.0) {
        add(LookLoss::kBeyondStrip);
      } else if (across_m <= 0.0) {
        add(LookLoss::kWrongSide);
      } else if (across_m < 5200.0 || across_m > 26000.0) {
        add(LookLoss::kOutsideSwath);
      } else {
        ++looks;
      }
    }
    ++by_looks[looks];
    for (std::size_t k = 0; k < own.size(); ++k) {
      lost[k] += own[k];
      of_left_out[k] += looks < 2 ? own[k] : 0;
    }
  }
  EXPECT_EQ(coverage.points_by_looks, by_looks);
  EXPECT_EQ(coverage.of(PointRole::kTie).placed, 300U);
  EXPECT_EQ(coverage.of(PointRole::kTie).left_out, by_looks[0] + by_looks[1]);
  EXPECT_EQ(coverage.of(PointRole::kTie).unseen, by_looks[0]);
  // What is out of reach of a pass is not asked why: it is beyond its strip or outside its swath.
  const auto at = [](const LossCounts& counts, LookLoss loss) {
    return counts[static_cast<std::size_t>(loss)];
  };
  for (const auto& [got, expected] :
       {std::pair(coverage.lost, lost), std::pair(coverage.lost_of_left_out, of_left_out)}) {
    EXPECT_EQ(std::accumulate(got.begin(), got.end(), std::size_t{0}),
              std::accumulate(expected.begin(), expected.end(), std::size_t{0}));
    EXPECT_EQ(at(got, LookLoss::kWrongSide), at(expected, LookLoss::kWrongSide));
    EXPECT_LE(at(got, LookLoss::kOutsideSwath), at(expected, LookLoss::kOutsideSwath));
    EXPECT_EQ(at(got, LookLoss::kOutsideSwath) + at(got, LookLoss::kBeyondStrip) +
                  at(got, LookLoss::kBeyondReach),
              at(expected, LookLoss::kOutsideSwath) + at(expected, LookLoss::kBeyondStrip));
    EXPECT_EQ(at(got, LookLoss::kShadow) + at(got, LookLoss::kLayover), 0U);
  }
  std::size_t shown = 0;
  for (const PassCoverage& pass : coverage.passes) {
    EXPECT_EQ(std::accumulate(pass.lost.begin(), pass.lost.end(), pass.shown), 300U);
    shown += pass.shown;
  }
  EXPECT_EQ(shown, by_looks[1] + 2 * by_looks[2]);
}

TEST(CoverageTest, NamesControlThatNoPassSees) {  // hand count: two of four corners are far north
  Scene scene = test::SmallScene();
  scene.control.layout = SceneControl::Layout::kPlaces;
  scene.control.places_m = {{900.0, 20000.0}, {900.0, 90000.0}, {2000.0, 91000.0}};
  scene.control.count = 3;
  scene.control.sigma_m = {1.0, 1.0, 1.0};
  const SceneCoverage coverage = Simulate(scene).coverage;
  EXPECT_EQ(coverage.of(PointRole::kControl).placed, 3U);
  EXPECT_EQ(coverage.of(PointRole::kControl).unseen, 2U);
  EXPECT_EQ(coverage.of(PointRole::kControl).left_out, 0U);
}

TEST(TerrainVisibilityTest, SaysWhenTheGroundHidesEverything) {
  Scene scene = RuggedScene();
  scene.terrain.hides = true;
  scene.terrain.relief_m = 900.0;
  scene.terrain.correlation_m = 800.0;
  scene.points.count = 3;
  scene.points.min_looks = 2;
  try {
    (void)Simulate(scene);
    FAIL() << "simulated";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("in shadow"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace sarblock
