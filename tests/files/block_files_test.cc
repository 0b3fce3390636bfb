// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/files/block_file.h"

#include <cmath>
#include <numbers>

#include "support/folder_test.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using BlockFilesTest = test::FolderTest;

// Bits equal, NaN included.
void ExpectSame(const std::vector<double>& a, const std::vector<double>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_TRUE(a[i] == b[i] || (std::isnan(a[i]) && std::isnan(b[i]))) << a[i] << " " << b[i];
  }
}

void ExpectSame(const FlightPath& a, const FlightPath& b) {
  ASSERT_EQ(a.states().size(), b.states().size());
  for (std::size_t i = 0; i < a.states().size(); ++i) {
    EXPECT_EQ(a.states()[i].time_s, b.states()[i].time_s);
    EXPECT_EQ(a.states()[i].position_m, b.states()[i].position_m);
    EXPECT_EQ(a.states()[i].velocity_mps, b.states()[i].velocity_mps);
  }
}

void ExpectSame(const Block& a, const Block& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.frame.kind(), b.frame.kind());
  EXPECT_EQ(a.frame.ellipsoid().a_m, b.frame.ellipsoid().a_m);
  ASSERT_EQ(a.passes.size(), b.passes.size());
  for (std::size_t i = 0; i < a.passes.size(); ++i) {
    const Pass &p = a.passes[i], &q = b.passes[i];
    EXPECT_EQ(p.id, q.id);
    EXPECT_EQ(p.side, q.side);
    EXPECT_EQ(p.sigma.azimuth_unit, q.sigma.azimuth_unit);
    ExpectSame({p.wavelength_m, p.sigma.range_m, p.sigma.azimuth, p.start_s, p.end_s},
               {q.wavelength_m, q.sigma.range_m, q.sigma.azimuth, q.start_s, q.end_s});
    ExpectSame(p.path, q.path);
    EXPECT_EQ(p.squint_rad, q.squint_rad);
    ASSERT_EQ(p.swath.has_value(), q.swath.has_value());
    if (!p.swath) continue;
    EXPECT_EQ(p.swath->kind, q.swath->kind);
    EXPECT_EQ(p.swath->limits, q.swath->limits);
  }
  ASSERT_EQ(a.points.size(), b.points.size());
  EXPECT_EQ(a.points.role, b.points.role);
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    EXPECT_EQ(a.points.ids[i], b.points.ids[i]);
    for (Eigen::Index k = 0; k < 3; ++k) {
      ExpectSame({a.points.given_m[i][k]}, {b.points.given_m[i][k]});
    }
  }
  ASSERT_EQ(a.points.known.size(), b.points.known.size());
  for (std::size_t i = 0; i < a.points.known.size(); ++i) {
    EXPECT_EQ(a.points.known[i].point, b.points.known[i].point);
    EXPECT_EQ(a.points.known[i].fixed, b.points.known[i].fixed);
    EXPECT_EQ(a.points.known[i].covariance_enu_m2, b.points.known[i].covariance_enu_m2);
  }
  EXPECT_EQ(a.looks.offsets, b.looks.offsets);
  EXPECT_EQ(a.looks.pass, b.looks.pass);
  EXPECT_EQ(a.looks.flags, b.looks.flags);
  ExpectSame(a.looks.time_s, b.looks.time_s);
  ExpectSame(a.looks.range_m, b.looks.range_m);
  ExpectSame(a.looks.cone, b.looks.cone);
  ExpectSame(a.looks.range_sigma_m, b.looks.range_sigma_m);
  ExpectSame(a.looks.azimuth_sigma, b.looks.azimuth_sigma);
}

Pass SimplePass(const std::string& id, LookSide side, RandomStream* random) {
  Pass pass;
  pass.id = id;
  pass.side = side;
  pass.wavelength_m = 0.0310665;
  pass.sigma = {1.1, 0.0013, AzimuthUnit::kSeconds};
  std::vector<StateVector> states;
  for (int i = 0; i < 5; ++i) {
    states.push_back({11.3 * i + 0.01 * random->Normal(),
                      Eigen::Vector3d(2300.7 * i, random->Normal(), 8100.0 / 3.0),
                      Eigen::Vector3d(203.0 + random->Normal(), random->Normal(), 1e-3)});
  }
  pass.path = FlightPath(std::move(states));
  pass.start_s = 1.0 / 3.0;
  pass.end_s = 40.0 + random->Uniform();
  return pass;
}

