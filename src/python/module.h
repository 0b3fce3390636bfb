// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/error.h"
#include "sarblock/core/progress.h"
#include "sarblock/files/block_file.h"
#include "sarblock/files/result.h"
#include "sarblock/model/result.h"

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <pybind11/pybind11.h>

namespace sarblock::python {

/// A block in memory, never changed once it is made, and what is needed to read `[adjust]` anew
/// with other options.
struct BlockData {
  files::BlockFile file;
  Truth truth;                           ///< of a simulation
  std::string toml;                      ///< place of [adjust]
  std::string toml_name;                 ///< for messages
  std::vector<std::string> overrides;    ///< KEY=VALUE that it was read with
  std::filesystem::path path;            ///< absolute; empty: it was never a file
  std::vector<files::InputFile> inputs;  ///< of the path, as they were when it was read
  files::Measurements measurements = files::Measurements::kRequired;
};
using BlockPointer = std::shared_ptr<const BlockData>;

[[nodiscard]] BlockPointer ReadBlockAt(const std::filesystem::path& path,
                                       const std::vector<std::string>& overrides,
                                       files::Measurements measurements,
                                       ProgressSink* progress);
[[nodiscard]] BlockPointer BlockOfArrays(const files::BlockArrays& arrays,
                                         files::Measurements measurements,
                                         ProgressSink* progress);
/// `text` is that of a scene, or null: the file `name` is read.
[[nodiscard]] BlockPointer SimulateScene(const std::string& name,
                                         const std::string* text,
                                         const std::vector<std::string>& overrides,
                                         int threads,
                                         ProgressSink* progress);

/// The options of the block with others over them.
[[nodiscard]] files::AdjustTable OptionsOf(const BlockData& data,
                                           const std::vector<std::string>& overrides,
                                           int threads);
/// The folder from which the names of lists count.
[[nodiscard]] std::filesystem::path HomeOf(const BlockData& data);
/// Throws InputError where a list that the block itself names is not what it was when the block was
/// read.
void RequireAsRead(const BlockData& data, const std::string& list);

void BindBlock(pybind11::module_* module);

/// A block that is not determined, with the explanations of its diagnosis, the most likely first.
class ExplainedRefusal : public UndeterminedError {
 public:
  ExplainedRefusal(const UndeterminedError& refusal, std::vector<std::string> sentences)
      : UndeterminedError(refusal), sentences_(std::move(sentences)) {}
  [[nodiscard]] const std::vector<std::string>& sentences() const { return sentences_; }

 private:
  std::vector<std::string> sentences_;
};

enum class Task { kAdjust, kIntersect, kPredict };

/// A result with the block that it is of.
struct SolvedBlock {
  BlockPointer source;
  std::optional<Block> changed;  ///< where a list of rejections left looks out
  files::AdjustTable options;
  AdjustResult result;
  files::ResultContext context;
  [[nodiscard]] const Block& block() const { return changed ? *changed : source->file.block; }
};

/// A result in memory, never changed once it is made: solved here, or read from files.
struct ResultData {
  std::optional<SolvedBlock> solved;
  std::optional<files::ResultFile> file;  ///< where it is not solved
  std::filesystem::path path;             ///< of what was read

  [[nodiscard]] const PointResults& points() const {
    return file ? file->points.results : solved->result.points;
  }
  [[nodiscard]] const IdTable& point_ids() const {
    return file ? file->points.ids : solved->block().points.ids;
  }
  [[nodiscard]] const std::vector<PointRole>& roles() const {
    return file ? file->points.role : solved->block().points.role;
  }
  [[nodiscard]] const std::vector<ParameterResult>& parameters() const {
    return file ? file->parameters : solved->result.parameters;
  }
  [[nodiscard]] const std::vector<ParameterCovariance>& parameter_covariance() const {
    return file ? file->parameter_covariance : solved->result.parameter_covariance;
  }
  [[nodiscard]] const std::vector<CheckResult>& checks() const {
    return file ? file->points.checks : solved->result.checks;
  }
  [[nodiscard]] const std::vector<StripStation>& strips() const {
    return file ? file->strips : solved->result.strips;
  }
  [[nodiscard]] const LookResults& looks() const {
    return file ? file->looks : solved->result.looks;
  }
  [[nodiscard]] const LookQuality& quality() const {
    return file ? file->looks.quality : solved->result.quality;
  }
  [[nodiscard]] const Reductions& reductions() const {
    return file ? file->reductions : solved->result.reductions;
  }
  [[nodiscard]] const std::vector<PairResult>& pairs() const {
    return file ? file->pairs : solved->result.pairs;
  }
  [[nodiscard]] std::vector<std::string> PassIds() const;
  [[nodiscard]] const Frame& frame() const { return file ? file->frame : solved->block().frame; }
  /// Content of summary.json.
  [[nodiscard]] std::string Summary() const;
};

/// Does what the command of the same name does between reading and writing. A refused adjustment
/// throws ExplainedRefusal, unless the options say not to look for the cause. `positions_m` are
/// those of Task::kPredict; without them the truth is taken where it is known.
[[nodiscard]] std::shared_ptr<const ResultData> Solve(
    Task task,
    const BlockPointer& block,
    const std::vector<std::string>& overrides,
    int threads,
    const std::optional<std::vector<Eigen::Vector3d>>& positions_m,
    ProgressSink* progress);

[[nodiscard]] std::shared_ptr<const ResultData> ReadResultAt(const std::filesystem::path& path,
                                                             ProgressSink* progress);

void BindResult(pybind11::module_* module);

/// Runs `work` in a thread of its own while the caller waits with the interpreter lock released, so
/// that other Python threads run. At least ten times per second the caller checks for signals and
/// calls `progress`, None or a callable (stage, done, total, detail), with the progress. Ctrl-C
/// asks the work to end and throws Interrupted; any other exception of a signal handler or of the
/// callable is thrown once the work has ended. BLAS then has as many threads as before.
void RunUnlocked(const pybind11::object& progress, const std::function<void(ProgressSink*)>& work);

/// Work that goes on in daemon threads when the interpreter ends is cancelled and waited for; their
/// threads then wait for the end of the process. Called once, when the module is imported.
void EndWorkWithInterpreter();

/// The same for work that returns something.
template <typename Work>
[[nodiscard]] auto RunWork(const pybind11::object& progress, const Work& work) {
  std::optional<std::invoke_result_t<Work, ProgressSink*>> out;
  RunUnlocked(progress, [&](ProgressSink* sink) { out.emplace(work(sink)); });
  return std::move(*out);
}

}  // namespace sarblock::python
