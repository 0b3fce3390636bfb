// SPDX-License-Identifier: Apache-2.0
// Adjusted flights as their sensors have them: orbit files of Sentinel-1, model states of USGSCSM.
#include "sarblock/core/error.h"
#include "sarblock/geometry/intersection.h"
#include "sarblock/tables/output.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>
#include <utility>

#include "adjusted_image.h"
#include "core/utc.h"
#include "export.h"
#include "products/csm.h"
#include "products/image_table.h"
#include <fmt/core.h>
#include <pugixml.hpp>

namespace sarblock {
namespace {

void Add(pugi::xml_node parent, const char* name, const std::string& text) {
  parent.append_child(name).text().set(text.c_str());
}

void AddVector(pugi::xml_node parent,
               const std::array<const char*, 3>& names,
               const char* unit,
               const Eigen::Vector3d& vector) {
  for (std::size_t i = 0; i < 3; ++i) {
    pugi::xml_node node = parent.append_child(names[i]);
    node.append_attribute("unit") = unit;
    node.text().set(fmt::format("{}", vector[static_cast<Eigen::Index>(i)]).c_str());
  }
}

void AddHeader(pugi::xml_node root,
               const OrbitFile& orbit,
               const UtcTime& created,
               const std::string& creator_version) {
  pugi::xml_node header = root.append_child("Earth_Explorer_Header");
  pugi::xml_node fixed = header.append_child("Fixed_Header");
  Add(fixed, "File_Name", orbit.file);
  Add(fixed, "File_Description", "Flight path after a block adjustment");
  Add(fixed, "Notes", "");
  Add(fixed, "Mission", orbit.mission);
  Add(fixed, "File_Class", "USER");
  Add(fixed, "File_Type", "AUX_RESORB");
  pugi::xml_node validity = fixed.append_child("Validity_Period");
  Add(validity, "Validity_Start", "UTC=" + UtcMicroseconds(orbit.states.front().time));
  Add(validity, "Validity_Stop", "UTC=" + UtcMicroseconds(orbit.states.back().time));
  Add(fixed, "File_Version", "0001");
  pugi::xml_node source = fixed.append_child("Source");
  Add(source, "System", "sarblock");
  Add(source, "Creator", "sarblock");
  Add(source, "Creator_Version", creator_version);
  Add(source, "Creation_Date", "UTC=" + UtcMicroseconds(created));
  pugi::xml_node variable = header.append_child("Variable_Header");
  Add(variable, "Ref_Frame", "EARTH_FIXED");
  Add(variable, "Time_Reference", "UTC");
}

}  // namespace

std::string OrbitFileText(const OrbitFile& orbit,
                          const UtcTime& created,
                          const std::string& creator_version) {
  pugi::xml_document document;
  pugi::xml_node declaration = document.append_child(pugi::node_declaration);
  declaration.append_attribute("version") = "1.0";
  declaration.append_attribute("encoding") = "UTF-8";
  pugi::xml_node root = document.append_child("Earth_Explorer_File");
  AddHeader(root, orbit, created, creator_version);
  pugi::xml_node data = root.append_child("Data_Block");
  data.append_attribute("type") = "xml";
  pugi::xml_node list = data.append_child("List_of_OSVs");
  list.append_attribute("count") = static_cast<unsigned long long>(orbit.states.size());
  for (const OrbitState& state : orbit.states) {
    pugi::xml_node osv = list.append_child("OSV");
    Add(osv, "TAI", "TAI=" + TaiMicroseconds(state.time));
    Add(osv, "UTC", "UTC=" + UtcMicroseconds(state.time));
    AddVector(osv, {"X", "Y", "Z"}, "m", state.position_m);
    AddVector(osv, {"VX", "VY", "VZ"}, "m/s", state.velocity_mps);
    Add(osv, "Quality", "NOMINAL");
  }
  std::ostringstream text;
  document.save(text, "  ", pugi::format_default, pugi::encoding_utf8);
  return text.str();
}

namespace {

void RequireWgs84(const Frame& frame) {
  if (frame.kind() == FrameKind::kLocal) {
    throw InputError("format",
                     "an orbit file holds earth-fixed positions; the frame of this result is "
                     "local, a geocentric one on WGS84 is allowed");
  }
  const Ellipsoid wgs84 = NamedEllipsoid("WGS84");
  const Ellipsoid& given = frame.ellipsoid();
  if (given.a_m != wgs84.a_m || given.flattening != wgs84.flattening) {
    throw InputError(
        "format",
        "an orbit file holds positions on the Earth; the ellipsoid of this result is " +
            given.name + ", WGS84 is allowed");
  }
}

// Sentinel-1A of S1A_IW2_VV_...
std::string MissionOf(const files::ResultPass& pass, const ExportOptions& options) {
  if (!options.mission.empty()) return options.mission;
  const std::string& id = pass.id;
  const bool sentinel =
      id.size() >= 4 && id.compare(0, 2, "S1") == 0 && id[2] >= 'A' && id[2] <= 'D' && id[3] == '_';
  if (sentinel) return std::string("Sentinel-1") + id[2];
  throw InputError("mission",
                   "an orbit file names its satellite, and '" + id +
                       "' does not begin as Sentinel-1 products do (S1A_); --mission names it");
}

// The path at whole microseconds: 1 us is 7 mm of an orbit, so a state between two of them is not
// rounded but computed anew. Below a nanosecond (7 um) it is the state itself.
std::vector<OrbitState> StatesOf(const files::ResultPass& pass, const UtcTime& epoch) {
  constexpr double kSame_s = 1e-9;
  std::vector<OrbitState> states;
  for (const StateVector& state : pass.path.states()) {
    const UtcTime exact = AddSeconds(epoch, state.time_s);
    UtcTime whole = WholeMicrosecond(exact);
    double shift_s = SecondsBetween(exact, whole);
    if (std::abs(shift_s) <= kSame_s) {
      states.push_back({whole, state.position_m, state.velocity_mps});
      continue;
    }
    auto motion = pass.path.At(state.time_s + shift_s);
    if (!motion) {  // of the first or last state: the next one inside
      whole = WholeMicrosecond(AddSeconds(whole, shift_s < 0.0 ? 1e-6 : -1e-6));
      shift_s = SecondsBetween(exact, whole);
      motion = pass.path.At(state.time_s + shift_s);
    }
    if (!motion) continue;
    states.push_back({whole, motion->position_m, motion->velocity_mps});
  }
  const auto not_later = [](const OrbitState& a, const OrbitState& b) {
    return !(SecondsBetween(a.time, b.time) > 0.0);
  };
  states.erase(std::unique(states.begin(), states.end(), not_later), states.end());
  if (states.size() < 2) {
    throw InputError("format",
                     "pass '" + pass.id +
                         "' spans less than two microseconds, an orbit file needs "
                         "two states");
  }
  return states;
}

}  // namespace

void WriteOrbitFiles(const std::filesystem::path& folder,
                     const ExportView& view,
                     ExportReport* report) {
  RequireWgs84(view.result.frame);
  std::vector<OrbitFile> orbits;
  std::set<std::string> names;
  for (const files::ResultPass& pass : view.result.passes) {
    OrbitFile orbit{FileNameOf(pass.id), MissionOf(pass, view.options), {}};
    orbit.states = StatesOf(pass, EpochOf(pass, "an orbit file"));
    if (!names.insert(orbit.file).second) {
      throw InputError("format", "two passes would have the file " + orbit.file + ".EOF");
    }
    orbits.push_back(std::move(orbit));
  }
  const auto given = ParseUtc(view.options.created_utc);
  MakeFolder(folder);
  for (const OrbitFile& orbit : orbits) {
    const UtcTime created = given ? *given : orbit.states.back().time;
    const std::filesystem::path file = folder / (orbit.file + ".EOF");
    AtomicFile out(file);
    out.Write(OrbitFileText(orbit, WholeSecond(created), Version()));
    out.Commit();
    report->files.push_back(file);
  }
  report->paths = orbits.size();
  report->not_carried.emplace_back("points, residuals, standard deviations of the paths");
  for (const ParameterResult& parameter : view.result.parameters) {
    // Positions and times are in the states.
    if (parameter.name.starts_with("position.") || parameter.name == "time.bias") continue;
    report->not_carried.push_back(fmt::format(
        "{}: {} {:.6g} {}", parameter.owner, parameter.name, parameter.value, parameter.unit));
  }
}

namespace {

/// Smaller differences are not reported.
constexpr double kReported_m = 1e-3;

double EpochOfPass_s(const files::ResultPass& pass) {
  return EphemerisTime_s(EpochOf(pass, "a model state"));
}

FlightPath PathFrom(const RadarImage& image, double epoch_s) {
  std::vector<StateVector> states = image.states;
  for (StateVector& state : states) state.time_s -= epoch_s;
  try {
    return FlightPath(std::move(states));
  } catch (const InputError& error) {
    throw InputError(FilePlace{image.file, 0, ""}, error.what());
  }
}

void RequireBody(const Frame& frame, const RadarImage& image) {
  if (frame.kind() == FrameKind::kGeocentric &&
      std::abs(frame.ellipsoid().a_m - image.ellipsoid.a_m) <= kSameRadius * image.ellipsoid.a_m) {
    return;
  }
  throw InputError(FilePlace{image.file, 0, "radii"},
                   fmt::format("is an image of a body of radius {} km, the frame of the result is "
                               "{}",
                               1e-3 * image.ellipsoid.a_m,
                               frame.kind() == FrameKind::kLocal
                                   ? "local"
                                   : fmt::format("that of {} km", 1e-3 * frame.ellipsoid().a_m)));
}

/// One pass on its way into a model state.
class StateMaker {
 public:
  StateMaker(const files::ResultFile& result, const PassImage& given, RangePolynomialTimes reading)
      : result_(result),
        model_(ReadCsmModel(given.file)),
        epoch_s_(EpochOfPass_s(result.passes[given.pass])),
        antenna_(result, given.pass, PathFrom(model_.image, epoch_s_), given.file),
        image_pass_(PassOfRadarImage(model_.image, RangePolynomialTimes::kGiven)),
        reading_(reading) {
    RequireBody(result.frame, model_.image);
  }

