// SPDX-License-Identifier: Apache-2.0
// Mistakes planted in shipped scenes, their passes, signs and sizes drawn: seeded statistics, with
// one draw of each by default; SARBLOCK_DRAWS sets more. The whole table is made by diagnosis_table
// (docs/validation.md).
#include "sarblock/diagnose/diagnose.h"

#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/files/block_file.h"
#include "sarblock/files/scene_file.h"
#include "sarblock/simulate/scene.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "block/plausibility.h"
#include "block/read_recorded.h"
#include "diagnose/mistakes.h"
#include "diagnose/plants_edit.h"
#include "diagnose/sample.h"
#include "diagnose/trial_blocks.h"
#include "support/scene_blocks.h"
#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using test::Outcome;
using test::Plant;
using ::testing::HasSubstr;

std::uint64_t Draws(std::uint64_t without) {
  const char* text = std::getenv("SARBLOCK_DRAWS");
  return text == nullptr ? without : std::strtoull(text, nullptr, 10);
}

class MistakesOfScene : public ::testing::TestWithParam<const char*> {};

TEST_P(MistakesOfScene, AreNamedFirstInNineOfTen) {
  int seen = 0, first = 0;
  std::string others;
  for (const Plant& plant : test::Plants()) {
    for (std::uint64_t seed = 1; seed <= Draws(1); ++seed) {
      const test::TrialResult result = test::RunTrial(GetParam(), plant, seed);
      if (result.outcome == Outcome::kNotApplicable || result.outcome == Outcome::kUnseen) continue;
      ++seen;
      first += result.outcome == Outcome::kFirst ? 1 : 0;
      if (result.outcome != Outcome::kFirst) {
        others += "\n" + plant.name + ", seed " + std::to_string(seed) + ":";
        for (const std::string& text : result.diagnosis.Sentences()) others += "\n  " + text;
      }
    }
  }
  EXPECT_GE(first, 0.9 * seen) << others;
  EXPECT_GT(seen, 20);
}

INSTANTIATE_TEST_SUITE_P(Scenes,
                         MistakesOfScene,
                         ::testing::Values("earth-asc-desc", "opposite-side"),
                         [](const auto& scene) { return test::TestNameOf(scene.param); });

TEST(DiagnoseTest, SaysNothingOfAGoodBlock) {
  for (const std::string& name : test::TrialNames()) {
    for (std::uint64_t seed = 1; seed <= Draws(2); ++seed) {
      const test::TrialBlock made = test::MakeTrialBlock(name, seed);
      const Diagnosis diagnosis = Diagnose(made.block, made.options);
      EXPECT_TRUE(diagnosis.explanations.empty())
          << name << ", seed " << seed << ": " << diagnosis.Sentences().front();
      EXPECT_TRUE(diagnosis.remarks.empty()) << name;
    }
  }
}

TEST(DiagnoseTest, ClaimsNoMoreOfAnUnlistedErrorThanWhatItTakes) {
  for (const Plant& plant : test::UnlistedErrors()) {
    for (const char* name : {"earth-asc-desc", "opposite-side"}) {
      for (std::uint64_t seed = 1; seed <= Draws(1); ++seed) {
        const test::TrialResult result = test::RunTrial(name, plant, seed);
        for (const Explanation& reported : result.diagnosis.explanations) {
          // Two routes: the part that is reported, and the square sums.
          const double part =
              (reported.square_sum_before - reported.square_sum_after) / reported.square_sum_before;
          EXPECT_NEAR(reported.part, part, 1e-12) << reported.sentence;
          const bool explains_all = reported.square_sum_after < 2.0 * reported.redundancy_after &&
                                    reported.looks_lost_after == 0;
          const bool says_so = reported.sentence.find("does not explain all") != std::string::npos;
          EXPECT_NE(says_so, explains_all) << reported.sentence;
        }
      }
    }
  }
}

// Positions that stand still give a path of their own no velocity: the other reading is none.
TEST(DiagnoseTest, AReadingThatGivesNoPathLeavesThePassesAsTheyWere) {
  test::TrialBlock made = test::MakeTrialBlock("leberl-aircraft", 3);
  Block& block = made.block;
  std::vector<StateVector> states = block.passes[0].RecordedStates();
  for (StateVector& state : states) {  // x_m and vz_mps were exchanged
    state.position_m = states.front().position_m;
    state.velocity_mps = {180.0, 0.0, 180.0 * state.time_s};
  }
  block.passes[0].path = FlightPath(states);
  const std::size_t pieces = block.passes[0].path.piece_count();
  ReadWithAuto({}, &block);
  EXPECT_EQ(block.passes[0].path.piece_count(), pieces);
  EXPECT_EQ(block.passes[0].recorded.asked.through, PathThrough::kStates);
  EXPECT_TRUE(block.passes[0].recorded.states.empty());
  EXPECT_NO_THROW(static_cast<void>(Diagnose(block, made.options)));
}

