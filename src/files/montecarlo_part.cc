// SPDX-License-Identifier: Apache-2.0
#include "montecarlo_part.h"

#include "sarblock/core/error.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <system_error>
#include <utility>

#include "quality/montecarlo.h"
#include "summary.h"
#include "tables/json.h"
#include "tables/open.h"
#include "tables/table.h"
#include <fmt/format.h>

namespace sarblock {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kPartFormat = "sarblock-part 1";
constexpr const char* kPartFile = "part.json";
constexpr std::array<const char*, 2> kPartTables = {"draws", "sums"};

[[noreturn]] void RefusePart(const fs::path& folder, const std::string& problem) {
  throw InputError(FilePlace{folder.string(), 0, ""}, problem);
}

std::string SolutionText(const MonteCarloDraws& draws) {
  return fmt::format("{:016x}", draws.solution);
}

constexpr std::array kRatios =
    kDrawColumns("variance_ratio_e", "variance_ratio_n", "variance_ratio_u");
constexpr std::array kCoverages = kDrawColumns("coverage_50", "coverage_90", "coverage_99");
constexpr std::array kProducts =
    kSumColumns("sum_ee", "sum_nn", "sum_uu", "sum_en", "sum_eu", "sum_nu");
constexpr std::array kInside = kSumColumns("inside_50", "inside_90", "inside_99");

void WriteDraws(const MonteCarloDraws& draws, TableSink* sink) {
  const auto table = sink->Open("draws", kDrawColumns);
  WriteEach(draws.runs.size(), table.get(), [&](std::size_t i, Batch* batch) {
    const MonteCarloRun& run = draws.runs[i];
    NewRow row(batch);
    row.Integer(kDrawColumns("run"), run.run);
    row.Integer(kDrawColumns("converged"), run.converged ? 1 : 0);
    if (!run.converged) return;
    row.Numbers(kRatios, run.variance_ratio);
    row.Number(kDrawColumns("normalised_square"), run.square);
    row.Numbers(kCoverages, run.inside);
  });
  table->Commit();
}

void WriteSums(const MonteCarloDraws& draws, const IdTable& ids, TableSink* sink) {
  const auto table = sink->Open("sums", kSumColumns);
  WriteEach(draws.points.size(), table.get(), [&](std::size_t i, Batch* batch) {
    const MonteCarloPoint& sums = draws.points[i];
    NewRow row(batch);
    row.Id(kSumColumns("point"), ids, sums.point);
    for (std::size_t k = 0; k < kProducts.size(); ++k) {
      row.Text(kProducts[k], sums.product[k].Text());
    }
    row.Text(kSumColumns("sum_square"), sums.square.Text());
    for (std::size_t k = 0; k < kInside.size(); ++k) row.Integer(kInside[k], sums.inside[k]);
  });
  table->Commit();
}

/// The tables in a folder, with their checksums.
std::vector<InputFile> TablesIn(const fs::path& folder) {
  std::vector<InputFile> tables;
  for (const char* name : kPartTables) {
    const auto file = FindTable(folder, name);
    if (!file) RefusePart(folder, fmt::format("has no table {}.csv", name));
    tables.push_back({file->filename().string(), fs::file_size(*file), Sha256OfFile(*file)});
  }
  return tables;
}

std::vector<InputFile> ReadFileList(const JsonValue& list) {
  std::vector<InputFile> files;
  for (const JsonValue& entry : list.Entries()) {
    files.push_back({entry.Require("file").Text(),
                     entry.Require("bytes").Count(),
                     entry.Require("sha256").Text()});
  }
  return files;
}

/// The first file that both lists do not have alike; empty: there is none.
std::string OtherFile(const std::vector<InputFile>& a, const std::vector<InputFile>& b) {
  const auto lacks = [](const std::vector<InputFile>& files, const InputFile& of) {
    return std::none_of(files.begin(), files.end(), [&of](const InputFile& file) {
      return file.name == of.name && file.sha256 == of.sha256;
    });
  };
  for (const InputFile& file : a) {
    if (lacks(b, file)) return file.name;
  }
  for (const InputFile& file : b) {
    if (lacks(a, file)) return file.name;
  }
  return {};
}

/// What a part was drawn with that does not hold here; empty: nothing. Threads change no digit, and
/// the list of rejections stands among the inputs, wherever it lies.
std::string OtherOption(const Json& there, const Json& here) {
  const auto text = [](const Json& table, const std::string& key) {
    return table.contains(key) ? table[key].dump(-1, ' ', false, Json::error_handler_t::replace)
                               : std::string("not given");
  };
  Json all = here;
  all.update(there);
  for (const auto& [key, value] : all.items()) {
    if (key == "threads" || key == "rejections") continue;
    const std::string a = text(there, key), b = text(here, key);
    if (a == b) continue;
    constexpr std::size_t kShort = 40;
    if (a.size() > kShort || b.size() > kShort) return key + " is not the same";
    return fmt::format("{} is {}, here it is {}", key, a, b);
  }
  return {};
}

PartOrigin OriginIn(const fs::path& folder) {
  std::error_code ignored;
  if (!fs::is_regular_file(folder / kPartFile, ignored)) {
    RefusePart(folder,
               fmt::format("holds no part of an adjustment: there is no file {}", kPartFile));
  }
  return ReadPartOrigin(*TablesAt(folder, FolderContent::kPart));
}

ExactSum SumIn(const Row& row, std::size_t column, std::uint32_t terms) {
  const auto sum = ExactSum::FromText(row.Text(column));
  if (!sum) row.Fail(column, "is no integer");
  if (!sum->HasTerms(terms)) row.Fail(column, fmt::format("is no sum of {} runs", terms));
  return *sum;
}

/// Returns how many runs converged.
std::uint32_t AddRuns(const TableSource& source,
                      const TaskPart& part,
                      std::size_t runs,
                      MonteCarloDraws* draws) {
  const auto table = source.Require("draws", kDrawColumns);
  const std::size_t count = part.TasksOf(runs);
  std::uint32_t converged = 0;
  std::size_t read = 0;
  ForRows(table.get(), [&](const Row& row) {
    MonteCarloRun run;
    run.run = row.Count(kDrawColumns("run"));
    if (read >= count || run.run != part.index + read * part.count) {
      row.Fail(kDrawColumns("run"), "is not the run that stands here in " + NameOf(part));
    }
    run.converged = row.Flag(kDrawColumns("converged"));
    if (run.converged) {
      for (std::size_t i = 0; i < 3; ++i) {
        run.variance_ratio[i] = row.RequiredNumber(kRatios[i]);
        run.inside[i] = row.RequiredNumber(kCoverages[i]);
      }
      run.square = row.RequiredNumber(kDrawColumns("normalised_square"));
      ++converged;
    }
    draws->runs.push_back(run);
    ++read;
  });
  if (read != count) {
    throw InputError(FilePlace{table->file(), 0, "run"},
                     fmt::format("has {} of {} runs of {}", read, count, NameOf(part)));
  }
  return converged;
}

void AddSums(const TableSource& source,
             std::uint32_t converged,
             const IdTable& ids,
             MonteCarloDraws* draws) {
  const auto table = source.Require("sums", kSumColumns);
  constexpr std::size_t kId = kSumColumns("point");
  std::size_t read = 0;
  ForRows(table.get(), [&](const Row& row) {
    if (read >= draws->points.size() || row.Id(kId) != ids[draws->points[read].point]) {
      row.Fail(kId, "is not the point that stands here in the block");
    }
    MonteCarloPoint& sums = draws->points[read++];
    for (std::size_t k = 0; k < kProducts.size(); ++k) {
      sums.product[k].Add(SumIn(row, kProducts[k], converged));
    }
    sums.square.Add(SumIn(row, kSumColumns("sum_square"), converged));
    for (std::size_t i = 0; i < kInside.size(); ++i) {
      const std::uint32_t inside = row.Count(kInside[i]);
      if (inside > converged) {
        row.Fail(kInside[i], fmt::format("is more than {} runs", converged));
      }
      sums.inside[i] += inside;
    }
  });
  if (read != draws->points.size()) {
    throw InputError(FilePlace{table->file(), 0, "point"},
                     fmt::format("has {} of {} points", read, draws->points.size()));
  }
}

}  // namespace

