// SPDX-License-Identifier: Apache-2.0
#include "adjusted_image.h"

#include "sarblock/core/error.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>
#include <unordered_map>
#include <utility>

#include "files/correction_options.h"
#include "geometry/track_axes.h"
#include "linear/dense.h"
#include <Eigen/Dense>
#include <fmt/core.h>
#include <glog/logging.h>

namespace sarblock {

Eigen::MatrixXd FitParameters(std::span<const FitTime> times) {
  if (times.empty()) throw InputError("times", "none to fit at");
  const Eigen::Index unknowns = times.front().by_format.cols();
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(unknowns, unknowns);
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(unknowns, times.front().by_result.cols());
  for (const FitTime& time : times) {
    normal += time.by_format.transpose() * time.by_format;
    right += time.by_format.transpose() * time.by_result;
  }
  // Columns are metres and metres per second: scaled to unit diagonal.
  const Eigen::VectorXd scale = normal.diagonal().cwiseSqrt();
  if (!(scale.minCoeff() > 0.0)) throw InputError("times", "do not determine the parameters");
  const Eigen::MatrixXd scaled =
      scale.cwiseInverse().asDiagonal() * normal * scale.cwiseInverse().asDiagonal();
  const dense::PivotedCholesky factor(scaled);
  constexpr double kMinPivot = 1e-10;
  if (!factor.PivotsAbove(kMinPivot)) {
    throw InputError("times", "do not determine the parameters");
  }
  const Eigen::MatrixXd solution =
      factor.Solve(Eigen::MatrixXd(scale.cwiseInverse().asDiagonal() * right));
  return scale.cwiseInverse().asDiagonal() * solution;
}

double UnfittedSigma_m(std::span<const FitTime> times,
                       Eigen::Index rows,
                       const Eigen::MatrixXd& fit,
                       const Eigen::MatrixXd& covariance) {
  double largest_m2 = 0.0;
  for (const FitTime& time : times) {
    const Eigen::MatrixXd rest = time.by_result.topRows(rows) - time.by_format.topRows(rows) * fit;
    largest_m2 = std::max(largest_m2, (rest * covariance * rest.transpose()).trace());
  }
  return std::sqrt(largest_m2);
}

namespace {

// The passes without looks; the one of the image has the image's path.
Block PassesOf(const files::ResultFile& result, std::size_t pass, const FlightPath& image_path) {
  Block block;
  block.frame = result.frame;
  for (std::size_t i = 0; i < result.passes.size(); ++i) {
    const files::ResultPass& given = result.passes[i];
    Pass made;
    made.id = given.id;
    made.side = given.side;
    made.wavelength_m = given.wavelength_m;
    made.start_s = given.start_s;
    made.end_s = given.end_s;
    made.path = i == pass ? image_path : given.path;
    block.passes.push_back(std::move(made));
  }
  return block;
}

// The layout, whose parameters must be those of passes.csv, one by one.
ParameterLayout LayoutOf(const files::ResultFile& result, const Block& block) {
  std::vector<CorrectionGroup> groups;
  if (!result.parameters.empty()) groups = CorrectionsOf(result);
  ParameterLayout layout = MakeParameterLayout(block, groups);
  const auto same = [](const Parameter& a, const ParameterResult& b) {
    return a.owner == b.owner && a.name == b.name;
  };
  if (!std::equal(layout.parameters.begin(),
                  layout.parameters.end(),
                  result.parameters.begin(),
                  result.parameters.end(),
                  same)) {
    throw InputError("passes.csv",
                     "its parameters are not those of the corrections in summary.json: the files "
                     "are of two results");
  }
  return layout;
}

// Beyond an end with acceleration and jerk of the velocities there.
Motion ReadContinued(const FlightPath& path, double time_s) {
  const double inside_s = std::clamp(time_s, path.start_s(), path.end_s());
  const double beyond_s = time_s - inside_s;
  Motion motion;
  CHECK(path.Read(inside_s, Acceleration::kOfVelocities, &motion));
  return beyond_s == 0.0 ? motion : motion.After(beyond_s);
}

}  // namespace

AdjustedAntenna::AdjustedAntenna(const files::ResultFile& result,
                                 std::size_t pass,
                                 const FlightPath& image_path,
                                 const std::string& file)
    : result_(result),
      pass_(pass),
      block_(PassesOf(result, pass, image_path)),
      layout_(LayoutOf(result, block_)),
      model_(block_, layout_) {
  CollectParameters();
  CollectCovariance();
  RefuseOtherImage(file);
}

void AdjustedAntenna::CollectParameters() {
  const PassCorrections& corrections = layout_.passes[pass_];
  const auto add = [this](const ParameterBlock& block) {
    for (int i = 0; i < block.size; ++i) {
      parameters_.push_back(static_cast<std::size_t>(block.offset + i));
    }
  };
  for (const int block : corrections.blocks) add(layout_.blocks[static_cast<std::size_t>(block)]);
  for (const SplineTerm& term : corrections.splines) {
    for (std::size_t q = 0; q < term.spline.count(); ++q) {
      add(layout_.blocks[static_cast<std::size_t>(term.first_block) + q]);
    }
  }
}

void AdjustedAntenna::CollectCovariance() {
  const auto size = static_cast<Eigen::Index>(parameters_.size());
  if (size > 0 && result_.parameter_covariance.empty()) return;
  std::unordered_map<std::size_t, Eigen::Index> place;
  for (std::size_t k = 0; k < parameters_.size(); ++k) {
    place[parameters_[k]] = static_cast<Eigen::Index>(k);
  }
  covariance_ = Eigen::MatrixXd::Zero(size, size);
  for (const ParameterCovariance& entry : result_.parameter_covariance) {
    const auto a = place.find(entry.a), b = place.find(entry.b);
    if (a == place.end() || b == place.end()) continue;
    covariance_(a->second, b->second) = covariance_(b->second, a->second) = entry.covariance;
  }
}

void AdjustedAntenna::RefuseOtherImage(const std::string& file) const {
  Eigen::VectorXd x(layout_.size());
  for (int j = 0; j < layout_.size(); ++j) {
    x[j] = result_.parameters[static_cast<std::size_t>(j)].value;
  }
  const FlightPath& image = block_.passes[pass_].path;
  const double bias_s = time_bias_s();
  const double from_s = std::max(image.start_s(), pass().path.start_s() + bias_s);
  const double to_s = std::min(image.end_s(), pass().path.end_s() + bias_s);
  double largest_m = from_s < to_s ? 0.0 : kOther_m * 2.0;
  constexpr int kParts = 32;
  for (int k = 0; k <= kParts && from_s < to_s; ++k) {
    const double path_s = from_s + (to_s - from_s) * k / kParts;
    const auto expected = model_.CorrectedMotionAtPathTime(pass_, path_s - bias_s, path_s, x);
    if (!expected) continue;
    const double apart_m = (expected->motion.position_m - MotionAt(path_s).position_m).norm();
    largest_m = std::max(largest_m, apart_m);
  }
  if (largest_m <= kOther_m) return;
  throw InputError(
      FilePlace{file, 0, ""},
      from_s < to_s
          ? fmt::format("is not the image of pass '{}': its path with the corrections of the "
                        "result lies up to {:.0f} m from that of the result",
                        pass().id,
                        largest_m)
          : fmt::format("is not the image of pass '{}': their times have nothing in common",
                        pass().id));
}

double AdjustedAntenna::ValueOf(ParameterKind kind) const {
  double sum = 0.0;
  for (std::size_t k = 0; k < parameters_.size(); ++k) {
    if (parameter(k).kind == kind) sum += value(k);
  }
  return sum;
}

Motion AdjustedAntenna::MotionAt(double path_time_s) const {
  return ReadContinued(pass().path, path_time_s - time_bias_s());
}

AntennaInfluence AdjustedAntenna::InfluenceAt(double path_time_s, Direction direction) const {
  const auto count = static_cast<Eigen::Index>(parameters_.size());
  AntennaInfluence influence = AntennaInfluence::Zero(6, count);
  const FlightPath& image = block_.passes[pass_].path;
  const double path_s = std::clamp(path_time_s, image.start_s(), image.end_s());
  const double measured_s = path_s - time_bias_s();
  const Motion motion = MotionAt(path_s);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(layout_.size());
  const auto read = [&] {
    const auto at = model_.CorrectedMotionAtPathTime(pass_, measured_s, path_s, x);
    CHECK(at.has_value());
    Eigen::Matrix<double, 6, 1> state;
    state << at->motion.position_m, at->motion.velocity_mps;
    return state;
  };
  const Eigen::Matrix<double, 6, 1> nominal = read();
  const TrackAxes axes = TrackAxesOf(result_.frame, motion);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Parameter& parameter = this->parameter(static_cast<std::size_t>(k));
    switch (parameter.kind) {
      case ParameterKind::kPosition: {
        // Linear in the parameter: a large step costs no digits.
        constexpr double kStep_m = 1e4;
        double& entry = x[static_cast<Eigen::Index>(parameters_[static_cast<std::size_t>(k)])];
        entry = kStep_m;
        influence.col(k) = (read() - nominal) / kStep_m;
        entry = 0.0;
        break;
      }
      case ParameterKind::kTimeBias:
        influence.col(k) << motion.velocity_mps, motion.acceleration_mps2;
        break;
      case ParameterKind::kVelocityAcross:
      case ParameterKind::kVelocityUp: {
        const Eigen::Index axis = parameter.kind == ParameterKind::kVelocityAcross ? 1 : 2;
        if (direction == Direction::kOfCone) {
          influence.col(k).tail<3>() = motion.velocity_mps.norm() * axes.axes.col(axis);
        }
        break;
      }
      default:
        break;
    }
  }
  return influence;
}

