// SPDX-License-Identifier: Apache-2.0
#include "look_reduction.h"

#include "sarblock/core/error.h"
#include "sarblock/geometry/look_equations.h"
#include "sarblock/geometry/predict_look.h"
#include "sarblock/reduction/reduction.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>

#include "core/text.h"
#include "core/threads.h"
#include "core/utc.h"
#include "frames.h"
#include "reduction.h"

namespace sarblock {
namespace {

constexpr std::size_t kLooksPerPiece = 16384;
constexpr double kSecondsPerYear = 365.25 * 86400.0;

std::size_t IndexOf(ReductionSource source) { return static_cast<std::size_t>(source); }

const char* NameOf(ReductionSource source) {
  constexpr std::array<const char*, kReductionSources> kNames{
      "given", "troposphere", "ionosphere", "tide", "motion", "constant"};
  return kNames[IndexOf(source)];
}

double HeightOf(const Frame& frame, const Eigen::Vector3d& p_m) {
  return frame.kind() == FrameKind::kLocal ? p_m.z() : frame.GeodeticFromFrame(p_m).h_m;
}

/// Key and problem.
using KeyProblem = std::pair<std::string, std::string>;

std::optional<KeyProblem> OutOfBounds(const ReductionModels& models) {
  constexpr double kLargest_m = 10e3, kLargest_s = 1.0;
  const auto constant = [](const char* key, double value, double largest) {
    return std::abs(value) <= largest
               ? std::optional<KeyProblem>()
               : KeyProblem{key,
                            "must be between -" + NumberText(largest) + " and " +
                                NumberText(largest) + ", got " + NumberText(value)};
  };
  if (auto problem = constant("reduction.range_m", models.range_m, kLargest_m)) return problem;
  if (auto problem = constant("reduction.time_s", models.time_s, kLargest_s)) return problem;
  const char* model = "";
  try {
    if (models.troposphere == TroposphereModel::kWeather) {
      model = "reduction.troposphere.";
      Validate(models.weather);
    }
    if (models.ionosphere) {
      model = "reduction.ionosphere.";
      Validate(*models.ionosphere);
    }
  } catch (const InputError& error) {
    return KeyProblem{model + error.place().field, error.problem()};
  }
  return std::nullopt;
}

/// Whether points move between the epoch of their positions and the dates of the images.
bool Moves(const Block& block) {
  return !std::isnan(block.epoch_year) &&
         std::any_of(block.points.known.begin(),
                     block.points.known.end(),
                     [](const KnownPosition& known) { return !known.velocity_mpy.isZero(0.0); });
}

std::optional<KeyProblem> Unusable(const Block& block,
                                   const Pass& pass,
                                   const ReductionModels& models) {
  if (auto out = OutOfBounds(models)) return out;
  const Frame& frame = block.frame;
  const bool other = frame.kind() == FrameKind::kGeocentric && !IsEarth(frame);
  const std::string body = "is a model of the Earth, the frame is that of another body (" +
                           frame.ellipsoid().name + "); \"none\" is allowed";
  if (models.troposphere != TroposphereModel::kNone && other)
    return KeyProblem{"reduction.troposphere", body};
  if (models.ionosphere) {
    constexpr double kIonosphere_m = 60e3;
    if (other) {
      return KeyProblem{"reduction.ionosphere",
                        "is that of the Earth, the frame is that of another body (" +
                            frame.ellipsoid().name + "); leave it out"};
    }
    if (std::isnan(pass.wavelength_m)) {
      return KeyProblem{"reduction.ionosphere", "needs wavelength_m of pass " + Quoted(pass.id)};
    }
    if (HeightOf(frame, pass.path.states().front().position_m) < kIonosphere_m) {
      return KeyProblem{"reduction.ionosphere",
                        "lies above the antenna of pass " + Quoted(pass.id) +
                            ", which is lower than 60 km; leave it out"};
    }
  }
  if (models.solid_tide) {
    if (other) return KeyProblem{"reduction.tide", body};
    if (frame.kind() == FrameKind::kLocal) {
      return KeyProblem{"reduction.tide",
                        "needs a geocentric frame: the place on the Earth is not known"};
    }
  }
  if ((models.solid_tide || Moves(block)) && !ParseUtc(pass.epoch_utc)) {
    return KeyProblem{
        "epoch_utc",
        std::string(models.solid_tide ? "tides need" : "the motion of known points needs") +
            " the date of pass " + Quoted(pass.id) + "; " + Quoted(pass.epoch_utc) +
            " is no UTC time, 2022-10-16T01:50:44Z is one"};
  }
  if (models.solid_tide) {
    try {
      static_cast<void>(TidalBodiesAt(ParseUtc(pass.epoch_utc).value()));
    } catch (const InputError& error) {
      return KeyProblem{"epoch_utc", "tides need the date: " + error.problem()};
    }
  }
  return std::nullopt;
}

}  // namespace

double SlantFactor(double cos_zenith) {
  return 1.001 / std::sqrt(0.002001 + cos_zenith * cos_zenith);
}

double LookReduction::Range_m() const {
  return std::accumulate(range_m.begin(), range_m.end(), 0.0);
}

double LookReduction::Time_s() const { return std::accumulate(time_s.begin(), time_s.end(), 0.0); }

std::optional<ReductionProblem> FindProblem(const Block& block,
                                            const std::vector<ReductionModels>& models) {
  for (std::size_t pass = 0; pass < block.passes.size(); ++pass) {
    if (auto problem = Unusable(block, block.passes[pass], models[pass])) {
      return ReductionProblem{pass, std::move(problem->first), std::move(problem->second)};
    }
  }
  return std::nullopt;
}

std::vector<ReductionModels> ModelsOf(const Block& block) {
  std::vector<ReductionModels> models;
  models.reserve(block.passes.size());
  for (const Pass& pass : block.passes) models.push_back(pass.reduction);
  return models;
}

struct ReductionOfLooks::PassModel {
  ReductionModels models;
  /// Sun and Moon at even times: the tide changes by 0.01 mm a second.
  std::vector<TidalBodies> bodies;
  double bodies_start_s = 0.0;
  double since_epoch_year = kNotGiven;  ///< time 0 of the pass after the epoch of the positions
};

namespace {

constexpr double kBetweenBodies_s = 20.0;

bool IsAnything(const ReductionModels& models) { return models != ReductionModels{}; }

}  // namespace

ReductionOfLooks::ReductionOfLooks(const Block& block, std::vector<ReductionModels> models)
    : block_(block) {
  if (const auto problem = FindProblem(block, models)) {
    throw InputError("passes[" + std::to_string(problem->pass) + "]." + problem->key,
                     problem->problem);
  }
  any_ = Moves(block) || std::any_of(models.begin(), models.end(), IsAnything);
  for (std::size_t i = 0; i < models.size(); ++i) {
    const Pass& pass = block.passes[i];
    PassModel& own = passes_.emplace_back();
    own.models = models[i];
    const std::optional<UtcTime> epoch = ParseUtc(pass.epoch_utc);
    if (epoch) own.since_epoch_year = JulianYear(*epoch) - block.epoch_year;
    if (!own.models.solid_tide) continue;
    own.bodies_start_s = pass.path.start_s();
    const auto count =
        1 + static_cast<std::size_t>((pass.path.end_s() - own.bodies_start_s) / kBetweenBodies_s);
    for (std::size_t k = 0; k < count; ++k) {
      const double time_s = own.bodies_start_s + (static_cast<double>(k) + 0.5) * kBetweenBodies_s;
      own.bodies.push_back(TidalBodiesAt(AddSeconds(*epoch, time_s)));
    }
  }
}

ReductionOfLooks::~ReductionOfLooks() = default;
ReductionOfLooks::ReductionOfLooks(ReductionOfLooks&&) noexcept = default;

bool ReductionOfLooks::any() const { return any_; }

LookReduction ReductionOfLooks::Of(std::uint32_t pass,
                                   double time_s,
                                   const Cone& cone,
                                   const Eigen::Vector3d& p_m,
                                   const Eigen::Vector3d& velocity_mpy) const {
  LookReduction out;
  const PassModel& own = passes_[pass];
  const ReductionModels& models = own.models;
  out.range_m[IndexOf(ReductionSource::kConstant)] = models.range_m;
  out.time_s[IndexOf(ReductionSource::kConstant)] = models.time_s;
  const std::optional<Motion> antenna =
      p_m.allFinite() ? block_.passes[pass].path.At(time_s) : std::nullopt;
  if (!antenna) return out;
  const Frame& frame = block_.frame;
  const Eigen::Vector3d sight_m = antenna->position_m - p_m;
  if (models.troposphere != TroposphereModel::kNone || models.ionosphere) {
    const Eigen::Vector3d up = frame.UpAt(p_m);
    const double cos_zenith = up.dot(sight_m) / sight_m.norm();
    const double latitude_rad =
        frame.kind() == FrameKind::kLocal ? std::numbers::pi / 4.0 : std::asin(up.z());
    constexpr double kSpace_m = 200e3;  // nothing is above it: 1e-12 m
    const bool in_space = up.dot(sight_m) > kSpace_m;
    const auto zenith_m = [&](double height_m) {
      return models.troposphere == TroposphereModel::kStandard
                 ? ZenithDelay_m(height_m)
                 : ZenithDelay_m(models.weather, latitude_rad, height_m);
    };
    if (models.troposphere != TroposphereModel::kNone) {
      out.range_m[IndexOf(ReductionSource::kTroposphere)] =
          (zenith_m(HeightOf(frame, p_m)) -
           (in_space ? 0.0 : zenith_m(HeightOf(frame, antenna->position_m)))) *
          SlantFactor(cos_zenith);
    }
    if (models.ionosphere) {
      out.range_m[IndexOf(ReductionSource::kIonosphere)] =
          IonosphericDelay_m(*models.ionosphere,
                             block_.passes[pass].wavelength_m,
                             std::acos(std::clamp(cos_zenith, 0.0, 1.0)));
    }
  }
  const bool moves = !velocity_mpy.isZero(0.0) && !std::isnan(own.since_epoch_year);
  if (!models.solid_tide && !moves) return out;
  LookGeometry look{.line_of_sight_m = -sight_m, .motion = *antenna, .cone = cone};
  LookPrediction seen;
  if (!PredictLook(look, &seen)) return out;
  const auto displace = [&](ReductionSource source, const Eigen::Vector3d& by_m) {
    out.range_m[IndexOf(source)] = seen.d_point.row(0).dot(by_m);
    out.time_s[IndexOf(source)] = seen.d_point.row(1).dot(by_m);
  };
  if (models.solid_tide) {
    const auto k =
        static_cast<std::size_t>(std::max(0.0, (time_s - own.bodies_start_s) / kBetweenBodies_s));
    const TidalBodies& bodies = own.bodies[std::min(k, own.bodies.size() - 1)];
    displace(ReductionSource::kTide, SolidEarthTide_m(bodies, p_m));
  }
  if (moves) {
    const double years = own.since_epoch_year + time_s / kSecondsPerYear;
    displace(ReductionSource::kMotion, years * velocity_mpy);
  }
  return out;
}

namespace {

/// Calls work(piece, look, point) for all looks, pieces side by side.
template <typename Work>
void ForLooks(const Looks& looks, const Work& work) {
  ParallelForChunks(
      looks.size(), kLooksPerPiece, [&](std::size_t piece, std::size_t begin, std::size_t end) {
        std::size_t point = looks.PointOf(begin);
        for (std::size_t look = begin; look < end; ++look) {
          while (looks.offsets[point + 1] <= look) ++point;
          work(piece, look, point);
        }
      });
}

std::size_t PiecesOf(const Looks& looks) {
  return (looks.size() + kLooksPerPiece - 1) / kLooksPerPiece;
}

}  // namespace

ReducedBlock::ReducedBlock(const Block& block) : given_(block), models_(block, ModelsOf(block)) {
  position_m_.assign(block.points.size(), Eigen::Vector3d::Constant(kNotGiven));
  if (!models_.any()) return;
  reduced_ = block;
  for (Pass& pass : reduced_->passes) pass.reduction = {};
  for (KnownPosition& known : reduced_->points.known) known.velocity_mpy.setZero();
  Looks& now = reduced_->looks;
  now.range_delay_m.resize(now.size());
  now.time_shift_s.resize(now.size());
  ForLooks(now, [&](std::size_t, std::size_t look, std::size_t point) {
    const LookReduction constants = Of(look, point, position_m_[point]);
    now.range_delay_m[look] = constants.Range_m();
    now.time_shift_s[look] = constants.Time_s();
  });
  TakeOff();
}

LookReduction ReducedBlock::Of(std::size_t look,
                               std::size_t point,
                               const Eigen::Vector3d& p_m) const {
  const Looks& looks = given_.looks;
  const KnownPosition* known = given_.points.FindKnown(static_cast<std::uint32_t>(point));
  const Eigen::Vector3d velocity_mpy =
      known == nullptr ? Eigen::Vector3d::Zero() : known->velocity_mpy;
  LookReduction out =
      models_.Of(looks.pass[look], looks.time_s[look], given_.ConeOf(look), p_m, velocity_mpy);
  constexpr std::size_t kGiven = 0;
  if (!looks.range_delay_m.empty()) out.range_m[kGiven] = looks.range_delay_m[look];
  if (!looks.time_shift_s.empty()) out.time_s[kGiven] = looks.time_shift_s[look];
  return out;
}

double ReducedBlock::ReduceAt(const std::vector<Eigen::Vector3d>& position_m, double settled_m) {
  if (!reduced_) return 0.0;
  Looks& now = reduced_->looks;
  std::vector<double> range_delay_m = now.range_delay_m, time_shift_s = now.time_shift_s;
  std::vector<double> changes_m(PiecesOf(now), 0.0);
  ForLooks(now, [&](std::size_t piece, std::size_t look, std::size_t point) {
    if (!position_m[point].allFinite()) return;
    const LookReduction at = Of(look, point, position_m[point]);
    range_delay_m[look] = at.Range_m();
    time_shift_s[look] = at.Time_s();
    if (now.rejected(look)) return;
    const double speed_mps =
        given_.passes[now.pass[look]].path.states().front().velocity_mps.norm();
    changes_m[piece] =
        std::max({changes_m[piece],
                  std::abs(range_delay_m[look] - now.range_delay_m[look]),
                  speed_mps * std::abs(time_shift_s[look] - now.time_shift_s[look])});
  });
  const double largest_m =
      changes_m.empty() ? 0.0 : *std::max_element(changes_m.begin(), changes_m.end());
  if (!(largest_m > settled_m)) return largest_m;
  now.range_delay_m = std::move(range_delay_m);
  now.time_shift_s = std::move(time_shift_s);
  TakeOff();
  for (std::size_t point = 0; point < position_m.size(); ++point) {
    if (position_m[point].allFinite()) position_m_[point] = position_m[point];
  }
  return largest_m;
}

void ReducedBlock::TakeOff() {
  Looks& now = reduced_->looks;
  ForLooks(now, [&](std::size_t, std::size_t look, std::size_t) {
    const RadarCoordinates measured = given_.Measured(look);
    now.range_m[look] = measured.range_m - now.range_delay_m[look];
    now.time_s[look] = measured.time_s - now.time_shift_s[look];
  });
}

namespace {

/// Of the looks of one pass.
struct Spread {
  double sum = 0.0, count = 0.0;
  double least = std::numeric_limits<double>::infinity();
  double largest = -std::numeric_limits<double>::infinity();