  MadeImage Make() {
    AdjustedCsmModel adjusted;
    adjusted.time_shift_s = antenna_.time_bias_s();
    adjusted.states = States();
    adjusted.ground_range = Polynomials();
    adjusted.covariance = Covariance();
    adjusted.reference_m = ReferencePoint();
    CheckInterpolation(adjusted.states);
    CheckPolynomials(adjusted.ground_range);
    ListUncarried();
    return {CsmStateText(model_, adjusted), std::move(notes_)};
  }

 private:
  [[nodiscard]] double PathTime_s(double ephemeris_s) const { return ephemeris_s - epoch_s_; }
  // One of `count` times evenly over the image, at which its states are read.
  [[nodiscard]] double StateTime_s(int k, int count) const {
    const double first_s = model_.image.first_line_s;
    return antenna_.time_bias_s() + first_s + (model_.end_s - first_s) * k / (count - 1);
  }

  [[nodiscard]] std::vector<StateVector> States() const {
    std::vector<StateVector> states;
    for (std::size_t k = 0; k < model_.times.count; ++k) {
      const Motion motion = antenna_.MotionAt(PathTime_s(model_.times.At(k)));
      states.push_back(
          {model_.times.At(k), motion.position_m, ConeVelocity(antenna_, result_.frame, motion)});
    }
    return states;
  }

