// SPDX-License-Identifier: Apache-2.0
#include "statistics/scene_statistics.h"

#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"
#include "sarblock/files/block_file.h"
#include "sarblock/files/scene_file.h"
#include "sarblock/model/result.h"
#include "sarblock/simulate/scene.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <string>
#include <string_view>
#include <utility>

#include <Eigen/Cholesky>

namespace sarblock::test {
namespace {

constexpr std::uint64_t kChoiceStream = 4177;

/// e' Q^-1 e; NaN, which no interval contains, where Q is not positive definite.
double NormalisedSquare(const Eigen::VectorXd& e, const Eigen::MatrixXd& Q) {
  const Eigen::LLT<Eigen::MatrixXd> factor(Q);
  if (factor.info() != Eigen::Success) return kNotGiven;
  return factor.matrixL().solve(e).squaredNorm();
}

/// The drawn value of a correction. Adding the drawn errors to the nominal path and measurements
/// gives the truth, so estimated corrections estimate them with their sign.
double TrueValue(const PassError& error, const std::string& parameter) {
  constexpr std::array<std::string_view, 3> kAxes = {"along", "across", "up"};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string stem = "position." + std::string(kAxes[axis]);
    if (!error.spline_m[axis].empty() && parameter.starts_with(stem + ".")) {
      const std::size_t coefficient = std::stoul(parameter.substr(stem.size() + 1));
      return error.constant_m[axis] + error.spline_m[axis].at(coefficient);  // they sum to one
    }
    if (parameter == stem + ".0") return error.constant_m[axis];
    if (parameter == stem + ".1") return error.drift_m[axis];
  }
  throw InputError("parameter", "no scene draws a " + parameter);
}

const PassError& ErrorOf(const SimulatedBlock& simulated, const std::string& owner) {
  for (std::size_t i = 0; i < simulated.block.passes.size(); ++i) {
    if (simulated.block.passes[i].id == owner) return simulated.errors[i];
  }
  throw InputError("parameter", "no pass " + owner);
}

double CorrectionSquare(const SimulatedBlock& simulated,
                        const AdjustResult& result,
                        std::vector<SquareSum>* each) {
  const auto count = static_cast<Eigen::Index>(result.parameters.size());
  Eigen::VectorXd error(count);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const ParameterResult& parameter = result.parameters[static_cast<std::size_t>(i)];
    error[i] = parameter.value - TrueValue(ErrorOf(simulated, parameter.owner), parameter.name);
    const double w = error[i] / parameter.sigma;
    (*each)[static_cast<std::size_t>(i)].Add(w * w, 1.0);
  }
  for (const ParameterCovariance& entry : result.parameter_covariance) {
    covariance(entry.a, entry.b) = covariance(entry.b, entry.a) = entry.covariance;
  }
  return NormalisedSquare(error, covariance);
}

/// Indices of the points of a role.
std::vector<std::uint32_t> PointsOf(const Points& points, PointRole role) {
  std::vector<std::uint32_t> found;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points.role[i] == role) found.push_back(static_cast<std::uint32_t>(i));
  }
  return found;
}

std::size_t ChooseOf(std::size_t count, RandomStream* random) {
  return std::min(count - 1,
                  static_cast<std::size_t>(random->Uniform() * static_cast<double>(count)));
}

double PointSquare(const SimulatedBlock& simulated, const AdjustResult& result, std::size_t i) {
  const Eigen::Vector3d& p_m = result.points.position_m[i];
  const Eigen::Vector3d error_m =
      simulated.block.frame.EnuFromFrame(p_m) * (p_m - simulated.truth.points_m[i]);
  return NormalisedSquare(error_m, MatrixOf(result.points.covariance_m2[i]));
}

double PairSquare(const SimulatedBlock& simulated, const AdjustResult& result) {
  const PairResult& pair = result.pairs.at(0);
  const Eigen::Vector3d true_difference_m =
      simulated.truth.points_m[pair.b] - simulated.truth.points_m[pair.a];
  const Eigen::Vector3d error_m =
      pair.difference_enu_m -
      simulated.block.frame.EnuFromFrame(result.points.position_m[pair.a]) * true_difference_m;
  return NormalisedSquare(error_m, MatrixOf(pair.covariance_m2));
}

}  // namespace

