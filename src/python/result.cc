// SPDX-License-Identifier: Apache-2.0
#include "sarblock/files/result.h"

#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/diagnose/diagnose.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "arrays.h"
#include "files/block_file.h"
#include "files/convert.h"
#include "module.h"
#include "tables/open.h"
#include "tables/table.h"
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

namespace sarblock::python {
namespace {

constexpr const char* kTaskNames[] = {"adjust", "intersect", "predict"};

/// A plan, read without measured values, can only be predicted.
void RequireMeasurements(const BlockData& data, Task task) {
  if (data.measurements == files::Measurements::kRequired || task == Task::kPredict) return;
  const Looks& looks = data.file.block.looks;
  for (std::size_t look = 0; look < looks.size(); ++look) {
    if (!std::isnan(looks.time_s[look]) && !std::isnan(looks.range_m[look])) continue;
    throw InputError("looks[" + std::to_string(look) + "]",
                     std::string("has no measured time and range, which ") +
                         kTaskNames[static_cast<std::size_t>(task)] + " needs; predict needs none");
  }
}

/// The files of a block as it was read, with lists that these options name beside.
std::vector<files::InputFile> InputsOf(const BlockData& data, const files::AdjustTable& options) {
  if (data.path.empty()) return {};
  std::vector<files::InputFile> inputs = data.inputs;
  const files::AdjustTable& read = data.file.adjust;
  if (options.pairs_file == read.pairs_file && options.rejections_file == read.rejections_file) {
    return inputs;
  }
  for (files::InputFile& input : files::ListInputFiles(data.path, options)) {
    const auto same = [&input](const files::InputFile& known) { return known.name == input.name; };
    if (std::none_of(inputs.begin(), inputs.end(), same)) inputs.push_back(std::move(input));
  }
  return inputs;
}

AdjustResult Run(Task task,
                 const SolvedBlock& solved,
                 const std::optional<std::vector<Eigen::Vector3d>>& positions_m,
                 ProgressSink* progress) {
  const Block& block = solved.block();
  const files::AdjustTable& options = solved.options;
  if (task == Task::kIntersect) return IntersectBlock(block, options, progress);
  PointPairs pairs;
  if (options.pairs == PairChoice::kList) {
    pairs = files::ReadPairs(HomeOf(*solved.source), options.pairs_file, block);
    if (options.pairs_file == solved.source->file.adjust.pairs_file) {
      RequireAsRead(*solved.source, options.pairs_file);
    }
  }
  if (task == Task::kAdjust) {
    try {
      return Adjust(block, options, pairs, progress);
    } catch (const UndeterminedError& refusal) {
      if (!options.diagnose) throw;
      throw ExplainedRefusal(refusal, ExplainRefusal(block, options, progress).Sentences());
    }
  }
  return Predict(
      block, options, positions_m ? *positions_m : solved.source->truth.points_m, pairs, progress);
}

}  // namespace

std::vector<std::string> ResultData::PassIds() const {
  return file ? files::IdsOf(file->passes) : files::IdsOf(solved->block().passes);
}

std::string ResultData::Summary() const {
  if (file) return file->summary.json;
  return files::SummaryJson(solved->block(), solved->options, solved->result, solved->context);
}

std::shared_ptr<const ResultData> Solve(
    Task task,
    const BlockPointer& block,
    const std::vector<std::string>& overrides,
    int threads,
    const std::optional<std::vector<Eigen::Vector3d>>& positions_m,
    ProgressSink* progress) {
  RequireMeasurements(*block, task);
  auto data = std::make_shared<ResultData>();
  SolvedBlock& solved = data->solved.emplace();
  solved.source = block;
  solved.options = OptionsOf(*block, overrides, threads);
  if (!solved.options.rejections_file.empty()) {
    solved.changed = block->file.block;
    static_cast<void>(
        files::ApplyRejections(HomeOf(*block), solved.options.rejections_file, &*solved.changed));
    if (solved.options.rejections_file == block->file.adjust.rejections_file) {
      RequireAsRead(*block, solved.options.rejections_file);
    }
  }
  const std::vector<std::string>& warnings = block->file.warnings;
  solved.context.command = kTaskNames[static_cast<std::size_t>(task)];
  solved.context.warnings = warnings;
  solved.context.inputs = InputsOf(*block, solved.options);
  solved.result =
      Naming(block->path.string(), [&] { return Run(task, solved, positions_m, progress); });
  if (task == Task::kAdjust && solved.options.diagnose) {
    solved.context.diagnosis =
        ExplainFailure(solved.block(), solved.options, warnings, &solved.result, progress);
  }
  return data;
}

std::shared_ptr<const ResultData> ReadResultAt(const std::filesystem::path& path,
                                               ProgressSink* progress) {
  files::ReadResultOptions options;
  options.progress = progress;
  auto data = std::make_shared<ResultData>();
  data->file = files::ReadResult(path, options);
  data->path = std::filesystem::absolute(path);
  return data;
}

namespace {

namespace py = pybind11;

py::object OptionalCovariances(const std::vector<SymmetricEnu>& of) {
  if (of.empty()) return py::none();
  return Covariances(of.size(), of.data(), sizeof(SymmetricEnu));
}

template <typename Enum>
py::array Codes(const py::handle& owner, const std::vector<Enum>& values) {
  static_assert(sizeof(Enum) == 1);
  return View(owner,
              reinterpret_cast<const std::uint8_t*>(values.data()),
              {static_cast<py::ssize_t>(values.size())},
              {1});
}

py::array ParameterTexts(const ResultData& data, std::string ParameterResult::*member) {
  const std::vector<ParameterResult>& parameters = data.parameters();
  return Texts(parameters.size(),
               [&](std::size_t i) -> std::string_view { return parameters[i].*member; });
}

py::object Reasons(const ResultData& data) {
  const std::vector<std::string>& reasons = data.points().reason;
  return Texts(data.points().status.size(), [&](std::size_t i) -> std::string_view {
    return reasons.empty() ? std::string_view() : std::string_view(reasons[i]);
  });
}

using ResultArrayGetter = std::function<py::object(const py::handle&, const ResultData&)>;
using ResultArrays = std::map<std::string, ResultArrayGetter>;

/// A list of a result, of whose rows members are shown.
template <typename Row>
using RowsOf = const std::vector<Row>& (ResultData::*)() const;

template <typename Row, typename Number>
ResultArrayGetter Column(RowsOf<Row> rows, Number Row::*member) {
  return [rows, member](const py::handle& self, const ResultData& data) {
    return ColumnView(self, (data.*rows)(), member);
  };
}

template <typename Row>
ResultArrayGetter Vectors(RowsOf<Row> rows, Eigen::Vector3d Row::*member) {
  return [rows, member](const py::handle& self, const ResultData& data) {
    return VectorView(self, (data.*rows)(), member);
  };
}

ResultArrays PointArrays() {
  const auto column = [](std::vector<double> PointResults::*member) {
    return [member](const py::handle& self, const ResultData& data) {
      return OptionalView(self, data.points().*member);
    };
  };
  return {
      {"points.ids",
       [](const py::handle&, const ResultData& data) {
         const IdTable& ids = data.point_ids();
         return Texts(ids.size(), [&ids](std::size_t i) { return ids[i]; });
       }},
      {"points.role",
       [](const py::handle& self, const ResultData& data) { return Codes(self, data.roles()); }},
      {"points.status",
       [](const py::handle& self, const ResultData& data) {
         return Codes(self, data.points().status);
       }},
      {"points.reason", [](const py::handle&, const ResultData& data) { return Reasons(data); }},
      {"points.looks",
       [](const py::handle& self, const ResultData& data) {
         return View(self, data.points().looks);
       }},
      {"points.position_m",
       [](const py::handle& self, const ResultData& data) {
         return VectorView(self, data.points().position_m);
       }},
      {"points.covariance_enu_m2",
       [](const py::handle&, const ResultData& data) {
         return OptionalCovariances(data.points().covariance_m2);
       }},
      {"points.fixed_path_covariance_enu_m2",
       [](const py::handle&, const ResultData& data) {
         return OptionalCovariances(data.points().fixed_path_covariance_m2);
       }},
      {"points.intersection_rad", column(&PointResults::intersection_rad)},
      {"points.redundancy_1", column(&PointResults::redundancy)},
      {"points.sigma_leberl_across_m", column(&PointResults::sigma_leberl_across_m)},
      {"points.sigma_leberl_up_m", column(&PointResults::sigma_leberl_up_m)},
      {"points.sigma_leberl_path_across_m", column(&PointResults::sigma_leberl_path_across_m)},
      {"points.sigma_leberl_path_up_m", column(&PointResults::sigma_leberl_path_up_m)},
      {"points.leberl_across_azimuth_rad", column(&PointResults::leberl_across_azimuth_rad)},
  };
}

ResultArrays CorrectionArrays() {
  const auto texts = [](std::string ParameterResult::*member) {
    return [member](const py::handle&, const ResultData& data) {
      return ParameterTexts(data, member);
    };
  };
  constexpr auto kEntries = &ResultData::parameter_covariance;
  return {
      {"corrections.owner", texts(&ParameterResult::owner)},
      {"corrections.name", texts(&ParameterResult::name)},
      {"corrections.unit", texts(&ParameterResult::unit)},
      {"corrections.value", Column(&ResultData::parameters, &ParameterResult::value)},
      {"corrections.sigma", Column(&ResultData::parameters, &ParameterResult::sigma)},
      {"corrections.prior_sigma", Column(&ResultData::parameters, &ParameterResult::prior_sigma)},
      {"corrections.covariance_row", Column(kEntries, &ParameterCovariance::a)},
      {"corrections.covariance_column", Column(kEntries, &ParameterCovariance::b)},
      {"corrections.covariance_value", Column(kEntries, &ParameterCovariance::covariance)},
  };
}

ResultArrays LookArrays() {
  const auto of_looks = []<typename Number>(std::vector<Number> LookResults::*member) {
    return [member](const py::handle& self, const ResultData& data) {
      return OptionalView(self, data.looks().*member);
    };
  };
  const auto quality = [](std::array<std::vector<float>, 2> LookQuality::*member,
                          std::size_t component) {
    return [member, component](const py::handle& self, const ResultData& data) {
      return OptionalView(self, (data.quality().*member)[component]);
    };
  };
  return {
      {"looks.offsets",  // by point, where the looks are those of a block
       [](const py::handle& self, const ResultData& data) -> py::object {
         if (data.file) return py::none();
         return View(self, data.solved->block().looks.offsets);
       }},
      {"looks.point_index",
       [](const py::handle& self, const ResultData& data) -> py::object {
         if (data.file) return View(self, data.file->looks.point);
         return py::none();
       }},
      {"looks.pass_index",
       [](const py::handle& self, const ResultData& data) {
         return View(self, data.file ? data.file->looks.pass : data.solved->block().looks.pass);
       }},
      {"looks.range_residual_m", of_looks(&LookResults::range_residual_m)},
      {"looks.azimuth_residual_m", of_looks(&LookResults::azimuth_residual_m)},
      {"looks.reduction_range_m",
       [](const py::handle& self, const ResultData& data) {
         return OptionalView(self, data.reductions().range_m);
       }},
      {"looks.reduction_time_s",
       [](const py::handle& self, const ResultData& data) {
         return OptionalView(self, data.reductions().time_s);
       }},
      {"looks.weight", of_looks(&LookResults::weight)},
      {"looks.rejected", of_looks(&LookResults::rejected)},
      {"looks.flags",
       [](const py::handle& self, const ResultData& data) -> py::object {
         if (data.file) return py::none();
         return View(self, data.solved->block().looks.flags);
       }},
      {"looks.reason",
       [](const py::handle& self, const ResultData& data) -> py::object {
         const std::vector<RejectReason>& reasons = data.looks().reason;
         if (reasons.empty()) return py::none();
         return Codes(self, reasons);
       }},
      {"looks.range_redundancy_1", quality(&LookQuality::redundancy, 0)},
      {"looks.azimuth_redundancy_1", quality(&LookQuality::redundancy, 1)},
      {"looks.range_w_1", quality(&LookQuality::w, 0)},
      {"looks.azimuth_w_1", quality(&LookQuality::w, 1)},
  };
}

ResultArrays OtherArrays() {
  return {
      {"checks.point_index", Column(&ResultData::checks, &CheckResult::point)},
      {"checks.error_enu_m", Vectors(&ResultData::checks, &CheckResult::error_enu_m)},
      {"checks.sigma_enu_m", Vectors(&ResultData::checks, &CheckResult::sigma_enu_m)},
      {"checks.chi_square_1", Column(&ResultData::checks, &CheckResult::chi_square)},
      {"strips.pass_index", Column(&ResultData::strips, &StripStation::pass)},
      {"strips.time_s", Column(&ResultData::strips, &StripStation::time_s)},
      {"strips.strip_time_1", Column(&ResultData::strips, &StripStation::strip_time)},
      {"strips.antenna_m", Vectors(&ResultData::strips, &StripStation::antenna_m)},
      {"strips.correction_m", Vectors(&ResultData::strips, &StripStation::correction_m)},
      {"strips.correction_sigma_m",
       Vectors(&ResultData::strips, &StripStation::correction_sigma_m)},
      {"pairs.first_index", Column(&ResultData::pairs, &PairResult::a)},
      {"pairs.second_index", Column(&ResultData::pairs, &PairResult::b)},
      {"pairs.difference_enu_m", Vectors(&ResultData::pairs, &PairResult::difference_enu_m)},
      {"pairs.covariance_enu_m2",
       [](const py::handle&, const ResultData& data) {
         const std::vector<PairResult>& pairs = data.pairs();
         static const PairResult kNothing{};
         const PairResult& first = pairs.empty() ? kNothing : pairs.front();
         return Covariances(pairs.size(), &first.covariance_m2, sizeof(PairResult));
       }},
  };
}

const ResultArrays& ResultArrayTable() {
  static const ResultArrays table = [] {
    ResultArrays all = PointArrays();
    for (ResultArrays part : {CorrectionArrays(), LookArrays(), OtherArrays()}) all.merge(part);
    return all;
  }();
  return table;
}

py::array States(const py::object& self, std::size_t pass) {
  const auto& data = self.cast<const ResultData&>();
  const std::size_t passes =
      data.file ? data.file->passes.size() : data.solved->result.corrected_paths.size();
  if (pass >= passes) throw py::index_error("no such pass");
  const FlightPath& path =
      data.file ? data.file->passes[pass].path : data.solved->result.corrected_paths[pass];
  return StatesView(self, path.states());
}

/// The tables of a result have more than is read; they are copied if they are unchanged.
void RequireSame(const ResultData& data) {
  const std::string summary =
      TablesAt(data.path, FolderContent::kResult)->Read("summary.json").second;
  if (summary == data.file->summary.json) return;
  throw InputError(data.path.string(),
                   "is another result now than the one that was read, whose tables are needed to "
                   "write it");
}

void WriteResultData(const ResultData& data,
                     const std::filesystem::path& path,
                     bool gzip,
                     bool force,
                     const py::object& progress) {
  const Compression compression = gzip ? Compression::kGzip : Compression::kNone;
  RunUnlocked(progress, [&](ProgressSink* sink) {
    if (data.file) {
      RequireSame(data);
      RequireFolderFor(
          FolderContent::kResult, path, force ? ForeignFiles::kReplace : ForeignFiles::kRefuse);
      files::Convert(data.path, path, compression, sink);
      return;
    }
    const SolvedBlock& solved = *data.solved;
    std::error_code ignored;
    if (std::filesystem::equivalent(solved.source->path, path, ignored)) {
      throw InputError(path.string(),
                       "is the block, whose tables the result would overwrite; any other name is "
                       "allowed");
    }
    RequireFolderFor(
        FolderContent::kResult, path, force ? ForeignFiles::kReplace : ForeignFiles::kRefuse);
    files::ResultContext context = solved.context;
    context.compression = compression;
    static_cast<void>(
        files::WriteResult(path, solved.block(), solved.options, solved.result, context));
  });
}

std::optional<std::vector<Eigen::Vector3d>> PositionsOf(const BlockData& block,
                                                        const py::object& positions_m) {
  if (positions_m.is_none()) return std::nullopt;
  const auto array =
      py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(positions_m);
  if (!array) throw py::error_already_set();
  const auto points = static_cast<py::ssize_t>(block.file.block.points.size());
  if (array.ndim() != 2 || array.shape(0) != points || array.shape(1) != 3) {
    throw InputError("positions_m",
                     "has the shape " + std::string(py::str(array.attr("shape"))) + ", (" +
                         std::to_string(points) + ", 3) is needed");
  }
  std::vector<Eigen::Vector3d> out;
  out.reserve(static_cast<std::size_t>(points));
  for (py::ssize_t i = 0; i < points; ++i) {
    out.emplace_back(array.at(i, 0), array.at(i, 1), array.at(i, 2));
    if (out.back().array().isInf().any()) {
      throw InputError("positions_m[" + std::to_string(i) + "]",
                       "is not finite; finite numbers are allowed, nan where a position is not "
                       "known");
    }
  }
  return out;
}

Task TaskOf(const std::string& name) {
  return name == "adjust" ? Task::kAdjust : name == "intersect" ? Task::kIntersect : Task::kPredict;
}

std::shared_ptr<ResultData> Shown(const std::shared_ptr<const ResultData>& data) {
  return std::const_pointer_cast<ResultData>(data);
}

}  // namespace

void BindResult(py::module_* module) {
  py::class_<ResultData, std::shared_ptr<ResultData>>(
      *module, "Result", "A result in memory; sarblock.Result is what people use.")
      .def_property_readonly("pass_ids", &ResultData::PassIds)
      .def_property_readonly(
          "local_frame",
          [](const ResultData& data) { return data.frame().kind() == FrameKind::kLocal; })
      .def("summary", &ResultData::Summary, "The content of summary.json.")
      .def(
          "array",
          [](const py::object& self, const std::string& name) {
            return ResultArrayTable().at(name)(self, self.cast<const ResultData&>());
          },
          py::arg("name"),
          "One of the result's arrays by the name of the property that shows it.")
      .def("states",
           &States,
           py::arg("index"),
           "Corrected state vectors of a pass, (states, 7): time [s], position [m], velocity "
           "[m/s].")
      .def(
          "geodetic",
          [](const ResultData& data) {
            const std::vector<Eigen::Vector3d>& positions_m = data.points().position_m;
            py::array_t<double> out({static_cast<py::ssize_t>(positions_m.size()), py::ssize_t{3}});
            double* to = out.mutable_data();
            for (const Eigen::Vector3d& position_m : positions_m) {
              Geodetic place{kNotGiven, kNotGiven, kNotGiven};
              if (position_m.allFinite()) place = data.frame().GeodeticFromFrame(position_m);
              for (const double value : {place.lat_rad, place.lon_rad, place.h_m}) *to++ = value;
            }
            return out;
          },
          "Latitude [rad], longitude [rad] and height [m] of the points, (points, 3).")
      .def("write",
           &WriteResultData,
           py::arg("path"),
           py::arg("gzip"),
           py::arg("force"),
           py::arg("progress"),
           "Writes a result folder or an HDF5 file.");
  module->def(
      "solve",
      [](const std::string& task,
         const std::shared_ptr<BlockData>& block,
         const std::vector<std::string>& set,
         int threads,
         const py::object& positions_m,
         const py::object& progress) {
        const auto positions = PositionsOf(*block, positions_m);
        return Shown(RunWork(progress, [&](ProgressSink* sink) {
          return Solve(TaskOf(task), block, set, threads, positions, sink);
        }));
      },
      py::arg("task"),
      py::arg("block"),
      py::arg("set"),
      py::arg("threads"),
      py::arg("positions_m"),
      py::arg("progress"),
      "Adjusts, intersects or predicts a block.");
  module->def(
      "read_result",
      [](const std::filesystem::path& path, const py::object& progress) {
        return Shown(
            RunWork(progress, [&](ProgressSink* sink) { return ReadResultAt(path, sink); }));
      },
      py::arg("path"),
      py::arg("progress"),
      "Reads a result folder or an HDF5 file.");
}

}  // namespace sarblock::python