Eigen::Vector3d ConeVelocity(const AdjustedAntenna& antenna,
                             const Frame& frame,
                             const Motion& motion) {
  const double across = antenna.ValueOf(ParameterKind::kVelocityAcross);
  const double up = antenna.ValueOf(ParameterKind::kVelocityUp);
  if (across == 0.0 && up == 0.0) return motion.velocity_mps;
  const TrackAxes axes = TrackAxesOf(frame, motion);
  return motion.velocity_mps +
         motion.velocity_mps.norm() * (across * axes.axes.col(1) + up * axes.axes.col(2));
}

namespace {

std::vector<PassImage> ImagesOf(const ExportView& view) {
  if (view.options.images.empty()) {
    throw InputError("image", "none given: --image PASS=FILE names the file of a pass");
  }
  std::vector<std::string> ids;
  for (const files::ResultPass& pass : view.result.passes) ids.push_back(pass.id);
  std::vector<PassImage> images;
  std::set<std::size_t> passes;
  for (const ExportImage& image : view.options.images) {
    const auto found = std::find(ids.begin(), ids.end(), image.pass);
    if (found == ids.end()) {
      throw InputError(
          "image",
          "the result has no pass '" + image.pass + "'" + DidYouMean(NearestName(image.pass, ids)));
    }
    const auto pass = static_cast<std::size_t>(found - ids.begin());
    if (!passes.insert(pass).second) {
      throw InputError("image", "pass '" + image.pass + "' is given two files, one is allowed");
    }
    images.push_back({pass, image.file});
  }
  return images;
}

}  // namespace

