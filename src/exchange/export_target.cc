// SPDX-License-Identifier: Apache-2.0
#include "export_target.h"

#include "sinex.h"

namespace sarblock {

void RequireTargetFor(ExportFormat format, const std::filesystem::path& out, ForeignFiles foreign) {
  switch (format) {
    case ExportFormat::kGeoJson:
      return RequireFileFor(out, {"\"generator\":\"sarblock\""}, foreign);
    case ExportFormat::kKml:
    case ExportFormat::kGeoPackage:
      return RequireFileFor(out, {"written by sarblock"}, foreign);
    case ExportFormat::kIsis:
      return RequireFilesFor(out,
                             {",,,x image,y image,Measured,Measured,sample,line,Residual Vector\n",
                              ",,,,,3-d,3-d,3-d,Sigma,Sigma,Sigma,Correction,Correction,"},
                             foreign);
    case ExportFormat::kSinex:
      RequireFileFor(out, {" SOFTWARE           sarblock "}, foreign);
      return RequireFileFor(SitesOf(out), {"code,point,role\n"}, foreign);
    case ExportFormat::kOrbitFiles:
      return RequireFilesFor(out, {"<Creator>sarblock</Creator>"}, foreign);
    case ExportFormat::kCsmStates:
    case ExportFormat::kSicd:
      return RequireFilesFor(out, {"written by sarblock"}, foreign);
  }
}

}  // namespace sarblock
