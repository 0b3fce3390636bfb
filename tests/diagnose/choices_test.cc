// SPDX-License-Identifier: Apache-2.0
// Blocks without a mistake whose corrections and priors are as users choose them: what is good is
// accepted, and what was chosen wrongly is said first. A part of the grid of docs/validation.md.
#include "sarblock/adjust/adjust.h"
#include "sarblock/diagnose/diagnose.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "support/scene_blocks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

AdjustOptions Polynomial(int degree, double prior_m) {
  PositionCorrection position;
  position.degree = degree;
  position.prior_sigma_m.fill({prior_m});
  AdjustOptions options;
  options.corrections = CorrectionChoice::kGiven;
  options.groups = {{"position", position, {}, false}};
  return options;
}

test::SceneBlock MadeScene(const std::string& name, const std::vector<std::string>& sets = {}) {
  std::vector<std::string> all{"points.count=150"};
  all.insert(all.end(), sets.begin(), sets.end());
  return test::SimulatedSceneBlock("scenes", name, all);
}

struct Explained {
  AdjustResult result;
  Diagnosis diagnosis;
  [[nodiscard]] std::string cause() const {
    return diagnosis.explanations.empty() ? "" : diagnosis.explanations.front().cause;
  }
  [[nodiscard]] std::string first() const {
    return result.assessment.reasons.empty() ? "" : result.assessment.reasons.front();
  }
};

Explained Explain(const Block& block, const AdjustOptions& options) {
  Explained out;
  out.result = Adjust(block, options);
  if (auto diagnosis = ExplainFailure(block, options, {}, &out.result)) {
    out.diagnosis = std::move(*diagnosis);
  }
  return out;
}

// More terms than the errors have, and priors far wider: every such block was said to have standard
// deviations that are too large.
TEST(ChoicesTest, MoreTermsAndWiderPriorsThanNeededAreAccepted) {
  // Not with its own seed, whose noise is that of one good block in fifty (docs/scenes.md).
  const std::vector<std::pair<const char*, std::vector<std::string>>> scenes = {
      {"block-12-strips", {}}, {"earth-asc-desc", {"seed=1"}}, {"convergent-squint", {}}};
  for (const auto& [name, set] : scenes) {
    const test::SceneBlock scene = MadeScene(name, set);
    for (const int degree : {1, 2, 4}) {
      for (const double prior_m : {100.0, 1000.0}) {
        const AdjustResult result = Adjust(scene.block, Polynomial(degree, prior_m));
        EXPECT_THAT(result.assessment.reasons, IsEmpty())
            << name << ' ' << degree << ' ' << prior_m << " m, s0^2 " << result.sigma0_squared;
      }
    }
  }
}

// leberl-aircraft flies up to 142 m beside its recorded paths.
TEST(ChoicesTest, PriorsThatAreTooTightAreNamedWithTheirFactor) {
  const test::SceneBlock scene = MadeScene("leberl-aircraft");
  const Explained tight = Explain(scene.block, Polynomial(0, 3.0));
  EXPECT_EQ(tight.cause(), "model.priors") << tight.first();
  EXPECT_THAT(tight.first(), HasSubstr("times too tight"));
  ASSERT_FALSE(tight.diagnosis.explanations.empty());
  const Explanation& first = tight.diagnosis.explanations.front();
  EXPECT_TRUE(first.cure.cures) << first.sentence;
  // The paths are off by 30, 100 and 10 m (standard deviations of the scene).
  EXPECT_GT(first.value, 10.0 / 3.0);
  EXPECT_LT(first.value, 100.0 / 3.0);
}