TEST(DiagnoseTest, NamesTheDifferenceOfGpsAndUtc) {
  test::TrialBlock made = test::MakeTrialBlock("earth-asc-desc", 3);
  Block& block = made.block;
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    if (block.passes[block.looks.pass[i]].id == "DSC") block.looks.time_s[i] += 18.0;
  }
  const Diagnosis diagnosis = Diagnose(block, made.options);
  ASSERT_FALSE(diagnosis.explanations.empty());
  const Explanation& reported = diagnosis.explanations.front();
  EXPECT_EQ(reported.cause, "time.constant");
  EXPECT_EQ(reported.passes, std::vector<std::string>{"DSC"});
  EXPECT_NEAR(reported.value, 18.0, 4.0 * reported.sigma);
  EXPECT_LT(reported.sigma, 0.01);
  EXPECT_GT(reported.part, 0.99);
  EXPECT_THAT(diagnosis.Sentences().front(),
              HasSubstr("s late (GPS and UTC differ by 18 s since 2017): takes 99.9"));
  EXPECT_THAT(reported.change,
              HasSubstr("time_s of DSC minus " + InFiles(reported.value, reported.sigma) +
                        ", or correction.time of DSC"));
}

// A search for blunders would leave out too many looks of the pass: it leaves out none, and the
// mistake is the first reason.
TEST(DiagnoseTest, IsTheFirstReasonWhereASearchForBlundersIsAborted) {
  test::TrialBlock made = test::MakeTrialBlock("earth-asc-desc", 3);
  Block& block = made.block;
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    if (block.passes[block.looks.pass[i]].id == "DSC") block.looks.time_s[i] += 0.4;
  }
  AdjustOptions options = made.options;
  for (const Snooping snooping : {Snooping::kIterative, Snooping::kRobust}) {
    options.quality.snooping = snooping;
    AdjustResult result = Adjust(block, options);
    EXPECT_FALSE(result.snooping.has_value());
    EXPECT_EQ(result.assessment.verdict, Verdict::kNotAccepted);
    ASSERT_TRUE(ExplainFailure(block, options, {}, &result).has_value());
    EXPECT_THAT(result.assessment.reasons.front(),
                HasSubstr("most likely: the times of pass DSC are 0."));
  }
}

TEST(DiagnoseTest, ReportsAMistakeOnce) {
  test::TrialBlock made = test::MakeTrialBlock("block-12-strips", 3);
  Block& block = made.block;
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    if (block.passes[block.looks.pass[i]].id == "S5") block.looks.range_m[i] += 300.0;
  }
  const Diagnosis diagnosis = Diagnose(block, made.options);
  ASSERT_EQ(diagnosis.explanations.size(), 1U);  // known points and the score test both find it
  EXPECT_EQ(diagnosis.explanations[0].passes, std::vector<std::string>{"S5"});
  EXPECT_NEAR(diagnosis.explanations[0].value, 300.0, 4.0 * diagnosis.explanations[0].sigma);
}

/// Squinted looks with their squints as measured Dopplers, of the standard deviation that the
/// azimuth had; the noise of the times stays in the block as one of the Dopplers.
test::TrialBlock DopplerTrial(std::uint64_t seed) {
  test::TrialBlock made = test::MakeTrialBlock("convergent-squint", seed);
  Block& block = made.block;
  Looks& looks = block.looks;
  std::vector<double> sigma_hz(looks.size());
  for (std::size_t i = 0; i < looks.size(); ++i) {
    Pass& pass = block.passes[looks.pass[i]];
    pass.wavelength_m = 0.031;
    const double speed_mps = pass.path.At(looks.time_s[i])->velocity_mps.norm();
    const double sigma_m = block.ApproximateAzimuthSigma_m(i, speed_mps);
    looks.cone[i] = 2.0 * speed_mps * std::sin(looks.cone[i]) / pass.wavelength_m;
    sigma_hz[i] = sigma_m * 2.0 * speed_mps / (pass.wavelength_m * looks.range_m[i]);
  }
  for (std::uint8_t& flags : looks.flags) flags |= Looks::kDoppler | Looks::kAzimuthHertz;
  looks.azimuth_sigma = sigma_hz;
  return made;
}