  // R = (R(g) - b_r) / (1 + kappa) is the distance of the antenna.
  [[nodiscard]] double Distance_m(double range_m) const {
    return (range_m - antenna_.ValueOf(ParameterKind::kRangeBias)) /
           (1.0 + antenna_.ValueOf(ParameterKind::kRangeScale));
  }
  [[nodiscard]] std::vector<GroundRangePolynomial> Polynomials() const {
    const RadarImage& image = model_.image;
    std::vector<GroundRangePolynomial> polynomials =
        reading_ == RangePolynomialTimes::kGiven
            ? ForUsgscsm(image.ground_range, image.first_line_s, model_.end_s)
            : image.ground_range;
    for (GroundRangePolynomial& polynomial : polynomials) {
      const double zero_m = Distance_m(polynomial.coefficients[0]);
      for (double& c : polynomial.coefficients) {
        c /= 1.0 + antenna_.ValueOf(ParameterKind::kRangeScale);
      }
      polynomial.coefficients[0] = zero_m;
    }
    return polynomials;
  }

  // Covariance of the antenna over the image: the parameters of USGSCSM move all positions and all
  // velocities alike, so the fit is the mean over the times.
  Eigen::Matrix<double, 6, 6> Covariance() {
    Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Identity();
    if (!antenna_.HasCovariance()) {
      notes_.not_carried.emplace_back(
          "m_covariance is the unit matrix that USGSCSM begins with: the result has no covariance");
      return covariance;
    }
    if (antenna_.parameters().empty()) return Eigen::Matrix<double, 6, 6>::Zero();
    std::vector<FitTime> times;
    constexpr int kTimes = 65;
    for (int k = 0; k < kTimes; ++k) {
      times.push_back({Eigen::MatrixXd::Identity(6, 6),
                       antenna_.InfluenceAt(PathTime_s(StateTime_s(k, kTimes)),
                                            AdjustedAntenna::Direction::kOfCone)});
    }
    const Eigen::MatrixXd fit = FitParameters(times);
    const double rest_m = UnfittedSigma_m(times, 3, fit, antenna_.covariance());
    if (rest_m > kReported_m) {
      notes_.not_carried.push_back(fmt::format(
          "m_covariance holds what is common to all positions; that they err by up to {:.3g} m (1 "
          "sigma) about it",
          rest_m));
    }
    covariance = fit * antenna_.covariance() * fit.transpose();
    return 0.5 * (covariance + covariance.transpose());
  }