// A block with everything a file can hold.
Block RichBlock() {
  RandomStream random(1979, 11);
  Block block;
  block.name = "rich \"block\"";
  block.frame = Frame::Geocentric({"custom", 1737.41234567, 1.0 / 297.3});
  block.passes = {SimplePass("A,1", LookSide::kLeft, &random),
                  SimplePass("#2", LookSide::kRight, &random),
                  SimplePass("C 3", LookSide::kRight, &random)};
  block.passes[2].sigma = {0.3, 2.0 / 3.0, AzimuthUnit::kMetres};
  block.passes[0].swath = Swath{SwathKind::kLookAngle, {31.7 * kRadPerDeg, 44.3 * kRadPerDeg}};
  block.passes[1].swath = Swath{SwathKind::kGroundRange, {1000.0 / 3.0, 7000.1}};
  block.passes[2].swath = Swath{SwathKind::kSlantRange, {2700.7, 9000.0 / 7.0 + 5000.0}};
  block.passes[1].squint_rad = 3.3 * kRadPerDeg;
  std::vector<std::uint32_t> point_of_look;
  for (std::uint32_t j = 0; j < 211; ++j) {
    block.points.ids.Append("P" + std::to_string(j));
    const auto role = static_cast<PointRole>(j % 7 < 3 ? j % 7 : 0);
    block.points.role.push_back(role);
    const bool given = role != PointRole::kTie || j % 2 == 0;
    block.points.given_m.push_back(
        given ? Eigen::Vector3d(1.7e6 * random.Normal(), 1e6 * random.Normal(), 1e5 / 3.0)
              : Eigen::Vector3d::Constant(kNotGiven));
    if (role != PointRole::kTie) {
      KnownPosition known;
      known.point = j;
      known.fixed = {true, j % 3 != 0, true};
      for (Eigen::Index k = 0; k < 3; ++k) {
        const double sigma_m = 0.1 + random.Uniform();
        if (known.fixed[static_cast<std::size_t>(k)]) {
          known.covariance_enu_m2(k, k) = sigma_m * sigma_m;
        }
      }
      known.covariance_enu_m2(0, 2) = known.covariance_enu_m2(2, 0) = 1e-3 / 7.0;
      block.points.known.push_back(known);
    }
    for (std::uint32_t i = 0; i < 3; ++i) {
      if ((i + j) % 4 == 3) continue;
      const bool doppler = i == 1 && j % 3 == 0, seconds = i == 2 && j % 5 == 0;
      const bool hertz = doppler && j % 2 == 0;  // the Doppler is measured
      block.looks.pass.push_back(i);
      block.looks.flags.push_back(static_cast<std::uint8_t>(
          (j % 13 == 0 ? Looks::kRejected : 0) | (doppler ? Looks::kDoppler : 0) |
          (seconds ? Looks::kAzimuthSeconds : 0) | (hertz ? Looks::kAzimuthHertz : 0)));
      block.looks.time_s.push_back(1.0 + 39.0 * random.Uniform());
      block.looks.range_m.push_back(12000.0 + 100.0 * random.Normal());
      block.looks.cone.push_back(doppler ? 300.0 * random.Normal()
                                         : -1.25 * static_cast<double>(j % 4) * kRadPerDeg);
      block.looks.range_sigma_m.push_back(j % 2 == 0 ? kNotGiven : 0.5 + random.Uniform());
      block.looks.azimuth_sigma.push_back(seconds  ? 1e-3 / 3.0
                                          : hertz  ? 7.0 / 3.0
                                          : i == 0 ? 0.7
                                                   : kNotGiven);
      point_of_look.push_back(j);
    }
  }
  SortLooksByPoint(point_of_look, 211, &block.looks);
  return block;
}

