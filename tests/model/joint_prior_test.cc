// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

#include <functional>
#include <string>
#include <vector>

#include "model/parameters.h"
#include "model/priors.h"
#include "support/joint_priors.h"
#include "support/small_blocks.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sarblock {
namespace {

using testing::HasSubstr;

const std::vector<std::string> kPasses{"A1", "A2", "B7"};

AdjustOptions Joint() { return test::WithJointPrior(PositionCorrection::Axes::kTrack, 11); }

struct Refused {
  std::string field;
  int entry = -1;
  std::string says;
  std::function<void(AdjustOptions*)> edit;
};

JointPrior& PriorOf(AdjustOptions* options) { return options->priors[0]; }

std::vector<Refused> RefusedPriors() {
  const auto own_sigma = [](AdjustOptions* o) {
    std::get<RangeCorrection>(o->groups[1].model).bias_prior_sigma_m = 0.5;
  };
  const auto singular = [](AdjustOptions* o) {
    Eigen::MatrixXd q = PriorOf(o).covariance.matrix();
    q.row(1) = 2.0 * q.row(0);
    q.col(1) = 2.0 * q.col(0);
    q(1, 1) = 4.0 * q(0, 0);
    PriorOf(o).covariance = q;
  };
  const auto indefinite = [](AdjustOptions* o) {
    PriorOf(o).covariance = Eigen::MatrixXd::Identity(7, 7);
    PriorOf(o).covariance(4, 2) = PriorOf(o).covariance(2, 4) = 1.5;
  };
  const auto sigmas = [](AdjustOptions* o) {
    PriorOf(o).covariance = {};
    PriorOf(o).sigma.assign(7, 0.7);
    PriorOf(o).correlation = Eigen::MatrixXd::Identity(7, 7);
  };
  return {
      {"passes",
       1,
       "no pass 'B8' in the block",
       [](auto* o) {
         PriorOf(o).passes = {"A1", "B8"};
       }},
      {"parameters",
       6,
       "did you mean range.bias?",
       [](auto* o) { PriorOf(o).parameters[6] = "range.bia"; }},
      {"parameters",
       6,
       "allowed are position.along.0",
       [](auto* o) { PriorOf(o).parameters[6] = "squint.bias"; }},
      {"parameters", 6, "is shared with other passes", [](auto* o) { o->groups[1].shared = true; }},
      {"parameters",
       0,
       "coefficients of a spline",
       [](auto* o) {
         auto& position = std::get<PositionCorrection>(o->groups[0].model);
         position.basis = PositionCorrection::Basis::kSpline;
         position.knot_spacing_s = 3.0;
       }},
      {"parameters", 6, "has a standard deviation of its own", own_sigma},
      {"parameters",
       3,
       "is given twice",
       [](auto* o) { PriorOf(o).parameters[3] = "position.up.0"; }},
      {"parameters",
       6,
       "pass 'B7' has no parameter 'range.bias'",
       [](auto* o) {
         o->groups[1].passes = {"A1", "A2"};
       }},
      {"parameters",
       0,
       "in another joint prior too",
       [](auto* o) {
         JointPrior other = PriorOf(o);
         other.name = "again";
         other.passes = {"A2"};
         o->priors.push_back(other);
       }},
      {"parameters", -1, "is empty", [](auto* o) { PriorOf(o).parameters.clear(); }},
      {"parameters", 0, "it has none of its own", [](auto* o) { o->groups.clear(); }},
      {"parameters",
       -1,
       "degree 1 of the position has 2 axes",
       [](auto* o) {
         JointPrior& prior = PriorOf(o);
         prior.axes = JointPrior::Axes::kFrame;
         prior.parameters = {
             "position.x.0", "position.y.0", "position.z.0", "position.x.1", "position.y.1"};
         prior.covariance = Eigen::MatrixXd::Identity(5, 5);
       }},
      {"parameters",
       0,
       "is no degree along the axes given",
       [](auto* o) {
         PriorOf(o).axes = JointPrior::Axes::kTrack;
         PriorOf(o).parameters[0] = "position.x.0";
       }},
      {"covariance",
       -1,
       "is 6 by 6, one row and one column",
       [](auto* o) {
         PriorOf(o).covariance = PriorOf(o).covariance.matrix().topLeftCorner(6, 6).eval();
       }},
      {"covariance", -1, "is not symmetric", [](auto* o) { PriorOf(o).covariance(5, 1) += 1e-6; }},
      {"covariance", -1, "of the variance of 'position.across.0' is left", singular},
      {"covariance",
       -1,
       "is not positive definite: beside the parameters before it -1.25 of the "
       "variance of 'position.across.1' is left",
       indefinite},
      {"covariance",
       -1,
       "the variance of 'position.across.1' is 0",
       [](auto* o) { PriorOf(o).covariance(4, 4) = 0.0; }},
      {"covariance", -1, "is not given", [](auto* o) { PriorOf(o).covariance = {}; }},
      {"covariance",
       -1,
       "excludes sigma and correlation",
       [](auto* o) { PriorOf(o).sigma.assign(7, 1.0); }},
      {"sigma",
       -1,
       "has 6 entries",
       [sigmas](auto* o) {
         sigmas(o);
         PriorOf(o).sigma.resize(6);
       }},
      {"sigma",
       2,
       "must be a number above 0, got -0.3",
       [sigmas](auto* o) {
         sigmas(o);
         PriorOf(o).sigma[2] = -0.3;
       }},
      {"correlation",
       3,
       "has 0.9 on its diagonal",
       [sigmas](auto* o) {
         sigmas(o);
         PriorOf(o).correlation(3, 3) = 0.9;
       }},
  };
}

TEST(JointPriorBindingTest, RefusesWhatDoesNotFit) {
  ASSERT_FALSE(BindJointPriors(kPasses, Joint().groups, Joint().priors).problem.has_value());
  for (const Refused& refused : RefusedPriors()) {
    SCOPED_TRACE(refused.says);
    AdjustOptions options = Joint();
    refused.edit(&options);
    const JointPriorBindings bindings = BindJointPriors(kPasses, options.groups, options.priors);
    ASSERT_TRUE(bindings.problem.has_value());
    EXPECT_EQ(bindings.problem->field, refused.field);
    EXPECT_EQ(bindings.problem->entry, refused.entry);
    EXPECT_THAT(bindings.problem->problem, HasSubstr(refused.says));
    EXPECT_TRUE(bindings.bound.empty());
  }
}

TEST(JointPriorBindingTest, IsOfThePassesThatHaveItsParameters) {
  AdjustOptions options = Joint();
  for (CorrectionGroup& group : options.groups) group.passes = {"A1", "B7"};
  const JointPriorBindings bindings = BindJointPriors(kPasses, options.groups, options.priors);
  ASSERT_FALSE(bindings.problem.has_value());
  ASSERT_EQ(bindings.bound.size(), 2U);
  EXPECT_EQ(bindings.bound[0].pass, 0U);
  EXPECT_EQ(bindings.bound[1].pass, 2U);
}

// Hand arithmetic: parameters in another order than the columns, the diagonal's roots as sigmas.
TEST(JointPriorLayoutTest, StandsInTheBlockOfItsPass) {
  test::KnownBlock known = test::MakeBlock(test::AircraftPlan());
  RangeCorrection range;
  range.bias = range.scale = true;
  range.scale_prior_sigma = 3e-6;
  JointPrior prior;
  prior.name = "radar";
  prior.parameters = {"time.bias", "range.bias"};
  prior.sigma = {0.25, 4.0};
  prior.correlation = Eigen::Matrix2d{{1.0, -0.6}, {-0.6, 1.0}};
  const ParameterLayout layout = MakeParameterLayout(
      known.block, {{"range", range, {}, false}, {"time", TimeCorrection{}, {}, false}}, {prior});
  ASSERT_EQ(layout.joint_priors.size(), known.block.passes.size());
  const JointPriorTerm& second = layout.joint_priors[1];
  EXPECT_EQ(second.owner, known.block.passes[1].id);
  EXPECT_EQ(second.parameters, (std::vector<int>{5, 3}));
  EXPECT_EQ(layout.parameters[5].prior_sigma, 0.25);
  EXPECT_EQ(layout.parameters[3].prior_sigma, 4.0);
  EXPECT_TRUE(layout.parameters[4].has_own_prior());
  EXPECT_FALSE(layout.parameters[5].has_own_prior());
  // L = [0.25, 0; -2.4, 3.2], L^-1 = [4, 0; 3, 0.3125].
  Eigen::Matrix2d whitening;
  whitening << 4.0, 0.0, 3.0, 0.3125;
  EXPECT_LT((second.whitening - whitening).norm(), 1e-14);
  EXPECT_LT((second.information - whitening.transpose() * whitening).norm(), 1e-13);
  const std::vector<PriorRow> rows = PriorRowsOf(layout, second.block);
  ASSERT_EQ(rows.size(), 3U);  // the scale by itself, then two rows of the joint prior
  EXPECT_EQ(rows[0].terms[0].parameter, 4);
  EXPECT_EQ(rows[2].terms[1].parameter, 3);
  EXPECT_NEAR(rows[2].terms[1].weight, 0.3125, 1e-15);
}

TEST(JointPriorLayoutTest, NamesTheFieldThatIsWrong) {
  const test::KnownBlock known = test::MakeBlock(test::AircraftPlan());
  AdjustOptions options = Joint();
  options.priors[0].covariance(0, 0) = -1.0;
  try {
    (void)MakeParameterLayout(known.block, options.groups, options.priors);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("prior.path.covariance: the variance of"));
  }
}

}  // namespace
}  // namespace sarblock
