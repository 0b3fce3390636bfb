// SPDX-License-Identifier: Apache-2.0
#include "open.h"

#include "sarblock/core/error.h"
#include "sarblock/tables/output.h"

#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "csv.h"
#include "hdf5_tables.h"

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
  std::unique_ptr<TableReader> Open(std::string_view table,
                                    std::span<const TableColumn> columns) const override {
    const auto text = Find(NameOf(table));
    if (!text) return nullptr;
    return std::make_unique<CsvReader>(NameOf(table), *text, columns);
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

class FolderSource final : public TableSource {
 public:
  FolderSource(fs::path folder, FolderContent content)
      : TableSource(content), folder_(std::move(folder)) {
    const bool block = fs::exists(folder_ / "block.toml");
    const bool result = fs::exists(folder_ / "summary.json");
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
  std::unique_ptr<TableReader> Open(std::string_view table,
                                    std::span<const TableColumn> columns) const override {
    const auto file = FindTable(folder_, table);
    if (!file) return nullptr;
    return std::make_unique<CsvReader>(*file, columns);
  }
  std::string NameOf(std::string_view table) const override {
    return (folder_ / (std::string(table) + ".csv")).string();
  }
  std::string DefaultName() const override { return NameAt(folder_); }

 private:
  fs::path folder_;
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
                     "stands beside " + plain.filename().string() + ", one of both is allowed");
  }
  if (has_plain) return plain;
  if (has_gzip) return gzip;
  return std::nullopt;
}

namespace {

class FolderSink final : public TableSink {
 public:
  FolderSink(std::filesystem::path folder, Compression compression)
      : folder_(std::move(folder)), compression_(compression) {}
  std::unique_ptr<TableWriter> Open(std::string_view table,
                                    std::span<const TableColumn> columns) override {
    std::vector<std::string_view> names;
    for (const TableColumn& column : columns) names.push_back(column.name);
    const char* const ending = compression_ == Compression::kGzip ? ".csv.gz" : ".csv";
    return std::make_unique<CsvWriter>(
        folder_ / (std::string(table) + ending), names, compression_);
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
    ContainerSink sink(target, compression, ids);
    write(&sink);
    sink.Commit();
    return;
  }
  StagedFolder staged(content, target);
  staged.Write([&](const std::filesystem::path& to) {
    FolderSink sink(to, compression);
    write(&sink);
  });
  staged.Publish(KnownFiles(content));
}

}  // namespace sarblock
