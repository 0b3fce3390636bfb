// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/files/adjust_options.h"
#include "sarblock/files/block_file.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <cmath>

#include "block/read_recorded.h"
#include "block_reader.h"
#include "block_tables.h"
#include "core/text.h"
#include "tables/open.h"

namespace sarblock {
namespace {

namespace fs = std::filesystem;

void AppendSigma(const LookSigma& sigma, const std::string& infix, std::string* text) {
  if (!std::isnan(sigma.range_m)) {
    *text += "range" + infix + "_m = " + NumberText(sigma.range_m) + "\n";
  }
  if (!std::isnan(sigma.azimuth)) {
    const AzimuthUnit unit = sigma.azimuth_unit;
    const std::string key = unit == AzimuthUnit::kHertz     ? "doppler" + infix + "_hz"
                            : unit == AzimuthUnit::kSeconds ? "azimuth" + infix + "_s"
                                                            : "azimuth" + infix + "_m";
    *text += key + " = " + NumberText(sigma.azimuth) + "\n";
  }
}

bool SameNumber(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

bool SameSigma(const LookSigma& a, const LookSigma& b) {
  return SameNumber(a.range_m, b.range_m) && SameNumber(a.azimuth, b.azimuth) &&
         a.azimuth_unit == b.azimuth_unit;
}

bool SameTrajectory(const TrajectoryOptions& a, const TrajectoryOptions& b) {
  return a.through == b.through && SameNumber(a.sigma.position_m, b.sigma.position_m) &&
         SameNumber(a.sigma.velocity_mps, b.sigma.velocity_mps);
}

/// An inline table, empty for what is the default.
std::string TrajectoryText(const TrajectoryOptions& options) {
  if (SameTrajectory(options, {})) return "";
  std::string text = std::string("trajectory = { through = \"") + NameOf(options.through) + "\"";
  if (!std::isnan(options.sigma.position_m)) {
    text += ", sigma_m = " + NumberText(options.sigma.position_m);
  }
  if (!std::isnan(options.sigma.velocity_mps)) {
    text += ", sigma_mps = " + NumberText(options.sigma.velocity_mps);
  }
  return text + " }\n";
}

std::string FrameText(const Frame& frame) {
  if (frame.kind() == FrameKind::kLocal) return "[frame]\nkind = \"local\"\n";
  const Ellipsoid& ellipsoid = frame.ellipsoid();
  std::string text = "[frame]\nkind = \"geocentric\"\nellipsoid = ";
  const auto& names = EllipsoidNames();
  if (std::find(names.begin(), names.end(), ellipsoid.name) != names.end()) {
    return text + TomlText(ellipsoid.name) + "\n";
  }
  return text + "{ a_m = " + NumberText(ellipsoid.a_m) +
         ", f = " + NumberText(ellipsoid.flattening) + " }\n";
}

std::string BlockTomlText(const Block& block, const AdjustOptions& adjust) {
  std::string text = "format = \"sarblock-block 1\"\nname = " + TomlText(block.name) + "\n";
  const bool one_trajectory =
      !block.passes.empty() &&
      std::all_of(block.passes.begin(), block.passes.end(), [&block](const Pass& pass) {
        return SameTrajectory(pass.recorded.asked, block.passes.front().recorded.asked);
      });
  if (one_trajectory) text += TrajectoryText(block.passes.front().recorded.asked);
  text += FrameText(block.frame);
  const bool one_sigma =
      !block.passes.empty() &&
      std::all_of(block.passes.begin(), block.passes.end(), [&block](const Pass& pass) {
        return SameSigma(pass.sigma, block.passes.front().sigma);
      });
  if (one_sigma) {
    text += "[sigma]\n";
    AppendSigma(block.passes.front().sigma, "", &text);
  }
  text += DumpAdjustTable(adjust);
  for (const Pass& pass : block.passes) {
    text += "[[pass]]\nid = " + TomlText(pass.id) + "\nlook = ";
    text += pass.side == LookSide::kLeft ? "\"left\"\n" : "\"right\"\n";
    if (!std::isnan(pass.wavelength_m)) {
      text += "wavelength_m = " + NumberText(pass.wavelength_m) + "\n";
    }
    if (!one_sigma) AppendSigma(pass.sigma, "_sigma", &text);
    text += "start_s = " + NumberText(pass.start_s) + "\n";
    text += "end_s = " + NumberText(pass.end_s) + "\n";
    if (!pass.epoch_utc.empty()) text += "epoch_utc = " + TomlText(pass.epoch_utc) + "\n";
    if (!one_trajectory) text += TrajectoryText(pass.recorded.asked);
    if (pass.image) text += ImageTableText(*pass.image);
  }
  return text;
}

void WritePoints(TableSink* sink, const Block& block) {
  // Positions are written in the axes of the frame, not as latitude, longitude and height.
  std::vector<TableColumn> columns(kPointColumns.begin(), kPointColumns.end());
  columns.erase(columns.begin() + 5, columns.begin() + 8);
  const auto table = sink->Open("points", columns);
  TableWriter& out = *table;
  constexpr const char* kRoles[] = {"tie", "control", "check"};
  const Points& points = block.points;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d& p = points.given_m[i];
    out.Id(points.ids[i], i).Text(kRoles[static_cast<std::size_t>(points.role[i])]);
    out.Number(p.x()).Number(p.y()).Number(p.z());
    const KnownPosition* known = points.FindKnown(i);
    if (known == nullptr) {
      out.Empty(6);
    } else {
      const Eigen::Matrix3d& covariance = known->covariance_enu_m2;
      for (Eigen::Index k = 0; k < 3; ++k) {
        // A check point taken as exactly known is written without standard deviations.
        out.Number(covariance(k, k) > 0.0 ? std::sqrt(covariance(k, k)) : kNotGiven);
      }
      for (const auto& [a, b] : {std::pair{0, 1}, std::pair{0, 2}, std::pair{1, 2}}) {
        out.Number(covariance(a, b) != 0.0 ? covariance(a, b) : kNotGiven);
      }
    }
    out.EndRow();
  }
  out.Commit();
}

// Which optional columns the looks of a block need.
struct WrittenColumns {
  bool squint = false, doppler = false, range_sigma = false, azimuth_m = false, azimuth_s = false,
       doppler_sigma = false, rejected = false;
};

WrittenColumns ColumnsOf(const Block& block) {
  const Looks& looks = block.looks;
  WrittenColumns columns;
  for (std::size_t i = 0; i < looks.size(); ++i) {
    const bool doppler = (looks.flags[i] & Looks::kDoppler) != 0;
    columns.doppler |= doppler;
    columns.squint |= !doppler && !looks.cone.empty() && looks.cone[i] != 0.0;
    columns.rejected |= looks.rejected(i);
    columns.range_sigma |= !looks.range_sigma_m.empty() && !std::isnan(looks.range_sigma_m[i]);
    if (!looks.azimuth_sigma.empty() && !std::isnan(looks.azimuth_sigma[i])) {
      const AzimuthUnit unit = block.SigmaOf(i).azimuth_unit;
      columns.azimuth_m |= unit == AzimuthUnit::kMetres;
      columns.azimuth_s |= unit == AzimuthUnit::kSeconds;
      columns.doppler_sigma |= unit == AzimuthUnit::kHertz;
    }
  }
  return columns;
}

void WriteLooks(TableSink* sink, const Block& block) {
  const Looks& looks = block.looks;
  const WrittenColumns columns = ColumnsOf(block);
  const std::array<bool, kObservationColumns.size()> written{true,
                                                             true,
                                                             true,
                                                             true,
                                                             columns.squint,
                                                             columns.doppler,
                                                             columns.range_sigma,
                                                             columns.azimuth_m,
                                                             columns.azimuth_s,
                                                             columns.doppler_sigma,
                                                             columns.rejected};
  std::vector<TableColumn> chosen;
  for (std::size_t i = 0; i < written.size(); ++i) {
    if (written[i]) chosen.push_back(kObservationColumns[i]);
  }
  const auto table = sink->Open("observations", chosen);
  const auto write_look = [&](std::size_t i, std::size_t point, TableWriter* out) {
    const bool doppler = (looks.flags[i] & Looks::kDoppler) != 0;
    const AzimuthUnit unit = block.SigmaOf(i).azimuth_unit;
    const double cone = looks.cone.empty() ? 0.0 : looks.cone[i];
    const double range_sigma_m = looks.range_sigma_m.empty() ? kNotGiven : looks.range_sigma_m[i];
    const double azimuth = looks.azimuth_sigma.empty() ? kNotGiven : looks.azimuth_sigma[i];
    out->Id(block.passes[looks.pass[i]].id, looks.pass[i]);
    out->Id(block.points.ids[point], static_cast<std::uint32_t>(point));
    out->Number(looks.time_s[i]).Number(looks.range_m[i]);
    if (columns.squint) {
      out->Number(doppler || cone == 0.0 ? kNotGiven : InUnit(cone, kRadPerDeg));
    }
    if (columns.doppler) out->Number(doppler ? cone : kNotGiven);
    if (columns.range_sigma) out->Number(range_sigma_m);
    const auto own_sigma = [&](AzimuthUnit of) { out->Number(unit == of ? azimuth : kNotGiven); };
    if (columns.azimuth_m) own_sigma(AzimuthUnit::kMetres);
    if (columns.azimuth_s) own_sigma(AzimuthUnit::kSeconds);
    if (columns.doppler_sigma) own_sigma(AzimuthUnit::kHertz);
    if (columns.rejected) out->Integer(looks.rejected(i) ? 1 : 0);
    out->EndRow();
  };
  const auto write = [&](std::size_t begin, std::size_t end, TableWriter* out) {
    ForLooks(
        looks, begin, end, [&](std::size_t i, std::size_t point) { write_look(i, point, out); });
  };
  WriteRows(looks.size(), table->rows_of_part(), table.get(), write);
  table->Commit();
}

void WriteTruePoints(TableSink* sink, const Block& block, const Truth& truth) {
  const auto table = sink->Open("truth", kTruthColumns);
  TableWriter& out = *table;
  for (std::size_t i = 0; i < truth.points_m.size(); ++i) {
    const Eigen::Vector3d& p = truth.points_m[i];
    if (std::isnan(p.x())) continue;
    out.Id(block.points.ids[i], static_cast<std::uint32_t>(i));
    out.Number(p.x()).Number(p.y()).Number(p.z()).EndRow();
  }
  out.Commit();
}

}  // namespace

void WritePaths(TableSink* sink,
                std::string_view name,
                const Block& block,
                const std::vector<FlightPath>& paths) {
  const auto table = sink->Open(name, kPathColumns);
  const auto write = [&](std::size_t begin, std::size_t end, TableWriter* out) {
    for (std::size_t i = begin; i < end; ++i) {
      for (const StateVector& state : paths[i].states()) {
        out->Id(block.passes[i].id, static_cast<std::uint32_t>(i)).Number(state.time_s);
        for (Eigen::Index k = 0; k < 3; ++k) out->Number(state.position_m[k]);
        for (Eigen::Index k = 0; k < 3; ++k) out->Number(state.velocity_mps[k]);
        out->EndRow();
      }
    }
  };
  WriteRows(paths.size(), 1, table.get(), write);
  table->Commit();
}

std::vector<FlightPath> NominalPaths(const Block& block) {
  std::vector<FlightPath> paths;
  for (const Pass& pass : block.passes) {
    if (pass.recorded.states.empty()) {
      paths.push_back(pass.path);
      continue;
    }
    std::vector<StateVector> states;
    for (const double time_s : PathTimes_s(pass)) {
      const std::optional<Motion> motion = pass.path.At(time_s);
      if (motion) states.push_back({time_s, motion->position_m, motion->velocity_mps});
    }
    paths.emplace_back(std::move(states));
  }
  return paths;
}

IdTable PassIds(const Block& block) {
  IdTable ids;
  for (const Pass& pass : block.passes) ids.Append(pass.id);
  return ids;
}

void WriteBlock(const fs::path& target,
                const Block& block,
                const AdjustOptions& adjust,
                const Truth* truth,
                Compression compression) {
  const IdTable passes = PassIds(block);
  const TextsOfTable pass_ids(passes), point_ids(block.points.ids);
  const BlockIds ids{&pass_ids, &point_ids};
  WriteTables(FolderContent::kBlock, target, compression, ids, [&](TableSink* sink) {
    std::vector<FlightPath> recorded;
    for (const Pass& pass : block.passes) recorded.emplace_back(pass.RecordedStates());
    WritePaths(sink, "trajectories", block, recorded);
    WriteLooks(sink, block);
    WritePoints(sink, block);
    if (truth != nullptr && !truth->points_m.empty()) WriteTruePoints(sink, block, *truth);
    if (truth != nullptr && !truth->paths.empty()) {
      WritePaths(sink, "truth_passes", block, truth->paths);
    }
    sink->WriteText("block.toml", kWrittenBySarblock + BlockTomlText(block, adjust));
  });
}

}  // namespace sarblock