UtcTime EpochOf(const files::ResultPass& pass, const std::string& what) {
  if (pass.epoch_utc.empty()) {
    throw InputError("format",
                     what + " needs UTC, and pass '" + pass.id +
                         "' has no epoch for its time_s = 0: set epoch_utc of the pass in "
                         "block.toml");
  }
  const auto epoch = ParseUtc(pass.epoch_utc);
  if (!epoch) {
    throw InputError("format",
                     what + " needs UTC, and epoch_utc of pass '" + pass.id + "', '" +
                         pass.epoch_utc + "', is no such time; 2022-10-16T01:50:44Z is one");
  }
  return *epoch;
}

std::string FileNameOf(const std::string& id) {
  std::string name = id;
  std::replace_if(
      name.begin(),
      name.end(),
      [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '.' && c != '-';
      },
      '_');
  return name;
}

void WriteImageFiles(const std::filesystem::path& folder,
                     const ExportView& view,
                     const char* ending,
                     const ImageMaker& make,
                     ExportReport* report) {
  const std::vector<PassImage> images = ImagesOf(view);
  std::vector<std::pair<std::string, std::string>> files;
  std::set<std::string> names;
  for (const PassImage& image : images) {
    const std::string& id = view.result.passes[image.pass].id;
    MadeImage made = make(image);
    files.emplace_back(FileNameOf(id) + ending, std::move(made.text));
    if (!names.insert(files.back().first).second) {
      throw InputError("format", "two passes would have the file " + files.back().first);
    }
    for (const std::string& what : made.notes.not_carried) {
      report->not_carried.push_back(id + ": " + what);
    }
    for (const std::string& what : made.notes.warnings)
      report->warnings.push_back(id + ": " + what);
  }
  for (std::size_t pass = 0; pass < view.result.passes.size(); ++pass) {
    const auto of_pass = [pass](const PassImage& image) { return image.pass == pass; };
    if (std::none_of(images.begin(), images.end(), of_pass)) {
      report->not_carried.push_back(view.result.passes[pass].id + ": no --image was given for it");
    }
  }
  report->not_carried.emplace_back(
      "points, residuals, covariances between passes; standard deviations of points");
  MakeFolder(folder);
  for (const auto& [name, text] : files) {
    AtomicFile out(folder / name);
    out.Write(text);
    out.Commit();
    report->files.push_back(folder / name);
  }
  report->paths = files.size();
}

}  // namespace sarblock