TEST(DiagnoseTest, NamesOneMeasuredDoppler) {
  test::TrialBlock made = DopplerTrial(3);
  EXPECT_TRUE(Diagnose(made.block, made.options).explanations.empty());
  Block& block = made.block;
  const std::uint32_t point = 11;
  const std::size_t look = block.looks.offsets[point];
  block.looks.cone[look] += 731.0;
  const Diagnosis diagnosis = Diagnose(block, made.options);
  ASSERT_FALSE(diagnosis.explanations.empty());
  const Explanation& reported = diagnosis.explanations.front();
  EXPECT_EQ(reported.points, std::vector<std::string>{std::string(block.points.ids[point])});
  bool named = false;
  for (const std::string& sentence : diagnosis.Sentences()) {
    named = named || sentence.find("the Doppler of point ") != std::string::npos;
    EXPECT_EQ(sentence.find("the time of point "), std::string::npos) << sentence;
  }
  EXPECT_TRUE(named) << diagnosis.Sentences().front();
}

/// Mistakes that led nowhere: before work was bounded they took 18 to 55 adjustments.
const char* const kDearMistakes[][2] = {{"earth-asc-desc", "control in radians"},
                                        {"block-12-strips", "control in km"},
                                        {"leberl-voir", "ranges of all two-way, km, us"},
                                        {"recorded/uav", "azimuth sigma 1000 times off"}};

TEST(DiagnoseTest, DoesNoMoreThanItsBoundHoweverBadTheBlock) {
  for (const auto& [name, mistake] : kDearMistakes) {
    test::TrialBlock made = test::MakeTrialBlock(name, 5);
    RandomStream random(1, 2);
    static_cast<void>(test::PlantNamed(mistake).make(&made.block, &random));
    const auto looks = static_cast<double>(made.block.looks.size());
    const auto sampled = static_cast<double>(TakeSample(made.block, nullptr).block.looks.size());
    const Diagnosis diagnosis = Diagnose(made.block, made.options);
    // docs/theory/diagnosis.md, eq. (11)
    EXPECT_DOUBLE_EQ(diagnosis.max_work,
                     DiagnosisBounds{}.adjustments * std::max(5.5 * looks, 54.0 * sampled))
        << name;
    // The first size may take a fifth more; a search is left before the next three solutions, each
    // of 17 + 7 looks formed at most, and no sample is more than the block.
    EXPECT_LE(diagnosis.work, 1.2 * diagnosis.max_work + 72.0 * looks) << name;
    EXPECT_GT(diagnosis.solutions, 1) << name;
  }
}

TEST(DiagnoseTest, CountsWhatItDoesNotTry) {
  test::TrialBlock made = test::MakeTrialBlock("earth-asc-desc", 5);
  RandomStream random(1, 2);
  static_cast<void>(test::UnlistedErrors().front().make(&made.block, &random));
  const DiagnosisBounds all{std::numeric_limits<double>::infinity()};
  const Diagnosis whole = Diagnose(made.block, made.options, nullptr, all);
  ASSERT_TRUE(whole.contradicts);
  EXPECT_EQ(whole.untried, 0);
  const Diagnosis none = Diagnose(made.block, made.options, nullptr, {0.0});
  EXPECT_GT(none.untried, 0);
  EXPECT_EQ(none.solutions, 1);  // the sample as it is
  EXPECT_LT(none.work, whole.work);
}

// Work is counted, so that words depend on the block alone.
TEST(DiagnoseTest, SaysTheSameWithAnyNumberOfThreads) {
  for (const auto& [name, mistake] : kDearMistakes) {
    test::TrialBlock made = test::MakeTrialBlock(name, 7);
    RandomStream random(3, 4);
    static_cast<void>(test::PlantNamed(mistake).make(&made.block, &random));
    made.options.threads = 1;
    const Diagnosis one = Diagnose(made.block, made.options);
    made.options.threads = 3;
    const Diagnosis three = Diagnose(made.block, made.options);
    EXPECT_EQ(one.Sentences(), three.Sentences()) << name;
    EXPECT_EQ(one.solutions, three.solutions) << name;
    EXPECT_EQ(one.untried, three.untried) << name;
    EXPECT_EQ(one.work, three.work) << name;
  }
}

