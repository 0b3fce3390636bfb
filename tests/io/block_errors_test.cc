// SPDX-License-Identifier: Apache-2.0
// Every fault of a block's files is refused with its place, its field and what is allowed.
#include "sarblock/core/error.h"
#include "sarblock/files/block_file.h"

#include <optional>
#include <string>

#include "io/io_fixture.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::HasSubstr;

const std::string kGoodToml =
    "format = \"sarblock-block 1\"\n"  // 1
    "name = \"small\"\n"               // 2
    "[frame]\n"                        // 3
    "kind = \"local\"\n"               // 4
    "[sigma]\n"                        // 5
    "range_m = 1.25\n"                 // 6
    "azimuth_m = 0.75\n"               // 7
    "[[pass]]\n"                       // 8
    "id = \"A1\"\n"                    // 9
    "look = \"left\"\n"                // 10
    "[[pass]]\n"                       // 11
    "id = \"A2\"\n"                    // 12
    "look = \"right\"\n";              // 13
const std::string kGoodPaths =
    "pass,time_s,x_m,y_m,z_m,vx_mps,vy_mps,vz_mps\n"
    "A1,0,0,0,8000.5,210.5,0,0\n"
    "A1,30.25,6367.6,0,8000.5,210.5,0,0\n"
    "A2,0,0,4000,8000.5,210.5,0,0\n"
    "A2,30.25,6367.6,4000,8000.5,210.5,0,0\n";
const std::string kGoodLooks =
    "pass,point,time_s,range_m\n"
    "A1,P1,3.5,9001.25\n"
    "A2,P1,3.75,9011.5\n";
const std::string kGoodPoints = "point,role,x_m,y_m,z_m,sigma_e_m,sigma_n_m,sigma_u_m\n";

struct Change {
  std::string from, to;
};

std::string Changed(std::string text, const Change& change) {
  const std::size_t at = text.find(change.from);
  EXPECT_NE(at, std::string::npos) << change.from;
  return at == std::string::npos ? text : text.replace(at, change.from.size(), change.to);
}

std::string BlockError(const std::string& toml,
                       const std::string& paths,
                       const std::string& looks,
                       const std::optional<std::string>& points = std::nullopt) {
  const std::string message = test::MessageOf<InputError>([&] {
    files::BlockTexts texts{toml, paths, looks, std::nullopt};
    if (points) texts.points_csv = *points;
    return files::ReadBlockTexts(texts);
  });
  return message;
}

TEST(BlockErrorsTest, AcceptsTheBlockThatTheOthersSpoil) {
  EXPECT_EQ(BlockError(kGoodToml, kGoodPaths, kGoodLooks, kGoodPoints + "P1,control,1,2,3,0.5,,\n"),
            "");
}

struct TomlCase {
  Change change;
  const char* message;
};

