// SPDX-License-Identifier: Apache-2.0
// Control networks and images of a made-up orbit (tests/truth/moon_images.py), which an independent
// script wrote: what it knows of them is the truth here.
#include "sarblock/core/error.h"

#include <cmath>
#include <filesystem>
#include <string>

#include "core/utc.h"
#include "fuzz/network_fuzz_targets.h"
#include "products/csm.h"
#include "products/import.h"
#include "products/isis.h"
#include "support/folder_test.h"
#include <Eigen/LU>
#include <gmock/gmock.h>

namespace sarblock {
namespace {

using test::MessageOf;
using testing::HasSubstr;

class NetworkTest : public test::FolderTest {
 protected:
  using Path = std::filesystem::path;
  static std::string Own(const std::string& name) {
    return Path(SARBLOCK_FUZZ_CORPUS) / Path(name).replace_filename("") / Path(name).filename();
  }
  static ControlNetwork Moon() { return ReadControlNetwork(Own("network/moon.net")); }
  static std::vector<RadarImage> Cubes() {
    return {ReadIsisCube(Own("cube/one.cub")), ReadIsisCube(Own("cube/two.cub"))};
  }
  static std::vector<RadarImage> Isds() {
    return {ReadCsmIsd(Own("isd/one.json")), ReadCsmIsd(Own("isd/two.json"))};
  }
  static NetworkImportOptions WithSigma() {
    NetworkImportOptions options;
    options.range_sigma_m = 4.0;
    options.azimuth_sigma_m = 6.0;
    return options;
  }
  static std::string Refusal(const ControlNetwork& network,
                             const std::vector<RadarImage>& images,
                             const NetworkImportOptions& options) {
    return MessageOf<InputError>([&] { return ImportNetwork(network, images, options); });
  }
  static bool Warns(const ImportedNetwork& imported, const std::string& text) {
    for (const std::string& warning : imported.warnings) {
      if (warning.find(text) != std::string::npos) return true;
    }
    return false;
  }
};

TEST_F(NetworkTest, TheNetworkHasItsPointsTypesAndFlags) {
  const ControlNetwork network = Moon();
  EXPECT_EQ(network.version, 5);
  EXPECT_EQ(network.target, "MOON");
  EXPECT_THAT(network.serials,
              testing::ElementsAre("LRO/MRFLRO/2012-03-04T05:06:07.890123",
                                   "LRO/MRFLRO/2012-03-04T07:01:02.500000"));
  ASSERT_EQ(network.points.size(), 12U);
  EXPECT_EQ(network.points[1].type, NetworkPointType::kFixed);
  EXPECT_EQ(network.points[2].type, NetworkPointType::kConstrained);
  EXPECT_EQ(network.points[5].type, NetworkPointType::kFree);
  EXPECT_FALSE(network.points[6].position_m.has_value());
  EXPECT_TRUE(network.points[7].measures[1].unused);
  EXPECT_TRUE(network.points[8].unused);
  EXPECT_NEAR(network.points[0].measures[0].line_px, 400.0, 1e-5);
  EXPECT_NEAR(network.points[0].measures[0].sample_px, 150.0, 1e-5);
  ASSERT_TRUE(network.points[3].covariance_m2.has_value());
  EXPECT_EQ((*network.points[3].covariance_m2)(0, 1), 30.0);
  EXPECT_EQ((*network.points[3].covariance_m2)(2, 2), 2500.0);
}

TEST_F(NetworkTest, VersionTwoIsTheSameNetwork) {
  const ControlNetwork five = Moon(), two = ReadControlNetwork(Own("network/moon2.net"));
  EXPECT_EQ(two.version, 2);
  EXPECT_EQ(two.serials, five.serials);
  ASSERT_EQ(two.points.size(), five.points.size());
  for (std::size_t i = 0; i < five.points.size(); ++i) {
    EXPECT_EQ(two.points[i].id, five.points[i].id);
    ASSERT_EQ(two.points[i].measures.size(), five.points[i].measures.size());
    EXPECT_EQ(two.points[i].measures[1].sample_px, five.points[i].measures[1].sample_px);
  }
}

// Time, slant range, path and rotation at once: the script places the points with its own formulas.
TEST_F(NetworkTest, PointsLieWhereTheyWereMeasuredInCubesAndIsds) {
  NetworkImportOptions options = WithSigma();
  for (const bool isis : {true, false}) {
    const ImportedNetwork imported = ImportNetwork(Moon(), isis ? Cubes() : Isds(), [&] {
      if (!isis) options.pixel_origin_px = {1.0, 1.0};
      return options;
    }());
    ASSERT_EQ(imported.images.size(), 2U);
    for (const ImportedImage& image : imported.images) {
      EXPECT_GE(image.offset.looks, 9U);
      // Ephemeris times step by 0.06 us, 6e-6 of a line. The ISD counts ground range from the edge
      // of the first pixel in lines alone.
      EXPECT_NEAR(image.offset.line_px, 0.0, 2e-5) << image.pass;
      EXPECT_NEAR(image.offset.sample_px, 0.0, 1e-5) << image.pass;
    }
    EXPECT_TRUE(imported.warnings.empty()) << imported.warnings.front();
  }
}

TEST_F(NetworkTest, RolesCovariancesAndRejectionsBecomeTheBlocks) {
  const ImportedNetwork imported = ImportNetwork(Moon(), Cubes(), WithSigma());
  const Block& block = imported.block;
  EXPECT_EQ(block.frame.ellipsoid().name, "Moon");
  EXPECT_EQ(block.points.size(), 12U);
  EXPECT_EQ(block.looks.size(), 24U);
  EXPECT_EQ(imported.fixed_points, 2U);
  EXPECT_EQ(block.passes[0].id, "one");
  EXPECT_EQ(block.passes[0].epoch_utc, "2012-03-04T05:06:07Z");
  EXPECT_EQ(block.passes[0].side, LookSide::kRight);
  EXPECT_NEAR(block.passes[0].wavelength_m, 299792458.0 / 2.38e9, 1e-12);
  std::size_t rejected = 0;
  for (std::size_t i = 0; i < block.looks.size(); ++i)
    rejected += block.looks.rejected(i) ? 1U : 0U;
  EXPECT_EQ(rejected, 3U);
  ASSERT_EQ(block.points.known.size(), 5U);
  EXPECT_NEAR(block.points.known[0].covariance_enu_m2(2, 2), 1e-6, 1e-18);
  // Trace and determinant do not change with axes.
  const Eigen::Matrix3d& enu_m2 = block.points.known[2].covariance_enu_m2;
  EXPECT_NEAR(enu_m2.trace(), 3800.0, 1e-9);
  EXPECT_NEAR(enu_m2.determinant(), (400.0 * 900.0 - 30.0 * 30.0) * 2500.0, 1e-2);
  EXPECT_EQ(block.points.role[8], PointRole::kTie);
  EXPECT_TRUE(std::isnan(block.points.given_m[6].x()));
}

TEST_F(NetworkTest, AConstrainedRadiusHoldsTheHeightAlone) {
  ControlNetwork network = Moon();
  network.points[2].constrained = {false, false, true};
  const KnownPosition known = ImportNetwork(network, Cubes(), WithSigma()).block.points.known[2];
  ASSERT_EQ(known.point, 2U);
  EXPECT_EQ(known.fixed, (std::array<bool, 3>{false, false, true}));
  EXPECT_EQ(known.covariance_enu_m2(0, 0), 0.0);
  const Eigen::Vector3d up = network.points[2].position_m->normalized();  // of a sphere
  EXPECT_NEAR(known.covariance_enu_m2(2, 2), up.dot(*network.points[2].covariance_m2 * up), 1e-9);
}

TEST_F(NetworkTest, SigmasOfMeasuresBecomeMetresAndSeconds) {
  ControlNetwork network = Moon();
  network.points[0].measures[0].line_sigma_px = 0.5;
  network.points[0].measures[0].sample_sigma_px = 0.25;
  const Block block = ImportNetwork(network, Cubes(), WithSigma()).block;
  EXPECT_EQ(block.SigmaOf(0).azimuth_unit, AzimuthUnit::kSeconds);
  EXPECT_NEAR(block.SigmaOf(0).azimuth, 0.5 * 0.0100012, 1e-12);
  // A sample is 15 m of ground range, 0.72 of it in slant range here.
  EXPECT_NEAR(block.SigmaOf(0).range_m, 0.25 * 15.0 * (0.70 + 2 * 4.1e-6 * 149 * 15.0), 5e-3);
  EXPECT_EQ(block.SigmaOf(1).range_m, 4.0);
  EXPECT_THAT(Refusal(network, Cubes(), {}), HasSubstr("--range-sigma-m gives one"));
}

TEST_F(NetworkTest, FreePointsAreConstrainedInHeightWhereAskedFor) {
  NetworkImportOptions options = WithSigma();
  options.height_sigma_m = 0.1;
  const Block block = ImportNetwork(Moon(), Cubes(), options).block;
  const KnownPosition* const known = block.points.FindKnown(5);
  ASSERT_NE(known, nullptr);
  EXPECT_EQ(known->fixed, (std::array<bool, 3>{false, false, true}));
  EXPECT_EQ(known->covariance_enu_m2(2, 2), 0.1 * 0.1);
  EXPECT_EQ(block.points.FindKnown(6), nullptr);  // has no position
  EXPECT_EQ(block.points.FindKnown(8), nullptr);  // is ignored
}

TEST_F(NetworkTest, ASerialNumberWithoutImageIsNamedWithItsRemedies) {
  const ControlNetwork network = Moon();
  EXPECT_THAT(Refusal(network, {Cubes()[0]}, WithSigma()),
              testing::AllOf(HasSubstr("'LRO/MRFLRO/2012-03-04T07:01:02.500000'"),
                             HasSubstr("--serial SERIAL=FILE"),
                             HasSubstr("--leave-out-missing")));
  NetworkImportOptions options = WithSigma();
  options.missing = MissingImages::kLeaveOut;
  const ImportedNetwork imported = ImportNetwork(network, {Cubes()[0]}, options);
  EXPECT_EQ(imported.block.looks.size(), 12U);
  EXPECT_TRUE(Warns(imported, "their measures are left out"));
}

TEST_F(NetworkTest, AnImageWithoutMeasuresIsLeftOutWithAWarning) {
  std::vector<RadarImage> images = Cubes();
  images.push_back(images.back());
  images.back().serial = "LRO/MRFLRO/2013-01-01T00:00:00";
  images.back().file = "three.cub";
  const ImportedNetwork imported = ImportNetwork(Moon(), images, WithSigma());
  EXPECT_EQ(imported.block.passes.size(), 2U);
  EXPECT_TRUE(Warns(imported, "three.cub: no measure of the network is in this image"));
}

TEST_F(NetworkTest, GivenSerialNumbersGoBeforeThoseOfTheFiles) {
  NetworkImportOptions options = WithSigma();
  options.serials = {{"LRO/MRFLRO/2012-03-04T05:06:07.890123", 1},
                     {"LRO/MRFLRO/2012-03-04T07:01:02.500000", 0}};
  // Cubes know better and are refused; ISDs follow the option.
  const ImportedNetwork imported = ImportNetwork(Moon(), Isds(), options);
  EXPECT_EQ(imported.images[0].pass, "one");
  EXPECT_EQ(imported.images[0].serial, "LRO/MRFLRO/2012-03-04T07:01:02.500000");
  options.serials = {{"nobody", 0}};
  EXPECT_THAT(Refusal(Moon(), Isds(), options), HasSubstr("'nobody' of --serial"));
}

TEST_F(NetworkTest, FileNamesAreSerialNumbersToo) {
  ControlNetwork network = Moon();
  network.serials = {"run/one.cub", "two"};
  const ImportedNetwork imported = ImportNetwork(network, Isds(), WithSigma());
  EXPECT_EQ(imported.images[1].serial, "two");
}

TEST_F(NetworkTest, AnImageOfAnotherBodyIsRefused) {
  std::vector<RadarImage> images = Isds();
  images[1] = ReadCsmIsd(Own("isd/mars.json"));
  const std::string message = Refusal(Moon(), images, WithSigma());
  EXPECT_THAT(message, HasSubstr("mars.json"));
  EXPECT_THAT(message, HasSubstr("is an image of another body: radius 3396.19 km"));
  ControlNetwork network = Moon();
  network.target = "Nobody";  // a body of unknown size: it follows from the points
  for (RadarImage& image : images) image.ellipsoid = {"", 3396190.0, 0.0};
  EXPECT_THAT(Refusal(network, images, WithSigma()), HasSubstr("from the centre"));
}

TEST_F(NetworkTest, HalfAPixelIsNamedWithTheOriginThatTakesItUp) {
  NetworkImportOptions options = WithSigma();
  options.pixel_origin_px = {0.5, 0.5};
  EXPECT_TRUE(Warns(ImportNetwork(Moon(), Isds(), options),
                    "half a pixel in line and sample after where the given positions"));
  EXPECT_TRUE(Warns(ImportNetwork(Moon(), Isds(), options), "--pixel-origin 1,1 takes it up"));
}

TEST_F(NetworkTest, OneLineBetweenNetworkAndIsdIsNamedTwice) {
  std::vector<RadarImage> images = Isds();
  images[0] = ReadCsmIsd(Own("isd/one_line_earlier.json"));
  NetworkImportOptions options = WithSigma();
  options.pixel_origin_px = {1.0, 1.0};
  options.pass_ids = {"one", "two"};
  const ImportedNetwork imported = ImportNetwork(Moon(), images, options);
  EXPECT_TRUE(Warns(imported, "starts one line (10.001 ms) earlier than serial number"));
  EXPECT_TRUE(Warns(imported, "--pixel-origin 0,1 shifts the network by this line"));
  // Measured where the path is a line behind: the points lie one line after.
  EXPECT_TRUE(Warns(imported, "one: measures lie one line before"));
}

// Hand arithmetic: N = 2 polynomials, 10 s apart, stand 5 s apart for USGSCSM.
TEST_F(NetworkTest, UsgscsmDividesTheSpanOfPolynomialsByTheirNumber) {
  std::vector<RadarImage> images{fuzz::PlainImage("a")};
  images[0].ground_range = {{0.0, 0.0, {50000.0, 0.5}}, {10.0, 0.0, {50010.0, 0.5}}};
  ControlNetwork network;
  network.serials = {"a"};
  network.points.resize(1);
  network.points[0].id = "P";
  network.points[0].measures = {{.line_px = 251.0, .sample_px = 1.0}};
  NetworkImportOptions options = WithSigma();
  const Block given = ImportNetwork(network, images, options).block;
  EXPECT_NEAR(given.looks.range_m[0], 50002.5, 1e-9);
  options.range_polynomial = RangePolynomialTimes::kUsgscsm;
  const Block usgscsm = ImportNetwork(network, images, options).block;
  EXPECT_NEAR(usgscsm.looks.range_m[0], 50005.0, 1e-9);
}

// Hand arithmetic: twelve constants k^5 stand 1 s apart for USGSCSM. Eight of them give 5.5^5, four
// at 1.5 (9 + 9 32 - 243) / 16, two at 0.5 the mean of 0 and 1.
TEST_F(NetworkTest, UsgscsmInterpolatesWithFewerPolynomialsTowardsTheEnds) {
  std::vector<RadarImage> images{fuzz::PlainImage("a")};
  images[0].ground_range.clear();
  for (int k = 0; k < 12; ++k) {
    images[0].ground_range.push_back({k * 12.0 / 11.0, 0.0, {50000.0 + std::pow(k, 5), 0.5}});
  }
  ControlNetwork network;
  network.serials = {"a"};
  NetworkImportOptions options = WithSigma();
  options.range_polynomial = RangePolynomialTimes::kUsgscsm;
  for (const auto& [line_px, constant_m] : {std::pair{551.0, std::pow(5.5, 5)},
                                            std::pair{151.0, (9.0 + 9.0 * 32.0 - 243.0) / 16.0},
                                            std::pair{51.0, 0.5}}) {
    network.points.assign(1, {});
    network.points[0].id = "P";
    network.points[0].measures = {{.line_px = line_px, .sample_px = 1.0}};
    const Block block = ImportNetwork(network, images, options).block;
    EXPECT_NEAR(block.looks.range_m[0], 50000.0 + constant_m, 1e-6) << line_px;
  }
}

// Closed form: an even turn is the same from one attitude with its rate and from two.
TEST_F(NetworkTest, OneAttitudeTurnsOnWithItsRate) {
  const RadarImage two = ReadCsmIsd(Own("isd/one.json"));
  const RadarImage one = ReadCsmIsd(Own("isd/one_attitude.json"));
  ASSERT_EQ(one.states.size(), two.states.size());
  for (std::size_t i = 0; i < two.states.size(); ++i) {
    EXPECT_LT((one.states[i].position_m - two.states[i].position_m).norm(), 1e-4);
    EXPECT_LT((one.states[i].velocity_mps - two.states[i].velocity_mps).norm(), 1e-7);
  }
}

TEST_F(NetworkTest, TheWeightsOfJigsawComeFromTheLabel) {
  const RadarImage image = Cubes()[0];
  ASSERT_TRUE(image.jigsaw.has_value());
  const double incidence_rad = 50.5 * std::acos(-1.0) / 180.0;
  EXPECT_NEAR(image.jigsaw->range_m, 1.4 * 15.0 * 100.0 * 31.5 * std::sin(incidence_rad), 1e-6);
  // The speed of a circular orbit, less the Moon's 5 m/s across it.
  const double speed_mps = std::sqrt(4.9028e12 / 1787400.0);
  EXPECT_NEAR(image.jigsaw->doppler_hz,
              1.4 * 15.0 * 100.0 * 2.0 * speed_mps / image.wavelength_m * 30.5 *
                  std::cos(incidence_rad) / 50000.0,
              1e-4 * image.jigsaw->doppler_hz);
  NetworkImportOptions options;
  options.jigsaw_sigma = true;
  const Block block = ImportNetwork(Moon(), Cubes(), options).block;
  EXPECT_EQ(block.SigmaOf(0).range_m, image.jigsaw->range_m);
  EXPECT_NEAR(
      block.SigmaOf(0).azimuth,
      image.jigsaw->doppler_hz * image.wavelength_m * block.looks.range_m[0] / (2.0 * speed_mps),
      1e-4 * block.SigmaOf(0).azimuth);
  EXPECT_THAT(Refusal(Moon(), Isds(), options), HasSubstr("the weights of jigsaw need a cube"));
}

TEST_F(NetworkTest, ACropCountsFromTheImageThatItIsOf) {
  const RadarImage whole = ReadIsisCube(Own("cube/one.cub"));
  const RadarImage crop = ReadIsisCube(Own("cube/crop.cub"));
  // 3000 lines from line 201 on in 1500: the first centre is at 201.5, one line is two.
  EXPECT_NEAR(crop.first_line_s - whole.first_line_s, 200.5 * 0.0100012, 2e-7);
  EXPECT_NEAR(crop.line_interval_s, 2 * 0.0100012, 1e-15);
  EXPECT_NEAR(crop.first_sample_m, 100.5 * 15.0, 1e-9);
  EXPECT_NEAR(crop.sample_spacing_m, 30.0, 1e-12);
}

TEST_F(NetworkTest, CubesThatCannotBeUsedSayWhatToDo) {
  const auto refusal = [](const char* name) {
    return MessageOf<InputError>([&] { return ReadIsisCube(Own(std::string("cube/") + name)); });
  };
  EXPECT_THAT(refusal("no_table.cub"), HasSubstr("BodyRotation is missing: run spiceinit"));
  EXPECT_THAT(refusal("fitted.cub"), HasSubstr("a path that jigsaw has fitted"));
  EXPECT_THAT(refusal("map.cub"), HasSubstr("is a map"));
  EXPECT_THAT(refusal("records_lie.cub"), HasSubstr("do not hold 900000000000 records"));
  EXPECT_THAT(refusal("start_lies.cub"), HasSubstr("are not in the file"));
  EXPECT_THAT(refusal("truncated.cub"), HasSubstr("cut short"));
  EXPECT_THAT(refusal("triaxial.cub"), HasSubstr("ellipsoid of revolution"));
  EXPECT_THAT(refusal("coefficient_times.cub"), HasSubstr("times must increase"));
  EXPECT_THAT(refusal("look.cub"), HasSubstr(".cub:18: IsisCube.Instrument.LookDirection"));
}

TEST_F(NetworkTest, NetworksThatCannotBeUsedSayWhereAndWhy) {
  const auto refusal = [](const char* name) {
    return MessageOf<InputError>(
        [&] { return ReadControlNetwork(Own(std::string("network/") + name)); });
  };
  EXPECT_THAT(refusal("point_size_lies.net"), HasSubstr("a point of 2147483647 bytes"));
  EXPECT_THAT(refusal("points_bytes_lie.net"), HasSubstr("PointsBytes"));
  EXPECT_THAT(refusal("version_3.net"), HasSubstr("3 is not read, 2 and 5 are"));
  EXPECT_THAT(refusal("text.net"), HasSubstr("is a network as text"));
  EXPECT_THAT(MessageOf<InputError>([] { return ReadControlNetwork(Own("cube/one.cub")); }),
              HasSubstr("a binary control network of ISIS (.net) is needed"));
  EXPECT_THAT(refusal("truncated.net"), HasSubstr("are not in the file"));
  EXPECT_THAT(refusal("covariance_of_five.net"), HasSubstr("has 5 numbers, 6 are needed"));
}

TEST_F(NetworkTest, IsdsThatCannotBeUsedNameTheKey) {
  const auto refusal = [](const char* name) {
    return MessageOf<InputError>([&] { return ReadCsmIsd(Own(std::string("isd/") + name)); });
  };
  EXPECT_THAT(refusal("frame_model.json"), HasSubstr("name_model"));
  EXPECT_THAT(refusal("old_form.json"), HasSubstr("isd_generate"));
  EXPECT_THAT(refusal("vector_of_two.json"), HasSubstr("instrument_position.positions[3]"));
  EXPECT_THAT(refusal("frame_10.json"), HasSubstr("must be 1 (J2000)"));
}

// A label that never ends costs 8 MiB, not the file: the rest of it is never read.
TEST_F(NetworkTest, ALabelOfAGigabyteIsRefusedAfterEightMegabytes) {
  const std::filesystem::path file = Put("long.net", "Object = ProtoBuffer\n");
  std::filesystem::resize_file(file, 1U << 30U);
  EXPECT_THAT(MessageOf<InputError>([&] { return ReadControlNetwork(file); }),
              HasSubstr("is longer than 8 MiB"));
  EXPECT_THAT(MessageOf<InputError>([&] { return ReadIsisCube(file); }),
              HasSubstr("is longer than 8 MiB"));
  std::filesystem::remove(file);
}

// What CSPICE's str2et prints for this time with naif0012.tls: the cube LSZ_00455 of ISIS holds it.
TEST_F(NetworkTest, EphemerisTimeIsThatOfSpice) {
  const auto start = ParseUtc("2009-08-01T08:43:31.545532");
  ASSERT_TRUE(start.has_value());
  EXPECT_NEAR(EphemerisTime_s(*start), 302388277.71971 + 0.00907750328, 1e-5);
  EXPECT_NEAR(SecondsBetween(*start, UtcOfEphemerisTime(EphemerisTime_s(*start))), 0.0, 1e-7);
}

TEST_F(NetworkTest, TheFuzzersCorpusIsReadOrRefused) {
  const auto replay = [](const char* folder, void (*target)(std::string_view)) {
    std::size_t files = 0;
    for (const auto& entry :
         std::filesystem::directory_iterator(Path(SARBLOCK_FUZZ_CORPUS) / folder)) {
      const std::string bytes = Content(entry.path());
      EXPECT_NO_THROW(target(bytes)) << entry.path();
      ++files;
    }
    EXPECT_GE(files, 20U) << folder;
  };
  replay("network", fuzz::Network);
  replay("cube", fuzz::Cube);
  replay("isd", fuzz::Isd);
}

}  // namespace
}  // namespace sarblock
