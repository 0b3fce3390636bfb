// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/exchange/export.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace sarblock {

/// What the writers of the single formats share.
struct ExportView {
  const ResultFile& result;
  const ExportOptions& options;
  double ellipse_scale_1 = 1.0;
  std::vector<std::uint32_t> points;  ///< solved ones, in their order

  [[nodiscard]] bool HasCovariance(std::uint32_t point) const;
  [[nodiscard]] const Eigen::Vector3d& Position_m(std::uint32_t point) const {
    return result.points.results.position_m[point];
  }
  [[nodiscard]] const SymmetricEnu& Covariance_m2(std::uint32_t point) const {
    return result.points.results.covariance_m2[point];
  }
};

void WriteKml(const std::filesystem::path& file, const ExportView& view, ExportReport* report);
void WriteGeoPackage(const std::filesystem::path& file,
                     const ExportView& view,
                     ExportReport* report);
void WriteIsisTables(const std::filesystem::path& folder,
                     const ExportView& view,
                     ExportReport* report);
void WriteSinex(const std::filesystem::path& file, const ExportView& view, ExportReport* report);
void WriteOrbitFiles(const std::filesystem::path& folder,
                     const ExportView& view,
                     ExportReport* report);

/// Error of a check point, or null; `checks` are sorted by point.
[[nodiscard]] const CheckResult* FindCheck(const std::vector<CheckResult>& checks,
                                           std::uint32_t point);

}  // namespace sarblock