TEST(BlockErrorsTest, NamesPlaceAndProblemInBlockToml) {
  const TomlCase cases[] = {
      {{"sarblock-block 1", "sarblock-block 9"},
       "block.toml:1: format: 'sarblock-block 9' is not known, \"sarblock-block 1\" is allowed"},
      {{"format = \"sarblock-block 1\"", ""},
       "block.toml:1: format: is missing, format = \"sarblock-block 1\" is needed"},
      {{"name = \"small\"", "name = 7"},
       "block.toml:2: name: is an integer, a text in quotes is "
       "needed"},
      {{"name = \"small\"", "name = \"small"},
       "block.toml:2: is not valid TOML: Error while parsing string: "},
      {{"[frame]", "[= 1.5"}, "block.toml:3: is not valid TOML: a table header needs a name"},
      {{"name = \"small\"", "nam = \"small\""},
       "block.toml:2: nam: the key is not known, format, name, frame, sigma, trajectory, "
       "reduction, adjust or "
       "pass is "
       "allowed; did you mean name?"},
      {{"\"local\"", "\"geocentrik\""},
       "block.toml:4: frame.kind: 'geocentrik' is not known, local or geocentric is allowed; did "
       "you mean geocentric?"},
      {{"kind = \"local\"", "kind = \"local\"\nellipsoid = \"Moon\""},
       "block.toml:5: frame.ellipsoid: belongs to kind = \"geocentric\", a local frame has none"},
      {{"kind = \"local\"", "kind = \"geocentric\"\nellipsoid = \"Moan\""},
       "block.toml:5: frame.ellipsoid: 'Moan' is not known, WGS84, GRS80, Moon, Venus or Mars or { "
       "a_m = ..., f = ... } is allowed; did you mean Moon?"},
      {{"kind = \"local\"", "kind = \"geocentric\"\nellipsoid = { a_m = 1e6, f = 1.5 }"},
       "block.toml:5: frame.ellipsoid.f: must be 0 <= f < 1, got 1.5"},
      {{"range_m = 1.25", "range_m = 0"},
       "block.toml:6: sigma.range_m: must be a number above 0, got 0"},
      {{"range_m = 1.25", "range_m = nan"},
       "block.toml:6: sigma.range_m: is not finite, a finite number is needed"},
      {{"range_m = 1.25", "range_m = \"1\""},
       "block.toml:6: sigma.range_m: is a text, a number is needed"},
      {{"azimuth_m = 0.75", "azimuth_m = 0.75\nazimuth_s = 1e-3"},
       "block.toml:8: sigma.azimuth_s: excludes azimuth_m; give one of both"},
      {{"\"A2\"", "\"A1\""},
       "block.toml:12: pass[1].id: pass 'A1' is given twice, first on line 9"},
      {{"\"A2\"", "\"\""}, "block.toml:12: pass[1].id: is empty, a name is needed"},
      {{"\"right\"", "\"up\""},
       "block.toml:13: pass[1].look: 'up' is not known, left or right is allowed"},
      {{"look = \"right\"", "look = \"right\"\nstart_s = 5.5\nend_s = 5.5"},
       "block.toml:15: pass[1].end_s: must be after start_s = 5.5, got 5.5"},
      {{"look = \"right\"", "look = \"right\"\nstart_s = 5.5"},
       "pass[1].end_s: is missing, with start_s the end of the strip is needed"},
      {{"look = \"right\"", "look = \"right\"\nazimuth_sigma_m = 1\ndoppler_sigma_hz = 2"},
       "block.toml:15: pass[1].doppler_sigma_hz: excludes azimuth_sigma_m; give one of both"},
      {{"azimuth_m = 0.75", "azimuth_m = 0.75\ndoppler_hz = 2"},
       "block.toml:8: sigma.doppler_hz: excludes azimuth_m; give one of both"},
      {{"look = \"right\"", "look = \"right\"\ndoppler_sigma_hz = 2"},
       "observations.csv:3: doppler_hz: is empty, but the standard deviation of azimuth of pass "
       "'A2' "
       "is one of Doppler: give the measured Doppler"},
      {{"look = \"right\"", "look = \"right\"\nwavelength = 0.03"},
       "block.toml:14: pass[1].wavelength: the key is not known"},
      {{"look = \"right\"", "look = \"right\"\nswath_look_deg = [30, 95]"},
       "block.toml:14: pass[1].swath_look_deg: must be near and far, 0 <= near < far < 90, got 30 "
       "and 95"},
      {{"look = \"right\"", "look = \"right\"\nswath_range_m = [9000, 4000]"},
       "block.toml:14: pass[1].swath_range_m: must be near and far, 0 <= near < far, got 9000 and "
       "4000"},
      {{"look = \"right\"", "look = \"right\"\nswath_ground_m = [9000]"},
       "block.toml:14: pass[1].swath_ground_m: is a list of 1, a list of 2 numbers is needed"},
      {{"look = \"right\"", "look = \"right\"\nswath_ground_m = 9000"},
       "block.toml:14: pass[1].swath_ground_m: "},
      {{"look = \"right\"", "look = \"right\"\nswath_range_m = [1, 2]\nswath_ground_m = [1, 2]"},
       "block.toml:14: pass[1].swath_range_m: excludes swath_ground_m; give one of both"},
      {{"look = \"right\"", "look = \"right\"\nsquint_deg = -90"},
       "block.toml:14: pass[1].squint_deg: must be between -90 and 90, got -90"},
      {{"[[pass]]", "[adjust]\nrobust = \"hubber\"\n[[pass]]"},
       "block.toml:9: adjust.robust: 'hubber' is not known, none, huber, cauchy or tukey is "
       "allowed; did you mean huber?"},
      {{"\"A2\"", "\"A3\""},
       "trajectories.csv:4: pass: block.toml has no pass 'A2'; did you mean "},
  };
  for (const TomlCase& bad : cases) {
    EXPECT_THAT(BlockError(Changed(kGoodToml, bad.change), kGoodPaths, kGoodLooks),
                HasSubstr(bad.message));
  }
}