std::string WriteMonteCarloPart(const fs::path& folder,
                                const Block& block,
                                const AdjustOptions& options,
                                const MonteCarloDraws& draws,
                                const std::vector<InputFile>& inputs,
                                Compression compression) {
  const TaskPart part = options.montecarlo_part.value_or(TaskPart{});
  const std::size_t number = part.index == 0 ? part.count : part.index;
  std::string text;
  const auto write = [&](TableSink* sink) {
    WriteDraws(draws, sink);
    WriteSums(draws, block.points.ids, sink);
    Json origin;
    origin["format"] = kPartFormat;
    origin["version"] = Version();
    origin["block"] = block.name;
    origin["part"] = fmt::format("{}/{}", number, part.count);
    origin["runs"] = draws.runs.size();
    origin["failed"] = std::count_if(draws.runs.begin(),
                                     draws.runs.end(),
                                     [](const MonteCarloRun& run) { return !run.converged; });
    origin["solution"] = SolutionText(draws);
    origin["tables"] = InputsJson(TablesIn(*sink->folder()));
    origin["inputs"] = InputsJson(inputs);
    origin["configuration"] = ConfigurationJson(options);
    text = origin.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
    sink->WriteText(kPartFile, text);
  };
  WriteTables(FolderContent::kPart, folder, compression, {}, write);
  return text;
}