TEST_F(BlockFilesTest, ABlockComesBackToTheLastBit) {  // round trip
  const Block block = RichBlock();
  Truth truth;
  for (std::size_t j = 0; j < block.points.size(); ++j) {
    truth.points_m.push_back(Eigen::Vector3d(1.0, 1.0 / 3.0, -7.7e5) * static_cast<double>(j));
  }
  for (const Pass& pass : block.passes) truth.paths.push_back(pass.path);
  for (const Compression compression : {Compression::kNone, Compression::kGzip}) {
    files::WriteBlock(folder_, block, {}, &truth, compression);
    EXPECT_EQ(FileCount(), 7u);  // with the checksums; nothing is left of the other compression
    const files::BlockFile read = files::ReadBlock(folder_);
    ExpectSame(read.block, block);
    // Random numbers contradict each other, and that is said; what was written is read without a
    // word.
    for (const std::string& warning : read.warnings) {
      EXPECT_EQ(warning.find(".csv"), std::string::npos) << warning;
    }
    const Truth truth_read = files::ReadTruth(folder_, read.block);
    EXPECT_EQ(truth_read.points_m, truth.points_m);
    ASSERT_EQ(truth_read.paths.size(), 3u);
    ExpectSame(truth_read.paths[1], truth.paths[1]);
  }
  files::WriteBlock(folder_, block, {}, nullptr);
  EXPECT_EQ(FileCount(), 5u);  // an older truth does not stay beside a new block
  EXPECT_TRUE(files::ReadTruth(folder_, block).points_m.empty());
}

TEST_F(BlockFilesTest, TheSameBlockGivesTheSameBytes) {
  files::WriteBlock(folder_ / "a", RichBlock(), {}, nullptr, Compression::kGzip);
  files::WriteBlock(folder_ / "b", RichBlock(), {}, nullptr, Compression::kGzip);
  for (const char* name :
       {"block.toml", "points.csv.gz", "observations.csv.gz", "trajectories.csv.gz"}) {
    EXPECT_EQ(Content(folder_ / "a" / name), Content(folder_ / "b" / name)) << name;
    EXPECT_FALSE(Content(folder_ / "a" / name).empty());
  }
}

TEST_F(BlockFilesTest, ADopplerMeasuredByEveryLookOfAPassComesBack) {  // round trip
  Block block = RichBlock();
  block.passes[1].sigma = {0.25, 11.0 / 3.0, AzimuthUnit::kHertz};
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    if (block.looks.pass[i] != 1) continue;
    if ((block.looks.flags[i] & Looks::kDoppler) == 0) block.looks.cone[i] = 17.0 / 3.0;
    block.looks.flags[i] |= Looks::kDoppler;
  }
  files::WriteBlock(folder_, block, {}, nullptr);
  EXPECT_THAT(Content(folder_ / "block.toml"),
              testing::HasSubstr("\ndoppler_sigma_hz = 3.6666666666666665\n"));
  const Block read = files::ReadBlock(folder_).block;
  ExpectSame(read, block);
  for (std::size_t i = 0; i < read.looks.size(); ++i) {
    EXPECT_EQ(read.MeasuresDoppler(i), read.looks.pass[i] == 1);
  }
}

constexpr std::string_view kSmallToml =
    "format = \"sarblock-block 1\"\n[frame]\nkind = \"geocentric\"\nellipsoid = \"WGS84\"\n"
    "[sigma]\nrange_m = 1.5\nazimuth_s = 0.002\n"
    "[[pass]]\nid = \"B\"\nlook = \"left\"\nwavelength_m = 0.24\nrange_sigma_m = 0.5\n"
    "[[pass]]\nid = \"A\"\nlook = \"right\"\nwavelength_m = 0.03\nstart_s = -2.5\nend_s = 44\n";
constexpr std::string_view kSmallPaths =
    "pass,time_s,x_m,y_m,z_m,vx_mps,vy_mps,vz_mps\n"
    "A,0,6378137,0,0,0,7500,0\nB,0,6378137,0,0,0,7500,0\n"
    "B,40,6378137,300000,0,0,7500,0\nA,40,6378137,300000,0,0,7500,0\n";
