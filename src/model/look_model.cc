// SPDX-License-Identifier: Apache-2.0
#include "look_model.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace sarblock {

namespace {

/// First and last time and largest range that each pass measured.
struct Span {
  double first_s = std::numeric_limits<double>::infinity(), last_s = -first_s, range_m = 0.0;
};

std::vector<Span> SpansOf(const Block& block) {
  std::vector<Span> out(block.passes.size());
  for (std::size_t i = 0; i < block.looks.size(); ++i) {
    Span& span = out[block.looks.pass[i]];
    span.first_s = std::min(span.first_s, block.looks.time_s[i]);
    span.last_s = std::max(span.last_s, block.looks.time_s[i]);
    span.range_m = std::max(span.range_m, block.looks.range_m[i]);
  }
  return out;
}

ConeTurning MeasureTurning(const FlightPath& path, const Span& span) {
  ConeTurning out;
  out.range_m = span.range_m;
  if (!(span.first_s <= span.last_s)) return out;  // no look
  std::vector<double> turning_1;
  const std::size_t last = path.PieceOf(span.last_s);
  for (std::size_t k = path.PieceOf(span.first_s); k <= last; ++k) {
    const double square = path.PieceVelocity_mps(k).squaredNorm();
    turning_1.push_back(path.AccelerationMisfit_mps2(k) * span.range_m / square);
    if (turning_1.back() > ConeTurning::kFolding_1) ++out.folded;
  }
  out.pieces = turning_1.size();
  out.largest_1 = *std::max_element(turning_1.begin(), turning_1.end());
  const auto middle = turning_1.begin() + static_cast<std::ptrdiff_t>(turning_1.size() / 2);
  std::nth_element(turning_1.begin(), middle, turning_1.end());
  out.median_1 = *middle;
  return out;
}

}  // namespace

LookModel::LookModel(const Block& block,
                     const ParameterLayout& layout,
                     const Simplified& simplified)
    : block_(block), layout_(layout), simplified_(simplified), readings_(block.passes.size()) {
  if (simplified.flat_frame) middle_ = block.frame.VerticalAt(simplified.middle_m);
  if (simplified.linear_velocity) {
    for (const Pass& pass : block.passes) straightened_.push_back(StraightenedPath(pass));
  }
  const std::vector<Span> spans = SpansOf(block);
  for (std::size_t pass = 0; pass < block.passes.size(); ++pass) {
    const FlightPath& path = PathOf(pass);
    PassReading& reading = readings_[pass];
    reading.turning = MeasureTurning(path, spans[pass]);
    reading.acceleration = reading.turning.largest_1 <= kMostTurn_1 ? Acceleration::kOfCubic
                                                                    : Acceleration::kOfVelocities;
    if (!layout.passes[pass].NeedsTrackAxes()) continue;
    if (simplified.fixed_track_axes ||
        (block.frame.kind() == FrameKind::kLocal && path.IsStraight())) {
      reading.axes = TrackAxesUse::kConstant;
      reading.axes_1 = AxesInTheMiddle(block.frame, path, block.passes[pass]);
    } else {
      reading.axes = TrackAxesUse::kTurning;
      reading.verticals = VerticalTable(block.frame, path);
    }
  }
}

LookSigma LookModel::SigmaOf(std::size_t look) const {
  LookSigma sigma = block_.SigmaOf(look);
  if (!sigma_factor_1_.empty()) {
    const std::array<double, 2>& factor = sigma_factor_1_[block_.looks.pass[look]];
    sigma.range_m *= factor[0];
    sigma.azimuth *= factor[1];
  }
  return sigma;
}

Cone LookModel::ConeOf(std::size_t look) const {
  Cone cone;
  const Looks& looks = block_.looks;
  if (looks.cone.empty()) return cone;
  if ((looks.flags[look] & Looks::kDoppler) != 0) {
    cone.kind = Cone::Kind::kDoppler;
    cone.closing_mps = 0.5 * block_.passes[looks.pass[look]].wavelength_m * looks.cone[look];
  } else {
    cone.squint_rad = looks.cone[look];
  }
  return cone;
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

double LookModel::WorkOf(std::size_t pass) const {
  const PassCorrections& c = layout_.passes[pass];
  const bool geocentric = block_.frame.kind() == FrameKind::kGeocentric;
  double work = PathOf(pass).IsStraight() ? 100.0 : 105.0;
  if (readings_[pass].axes == TrackAxesUse::kTurning) work += geocentric ? 60.0 : 45.0;
  if (!c.troposphere.empty()) work += geocentric && !simplified_.flat_frame ? 120.0 : 40.0;
  return work;
}

Vertical LookModel::DelayVerticalAt(const Eigen::Vector3d& p_m) const {
  if (!simplified_.flat_frame) return block_.frame.VerticalAt(p_m);
  Vertical plane = middle_;
  plane.height_m += middle_.up_1.dot(p_m - simplified_.middle_m);
  plane.dup_dp.setZero();
  return plane;
}

}  // namespace sarblock