  void Add(double value) {
    sum += value;
    count += 1.0;
    least = std::min(least, value);
    largest = std::max(largest, value);
  }
  void Add(const Spread& other) {
    sum += other.sum;
    count += other.count;
    least = std::min(least, other.least);
    largest = std::max(largest, other.largest);
  }
  [[nodiscard]] bool IsNothing() const { return count == 0.0 || (least == 0.0 && largest == 0.0); }
};

}  // namespace

Reductions ReducedBlock::Report() const {
  const Looks& looks = block().looks;
  Reductions out;
  const auto used = [](const std::vector<double>& column) {
    return std::any_of(column.begin(), column.end(), [](double value) { return value != 0.0; });
  };
  if (used(looks.range_delay_m)) out.range_m = looks.range_delay_m;
  if (used(looks.time_shift_s)) out.time_s = looks.time_shift_s;
  if (out.range_m.empty() && out.time_s.empty()) return out;
  using OfPass = std::array<std::array<Spread, kReductionSources>, 2>;
  // Few pieces: each has the sums of all passes.
  constexpr std::size_t kMostPieces = 32;
  const std::size_t points = given_.points.size();
  const std::size_t points_per_piece = points / kMostPieces + 1;
  std::vector<std::vector<OfPass>> pieces(points / points_per_piece + 1,
                                          std::vector<OfPass>(given_.passes.size()));
  ParallelForChunks(
      points, points_per_piece, [&](std::size_t piece, std::size_t begin, std::size_t end) {
        for (std::size_t i = looks.offsets[begin], point = begin; i < looks.offsets[end]; ++i) {
          while (looks.offsets[point + 1] <= i) ++point;
          if (looks.rejected(i) || std::isnan(looks.range_m[i])) continue;
          const LookReduction at = Of(i, point, position_m_[point]);
          OfPass& own = pieces[piece][looks.pass[i]];
          for (std::size_t k = 0; k < kReductionSources; ++k) {
            own[0][k].Add(at.range_m[k]);
            own[1][k].Add(at.time_s[k]);
          }
        }
      });
  std::vector<OfPass> passes(given_.passes.size());
  for (const std::vector<OfPass>& piece : pieces) {
    for (std::size_t pass = 0; pass < passes.size(); ++pass) {
      for (std::size_t axis = 0; axis < 2; ++axis) {
        for (std::size_t k = 0; k < kReductionSources; ++k) {
          passes[pass][axis][k].Add(piece[pass][axis][k]);
        }
      }
    }
  }
  for (std::size_t pass = 0; pass < passes.size(); ++pass) {
    for (std::size_t k = 0; k < kReductionSources; ++k) {
      for (std::size_t axis = 0; axis < 2; ++axis) {
        const Spread& spread = passes[pass][axis][k];
        if (spread.IsNothing()) continue;
        out.terms.push_back({static_cast<std::uint32_t>(pass),
                             NameOf(static_cast<ReductionSource>(k)),
                             axis == 0 ? "m" : "s",
                             spread.sum / spread.count,
                             spread.least,
                             spread.largest});
      }
    }
  }
  return out;
}

}  // namespace sarblock
