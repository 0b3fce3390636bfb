// SPDX-License-Identifier: Apache-2.0
#include "sarblock/files/scene_file.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/path.h"

#include "block_file.h"
#include "correction_options.h"
#include "tables/csv.h"
#include "tables/toml.h"

namespace sarblock::files {
namespace {

constexpr char kSceneFormat[] = "sarblock-scene 1";

/// The keys of an orbit that is given by its node; they exclude those of its aim.
void ReadNode(SceneTable& table, SceneFlight* flight) {
  const auto read = [&](const char* key, double* value_rad) {
    const auto given = table.Take(key);
    if (!given) return;
    for (const char* other : {"aim_m", "aim_look_deg", "direction", "spacing_m"}) {
      if (table.Has(other)) {
        given->Fail(std::string("excludes ") + other +
                    "; an orbit is given by its aim or by its node");
      }
    }
    *value_rad = given->Number() * kRadPerDeg;
  };
  read("node_lon_deg", &flight->node_lon_rad);
  read("argument_of_latitude_deg", &flight->argument_of_latitude_rad);
  read("node_spacing_deg", &flight->node_spacing_rad);
}

SceneFlight ReadFlight(SceneTable& table) {
  using Pattern = SceneFlight::Pattern;
  SceneFlight flight;
  table.Text("id", &flight.id);
  table.Choice<Pattern>(
      "pattern", {{"strips", Pattern::kStrips}, {"orbit", Pattern::kOrbit}}, &flight.pattern);
  table.Choice<LookSide>(
      "look", {{"left", LookSide::kLeft}, {"right", LookSide::kRight}}, &flight.side);
  table.Number("squint_deg", &flight.squint_rad, kRadPerDeg);
  if (const auto swath = ReadSwath([&table](const std::string& key) {
        auto value = table.Take(key);
        // The name of swath_range_m in older scenes.
        return value || key != "swath_range_m" ? value : table.Take("swath_slant_m");
      })) {
    flight.swath = *swath;
  }
  table.Count("count", &flight.count);
  table.Count("segments", &flight.segments);
  table.Number("segment_spacing_m", &flight.segment_spacing_m);
  table.Number("spacing_m", &flight.spacing_m);
  table.Number("overlap", &flight.overlap);
  table.Number("height_m", &flight.height_m);
  table.Number("length_m", &flight.length_m);
  table.Number("speed_mps", &flight.speed_mps);
  table.Number("start_s", &flight.start_s);
  table.Number("state_spacing_s", &flight.state_spacing_s);
  std::array<double, 2> pair{};
  if (table.Numbers("start_m", &pair)) flight.start_m << pair[0], pair[1];
  table.Number("heading_deg", &flight.heading_rad, kRadPerDeg);
  table.Number("inclination_deg", &flight.inclination_rad, kRadPerDeg);
  table.Choice<bool>("direction", {{"ascending", false}, {"descending", true}}, &flight.descending);
  if (table.Numbers("aim_m", &pair)) flight.aim_m << pair[0], pair[1];
  table.Number("aim_look_deg", &flight.aim_look_rad, kRadPerDeg);
  ReadNode(table, &flight);
  table.Number("wavelength_m", &flight.wavelength_m);
  table.Number("range_sigma_m", &flight.range_sigma_m);
  table.Number("azimuth_sigma_m", &flight.azimuth_sigma_m);
  table.Text("epoch_utc", &flight.epoch_utc);
  table.Finish();
  return flight;
}

SceneNavigation ReadNavigation(SceneTable& table) {
  using Process = SceneNavigation::Process;
  SceneNavigation navigation;
  table.Numbers("constant_sigma_m", &navigation.constant_sigma_m);
  table.Numbers("drift_sigma_m", &navigation.drift_sigma_m);
  table.Numbers("curvature_sigma_m", &navigation.curvature_sigma_m);
  table.Choice<Process>("process",
                        {{"none", Process::kNone},
                         {"random-walk", Process::kRandomWalk},
                         {"gauss-markov", Process::kGaussMarkov}},
                        &navigation.process);
  table.Numbers("process_sigma_m", &navigation.process_sigma_m);
  table.Number("correlation_time_s", &navigation.correlation_time_s);
  table.Number("knot_spacing_s", &navigation.knot_spacing_s);
  table.Number("range_bias_sigma_m", &navigation.range_bias_sigma_m);
  table.Number("range_scale_sigma_ppm", &navigation.range_scale_sigma, 1e-6);
  table.Number("time_bias_sigma_s", &navigation.time_bias_sigma_s);
  table.Number("squint_bias_sigma_deg", &navigation.squint_bias_sigma_rad, kRadPerDeg);
  table.Truth("shared_biases", &navigation.shared_biases);
  if (const auto prior = table.Take("prior")) navigation.joint = ReadPriors(TomlTable(*prior));
  table.Finish();
  return navigation;
}

/// Reads wander.table; without a folder to look in it is refused.
void ReadTrajectoryErrorTable(const TomlValue& name,
                              const std::filesystem::path* folder,
                              SceneTrajectoryError* trajectory_error) {
  const std::string file = name.Text();
  if (folder == nullptr) name.Fail("is for scenes that are files, whose folder it counts from");
  constexpr Columns kColumns{{
      {"time_s", ColumnNeed::kRequired},
      {"along_m", ColumnNeed::kRequired},
      {"across_m", ColumnNeed::kRequired},
      {"up_m", ColumnNeed::kRequired},
  }};
  const auto table = ReadCsv(*folder / file, kColumns);
  if (!table->unknown_columns().empty()) {
    name.Fail("has a column '" + table->unknown_columns().front() +
              "', allowed are time_s, along_m, across_m and up_m");
  }
  ForRows(table.get(), [&](const Row& row) {
    const double time_s = row.RequiredNumber(kColumns("time_s"));
    if (!trajectory_error->table_time_s.empty() &&
        !(time_s > trajectory_error->table_time_s.back())) {
      row.Fail(kColumns("time_s"), "times must increase");
    }
    trajectory_error->table_time_s.push_back(time_s);
    trajectory_error->table_m.emplace_back(row.RequiredNumber(kColumns("along_m")),
                                           row.RequiredNumber(kColumns("across_m")),
                                           row.RequiredNumber(kColumns("up_m")));
  });
  if (trajectory_error->table_time_s.size() < 2) name.Fail("has fewer than two rows");
}

}  // namespace

SceneTrajectoryError ReadTrajectoryError(SceneTable& table, const std::filesystem::path* folder) {
  SceneTrajectoryError trajectory_error;
  table.Numbers("rms_m", &trajectory_error.rms_m);
  table.Numbers("time_constant_s", &trajectory_error.time_constant_s);
  if (const auto name = table.Take("table"))
    ReadTrajectoryErrorTable(*name, folder, &trajectory_error);
  table.Finish();
  return trajectory_error;
}

SceneRecorder ReadRecorder(SceneTable& table) {
  SceneRecorder recorder;
  table.Number("rate_hz", &recorder.rate_hz);
  table.Number("noise_m", &recorder.noise_m);
  table.Number("noise_mps", &recorder.noise_mps);
  table.Numbers("drift_sigma_mps", &recorder.drift_sigma_mps);
  table.Numbers("velocity_bias_sigma_mps", &recorder.velocity_bias_sigma_mps);
  table.Number("jump_m", &recorder.jump_m);
  table.Number("jump_interval_s", &recorder.jump_interval_s);
  table.Number("time_offset_s", &recorder.time_offset_s);
  table.Choice("through", kPathsThrough, &recorder.reading.through);
  table.Number("sigma_m", &recorder.reading.sigma.position_m);
  table.Number("sigma_mps", &recorder.reading.sigma.velocity_mps);
  table.Finish();
  return recorder;
}

namespace {

SceneImage ReadImage(SceneTable& table) {
  SceneImage image;
  table.Number("bandwidth_mhz", &image.bandwidth_hz, 1e6);
  table.Number("azimuth_resolution_m", &image.azimuth_resolution_m);
  table.Number("snr_db", &image.snr_db);
  table.Number("snr_incidence_deg", &image.snr_incidence_rad, kRadPerDeg);
  table.Number("backscatter_exponent", &image.backscatter_exponent);
  table.Number("window_m", &image.window_m);
  table.Number("correlation", &image.correlation);
  table.Number("slope_rms", &image.slope_rms);
  table.Finish();
  return image;
}

SceneLooks ReadLooks(SceneTable& table) {
  using Blunder = SceneLooks::BlunderKind;
  SceneLooks looks;
  table.Number("range_sigma_m", &looks.range_sigma_m);
  table.Number("azimuth_sigma_m", &looks.azimuth.azimuth);
  if (const auto seconds = table.Take("azimuth_sigma_s")) {
    if (table.Has("azimuth_sigma_m")) seconds->Fail("excludes azimuth_sigma_m; give one");
    looks.azimuth.azimuth = seconds->Number();
    looks.azimuth.azimuth_unit = AzimuthUnit::kSeconds;
  }
  if (const auto hertz = table.Take("doppler_sigma_hz")) {
    for (const char* other : {"azimuth_sigma_m", "azimuth_sigma_s"}) {
      if (table.Has(other)) hertz->Fail(std::string("excludes ") + other + "; give one");
    }
    looks.azimuth.azimuth = hertz->Number();
    looks.azimuth.azimuth_unit = AzimuthUnit::kHertz;
  }
  table.Number("noise_scale", &looks.noise_scale);
  table.Number("blunder_fraction", &looks.blunder_fraction);
  table.Number("blunder_size", &looks.blunder_size);
  table.Choice<Blunder>(
      "blunder_kind",
      {{"range", Blunder::kRange}, {"azimuth", Blunder::kAzimuth}, {"both", Blunder::kBoth}},
      &looks.blunder_kind);
  table.Choice<bool>("cone", {{"squint", false}, {"doppler", true}}, &looks.doppler);
  if (auto image = table.Table("image")) looks.image = ReadImage(*image);
  table.Finish();
  return looks;
}

SceneTerrain ReadTerrain(SceneTable& table) {
  using Kind = SceneTerrain::Kind;
  SceneTerrain terrain;
  table.Choice<Kind>(
      "kind",
      {{"flat", Kind::kFlat}, {"rolling", Kind::kRolling}, {"rugged", Kind::kRugged}},
      &terrain.kind);
  table.Number("height_m", &terrain.height_m);
  table.Number("relief_m", &terrain.relief_m);
  table.Number("correlation_m", &terrain.correlation_m);
  table.Choice<bool>("visibility", {{"none", false}, {"terrain", true}}, &terrain.hides);
  table.Finish();
  return terrain;
}

ScenePoints ReadPoints(SceneTable& table) {
  using Pattern = ScenePoints::Pattern;
  ScenePoints points;
  table.Count("count", &points.count);
  table.Numbers("east_m", &points.east_m);
  table.Numbers("north_m", &points.north_m);
  if (const auto given = table.Take("density_per_km2")) {
    if (table.Has("count")) given->Fail("excludes count; give one");
    const double density = given->Number();
    const double area_km2 =
        (points.east_m[1] - points.east_m[0]) * (points.north_m[1] - points.north_m[0]) * 1e-6;
    const double count = density * area_km2;
    if (!(density >= 0.0 && count >= 0.0 && count < 1e9)) {
      given->Fail("must be 0 or more and give fewer than 1e9 points");
    }
    points.count = static_cast<std::size_t>(count + 0.5);
  }
  table.Choice<Pattern>(
      "pattern", {{"random", Pattern::kRandom}, {"grid", Pattern::kGrid}}, &points.pattern);
  table.Count("min_looks", &points.min_looks);
  table.Finish();
  return points;
}

SceneControl ReadSceneControl(SceneTable& table, SceneControl::Layout default_layout) {
  using Layout = SceneControl::Layout;
  SceneControl known;
  known.layout = default_layout;
  table.Choice<Layout>("layout",
                       {{"none", Layout::kNone},
                        {"corners", Layout::kCorners},
                        {"perimeter", Layout::kPerimeter},
                        {"grid", Layout::kGrid},
                        {"chain", Layout::kChain},
                        {"random", Layout::kRandom},
                        {"places", Layout::kPlaces}},
                       &known.layout);
  if (const auto places = table.Take("places_m")) {
    for (const TomlValue& place : places->Entries()) {
      const std::vector<TomlValue> pair = place.Entries();
      if (pair.size() != 2) place.Fail("must be [east, north]");
      known.places_m.emplace_back(pair[0].Number(), pair[1].Number());
    }
    if (known.layout == Layout::kPlaces) known.count = known.places_m.size();
  }
  table.Count("count", &known.count);
  if (known.count == 0) known.layout = Layout::kNone;
  table.Numbers("sigma_m", &known.sigma_m);
  if (const auto components = table.Take("components")) {
    known.fixed = {false, false, false};
    for (const TomlValue& name : components->Entries()) {
      known.fixed[name.OneOf({"e", "n", "u"})] = true;
    }
  }
  table.Numbers("east_m", &known.east_m);
  table.Numbers("north_m", &known.north_m);
  table.Number("inset", &known.inset);
  table.Number("noise_scale", &known.noise_scale);
  table.Number("approximate_sigma_m", &known.approximate_sigma_m);
  table.Finish();
  return known;
}

ReductionModels ReadTruth(SceneTable& table) {
  ReductionModels delay;
  if (const auto t = table.Take("delay")) delay = ReadReduction(TomlTable(*t), {});
  table.Finish();
  return delay;
}

void ReadSceneFrame(SceneTable& table, Scene* scene) {
  std::string kind = "local";
  table.Choice<std::string>("kind", {{"local", "local"}, {"geocentric", "geocentric"}}, &kind);
  Ellipsoid ellipsoid;
  if (const auto given = table.Take("ellipsoid")) {
    ellipsoid = ReadEllipsoid(*given);
  } else if (kind == "geocentric") {
    throw InputError(table.PlaceOf("ellipsoid"), "must be given for a geocentric frame");
  }
  if (kind == "geocentric") scene->frame = Frame::Geocentric(ellipsoid);
  table.Number("centre_lat_deg", &scene->centre.lat_rad, kRadPerDeg);
  table.Number("centre_lon_deg", &scene->centre.lon_rad, kRadPerDeg);
  table.Number("rotation_rad_per_s", &scene->rotation_rad_per_s);
  table.Finish();
}

/// `folder`: that of the scene's file, where tables are looked for.
Scene ParseSceneIn(const std::filesystem::path* folder,
                   std::string_view text,
                   const std::string& file,
                   const std::vector<std::string>& overrides) {
  const toml::table root = ParseToml(text, file, overrides);
  SceneTable table{TomlTable(root, "")};
  Scene scene;
  std::string format;
  table.Text("format", &format);
  if (format != kSceneFormat) {
    throw InputError(PlaceOfField(root, file, "format"),
                     std::string("must be \"") + kSceneFormat + "\"");
  }
  table.Text("name", &scene.name);
  table.Text("purpose", &scene.purpose);
  table.Count("seed", &scene.seed);
  if (auto frame = table.Table("frame")) ReadSceneFrame(*frame, &scene);
  for (SceneTable& flight : table.Tables("flight")) {
    scene.flights.push_back(ReadFlight(flight));
  }
  if (auto t = table.Table("wander")) scene.trajectory_error = ReadTrajectoryError(*t, folder);
  if (auto t = table.Table("recorder")) scene.recorder = ReadRecorder(*t);
  if (auto t = table.Table("navigation")) scene.navigation = ReadNavigation(*t);
  if (auto t = table.Table("looks")) scene.looks = ReadLooks(*t);
  if (auto t = table.Table("terrain")) scene.terrain = ReadTerrain(*t);
  if (auto t = table.Table("points")) scene.points = ReadPoints(*t);
  if (auto t = table.Table("control")) {
    scene.control = ReadSceneControl(*t, SceneControl::Layout::kCorners);
  }
  if (auto t = table.Table("check")) {
    scene.check = ReadSceneControl(*t, SceneControl::Layout::kRandom);
  }
  if (auto t = table.Table("truth")) scene.delay = ReadTruth(*t);
  if (const auto t = table.Take("reduction")) scene.reduction = ReadReduction(TomlTable(*t), {});
  if (const auto adjust = table.Take("adjust")) {
    scene.adjust_toml = sarblock::TextOf(toml::table{{"adjust", TomlTable(*adjust).table()}});
  }
  table.Finish();
  if (const auto problem = FindProblem(scene)) {
    throw InputError(PlaceOfField(root, file, problem->field), problem->problem);
  }
  return scene;
}

}  // namespace

Scene ParseScene(std::string_view text,
                 const std::string& file,
                 const std::vector<std::string>& overrides) {
  return ParseSceneIn(nullptr, text, file, overrides);
}

Scene ReadScene(const std::filesystem::path& path, const std::vector<std::string>& overrides) {
  const std::filesystem::path folder = path.parent_path();
  return ParseSceneIn(&folder, ReadTomlText(path, "a scene"), path.string(), overrides);
}

std::string EffectiveSceneText(const std::filesystem::path& path,
                               const std::vector<std::string>& overrides) {
  return TextOf(ParseToml(ReadTomlText(path, "a scene"), path.string(), overrides));
}

std::vector<std::string> SceneKeys() {
  std::vector<std::string> keys = {"format", "name", "purpose", "seed"};
  const toml::table empty;
  // The readers are asked on an empty table: they ask for every key they know.
  const auto add = [&](const std::string& table, const auto& read) {
    SceneTable asked{TomlTable(empty, table)};
    read(asked);
    for (const std::string& key : asked.known()) keys.push_back(table + "." + key);
  };
  Scene scene;
  add("frame", [&](SceneTable& table) { ReadSceneFrame(table, &scene); });
  add("flight.0", [](SceneTable& table) { ReadFlight(table); });
  add("wander", [](SceneTable& table) { ReadTrajectoryError(table, nullptr); });
  add("recorder", [](SceneTable& table) { ReadRecorder(table); });
  add("navigation", [](SceneTable& table) { ReadNavigation(table); });
  add("looks", [](SceneTable& table) { ReadLooks(table); });
  add("looks.image", [](SceneTable& table) { ReadImage(table); });
  add("terrain", [](SceneTable& table) { ReadTerrain(table); });
  add("points", [](SceneTable& table) { ReadPoints(table); });
  for (const char* name : {"control", "check"}) {
    add(name, [](SceneTable& table) { ReadSceneControl(table, SceneControl::Layout::kNone); });
  }
  for (const std::string& key : ReductionKeys()) {
    keys.push_back("truth.delay." + key);
    keys.push_back("reduction." + key);
  }
  return keys;
}

}  // namespace sarblock::files
