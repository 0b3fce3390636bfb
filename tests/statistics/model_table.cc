// SPDX-License-Identifier: Apache-2.0
// Run by hand: models of corrections that users choose, on shipped scenes, with both engines: how
// many do not converge, how many steps they take, and where the engines differ. Tables of
// docs/performance.md and docs/validation.md.
//
//     model_table [--scenes TEXT] [--seeds 1,2,3] [--points N] [--verbose]
//
// of the scenes whose names contain TEXT (default: recorded/).
#include "sarblock/adjust/adjust.h"
#include "sarblock/simulate/simulate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "statistics/scene_statistics.h"

namespace {

using namespace sarblock;

struct Arguments {
  std::string scenes = "recorded/", seeds = "1,2,3", points = "300";
  bool verbose = false;
};

Arguments Read(int count, char** values) {
  Arguments out;
  for (int i = 1; i < count; ++i) {
    const std::string name = values[i];
    std::string* value = name == "--scenes"   ? &out.scenes
                         : name == "--seeds"  ? &out.seeds
                         : name == "--points" ? &out.points
                                              : nullptr;
    if (name == "--verbose") {
      out.verbose = true;
    } else if (value != nullptr && i + 1 < count) {
      *value = values[++i];
    } else {
      std::fprintf(stderr, "model_table [--scenes TEXT] [--seeds 1,2] [--points N] [--verbose]\n");
      std::exit(2);
    }
  }
  return out;
}

std::vector<std::string> SceneNames(const std::string& containing) {
  std::vector<std::string> names;
  for (const std::string sub : {"", "recorded/"}) {
    const auto folder = std::filesystem::path(SARBLOCK_DATASETS) / "scenes" / sub;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      const std::string name = sub + entry.path().stem().string();
      if (entry.path().extension() != ".toml" || name == "single-flight-squint") continue;
      if (name.find(containing) != std::string::npos) names.push_back(name);
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

/// Polynomials of these degrees, or a spline of eight knots a strip.
constexpr std::array kDegrees{0, 1, 2, 4, -1};
constexpr std::array kPriors_m{10.0, 100.0, 1000.0};

AdjustOptions WithModel(
    AdjustOptions options, int degree, double prior_m, bool biases, double knots_s) {
  PositionCorrection position;
  position.prior_sigma_m.fill({prior_m});
  if (degree < 0) {
    position.basis = PositionCorrection::Basis::kSpline;
    position.knot_spacing_s = knots_s;
  } else {
    position.degree = degree;
  }
  options.corrections = CorrectionChoice::kGiven;
  options.diagnose = false;
  options.priors.clear();
  options.groups = {{"position", position, {}, false}};
  if (biases) {
    RangeCorrection range;
    range.bias = true;
    range.bias_prior_sigma_m = 100.0;
    TimeCorrection time;
    time.bias_prior_sigma_s = 0.1;
    options.groups.push_back({"range", range, {}, false});
    options.groups.push_back({"time", time, {}, false});
  }
  return options;
}

/// Largest distance of two solutions at a point, in its largest standard deviation.
double ApartInSigmas(const AdjustResult& a, const AdjustResult& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.points.covariance_m2.size(); ++i) {
    const SymmetricEnu& c = a.points.covariance_m2[i];
    const double sigma_m = std::sqrt(std::max({c[0], c[1], c[2]}));
    if (!(sigma_m > 0.0)) continue;
    const double apart = (a.points.position_m[i] - b.points.position_m[i]).norm() / sigma_m;
    most = std::max(most, apart);
  }
  return most;
}

bool Converged(const AdjustResult& result) {
  const std::vector<std::string>& reasons = result.assessment.reasons;
  return std::none_of(reasons.begin(), reasons.end(), [](const std::string& reason) {
    return reason.rfind("not converged", 0) == 0;
  });
}

/// Of the models of a scene; both engines, the default one first.
struct Counts {
  int models = 0, apart = 0;
  std::array<int, 2> not_accepted{}, not_converged{}, long_ones{}, iterations{}, most{};

  void Add(const std::array<std::optional<AdjustResult>, 2>& results) {
    constexpr int kMany = 12;
    ++models;
    for (std::size_t e = 0; e < 2; ++e) {
      if (!results[e]) {
        ++not_converged[e];
        ++not_accepted[e];
        continue;
      }
      not_accepted[e] += results[e]->accepted() ? 0 : 1;
      not_converged[e] += Converged(*results[e]) ? 0 : 1;
      long_ones[e] += results[e]->iterations > kMany ? 1 : 0;
      iterations[e] += results[e]->iterations;
      most[e] = std::max(most[e], results[e]->iterations);
    }
    if (results[0] && results[1] && ApartInSigmas(*results[0], *results[1]) > 1e-6) ++apart;
  }
  void Print(const std::string& name) const {
    std::printf("| %s | %d | %d / %d | %d / %d | %d / %d | %d / %d | %d / %d | %d |\n",
                name.c_str(),
                models,
                not_accepted[0],
                not_accepted[1],
                not_converged[0],
                not_converged[1],
                long_ones[0],
                long_ones[1],
                iterations[0],
                iterations[1],
                most[0],
                most[1],
                apart);
    std::fflush(stdout);
  }
};

}  // namespace

int main(int count, char** values) {
  const Arguments arguments = Read(count, values);
  std::printf(
      "| scene | models | not accepted | not converged | more than 12 iterations | iterations | "
      "most | engines apart by 1e-6 sigma |\n| --- | --- | --- | --- | --- | --- | --- | --- |\n");
  for (const std::string& name : SceneNames(arguments.scenes)) {
    Counts counts;
    std::istringstream seeds(arguments.seeds);
    for (std::string seed; std::getline(seeds, seed, ',');) {
      const Scene scene =
          test::ShippedScene(name, {"points.count=" + arguments.points, "seed=" + seed});
      const SimulatedBlock simulated = Simulate(scene);
      const Block& block = simulated.block;
      const AdjustOptions given = test::OptionsOf(scene, block);
      double longest_s = 0.0;
      for (const Pass& pass : block.passes) {
        longest_s = std::max(longest_s, pass.end_s - pass.start_s);
      }
      for (const int degree : kDegrees) {
        for (const double prior_m : kPriors_m) {
          for (const bool biases : {false, true}) {
            AdjustOptions options = WithModel(given, degree, prior_m, biases, longest_s / 8.0);
            std::array<std::optional<AdjustResult>, 2> results;
            for (const Engine engine : {Engine::kReduced, Engine::kCeres}) {
              options.engine = engine;
              auto& result = results[engine == Engine::kReduced ? 0 : 1];
              try {
                result = Adjust(block, options);
              } catch (const std::exception& error) {
                if (arguments.verbose) std::printf("# %s\n", error.what());
              }
            }
            counts.Add(results);
            const bool odd = !results[0] || !results[1] || !results[0]->accepted() ||
                             !results[1]->accepted() || results[0]->iterations > 12;
            if (!arguments.verbose || !odd) continue;
            std::printf("# %s degree %d prior %g m biases %d seed %s: %d / %d iterations, %s\n",
                        name.c_str(),
                        degree,
                        prior_m,
                        biases ? 1 : 0,
                        seed.c_str(),
                        results[0] ? results[0]->iterations : -1,
                        results[1] ? results[1]->iterations : -1,
                        results[0] && !results[0]->assessment.reasons.empty()
                            ? results[0]->assessment.reasons.front().c_str()
                            : "");
          }
        }
      }
    }
    counts.Print(name);
  }
  return 0;
}
