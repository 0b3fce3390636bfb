// SPDX-License-Identifier: Apache-2.0
#include "write_tables.h"

#include <string>
#include <vector>

#include "container_writer.h"
#include "csv_writer.h"
#include "folder_content.h"
#include "output_folder.h"

namespace sarblock {
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
