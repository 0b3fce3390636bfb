// SPDX-License-Identifier: Apache-2.0
#include "sicd_offsets.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/intersection.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <sstream>
#include <utility>

#include "adjusted_image.h"
#include "core/text.h"
#include "export.h"
#include "products/bytes.h"
#include "products/sicd.h"
#include "products/sicd_image.h"
#include "products/xml.h"
#include <Eigen/Dense>
#include <fmt/core.h>

namespace sarblock {
namespace {

constexpr std::string_view kNamespace = "urn:SICD:";
constexpr const char* kAdjusted = "AdjustableParameterOffsets";
constexpr std::string_view kMark = " written by sarblock ";

struct SicdVersion {
  int major = 0, minor = 0;
};

SicdVersion VersionOf(const XmlElement& root) {
  const std::string given = root.AttributeText("xmlns");
  SicdVersion version;
  const auto fail = [&] {
    root.Fail("its namespace xmlns is " + Quoted(given) +
              ", urn:SICD:1.0.0 or later is needed, which has the version");
  };
  if (!given.starts_with(kNamespace)) fail();
  const char* const end = given.data() + given.size();
  const auto major = std::from_chars(given.data() + kNamespace.size(), end, version.major);
  if (major.ec != std::errc() || major.ptr == end || *major.ptr != '.') fail();
  const auto minor = std::from_chars(major.ptr + 1, end, version.minor);
  if (minor.ec != std::errc() || version.major < 1) fail();
  return version;
}

void AddNumber(pugi::xml_node parent, const char* name, double value) {
  parent.append_child(name).text().set(NumberText(value).c_str());
}

void AddVector(pugi::xml_node parent, const char* name, const Eigen::Vector3d& vector) {
  pugi::xml_node node = parent.append_child(name);
  AddNumber(node, "X", vector.x());
  AddNumber(node, "Y", vector.y());
  AddNumber(node, "Z", vector.z());
}

// Only elements that are not zero, as the type of the matrix allows.
void AddMatrix(pugi::xml_node parent, const char* name, const Eigen::Matrix<double, 8, 8>& matrix) {
  pugi::xml_node node = parent.append_child(name);
  node.append_attribute("size1").set_value(8);
  node.append_attribute("size2").set_value(8);
  for (int i = 0; i < 8; ++i) {
    for (int j = 0; j < 8; ++j) {
      if (matrix(i, j) == 0.0) continue;
      pugi::xml_node entry = node.append_child("Entry");
      entry.append_attribute("index1").set_value(i + 1);
      entry.append_attribute("index2").set_value(j + 1);
      entry.text().set(NumberText(matrix(i, j)).c_str());
    }
  }
}

// ErrorStatistics comes before MatchInfo and the elements of the kind of image.
pugi::xml_node StatisticsOf(pugi::xml_node root) {
  if (pugi::xml_node statistics = root.child("ErrorStatistics")) return statistics;
  for (const char* after : {"MatchInfo", "RgAzComp", "PFA", "RMA"}) {
    if (const pugi::xml_node next = root.child(after)) {
      return root.insert_child_before("ErrorStatistics", next);
    }
  }
  return root.append_child("ErrorStatistics");
}

void SetMark(pugi::xml_document* document) {
  for (pugi::xml_node node : document->children()) {
    if (node.type() == pugi::node_comment && std::string_view(node.value()).starts_with(kMark)) {
      document->remove_child(node);
      break;
    }
  }
  pugi::xml_node mark =
      document->insert_child_before(pugi::node_comment, document->document_element());
  mark.set_value((std::string(kMark) + Version() + " ").c_str());
}

}  // namespace

AdjustedSicd AdjustSicd(std::string_view bytes,
                        const std::string& file,
                        const SicdAdjustment& adjustment) {
  ByteSource source = ByteSource::FromBytes(bytes, file);
  const std::string text = SicdText(&source);
  AdjustedSicd adjusted;
  {
    const XmlFile checked(text, file, "SICD");  // refuses with lines
    const SicdVersion version = VersionOf(checked.Root());
    constexpr int kWithOffsets = 4;
    adjusted.raised = version.major == 1 && version.minor < kWithOffsets;
  }
  // Blanks and comments stay where they are.
  pugi::xml_document document;
  constexpr unsigned int kKeepAll = pugi::parse_full | pugi::parse_ws_pcdata;
  if (!document.load_buffer(text.data(), text.size(), kKeepAll, pugi::encoding_utf8)) {
    throw InputError(FilePlace{file, 0, ""}, "is not valid XML");
  }
  pugi::xml_node root = document.document_element();
  if (adjusted.raised) root.attribute("xmlns").set_value("urn:SICD:1.4.0");
  pugi::xml_node statistics = StatisticsOf(root);
  while (statistics.remove_child(kAdjusted)) {
  }
  pugi::xml_node offsets = statistics.append_child(kAdjusted);
  AddVector(offsets, "ARPPosSCPCOA", adjustment.offsets.position_m);
  AddVector(offsets, "ARPVel", adjustment.offsets.velocity_mps);
  AddNumber(offsets, "TxTimeSCPCOA", 0.0);
  AddNumber(offsets, "RcvTimeSCPCOA", 2.0 / kSpeedOfLight_mps * adjustment.offsets.range_m);
  if (adjustment.covariance) AddMatrix(offsets, "APOError", *adjustment.covariance);
  if (adjustment.composite) {
    pugi::xml_node composite = offsets.append_child("CompositeSCP");
    AddNumber(composite, "Rg", adjustment.composite->range_m);
    AddNumber(composite, "Az", adjustment.composite->azimuth_m);
    AddNumber(composite, "RgAz", adjustment.composite->correlation);
  }
  SetMark(&document);
  std::ostringstream out;
  document.save(out, "", pugi::format_raw, pugi::encoding_utf8);
  adjusted.text = out.str();
  return adjusted;
}

AdjustedSicd AdjustSicdFile(const std::string& file, const SicdAdjustment& adjustment) {
  ByteSource source = ByteSource::FromFile(file);
  const std::string text = SicdText(&source);
  return AdjustSicd(text, file, adjustment);
}

namespace {

/// Smaller differences are not reported.
constexpr double kSicdReported_m = 1e-3;
constexpr int kFitTimes = 65;

ImagePass PassAt(const SicdImage& image, const UtcTime& epoch) {
  ImagePass made = PassOfSicd(image);
  const double shift_s = SecondsBetween(epoch, *ParseUtc(made.pass.epoch_utc));
  std::vector<StateVector> states = made.pass.path.states();
  for (StateVector& state : states) state.time_s += shift_s;
  made.pass.path = FlightPath(std::move(states));
  for (double& time_s : *made.span_s) time_s += shift_s;
  return made;
}

/// One pass on its way into AdjustableParameterOffsets.
class OffsetMaker {
 public:
  OffsetMaker(const files::ResultFile& result, const PassImage& given)
      : result_(result),
        file_(given.file),
        image_(ReadSicd(given.file)),
        epoch_(EpochOf(result.passes[given.pass], "a SICD image")),
        start_s_(SecondsBetween(epoch_, image_.start)),
        made_(PassAt(image_, epoch_)),
        antenna_(result, given.pass, made_.pass.path, given.file) {
    RequireOffsetsAlone();
    if (std::isnan(image_.centre_time_s)) {
      throw InputError(FilePlace{file_, 0, "SICD.SCPCOA.SCPTime"},
                       "the element is missing, the offsets count from it");
    }
  }