constexpr std::string_view kSmallLooks =
    "point,pass,range_m,time_s,squint_deg,doppler_hz,range_sigma_m,time_sigma_s,rejected,colour\n"
    "Z,A,800000,12.5,,,,,,red\nK,B,810000,13.25,-1.5,,2.5,,1,\nZ,B,820000,14.125,,0,,0.25,0,\n"
    "Y,A,830000,15.0625,,77.5,,,,\n";

TEST_F(BlockFilesTest, ReadsOptionalColumnsAndUnits) {  // hand values
  constexpr std::string_view points =
      "point,role,lat_deg,lon_deg,h_m,sigma_u_m\nK,control,0,90,12.5,0.25\nN,check,90,0,0,\n";
  const files::BlockFile file =
      files::ReadBlockTexts({kSmallToml, kSmallPaths, kSmallLooks, points});
  const Block& block = file.block;
  EXPECT_EQ(block.name, "block");
  ASSERT_EQ(block.points.size(), 4u);  // points.csv first, then in the order of their looks
  EXPECT_EQ(block.points.ids[0], "K");
  EXPECT_EQ(block.points.ids[1], "N");
  EXPECT_EQ(block.points.ids[2], "Z");
  EXPECT_EQ(block.points.ids[3], "Y");
  EXPECT_THAT(block.looks.offsets, ElementsAre(0u, 1u, 1u, 3u, 4u));
  EXPECT_THAT(block.looks.pass, ElementsAre(0u, 0u, 1u, 1u));  // B is pass 0
  EXPECT_DOUBLE_EQ(block.looks.cone[0], -1.5 * std::numbers::pi / 180.0);
  EXPECT_EQ(block.looks.cone[3], 77.5);
  EXPECT_THAT(block.looks.flags,
              ElementsAre(Looks::kRejected,
                          Looks::kDoppler | Looks::kAzimuthSeconds,
                          0,
                          std::uint8_t{Looks::kDoppler}));
  EXPECT_EQ(block.SigmaOf(0).range_m, 2.5);
  EXPECT_EQ(block.SigmaOf(1).range_m, 0.5);  // of the pass
  EXPECT_EQ(block.SigmaOf(1).azimuth, 0.25);
  EXPECT_EQ(block.SigmaOf(2).range_m, 1.5);  // of [sigma]
  EXPECT_EQ(block.SigmaOf(2).azimuth, 0.002);
  EXPECT_EQ(block.SigmaOf(2).azimuth_unit, AzimuthUnit::kSeconds);
  EXPECT_EQ(block.passes[0].start_s, 13.625);
  EXPECT_EQ(block.passes[0].end_s, 14.625);
  EXPECT_EQ(block.passes[1].start_s, -2.5);
  EXPECT_EQ(block.passes[1].end_s, 44.0);
  // On the equator at 90 degrees east; 1e-9 m is the rounding of coordinates of 6e6 m.
  EXPECT_LE((block.points.given_m[0] - Eigen::Vector3d(0, 6378149.5, 0)).norm(), 2e-9);
  const KnownPosition* control = block.points.FindKnown(0);
  ASSERT_NE(control, nullptr);
  EXPECT_THAT(control->fixed, ElementsAre(false, false, true));
  EXPECT_EQ(control->covariance_enu_m2(2, 2), 0.0625);
  const KnownPosition* check = block.points.FindKnown(1);
  ASSERT_NE(check, nullptr);  // without standard deviations: exactly known
  EXPECT_THAT(check->fixed, ElementsAre(true, true, true));
  EXPECT_EQ(check->covariance_enu_m2, Eigen::Matrix3d(Eigen::Matrix3d::Zero()));
  EXPECT_THAT(file.warnings,
              ElementsAre("observations.csv: columns not known and ignored: 'colour'"));
}