// Two routes: the pass alone, and all of them read again.
TEST(DiagnoseTest, ReadsAgainOnlyThePassThatItChanges) {
  const test::TrialBlock made = test::MakeTrialBlock("recorded/airborne-turbulent", 3);
  const auto turn = [](StateVector* state) { state->velocity_mps *= -1.0; };
  Block alone = made.block, all = made.block;
  EditStates(turn, 1, &alone);
  for (StateVector& state : all.passes[1].recorded.states) turn(&state);
  static_cast<void>(ReadRecordedFlights(&all));
  for (std::size_t p = 0; p < all.passes.size(); ++p) {
    const double middle_s = 0.5 * (all.passes[p].start_s + all.passes[p].end_s);
    const auto a = alone.passes[p].path.At(middle_s), b = all.passes[p].path.At(middle_s);
    ASSERT_TRUE(a.has_value() && b.has_value());
    EXPECT_EQ(a->position_m, b->position_m) << p;
    EXPECT_EQ(a->velocity_mps, b->velocity_mps) << p;
  }
}

/// Asks to stop at its n-th call.
class StoppingSink : public ProgressSink {
 public:
  explicit StoppingSink(int calls) : left_(calls) {}
  void Update(std::string_view, std::size_t, std::size_t, std::string_view) override { --left_; }
  [[nodiscard]] bool Cancelled() const override { return left_ < 0; }

 private:
  int left_;
};

TEST(DiagnoseTest, EndsWhereTheUserInterrupts) {
  test::TrialBlock made = test::MakeTrialBlock("earth-asc-desc", 3);
  RandomStream random(1, 2);
  static_cast<void>(test::PlantNamed("times of a pass reversed").make(&made.block, &random));
  for (const int calls : {0, 10, 100}) {
    StoppingSink sink(calls);
    EXPECT_THROW(static_cast<void>(Diagnose(made.block, made.options, &sink)), Interrupted);
  }
}

TEST(DiagnoseTest, TakesBlocksOfWhichNothingCanBeSolved) {
  test::TrialBlock made = test::MakeTrialBlock("earth-asc-desc", 3);
  Block nothing = made.block;
  for (std::uint8_t& flags : nothing.looks.flags) flags |= Looks::kRejected;
  EXPECT_TRUE(Diagnose(nothing, made.options).explanations.empty());
  Block alone = made.block;
  for (std::size_t i = 0; i < alone.looks.size(); ++i) {
    if (alone.looks.pass[i] != 0) alone.looks.flags[i] |= Looks::kRejected;
  }
  static_cast<void>(Diagnose(alone, made.options));
  Block far = made.block;
  for (double& range_m : far.looks.range_m) range_m = 1e-3;
  static_cast<void>(Diagnose(far, made.options));
}

/// A mistake on a block, and the cause that is to stand first.
class MistakesOfPublicReports
    : public ::testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(MistakesOfPublicReports, AreNamedFirst) {
  const auto& [plant, block] = GetParam();
  const test::TrialResult result = test::RunTrial(block, test::PlantNamed(plant), 3);
  std::string said;
  for (const std::string& text : result.diagnosis.Sentences()) said += text + "\n";
  EXPECT_EQ(static_cast<int>(result.outcome), static_cast<int>(Outcome::kFirst)) << said;
}

INSTANTIATE_TEST_SUITE_P(
    Reports,
    MistakesOfPublicReports,
    ::testing::Values(std::pair{"inertial path at any sidereal time", "earth-asc-desc"},
                      std::pair{"inertial path at any sidereal time", "venus-magellan"},
                      std::pair{"one pass inertial", "recorded/sparse-orbit"},
                      std::pair{"coordinates of a map projection", "block-12-strips"},
                      std::pair{"control shifted by one vector", "recorded/sparse-orbit"},
                      std::pair{"control shifted by one vector", "earth-same-side"},
                      std::pair{"sigmas of known points too small", "earth-asc-desc"},
                      std::pair{"sigmas of known points too small", "cross-wise"},
                      std::pair{"seconds of the day at midnight", "moon-alse"},
                      std::pair{"native Doppler read as zero", "earth-asc-desc"},
                      std::pair{"native Doppler read as zero", "cross-wise"}));

/// The first three numbers of a text.
std::vector<double> NumbersOf(const std::string& text) {
  std::vector<double> out;
  const std::regex number("-?[0-9]+(\\.[0-9]+)?");
  for (std::sregex_iterator at(text.begin(), text.end(), number), end; at != end && out.size() < 3;
       ++at) {
    out.push_back(std::stod(at->str()));
  }
  return out;
}

