// SPDX-License-Identifier: Apache-2.0
// Plants every mistake of plants.h in every block and prints what is said of it, and how long that
// takes beside one adjustment; the tables of docs/validation.md. Usage: diagnosis_table [--draws N]
// [--seed S] [--block TEXT] [--plant TEXT] [--verbose] [--write FOLDER]; TEXT is a part of the
// name. With --write the blocks are written as folders of FOLDER, with the truth of the scene, and
// not diagnosed, the good block of each scene and seed too; a line each to standard output: folder,
// block, mistake or "none", seed, tabs between them.
#include "sarblock/files/block_file.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "trial_blocks.h"

namespace {

using sarblock::test::Outcome;
using sarblock::test::Plant;

struct Arguments {
  std::uint64_t draws = 1, seed = 1;
  std::string block, plant, folder;
  bool verbose = false;
};

Arguments Read(int count, char** values) {
  Arguments out;
  for (int i = 1; i < count; ++i) {
    const std::string_view name = values[i];
    if (name == "--verbose") {
      out.verbose = true;
      continue;
    }
    if (i + 1 == count) break;
    const char* value = values[++i];
    if (name == "--draws") out.draws = std::strtoull(value, nullptr, 10);
    if (name == "--seed") out.seed = std::strtoull(value, nullptr, 10);
    if (name == "--block") out.block = value;
    if (name == "--plant") out.plant = value;
    if (name == "--write") out.folder = value;
  }
  return out;
}

using Counts = std::array<int, 7>;

void Print(const std::string& name, const Counts& counts) {
  const int seen = counts[1] + counts[2] + counts[3] + counts[4] + counts[5];
  std::printf("| %s | %d | %d | %d | %d | %d | %d | %d | %.0f %% |\n",
              name.c_str(),
              seen + counts[6],
              counts[6],
              counts[1],
              counts[2],
              counts[3],
              counts[4],
              counts[5],
              seen > 0 ? 100.0 * counts[1] / seen : 100.0);
  std::fflush(stdout);
}

/// Processor times of the diagnoses of one block.
struct Times {
  double worst_s = 0.0;
  std::string worst;  ///< its mistake
  std::vector<double> all_s;
};

void PrintTimes(const std::map<std::string, Times>& times) {
  std::printf("\n| block | adjustment [ms] | diagnosis, median | largest | of |\n");
  std::printf("| --- | --- | --- | --- | --- |\n");
  for (auto [block, of] : times) {
    const double adjustment_s = sarblock::test::AdjustmentTime_s(block);
    std::sort(of.all_s.begin(), of.all_s.end());
    std::printf("| %s | %.1f | %.2f | %.2f | %s |\n",
                block.c_str(),
                1e3 * adjustment_s,
                of.all_s[of.all_s.size() / 2] / adjustment_s,
                of.worst_s / adjustment_s,
                of.worst.c_str());
  }
}

void Tell(const std::string& block,
          const Plant& plant,
          std::uint64_t seed,
          const sarblock::test::TrialResult& result) {
  std::printf(
      "# %s / %s / %llu: outcome %d, expected %s (%s) of %s %s, %.0f ms, %d solutions, "
      "%d hypotheses, %d untried\n",
      block.c_str(),
      plant.name.c_str(),
      static_cast<unsigned long long>(seed),
      static_cast<int>(result.outcome),
      result.planted.causes.empty() ? "" : result.planted.causes[0].c_str(),
      result.diagnosis.contradicts ? "contradicts" : "no contradiction",
      result.planted.passes.empty() ? "" : result.planted.passes[0].c_str(),
      result.planted.points.empty() ? "" : result.planted.points[0].c_str(),
      1e3 * result.diagnosis_s,
      result.diagnosis.solutions,
      result.diagnosis.hypotheses,
      result.diagnosis.untried);
  for (const std::string& remark : result.diagnosis.remarks)
    std::printf("#   %s\n", remark.c_str());
  for (const std::string& text : result.diagnosis.Sentences())
    std::printf("#   %s\n", text.c_str());
}

void Write(const Arguments& arguments) {
  int number = 0;
  std::vector<Plant> plants = sarblock::test::Plants();
  std::erase_if(plants, [&](const Plant& plant) {
    return plant.name.find(arguments.plant) == std::string::npos;
  });
  plants.push_back({"none", [](sarblock::Block*, sarblock::RandomStream*) {
                      return sarblock::test::Planted{true, {}, {}, {}, ""};
                    }});
  for (const Plant& plant : plants) {
    for (const std::string& block : sarblock::test::TrialNames()) {
      if (block.find(arguments.block) == std::string::npos) continue;
      for (std::uint64_t draw = 0; draw < arguments.draws; ++draw) {
        const std::uint64_t seed = arguments.seed + draw;
        const auto [made, planted] = sarblock::test::PlantIn(block, plant, seed);
        if (!planted.done) continue;
        const std::string folder = std::to_string(++number);
        sarblock::files::WriteBlock(std::filesystem::path(arguments.folder) / folder,
                                    made.block,
                                    made.options,
                                    &made.truth);
        std::printf("%s\t%s\t%s\t%llu\n",
                    folder.c_str(),
                    block.c_str(),
                    plant.name.c_str(),
                    static_cast<unsigned long long>(seed));
      }
    }
  }
}

}  // namespace

int main(int count, char** values) {
  const Arguments arguments = Read(count, values);
  if (!arguments.folder.empty()) {
    Write(arguments);
    return 0;
  }
  Counts all{};
  std::map<std::string, Times> times;
  std::printf(
      "| mistake | blocks | unseen | first | tied | later | wrong | silent | first of seen |\n");
  std::printf("| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  for (const Plant& plant : sarblock::test::Plants()) {
    if (plant.name.find(arguments.plant) == std::string::npos) continue;
    Counts counts{};
    for (const std::string& block : sarblock::test::TrialNames()) {
      if (block.find(arguments.block) == std::string::npos) continue;
      for (std::uint64_t draw = 0; draw < arguments.draws; ++draw) {
        const std::uint64_t seed = arguments.seed + draw;
        const auto result = sarblock::test::RunTrial(block, plant, seed);
        ++counts[static_cast<std::size_t>(result.outcome)];
        if (result.planted.done) {
          Times& of = times[block];
          of.all_s.push_back(result.diagnosis_s);
          if (result.diagnosis_s > of.worst_s) {
            of.worst_s = result.diagnosis_s;
            of.worst = plant.name;
          }
        }
        const bool odd =
            result.outcome != Outcome::kFirst && result.outcome != Outcome::kNotApplicable;
        if (arguments.verbose && odd) Tell(block, plant, seed, result);
      }
    }
    Print(plant.name, counts);
    for (std::size_t i = 0; i < all.size(); ++i) all[i] += counts[i];
  }
  Print("all", all);
  PrintTimes(times);
  return 0;
}
