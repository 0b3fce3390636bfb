// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"
#include "sarblock/files/block_file.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "block/read_recorded.h"
#include "block_parts.h"
#include "core/text.h"
#include "tables/open.h"

namespace sarblock::files {
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

/// A number for people to read and change: 30, where the nearest double in degrees is not.
std::string ShortText(double value, double factor) {
  const std::string text = Digits(value / factor, 15);
  return std::strtod(text.c_str(), nullptr) * factor == value ? text
                                                              : NumberText(ToUnit(value, factor));
}

std::string SwathText(const Swath& swath) {
  const SwathKey& key = kSwathKeys[static_cast<std::size_t>(swath.kind)];
  return std::string(key.key) + " = [" + ShortText(swath.limits[0], key.factor) + ", " +
         ShortText(swath.limits[1], key.factor) + "]\n";
}

std::string FrameText(const Block& block) {
  if (block.frame.kind() == FrameKind::kLocal) return "[frame]\nkind = \"local\"\n";
  const Ellipsoid& ellipsoid = block.frame.ellipsoid();
  std::string text = "[frame]\nkind = \"geocentric\"\nellipsoid = ";
  const auto& names = EllipsoidNames();
  if (std::find(names.begin(), names.end(), ellipsoid.name) != names.end()) {
    text += TomlText(ellipsoid.name) + "\n";
  } else {
    text += "{ a_m = " + NumberText(ellipsoid.a_m) + ", f = " + NumberText(ellipsoid.flattening) +
            " }\n";
  }
  if (!block.realization.empty()) text += "realization = " + TomlText(block.realization) + "\n";
  if (!std::isnan(block.epoch_year)) text += "epoch = " + NumberText(block.epoch_year) + "\n";
  return text;
}

std::string BlockTomlText(const Block& block, const AdjustTable& adjust) {
  std::string text = "format = \"sarblock-block 1\"\nname = " + TomlText(block.name) + "\n";
  const bool one_trajectory =
      !block.passes.empty() &&
      std::all_of(block.passes.begin(), block.passes.end(), [&block](const Pass& pass) {
        return SameTrajectory(pass.recorded.asked, block.passes.front().recorded.asked);
      });
  if (one_trajectory) text += TrajectoryText(block.passes.front().recorded.asked);
  text += FrameText(block);
  const bool one_sigma =
      !block.passes.empty() &&
      std::all_of(block.passes.begin(), block.passes.end(), [&block](const Pass& pass) {
        return SameSigma(pass.sigma, block.passes.front().sigma);
      });
  if (one_sigma) {
    text += "[sigma]\n";
    AppendSigma(block.passes.front().sigma, "", &text);
  }
  const bool one_reduction =
      !block.passes.empty() &&
      std::all_of(block.passes.begin(), block.passes.end(), [&block](const Pass& pass) {
        return pass.reduction == block.passes.front().reduction;
      });
  if (one_reduction) text += ReductionText(block.passes.front().reduction, "reduction");
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
    if (pass.squint_rad != 0.0) {
      text += "squint_deg = " + ShortText(pass.squint_rad, kRadPerDeg) + "\n";
    }
    if (pass.swath) text += SwathText(*pass.swath);
    if (!pass.epoch_utc.empty()) text += "epoch_utc = " + TomlText(pass.epoch_utc) + "\n";
    if (!one_trajectory) text += TrajectoryText(pass.recorded.asked);
    if (!one_reduction) text += ReductionText(pass.reduction, "pass.reduction");
    if (pass.image) text += ImageTableText(*pass.image);
  }
  return text;
}