TEST(DiagnoseTest, ReportsTheVectorOfShiftedControl) {
  test::TrialBlock made = test::MakeTrialBlock("recorded/sparse-orbit", 3);
  Block& block = made.block;
  const Eigen::Vector3d shift_enu_m(-140.0, 83.0, 47.0);
  const std::uint32_t first = block.points.known.front().point;
  const Eigen::Matrix3d enu = block.frame.EnuFromFrame(block.points.given_m[first]);
  for (const KnownPosition& known : block.points.known) {
    block.points.given_m[known.point] += enu.transpose() * shift_enu_m;
  }
  const Diagnosis diagnosis = Diagnose(block, made.options);
  ASSERT_FALSE(diagnosis.explanations.empty());
  const Explanation& reported = diagnosis.explanations.front();
  EXPECT_EQ(reported.cause, "control.shift") << reported.sentence;
  const std::vector<double> numbers = NumbersOf(reported.sentence);
  ASSERT_EQ(numbers.size(), 3U) << reported.sentence;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(numbers[axis], shift_enu_m[static_cast<Eigen::Index>(axis)], 3.0)
        << reported.sentence;
  }
}

TEST(DiagnoseTest, ReportsTheScaleOfAMapProjection) {
  // The block of ../shared/data/field/utm, re-made: UTM's scale on its central meridian.
  const std::filesystem::path folder = std::filesystem::path(SARBLOCK_SHARED_DATA) / "field/utm";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  files::ReadOptions reading;
  reading.contradictions = files::Contradictions::kKeep;
  const files::BlockFile file = files::ReadBlock(folder, reading);
  const Diagnosis diagnosis = Diagnose(file.block, file.adjust);
  ASSERT_FALSE(diagnosis.explanations.empty());
  const Explanation& reported = diagnosis.explanations.front();
  EXPECT_EQ(reported.cause, "frame.projection") << reported.sentence;
  EXPECT_NEAR(reported.value, 0.9996, 4.0 * reported.sigma);
  EXPECT_LT(reported.sigma, 1e-4);
  EXPECT_THAT(reported.equals, HasSubstr("UTM"));
}

TEST(DiagnoseTest, ReportsWhenInertialAxesAreThoseOfTheBody) {
  test::TrialBlock made = test::MakeTrialBlock("earth-asc-desc", 3);
  constexpr double kRate = 7.292115e-5, kAligned_s = 8.9;
  Block& block = made.block;
  for (std::uint32_t pass = 0; pass < block.passes.size(); ++pass) {
    std::vector<StateVector> states = block.passes[pass].RecordedStates();
    for (StateVector& state : states) {
      const Eigen::AngleAxisd turn(kRate * (state.time_s - kAligned_s), Eigen::Vector3d::UnitZ());
      state.velocity_mps =
          turn * (state.velocity_mps + kRate * Eigen::Vector3d::UnitZ().cross(state.position_m));
      state.position_m = turn * state.position_m;
    }
    test::ReplaceStates(std::move(states), pass, &block);
  }
  EXPECT_THAT([&] { RequireBodyFixedStates(block); },
              ::testing::ThrowsMessage<InputError>(
                  HasSubstr("move as in axes that do not turn with the body")));
  const Diagnosis diagnosis = Diagnose(block, made.options);
  ASSERT_FALSE(diagnosis.explanations.empty());
  const Explanation& reported = diagnosis.explanations.front();
  EXPECT_EQ(reported.cause, "path.inertial") << reported.sentence;
  EXPECT_NEAR(reported.value, kAligned_s, 4.0 * reported.sigma);
  EXPECT_LT(reported.sigma, 0.05);
}

// Simulated about a body that does not turn a block is a good one: the motion alone refuses none.
TEST(DiagnoseTest, KeepsABlockAboutABodyThatDoesNotTurn) {
  Scene scene =
      files::ReadScene(std::filesystem::path(SARBLOCK_DATASETS) / "scenes" / "earth-asc-desc.toml");
  scene.rotation_rad_per_s = 0.0;
  const SimulatedBlock made = Simulate(scene);
  EXPECT_THAT(ExaminePlausibility(made.block),
              ::testing::Each(HasSubstr("unless the body does not turn in this block")));
  EXPECT_NO_THROW(RequireBodyFixedStates(made.block));
}

}  // namespace
}  // namespace sarblock