TEST(BlockErrorsTest, NamesThePassWithoutTrajectory) {
  const std::string one_pass = kGoodPaths.substr(0, kGoodPaths.find("A2"));
  EXPECT_EQ(
      BlockError(kGoodToml, one_pass, kGoodLooks),
      "block.toml:12: pass[1].id: pass 'A2' has no states in trajectories.csv, two or more are "
      "needed");
  EXPECT_EQ(BlockError(kGoodToml, one_pass + "A2,0,0,4000,8000.5,210.5,0,0\n", kGoodLooks),
            "trajectories.csv:4: pass: pass 'A2' has one state, two or more are needed");
}

TEST(BlockErrorsTest, NamesPlaceAndProblemInTrajectories) {
  const TomlCase cases[] = {
      {{",z_m,", ",Z,"}, "trajectories.csv:1: z_m: the column is missing"},
      {{"A1,30.25", "A1,0"},
       "trajectories.csv:3: time_s: pass 'A1' has two states at 0 s, one is allowed; the state "
       "before, on line 2, is at 0 s"},
      {{"A1,30.25", "A1,0.000000001"},
       "trajectories.csv:3: time_s: the states of pass 'A1' at 1e-09 s and, on line 2, at 0 s are "
       "1e-09 s apart: their difference is rounding and noise, no motion; remove one of them, or "
       "one "
       "of two merged orbits"},
      {{"A1,30.25", "A1,-1"},
       "trajectories.csv:3: time_s: times of pass 'A1' must increase, -1 s does not; the state "
       "before, on line 2, is at 0 s"},
      {{"210.5,0,0\nA2,0", "0,0,0\nA2,0"},
       "trajectories.csv:3: vx_mps: the velocity is zero, the antenna must move"},
      {{"6367.6", "inf"}, "trajectories.csv:3: x_m: must be a finite number, got 'inf'"},
      {{"6367.6", ""}, "trajectories.csv:3: x_m: is empty, a number is needed"},
      {{"6367.6", "6367,6"}, "trajectories.csv:3: the row has 9 cells, the header has 8 columns"},
      {{"A2,30.25", "B2,30.25"},
       "trajectories.csv:5: pass: block.toml has no pass 'B2'; did you mean A2?"},
  };
  for (const TomlCase& bad : cases) {
    EXPECT_THAT(BlockError(kGoodToml, Changed(kGoodPaths, bad.change), kGoodLooks),
                HasSubstr(bad.message));
  }
}

struct RowCase {
  const char* header;
  const char* rows;
  const char* message;
};

