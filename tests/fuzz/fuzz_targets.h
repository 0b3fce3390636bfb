// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/core/error.h"
#include "sarblock/files/block_file.h"
#include "sarblock/files/result.h"
#include "sarblock/files/scene_file.h"

#include <array>
#include <cstdlib>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "studies/densification.h"
#include "studies/design.h"
#include "studies/stability.h"
#include "studies/tradeoff.h"
#include "tables/csv.h"
#include "tables/open.h"
#include "tables/table.h"

// What the fuzzers run and the unit tests replay on the corpus. A file may be refused by
// InputError and by nothing else; what is accepted has to keep its promises.
namespace sarblock::fuzz {

inline constexpr std::string_view kToml =
    "format = \"sarblock-block 1\"\n[frame]\nkind = \"geocentric\"\nellipsoid = \"Moon\"\n"
    "[sigma]\nrange_m = 1.5\nazimuth_m = 2.5\n[[pass]]\nid = \"A\"\nlook = \"left\"\n"
    "wavelength_m = 0.03\n[[pass]]\nid = \"B\"\nlook = \"right\"\n";
inline constexpr std::string_view kPaths =
    "pass,time_s,x_m,y_m,z_m,vx_mps,vy_mps,vz_mps\nA,0,2e6,0,0,0,1500,0\nA,40,2e6,6e4,0,0,1500,0\n"
    "B,0,2e6,0,9000,0,1500,0\nB,40,2e6,6e4,9000,0,1500,0\n";
inline constexpr std::string_view kLooks =
    "pass,point,time_s,range_m\nA,P,12.5,300000\nB,P,12.75,300100\n";

inline void Check(bool holds) {
  if (!holds) std::abort();
}

template <typename Run>
void AllowInputError(const Run& run) {
  try {
    run();
  } catch (const InputError&) {
  }
}

// Offsets and indices of an accepted block stay inside its arrays.
inline void CheckBlock(const Block& block) {
  Check(block.looks.offsets.size() == block.points.size() + 1);
  Check(block.looks.offsets.back() == block.looks.size());
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    Check(block.looks.pass[i] < block.passes.size());
    const LookSigma sigma = block.SigmaOf(i);
    Check(sigma.range_m > 0.0 && sigma.azimuth > 0.0 && block.looks.range_m[i] > 0.0);
  }
  for (const Pass& pass : block.passes) Check(pass.start_s < pass.end_s);
}

/// The text as any table, and as each table of a block.
inline void Csv(std::string_view text) {
  constexpr Columns kColumns{{
      {"pass", ColumnNeed::kOptional, CellKind::kText},
      {"point", ColumnNeed::kOptional, CellKind::kPoint},
      {"x_m"},
  }};
  AllowInputError([&] {
    ForRows(ReadCsvText("t.csv", text, kColumns).get(), [&](const Row& row) {
      static_cast<void>(row.Text(kColumns("pass")));
      static_cast<void>(row.Id(kColumns("point")));
      static_cast<void>(row.Number(kColumns("x_m")));
    });
  });
  AllowInputError([&] { CheckBlock(files::ReadBlockTexts({kToml, text, kLooks, {}}).block); });
  AllowInputError([&] { CheckBlock(files::ReadBlockTexts({kToml, kPaths, text, {}}).block); });
  AllowInputError([&] { CheckBlock(files::ReadBlockTexts({kToml, kPaths, kLooks, text}).block); });
}

/// The text as block.toml; options that are read are dumped and read back to the same.
inline void BlockToml(std::string_view text) {
  AllowInputError([&] {
    const files::BlockFile file = files::ReadBlockTexts({text, kPaths, kLooks, {}});
    CheckBlock(file.block);
    std::vector<std::string> ids;
    for (const Pass& pass : file.block.passes) ids.push_back(pass.id);
    const std::string dumped = files::DumpAdjustTable(file.adjust);
    try {
      Check(files::DumpAdjustTable(files::ReadAdjustTable(dumped, "dump", ids)) == dumped);
    } catch (const InputError&) {
      std::abort();
    }
  });
}