  MadeImage Make() {
    SicdAdjustment adjustment;
    const Eigen::MatrixXd fit = Fit();
    adjustment.offsets = Offsets();
    if (antenna_.HasCovariance()) {
      adjustment.covariance = Covariance(fit);
      adjustment.composite = Composite(adjustment.offsets, *adjustment.covariance);
    } else {
      notes_.not_carried.emplace_back("APOError and CompositeSCP: the result has no covariance");
    }
    CompareWithApertures(adjustment.offsets);
    AdjustedSicd adjusted = AdjustSicdFile(file_, adjustment);
    if (adjusted.raised) {
      notes_.warnings.emplace_back(
          "the version of the file is raised to 1.4.0, the first that knows offsets");
    }
    return {std::move(adjusted.text), std::move(notes_)};
  }

 private:
  // Offset and drift of the path, a time bias, a range bias.
  void RequireOffsetsAlone() const {
    std::string others;
    for (std::size_t k = 0; k < antenna_.parameters().size(); ++k) {
      const Parameter& parameter = antenna_.parameter(k);
      const bool path =
          parameter.kind == ParameterKind::kPosition && !parameter.spline && parameter.degree <= 1;
      if (path || parameter.kind == ParameterKind::kTimeBias ||
          parameter.kind == ParameterKind::kRangeBias) {
        continue;
      }
      if (parameter.spline) {
        if (others.find("position (spline)") == std::string::npos) {
          others += (others.empty() ? "" : ", ") + std::string("position (spline)");
        }
        continue;
      }
      others += (others.empty() ? "" : ", ") + parameter.name;
    }
    if (others.empty()) return;
    throw InputError("format",
                     "a SICD image holds an offset and a drift of the path, time and range biases; "
                     "pass '" +
                         antenna_.pass().id + "' has " + others + " besides");
  }

