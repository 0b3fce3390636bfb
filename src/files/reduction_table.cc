// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

#include <optional>

#include "block_reader.h"
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

void RequireReductions(const Block& block, const std::vector<FilePlace>& places) {
  const auto problem = FindProblem(block, ModelsOf(block));
  if (!problem) return;
  FilePlace place = places[problem->pass];
  place.field = "pass[" + std::to_string(problem->pass) + "]." + problem->key;
  throw InputError(place, problem->problem);
}

}  // namespace sarblock::files
