// SPDX-License-Identifier: Apache-2.0
#include "table_source.h"

#include "sarblock/core/error.h"

#include <fstream>
#include <iterator>

namespace sarblock {
namespace {

namespace fs = std::filesystem;

class FolderSource final : public TableSource {
 public:
  FolderSource(fs::path folder, FolderKind kind) : TableSource(kind), folder_(std::move(folder)) {
    RequireFolder(folder_, kind);
  }
  std::pair<std::string, std::string> Read(std::string_view name) const override {
    const fs::path file = folder_ / name;
    std::ifstream stream(file, std::ios::binary);
    if (!fs::is_regular_file(file) || !stream) FailMissing(file.string(), "file");
    return {file.string(), {std::istreambuf_iterator<char>(stream), {}}};
  }
  std::optional<CsvReader> Open(std::string_view table,
                                std::span<const CsvColumn> columns) const override {
    const auto file = FindTable(folder_, table);
    if (!file) return std::nullopt;
    return CsvReader(*file, columns);
  }
  std::string NameOf(std::string_view table) const override {
    return (folder_ / (std::string(table) + ".csv")).string();
  }
  std::string DefaultName() const override {
    const fs::path whole = fs::absolute(folder_).lexically_normal();
    return (whole.has_filename() ? whole : whole.parent_path()).filename().string();
  }

 private:
  fs::path folder_;
};

class TextSource final : public TableSource {
 public:
  TextSource(FileTexts texts, FolderKind kind) : TableSource(kind), texts_(std::move(texts)) {}
  std::pair<std::string, std::string> Read(std::string_view name) const override {
    const auto text = Find(name);
    if (!text) FailMissing(std::string(name), "file");
    return {std::string(name), std::string(*text)};
  }
  std::optional<CsvReader> Open(std::string_view table,
                                std::span<const CsvColumn> columns) const override {
    const auto text = Find(NameOf(table));
    if (!text) return std::nullopt;
    return CsvReader(NameOf(table), *text, columns);
  }
  std::string NameOf(std::string_view table) const override { return std::string(table) + ".csv"; }
  std::string DefaultName() const override { return kind_.name; }

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

void RequireFolder(const fs::path& folder, FolderKind kind) {
  const std::string name = kind.name;
  const auto fail = [&](const std::string& what) {
    throw InputError(FilePlace{folder.string(), 0, ""},
                     what + "; a " + name + " is a folder with " + kind.holds);
  };
  if (!fs::exists(folder)) fail("does not exist");
  if (!fs::is_directory(folder)) fail("is a file");
  const bool block = fs::exists(folder / "block.toml");
  const bool result = fs::exists(folder / "summary.json");
  if (block == result) return;
  if (name == "block" && result) fail("is a result, not a block");
  if (name != "block" && block) fail("is a block, not a " + name);
}

std::unique_ptr<TableSource> TablesOfFolder(const std::filesystem::path& folder, FolderKind kind) {
  return std::make_unique<FolderSource>(folder, kind);
}

std::unique_ptr<TableSource> TablesOfTexts(FileTexts texts, FolderKind kind) {
  return std::make_unique<TextSource>(std::move(texts), kind);
}

void TableSource::FailMissing(const std::string& file, const char* what) const {
  throw InputError(FilePlace{file, 0, ""},
                   std::string("is missing, every ") + kind_.name + " has this " + what);
}

CsvReader TableSource::Require(std::string_view table, std::span<const CsvColumn> columns) const {
  auto reader = Open(table, columns);
  if (!reader) FailMissing(NameOf(table), "table (or it as .csv.gz)");
  return std::move(*reader);
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

}  // namespace sarblock