TEST(BlockErrorsTest, NamesPlaceAndProblemInObservations) {
  const std::string toml = Changed(kGoodToml, {"\"right\"\n", "\"right\"\nwavelength_m = 0.03\n"});
  const RowCase cases[] = {
      {"pass,time_s,range_m", "", "observations.csv:1: point: the column is missing"},
      {"pass,point,time_s", "", "observations.csv:1: range_m: the column is missing"},
      {"pass,point,time_s,range_m",
       "A1,P1,3.5,far\n",
       "observations.csv:2: range_m: must be a decimal number with a point, got 'far'"},
      {"pass,point,time_s,range_m",
       "A1,P1,,9000\n",
       "observations.csv:2: time_s: is empty, a number is needed"},
      {"pass,point,time_s,range_m",
       "A1,P1,3.5,\n",
       "observations.csv:2: range_m: is empty, a number is needed"},
      {"pass,point,time_s,range_m",
       "A1,P1,3.5,0\n",
       "observations.csv:2: range_m: must be a number above 0, got 0"},
      {"pass,point,time_s,range_m",
       "A1,,3.5,9000\n",
       "observations.csv:2: point: is empty, a name is needed"},
      {"pass,point,time_s,range_m",
       "A1,P1,3.5,9000\nAl,P1,3.5,9000\n",
       "observations.csv:3: pass: block.toml has no pass 'Al'; did you mean A1?"},
      {"pass,point,time_s,range_m",
       "A1,P1,30.26,9000\n",
       "observations.csv:2: time_s: 30.26 is outside the flight path of pass 'A1', which goes from "
       "0 to 30.25 s"},
      {"pass,point,time_s,range_m",
       "A1,P9,3.5,9000\n# note\nA1,P1,3.5,9000\nA2,P1,3.5,9000\n\nA1,P1,4.5,9001\n",
       "observations.csv:7: point: pass 'A1' sees point 'P1' twice, first on line 4; one look per "
       "pass and point is allowed"},
      {"pass,point,time_s,range_m,squint_deg",
       "A1,P1,3.5,9000,-90\n",
       "observations.csv:2: squint_deg: must be between -90 and 90, got -90"},
      {"pass,point,time_s,range_m,doppler_hz",
       "A1,P1,3.5,9000,120.5\n",
       "observations.csv:2: doppler_hz: pass 'A1' has no wavelength_m in block.toml"},
      {"pass,point,time_s,range_m,doppler_hz",
       "A2,P1,3.5,9000,-15000.5\n",
       "observations.csv:2: doppler_hz: must be less than 2 |v| / wavelength = "},
      {"pass,point,time_s,range_m,squint_deg,doppler_hz",
       "A2,P1,3.5,9000,1.5,120.5\n",
       "observations.csv:2: doppler_hz: excludes squint_deg; give one of both"},
      {"pass,point,time_s,range_m,range_sigma_m",
       "A1,P1,3.5,9000,-2\n",
       "observations.csv:2: range_sigma_m: must be a number above 0, got -2"},
      {"pass,point,time_s,range_m,azimuth_sigma_m,time_sigma_s",
       "A1,P1,3.5,9000,2,0.001\n",
       "observations.csv:2: time_sigma_s: excludes azimuth_sigma_m; give one of both"},
      {"pass,point,time_s,range_m,doppler_hz,time_sigma_s,doppler_sigma_hz",
       "A2,P1,3.5,9000,120.5,0.001,2\n",
       "observations.csv:2: doppler_sigma_hz: excludes time_sigma_s; give one of both"},
      {"pass,point,time_s,range_m,doppler_hz,doppler_sigma_hz",
       "A2,P1,3.5,9000,120.5,0\n",
       "observations.csv:2: doppler_sigma_hz: must be a number above 0, got 0"},
      {"pass,point,time_s,range_m,doppler_hz,doppler_sigma_hz",
       "A2,P1,3.5,9000,,2\n",
       "observations.csv:2: doppler_hz: is empty, but this row has doppler_sigma_hz: give "
       "the "
       "measured Doppler, or the standard deviation as azimuth_sigma_m or time_sigma_s"},
      {"pass,point,time_s,range_m,squint_deg,doppler_sigma_hz",
       "A2,P1,3.5,9000,1.5,2\n",
       "observations.csv:2: doppler_hz: is empty, but this row has doppler_sigma_hz"},
      {"pass,point,time_s,range_m,doppler_hz,doppler_sigma_hz",
       "A1,P1,3.5,9000,120.5,2\n",
       "observations.csv:2: doppler_hz: pass 'A1' has no wavelength_m in block.toml"},
      {"pass,point,time_s,range_m,rejected",
       "A1,P1,3.5,9000,yes\n",
       "observations.csv:2: rejected: must be 0 or 1, got 'yes'"},
  };
  for (const RowCase& bad : cases) {
    EXPECT_THAT(BlockError(toml, kGoodPaths, std::string(bad.header) + "\n" + bad.rows),
                HasSubstr(bad.message));
  }
}

TEST(BlockErrorsTest, HasNoSilentDefaultForAMissingSigma) {
  const std::string row = "pass,point,time_s,range_m\nA1,P1,3.5,9000\n";
  EXPECT_EQ(BlockError(Changed(kGoodToml, {"range_m = 1.25", ""}), kGoodPaths, row),
            "observations.csv:2: range_sigma_m: no standard deviation of range: neither this row, "
            "pass 'A1' nor [sigma] of block.toml gives one");
  EXPECT_EQ(BlockError(Changed(kGoodToml, {"azimuth_m = 0.75", ""}), kGoodPaths, row),
            "observations.csv:2: azimuth_sigma_m: no standard deviation of azimuth: neither this "
            "row, pass 'A1' nor [sigma] of block.toml gives one");
  const std::string pass_gives = "look = \"left\"\nazimuth_sigma_s = 0.002";
  const std::string toml =
      Changed(Changed(kGoodToml, {"azimuth_m = 0.75", ""}), {"look = \"left\"", pass_gives});
  EXPECT_EQ(BlockError(toml, kGoodPaths, row), "");
}

