// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sarblock/block/block.h"
#include "sarblock/files/result.h"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/utc.h"
#include "export.h"
#include "model/look_model.h"
#include <Eigen/Core>

namespace sarblock {

/// Contribution of one time to a fit: derivatives of the antenna by the q parameters of a format
/// (`by_format`) and by the n corrections of a result (`by_result`), as many rows each.
struct FitTime {
  Eigen::MatrixXd by_format, by_result;
};

/// The parameters of a format by least squares: the q that comes nearest to the effect of x
/// corrections on the antenna at all times together,
///
///     sum_k |A_k q - J_k x|^2 = min,   q = G x,   G = (sum A_k' A_k)^-1 sum A_k' J_k
///
/// docs/export.md, eq. (1). Where the corrections are parameters of the format, J_k = A_k T, it is
/// T. Throws InputError where the times do not determine q.
[[nodiscard]] Eigen::MatrixXd FitParameters(std::span<const FitTime> times);

/// Largest standard deviation, over the times, of what the format cannot represent: the root of the
/// largest trace of (J_k - A_k G) C (J_k - A_k G)' over its first `rows` rows, which are in metres.
[[nodiscard]] double UnfittedSigma_m(std::span<const FitTime> times,
                                     Eigen::Index rows,
                                     const Eigen::MatrixXd& fit,
                                     const Eigen::MatrixXd& covariance);

/// Position and velocity of an antenna by parameters: rows x, y, z [m] and vx, vy, vz [m/s] per
/// unit of the parameter.
using AntennaInfluence = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// One pass of a result and the path that its image gave: the corrected antenna and the covariance
/// of its corrections.
///
/// At the measured time t the antenna is where the corrected path is read, at t + b_t with the time
/// bias b_t (docs/theory/flight_path.md). Holds a reference to the result.
class AdjustedAntenna {
 public:
  /// `image_path` is the path of the image before any correction, times as in the result; `file`
  /// names the image in messages. Throws InputError where path and result are of different images:
  /// with the result's corrections it lies more than kOther_m from the result's path.
  AdjustedAntenna(const files::ResultFile& result,
                  std::size_t pass,
                  const FlightPath& image_path,
                  const std::string& file);

  /// Paths of the same image differ by less, however the states were read; paths of other images by
  /// much more.
  static constexpr double kOther_m = 10.0;

  [[nodiscard]] const files::ResultPass& pass() const { return result_.passes[pass_]; }
  /// Sum of the time biases.
  [[nodiscard]] double time_bias_s() const { return ValueOf(ParameterKind::kTimeBias); }
  /// Sum of the parameters of a kind other than a position, in their unit.
  [[nodiscard]] double ValueOf(ParameterKind kind) const;
  /// Corrected antenna at the measured time path_time_s - time_bias_s(); the first or last piece of
  /// the path is continued beyond its ends.
  [[nodiscard]] Motion MotionAt(double path_time_s) const;

  /// Parameters that correct this pass: their place in the result's list and what they are.
  [[nodiscard]] const std::vector<std::size_t>& parameters() const { return parameters_; }
  [[nodiscard]] const Parameter& parameter(std::size_t k) const {
    return layout_.parameters[parameters_[k]];
  }
  [[nodiscard]] double value(std::size_t k) const {
    return result_.parameters[parameters_[k]].value;
  }
  [[nodiscard]] double sigma(std::size_t k) const {
    return result_.parameters[parameters_[k]].sigma;
  }
  /// By parameters(): derivatives by positions and time biases; velocity groups turn the direction
  /// of flight and count where `with_direction`; all others are zero. They are those of the image's
  /// path, which depends on the corrections linearly.
  enum class Direction { kOfPath, kOfCone };
  [[nodiscard]] AntennaInfluence InfluenceAt(double path_time_s, Direction direction) const;
  /// Covariance by parameters(), in their units; without rows where the result has none.
  [[nodiscard]] const Eigen::MatrixXd& covariance() const { return covariance_; }
  [[nodiscard]] bool HasCovariance() const {
    return covariance_.rows() == static_cast<Eigen::Index>(parameters_.size());
  }

 private:
  void CollectParameters();
  void CollectCovariance();
  void RefuseOtherImage(const std::string& file) const;

  const files::ResultFile& result_;
  std::size_t pass_;
  Block block_;
  ParameterLayout layout_;
  LookModel model_;
  std::vector<std::size_t> parameters_;
  Eigen::MatrixXd covariance_;
};

/// Velocity direction of the cone as the velocity groups turn it, with the speed of the path:
/// |v| (v/|v| + c_across across + c_up up).
[[nodiscard]] Eigen::Vector3d ConeVelocity(const AdjustedAntenna& antenna,
                                           const Frame& frame,
                                           const Motion& motion);

/// The epoch time_s = 0 of a pass. Throws InputError if the block does not give it; `what` ("an
/// orbit file") needs it.
[[nodiscard]] UtcTime EpochOf(const files::ResultPass& pass, const std::string& what);

/// The id of a pass as the name of a file: letters, digits, dots and dashes; anything else becomes
/// an underscore.
[[nodiscard]] std::string FileNameOf(const std::string& id);

/// An image that was given for a pass.
struct PassImage {
  std::size_t pass = 0;  ///< index in the result
  std::string file;
};

/// Notes on one image's file.
struct ImageNotes {
  std::vector<std::string> not_carried;  ///< with its size where it has one
  std::vector<std::string> warnings;
};
/// One image's file as it was made.
struct MadeImage {
  std::string text;
  ImageNotes notes;
};
using ImageMaker = std::function<MadeImage(const PassImage&)>;

/// Writes one file for each image given, its name that of the pass and an ending, after all of them
/// are made. Passes without an image are listed among what is not carried. Throws InputError if no
/// image is given, two are of one pass, or a pass is not in the result.
void WriteImageFiles(const std::filesystem::path& folder,
                     const ExportView& view,
                     const char* ending,
                     const ImageMaker& make,
                     ExportReport* report);

}  // namespace sarblock
