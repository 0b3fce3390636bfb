// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/leberl/formulas.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "leberl/validity.h"
#include "session.h"

namespace sarblock::cli {

/// `sarblock leberl ...`: the paper's closed forms beside their rigorous counterparts.
void AddLeberl(CLI::App* app, Session* session);

/// Its subcommands; each sets session->run when chosen.
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

/// A cell of a CSV on standard output: quoted if it contains a comma or a quotation mark.
[[nodiscard]] std::string CsvText(const std::string& text);

/// A number for a cell of a CSV; NaN, an empty cell, where there is none.
[[nodiscard]] double OrNaN(const std::optional<double>& value);

/// An SVG of the lines where the first order of `source` is off by 1, 5 and 20 percent: look angle
/// against log10(error/H), one colour a base-to-height ratio, the case of `terrain_ratio` z/H.
[[nodiscard]] std::string PlotValidity(const std::vector<ValidityLine>& lines,
                                       ValiditySource source,
                                       double terrain_ratio);

}  // namespace sarblock::cli
