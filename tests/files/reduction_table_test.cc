// SPDX-License-Identifier: Apache-2.0
// Reductions in files: columns of looks, [reduction] of a block and of a pass, refusals.
#include "sarblock/files/block_file.h"

#include <string>

#include "support/folder_test.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::HasSubstr;
using testing::Not;
using ReductionTableTest = test::FolderTest;

constexpr const char* kTwoFlights =
    "pass,time_s,x_m,y_m,z_m,vx_mps,vy_mps,vz_mps\n"
    "A,0,0,-9000,70000,100,0,0\nA,100,10000,-9000,70000,100,0,0\n"
    "B,0,0,9000,70000,100,0,0\nB,100,10000,9000,70000,100,0,0\n";

files::BlockFile FileWith(const std::string& reduction,
                          const std::string& of_b,
                          const std::string& looks) {
  const std::string toml =
      "format = \"sarblock-block 1\"\n[frame]\nkind = \"local\"\n" + reduction +
      "[sigma]\nrange_m = 1\nazimuth_m = 1\n[[pass]]\nid = \"A\"\nlook = \"left\"\n"
      "wavelength_m = 0.03\n[[pass]]\nid = \"B\"\nlook = \"right\"\n" +
      of_b;
  return files::ReadBlockTexts({toml, kTwoFlights, looks, "point,role\n"});
}
Block ReadWith(const std::string& reduction, const std::string& of_b, const std::string& looks) {
  return FileWith(reduction, of_b, looks).block;
}
std::vector<std::string> WarningsWith(const std::string& looks) {
  return FileWith("", "", looks).warnings;
}

constexpr const char* kReducedLooks =
    "pass,point,time_s,range_m,range_delay_m,time_shift_s\nA,P,50,70576.65,2.5,-0.25\n"
    "B,P,50,70576.65,,\n";

TEST_F(ReductionTableTest, LooksAreReadWithoutWhatTheySayToTakeOff) {
  const Block block = ReadWith("", "", kReducedLooks);
  EXPECT_EQ(block.looks.range_m[0], 70576.65 - 2.5);
  EXPECT_EQ(block.looks.time_s[0], 50.25);
  EXPECT_EQ(block.looks.range_m[1], 70576.65);
  EXPECT_EQ(block.looks.range_delay_m[1], 0.0);
  EXPECT_EQ(block.Measured(0).time_s, 50.0);
  EXPECT_NEAR(block.Measured(0).range_m, 70576.65, 1e-11);
  // Columns of nothing are none.
  EXPECT_TRUE(ReadWith("", "", "pass,point,time_s,range_m,range_delay_m\nA,P,50,70500,0\n")
                  .looks.range_delay_m.empty());
}

TEST_F(ReductionTableTest, APassOverridesTheBlock) {
  const Block block = ReadWith(
      "[reduction]\ntroposphere = \"standard\"\nionosphere = { tec_tecu = 12 }\nrange_m = 0.5\n",
      "wavelength_m = 0.03\nreduction = { troposphere = { pressure_hpa = 1000, temperature_k = "
      "280, humidity_1 = 0.4 }, ionosphere = \"none\", time_s = 1e-4 }\n",
      kReducedLooks);
  const ReductionModels &a = block.passes[0].reduction, &b = block.passes[1].reduction;
  EXPECT_EQ(a.troposphere, TroposphereModel::kStandard);
  EXPECT_EQ(a.ionosphere.value().tec_tecu, 12.0);
  EXPECT_EQ(a.ionosphere.value().share, 1.0);
  EXPECT_EQ(a.range_m, 0.5);
  EXPECT_EQ(b.troposphere, TroposphereModel::kWeather);
  EXPECT_EQ(b.weather, (Weather{1000.0, 280.0, 0.4, 0.0}));
  EXPECT_FALSE(b.ionosphere.has_value());
  EXPECT_EQ(b.range_m, 0.5);
  EXPECT_EQ(b.time_s, 1e-4);
}

TEST_F(ReductionTableTest, IsWrittenAsItWasRead) {
  for (const char* of_b : {"", "reduction = { time_s = -0.001, tide = \"none\" }\n"}) {
    const Block block = ReadWith(
        "[reduction]\ntroposphere = { pressure_hpa = 1000.5, temperature_k = 281, "
        "humidity_1 = 0.25, height_m = 120 }\nrange_m = 0.5\n",
        of_b,
        kReducedLooks);
    for (const char* name : {"block", "block.h5"}) {
      files::WriteBlock(folder_ / name, block, {});
      const Block back = files::ReadBlock(folder_ / name).block;
      for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_EQ(back.passes[i].reduction, block.passes[i].reduction);
        EXPECT_NEAR(back.looks.range_m[i], block.looks.range_m[i], 4e-12);
        EXPECT_EQ(back.looks.range_delay_m[i], block.looks.range_delay_m[i]);
        EXPECT_EQ(back.looks.time_shift_s[i], block.looks.time_shift_s[i]);
      }
      std::filesystem::remove_all(folder_ / name);
    }
  }
  // A block that takes nothing off says nothing of it.
  files::WriteBlock(
      folder_ / "plain", ReadWith("", "", "pass,point,time_s,range_m\nA,P,50,70500\n"), {});
  EXPECT_THAT(Content(folder_ / "plain" / "block.toml"), Not(HasSubstr("reduction")));
  EXPECT_THAT(Content(folder_ / "plain" / "observations.csv"), Not(HasSubstr("delay")));
}

TEST_F(ReductionTableTest, DoubtsDelaysOfTheWrongSignAndUnit) {
  const auto warnings = [](const std::string& delay, const std::string& shift) {
    const std::string looks =
        "pass,point,time_s,range_m,range_delay_m,time_shift_s\nA,P,50,70576," + delay + "," +
        shift + "\nB,P,50,70576,,\n";
    std::string all;
    for (const std::string& warning : WarningsWith(looks)) all += warning + "\n";
    return all;
  };
  EXPECT_THAT(warnings("2.4", "0.0003"), Not(HasSubstr("in the median")));
  EXPECT_THAT(warnings("-0.4", "-0.0003"), Not(HasSubstr("in the median")));
  EXPECT_THAT(warnings("-2.4", ""),
              HasSubstr("pass 'A': range_delay_m is -2.4 m in the median: what makes ranges too "
                        "long is positive"));
  EXPECT_THAT(warnings("1.6e-8", ""), HasSubstr("are these seconds?"));
  EXPECT_THAT(warnings("", "0.38"), HasSubstr("are these milliseconds or metres?"));
}

}  // namespace
}  // namespace sarblock