PartOrigin ReadPartOrigin(const TableSource& source) {
  const auto [file, text] = source.Read(kPartFile);
  const JsonFile parsed(text, file);
  const JsonValue root = parsed.Root();
  const JsonValue format = root.Require("format");
  if (format.Text() != kPartFormat) {
    format.Fail(fmt::format("\"{}\" is allowed", kPartFormat));
  }
  PartOrigin origin;
  origin.version = root.Require("version").Text();
  const JsonValue part = root.Require("part");
  const auto held = TaskPartOf(part.Text());
  if (!held) part.Fail("is no part I/N");
  origin.part = *held;
  origin.solution = root.Require("solution").Text();
  origin.tables = ReadFileList(root.Require("tables"));
  origin.inputs = ReadFileList(root.Require("inputs"));
  const JsonValue configuration = root.Require("configuration");
  if (!configuration.IsObject()) configuration.Fail("is no table of options");
  origin.configuration = configuration.Node();
  return origin;
}

void AddPartTables(const TableSource& source,
                   const TaskPart& part,
                   std::size_t runs,
                   const IdTable& ids,
                   MonteCarloDraws* draws) {
  AddSums(source, AddRuns(source, part, runs, draws), ids, draws);
}

MonteCarloParts::MonteCarloParts(const std::vector<std::string>& folders,
                                 const AdjustOptions& options,
                                 const std::vector<InputFile>& inputs) {
  const Json configuration = ConfigurationJson(options);
  for (const std::string& folder : folders) {
    PartOrigin origin = OriginIn(folder);
    if (origin.version != Version()) {
      RefusePart(folder,
                 fmt::format("was drawn by sarblock {}, this is {}", origin.version, Version()));
    }
    if (const std::string file = OtherFile(origin.inputs, inputs); !file.empty()) {
      RefusePart(folder, "belongs to another block: " + file + " is not the same");
    }
    if (const std::string other = OtherOption(origin.configuration, configuration);
        !other.empty()) {
      RefusePart(folder, "was drawn with other options: " + other);
    }
    if (const std::string file = OtherFile(origin.tables, TablesIn(folder)); !file.empty()) {
      RefusePart(folder, "is damaged: " + file + " has another checksum than part.json says");
    }
    folders_.Add(folder, origin.part);
    origins_.push_back(std::move(origin));
  }
  folders_.RequireAll();
}

void MonteCarloParts::Join(const Block& block,
                           const AdjustOptions& options,
                           AdjustResult* result) const {
  MonteCarloDraws& draws = *result->montecarlo_draws;
  const std::string solution = SolutionText(draws);
  for (std::size_t i = 0; i < origins_.size(); ++i) {
    if (origins_[i].solution == solution) continue;
    RefusePart(folders_.folders()[i],
               "its draws are about a solution with other last digits than this one: parts and "
               "join need the same program and libraries on processors for which OpenBLAS takes "
               "the same kernels (OPENBLAS_CORETYPE sets them), and with engine = \"ceres\" the "
               "same --threads");
  }
  const auto runs = static_cast<std::size_t>(options.montecarlo_runs);
  for (std::size_t i = 0; i < origins_.size(); ++i) {
    const auto source = TablesAt(folders_.folders()[i], FolderContent::kPart);
    AddPartTables(*source, origins_[i].part, runs, block.points.ids, &draws);
  }
  std::sort(draws.runs.begin(),
            draws.runs.end(),
            [](const MonteCarloRun& a, const MonteCarloRun& b) { return a.run < b.run; });
  result->montecarlo =
      ReportMonteCarlo(draws, options.montecarlo_seed, result->points.covariance_m2);
  result->montecarlo_draws.reset();
}

}  // namespace sarblock
