// SPDX-License-Identifier: Apache-2.0
// Calls of the library from a program that has threads, loops and options of its own (docs/api.md,
// "What a call does to your process").
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"

#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "core/threads.h"
#include "support/small_blocks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

namespace sarblock {
namespace {

using testing::HasSubstr;

/// A dozen points in four passes, with noise, control and a check point.
test::KnownBlock SomeBlock(std::uint64_t seed = 12) {
  test::KnownBlock known = test::MakeBlock(test::AircraftPlan());
  for (const std::size_t point : {0U, 3U, 5U}) test::AddKnownPoint(point, {0.2, 0.3, 0.4}, &known);
  test::AddKnownPoint(8, {0.2, 0.2, 0.2}, &known, PointRole::kCheck);
  test::AddNoise(seed, 1.0, &known);
  return known;
}

/// A constant a pass.
AdjustOptions SomeOptions() {
  AdjustOptions options;
  options.groups = {{"position", PositionCorrection{}, {}, false}};
  options.pairs = PairChoice::kNeighbours;
  return options;
}

/// Everything of a result that two runs have alike to the bit.
std::vector<double> NumbersOf(const AdjustResult& result) {
  std::vector<double> out{result.sigma0_squared, result.final_cost, result.condition};
  for (const Eigen::Vector3d& p : result.points.position_m)
    out.insert(out.end(), p.begin(), p.end());
  for (const SymmetricEnu& c : result.points.covariance_m2)
    out.insert(out.end(), c.begin(), c.end());
  for (const PairResult& pair : result.pairs) {
    out.insert(out.end(), pair.covariance_m2.begin(), pair.covariance_m2.end());
  }
  for (const ParameterResult& p : result.parameters) out.insert(out.end(), {p.value, p.sigma});
  for (const ParameterCovariance& c : result.parameter_covariance) out.push_back(c.covariance);
  return out;
}

// Second route: each alone.
TEST(HostTest, AdjustmentsAtOnceAreThoseAlone) {
  const test::KnownBlock shared = SomeBlock(), other = SomeBlock(13);
  const AdjustOptions options = SomeOptions();
  const std::vector<double> alone = NumbersOf(Adjust(shared.block, options));
  const std::vector<double> other_alone = NumbersOf(Adjust(other.block, options));
  ASSERT_NE(alone, other_alone);
  std::array<std::vector<double>, 6> found;
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < found.size(); ++i) {
    threads.emplace_back([&, i] {
      AdjustOptions own = options;
      own.threads = static_cast<int>(i % 3);  // all, one, two
      found[i] = NumbersOf(Adjust(i % 2 == 0 ? shared.block : other.block, own));
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i], i % 2 == 0 ? alone : other_alone) << i;
  }
}

/// Threads that a loop of the process may take, as TBB says it.
std::size_t OfTheProcess() {
  return tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
}

/// Has another thread look at the process while an adjustment runs.
class Watching final : public ProgressSink {
 public:
  void Update(std::string_view, std::size_t, std::size_t, std::string_view) override {
    inside_ = std::max(inside_, ThreadsAllowed());
    std::thread([this] {
      least_ = std::min({least_, OfTheProcess(), static_cast<std::size_t>(ThreadsAllowed())});
    }).join();
  }
  [[nodiscard]] bool Cancelled() const override { return false; }
  [[nodiscard]] std::size_t least() const { return least_; }
  [[nodiscard]] int inside() const { return inside_; }

 private:
  std::size_t least_ = 1000000;
  int inside_ = 0;
};

TEST(HostTest, ThreadsLimitTheCallAndNothingElse) {
  const std::size_t before = OfTheProcess();
  const int own = ThreadsAllowed();
  AdjustOptions options = SomeOptions();
  options.threads = 1;
  Watching sink;
  EXPECT_TRUE(Adjust(SomeBlock().block, options, {}, &sink).usable());
  EXPECT_EQ(sink.inside(), 1);
  EXPECT_EQ(sink.least(), std::min(before, static_cast<std::size_t>(own)));
  EXPECT_EQ(OfTheProcess(), before);
  // Within an arena of the caller's it takes no more than that has.
  options.threads = 0;
  Watching within;
  tbb::task_arena(1).execute(
      [&] { static_cast<void>(Adjust(SomeBlock().block, options, {}, &within)); });
  EXPECT_EQ(within.inside(), 1);
}

/// Asks to stop from the n-th question on, whoever asks.
class StopsAt final : public ProgressSink {
 public:
  explicit StopsAt(int at) : at_(at) {}
  void Update(std::string_view, std::size_t, std::size_t, std::string_view) override {
    asked_of_last_ = asked_.load();
  }
  [[nodiscard]] bool Cancelled() const override { return ++asked_ > at_; }
  [[nodiscard]] int asked() const { return asked_; }
  [[nodiscard]] int asked_after_last_update() const { return asked_ - asked_of_last_; }

