// SPDX-License-Identifier: Apache-2.0
#include "product/matched_points.h"

#include "tables/csv.h"
#include "tables/table.h"

namespace sarblock {
namespace {

enum { kMatchPoint, kMatchImage, kMatchLine, kMatchSample, kMatchLineSigma, kMatchSampleSigma };
constexpr std::array<TableColumn, 6> kMatchColumns{{
    {"point", ColumnNeed::kRequired, CellKind::kPoint},
    {"image", ColumnNeed::kRequired, CellKind::kText},
    {"line", ColumnNeed::kRequired},
    {"sample", ColumnNeed::kRequired},
    {"line_sigma_px"},
    {"sample_sigma_px"},
}};

MatchedPoints ReadMatches(CsvReader reader) {
  MatchedPoints matches;
  matches.file = reader.file();
  WarnOfUnknownColumns(reader, &matches.warnings);
  while (reader.Next()) {
    MatchedPoint row;
    row.point = reader.Id(kMatchPoint);
    row.image = reader.Id(kMatchImage);
    row.line_px = reader.RequiredNumber(kMatchLine);
    row.sample_px = reader.RequiredNumber(kMatchSample);
    row.line_sigma_px = PositiveNumber(reader, kMatchLineSigma);
    row.sample_sigma_px = PositiveNumber(reader, kMatchSampleSigma);
    row.file_line = reader.line();
    matches.rows.push_back(std::move(row));
  }
  return matches;
}

}  // namespace

MatchedPoints ReadMatchedPoints(const std::string& file) {
  return ReadMatches(CsvReader(std::filesystem::path(file), kMatchColumns));
}

MatchedPoints ParseMatchedPoints(std::string_view text, const std::string& file) {
  return ReadMatches(CsvReader(file, text, kMatchColumns));
}

}  // namespace sarblock
