// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "folder_content.h"

namespace sarblock {

enum class ColumnNeed { kOptional, kRequired };

/// What the cells of a column hold.
enum class CellKind {
  kNumber,     ///< its unit is the end of the column's name
  kRowNumber,  ///< a number whose unit the cell `unit` of its row, or the parameter it is of, gives
  kCount,      ///< an integer of 0 or more
  kFlag,       ///< 0 or 1
  kText,
  kPass,   ///< id of a pass of the block
  kPoint,  ///< id of a point of the block
};

/// A column of a table. Its index in the list that a reader is given is what the cell functions
/// take.
struct TableColumn {
  std::string_view name;
  ColumnNeed need = ColumnNeed::kOptional;
  CellKind kind = CellKind::kNumber;
};

/// "m" for a name that ends in "_m"; "1" for one that ends in no unit.
[[nodiscard]] std::string_view UnitOfColumn(std::string_view name);

/// A table of a block, a result or a part: what readers, writers and both kinds of files go by. The
/// columns stand in the order in which they are written.
struct TableDescription {
  std::string_view name;
  std::span<const TableColumn> columns;
};
/// All tables of a block, a result or a part, in the order in which they are written.
[[nodiscard]] std::span<const TableDescription> TablesOf(FolderContent content);

namespace column {
inline constexpr ColumnNeed kRequired = ColumnNeed::kRequired;
inline constexpr ColumnNeed kOptional = ColumnNeed::kOptional;
}  // namespace column

inline constexpr std::array<TableColumn, 8> kPathColumns{{
    {"pass", column::kRequired, CellKind::kPass},
    {"time_s", column::kRequired},
    {"x_m", column::kRequired},
    {"y_m", column::kRequired},
    {"z_m", column::kRequired},
    {"vx_mps", column::kRequired},
    {"vy_mps", column::kRequired},
    {"vz_mps", column::kRequired},
}};
/// Needed of the looks are time and range, or line and pixel.
inline constexpr std::array<TableColumn, 15> kObservationColumns{{
    {"pass", column::kRequired, CellKind::kPass},
    {"point", column::kRequired, CellKind::kPoint},
    {"time_s"},
    {"range_m"},
    {"squint_deg"},
    {"doppler_hz"},
    {"range_sigma_m"},
    {"azimuth_sigma_m"},
    {"time_sigma_s"},
    {"doppler_sigma_hz"},
    {"rejected", column::kOptional, CellKind::kFlag},
    {"line"},
    {"pixel"},
    {"line_sigma_px"},
    {"pixel_sigma_px"},
}};
inline constexpr std::array<TableColumn, 14> kPointColumns{{
    {"point", column::kRequired, CellKind::kPoint},
    {"role", column::kOptional, CellKind::kText},
    {"x_m"},
    {"y_m"},
    {"z_m"},
    {"lat_deg"},
    {"lon_deg"},
    {"h_m"},
    {"sigma_e_m"},
    {"sigma_n_m"},
    {"sigma_u_m"},
    {"cov_en_m2"},
    {"cov_eu_m2"},
    {"cov_nu_m2"},
}};
inline constexpr std::array<TableColumn, 4> kTruthColumns{{
    {"point", column::kRequired, CellKind::kPoint},
    {"x_m", column::kRequired},
    {"y_m", column::kRequired},
    {"z_m", column::kRequired},
}};

inline constexpr std::array<TableColumn, 35> kResultPointColumns{{
    {"point", column::kRequired, CellKind::kPoint},
    {"role", column::kRequired, CellKind::kText},
    {"status", column::kRequired, CellKind::kText},
    {"looks", column::kRequired, CellKind::kCount},
    {"x_m", column::kRequired},
    {"y_m", column::kRequired},
    {"z_m", column::kRequired},
    {"lat_deg"},
    {"lon_deg"},
    {"h_m"},
    {"sigma_e_m", column::kRequired},
    {"sigma_n_m", column::kRequired},
    {"sigma_u_m", column::kRequired},
    {"cov_en_m2", column::kRequired},
    {"cov_eu_m2", column::kRequired},
    {"cov_nu_m2", column::kRequired},
    {"intersection_deg"},
    {"sigma_leberl_across_m"},
    {"sigma_leberl_up_m"},
    {"sigma_leberl_path_across_m"},
    {"sigma_leberl_path_up_m"},
    {"leberl_across_azimuth_deg"},
    {"redundancy"},
    {"error_e_m"},
    {"error_n_m"},
    {"error_u_m"},
    {"chi_square_3"},
    {"error_sigma_e_m"},
    {"error_sigma_n_m"},
    {"error_sigma_u_m"},
    {"sigma_held_e_m"},
    {"sigma_held_n_m"},
    {"sigma_held_u_m"},
    {"cov_held_en_m2"},
    {"reason", column::kOptional, CellKind::kText},
}};
inline constexpr std::array<TableColumn, 10> kParameterColumns{{
    {"pass", column::kRequired, CellKind::kText},  // or the name of a shared group
    {"parameter", column::kRequired, CellKind::kText},
    {"unit", column::kRequired, CellKind::kText},
    {"value", column::kRequired, CellKind::kRowNumber},
    {"sigma", column::kRequired, CellKind::kRowNumber},
    {"prior_sigma", column::kRequired, CellKind::kRowNumber},
    {"significance"},
    {"kept", column::kOptional, CellKind::kText},
    {"prior_redundancy"},
    {"prior_w"},
}};
inline constexpr std::array<TableColumn, 5> kParameterCovarianceColumns{{
    {"pass_a", column::kRequired, CellKind::kText},
    {"parameter_a", column::kRequired, CellKind::kText},
    {"pass_b", column::kRequired, CellKind::kText},
    {"parameter_b", column::kRequired, CellKind::kText},
    {"covariance", column::kRequired, CellKind::kRowNumber},
}};
inline constexpr std::array<TableColumn, 13> kSelectionColumns{{
    {"candidate", column::kRequired, CellKind::kText},
    {"passes", column::kOptional, CellKind::kText},
    {"parameters", column::kOptional, CellKind::kCount},
    {"test", column::kOptional, CellKind::kText},
    {"statistic"},
    {"f"},
    {"p"},
    {"delta_bic"},
    {"condition"},
    {"posterior_prior"},
    {"verdict", column::kRequired, CellKind::kText},
    {"reason", column::kOptional, CellKind::kText},
    {"step", column::kOptional, CellKind::kCount},
}};
inline constexpr std::array<TableColumn, 7> kSimplificationColumns{{
    {"simplification", column::kRequired, CellKind::kText},
    {"bound_m"},
    {"sigma_m"},
    {"fraction"},
    {"allowed", column::kOptional, CellKind::kFlag},
    {"taken", column::kOptional, CellKind::kFlag},
    {"verdict", column::kOptional, CellKind::kText},
}};
inline constexpr std::array<TableColumn, 19> kStripColumns{{
    {"pass", column::kRequired, CellKind::kPass},
    {"look", column::kOptional, CellKind::kText},
    {"time_s", column::kRequired},
    {"strip_time", column::kRequired},
    {"x_m", column::kRequired},
    {"y_m", column::kRequired},
    {"z_m", column::kRequired},
    {"near_x_m"},
    {"near_y_m"},
    {"near_z_m"},
    {"far_x_m"},
    {"far_y_m"},
    {"far_z_m"},
    {"correction_along_m"},
    {"correction_across_m"},
    {"correction_up_m"},
    {"sigma_along_m"},
    {"sigma_across_m"},
    {"sigma_up_m"},
}};
/// The last four stand there where a pass has an image.
inline constexpr std::size_t kImageResidualColumns = 4;
inline constexpr std::array<TableColumn, 22> kResidualColumns{{
    {"pass", column::kRequired, CellKind::kPass},
    {"point", column::kRequired, CellKind::kPoint},
    {"range_residual_m", column::kRequired},
    {"azimuth_residual_m", column::kRequired},
    {"range_redundancy"},
    {"azimuth_redundancy"},
    {"range_w"},
    {"azimuth_w"},
    {"range_tau"},
    {"azimuth_tau"},
    {"range_mdb_m"},
    {"azimuth_mdb_m"},
    {"range_influence_m"},
    {"azimuth_influence_m"},
    {"weight"},
    {"rejected", column::kRequired, CellKind::kFlag},
    {"reason", column::kOptional, CellKind::kText},
    {"finding", column::kOptional, CellKind::kCount},
    {"line"},
    {"pixel"},
    {"line_residual_px"},
    {"pixel_residual_px"},
}};
inline constexpr std::array<TableColumn, 9> kControlColumns{{
    {"point", column::kRequired, CellKind::kPoint},
    {"component", column::kRequired, CellKind::kText},
    {"residual_m", column::kRequired},
    {"sigma_m"},
    {"redundancy"},
    {"w"},
    {"tau"},
    {"mdb_m"},
    {"influence_m"},
}};
inline constexpr std::array<TableColumn, 15> kPairColumns{{
    {"point_a", column::kRequired, CellKind::kPoint},
    {"point_b", column::kRequired, CellKind::kPoint},
    {"de_m", column::kRequired},
    {"dn_m", column::kRequired},
    {"du_m", column::kRequired},
    {"cov_ee_m2", column::kRequired},
    {"cov_nn_m2", column::kRequired},
    {"cov_uu_m2", column::kRequired},
    {"cov_en_m2", column::kRequired},
    {"cov_eu_m2", column::kRequired},
    {"cov_nu_m2", column::kRequired},
    {"sigma_leberl_across_m"},
    {"sigma_leberl_up_m"},
    {"sigma_leberl_path_across_m"},
    {"sigma_leberl_path_up_m"},
}};
inline constexpr std::array<TableColumn, 14> kMonteCarloColumns{{
    {"point", column::kRequired, CellKind::kPoint},
    {"sample_sigma_e_m"},
    {"sample_sigma_n_m"},
    {"sample_sigma_u_m"},
    {"sigma_e_m"},
    {"sigma_n_m"},
    {"sigma_u_m"},
    {"ratio_e"},
    {"ratio_n"},
    {"ratio_u"},
    {"normalised_square"},
    {"coverage_50"},
    {"coverage_90"},
    {"coverage_99"},
}};
inline constexpr std::array<TableColumn, 9> kDrawColumns{{
    {"run", column::kRequired, CellKind::kCount},
    {"converged", column::kRequired, CellKind::kFlag},
    {"variance_ratio_e", column::kRequired},
    {"variance_ratio_n", column::kRequired},
    {"variance_ratio_u", column::kRequired},
    {"normalised_square", column::kRequired},
    {"coverage_50", column::kRequired},
    {"coverage_90", column::kRequired},
    {"coverage_99", column::kRequired},
}};
inline constexpr std::array<TableColumn, 11> kSumColumns{{
    {"point", column::kRequired, CellKind::kPoint},
    {"sum_ee", column::kRequired, CellKind::kText},  // integers of more digits than a double has
    {"sum_nn", column::kRequired, CellKind::kText},
    {"sum_uu", column::kRequired, CellKind::kText},
    {"sum_en", column::kRequired, CellKind::kText},
    {"sum_eu", column::kRequired, CellKind::kText},
    {"sum_nu", column::kRequired, CellKind::kText},
    {"sum_square", column::kRequired, CellKind::kText},
    {"inside_50", column::kRequired, CellKind::kCount},
    {"inside_90", column::kRequired, CellKind::kCount},
    {"inside_99", column::kRequired, CellKind::kCount},
}};

}  // namespace sarblock