  [[nodiscard]] FixedPathLook MiddleLook() const {
    const Motion motion = antenna_.MotionAt(MiddleTime_s());
    FixedPathLook observation;
    observation.antenna_m = motion.position_m;
    observation.velocity_mps = ConeVelocity(antenna_, result_.frame, motion);
    observation.acceleration_mps2 = motion.acceleration_mps2;
    observation.range_m = Distance_m(MiddleRange_m());
    observation.side = static_cast<int>(antenna_.pass().side);
    return observation;
  }
  [[nodiscard]] double MiddleTime_s() const {
    const double line = 0.5 * static_cast<double>(model_.image.lines - 1);
    return antenna_.time_bias_s() +
           PathTime_s(model_.image.first_line_s + line * model_.image.line_interval_s);
  }
  [[nodiscard]] double MiddleRange_m() const {
    if (image_pass_.middle) return image_pass_.middle->range_m;
    throw InputError(FilePlace{model_.image.file, 0, "range polynomials"},
                     "give no slant range in the middle of the image");
  }
  // Zeros, which USGSCSM takes for not given, where the middle of the image is not on the ground.
  [[nodiscard]] Eigen::Vector3d ReferencePoint() const {
    const Intersection place = IntersectWithHeight(MiddleLook(), result_.frame, 0.0);
    if (place.outcome != IntersectionOutcome::kDetermined) return Eigen::Vector3d::Zero();
    return place.position_m;
  }

  // Between its states USGSCSM takes Lagrange's polynomial of eight.
  void CheckInterpolation(const std::vector<StateVector>& states) {
    std::vector<std::vector<double>> rows;
    for (const StateVector& state : states) {
      rows.emplace_back(state.position_m.data(), state.position_m.data() + 3);
    }
    double largest_m = 0.0;
    constexpr int kTimes = 1001;
    for (int k = 0; k < kTimes; ++k) {
      const double ephemeris_s = StateTime_s(k, kTimes);
      const double place = (ephemeris_s - model_.times.first_s) / model_.times.step_s;
      const std::vector<double> read = AsUsgscsmInterpolates(rows, place);
      const Eigen::Vector3d& true_m = antenna_.MotionAt(PathTime_s(ephemeris_s)).position_m;
      largest_m = std::max(largest_m, (Eigen::Vector3d(read.data()) - true_m).norm());
    }
    if (largest_m > kReported_m) {
      notes_.not_carried.push_back(
          fmt::format("between its states, {:.3g} s apart, the path is up to {:.3g} m from that of "
                      "the result",
                      model_.times.step_s,
                      largest_m));
    }
  }