Scene ShippedScene(const std::string& name, const std::vector<std::string>& overrides) {
  return files::ReadScene(std::string(SARBLOCK_DATASETS) + "/scenes/" + name + ".toml", overrides);
}

AdjustOptions OptionsOf(const Scene& scene, const Block& block) {
  std::vector<std::string> passes;
  for (const Pass& pass : block.passes) passes.push_back(pass.id);
  AdjustOptions options = files::ReadAdjustTable(scene.adjust_toml, scene.name, passes);
  options.threads = 1;
  return options;
}

SceneStatistics RunDraws(const Scene& scene,
                         std::size_t draws,
                         std::uint64_t first_seed,
                         const std::function<void(Block*)>& edit) {
  SimulatedBlock simulated = Simulate(scene);
  const Block& block = simulated.block;
  AdjustOptions options = OptionsOf(scene, block);
  options.pairs = PairChoice::kList;
  const std::vector<std::uint32_t> ties = PointsOf(block.points, PointRole::kTie);
  if (ties.size() < 2) throw InputError("points", "fewer than two tie points");

  SceneStatistics sums;
  sums.draws = draws;
  sums.each_point.resize(ties.size());
  for (std::size_t draw = 0; draw < draws; ++draw) {
    const std::uint64_t seed = first_seed + draw;
    Redraw(scene, seed, RedrawChoice{}, &simulated);
    RandomStream random(seed, kChoiceStream);
    const std::size_t a = ChooseOf(ties.size(), &random);
    const std::size_t b = (a + 1 + ChooseOf(ties.size() - 1, &random)) % ties.size();
    Block reported = block;
    if (edit) edit(&reported);
    const AdjustResult result = Adjust(reported, options, {{ties[a], ties[b]}});

    sums.accepted += result.usable() ? 1u : 0u;
    const std::vector<std::string>& reasons = result.assessment.reasons;
    sums.alarms += std::any_of(reasons.begin(), reasons.end(), [](const std::string& reason) {
      return reason.starts_with("tests of observations") || reason.starts_with("priors");
    });
    for (const PointStatus status : result.points.status) {
      sums.unsolved += status == PointStatus::kAdjusted ? 0u : 1u;
    }
    for (std::size_t i = 0; i < ties.size(); ++i) {
      const double square = PointSquare(simulated, result, ties[i]);
      sums.each_point[i].Add(square, 3.0);
      if (i == a) sums.point.Add(square, 3.0);
    }
    sums.pair.Add(PairSquare(simulated, result), 3.0);
    if (!result.checks.empty()) {
      const CheckResult& check = result.checks[ChooseOf(result.checks.size(), &random)];
      sums.check.Add(check.chi_square, check.components);
    }
    if (!result.parameters.empty()) {
      sums.each_parameter.resize(result.parameters.size());
      sums.corrections.Add(CorrectionSquare(simulated, result, &sums.each_parameter),
                           static_cast<double>(result.parameters.size()));
    }
    if (draw == 0) {
      for (const ParameterResult& p : result.parameters) {
        sums.parameters.push_back(p.owner + " " + p.name);
      }
    }
    sums.residuals.Add(2.0 * result.final_cost, result.redundancy());
  }
  return sums;
}

std::size_t DrawsAsked() {
  const char* text = std::getenv("SARBLOCK_DRAWS");
  if (text == nullptr) return 200;
  const std::string_view view(text);
  std::size_t draws = 0;
  const auto [end, error] = std::from_chars(view.data(), view.data() + view.size(), draws);
  if (error != std::errc() || end != view.data() + view.size() || draws == 0) {
    throw InputError("SARBLOCK_DRAWS", "'" + std::string(view) + "' is no whole number above 0");
  }
  return draws;
}

}  // namespace sarblock::test