void WritePoints(TableSink* sink, const Block& block) {
  constexpr const auto& kColumns = kPointColumns;
  constexpr std::array kSigmas = kColumns("sigma_e_m", "sigma_n_m", "sigma_u_m");
  constexpr std::array kCovariances = kColumns("cov_en_m2", "cov_eu_m2", "cov_nu_m2");
  constexpr std::array kMotion = kColumns("vx_mpy", "vy_mpy", "vz_mpy");
  const Points& points = block.points;
  // Positions are written in the axes of the frame, at its epoch.
  std::vector<std::string_view> left_out{"lat_deg", "lon_deg", "h_m", "frame", "epoch", "geoid"};
  const auto moves = [](const KnownPosition& known) { return !known.velocity_mpy.isZero(0.0); };
  if (std::none_of(points.known.begin(), points.known.end(), moves)) {
    for (const std::size_t column : kMotion) left_out.push_back(kColumns.columns[column].name);
  }
  const auto table = sink->Open("points", kColumns, left_out);
  constexpr const char* kRoles[] = {"tie", "control", "check"};
  WriteEach(points.size(), table.get(), [&](std::size_t i, Batch* batch) {
    const auto index = static_cast<std::uint32_t>(i);
    NewRow row(batch);
    row.Id(kColumns("point"), points.ids, index);
    row.Text(kColumns("role"), kRoles[static_cast<std::size_t>(points.role[i])]);
    row.Numbers(kColumns("x_m", "y_m", "z_m"), points.given_m[i]);
    const KnownPosition* known = points.FindKnown(index);
    if (known == nullptr) return;
    const Eigen::Matrix3d& covariance = known->covariance_enu_m2;
    for (std::size_t k = 0; k < 3; ++k) {
      // A check point taken as exactly known is written without standard deviations.
      const double variance_m2 =
          covariance(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(k));
      if (variance_m2 > 0.0) row.Number(kSigmas[k], std::sqrt(variance_m2));
    }
    std::size_t k = 0;
    for (const auto& [a, b] : {std::pair{0, 1}, std::pair{0, 2}, std::pair{1, 2}}) {
      if (covariance(a, b) != 0.0) row.Number(kCovariances[k], covariance(a, b));
      ++k;
    }
    if (moves(*known)) row.Numbers(kMotion, known->velocity_mpy);
  });
  table->Commit();
}

/// Whether the row of a look says its squint: it is not 0, or 0 in a pass with another one.
bool NeedsSquint(const Block& block, std::size_t look) {
  const Looks& looks = block.looks;
  return (!looks.cone.empty() && looks.cone[look] != 0.0) ||
         block.passes[looks.pass[look]].squint_rad != 0.0;
}

/// Columns of looks that a block does not need.
std::vector<std::string_view> ColumnsLeftOut(const Block& block) {
  const Looks& looks = block.looks;
  bool squint = false, doppler = false, range_sigma = false, rejected = false;
  std::array<bool, 3> azimuth{};  // by unit
  for (std::size_t i = 0; i < looks.size(); ++i) {
    const bool by_doppler = (looks.flags[i] & Looks::kDoppler) != 0;
    doppler |= by_doppler;
    squint |= !by_doppler && NeedsSquint(block, i);
    rejected |= looks.rejected(i);
    range_sigma |= !looks.range_sigma_m.empty() && !std::isnan(looks.range_sigma_m[i]);
    if (!looks.azimuth_sigma.empty() && !std::isnan(looks.azimuth_sigma[i])) {
      azimuth[static_cast<std::size_t>(block.SigmaOf(i).azimuth_unit)] = true;
    }
  }
  std::vector<std::string_view> left_out{"line", "pixel", "line_sigma_px", "pixel_sigma_px"};
  for (const auto& [needed, column] :
       {std::pair{squint, "squint_deg"},
        std::pair{doppler, "doppler_hz"},
        std::pair{range_sigma, "range_sigma_m"},
        std::pair{azimuth[static_cast<std::size_t>(AzimuthUnit::kMetres)], "azimuth_sigma_m"},
        std::pair{azimuth[static_cast<std::size_t>(AzimuthUnit::kSeconds)], "time_sigma_s"},
        std::pair{azimuth[static_cast<std::size_t>(AzimuthUnit::kHertz)], "doppler_sigma_hz"},
        std::pair{!looks.range_delay_m.empty(), "range_delay_m"},
        std::pair{!looks.time_shift_s.empty(), "time_shift_s"},
        std::pair{rejected, "rejected"}}) {
    if (!needed) left_out.emplace_back(column);
  }
  return left_out;
}