  void CheckPolynomials(const std::vector<GroundRangePolynomial>& written) {
    if (reading_ != RangePolynomialTimes::kGiven || written.size() < 2) return;
    std::vector<std::vector<double>> rows;
    for (const GroundRangePolynomial& polynomial : written) rows.push_back(polynomial.coefficients);
    const double step_s =
        (written.back().time_s - written.front().time_s) / static_cast<double>(written.size());
    const RadarImage& image = model_.image;
    const double far_px = static_cast<double>(image.samples - 1);
    const double far_m = far_px * image.sample_spacing_m;
    const double offset_s = image_pass_.pass.image->first_line_s - image.first_line_s;
    double largest_m = 0.0;
    constexpr int kTimes = 1001;
    for (int k = 0; k < kTimes; ++k) {
      const double line = static_cast<double>(image.lines - 1) * k / (kTimes - 1);
      const auto given = RadarFromImage(*image_pass_.pass.image, {line, far_px});
      if (!given) continue;
      const double ephemeris_s = given->time_s - offset_s;
      const std::vector<double> c =
          AsUsgscsmInterpolates(rows, (ephemeris_s - written.front().time_s) / step_s);
      const double read_m = c[0] + far_m * (c[1] + far_m * (c[2] + far_m * c[3]));
      largest_m = std::max(largest_m, std::abs(read_m - Distance_m(given->range_m)));
    }
    if (largest_m > kReported_m) {
      notes_.not_carried.push_back(fmt::format(
          "between the range polynomials slant ranges are read up to {:.3g} m apart", largest_m));
    }
  }

  void ListUncarried() {
    const FixedPathLook middle = MiddleLook();
    for (std::size_t k = 0; k < antenna_.parameters().size(); ++k) {
      const double value = antenna_.value(k), sigma = antenna_.sigma(k);
      switch (antenna_.parameter(k).kind) {
        case ParameterKind::kSquintBias:
          List(k,
               fmt::format("{:.3g} m along the track in the middle of the image",
                           middle.range_m * std::sin(value)));
          break;
        case ParameterKind::kZenithDelay:
          List(k,
               fmt::format("{:.3g} m of slant range in the middle of the image",
                           value * DelaysPerZenith(middle)));
          break;
        case ParameterKind::kRangeBias:
          if (sigma > 0.0) ListSigma(k, sigma);
          break;
        case ParameterKind::kRangeScale:
          if (sigma > 0.0) ListSigma(k, sigma * middle.range_m);
          break;
        default:
          break;
      }
    }
    if (model_.sun_position_m.empty()) {
      notes_.not_carried.emplace_back("the place of the Sun: " + model_.image.file +
                                      " does not give it, so USGSCSM has no illumination");
    }
  }
  void List(std::size_t k, const std::string& size) {
    notes_.not_carried.push_back(antenna_.parameter(k).name + ": " + size);
  }
  void ListSigma(std::size_t k, double sigma_m) {
    notes_.not_carried.push_back(
        fmt::format("the standard deviation of {}, {:.3g} m of slant range",
                    antenna_.parameter(k).name,
                    sigma_m));
  }
  // One over the cosine of the incidence on the sphere of the ground below.
  [[nodiscard]] double DelaysPerZenith(const FixedPathLook& observation) const {
    const double ground_m = result_.frame.ellipsoid().a_m;
    const double cosine = (observation.antenna_m.squaredNorm() - ground_m * ground_m -
                           observation.range_m * observation.range_m) /
                          (2.0 * ground_m * observation.range_m);
    return 1.0 / cosine;
  }

  const files::ResultFile& result_;
  CsmModel model_;
  double epoch_s_;
  AdjustedAntenna antenna_;
  ImagePass image_pass_;
  RangePolynomialTimes reading_;
  ImageNotes notes_;
};

}  // namespace

void WriteCsmStates(const std::filesystem::path& folder,
                    const ExportView& view,
                    ExportReport* report) {
  const auto make = [&view](const PassImage& image) {
    return StateMaker(view.result, image, view.options.range_polynomial).Make();
  };
  WriteImageFiles(folder, view, ".adjusted_state.json", make, report);
}

}  // namespace sarblock