// The steps of a stiff process are sigma sqrt(2 h / T) where T is long, and what the flights do
// asks for one size of them: with T ten times as long the priors are sqrt(10) times tighter. As
// many times as large as their own standard deviations the coefficients themselves would be in
// both.
TEST(ChoicesTest, AProcessThatIsTooStiffIsTooTightByItsSteps) {
  const test::SceneBlock scene = MadeScene("convergent-squint");
  double longest_s = 0.0;
  for (const Pass& pass : scene.block.passes) {
    longest_s = std::max(longest_s, pass.end_s - pass.start_s);
  }
  std::vector<double> factors;
  for (const double strips : {1e4, 1e5}) {
    PositionCorrection position;
    position.basis = PositionCorrection::Basis::kSpline;
    position.knot_spacing_s = longest_s / 7.0;
    position.prior_sigma_m.fill({30.0});
    position.process = PositionCorrection::Process::kGaussMarkov;
    position.correlation_time_s = strips * longest_s;
    AdjustOptions options;
    options.corrections = CorrectionChoice::kGiven;
    options.groups = {{"position", position, {}, false}};
    const Explained stiff = Explain(scene.block, options);
    ASSERT_EQ(stiff.cause(), "model.priors") << strips << ": " << stiff.first();
    factors.push_back(stiff.diagnosis.explanations.front().value);
  }
  EXPECT_NEAR(factors[1] / factors[0], std::sqrt(10.0), 0.1);
}

TEST(ChoicesTest, KilometresForMetresAreHundredsOfTimesTooTight) {
  const test::SceneBlock scene = MadeScene("leberl-voir");
  const Explained wrong = Explain(scene.block, Polynomial(0, 0.3));
  ASSERT_EQ(wrong.cause(), "model.priors") << wrong.first();
  // The paths are off by 300, 1000 and 100 m (standard deviations of the scene).
  const double factor = wrong.diagnosis.explanations.front().value;
  EXPECT_GT(factor, 100.0 / 0.3);
  EXPECT_LT(factor, 1000.0 / 0.3);
}

TEST(ChoicesTest, ADriftWithoutATermIsADegreeTooLow) {
  for (const char* name : {"block-12-strips", "convergent-squint"}) {
    const Explained low = Explain(MadeScene(name).block, Polynomial(0, 100.0));
    EXPECT_EQ(low.cause(), "model.degree") << name << ": " << low.first();
    EXPECT_THAT(low.first(), Not(HasSubstr("standard deviations of the ranges"))) << name;
  }
}

TEST(ChoicesTest, FlightsWithoutCorrectionsAreSaidToNeedThem) {
  for (const char* name : {"block-12-strips", "convergent-squint"}) {
    const Explained none = Explain(MadeScene(name).block, {});
    EXPECT_EQ(none.cause(), "model.missing") << name << ": " << none.first();
  }
}

// A spline so free that no solution is found, while residuals are those of a good block: no mistake
// of the input is named for it.
TEST(ChoicesTest, TooFreeAFlightIsNoMistakeOfAPoint) {
  const test::SceneBlock scene =
      test::SimulatedSceneBlock("scenes", "opposite-side", {"seed=1", "points.count=40"});
  AdjustOptions options = Polynomial(0, 1000.0);
  auto& spline = std::get<PositionCorrection>(options.groups.front().model);
  spline.basis = PositionCorrection::Basis::kSpline;
  spline.knot_spacing_s = 6.44;
  const Explained of = Explain(scene.block, options);
  EXPECT_EQ(of.result.status, AdjustStatus::kNotConverged);
  EXPECT_THAT(of.result.assessment.reasons,
              ElementsAre(AllOf(HasSubstr("not converged: "), HasSubstr(" has no value: "))));
  EXPECT_THAT(of.diagnosis.explanations, IsEmpty());
}

// Noise alone: twice what is stated, which an explanation cures.
TEST(ChoicesTest, NoiseIsAStandardDeviationAndItCures) {
  const test::SceneBlock scene = MadeScene("block-12-strips", {"looks.noise_scale=2"});
  const Explained noisy = Explain(scene.block, Polynomial(1, 100.0));
  EXPECT_THAT(noisy.cause(), HasSubstr("sigma")) << noisy.first();
  ASSERT_FALSE(noisy.diagnosis.explanations.empty());
  EXPECT_TRUE(noisy.diagnosis.explanations.front().cure.cures) << noisy.first();
  // By the whole block, whose seed draws noise that is low (docs/scenes.md).
  const Explanation& first = noisy.diagnosis.explanations.front();
  EXPECT_LT(first.sigma, 0.03);
  EXPECT_NEAR(first.value, 0.5, 4.0 * first.sigma);
}

}  // namespace
}  // namespace sarblock