TEST_F(BlockFilesTest, APlanNeedsNoMeasuredValues) {
  files::ReadOptions plan;
  plan.measurements = files::Measurements::kOptional;
  const files::BlockTexts no_columns{
      kSmallToml, kSmallPaths, "pass,point\nA,P\nB,P\n", std::nullopt};
  const Block block = files::ReadBlockTexts(no_columns, plan).block;
  EXPECT_EQ(block.looks.size(), 2u);
  EXPECT_TRUE(std::isnan(block.looks.time_s[0]));
  EXPECT_TRUE(std::isnan(block.looks.range_m[1]));
  EXPECT_EQ(block.passes[0].end_s, 40.0);  // the path's span
  EXPECT_THROW(static_cast<void>(files::ReadBlockTexts(no_columns)), InputError);
}

TEST_F(BlockFilesTest, OverridesReachTheAdjustment) {
  files::ReadOptions options;
  options.set_overrides = {"robust=huber", "correction.position.degree=2"};
  const AdjustOptions adjust =
      files::ReadBlockTexts({kSmallToml, kSmallPaths, kSmallLooks, std::nullopt}, options).adjust;
  EXPECT_EQ(adjust.robust, RobustLoss::kHuber);
  ASSERT_EQ(adjust.groups.size(), 1u);
  EXPECT_EQ(std::get<PositionCorrection>(adjust.groups[0].model).degree, 2);
}

TEST_F(BlockFilesTest, ReadsPairsByName) {
  const Block block =
      files::ReadBlockTexts({kSmallToml, kSmallPaths, kSmallLooks, std::nullopt}).block;
  Put("pairs.csv", "point_b,point_a\nZ,Y\nK,Z\n");
  const auto pairs = files::ReadPairs(folder_, "pairs.csv", block);
  EXPECT_THAT(pairs, ElementsAre(std::pair{2u, 0u}, std::pair{0u, 1u}));
}

TEST_F(BlockFilesTest, NamesTheLineWhereAGzipTableIsCutOff) {
  Put("block.toml", kSmallToml);
  Put("trajectories.csv", kSmallPaths);
  std::string looks = "pass,point,time_s,range_m\n";
  for (int i = 0; i < 20011; ++i) {
    looks +=
        "A,Q" + std::to_string(i * 7919 % 100003) + ",3.5," + std::to_string(9e3 + i % 977) + "\n";
  }
  const std::string bytes = Content(PutGzip("observations.csv.gz", looks));
  Put("observations.csv.gz", bytes.substr(0, bytes.size() * 3 / 4));
  EXPECT_THAT(test::MessageOf<InputError>([&] { return files::ReadBlock(folder_); }),
              testing::ContainsRegex("observations.csv.gz:[0-9]+: the gzip data end too early"));
}

class CancelledSink final : public ProgressSink {
 public:
  void Update(std::string_view, std::size_t, std::size_t, std::string_view) override {}
  bool Cancelled() const override { return true; }
};

TEST_F(BlockFilesTest, ReadingEndsWhenTheUserAsks) {
  std::string looks = "pass,point,time_s,range_m\n";
  for (int i = 0; i < 70001; ++i) looks += "A,P" + std::to_string(i) + ",1.5,2.5\n";
  CancelledSink sink;
  files::ReadOptions options;
  options.progress = &sink;
  EXPECT_THROW(static_cast<void>(
                   files::ReadBlockTexts({kSmallToml, kSmallPaths, looks, std::nullopt}, options)),
               Interrupted);
}

TEST(RealBlocksTest, LoadWithTheirCounts) {  // counts of the data's own description
  const std::filesystem::path data(SARBLOCK_SHARED_DATA);
  if (!std::filesystem::exists(data)) GTEST_SKIP() << "no shared data beside the project";
  for (const char* name : {"cabeus-minirf", "cabeus-minirf-jigsaw"}) {
    const files::BlockFile file = files::ReadBlock(data / name);
    EXPECT_EQ(file.block.name, name);
    EXPECT_EQ(file.block.passes.size(), 3u);
    EXPECT_EQ(file.block.points.size(), 118u);
    EXPECT_EQ(file.block.looks.size(), 287u);
    EXPECT_EQ(file.adjust.corrections, CorrectionChoice::kGiven);
    EXPECT_TRUE(file.warnings.empty());
  }
}

}  // namespace
}  // namespace sarblock
