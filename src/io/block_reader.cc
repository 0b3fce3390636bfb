// SPDX-License-Identifier: Apache-2.0
#include "block_reader.h"

#include <fstream>
#include <iterator>
#include <utility>

#include "number.h"
#include "toml_reader.h"

namespace sarblock {
namespace {

namespace fs = std::filesystem;

class FolderSource final : public BlockSource {
 public:
  explicit FolderSource(fs::path folder) : folder_(std::move(folder)) {
    if (!fs::is_directory(folder_)) {
      throw InputError(FilePlace{folder_.string(), 0, ""},
                       "is no folder; a block is a folder with block.toml, trajectories.csv and "
                       "observations.csv");
    }
  }
  std::pair<std::string, std::string> ReadToml() const override {
    const fs::path file = folder_ / "block.toml";
    std::ifstream stream(file, std::ios::binary);
    if (!fs::is_regular_file(file) || !stream) {
      throw InputError(FilePlace{file.string(), 0, ""}, "is missing, every block has this file");
    }
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

class TextSource final : public BlockSource {
 public:
  explicit TextSource(const BlockTexts& texts) : texts_(texts) {}
  std::pair<std::string, std::string> ReadToml() const override {
    return {"block.toml", std::string(texts_.block_toml)};
  }
  std::optional<CsvReader> Open(std::string_view table,
                                std::span<const CsvColumn> columns) const override {
    std::optional<std::string_view> text = texts_.points_csv;
    if (table == "trajectories") text = texts_.trajectories_csv;
    if (table == "observations") text = texts_.observations_csv;
    if (!text) return std::nullopt;
    return CsvReader(NameOf(table), *text, columns);
  }
  std::string NameOf(std::string_view table) const override { return std::string(table) + ".csv"; }
  std::string DefaultName() const override { return "block"; }

 private:
  BlockTexts texts_;
};

BlockFile Read(const BlockSource& source, const ReadOptions& options) {
  BlockReading reading{source, options, {}, {}, {}, {}, {}};
  ReadBlockToml(&reading);
  ReadTrajectories(&reading);
  ReadPoints(&reading);
  ReadLooks(&reading);
  SetStripSpans(reading.strip_spans_s, &reading.result.block);
  reading.result.block.points.ids.DropIndex();
  return std::move(reading.result);
}

}  // namespace

BlockFile ReadBlock(const std::filesystem::path& folder, const ReadOptions& options) {
  return Read(FolderSource(folder), options);
}

BlockFile ReadBlockTexts(const BlockTexts& texts, const ReadOptions& options) {
  return Read(TextSource(texts), options);
}

CsvReader BlockSource::Require(std::string_view table, std::span<const CsvColumn> columns) const {
  auto reader = Open(table, columns);
  if (!reader) {
    throw InputError(FilePlace{NameOf(table), 0, ""},
                     "is missing, every block has this table (or it as .csv.gz)");
  }
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

void WarnOfUnknownColumns(const CsvReader& reader, std::vector<std::string>* warnings) {
  if (reader.unknown_columns().empty()) return;
  std::string names;
  for (const std::string& name : reader.unknown_columns()) {
    names += (names.empty() ? "" : ", ") + Quoted(name);
  }
  warnings->push_back(reader.file() + ": columns not known and ignored: " + names);
}

std::uint32_t FindPass(const CsvReader& reader, std::size_t column, const IdTable& pass_ids) {
  const std::string_view id = reader.Id(column);
  const std::uint32_t pass = pass_ids.Find(id);
  if (pass == IdTable::kNone) {
    reader.Fail(column, "block.toml has no pass " + Quoted(id) + DidYouMean(pass_ids.Nearest(id)));
  }
  return pass;
}

std::uint32_t FindPoint(const CsvReader& reader, std::size_t column, const IdTable& ids) {
  const std::string_view id = reader.Id(column);
  const std::uint32_t point = ids.Find(id);
  if (point == IdTable::kNone) {
    reader.Fail(column, "the block has no point " + Quoted(id) + DidYouMean(ids.Nearest(id)));
  }
  return point;
}

bool ReadRejected(const CsvReader& reader, std::size_t column) {
  const std::string_view text = reader.Text(column);
  if (text == "1") return true;
  if (!text.empty() && text != "0") {
    reader.Fail(column, Quoted(text) + " is not allowed, 0 or 1 is");
  }
  return false;
}

double PositiveNumber(const CsvReader& reader, std::size_t column) {
  const double value = reader.Number(column);
  if (value <= 0.0) {
    reader.Fail(column, NumberText(value) + " is not allowed, a number above 0 is");
  }
  return value;
}

}  // namespace sarblock