 private:
  int at_;
  mutable std::atomic<int> asked_{0};
  int asked_of_last_ = 0;
};

// The definition: whenever it is asked, a call that is asked to stop stops, and it is asked in the
// loops after the last stage too.
TEST(HostTest, AStopIsSeenUntilTheEnd) {
  const test::KnownBlock known = SomeBlock();
  AdjustOptions options = SomeOptions();
  options.threads = 1;
  StopsAt never(1000000);
  ASSERT_TRUE(Adjust(known.block, options, {}, &never).usable());
  ASSERT_GT(never.asked(), 20);
  EXPECT_GT(never.asked_after_last_update(), 1);
  for (int at = 0; at < never.asked(); ++at) {
    StopsAt sink(at);
    EXPECT_THROW(static_cast<void>(Adjust(known.block, options, {}, &sink)), Interrupted) << at;
  }
  const std::vector<Eigen::Vector3d>& truth_m = known.truth_m;
  for (int at = 0; at < 3; ++at) {
    StopsAt predicting(at), intersecting(at), checking(at);
    EXPECT_THROW(static_cast<void>(Predict(known.block, options, truth_m, {}, &predicting)),
                 Interrupted);
    EXPECT_THROW(static_cast<void>(IntersectBlock(known.block, options, &intersecting)),
                 Interrupted);
    EXPECT_THROW(static_cast<void>(CheckBlock(known.block, options, &checking)), Interrupted);
  }
}

// Hand count: three constants for each of four passes.
TEST(HostTest, GroupsThatAreGivenCount) {
  AdjustOptions options;
  EXPECT_TRUE(Adjust(SomeBlock().block, options).parameters.empty());
  options.groups = {{"position", PositionCorrection{}, {}, false}};
  EXPECT_EQ(Adjust(SomeBlock().block, options).parameters.size(), 12U);
  options.corrections = CorrectionChoice::kNone;
  EXPECT_TRUE(Adjust(SomeBlock().block, options).parameters.empty());
}

TEST(HostTest, PairsThatAreHandedOverCount) {
  const test::KnownBlock known = SomeBlock();
  AdjustOptions options = SomeOptions();
  options.pairs = PairChoice::kNone;
  const PointPairs pairs{{1, 2}, {9, 4}};
  for (const AdjustResult& result :
       {Adjust(known.block, options, pairs), Predict(known.block, options, known.truth_m, pairs)}) {
    ASSERT_EQ(result.pairs.size(), 2U);
    EXPECT_EQ(result.pairs[1].a, 9U);
    EXPECT_EQ(result.pairs[1].b, 4U);
    EXPECT_GT(result.pairs[1].covariance_m2[0], 0.0);
  }
  options.pairs = PairChoice::kAll;
  try {
    static_cast<void>(Adjust(known.block, options, pairs));
    ADD_FAILURE() << "two choices at once";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("options.pairs"));
  }
}

// The definition: covariances times s0^2, standard deviations times s0, tests as without.
TEST(HostTest, ScalingByThePosteriorFactorScalesTheResult) {
  const test::KnownBlock known = SomeBlock();
  AdjustOptions options = SomeOptions();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::get<PositionCorrection>(options.groups[0].model).prior_sigma_m[axis] = {5.0};
  }
  const AdjustResult given = Adjust(known.block, options);
  options.scale_by_posterior = true;
  const AdjustResult scaled = Adjust(known.block, options);
  const double factor = given.sigma0_squared;
  ASSERT_GT(std::abs(factor - 1.0), 0.02) << "nothing would be scaled";
  EXPECT_EQ(given.posterior_factor, 1.0);
  EXPECT_EQ(scaled.posterior_factor, factor);
  for (std::size_t point = 0; point < known.block.points.size(); ++point) {
    for (std::size_t k = 0; k < 6; ++k) {
      EXPECT_DOUBLE_EQ(scaled.points.covariance_m2[point][k],
                       factor * given.points.covariance_m2[point][k]);
      EXPECT_DOUBLE_EQ(scaled.points.fixed_path_covariance_m2[point][k],
                       factor * given.points.fixed_path_covariance_m2[point][k]);
    }
  }
  ASSERT_EQ(scaled.parameters.size(), 12U);
  for (std::size_t i = 0; i < 12; ++i) {
    EXPECT_DOUBLE_EQ(scaled.parameters[i].sigma, std::sqrt(factor) * given.parameters[i].sigma);
    EXPECT_EQ(scaled.parameters[i].prior_sigma, 5.0);
  }
  for (std::size_t i = 0; i < given.parameter_covariance.size(); ++i) {
    EXPECT_DOUBLE_EQ(scaled.parameter_covariance[i].covariance,
                     factor * given.parameter_covariance[i].covariance);
  }
  for (std::size_t i = 0; i < given.pairs.size(); ++i) {
    EXPECT_DOUBLE_EQ(scaled.pairs[i].covariance_m2[2], factor * given.pairs[i].covariance_m2[2]);
  }
  for (std::size_t i = 0; i < given.strips.size(); ++i) {
    EXPECT_DOUBLE_EQ(scaled.strips[i].correction_sigma_m[1],
                     std::sqrt(factor) * given.strips[i].correction_sigma_m[1]);
  }
  EXPECT_EQ(scaled.assessment.priors.redundancy, given.assessment.priors.redundancy);
  EXPECT_EQ(scaled.sigma0_squared, given.sigma0_squared);
}

TEST(HostTest, AFailedTestIsUsableAndNotAccepted) {
  test::KnownBlock known = SomeBlock();
  test::AddNoise(5, 1.5, &known);  // 1.8 times as much as stated
  const AdjustResult result = Adjust(known.block, SomeOptions());
  ASSERT_EQ(result.assessment.verdict, Verdict::kTestsFailed);
  EXPECT_TRUE(result.usable());
  EXPECT_FALSE(result.accepted());
  EXPECT_TRUE(Adjust(SomeBlock().block, SomeOptions()).accepted());
}

}  // namespace
}  // namespace sarblock
