// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>

#include "result_folder.h"
#include "study_page.h"
#include "tables/csv.h"
#include "tables/open.h"
#include "tables/toml.h"

namespace sarblock {
namespace {

constexpr std::size_t kMostPictureBytes = 1000000;
constexpr std::size_t kMostStudyRows = 20000;

struct StudyKind {
  const char* name;
  std::vector<TableColumn> columns;  ///< the first is required
};

const std::vector<StudyKind>& Kinds() {
  static const std::vector<StudyKind> kinds{{"densification",
                                             {{"layout", ColumnNeed::kRequired},
                                              {"control_points", ColumnNeed::kRequired},
                                              {"tie_points"},
                                              {"passes"},
                                              {"median_sigma_e_m"},
                                              {"median_sigma_n_m"},
                                              {"median_sigma_u_m"},
                                              {"max_sigma_h_m"},
                                              {"max_sigma_u_m"},
                                              {"montecarlo_rms_e_m"},
                                              {"montecarlo_rms_n_m"},
                                              {"montecarlo_rms_u_m"},
                                              {"nees"},
                                              {"runs"},
                                              {"determined"},
                                              {"variant"},
                                              {"rms_sigma_u_m"}}},
                                            {"tradeoff",
                                             {{"stage", ColumnNeed::kRequired},
                                              {"choice", ColumnNeed::kRequired},
                                              {"points"},
                                              {"looks"},
                                              {"wall_s"},
                                              {"peak_mib"},
                                              {"speed_ratio"},
                                              {"position_error_sigma"},
                                              {"covariance_error"},
                                              {"pareto"}}},
                                            {"stability",
                                             {{"family", ColumnNeed::kRequired},
                                              {"parameter"},
                                              {"value"},
                                              {"condition"},
                                              {"outcome", ColumnNeed::kRequired},
                                              {"covariance_digits"},
                                              {"position_digits"},
                                              {"message"}}}};
  return kinds;
}

std::vector<StudyPicture> ReadPictures(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const std::filesystem::path& place : {folder, folder / "plots"}) {
    if (!std::filesystem::is_directory(place)) continue;
    for (const auto& entry : std::filesystem::directory_iterator(place)) {
      if (entry.is_regular_file() && entry.path().extension() == ".svg") {
        files.push_back(entry.path());
      }
    }
  }
  std::sort(files.begin(), files.end());
  std::vector<StudyPicture> out;
  std::size_t bytes = 0;
  for (const std::filesystem::path& file : files) {
    std::ifstream stream(file, std::ios::binary);
    std::string svg{std::istreambuf_iterator<char>(stream), {}};
    if (bytes + svg.size() > kMostPictureBytes) continue;
    bytes += svg.size();
    out.push_back({file.stem().string(), std::move(svg)});
  }
  return out;
}

/// Name and goal of the study file, which a study leaves beside its table.
void ReadHeading(const std::filesystem::path& file, StudyFolder* out) {
  if (!std::filesystem::exists(file)) return;
  const toml::table root = ParseToml(ReadTomlText(file, "a study"), file.string(), {});
  out->name = root["name"].value_or(std::string());
  out->purpose = root["purpose"].value_or(std::string());
}

std::vector<std::string> ReadLines(const std::filesystem::path& file) {
  std::vector<std::string> out;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    if (!line.empty()) out.push_back(line);
  }
  return out;
}

}  // namespace

bool StudyCsv::HasNumbers(const std::string& column) const {
  for (std::size_t row = 0; row < rows.size(); ++row) {
    if (!std::isnan(Number(row, column))) return true;
  }
  return false;
}

std::size_t StudyCsv::Column(const std::string& name) const {
  return static_cast<std::size_t>(std::find(columns.begin(), columns.end(), name) -
                                  columns.begin());
}

std::string StudyCsv::Text(std::size_t row, const std::string& column) const {
  const std::size_t at = Column(column);
  return at == columns.size() ? "" : rows[row][at];
}

double StudyCsv::Number(std::size_t row, const std::string& column) const {
  const std::string text = Text(row, column);
  double value = kAbsent;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? value : kAbsent;
}

std::vector<std::string> StudyCsv::Values(const std::string& column) const {
  std::vector<std::string> out;
  for (std::size_t row = 0; row < rows.size(); ++row) {
    std::string text = Text(row, column);
    if (std::find(out.begin(), out.end(), text) == out.end()) out.push_back(std::move(text));
  }
  return out;
}

StudyFolder ReadStudyFolder(const std::filesystem::path& folder) {
  StudyFolder out;
  out.path = folder.string();
  for (const StudyKind& kind : Kinds()) {
    const auto file = FindTable(folder, kind.name);
    if (!file) continue;
    StudyCsv table;
    table.kind = kind.name;
    CsvReader reader(*file, kind.columns);
    std::vector<std::size_t> there;
    for (std::size_t c = 0; c < kind.columns.size(); ++c) {
      if (!reader.Has(c)) continue;
      there.push_back(c);
      table.columns.emplace_back(kind.columns[c].name);
    }
    while (reader.Next() && table.rows.size() < kMostStudyRows) {
      std::vector<std::string> row;
      for (const std::size_t c : there) row.emplace_back(reader.Text(c));
      table.rows.push_back(std::move(row));
    }
    out.tables.push_back(std::move(table));
    ReadHeading(folder / (std::string(kind.name) + ".study.toml"), &out);
    for (std::string& line : ReadLines(folder / (std::string(kind.name) + ".txt"))) {
      out.answers.push_back(std::move(line));
    }
  }
  if (!out.tables.empty()) out.pictures = ReadPictures(folder);
  return out;
}

}  // namespace sarblock