/// The text as a scene; what is accepted has the numbers that a simulation relies on, and its
/// [adjust] reaches the block as TOML that parses.
inline void SceneToml(std::string_view text) {
  AllowInputError([&] {
    const Scene scene = files::ParseScene(text, "scene.toml");
    Check(!scene.flights.empty());
    for (const SceneFlight& flight : scene.flights) {
      Check(flight.count > 0 && flight.height_m > 0.0 && flight.length_m > 0.0);
      Check(flight.swath.limits[0] < flight.swath.limits[1]);
    }
    Check(scene.points.east_m[0] <= scene.points.east_m[1]);
    static_cast<void>(files::ReadAdjustTable(scene.adjust_toml, "adjust", {}));
  });
}

inline constexpr std::string_view kSummary =
    R"({"format": "sarblock-result 1", "version": "0", "command": "adjust", "block": "b",
"status": "converged", "verdict": "accepted", "accepted": true, "frame": {"kind": "geocentric",
"ellipsoid": {"name": "Moon", "a_m": 1737400.0, "f": 0.0}},
"passes": [{"id": "A", "look": "left", "start_s": 0, "end_s": 40},
{"id": "B", "look": "right", "start_s": 0, "end_s": 40}],
"counts": {"points": 1, "looks": 2, "looks_used": 2, "parameters": 3, "observations": 4,
"redundancy": 1}, "iterations": 3, "initial_cost": 5.5, "final_cost": 0.5, "gradient": null,
"sigma0_squared": 1.25, "sigma_scaled_by_posterior": false, "chi_square": null,
"covariance": "block", "condition": 10.5, "stages": {}, "warnings": []})";
inline constexpr std::string_view kResultPoints =
    "point,role,status,looks,x_m,y_m,z_m,sigma_e_m,sigma_n_m,sigma_u_m,cov_en_m2,cov_eu_m2,"
    "cov_nu_m2\nP,tie,adjusted,2,1737000,30000.5,500,1,2,3,0.5,0.25,-0.5\n";
inline constexpr std::string_view kResultPasses =
    "pass,parameter,unit,value,sigma,prior_sigma\nA,range.bias,m,1.5,0.5,\nB,time.bias,s,2,1,4\n";
inline constexpr std::string_view kResiduals =
    "pass,point,range_residual_m,azimuth_residual_m,rejected\nA,P,0.5,-0.25,0\nB,P,,,1\n";

// Indices of an accepted result stay inside its arrays, its flat arrays have one length.
inline void CheckResultFile(const files::ResultFile& file) {
  const std::size_t points = file.points.size(), looks = file.looks.size();
  Check(points == file.points.ids.size() && points == file.points.results.position_m.size());
  Check(file.looks.point.size() == looks && file.looks.rejected.size() == looks);
  for (std::size_t i = 0; i < looks; ++i) {
    Check(file.looks.pass[i] < file.passes.size() && file.looks.point[i] < points);
  }
  for (const PairResult& pair : file.pairs) Check(pair.a < points && pair.b < points);
  for (const files::ResultControl& control : file.control) {
    Check(control.point < points && control.component >= 0 && control.component < 3);
  }
  for (const StripStation& station : file.strips) Check(station.pass < file.passes.size());
  for (const ParameterCovariance& entry : file.parameter_covariance) {
    Check(entry.a < file.parameters.size() && entry.b < file.parameters.size());
  }
  for (const files::ResultPass& pass : file.passes) Check(pass.start_s < pass.end_s);
}

