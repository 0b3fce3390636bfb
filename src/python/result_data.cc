// SPDX-License-Identifier: Apache-2.0
#include "result_data.h"

#include "sarblock/adjust/adjust.h"
#include "sarblock/core/error.h"
#include "sarblock/diagnose/diagnose.h"
#include "sarblock/files/result.h"

#include <algorithm>
#include <cmath>

#include "tables/table.h"

namespace sarblock::python {
namespace {

constexpr const char* kTaskNames[] = {"adjust", "intersect", "predict"};

/// A plan, read without measured values, can only be predicted.
void RequireMeasurements(const BlockData& data, Task task) {
  if (data.measurements == Measurements::kRequired || task == Task::kPredict) return;
  const Looks& looks = data.file.block.looks;
  for (std::size_t look = 0; look < looks.size(); ++look) {
    if (!std::isnan(looks.time_s[look]) && !std::isnan(looks.range_m[look])) continue;
    throw InputError("looks[" + std::to_string(look) + "]",
                     std::string("has no measured time and range, which ") +
                         kTaskNames[static_cast<std::size_t>(task)] + " needs; predict needs none");
  }
}

/// The files of a block as it was read, with lists that these options name beside.
std::vector<InputFile> InputsOf(const BlockData& data, const AdjustOptions& options) {
  if (data.path.empty()) return {};
  std::vector<InputFile> inputs = data.inputs;
  const AdjustOptions& read = data.file.adjust;
  if (options.pairs_file == read.pairs_file && options.rejections_file == read.rejections_file) {
    return inputs;
  }
  for (InputFile& input : ListInputFiles(data.path, options)) {
    const auto same = [&input](const InputFile& known) { return known.name == input.name; };
    if (std::none_of(inputs.begin(), inputs.end(), same)) inputs.push_back(std::move(input));
  }
  return inputs;
}

AdjustResult Run(Task task,
                 const SolvedBlock& solved,
                 const std::optional<std::vector<Eigen::Vector3d>>& positions_m,
                 ProgressSink* progress) {
  const Block& block = solved.block();
  const AdjustOptions& options = solved.options;
  if (task == Task::kIntersect) return IntersectBlock(block, options, progress);
  PointPairs pairs;
  if (options.pairs == PairChoice::kList) {
    pairs = ReadPairs(HomeOf(*solved.source), options.pairs_file, block);
  }
  if (task == Task::kAdjust) {
    try {
      return Adjust(block, options, pairs, progress);
    } catch (const UndeterminedError& refusal) {
      if (!options.diagnose) throw;
      throw ExplainedRefusal(refusal, Diagnose(block, options, progress).Sentences());
    }
  }
  return Predict(block,
                 options,
                 positions_m ? *positions_m : TruthOf(*solved.source).points_m,
                 pairs,
                 progress);
}

}  // namespace

std::vector<std::string> ResultData::PassIds() const {
  std::vector<std::string> ids;
  if (file) {
    for (const ResultPass& pass : file->passes) ids.push_back(pass.id);
  } else {
    for (const Pass& pass : solved->block().passes) ids.push_back(pass.id);
  }
  return ids;
}

std::string ResultData::Summary() const {
  if (file) return file->summary.json;
  return SummaryJson(solved->block(), solved->options, solved->result, solved->context);
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
        ApplyRejections(HomeOf(*block), solved.options.rejections_file, &*solved.changed));
  }
  const std::vector<std::string>& warnings = block->file.warnings;
  solved.context.command = kTaskNames[static_cast<std::size_t>(task)];
  solved.context.warnings = warnings;
  solved.context.inputs = InputsOf(*block, solved.options);
  solved.result =
      Naming(block->path.string(), [&] { return Run(task, solved, positions_m, progress); });
  if (task == Task::kAdjust) {
    solved.context.diagnosis =
        ExplainFailure(solved.block(), solved.options, warnings, &solved.result, progress);
  }
  return data;
}

std::shared_ptr<const ResultData> ReadResultAt(const std::filesystem::path& path,
                                               ProgressSink* progress) {
  ReadResultOptions options;
  options.progress = progress;
  auto data = std::make_shared<ResultData>();
  data->file = ReadResult(path, options);
  data->path = std::filesystem::absolute(path);
  return data;
}

}  // namespace sarblock::python
