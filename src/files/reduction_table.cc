// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/core/statistics.h"

#include <cmath>
#include <optional>
#include <utility>

#include "block_parts.h"
#include "core/text.h"
#include "reduction/look_reduction.h"

namespace sarblock::files {
namespace {

void ReadTroposphere(const TomlValue& value, ReductionModels* models) {
  if (value.IsText()) {
    models->troposphere = value.OneOf({"none", "standard"}) == 0 ? TroposphereModel::kNone
                                                                 : TroposphereModel::kStandard;
    return;
  }
  const TomlTable table(value);
  table.RefuseOthers({"pressure_hpa", "temperature_k", "humidity_1", "height_m"});
  models->troposphere = TroposphereModel::kWeather;
  models->weather.pressure_hpa =
      table.Require("pressure_hpa", "the air pressure in hectopascal").Number();
  models->weather.temperature_k =
      table.Require("temperature_k", "the temperature in kelvin").Number();
  models->weather.humidity = table.Require("humidity_1", "the relative humidity, 0 to 1").Number();
  const auto height = table.Find("height_m");
  models->weather.height_m = height ? height->Number() : 0.0;
}

void ReadIonosphere(const TomlValue& value, ReductionModels* models) {
  if (value.IsText()) {
    static_cast<void>(value.OneOf({"none"}));
    models->ionosphere.reset();
    return;
  }
  const TomlTable table(value);
  table.RefuseOthers({"tec_tecu", "share_1"});
  Ionosphere& ionosphere = models->ionosphere.emplace();
  ionosphere.tec_tecu = table.Require("tec_tecu", "the vertical electron content in TECU").Number();
  if (const auto share = table.Find("share_1")) ionosphere.share = share->Number();
}

}  // namespace

const std::vector<std::string>& ReductionKeys() {
  static const std::vector<std::string> keys{
      "troposphere", "ionosphere", "tide", "range_m", "time_s"};
  return keys;
}

ReductionModels ReadReduction(const TomlTable& table, const ReductionModels& standard) {
  table.RefuseOthers(ReductionKeys());
  ReductionModels models = standard;
  if (const auto value = table.Find("troposphere")) ReadTroposphere(*value, &models);
  if (const auto value = table.Find("ionosphere")) ReadIonosphere(*value, &models);
  if (const auto value = table.Find("tide")) {
    models.solid_tide = value->OneOf({"none", "solid"}) == 1;
  }
  if (const auto value = table.Find("range_m")) models.range_m = value->Number();
  if (const auto value = table.Find("time_s")) models.time_s = value->Number();
  return models;
}

std::string ReductionText(const ReductionModels& models, std::string_view name) {
  if (models == ReductionModels{}) return "";
  std::string text = "[" + std::string(name) + "]\n";
  if (models.troposphere == TroposphereModel::kStandard) text += "troposphere = \"standard\"\n";
  if (models.troposphere == TroposphereModel::kWeather) {
    const Weather& weather = models.weather;
    text += "troposphere = { pressure_hpa = " + NumberText(weather.pressure_hpa) +
            ", temperature_k = " + NumberText(weather.temperature_k) +
            ", humidity_1 = " + NumberText(weather.humidity);
    if (weather.height_m != 0.0) text += ", height_m = " + NumberText(weather.height_m);
    text += " }\n";
  }
  if (models.ionosphere) {
    text += "ionosphere = { tec_tecu = " + NumberText(models.ionosphere->tec_tecu) +
            ", share_1 = " + NumberText(models.ionosphere->share) + " }\n";
  }
  if (models.solid_tide) text += "tide = \"solid\"\n";
  if (models.range_m != 0.0) text += "range_m = " + NumberText(models.range_m) + "\n";
  if (models.time_s != 0.0) text += "time_s = " + NumberText(models.time_s) + "\n";
  return text;
}

std::vector<std::string> DoubtsOfReductions(const Block& block) {
  const Looks& looks = block.looks;
  // The atmosphere makes ranges longer by decimetres or more; motion within the pulse is below half
  // a metre of either sign. Sentinel-1's times are off by half a millisecond.
  constexpr double kWrongSign_m = -1.0, kSeconds_m = 1e-5, kMilliseconds_s = 0.01;
  std::vector<std::vector<double>> ranges_m(block.passes.size()), times_s(block.passes.size());
  for (std::size_t i = 0; i < looks.size(); ++i) {
    if (looks.rejected(i)) continue;
    if (!looks.range_delay_m.empty()) ranges_m[looks.pass[i]].push_back(looks.range_delay_m[i]);
    if (!looks.time_shift_s.empty()) times_s[looks.pass[i]].push_back(looks.time_shift_s[i]);
  }
  std::vector<std::string> doubts;
  for (std::size_t pass = 0; pass < block.passes.size(); ++pass) {
    const auto say = [&](const char* column, double value, const char* unit, const char* doubt) {
      doubts.push_back("pass " + Quoted(block.passes[pass].id) + ": " + column + " is " +
                       Digits(value, 3) + unit + " in the median: " + doubt);
    };
    if (!ranges_m[pass].empty()) {
      const double median_m = Median(std::move(ranges_m[pass]));
      if (median_m < kWrongSign_m) {
        say("range_delay_m", median_m, " m", "what makes ranges too long is positive");
      } else if (median_m != 0.0 && std::abs(median_m) < kSeconds_m) {
        say("range_delay_m", median_m, " m", "one-way metres are needed, are these seconds?");
      }
    }
    if (times_s[pass].empty()) continue;
    const double median_s = Median(std::move(times_s[pass]));
    if (std::abs(median_s) > kMilliseconds_s) {
      say("time_shift_s", median_s, " s", "seconds are needed, are these milliseconds or metres?");
    }
  }
  return doubts;
}

void RequireReductions(const Block& block, const std::vector<FilePlace>& places) {
  const auto problem = FindProblem(block, ModelsOf(block));
  if (!problem) return;
  FilePlace place = places[problem->pass];
  place.field = "pass[" + std::to_string(problem->pass) + "]." + problem->key;
  throw InputError(place, problem->problem);
}

}  // namespace sarblock::files