TEST(BlockErrorsTest, NamesPlaceAndProblemInPoints) {
  const std::string plain = "point,role,x_m,y_m,z_m,sigma_e_m,sigma_n_m,sigma_u_m,cov_en_m2";
  const RowCase cases[] = {
      {"role,x_m", "", "points.csv:1: point: the column is missing"},
      {"point,role",
       "P1,tie\nP1,tie\n",
       "points.csv:3: point: 'P1' is given twice; one row per point"},
      {"point,role",
       "P1,controll\n",
       "points.csv:2: role: 'controll' is not known, tie, control or check is allowed; did you "
       "mean "
       "control?"},
      {"point,role",
       "P1,control\n",
       "points.csv:2: x_m: is empty, a control or check point needs x_m, y_m, z_m"},
      {plain.c_str(),
       "P1,tie,1,,3,,,,\n",
       "points.csv:2: y_m: is empty, all three components are needed or none"},
      {plain.c_str(),
       "P1,control,1,2,3,,,,\n",
       "points.csv:2: sigma_e_m: a control point without a standard deviation"},
      {plain.c_str(),
       "P1,control,1,2,3,0.5,0,,\n",
       "points.csv:2: sigma_n_m: must be a number above 0, got 0"},
      {plain.c_str(),
       "P1,control,1,2,3,0.5,1e308,,\n",
       "points.csv:2: sigma_n_m: must be a number from 1e-60 to 1e60, got 1e+308"},
      {plain.c_str(),
       "P1,control,1,2,3,0.5,,0.5,0.01\n",
       "points.csv:2: cov_en_m2: is given without the standard deviations of both components"},
      {plain.c_str(),
       "P1,control,1,2,3,0.5,0.4,,-0.2\n",
       "points.csv:2: cov_en_m2: the covariance matrix is not positive definite"},
      {"point,lat_deg,lon_deg,h_m",
       "P1,1,2,3\n",
       "points.csv:1: lat_deg: a local frame has no geodetic coordinates"},
  };
  for (const RowCase& bad : cases) {
    EXPECT_THAT(
        BlockError(kGoodToml, kGoodPaths, kGoodLooks, std::string(bad.header) + "\n" + bad.rows),
        HasSubstr(bad.message));
  }
}

TEST(BlockErrorsTest, NamesPlaceAndProblemOfGeodeticCoordinates) {
  const std::string toml =
      Changed(kGoodToml, {"kind = \"local\"", "kind = \"geocentric\"\nellipsoid = \"moon\""});
  const std::string header = "point,x_m,y_m,z_m,lat_deg,lon_deg,h_m\n";
  EXPECT_EQ(BlockError(toml, kGoodPaths, kGoodLooks, header + "P1,,,,90.5,12,100\n"),
            "points.csv:2: lat_deg: must be from -90 to 90, got 90.5");
  EXPECT_EQ(BlockError(toml, kGoodPaths, kGoodLooks, header + "P1,,,,9.5,-361,100\n"),
            "points.csv:2: lon_deg: must be from -360 to 360, got -361");
  EXPECT_EQ(BlockError(toml, kGoodPaths, kGoodLooks, header + "P1,1,2,3,9.5,12,100\n"),
            "points.csv:2: lat_deg: excludes x_m, y_m, z_m; give one kind of coordinates");
}

using BlockFolderErrorsTest = test::FolderTest;

TEST_F(BlockFolderErrorsTest, NamesMissingFiles) {
  const auto error = [&] {
    return test::MessageOf<InputError>([&] { return files::ReadBlock(folder_); });
  };
  EXPECT_THAT(error(), HasSubstr("block.toml: is missing, every block has this file"));
  Put("block.toml", kGoodToml);
  EXPECT_THAT(error(), HasSubstr("trajectories.csv: is missing, every block has this table"));
  Put("trajectories.csv", kGoodPaths);
  EXPECT_THAT(error(), HasSubstr("observations.csv: is missing, every block has this table"));
  PutGzip("observations.csv.gz", kGoodLooks);
  EXPECT_EQ(error(), "");
  Put("observations.csv", kGoodLooks);
  EXPECT_THAT(error(), HasSubstr("observations.csv.gz: excludes observations.csv"));
  EXPECT_THAT(test::MessageOf<InputError>([&] { return files::ReadBlock(folder_ / "none"); }),
              HasSubstr("none: does not exist; a block is a folder with block.toml"));
  std::filesystem::remove(folder_ / "block.toml");
  Put("summary.json", "{}");
  EXPECT_THAT(error(), HasSubstr("is a result, not a block; a block is a folder with"));
  EXPECT_THAT(
      test::MessageOf<InputError>([&] { return files::ReadBlock(folder_ / "summary.json"); }),
      HasSubstr("summary.json: is a file that is no HDF5 file; a block is a folder"));
}