  // Measured times, evenly over the image.
  [[nodiscard]] double Time_s(int k) const {
    const auto [first_s, last_s] = *made_.span_s;
    return first_s + (last_s - first_s) * k / (kFitTimes - 1);
  }
  [[nodiscard]] double SinceCentre_s(double time_s) const {
    return time_s - (start_s_ + image_.centre_time_s);
  }
  [[nodiscard]] double PathTime_s(double time_s) const { return time_s + antenna_.time_bias_s(); }

  // Rows of position, and of velocity as it moves the scene centre along the track: R/|v| turns the
  // one into the other.
  [[nodiscard]] double MetresOfVelocity_s() const {
    const SicdMotion motion = MotionOf(image_, image_.centre_time_s);
    return (motion.position_m - image_.centre_m).norm() / motion.velocity_mps.norm();
  }
  // Offset and drift, columns 0 to 2 and 3 to 5, of these.
  [[nodiscard]] Eigen::MatrixXd OffsetJacobian(double time_s) const {
    Eigen::MatrixXd by = Eigen::MatrixXd::Zero(6, 6);
    by.topLeftCorner(3, 3).setIdentity();
    by.topRightCorner(3, 3).diagonal().setConstant(SinceCentre_s(time_s));
    by.bottomRightCorner(3, 3).diagonal().setConstant(MetresOfVelocity_s());
    return by;
  }

  // What the corrections do to offset and drift; kept for the covariance.
  Eigen::MatrixXd Fit() {
    std::vector<FitTime> times;
    for (int k = 0; k < kFitTimes; ++k) {
      const double time_s = Time_s(k);
      Eigen::MatrixXd by_result =
          antenna_.InfluenceAt(PathTime_s(time_s), AdjustedAntenna::Direction::kOfPath);
      by_result.bottomRows(3) *= MetresOfVelocity_s();
      times.push_back({OffsetJacobian(time_s), std::move(by_result)});
    }
    Eigen::MatrixXd fit = FitParameters(times);
    if (antenna_.HasCovariance() && !antenna_.parameters().empty()) {
      const double rest_m = UnfittedSigma_m(times, 6, fit, antenna_.covariance());
      if (rest_m > kSicdReported_m) {
        notes_.not_carried.push_back(fmt::format(
            "APOError holds an offset and a drift; the error about them, up to {:.3g} m (1 "
            "sigma)",
            rest_m));
      }
    }
    return fit;
  }

