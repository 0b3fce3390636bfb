// SPDX-License-Identifier: Apache-2.0
#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/files/block_file.h"
#include "sarblock/files/scene_file.h"
#include "sarblock/simulate/scene.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "arrays.h"
#include "core/text.h"
#include "core/threads.h"
#include "files/block_file.h"
#include "module.h"
#include "tables/open.h"
#include "tables/table.h"
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

namespace sarblock::python {
BlockPointer ReadBlockAt(const std::filesystem::path& path,
                         const std::vector<std::string>& overrides,
                         files::Measurements measurements,
                         ProgressSink* progress) {
  auto data = std::make_shared<BlockData>();
  std::tie(data->toml_name, data->toml) = TablesAt(path, FolderContent::kBlock)->Read("block.toml");
  files::ReadOptions options;
  options.measurements = measurements;
  options.set_overrides = overrides;
  options.progress = progress;
  data->file = files::ReadBlock(path, options);
  data->overrides = overrides;
  data->path = std::filesystem::absolute(path);
  data->inputs = files::ListInputFiles(path, data->file.adjust);
  data->truth = files::ReadTruth(path, data->file.block);  // the path may hold another block later
  data->measurements = measurements;
  return data;
}

BlockPointer BlockOfArrays(const files::BlockArrays& arrays,
                           files::Measurements measurements,
                           ProgressSink* progress) {
  auto data = std::make_shared<BlockData>();
  files::ReadOptions options;
  options.measurements = measurements;
  options.progress = progress;
  data->file = files::ReadBlockArrays(arrays, options);
  data->toml = arrays.block_toml;
  data->toml_name = "block.toml";
  data->measurements = measurements;
  return data;
}

BlockPointer SimulateScene(const std::string& name,
                           const std::string* text,
                           const std::vector<std::string>& overrides,
                           int threads,
                           ProgressSink* progress) {
  const Scene scene = text == nullptr ? files::ReadScene(name, overrides)
                                      : files::ParseScene(*text, name, overrides);
  SimulatedBlock simulated = CallInLibrary(
      threads, progress, [&] { return Naming(name, [&] { return Simulate(scene, progress); }); });
  auto data = std::make_shared<BlockData>();
  data->file.adjust =
      files::ReadAdjustTable(scene.adjust_toml, name, files::IdsOf(simulated.block.passes));
  data->file.block = std::move(simulated.block);
  data->truth = std::move(simulated.truth);
  data->toml = files::DumpAdjustTable(data->file.adjust);  // as its block.toml would have it
  data->toml_name = name;
  return data;
}

files::AdjustTable OptionsOf(const BlockData& data,
                             const std::vector<std::string>& overrides,
                             int threads) {
  std::vector<std::string> all = data.overrides;
  for (const std::string& text : overrides) {
    for (const char* table : {"trajectory.", "reduction."}) {
      if (!text.starts_with(table)) continue;
      throw InputError("--set " + text.substr(0, text.find('=')),
                       "says how a block is read, which read_block does");
    }
    all.push_back(text);
  }
  files::AdjustTable options =
      files::ReadAdjustTable(data.toml, data.toml_name, files::IdsOf(data.file.block.passes), all);
  options.threads = threads > 0 ? threads : AvailableCores();
  return options;
}

std::filesystem::path HomeOf(const BlockData& data) {
  return data.path.empty() ? std::filesystem::path(".") : data.path;
}

void RequireAsRead(const BlockData& data, const std::string& list) {
  const std::filesystem::path file = FolderOf(data.path) / list;
  for (const files::InputFile& input : data.inputs) {
    if (input.name != file.filename().string() || input.sha256 == files::Sha256OfFile(file))
      continue;
    throw InputError(FilePlace{file.string(), 0, ""},
                     "has changed since the block was read, which names it; read_block reads both");
  }
}

namespace {

namespace py = pybind11;
using BlockClass = py::class_<BlockData, std::shared_ptr<BlockData>>;

/// Python never changes a block, so that the library's `const` needs no class of its own there.
std::shared_ptr<BlockData> Shown(const BlockPointer& block) {
  return std::const_pointer_cast<BlockData>(block);
}

py::array FixedComponents(const std::vector<KnownPosition>& known) {
  py::array_t<bool> out({static_cast<py::ssize_t>(known.size()), py::ssize_t{3}});
  bool* to = out.mutable_data();
  for (const KnownPosition& position : known) {
    to = std::copy(position.fixed.begin(), position.fixed.end(), to);
  }
  return out;
}

py::array KnownVelocities(const py::handle& owner, const std::vector<KnownPosition>& known) {
  static const KnownPosition kNothing{};
  const KnownPosition& first = known.empty() ? kNothing : known.front();
  return View(
      owner,
      first.velocity_mpy.data(),
      {static_cast<py::ssize_t>(known.size()), 3},
      {static_cast<py::ssize_t>(sizeof(KnownPosition)), static_cast<py::ssize_t>(sizeof(double))});
}

py::array KnownCovariances(const py::handle& owner, const std::vector<KnownPosition>& known) {
  static const KnownPosition kNothing{};
  const KnownPosition& first = known.empty() ? kNothing : known.front();
  constexpr auto kDouble = static_cast<py::ssize_t>(sizeof(double));
  return View(owner,
              first.covariance_enu_m2.data(),
              {static_cast<py::ssize_t>(known.size()), 3, 3},
              {static_cast<py::ssize_t>(sizeof(KnownPosition)), kDouble, 3 * kDouble});
}

using BlockArrayGetter = std::function<py::object(const py::handle&, const BlockData&)>;

const std::map<std::string, BlockArrayGetter>& BlockArrayTable() {
  static const std::map<std::string, BlockArrayGetter> table{
      {"points.ids",
       [](const py::handle&, const BlockData& data) {
         const IdTable& ids = data.file.block.points.ids;
         return Texts(ids.size(), [&ids](std::size_t i) { return ids[i]; });
       }},
      {"points.role",
       [](const py::handle& self, const BlockData& data) {
         const std::vector<PointRole>& roles = data.file.block.points.role;
         return View(self,
                     reinterpret_cast<const std::uint8_t*>(roles.data()),
                     {static_cast<py::ssize_t>(roles.size())},
                     {1});
       }},
      {"points.given_m",
       [](const py::handle& self, const BlockData& data) {
         return VectorView(self, data.file.block.points.given_m);
       }},
      {"points.known_index",
       [](const py::handle& self, const BlockData& data) {
         return ColumnView(self, data.file.block.points.known, &KnownPosition::point);
       }},
      {"points.known_held",
       [](const py::handle&, const BlockData& data) {
         return FixedComponents(data.file.block.points.known);
       }},
      {"points.known_covariance_enu_m2",
       [](const py::handle& self, const BlockData& data) {
         return KnownCovariances(self, data.file.block.points.known);
       }},
      {"points.known_velocity_mpy",
       [](const py::handle& self, const BlockData& data) {
         return KnownVelocities(self, data.file.block.points.known);
       }},
      {"looks.offsets",
       [](const py::handle& self, const BlockData& data) {
         return View(self, data.file.block.looks.offsets);
       }},
      {"looks.pass_index",
       [](const py::handle& self, const BlockData& data) {
         return View(self, data.file.block.looks.pass);
       }},
      {"looks.flags",
       [](const py::handle& self, const BlockData& data) {
         return View(self, data.file.block.looks.flags);
       }},
      {"looks.time_s",
       [](const py::handle& self, const BlockData& data) {
         return View(self, data.file.block.looks.time_s);
       }},
      {"looks.range_m",
       [](const py::handle& self, const BlockData& data) {
         return View(self, data.file.block.looks.range_m);
       }},
      {"looks.cone",
       [](const py::handle& self, const BlockData& data) {
         return OptionalView(self, data.file.block.looks.cone);
       }},
      {"looks.range_sigma_m",
       [](const py::handle& self, const BlockData& data) {
         return OptionalView(self, data.file.block.looks.range_sigma_m);
       }},
      {"looks.azimuth_sigma",
       [](const py::handle& self, const BlockData& data) {
         return OptionalView(self, data.file.block.looks.azimuth_sigma);
       }},
      {"looks.range_delay_m",
       [](const py::handle& self, const BlockData& data) {
         return OptionalView(self, data.file.block.looks.range_delay_m);
       }},
      {"looks.time_shift_s",
       [](const py::handle& self, const BlockData& data) {
         return OptionalView(self, data.file.block.looks.time_shift_s);
       }},
  };
  return table;
}

const Pass& PassAt(const BlockData& data, std::size_t index) {
  if (index >= data.file.block.passes.size()) throw py::index_error("no such pass");
  return data.file.block.passes[index];
}

/// As the names of columns end.
const char* UnitOf(AzimuthUnit unit) {
  switch (unit) {
    case AzimuthUnit::kMetres:
      return "m";
    case AzimuthUnit::kSeconds:
      return "s";
    case AzimuthUnit::kHertz:
      break;
  }
  return "hz";
}

/// As [pass.reduction] has it.
py::dict DescribeReduction(const ReductionModels& models) {
  py::dict out;
  if (models.troposphere == TroposphereModel::kStandard) out["troposphere"] = "standard";
  if (models.troposphere == TroposphereModel::kWeather) {
    py::dict weather;
    weather["pressure_hpa"] = models.weather.pressure_hpa;
    weather["temperature_k"] = models.weather.temperature_k;
    weather["humidity_1"] = models.weather.humidity;
    weather["height_m"] = models.weather.height_m;
    out["troposphere"] = weather;
  }
  if (models.ionosphere) {
    py::dict ionosphere;
    ionosphere["tec_tecu"] = models.ionosphere->tec_tecu;
    ionosphere["share_1"] = models.ionosphere->share;
    out["ionosphere"] = ionosphere;
  }
  if (models.solid_tide) out["tide"] = "solid";
  if (models.range_m != 0.0) out["range_m"] = models.range_m;
  if (models.time_s != 0.0) out["time_s"] = models.time_s;
  return out;
}

py::dict DescribePass(const BlockData& data, std::size_t index) {
  const Pass& pass = PassAt(data, index);
  py::dict out;
  out["id"] = pass.id;
  out["look"] = pass.side == LookSide::kLeft ? "left" : "right";
  out["wavelength_m"] = pass.wavelength_m;
  out["range_sigma_m"] = pass.sigma.range_m;
  out["azimuth_sigma"] = pass.sigma.azimuth;
  out["azimuth_unit"] = UnitOf(pass.sigma.azimuth_unit);
  out["start_s"] = pass.start_s;
  out["end_s"] = pass.end_s;
  out["squint_deg"] = ToUnit(pass.squint_rad, kRadPerDeg);
  out["swath"] = py::none();
  if (pass.swath) {
    const SwathKey& key = kSwathKeys[static_cast<std::size_t>(pass.swath->kind)];
    out["swath"] = py::make_tuple(key.key,
                                  ToUnit(pass.swath->limits[0], key.factor),
                                  ToUnit(pass.swath->limits[1], key.factor));
  }
  out["epoch_utc"] = pass.epoch_utc;
  out["reduction"] = DescribeReduction(pass.reduction);
  out["through"] = NameOf(pass.recorded.asked.through);
  out["state_sigma_m"] = pass.recorded.asked.sigma.position_m;
  out["state_sigma_mps"] = pass.recorded.asked.sigma.velocity_mps;
  return out;
}

files::Measurements MeasurementsOf(bool plan) {
  return plan ? files::Measurements::kOptional : files::Measurements::kRequired;
}

/// By name of the table the arrays by name of the column.
using ArrayTables = std::map<std::string, std::map<std::string, py::array>>;

std::shared_ptr<BlockData> FromArrays(const std::string& toml,
                                      const std::vector<std::string>& pass_ids,
                                      const ArrayTables& tables,
                                      bool plan,
                                      const py::object& progress) {
  auto passes = std::make_shared<IdTable>();
  for (const std::string& id : pass_ids) passes->Append(id);
  std::shared_ptr<const IdTable> points = std::make_shared<IdTable>();
  std::vector<FixedColumn> fixed;
  files::BlockArrays arrays{toml, {}};
  // Those of the points first: indices of other tables count in them.
  for (const char* name : {"points", "trajectories", "observations"}) {
    const auto given = tables.find(name);
    if (given == tables.end()) continue;
    files::ArrayTable table{name, {}};
    for (const auto& [column, array] : given->second) {
      if (column == "pass_index") {
        fixed.push_back(IndexColumnOf(name, column, array, passes));
      } else if (column == "point_index") {
        fixed.push_back(IndexColumnOf(name, column, array, points));
      } else {
        fixed.push_back(ColumnOf(name, column, array));
      }
      table.columns.push_back(fixed.back().column);
      if (table.name == "points" && column == "point" && fixed.back().column.texts) {
        points = fixed.back().column.texts;
      }
    }
    arrays.tables.push_back(std::move(table));
  }
  return Shown(RunWork(progress, [&](ProgressSink* sink) {
    return BlockOfArrays(arrays, MeasurementsOf(plan), sink);
  }));
}

py::object TruePositions(const BlockData& data) {
  const Truth& truth = data.truth;
  if (truth.points_m.empty()) return py::none();
  const py::array view = VectorView(py::none(), truth.points_m);
  return view.attr("copy")();
}

py::dict Check(const std::shared_ptr<BlockData>& data,
               const std::vector<std::string>& overrides,
               int threads,
               const py::object& progress) {
  const BlockCheck check = RunWork(progress, [&](ProgressSink* sink) {
    const files::AdjustTable options = OptionsOf(*data, overrides, threads);
    return Naming(data->path.string(), [&] { return CheckBlock(data->file.block, options, sink); });
  });
  std::vector<std::string> warnings = data->file.warnings;
  warnings.insert(warnings.end(), check.findings.begin(), check.findings.end());
  py::dict out;
  out["corrections"] = check.corrections;
  out["warnings"] = TextList(warnings);
  return out;
}

void WriteBlockData(const BlockData& data,
                    const std::filesystem::path& path,
                    bool gzip,
                    bool force,
                    const py::object& progress) {
  RunUnlocked(progress, [&](ProgressSink*) {
    RequireFolderFor(
        FolderContent::kBlock, path, force ? ForeignFiles::kReplace : ForeignFiles::kRefuse);
    const Truth& truth = data.truth;
    files::WriteBlock(path,
                      data.file.block,
                      data.file.adjust,
                      truth.points_m.empty() ? nullptr : &truth,
                      gzip ? Compression::kGzip : Compression::kNone);
  });
}

py::dict DescribeFrame(const Block& block) {
  const Frame& frame = block.frame;
  py::dict out;
  const bool local = frame.kind() == FrameKind::kLocal;
  out["kind"] = local ? "local" : "geocentric";
  if (local) return out;
  const Ellipsoid& ellipsoid = frame.ellipsoid();
  const std::vector<std::string>& names = EllipsoidNames();
  if (std::find(names.begin(), names.end(), ellipsoid.name) != names.end()) {
    out["ellipsoid"] = ellipsoid.name;
  } else {
    py::dict axes;
    axes["a_m"] = ellipsoid.a_m;
    axes["f"] = ellipsoid.flattening;
    out["ellipsoid"] = axes;
  }
  if (!block.realization.empty()) out["realization"] = block.realization;
  if (!std::isnan(block.epoch_year)) out["epoch"] = block.epoch_year;
  return out;
}

}  // namespace

void BindBlock(py::module_* module) {
  BlockClass(*module, "Block", "A block in memory; sarblock.Block is what people use.")
      .def_property_readonly("name", [](const BlockData& data) { return data.file.block.name; })
      .def_property_readonly("frame",
                             [](const BlockData& data) { return DescribeFrame(data.file.block); })
      .def_property_readonly("warnings",
                             [](const BlockData& data) { return TextList(data.file.warnings); })
      .def_property_readonly("path", [](const BlockData& data) { return data.path.string(); })
      .def_property_readonly("pass_count",
                             [](const BlockData& data) { return data.file.block.passes.size(); })
      .def(
          "options",
          [](const BlockData& data, const std::vector<std::string>& set) {
            return files::DumpAdjustTable(OptionsOf(data, set, 1));
          },
          py::arg("set"),
          "The [adjust] table as TOML, with KEY=VALUE texts over it.")
      .def("describe_pass", &DescribePass, py::arg("index"), "What block.toml says of a pass.")
      .def(
          "states",
          [](const py::object& self, std::size_t index) {
            const Pass& pass = PassAt(self.cast<const BlockData&>(), index);
            return StatesView(self, pass.RecordedStates());
          },
          py::arg("index"),
          "State vectors of a pass, (states, 7): time [s], position [m], velocity [m/s].")
      .def(
          "array",
          [](const py::object& self, const std::string& name) {
            return BlockArrayTable().at(name)(self, self.cast<const BlockData&>());
          },
          py::arg("name"),
          "One of the block's arrays by the name of the property that shows it.")
      .def("truth_m", &TruePositions, "True positions, (points, 3) [m], or None.")
      .def("check",
           &Check,
           py::arg("set"),
           py::arg("threads"),
           py::arg("progress"),
           "What an adjustment would say of the block.")
      .def("write",
           &WriteBlockData,
           py::arg("path"),
           py::arg("gzip"),
           py::arg("force"),
           py::arg("progress"),
           "Writes a block folder or an HDF5 file.");
  module->def(
      "read_block",
      [](const std::filesystem::path& path,
         const std::vector<std::string>& set,
         bool plan,
         const py::object& progress) {
        return Shown(RunWork(progress, [&](ProgressSink* sink) {
          return ReadBlockAt(path, set, MeasurementsOf(plan), sink);
        }));
      },
      py::arg("path"),
      py::arg("set"),
      py::arg("plan"),
      py::arg("progress"),
      "Reads a block folder or an HDF5 file.");
  module->def("from_arrays",
              &FromArrays,
              py::arg("toml"),
              py::arg("pass_ids"),
              py::arg("tables"),
              py::arg("plan"),
              py::arg("progress"),
              "A block of the content of block.toml and tables of arrays.");
  module->def(
      "simulate",
      [](const std::string& name,
         const std::optional<std::string>& text,
         const std::vector<std::string>& set,
         int threads,
         const py::object& progress) {
        return Shown(RunWork(progress, [&](ProgressSink* sink) {
          return SimulateScene(name, text ? &*text : nullptr, set, threads, sink);
        }));
      },
      py::arg("name"),
      py::arg("text"),
      py::arg("set"),
      py::arg("threads"),
      py::arg("progress"),
      "Simulates the scene of a file or of a text.");
}

}  // namespace sarblock::python