TEST_F(BlockFolderErrorsTest, NamesTheLineWhereAGzipTableIsCutOff) {
  Put("block.toml", kGoodToml);
  Put("trajectories.csv", kGoodPaths);
  std::string looks = "pass,point,time_s,range_m\n";
  for (int i = 0; i < 20011; ++i) {
    looks +=
        "A1,Q" + std::to_string(i * 7919 % 100003) + ",3.5," + std::to_string(9e3 + i % 977) + "\n";
  }
  const std::string bytes = Content(PutGzip("observations.csv.gz", looks));
  Put("observations.csv.gz", bytes.substr(0, bytes.size() * 3 / 4));
  EXPECT_THAT(test::MessageOf<InputError>([&] { return files::ReadBlock(folder_); }),
              testing::ContainsRegex("observations.csv.gz:[0-9]+: the gzip data end too early"));
}

TEST(BlockErrorsTest, SecondsThatBeginAgainAreToldBesideATimeOffThePath) {
  const auto with_time = [](const std::string& time) {
    return BlockError(kGoodToml, kGoodPaths, Changed(kGoodLooks, {"A2,P1,3.75", "A2,P1," + time}));
  };
  EXPECT_THAT(with_time("-86396.25"),
              testing::AllOf(HasSubstr("observations.csv:3: time_s: -86396.25 is outside"),
                             HasSubstr("; 86400 s later it is on it: seconds of the day")));
  EXPECT_THAT(with_time("604803.75"),
              HasSubstr("; 604800 s earlier it is on it: seconds of the week"));
  EXPECT_THAT(with_time("40"), testing::EndsWith("which goes from 0 to 30.25 s"));
}

TEST(BlockErrorsTest, KnownPointsThatAreCommentsAreRefusedWhereTheyAreSeen) {
  const std::string points = kGoodPoints + "#1,control,1,2,3,0.5,0.5,0.5\n";
  std::string looks = kGoodLooks;
  for (std::size_t at; (at = looks.find(",P1,")) != std::string::npos;)
    looks.replace(at, 4, ",#1,");
  EXPECT_THAT(BlockError(kGoodToml, kGoodPaths, looks, points),
              HasSubstr("points.csv:2: point: a line that begins with # is a comment, and the "
                        "observations name a point '#1'"));
  EXPECT_EQ(BlockError(kGoodToml, kGoodPaths, looks, kGoodPoints + "\"#1\",tie,,,,,,\n"), "");
  // A row that is left out on purpose, and tie points that no row gives.
  EXPECT_EQ(BlockError(kGoodToml, kGoodPaths, kGoodLooks, points), "");
  EXPECT_EQ(BlockError(kGoodToml, kGoodPaths, looks, kGoodPoints), "");
}

TEST(BlockErrorsTest, AdjustedPathsAreRefusedWithoutTheCorrectionsBesideThem) {
  std::string paths = kGoodPaths;
  for (std::size_t at = 0, row = 0; at < paths.size(); ++row) {
    at = paths.find('\n', at);
    const std::string cell = row == 0 ? ",adjusted" : row < 3 ? ",range.bias time.bias" : ",all";
    paths.insert(at, cell);
    at += cell.size() + 1;
  }
  EXPECT_THAT(
      BlockError(kGoodToml, paths, kGoodLooks),
      testing::AllOf(HasSubstr("trajectories.csv:2: adjusted: the adjustment that wrote these "
                               "states of pass 'A1' also corrected range.bias, time.bias"),
                     HasSubstr("[adjust.correction]")));
  EXPECT_EQ(BlockError(kGoodToml + "[adjust]\ncorrections = \"auto\"\n", paths, kGoodLooks), "");
  const std::string none = kGoodToml +
                           "[adjust]\ncorrections = \"none\"\n[adjust.correction.range]\nbias = "
                           "true\n[adjust.correction.time]\nbias = true\n";
  EXPECT_THAT(BlockError(none, paths, kGoodLooks), HasSubstr("also corrected range.bias"));
  const std::string both = kGoodToml + "[adjust.correction.range]\nbias = true\n";
  EXPECT_THAT(BlockError(both, paths, kGoodLooks), HasSubstr("also corrected time.bias, which"));
  EXPECT_EQ(BlockError(both + "[adjust.correction.time]\nbias = true\n", paths, kGoodLooks), "");
}

}  // namespace
}  // namespace sarblock