  // The deviation of the result's path from ARPPoly, by the same least squares. It includes the
  // offsets of the file, and the range bias is added to theirs.
  SicdOffsets Offsets() {
    std::vector<FitTime> times;
    for (int k = 0; k < kFitTimes; ++k) {
      const double time_s = Time_s(k);
      const SicdMotion nominal = MotionOf(image_, time_s - start_s_);
      const Motion found = antenna_.MotionAt(PathTime_s(time_s));
      Eigen::VectorXd change_m(6);
      change_m << found.position_m - nominal.position_m,
          MetresOfVelocity_s() * (found.velocity_mps - nominal.velocity_mps);
      times.push_back({OffsetJacobian(time_s), change_m});
    }
    const Eigen::VectorXd fit = FitParameters(times);
    double largest_m = 0.0;
    for (const FitTime& time : times) {
      largest_m = std::max(largest_m, (time.by_result - time.by_format * fit).norm());
    }
    if (largest_m > kSicdReported_m) {
      notes_.not_carried.push_back(fmt::format(
          "deviations of the path from an offset and a drift, up to {:.3g} m at the scene centre",
          largest_m));
    }
    SicdOffsets offsets;
    offsets.position_m = fit.head<3>();
    offsets.velocity_mps = fit.tail<3>();
    // R + range is the distance of the antenna; R = distance + b_r.
    offsets.range_m = image_.RangeOffset_m() - antenna_.ValueOf(ParameterKind::kRangeBias);
    return offsets;
  }

  [[nodiscard]] Eigen::Matrix<double, 8, 8> Covariance(const Eigen::MatrixXd& fit) const {
    const auto count = static_cast<Eigen::Index>(antenna_.parameters().size());
    Eigen::MatrixXd gain = Eigen::MatrixXd::Zero(8, count);
    gain.topRows(6) = fit;
    for (Eigen::Index k = 0; k < count; ++k) {
      if (antenna_.parameter(static_cast<std::size_t>(k)).kind == ParameterKind::kRangeBias) {
        gain(7, k) = -2.0 / kSpeedOfLight_mps;
      }
    }
    const Eigen::Matrix<double, 8, 8> covariance = gain * antenna_.covariance() * gain.transpose();
    return 0.5 * (covariance + covariance.transpose());
  }

  // Range and azimuth in the slant plane of the scene centre (NGA.STND.0024-3: sensitivity of range
  // and range rate to the offsets, and of the place in the slant plane to these).
  [[nodiscard]] SicdComposite Composite(const SicdOffsets& offsets,
                                        const Eigen::Matrix<double, 8, 8>& covariance) const {
    SicdImage adjusted = image_;
    adjusted.offsets = offsets;
    const SicdMotion antenna = AdjustedMotionOf(adjusted, image_.centre_time_s);
    const Eigen::Vector3d from_m = antenna.position_m - image_.centre_m;
    const double range_m = from_m.norm();
    const Eigen::Vector3d los = from_m / range_m;
    const Eigen::Vector3d across_mps = antenna.velocity_mps - antenna.velocity_mps.dot(los) * los;
    Eigen::Matrix<double, 2, 8> partials = Eigen::Matrix<double, 2, 8>::Zero();
    partials.block<1, 3>(0, 0) = -los.transpose();
    partials.block<1, 3>(1, 0) = -across_mps.transpose() / range_m;
    partials.block<1, 3>(1, 3) = -los.transpose();
    partials(0, 6) = -0.5 * kSpeedOfLight_mps;
    partials(0, 7) = 0.5 * kSpeedOfLight_mps;
    // The second axis of the slant plane is along the flight where the image looks to the left.
    const double side = image_.side == LookSide::kLeft ? 1.0 : -1.0;
    partials.row(1) *= side * range_m / across_mps.norm();
    const Eigen::Matrix2d plane_m2 = partials * covariance * partials.transpose();
    SicdComposite composite;
    composite.range_m = std::sqrt(plane_m2(0, 0));
    composite.azimuth_m = std::sqrt(plane_m2(1, 1));
    const double product_m2 = composite.range_m * composite.azimuth_m;
    if (product_m2 > 0.0) {
      composite.correlation = std::clamp(plane_m2(0, 1) / product_m2, -1.0, 1.0);
    }
    return composite;
  }

