// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/leberl/formulas.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "leberl/rigorous.h"
#include "session.h"
#include <nlohmann/json.hpp>

namespace sarblock::cli {

/// `sarblock leberl ...`: the paper's closed forms beside their rigorous counterparts.
void AddLeberl(CLI::App* app, Session* session);

/// `sarblock plan ...`: predicted accuracy of a planned pair or block.
void AddPlan(CLI::App* app, Session* session);

/// Subcommands of `leberl`; each sets session->run when chosen.
void AddLeberlErrors(CLI::App* leberl, Session* session);
void AddLeberlDifferences(CLI::App* leberl, Session* session);
void AddLeberlExaggeration(CLI::App* leberl, Session* session);
void AddLeberlFigures(CLI::App* leberl, Session* session);
void AddLeberlParallax(CLI::App* leberl, Session* session);
void AddLeberlValidity(CLI::App* leberl, Session* session);

/// Adds --base-m, --height-m, --ground-range-m and --opposite to a subcommand.
enum class GroundRange { kRequired, kFromTable };
void AddConfiguration(CLI::App* command,
                      GroundRange ground_range,
                      leberl::StereoConfiguration* configuration);

/// One column of a list that a command prints as JSON or as CSV: its name there and its cell, an
/// empty cell of a CSV where that is null.
template <typename Row>
struct ListColumn {
  const char* name;
  nlohmann::ordered_json (*cell)(const Row& row);
  enum class Form { kBoth, kJsonAlone } form = Form::kBoth;
};

/// A line of a CSV on standard output: texts are quoted if they contain a comma or a quotation
/// mark.
[[nodiscard]] std::string CsvLine(const std::vector<nlohmann::ordered_json>& cells);

template <typename Row, std::size_t N>
[[nodiscard]] nlohmann::ordered_json JsonOf(const Row& row,
                                            const std::array<ListColumn<Row>, N>& columns) {
  nlohmann::ordered_json object;
  for (const ListColumn<Row>& column : columns) object[column.name] = column.cell(row);
  return object;
}

/// The line of a row, or the heading where there is none.
template <typename Row, std::size_t N>
[[nodiscard]] std::string CsvOf(const Row* row, const std::array<ListColumn<Row>, N>& columns) {
  std::vector<nlohmann::ordered_json> cells;
  for (const ListColumn<Row>& column : columns) {
    if (column.form == ListColumn<Row>::Form::kJsonAlone) continue;
    cells.push_back(row == nullptr ? nlohmann::ordered_json(column.name) : column.cell(*row));
  }
  return CsvLine(cells);
}

/// The whole list, as JSON or as CSV.
template <typename Row, std::size_t N>
[[nodiscard]] std::string ListOf(const std::vector<Row>& rows,
                                 const std::array<ListColumn<Row>, N>& columns,
                                 const Session& session) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  std::string csv = CsvOf<Row>(nullptr, columns);
  for (const Row& row : rows) {
    if (session.json) list.push_back(JsonOf(row, columns));
    csv += CsvOf(&row, columns);
  }
  return session.json ? list.dump(2) + "\n" : csv;
}

/// A number for a cell of a CSV; NaN, an empty cell, where there is none.
[[nodiscard]] double OrNaN(const std::optional<double>& value);

/// An SVG of the lines where the first order of `source` is off by 1, 5 and 20 percent: look angle
/// against log10(error/H), one colour a base-to-height ratio, the case of `terrain_ratio` z/H.
[[nodiscard]] std::string PlotValidity(const std::vector<ValidityLine>& lines,
                                       ValiditySource source,
                                       double terrain_ratio);

}  // namespace sarblock::cli