/// The text as each file of a result.
inline void Result(std::string_view text) {
  const files::ResultTexts good{kSummary, kResultPoints, kResultPasses, kResiduals, kPaths};
  const auto with = [&](auto member) {
    files::ResultTexts texts = good;
    texts.*member = text;
    AllowInputError([&] { CheckResultFile(files::ReadResultTexts(texts)); });
  };
  with(&files::ResultTexts::summary_json);
  with(&files::ResultTexts::points_csv);
  with(&files::ResultTexts::passes_csv);
  with(&files::ResultTexts::residuals_csv);
  with(&files::ResultTexts::trajectories_csv);
  with(&files::ResultTexts::passes_covariance_csv);
  with(&files::ResultTexts::control_quality_csv);
  with(&files::ResultTexts::pairs_csv);
  with(&files::ResultTexts::strips_csv);
  with(&files::ResultTexts::selection_csv);
  with(&files::ResultTexts::simplifications_csv);
}

inline constexpr std::string_view kScene =
    "format = \"sarblock-scene 1\"\nname = \"s\"\n[[flight]]\nid = \"A\"\nheight_m = 9000\n"
    "length_m = 9000\nheading_deg = 90\nspeed_mps = 200\nswath_ground_m = [5000, 15000]\n"
    "[[flight]]\nid = \"B\"\nheight_m = 9000\nlength_m = 9000\nheading_deg = 90\n"
    "speed_mps = 200\nstart_m = [0, 4000]\nswath_ground_m = [1000, 11000]\n[looks]\n"
    "range_sigma_m = 1.5\nazimuth_sigma_m = 1.5\n[points]\neast_m = [1000, 8000]\n"
    "north_m = [6000, 14000]\n[control]\nsigma_m = [0.5, 0.5, 0.5]\n[adjust]\n"
    "corrections = \"given\"\n[adjust.correction.position]\ndegree = 1\nsigma_m = [2, 2, 2]\n";

/// The text as a study of each kind; every case of an accepted densification or design is a scene
/// that can be made, every stage of a trade-off has its reference, every family of a stability
/// study values.
inline void StudyToml(std::string_view text) {
  AllowInputError([&] {
    const TradeoffStudy study = ParseTradeoffStudy(
        text, "study.toml", {}, [](const std::string&) { return std::string(kScene); });
    Check(!study.choices.empty() && !study.identity.empty());
    for (const TradeoffEntry& entry : study.choices) {
      Check(study.ReferenceOf(entry.choice.stage).choice.stage == entry.choice.stage);
      for (const TradeoffSize& size : study.sizes) {
        Check(size.points > 0 && !FindProblem(size.scene));
        static_cast<void>(study.WhyNotRun(entry, size));
      }
    }
  });
  AllowInputError([&] {
    const StabilityStudy study = ParseStability(text, "study.toml");
    Check(!study.families.empty());
    for (const StabilityFamily& family : study.families) Check(!family.values.empty());
  });
  AllowInputError([&] {
    const DensificationFile file = ParseDensification(
        text, "study.toml", {}, [](const std::string&) { return std::string(kScene); });
    Check(!file.study.cases.empty() || !file.study.placements.empty());
    Check(file.study.cases.size() <= kMaxStudyCases && !file.identity.empty());
    for (const StudyCase& of : file.study.cases) {
      Check(!FindProblem(of.scene) && !of.scene.flights.empty());
      Check(of.adjust.corrections != CorrectionChoice::kAuto);
    }
    for (const PlacementCase& of : file.study.placements) Check(of.sigma_m[2] > 0.0);
    Check(file.study.verify.every > 0 && file.study.verify.level < 1.0);
  });
  AllowInputError([&] {
    const DesignFile file =
        ParseDesign(text, "study.toml", {}, [](const std::string&) { return std::string(kScene); });
    const DesignStudy& study = file.study;
    Check(study.axes.size() == study.choices.size() && !file.identity.empty());
    std::size_t cases = 1;
    for (const DesignAxis& axis : study.axes) cases *= axis.values.size();
    Check(cases == study.cases.size() && cases <= kMaxStudyCases);
    for (const StudyCase& of : study.cases) Check(!FindProblem(of.scene));
    for (const DesignGoal& goal : study.goals) Check(goal.limit > 0.0);
  });
}

}  // namespace sarblock::fuzz
