// SPDX-License-Identifier: Apache-2.0
#include "table_texts.h"

#include <utility>

#include "csv_reader.h"

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

}  // namespace sarblock
