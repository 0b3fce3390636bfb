// SPDX-License-Identifier: Apache-2.0
#include "look_model.h"

#include <array>

namespace sarblock {
LookModel::LookModel(const Block& block,
                     const ParameterLayout& layout,
                     const Simplified& simplified)
    : block_(block), layout_(layout), simplified_(simplified), paths_(block, layout, simplified) {}

LookSigma LookModel::SigmaOf(std::size_t look) const {
  LookSigma sigma = block_.SigmaOf(look);
  if (!sigma_factors_.empty()) {
    const std::array<double, 2>& factor = sigma_factors_[block_.looks.pass[look]];
    sigma.range_m *= factor[0];
    sigma.azimuth *= factor[1];
  }
  return sigma;
}

void LookModel::ColumnsOf(std::size_t look, LookColumns* columns) const {
  ColumnsAt(block_.looks.pass[look], block_.looks.time_s[look], columns);
}

void LookModel::ColumnsAt(std::size_t pass, double time_s, LookColumns* columns) const {
  const PassCorrections& corrections = layout_.passes[pass];
  columns->column_count = corrections.static_columns;
  if (corrections.blocks.size() == 1 && corrections.splines.empty()) {  // the usual pass
    columns->block_count = 1;
    columns->block[0] = corrections.blocks[0];
    return;
  }
  columns->block_count = 0;
  const auto add = [&](int block) {
    columns->block[static_cast<std::size_t>(columns->block_count++)] = block;
  };
  for (const int block : corrections.blocks) add(block);
  for (const SplineTerm& term : corrections.splines) {
    const int first = static_cast<int>(term.spline.PieceOf(time_s));
    for (int k = 0; k < 4; ++k) add(term.first_block + first + k);
    columns->column_count += 4 * term.component_count;
  }
}

void GatherColumns(const ParameterLayout& layout,
                   const LookColumns& columns,
                   const Eigen::VectorXd& x,
                   double* local) {
  for (int b = 0; b < columns.block_count; ++b) {
    const ParameterBlock& block =
        layout.blocks[static_cast<std::size_t>(columns.block[static_cast<std::size_t>(b)])];
    for (int i = 0; i < block.size; ++i) *local++ = x[block.offset + i];
  }
}

const double* LocalCorrections(const ParameterLayout& layout,
                               const LookColumns& columns,
                               const Eigen::VectorXd& x,
                               std::array<double, ParameterLayout::kMaxLocalColumns>* local) {
  if (columns.block_count == 1) {
    return x.data() + layout.blocks[static_cast<std::size_t>(columns.block[0])].offset;
  }
  GatherColumns(layout, columns, x, local->data());
  return local->data();
}

MeasuredLook LookModel::MeasuredAt(std::size_t look) const {
  MeasuredLook out{block_.looks.time_s[look], block_.looks.range_m[look], block_.ConeOf(look)};
  if (block_.MeasuresDoppler(look)) {
    out.azimuth = MeasuredLook::Azimuth::kDoppler;
    out.wavelength_m = block_.passes[block_.looks.pass[look]].wavelength_m;
  }
  return out;
}

bool LookModel::Evaluate(const LookState& at,
                         const LookWeights& weights,
                         LookEvaluation* out,
                         LookCurvature* curvature) const {
  return ValueOf(at, weights, out, curvature) == LookValue::kGiven;
}

LookValue LookModel::ValueOf(const LookState& at,
                             const LookWeights& weights,
                             LookEvaluation* out,
                             LookCurvature* curvature) const {
  return EvaluateMeasuredLook(paths_[block_.looks.pass[at.look]],
                              MeasuredAt(at.look),
                              at.start_m,
                              at.displacement_m,
                              at.x,
                              at.columns.column_count,
                              weights,
                              out,
                              curvature);
}

std::optional<CorrectedMotion> LookModel::ReadMotion(std::size_t pass,
                                                     double measured_s,
                                                     double read_s,
                                                     double path_s,
                                                     const Eigen::VectorXd& x) const {
  if (BeyondPath(paths_[pass].path(), path_s) != Beyond::kInside) return std::nullopt;
  LookColumns columns;
  ColumnsAt(pass, measured_s, &columns);
  std::array<double, ParameterLayout::kMaxLocalColumns> local;
  PathReading path;
  if (!paths_[pass].Read(
          measured_s, read_s, LocalCorrections(layout_, columns, x, &local), &path)) {
    return std::nullopt;
  }
  const double later_s = path_s - read_s;
  return CorrectedMotion{later_s == 0.0 ? path.motion : path.motion.After(later_s), path_s};
}

std::optional<CorrectedMotion> LookModel::CorrectedMotionAt(std::size_t pass,
                                                            double time_s,
                                                            const Eigen::VectorXd& x) const {
  const double path_s = time_s + layout_.TimeBias_s(pass, x);
  return ReadMotion(pass, time_s, paths_[pass].ReadingTime_s(time_s, path_s), path_s, x);
}

std::optional<CorrectedMotion> LookModel::CorrectedMotionAtPathTime(
    std::size_t pass, double measured_s, double path_s, const Eigen::VectorXd& x) const {
  return ReadMotion(pass, measured_s, path_s, path_s, x);
}

std::optional<FixedPathLook> LookModel::FixPath(std::size_t look, const Eigen::VectorXd& x) const {
  const Looks& looks = block_.looks;
  const std::size_t pass = looks.pass[look];
  const std::optional<CorrectedMotion> corrected = CorrectedMotionAt(pass, looks.time_s[look], x);
  if (!corrected) return std::nullopt;
  const LookSigma sigma = SigmaOf(look);
  FixedPathLook observation;
  observation.antenna_m = corrected->motion.position_m;
  observation.velocity_mps = corrected->motion.velocity_mps;
  observation.acceleration_mps2 = corrected->motion.acceleration_mps2;
  observation.range_m = looks.range_m[look];
  observation.cone = block_.ConeOf(look);
  observation.side = static_cast<int>(block_.passes[pass].side);
  observation.range_sigma_m = sigma.range_m;
  observation.azimuth_sigma = sigma.azimuth;
  observation.azimuth_in_seconds = sigma.azimuth_unit == AzimuthUnit::kSeconds;
  observation.exact_time = block_.MeasuresDoppler(look);
  if (observation.exact_time) {
    observation.azimuth_sigma *=
        block_.ApproximateAzimuthUnit_m(look, observation.velocity_mps.norm());
  }
  return observation;
}

double LookModel::WorkOf(std::size_t pass) const {
  const PassCorrections& c = layout_.passes[pass];
  const bool geocentric = block_.frame.kind() == FrameKind::kGeocentric;
  double work = paths_[pass].path().IsStraight() ? 100.0 : 105.0;
  if (paths_[pass].AxesTurn()) work += geocentric ? 60.0 : 45.0;
  if (!c.troposphere.empty()) work += geocentric && !simplified_.flat_frame ? 120.0 : 40.0;
  return work;
}

}  // namespace sarblock
