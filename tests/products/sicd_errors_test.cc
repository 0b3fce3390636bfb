// SPDX-License-Identifier: Apache-2.0
// ErrorStatistics of SICD images as priors, against closed forms of plain.xml (sicd_test.cc): the
// antenna flies along z at x = 7e6 m, so that radial is x, in-track z and cross-track -y.
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/files/block_file.h"

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "products/import.h"
#include "products/sicd.h"
#include "products/synthetic_annotation.h"
#include "support/folder_test.h"
#include <gmock/gmock.h>

namespace sarblock {
namespace {

using test::MessageOf;
using test::Replaced;
using testing::HasSubstr;

// Columns -200 to 99 of 1.5 m at 1.4e-4 s/m about the aperture of the scene centre.
constexpr double kSinceCentre_s = 0.5 * (-300.0 + 148.5) * 1.4e-4;
constexpr double kHalf_s = 0.5 * 448.5 * 1.4e-4;

class SicdErrorsTest : public test::FolderTest {
 protected:
  static std::string Text(const std::string& name = "errors.xml") {
    return Content(std::filesystem::path(SARBLOCK_FUZZ_CORPUS) / "sicd" / name);
  }
  static ImportedBlock Imported(const std::string& text) {
    return ImportProducts({ParseSicd(text, "a.xml")}, {}, ImportOptions{});
  }
  /// Of errors.xml: P1 .. V3 as the file has them.
  static Eigen::MatrixXd Given(double p1_m = 1.1) {
    Eigen::VectorXd sigma(6);
    sigma << p1_m, 0.7, 1.9, 0.013, 0.017, 0.011;
    Eigen::MatrixXd r = Eigen::MatrixXd::Identity(6, 6);
    r(0, 1) = 0.31;
    r(0, 3) = -0.42;
    r(1, 5) = 0.27;
    r(2, 5) = -0.53;
    r(3, 4) = 0.19;
    const Eigen::MatrixXd upper = r.triangularView<Eigen::StrictlyUpper>();
    return sigma.asDiagonal() * (r + upper.transpose()) * sigma.asDiagonal();
  }
  /// Of c_0 = P + s V and c = h V, element by element.
  static Eigen::MatrixXd Expected(const Eigen::MatrixXd& q) {
    const double s = kSinceCentre_s, h = kHalf_s;
    Eigen::MatrixXd out(6, 6);
    for (Eigen::Index i = 0; i < 3; ++i) {
      for (Eigen::Index j = 0; j < 3; ++j) {
        const double vv = q(3 + i, 3 + j);
        out(i, j) = q(i, j) + s * (q(i, 3 + j) + q(3 + i, j)) + s * s * vv;
        out(i, 3 + j) = out(3 + j, i) = h * (q(i, 3 + j) + s * vv);
        out(3 + i, 3 + j) = h * h * vv;
      }
    }
    return out;
  }
};

TEST_F(SicdErrorsTest, EarthFixedErrorsBecomeConstantsAndDrifts) {
  const ImportedBlock imported = Imported(Text());
  ASSERT_EQ(imported.corrections.size(), 3U);
  const auto& position = std::get<PositionCorrection>(imported.corrections[0].model);
  EXPECT_EQ(position.degree, 1);
  EXPECT_EQ(position.axes, PositionCorrection::Axes::kFrame);
  EXPECT_EQ(imported.corrections[0].passes, std::vector<std::string>{"a"});
  EXPECT_EQ(std::get<RangeCorrection>(imported.corrections[1].model).bias_prior_sigma_m, 0.23);
  EXPECT_EQ(std::get<TroposphereCorrection>(imported.corrections[2].model).zenith_prior_sigma_m,
            0.05);
  ASSERT_EQ(imported.priors.size(), 1U);
  const JointPrior& prior = imported.priors[0];
  EXPECT_EQ(prior.passes, std::vector<std::string>{"a"});
  EXPECT_EQ(prior.parameters,
            (std::vector<std::string>{"position.x.0",
                                      "position.y.0",
                                      "position.z.0",
                                      "position.x.1",
                                      "position.y.1",
                                      "position.z.1"}));
  EXPECT_LT((prior.covariance.matrix() - Expected(Given())).norm(), 1e-12);
  EXPECT_THAT(imported.products[0].priors, HasSubstr("path 1.1, 0.7, 1.9 m and 0.013, 0.017"));
  EXPECT_THAT(
      imported.products[0].priors,
      HasSubstr("not used: CompositeSCP, PosVelErr.PositionDecorr, RadarSensor.ClockFreqSF, "
                "IonoError"));
}

TEST_F(SicdErrorsTest, RadialInTrackAndCrossTrackAreThoseOfTheVelocity) {
  // At t = 0.5 the antenna is at (7e6, 0, 0.125) and flies with (0, 0, 7000.5): radial is x to
  // 2e-8.
  const auto turned = [](const Eigen::Matrix3d& axes) {
    Eigen::MatrixXd t = Eigen::MatrixXd::Zero(6, 6);
    t.topLeftCorner<3, 3>() = t.bottomRightCorner<3, 3>() = axes;
    return Expected(t * Given() * t.transpose());
  };
  Eigen::Matrix3d fixed;  // columns radial, in-track, cross-track
  fixed << 1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0;
  const ImportedBlock by_fixed = Imported(Replaced(Text(), ">ECF</Frame>", ">RIC_ECF</Frame>"));
  EXPECT_LT((by_fixed.priors.at(0).covariance.matrix() - turned(fixed)).norm(), 1e-6);
  // The Earth turns the antenna by 7.292115e-5 * 7e6 m/s to the east (y).
  const double east_mps = 7.292115e-5 * 7e6, angle_rad = std::atan2(east_mps, 7000.5);
  Eigen::Matrix3d inertial;
  inertial << 1.0, 0.0, 0.0,                           //
      0.0, std::sin(angle_rad), -std::cos(angle_rad),  //
      0.0, std::cos(angle_rad), std::sin(angle_rad);
  const ImportedBlock by_inertial = Imported(Replaced(Text(), ">ECF</Frame>", ">RIC_ECI</Frame>"));
  EXPECT_LT((by_inertial.priors.at(0).covariance.matrix() - turned(inertial)).norm(), 1e-6);
  EXPECT_GT((turned(inertial) - turned(fixed)).norm(), 1e-2);
}

TEST_F(SicdErrorsTest, WhatIsLeftOutIsSaid) {
  const ImportedBlock plain = Imported(Text("plain.xml"));
  EXPECT_TRUE(plain.corrections.empty());
  EXPECT_TRUE(plain.priors.empty());
  EXPECT_THAT(plain.products[0].priors, HasSubstr("no ErrorStatistics"));
  // Velocities of 0: no drift.
  std::string still = Text();
  for (const char* v : {"<V1>0.013", "<V2>0.017", "<V3>0.011"}) {
    still = Replaced(still, v, std::string(v).substr(0, 4) + "0");
  }
  const ImportedBlock constant = Imported(still);
  EXPECT_EQ(std::get<PositionCorrection>(constant.corrections.at(0).model).degree, 0);
  const Eigen::MatrixXd given = Given();
  EXPECT_LT((constant.priors.at(0).covariance.matrix() - given.topLeftCorner<3, 3>()).norm(),
            1e-14);
  // Correlations of 1 throughout are no distribution.
  const ImportedBlock singular = Imported(Text("errors_singular.xml"));
  EXPECT_TRUE(singular.priors.empty());
  EXPECT_EQ(singular.corrections.size(), 2U);
  EXPECT_THAT(singular.warnings, testing::Contains(HasSubstr("PosVelErr is no prior of the path")));
}

TEST_F(SicdErrorsTest, UnmodeledErrorsAreTheStandardDeviationsOfLooks) {  // hand values
  const auto text = [](const std::string& rest) {
    return Replaced(
        Text(), " </Components>\n", " </Components>\n <Unmodeled>" + rest + "</Unmodeled>\n");
  };
  const std::string both = "<Xrow>0.21</Xrow><Ycol>0.37</Ycol><XrowYcol>0.1</XrowYcol>";
  const ImportedBlock imported = Imported(text(both));
  const LookSigma sigma = imported.block.passes[0].sigma;
  EXPECT_EQ(sigma.range_m, 0.21);
  EXPECT_EQ(sigma.azimuth, 0.37);
  EXPECT_EQ(sigma.azimuth_unit, AzimuthUnit::kMetres);
  EXPECT_THAT(imported.products[0].priors, HasSubstr("Unmodeled.XrowYcol"));
  ImportOptions options;
  options.range_sigma_m = 0.5;  // what is asked for stands before what the file says
  const ImportedBlock asked = ImportProducts({ParseSicd(text(both), "a.xml")}, {}, options);
  EXPECT_EQ(asked.block.passes[0].sigma.range_m, 0.5);
  EXPECT_EQ(asked.block.passes[0].sigma.azimuth, 0.37);
  EXPECT_THAT(MessageOf<InputError>([&] { Imported(text("<Xrow>0</Xrow><Ycol>0.37</Ycol>")); }),
              HasSubstr("Xrow: is 0"));
}

TEST_F(SicdErrorsTest, NonsenseIsRefusedWithLineAndElement) {
  const auto refusal = [](const std::string& from, const std::string& to) {
    return MessageOf<InputError>([&] { return ParseSicd(Replaced(Text(), from, to), "a.xml"); });
  };
  const std::string at = "a.xml:18: SICD.ErrorStatistics.Components.PosVelErr.";
  EXPECT_THAT(refusal(">ECF</Frame>", ">RTN</Frame>"),
              HasSubstr(at + "Frame: must be ECF, RIC_ECF or RIC_ECI, got 'RTN'"));
  EXPECT_THAT(refusal("<P2>0.7", "<P2>-0.7"),
              HasSubstr(at + "P2: must be a standard deviation from 0 to"));
  EXPECT_THAT(refusal("<P1P2>0.31", "<P1P2>1.31"), HasSubstr("P1P2: is no correlation"));
  EXPECT_THAT(refusal("<V2V3>0</V2V3>", ""), HasSubstr("V2V3"));
  EXPECT_THAT(refusal("<RangeBias>0.23", "<RangeBias>nan"), HasSubstr("RangeBias"));
}

// Round trip: the table that is written reads back to the same priors, of several images too.
TEST_F(SicdErrorsTest, SeveralImagesHaveEachItsOwnPrior) {
  const ImportedBlock imported =
      ImportProducts({ParseSicd(Text(), "a.xml"),
                      ParseSicd(Text("plain.xml"), "b 1.xml"),
                      ParseSicd(Replaced(Text(), "<P1>1.1", "<P1>2.2"), "c.xml")},
                     {},
                     ImportOptions{});
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = imported.corrections;
  options.priors = imported.priors;
  const std::string dump = files::DumpAdjustTable(options);
  const AdjustOptions again = files::ReadAdjustTable(dump, "block.toml", {"a", "b 1", "c"});
  ASSERT_EQ(again.priors.size(), 2U);
  EXPECT_EQ(again.priors[0].covariance, imported.priors[0].covariance);
  EXPECT_LT((again.priors[1].covariance.matrix() - Expected(Given(2.2))).norm(), 1e-12);
  EXPECT_EQ(files::DumpAdjustTable(again), dump);
}

}  // namespace
}  // namespace sarblock
