// SPDX-License-Identifier: Apache-2.0
#include "design_law.h"

#include <algorithm>
#include <cmath>

#include "core/text.h"
#include <fmt/core.h>

namespace sarblock {
namespace {

/// Column of the worst point or the median.
std::string ColumnOf(const DesignLaw& law, const char* measure, std::size_t axis) {
  return fmt::format("{}_{}sigma_{}_m",
                     measure,
                     law.part == DesignLaw::Part::kPaths ? "path_" : "",
                     kDesignDirections[axis]);
}

const char* QuantityOf(const DesignLaw& law) {
  return law.part == DesignLaw::Part::kPaths ? "what the paths add" : "sigma";
}

std::string ExponentText(double value) {
  return std::isnan(value) ? "-" : fmt::format("{:.2f}", value);
}

}  // namespace

PowerLaw FitPowerLaw(const std::vector<std::array<double, 2>>& values) {
  std::vector<std::array<double, 2>> logs;
  for (const auto& [x, y] : values) {
    if (x > 0.0 && y > 0.0 && std::isfinite(x) && std::isfinite(y)) {
      logs.push_back({std::log(x), std::log(y)});
    }
  }
  PowerLaw law;
  law.values = logs.size();
  if (logs.empty()) return law;
  const auto n = static_cast<double>(logs.size());
  double mean_x = 0.0, mean_y = 0.0;
  for (const auto& [x, y] : logs) mean_x += x / n, mean_y += y / n;
  double xx = 0.0, xy = 0.0;
  for (const auto& [x, y] : logs) {
    xx += (x - mean_x) * (x - mean_x);
    xy += (x - mean_x) * (y - mean_y);
  }
  if (!(logs.front()[0] < logs.back()[0])) return law;
  law.exponent = xy / xx;
  law.factor = std::exp(mean_y - law.exponent * mean_x);
  const auto& [last_x, last_y] = logs.back();
  const auto& [before_x, before_y] = logs[logs.size() - 2];
  law.last_exponent = (last_y - before_y) / (last_x - before_x);
  if (logs.size() == 2) return law;
  double square_sum = 0.0;
  for (const auto& [x, y] : logs) {
    const double residual = y - mean_y - law.exponent * (x - mean_x);
    square_sum += residual * residual;
  }
  law.exponent_sigma = std::sqrt(square_sum / (n - 2.0) / xx);
  return law;
}

std::vector<FittedLaw> FitLaws(const DesignStudy& study, const StudyTable& table) {
  std::vector<FittedLaw> laws;
  if (!study.law) return laws;
  const std::size_t swept = study.law->axis;
  const bool alone = study.axes.size() == 1;
  for (const char* measure : {"max", "median"}) {
    for (std::size_t place = 0; place < study.law->derived.size(); ++place) {
      for (std::size_t axis = 0; axis < kDesignDirections.size(); ++axis) {
        FittedLaw fitted;
        fitted.value = alone ? "" : study.axes[1 - swept].values[place];
        fitted.place = place;
        fitted.axis = axis;
        fitted.column = ColumnOf(*study.law, measure, axis);
        fitted.derived = study.law->derived[place][axis];
        for (std::size_t row = 0; row < table.size(); ++row) {
          const std::vector<std::size_t> at = DesignPlaces(study, row);
          if (!alone && at[1 - swept] != place) continue;
          fitted.values.push_back(
              {study.choices[swept][at[swept]].number, table.Number(row, fitted.column)});
        }
        std::sort(fitted.values.begin(), fitted.values.end());
        fitted.law = FitPowerLaw(fitted.values);
        laws.push_back(std::move(fitted));
      }
    }
  }
  return laws;
}

StudyTable LawTable(const DesignStudy& study, const std::vector<FittedLaw>& laws) {
  using Cell = StudyCellKind;
  static const std::vector<StudyColumn> columns = {{"swept", Cell::kText},
                                                   {"value", Cell::kText},
                                                   {"column", Cell::kText},
                                                   {"factor"},
                                                   {"exponent"},
                                                   {"exponent_sigma"},
                                                   {"last_exponent"},
                                                   {"derived"},
                                                   {"values", Cell::kInteger}};
  std::vector<StudyRow> rows;
  for (const FittedLaw& fitted : laws) {
    StudyRowMaker row(columns);
    row.Set("swept", study.axes[study.law->axis].name)
        .Set("value", fitted.value)
        .Set("column", fitted.column)
        .Set("factor", fitted.law.factor)
        .Set("exponent", fitted.law.exponent)
        .Set("exponent_sigma", fitted.law.exponent_sigma)
        .Set("last_exponent", fitted.law.last_exponent)
        .Set("derived", fitted.derived)
        .Count("values", fitted.law.values);
    rows.push_back(row.row());
  }
  return {columns, std::move(rows)};
}

std::vector<std::string> LawLines(const DesignStudy& study, const std::vector<FittedLaw>& laws) {
  std::vector<std::string> lines;
  if (laws.empty()) return lines;
  const std::string& swept = study.axes[study.law->axis].name;
  const bool alone = study.axes.size() == 1;
  const std::string other = alone ? "" : study.axes[1 - study.law->axis].name;
  lines.push_back(
      fmt::format("worst point, {} ~ {}^p, exponents p", QuantityOf(*study.law), swept));
  std::size_t width = other.size();
  for (const FittedLaw& fitted : laws) width = std::max(width, fitted.value.size());
  width = std::min<std::size_t>(width, 34);
  lines.push_back(fmt::format(
      "{:<{}}  {:<6}{:>15}{:>12}{:>9}", other, width, "", "fitted", "last step", "derived"));
  for (const FittedLaw& fitted : laws) {
    if (!fitted.column.starts_with("max_")) continue;
    const std::string sigma = std::isnan(fitted.law.exponent_sigma)
                                  ? ""
                                  : fmt::format(" +- {:.2f}", fitted.law.exponent_sigma);
    lines.push_back(fmt::format("{:<{}}  {:<6}{:>15}{:>12}{:>9}",
                                fitted.axis == 0 ? fitted.value : "",
                                width,
                                kDesignDirections[fitted.axis],
                                ExponentText(fitted.law.exponent) + sigma,
                                ExponentText(fitted.law.last_exponent),
                                ExponentText(fitted.derived)));
  }
  return lines;
}

std::vector<std::string> DescribeLaws(const DesignStudy& study,
                                      const std::vector<FittedLaw>& laws) {
  std::vector<std::string> words;
  for (std::size_t i = 0; i + 2 < laws.size(); i += 3) {
    if (!laws[i].column.starts_with("max_")) continue;
    std::string found, derived;
    for (std::size_t axis = 0; axis < kDesignDirections.size(); ++axis) {
      const FittedLaw& fitted = laws[i + axis];
      found += fmt::format("{}^{} {}",
                           axis == 0 ? study.axes[study.law->axis].name : ", ",
                           ExponentText(fitted.law.exponent),
                           kDesignDirections[axis]);
      derived += (axis == 0 ? "" : ", ") + ExponentText(fitted.derived);
    }
    std::string text = laws[i].value + (laws[i].value.empty() ? "" : ": ");
    text += fmt::format("the worst point goes as {}", found);
    if (derived != "-, -, -") text += fmt::format(" (derived {})", derived);
    words.push_back(std::move(text));
  }
  return words;
}

}  // namespace sarblock