void WriteLooks(TableSink* sink, const Block& block, const IdTable& pass_ids) {
  constexpr const auto& kColumns = kLookColumns;
  const Looks& looks = block.looks;
  const auto table = sink->Open("observations", kColumns, ColumnsLeftOut(block));
  const auto write_look = [&](std::size_t i, std::size_t point, Batch* batch) {
    NewRow row(batch);
    row.Id(kColumns("pass"), pass_ids, looks.pass[i]);
    row.Id(kColumns("point"), block.points.ids, static_cast<std::uint32_t>(point));
    const RadarCoordinates measured = block.Measured(i);
    row.Number(kColumns("time_s"), measured.time_s).Number(kColumns("range_m"), measured.range_m);
    if (!looks.range_delay_m.empty()) {
      row.Number(kColumns("range_delay_m"), looks.range_delay_m[i]);
    }
    if (!looks.time_shift_s.empty()) row.Number(kColumns("time_shift_s"), looks.time_shift_s[i]);
    const double cone = looks.cone.empty() ? 0.0 : looks.cone[i];
    if ((looks.flags[i] & Looks::kDoppler) != 0) {
      row.Number(kColumns("doppler_hz"), cone);
    } else if (NeedsSquint(block, i)) {
      row.Number(kColumns("squint_deg"), ToUnit(cone, kRadPerDeg));
    }
    if (!looks.range_sigma_m.empty()) {
      row.Number(kColumns("range_sigma_m"), looks.range_sigma_m[i]);
    }
    if (!looks.azimuth_sigma.empty()) {
      const AzimuthUnit unit = block.SigmaOf(i).azimuth_unit;
      row.Number(unit == AzimuthUnit::kMetres    ? kColumns("azimuth_sigma_m")
                 : unit == AzimuthUnit::kSeconds ? kColumns("time_sigma_s")
                                                 : kColumns("doppler_sigma_hz"),
                 looks.azimuth_sigma[i]);
    }
    row.Integer(kColumns("rejected"), looks.rejected(i) ? 1 : 0);
  };
  WriteRows(looks.size(), table.get(), [&](std::size_t begin, std::size_t end, Batch* batch) {
    ForLooks(
        looks, begin, end, [&](std::size_t i, std::size_t point) { write_look(i, point, batch); });
  });
  table->Commit();
}

void WriteTruePoints(TableSink* sink, const Block& block, const Truth& truth) {
  constexpr const auto& kColumns = kTruthColumns;
  const auto table = sink->Open("truth", kColumns);
  WriteEach(truth.points_m.size(), table.get(), [&](std::size_t i, Batch* batch) {
    const Eigen::Vector3d& p_m = truth.points_m[i];
    if (std::isnan(p_m.x())) return;
    NewRow(batch)
        .Id(kColumns("point"), block.points.ids, static_cast<std::uint32_t>(i))
        .Numbers(kColumns("x_m", "y_m", "z_m"), p_m);
  });
  table->Commit();
}

}  // namespace

void WritePaths(TableSink* sink,
                std::string_view name,
                const IdTable& pass_ids,
                const std::vector<FlightPath>& paths,
                const std::vector<std::string>& adjusted) {
  constexpr const auto& kColumns = kPathColumns;
  constexpr std::array<std::string_view, 1> kOfResults{"adjusted"};
  const auto table =
      adjusted.empty() ? sink->Open(name, kColumns, kOfResults) : sink->Open(name, kColumns);
  const auto write = [&](std::size_t begin, std::size_t end, Batch* batch) {
    for (std::size_t i = begin; i < end; ++i) {
      for (const StateVector& state : paths[i].states()) {
        NewRow row(batch);
        row.Id(kColumns("pass"), pass_ids, static_cast<std::uint32_t>(i))
            .Number(kColumns("time_s"), state.time_s)
            .Numbers(kColumns("x_m", "y_m", "z_m"), state.position_m)
            .Numbers(kColumns("vx_mps", "vy_mps", "vz_mps"), state.velocity_mps);
        if (!adjusted.empty()) row.Text(kColumns("adjusted"), adjusted[i]);
      }
    }
  };
  WriteRows(paths.size(), table.get(), write, 1);
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
                const AdjustTable& adjust,
                const Truth* truth,
                Compression compression) {
  const IdTable passes = PassIds(block);
  const BlockIds ids{&passes, &block.points.ids};
  WriteTables(FolderContent::kBlock, target, compression, ids, [&](TableSink* sink) {
    std::vector<FlightPath> recorded;
    for (const Pass& pass : block.passes) recorded.emplace_back(pass.RecordedStates());
    WritePaths(sink, "trajectories", passes, recorded);
    WriteLooks(sink, block, passes);
    WritePoints(sink, block);
    if (truth != nullptr && !truth->points_m.empty()) WriteTruePoints(sink, block, *truth);
    if (truth != nullptr && !truth->paths.empty()) {
      WritePaths(sink, "truth_passes", passes, truth->paths);
    }
    sink->WriteText("block.toml", kWrittenBySarblock + BlockTomlText(block, adjust));
  });
}

}  // namespace sarblock::files
