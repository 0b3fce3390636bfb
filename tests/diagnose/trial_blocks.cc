// SPDX-License-Identifier: Apache-2.0
#include "trial_blocks.h"

#include "sarblock/adjust/adjust.h"
#include "sarblock/core/statistics.h"
#include "sarblock/files/block_file.h"
#include "sarblock/files/scene_file.h"
#include "sarblock/simulate/scene.h"

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <limits>
#include <map>

namespace sarblock::test {
namespace {

const char* const kRealBlock = "cabeus-minirf";

std::filesystem::path RealFolder() {
  return std::filesystem::path(SARBLOCK_SHARED_DATA) / kRealBlock;
}

double ProcessorTime_s() {
  return static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC);
}

bool IsRight(const Explanation& reported, const Planted& planted) {
  if (std::find(planted.causes.begin(), planted.causes.end(), reported.cause) ==
      planted.causes.end()) {
    return false;
  }
  const bool passes = planted.passes.empty() || std::is_permutation(reported.passes.begin(),
                                                                    reported.passes.end(),
                                                                    planted.passes.begin(),
                                                                    planted.passes.end());
  const bool points = planted.points.empty() || std::is_permutation(reported.points.begin(),
                                                                    reported.points.end(),
                                                                    planted.points.begin(),
                                                                    planted.points.end());
  return passes && points;
}

Outcome OutcomeOf(const Diagnosis& diagnosis, const Planted& planted) {
  if (!planted.causes.empty() && planted.causes[0] == "copy") {
    for (const std::string& remark : diagnosis.remarks) {
      if (remark.find(planted.words) != std::string::npos) return Outcome::kFirst;
    }
    return Outcome::kSilent;
  }
  for (std::size_t i = 0; i < diagnosis.explanations.size(); ++i) {
    const Explanation& reported = diagnosis.explanations[i];
    if (!IsRight(reported, planted)) continue;
    if (i == 0) return Outcome::kFirst;
    const bool tied =
        reported.sentence.find("does not tell it from the first") != std::string::npos;
    return tied ? Outcome::kTied : Outcome::kListed;
  }
  if (!diagnosis.explanations.empty()) return Outcome::kWrong;
  return diagnosis.contradicts ? Outcome::kSilent : Outcome::kUnseen;
}

}  // namespace

std::vector<std::string> TrialNames() {
  std::vector<std::string> names;
  const auto folder = std::filesystem::path(SARBLOCK_DATASETS) / "scenes";
  for (const std::string sub : {"", "recorded/"}) {
    for (const auto& entry : std::filesystem::directory_iterator(folder / sub)) {
      const std::string stem = entry.path().stem().string();
      if (entry.path().extension() != ".toml" || stem == "single-flight-squint") continue;
      names.push_back(sub + stem);
    }
  }
  std::sort(names.begin(), names.end());
  if (std::filesystem::exists(RealFolder())) names.emplace_back(kRealBlock);
  return names;
}

TrialBlock MakeTrialBlock(const std::string& name, std::uint64_t seed) {
  TrialBlock made;
  if (name == kRealBlock) {
    files::BlockFile file = files::ReadBlock(RealFolder());
    return {std::move(file.block), std::move(file.adjust), {}};
  }
  // Planned paths, points and visibility are made once; a seed draws the errors anew.
  struct Simulated {
    Scene scene;
    SimulatedBlock block;
    AdjustOptions options;
  };
  static std::map<std::string, Simulated> kept;
  auto found = kept.find(name);
  if (found == kept.end()) {
    const auto file = std::filesystem::path(SARBLOCK_DATASETS) / "scenes" / (name + ".toml");
    Simulated simulated{files::ReadScene(file), {}, {}};
    simulated.block = Simulate(simulated.scene);
    std::vector<std::string> ids;
    for (const Pass& pass : simulated.block.block.passes) ids.push_back(pass.id);
    simulated.options = files::ReadAdjustTable(simulated.scene.adjust_toml, name, ids);
    found = kept.emplace(name, std::move(simulated)).first;
  }
  Simulated& simulated = found->second;
  if (seed > 0) Redraw(simulated.scene, seed, {}, &simulated.block);
  return {simulated.block.block, simulated.options, simulated.block.truth};
}

double AdjustmentTime_s(const std::string& name) {
  TrialBlock made = MakeTrialBlock(name, 1);
  made.options.threads = 1;
  double least_s = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 5; ++i) {
    const double begin_s = ProcessorTime_s();
    static_cast<void>(Adjust(made.block, made.options));
    least_s = std::min(least_s, ProcessorTime_s() - begin_s);
  }
  return least_s;
}

PlantedBlock PlantIn(const std::string& name, const Plant& plant, std::uint64_t seed) {
  PlantedBlock out{MakeTrialBlock(name, seed), {}};
  RandomStream random(seed, std::hash<std::string>{}(name + plant.name));
  out.planted = plant.make(&out.made.block, &random);
  return out;
}

TrialResult RunTrial(const std::string& name, const Plant& plant, std::uint64_t seed) {
  TrialResult result;
  auto [made, planted] = PlantIn(name, plant, seed);
  result.planted = std::move(planted);
  if (!result.planted.done) return result;
  made.options.threads = 1;
  const double begin_s = ProcessorTime_s();
  result.diagnosis = Diagnose(made.block, made.options);
  result.diagnosis_s = ProcessorTime_s() - begin_s;
  result.outcome = OutcomeOf(result.diagnosis, result.planted);
  return result;
}

}  // namespace sarblock::test