  // A look of zero Doppler is corrected at its own time; the standard adds offsets at the centre of
  // the aperture.
  void CompareWithApertures(const SicdOffsets& offsets) {
    if (!HasRaster(image_) || image_.aperture_time_s.empty() || image_.rate_scale.empty()) return;
    SicdImage adjusted = image_;
    adjusted.offsets = offsets;
    SicdImage given = image_;
    given.offsets.reset();
    std::array<double, 2> largest_m{};
    const double last_row = static_cast<double>(image_.rows - 1);
    const double last_column = static_cast<double>(image_.columns - 1);
    for (const double row : {0.0, 0.5, 1.0}) {
      for (const double column : {0.0, 0.5, 1.0}) {
        const auto with = ApertureMisfit_m(adjusted, row * last_row, column * last_column);
        const auto without = ApertureMisfit_m(given, row * last_row, column * last_column);
        if (!with || !without) continue;
        for (std::size_t k = 0; k < 2; ++k) {
          largest_m[k] = std::max(largest_m[k], std::abs((*with)[k] - (*without)[k]));
        }
      }
    }
    if (std::max(largest_m[0], largest_m[1]) <= kSicdReported_m) return;
    notes_.not_carried.push_back(
        fmt::format("looks of zero Doppler as they are corrected here: offsets that are added at "
                    "the centre of the aperture place them up to {:.3g} m in range and {:.3g} m "
                    "along the track from there",
                    largest_m[0],
                    largest_m[1]));
  }
  // Misfit of range and azimuth at the centre of the aperture, given less computed, for the place
  // that the look of closest approach sees.
  [[nodiscard]] std::optional<std::array<double, 2>> ApertureMisfit_m(const SicdImage& image,
                                                                      double row,
                                                                      double column) const {
    const double closest_s = ValueOf(image.closest_time_s, image.Azimuth_m(column));
    const SicdMotion closest = AdjustedMotionOf(image, closest_s);
    FixedPathLook observation;
    observation.antenna_m = closest.position_m;
    observation.velocity_mps = closest.velocity_mps;
    observation.range_m = image.ClosestRange_m(row);
    observation.side = static_cast<int>(image.side);
    const double height_m = result_.frame.GeodeticFromFrame(image.centre_m).h_m;
    const Intersection place = IntersectWithHeight(observation, result_.frame, height_m);
    const auto look = LookOfPlace(image, row, column);
    if (place.outcome != IntersectionOutcome::kDetermined || !look) return std::nullopt;
    const SicdMotion antenna = AdjustedMotionOf(image, look->time_s);
    const Eigen::Vector3d from_m = antenna.position_m - place.position_m;
    const double range_m = from_m.norm();
    const double rate_mps = antenna.velocity_mps.dot(from_m) / range_m;
    return std::array<double, 2>{
        look->range_m - range_m,
        (look->range_rate_mps - rate_mps) * range_m / antenna.velocity_mps.norm()};
  }

  const files::ResultFile& result_;
  std::string file_;
  SicdImage image_;
  UtcTime epoch_;
  double start_s_;  ///< of the collection, from the epoch
  ImagePass made_;
  AdjustedAntenna antenna_;
  ImageNotes notes_;
};

}  // namespace

void WriteSicdOffsets(const std::filesystem::path& folder,
                      const ExportView& view,
                      ExportReport* report) {
  const auto make = [&view](const PassImage& image) {
    return OffsetMaker(view.result, image).Make();
  };
  WriteImageFiles(folder, view, ".xml", make, report);
}

}  // namespace sarblock
