// SPDX-License-Identifier: Apache-2.0
#include "open.h"

#include "sarblock/core/error.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "checksum.h"
#include "core/threads.h"
#include "csv.h"
#include "hdf5_tables.h"
#include "json.h"

namespace sarblock {
namespace {

class TextSource final : public TableSource {
 public:
  TextSource(FileTexts texts, FolderContent content)
      : TableSource(content), texts_(std::move(texts)) {}
  std::pair<std::string, std::string> Read(std::string_view name) const override {
    const auto text = Find(name);
    if (!text) FailMissing(std::string(name), "file");
    return {std::string(name), std::string(*text)};
  }
  std::unique_ptr<TableReader> Open(std::string_view table, Schema schema) const override {
    const auto text = Find(NameOf(table));
    if (!text) return nullptr;
    return ReadCsvText(NameOf(table), *text, schema);
  }
  std::string NameOf(std::string_view table) const override { return std::string(table) + ".csv"; }
  std::string DefaultName() const override { return sarblock::NameOf(content()); }

 private:
  std::optional<std::string_view> Find(std::string_view name) const {
    for (const auto& [file, text] : texts_) {
      if (file == name) return text;
    }
    return std::nullopt;
  }
  FileTexts texts_;
};

}  // namespace

std::unique_ptr<TableSource> TablesOfTexts(FileTexts texts, FolderContent content) {
  return std::make_unique<TextSource>(std::move(texts), content);
}

namespace {

namespace fs = std::filesystem;

constexpr const char* kNotABlock = "is a result, not a block";
constexpr const char* kNotAResult = "is a block, not a result";

[[noreturn]] void FailKind(const fs::path& path, FolderContent content, const std::string& what) {
  const bool block = content == FolderContent::kBlock;
  throw InputError(FilePlace{path.string(), 0, ""},
                   what + "; a " + NameOf(content) + " is a folder with " +
                       (block ? "block.toml, trajectories.csv and observations.csv"
                              : "summary.json, points.csv, passes.csv, residuals.csv and "
                                "trajectories.csv") +
                       ", or an HDF5 file of these");
}

/// The tables that the summary of a result lists; nothing where it lists none, as summaries of
/// earlier versions, or where it cannot be read, which is reported when it is read.
std::optional<std::vector<TableSum>> ListedTables(const fs::path& summary) {
  std::ifstream stream(summary, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  try {
    const JsonFile json(text, summary.string());
    const auto tables = json.Root().Find("tables");
    if (!tables) return std::nullopt;
    std::vector<TableSum> sums;
    for (const JsonValue& table : tables->Entries()) {
      sums.push_back({table.Require("table").Text(),
                      table.Require("bytes").Count(),
                      table.Require("sha256").Text()});
    }
    return sums;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

class FolderSource final : public TableSource {
 public:
  FolderSource(fs::path folder, FolderContent content)
      : TableSource(content), folder_(std::move(folder)) {
    const bool block = fs::exists(folder_ / "block.toml");
    const bool result = fs::exists(folder_ / "summary.json");
    if (result && content == FolderContent::kResult) {
      listed_ = ListedTables(folder_ / "summary.json");
    }
    if (block == result) return;
    if (content == FolderContent::kBlock && result) FailKind(folder_, content, kNotABlock);
    if (content == FolderContent::kResult && block) FailKind(folder_, content, kNotAResult);
  }
  std::pair<std::string, std::string> Read(std::string_view name) const override {
    const fs::path file = folder_ / name;
    std::ifstream stream(file, std::ios::binary);
    if (!fs::is_regular_file(file) || !stream) FailMissing(file.string(), "file");
    return {file.string(), {std::istreambuf_iterator<char>(stream), {}}};
  }
  std::unique_ptr<TableReader> Open(std::string_view table, Schema schema) const override {
    const auto file = FindTable(folder_, table);
    const TableSum* const sum = Listed(table);
    if (file && listed_ && sum == nullptr) {
      throw InputError(FilePlace{file->string(), 0, ""},
                       "is not among the tables that summary.json lists: of another run");
    }
    if (file) return ReadCsv(*file, schema, sum != nullptr ? sum->sha256 : "");
    if (sum != nullptr) {
      throw InputError(FilePlace{NameOf(table), 0, ""},
                       "is missing (also as .csv.gz), summary.json lists this table");
    }
    return nullptr;
  }
  std::string NameOf(std::string_view table) const override {
    return (folder_ / (std::string(table) + ".csv")).string();
  }
  std::string DefaultName() const override { return NameAt(folder_); }

 private:
  [[nodiscard]] const TableSum* Listed(std::string_view table) const {
    if (!listed_) return nullptr;
    const auto found = std::find_if(
        listed_->begin(), listed_->end(), [&](const TableSum& sum) { return sum.table == table; });
    return found == listed_->end() ? nullptr : &*found;
  }

  fs::path folder_;
  std::optional<std::vector<TableSum>> listed_;
};

}  // namespace

std::unique_ptr<TableSource> TablesAt(const std::filesystem::path& path, FolderContent content) {
  if (!fs::exists(path)) FailKind(path, content, "does not exist");
  if (fs::is_directory(path)) return std::make_unique<FolderSource>(path, content);
  if (!IsContainer(path)) FailKind(path, content, "is a file that is no HDF5 file");
  const auto holds = ContentOf(path);
  if (holds && *holds != content) {
    FailKind(path, content, content == FolderContent::kBlock ? kNotABlock : kNotAResult);
  }
  return TablesOfContainer(path, content);
}

std::filesystem::path FolderOf(const std::filesystem::path& block) {
  return fs::is_regular_file(block) ? block.parent_path() : block;
}

FolderContent ContentAt(const fs::path& path) {
  if (IsContainer(path)) {
    if (const auto content = ContentOf(path)) return *content;
    throw InputError(FilePlace{path.string(), 0, ""},
                     "has neither the attribute block_toml nor summary_json: no file of sarblock");
  }
  const bool result = fs::exists(path / "summary.json");
  return result ? FolderContent::kResult : FolderContent::kBlock;
}

std::optional<std::filesystem::path> FindTable(const std::filesystem::path& folder,
                                               std::string_view name) {
  const fs::path plain = folder / (std::string(name) + ".csv");
  const fs::path gzip = folder / (std::string(name) + ".csv.gz");
  const bool has_plain = fs::exists(plain), has_gzip = fs::exists(gzip);
  if (has_plain && has_gzip) {
    throw InputError(FilePlace{gzip.string(), 0, ""},
                     "excludes " + plain.filename().string() + "; give one of both");
  }
  if (has_plain) return plain;
  if (has_gzip) return gzip;
  return std::nullopt;
}

namespace {

TableSum SumOf(std::string_view table, const std::filesystem::path& file) {
  const std::unique_ptr<TableBytes> source = OpenBytes(file);
  std::vector<char> buffer(std::size_t{1} << 18U);
  std::string problem;
  Sha256 sum;
  TableSum out{std::string(table), 0, {}};
  while (const std::size_t got = source->Read(buffer.data(), buffer.size(), &problem)) {
    sum.Add({buffer.data(), got});
    out.bytes += got;
  }
  if (!problem.empty()) throw InputError(FilePlace{file.string(), 0, ""}, problem);
  out.sha256 = sum.Digits();
  return out;
}

}  // namespace

std::vector<TableSum> SumsOfTables(const std::filesystem::path& folder, FolderContent content) {
  std::vector<std::pair<std::string_view, std::filesystem::path>> files;
  for (const TableDescription& table : TablesOf(content)) {
    if (const auto file = FindTable(folder, table.name)) files.emplace_back(table.name, *file);
  }
  std::vector<TableSum> sums(files.size());
  ParallelForChunks(files.size(), 1, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) sums[i] = SumOf(files[i].first, files[i].second);
  });
  return sums;
}

namespace {

class FolderSink final : public TableSink {
 public:
  FolderSink(std::filesystem::path folder, Compression compression)
      : folder_(std::move(folder)), compression_(compression) {}
  std::unique_ptr<TableWriter> Open(std::string_view table,
                                    Schema schema,
                                    std::span<const std::string_view> left_out) override {
    const char* const ending = compression_ == Compression::kGzip ? ".csv.gz" : ".csv";
    return WriteCsv(folder_ / (std::string(table) + ending), schema, compression_, left_out);
  }
  void WriteText(std::string_view file, std::string_view text) override {
    AtomicFile out(folder_ / file);
    out.Write(text);
    out.Commit();
  }
  std::optional<std::filesystem::path> folder() const override { return folder_; }

 private:
  std::filesystem::path folder_;
  Compression compression_;
};

// Every file that such a folder may have, so that an earlier one leaves nothing beside this one
// that could be taken for it: no table in the other compression, none that this one has not, no
// report.
std::vector<std::string> KnownFiles(FolderContent content) {
  std::vector<std::string> names;
  if (content == FolderContent::kResult) {
    names = {"points.geojson", "report.html", "comparison.html"};
  }
  for (const TableDescription& table : TablesOf(content)) {
    for (const char* ending : {".csv", ".csv.gz"}) {
      names.push_back(std::string(table.name) + ending);
    }
  }
  return names;
}

}  // namespace

void WriteTables(FolderContent content,
                 const std::filesystem::path& target,
                 Compression compression,
                 const BlockIds& ids,
                 const std::function<void(TableSink*)>& write) {
  if (NamesContainer(target)) {
    WriteContainer(target, compression, ids, write);
    return;
  }
  StagedFolder staged(content, target);
  staged.Write([&](const std::filesystem::path& to) {
    FolderSink sink(to, compression);
    write(&sink);
    if (content == FolderContent::kBlock) NoteWritten(to);
  });
  staged.Publish(KnownFiles(content));
}

}  // namespace sarblock
