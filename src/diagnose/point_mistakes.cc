// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "mistake.h"
#include "mistakes.h"
#include "sample.h"

namespace sarblock {
namespace {

/// Known points by role or id.
struct PointSelection {
  std::optional<PointRole> role;
  std::string point;  ///< empty: all of the role

  [[nodiscard]] std::string Words() const {
    if (!point.empty()) return "of point " + point;
    if (!role) return "of all known points";
    return *role == PointRole::kControl ? "of the control points" : "of the check points";
  }
  template <typename Edit>
  void Apply(Block* block, const Edit& edit) const {
    Points& points = block->points;
    for (const KnownPosition& known : points.known) {
      if (role && points.role[known.point] != *role) continue;
      if (!point.empty() && points.ids[known.point] != point) continue;
      if (points.given_m[known.point].allFinite()) edit(&points.given_m[known.point]);
    }
  }
};

/// From the position that was read to the one that was meant.
using Meant = std::function<Eigen::Vector3d(const Frame&, const Eigen::Vector3d&)>;

Hypothesis Replaced(const PointSelection& selection,
                    std::string cause,
                    Meant meant,
                    std::string says,
                    std::string change) {
  Hypothesis out;
  out.kind = MistakeKind::kControl;
  out.cause = std::move(cause);
  if (!selection.point.empty()) out.points = {selection.point};
  out.parameters = 0;
  out.undo = [selection, meant = std::move(meant)](Block* block, double) {
    selection.Apply(block, [&](Eigen::Vector3d* p_m) { *p_m = meant(block->frame, *p_m); });
  };
  out.says = [selection, says = std::move(says)](const Size&) {
    return "the coordinates " + selection.Words() + " " + says;
  };
  out.change = [selection, change = std::move(change)](const Size&) {
    return "points.csv: " + change + " " + selection.Words();
  };
  return out;
}

/// Through geodetic coordinates as they were read.
template <typename Edit>
Meant Geodetically(Edit edit) {
  return [edit](const Frame& frame, const Eigen::Vector3d& p_m) {
    return frame.FrameFromGeodetic(edit(frame.GeodeticFromFrame(p_m)));
  };
}

Hypothesis Exchanged(const PointSelection& selection) {
  return Replaced(selection,
                  "control.lat_lon",
                  Geodetically([](Geodetic at) {
                    std::swap(at.lat_rad, at.lon_rad);
                    return at;
                  }),
                  "have latitude and longitude exchanged",
                  "exchange lat_deg and lon_deg");
}

struct NamedBody {
  const char* name;
  double a_m, flattening;
};
/// Ellipsoids and radii that coordinates are mistaken for.
constexpr std::array kBodies{
    NamedBody{"WGS84", 6378137.0, 1.0 / 298.257223563},
    NamedBody{"Bessel 1841", 6377397.155, 1.0 / 299.1528128},
    NamedBody{"Clarke 1866", 6378206.4, 1.0 / 294.978698214},
    NamedBody{"International 1924", 6378388.0, 1.0 / 297.0},
    NamedBody{"Krassovsky 1940", 6378245.0, 1.0 / 298.3},
    NamedBody{"a sphere of 6371 km", 6371000.0, 0.0},
    NamedBody{"a sphere of 6378.137 km", 6378137.0, 0.0},
    NamedBody{"the Moon's sphere of 1737.4 km", 1737400.0, 0.0},
    NamedBody{"a lunar sphere of 1738 km", 1738000.0, 0.0},
    NamedBody{"the Mars ellipsoid of IAU 2000", 3396190.0, 1.0 / 169.894447223612},
    NamedBody{"a sphere of 3396.19 km", 3396190.0, 0.0},
    NamedBody{"a sphere of 3389.5 km", 3389500.0, 0.0},
    NamedBody{"the Venus sphere of 6051.8 km", 6051800.0, 0.0},
    NamedBody{"a Venus sphere of 6051 km", 6051000.0, 0.0},
    NamedBody{"a Venus sphere of 6052 km", 6052000.0, 0.0}};

/// DD.MMmm, degrees and minutes, read as degrees with decimals.
double FromMinutes(double read_rad) {
  const double read_deg = read_rad / kRadPerDeg;
  const double degrees = std::trunc(read_deg);
  return kRadPerDeg * (degrees + 100.0 * (read_deg - degrees) / 60.0);
}

void AddGeodetic(const PointSelection& selection, const Frame& frame, Hypotheses* out) {
  out->push_back(Exchanged(selection));
  out->push_back(
      Replaced(selection,
               "control.radians",
               Geodetically([](Geodetic at) {
                 return Geodetic{at.lat_rad / kRadPerDeg, at.lon_rad / kRadPerDeg, at.h_m};
               }),
               "are radians where degrees are read",
               "lat_deg and lon_deg in degrees"));
  out->push_back(Replaced(selection,
                          "control.longitude_sign",
                          Geodetically([](Geodetic at) {
                            return Geodetic{at.lat_rad, -at.lon_rad, at.h_m};
                          }),
                          "have longitudes of the wrong sign",
                          "lon_deg positive east"));
  out->push_back(Replaced(selection,
                          "control.latitude_sign",
                          Geodetically([](Geodetic at) {
                            return Geodetic{-at.lat_rad, at.lon_rad, at.h_m};
                          }),
                          "have latitudes of the wrong sign",
                          "lat_deg positive north"));
  out->push_back(Replaced(selection,
                          "control.half_turn",
                          Geodetically([](Geodetic at) {
                            return Geodetic{at.lat_rad, at.lon_rad + std::numbers::pi, at.h_m};
                          }),
                          "have longitudes that are half a turn off",
                          "lon_deg plus or minus 180"));
  out->push_back(
      Replaced(selection,
               "control.minutes",
               Geodetically([](Geodetic at) {
                 return Geodetic{FromMinutes(at.lat_rad), FromMinutes(at.lon_rad), at.h_m};
               }),
               "are degrees and minutes where degrees with decimals are read",
               "lat_deg and lon_deg in degrees with decimals"));
  out->push_back(Replaced(selection,
                          "control.height_km",
                          Geodetically([](Geodetic at) {
                            return Geodetic{at.lat_rad, at.lon_rad, 1e3 * at.h_m};
                          }),
                          "have heights in kilometres",
                          "h_m in metres"));
  const Ellipsoid own = frame.ellipsoid();
  if (own.flattening > 0.0) {
    const double ratio = (1.0 - own.flattening) * (1.0 - own.flattening);
    out->push_back(Replaced(selection,
                            "control.planetocentric",
                            Geodetically([ratio](Geodetic at) {
                              at.lat_rad = std::atan(std::tan(at.lat_rad) / ratio);
                              return at;
                            }),
                            "have planetocentric latitudes",
                            "planetographic (geodetic) lat_deg"));
  }
  for (const NamedBody& body : kBodies) {
    if (body.a_m == own.a_m && std::abs(body.flattening - own.flattening) < 1e-9) continue;
    if (std::abs(body.a_m / own.a_m - 1.0) > 0.01) continue;
    const Frame other = Frame::Geocentric({body.name, body.a_m, body.flattening});
    out->push_back(Replaced(
        selection,
        "control.ellipsoid",
        [other](const Frame& given, const Eigen::Vector3d& p_m) {
          return other.FrameFromGeodetic(given.GeodeticFromFrame(p_m));
        },
        std::string("refer to ") + body.name,
        "coordinates on the ellipsoid of the frame"));
  }
}

/// Heights that were read as `meant` times what they are.
Hypothesis ScaledHeights(const PointSelection& selection,
                         bool geocentric,
                         std::string cause,
                         double meant,
                         std::string says,
                         std::string change) {
  const Meant on_ellipsoid = Geodetically([meant](Geodetic at) {
    return Geodetic{at.lat_rad, at.lon_rad, meant * at.h_m};
  });
  const Meant flat = [meant](const Frame&, const Eigen::Vector3d& p_m) {
    return Eigen::Vector3d(p_m.x(), p_m.y(), meant * p_m.z());
  };
  return Replaced(selection,
                  std::move(cause),
                  geocentric ? on_ellipsoid : flat,
                  std::move(says),
                  std::move(change));
}

void AddHeights(const PointSelection& selection, bool geocentric, Hypotheses* out) {
  constexpr double kFoot_m = 0.3048;
  out->push_back(ScaledHeights(selection,
                               geocentric,
                               "control.height_sign",
                               -1.0,
                               "have heights of the wrong sign",
                               "the other sign of the heights"));
  out->push_back(ScaledHeights(selection,
                               geocentric,
                               "control.feet",
                               kFoot_m,
                               "have heights in feet",
                               "heights in metres, times 0.3048,"));
  for (Hypothesis* hypothesis : {&(*out)[out->size() - 2], &out->back()}) {
    hypothesis->screened = true;  // small against errors of the flights
    hypothesis->local = true;
  }
}

Hypothesis ConstantHeight(const PointSelection& selection, double step_m, const Fit& before) {
  Hypothesis out;
  out.kind = MistakeKind::kControl;
  out.cause = "control.height";
  out.undo = [selection](Block* block, double higher_m) {
    selection.Apply(
        block, [&](Eigen::Vector3d* p_m) { *p_m -= higher_m * block->frame.VerticalAt(*p_m).up; });
  };
  out.free = true;
  out.step = step_m;
  out.unit = "m";
  out.says = [selection](const Size& size) {
    return "the heights " + selection.Words() + " are " +
           SizeOf(std::abs(size.value), size.sigma, "m").text +
           (size.value > 0.0 ? " too large" : " too small") +
           " (heights above the geoid or of another ellipsoid?)";
  };
  out.change = [selection](const Size& size) {
    return "points.csv: heights " + selection.Words() + (size.value > 0.0 ? " minus " : " plus ") +
           Short(std::abs(size.value)) +
           "; check points of the same source as the control cannot see such an error";
  };
  out.screened = true;
  // Differences of unfinished solutions show nothing.
  out.order = before.settled ? Hypothesis::kScored : Hypothesis::kGuessed;
  out.local = true;
  return out;
}

Hypothesis Released(const std::string& point) {
  Hypothesis out;
  out.kind = MistakeKind::kControl;
  out.cause = "control.point";
  out.points = {point};
  out.parameters = 3;
  out.undo = [point](Block* block, double) {
    Points& points = block->points;
    for (const KnownPosition& known : points.known) {
      if (points.ids[known.point] != point) continue;
      points.role[known.point] = PointRole::kTie;
      points.given_m[known.point].setConstant(kNotGiven);
    }
    std::erase_if(points.known,
                  [&](const KnownPosition& known) { return points.ids[known.point] == point; });
  };
  out.says = [point](const Size&) { return "the known position of point " + point + " is wrong"; };
  out.change = [point](const Size&) {
    return "points.csv: the coordinates of " + point + ", or role = tie";
  };
  out.screened = true;
  out.local = true;
  return out;
}

Hypothesis ExchangedPoints(const std::string& a, const std::string& b) {
  Hypothesis out;
  out.kind = MistakeKind::kControl;
  out.cause = "control.exchanged";
  out.points = {a, b};
  out.parameters = 0;
  out.undo = [a, b](Block* block, double) {
    const std::uint32_t i = block->points.ids.Find(a), j = block->points.ids.Find(b);
    if (i == IdTable::kNone || j == IdTable::kNone) return;
    std::swap(block->points.given_m[i], block->points.given_m[j]);
  };
  out.says = [a, b](const Size&) {
    return "points " + a + " and " + b + " have each other's coordinates";
  };
  out.change = [a, b](const Size&) {
    return "points.csv: exchange the coordinates of " + a + " and " + b;
  };
  out.screened = true;
  out.local = true;
  return out;
}

/// Known points that the fit moves most, in their standard deviations, after the suspects.
std::vector<std::uint32_t> DoubtfulKnownPoints(const Facts& facts) {
  constexpr std::size_t kMax = 6;
  const Block& block = facts.sample.block;
  std::vector<std::uint32_t> out;
  for (const std::uint32_t suspect : facts.sample.suspects) {
    if (block.points.FindKnown(suspect) != nullptr && out.size() < kMax) out.push_back(suspect);
  }
  std::vector<std::pair<double, std::uint32_t>> moved;
  for (const KnownPosition& known : block.points.known) {
    if (!facts.before.solved) break;
    const Eigen::Vector3d& given_m = block.points.given_m[known.point];
    const Eigen::Vector3d off_m =
        block.frame.EnuFromFrame(given_m) * (facts.before.state.Position(known.point) - given_m);
    double square = 0.0;
    for (int i = 0; i < 3; ++i) {
      if (known.fixed[static_cast<std::size_t>(i)]) {
        square += off_m[i] * off_m[i] / known.covariance_enu_m2(i, i);
      }
    }
    if (std::isfinite(square)) moved.emplace_back(-square, known.point);
  }
  std::sort(moved.begin(), moved.end());
  for (std::size_t i = 0; i < std::min<std::size_t>(3, moved.size()); ++i) {
    if (std::find(out.begin(), out.end(), moved[i].second) == out.end()) {
      out.push_back(moved[i].second);
    }
  }
  return out;
}

/// The looks of two known points lie nearer to each other's coordinates.
bool MeetExchanged(const Block& block, std::uint32_t a, std::uint32_t b) {
  constexpr double kMuchNearer = 0.3;
  Block part = PartOf(block, {a, b});
  const auto worst_m = [&part] {
    return std::max(ContradictionOf(part, 0), ContradictionOf(part, 1));
  };
  const double before_m = worst_m();
  std::swap(part.points.given_m[0], part.points.given_m[1]);
  return !(worst_m() > kMuchNearer * before_m);
}

}  // namespace

void AddControlMistakes(const Facts& facts, Hypotheses* out) {
  const Block& block = facts.sample.block;
  if (block.points.known.empty()) return;
  bool control = false, check = false;
  double sigma_m = 1.0;
  for (const KnownPosition& known : block.points.known) {
    control = control || block.points.role[known.point] == PointRole::kControl;
    check = check || block.points.role[known.point] == PointRole::kCheck;
    if (known.fixed[2]) sigma_m = std::sqrt(known.covariance_enu_m2(2, 2));
  }
  std::vector<PointSelection> scopes{{std::nullopt, ""}};
  if (control && check)
    scopes = {{std::nullopt, ""}, {PointRole::kControl, ""}, {PointRole::kCheck, ""}};
  const bool geocentric = block.frame.kind() == FrameKind::kGeocentric;
  for (const PointSelection& selection : scopes) {
    out->push_back(ConstantHeight(selection, sigma_m, facts.before));
    out->push_back(Replaced(
        selection,
        "control.km",
        [](const Frame&, const Eigen::Vector3d& p_m) { return Eigen::Vector3d(1e3 * p_m); },
        "are in kilometres",
        "metres in x_m, y_m, z_m"));
    AddHeights(selection, geocentric, out);
    if (geocentric) {
      AddGeodetic(selection, block.frame, out);
    } else {
      out->push_back(Replaced(
          selection,
          "control.xy",
          [](const Frame&, const Eigen::Vector3d& p_m) {
            return Eigen::Vector3d(p_m.y(), p_m.x(), p_m.z());
          },
          "have x and y exchanged",
          "exchange x_m and y_m"));
    }
  }
}

void AddKnownPointMistakes(const Facts& facts, Hypotheses* out) {
  const Block& block = facts.sample.block;
  if (block.points.known.empty()) return;
  const bool geocentric = block.frame.kind() == FrameKind::kGeocentric;
  const std::vector<std::uint32_t> doubtful = DoubtfulKnownPoints(facts);
  if (!facts.may_explain(doubtful)) return;  // then no part of them does
  for (std::size_t i = 0; i < doubtful.size(); ++i) {
    for (std::size_t j = i + 1; j < doubtful.size(); ++j) {
      if (!MeetExchanged(block, doubtful[i], doubtful[j])) continue;
      if (!facts.may_explain({doubtful[i], doubtful[j]})) continue;
      out->push_back(ExchangedPoints(std::string(block.points.ids[doubtful[i]]),
                                     std::string(block.points.ids[doubtful[j]])));
    }
  }
  for (const std::uint32_t point : doubtful) {
    if (!facts.may_explain({point})) continue;
    const std::string id(block.points.ids[point]);
    out->push_back(Released(id));
    if (!geocentric) continue;
    out->push_back(Exchanged({std::nullopt, id}));
    out->back().screened = true;
  }
}

namespace {

enum class Part { kTime, kDoppler, kRange, kBoth };

const char* UnitOf(Part part) {
  return part == Part::kTime      ? "s"
         : part == Part::kDoppler ? "Hz"
         : part == Part::kRange   ? "m"
                                  : "";
}

/// One look: of a point in a pass.
struct LookName {
  std::string pass, point;
  [[nodiscard]] std::string Words() const { return "point " + point + " in pass " + pass; }
  template <typename Edit>
  void Apply(Block* block, const Edit& edit) const {
    const auto p = FindPass(*block, pass);
    const std::uint32_t j = block->points.ids.Find(point);
    if (!p || j == IdTable::kNone) return;
    for (std::size_t i = block->looks.offsets[j]; i < block->looks.offsets[j + 1]; ++i) {
      if (block->looks.pass[i] == *p) edit(i);
    }
  }
};

Hypothesis OneLook(const LookName& look, Part part, double value, double step) {
  Hypothesis out;
  out.kind = part == Part::kTime      ? MistakeKind::kTime
             : part == Part::kDoppler ? MistakeKind::kCone
             : part == Part::kRange   ? MistakeKind::kRange
                                      : MistakeKind::kIds;
  out.cause = part == Part::kTime      ? "time.one"
              : part == Part::kDoppler ? "cone.one"
              : part == Part::kRange   ? "range.one"
                                       : "ids.look";
  out.passes = {look.pass};
  out.points = {look.point};
  out.undo = [look, part](Block* block, double size) {
    look.Apply(block, [&](std::size_t i) {
      if (part == Part::kTime) block->looks.time_s[i] -= size;
      if (part == Part::kDoppler) block->looks.cone[i] -= size;
      if (part == Part::kRange) block->looks.range_m[i] -= size;
      if (part == Part::kBoth) block->looks.flags[i] |= Looks::kRejected;
    });
  };
  out.within_last = part != Part::kBoth;
  out.parameters = part == Part::kBoth ? 0 : 1;  // a look left out takes its equations with it
  out.free = part != Part::kBoth;
  out.value = value;
  out.step = step;
  out.unit = UnitOf(part);
  out.says = [look, part](const Size& size) {
    if (part == Part::kBoth) return "the look of " + look.Words() + " is of something else";
    const bool more = size.value > 0.0;
    const std::string text =
        look.Words() + " is " + SizeOf(std::abs(size.value), size.sigma, UnitOf(part)).text;
    if (part == Part::kTime) return "the time of " + text + (more ? " late" : " early");
    if (part == Part::kDoppler) return "the Doppler of " + text + (more ? " too high" : " too low");
    return "the range of " + text + (more ? " too long" : " too short");
  };
  out.change = [look](const Size&) {
    return "observations.csv: the row of " + look.Words() + ", or rejected = 1 there";
  };
  out.screened = true;
  out.local = true;
  return out;
}

Hypothesis OnePoint(const std::string& point, int looks) {
  Hypothesis out;
  out.kind = MistakeKind::kIds;
  out.cause = "ids.point";
  out.points = {point};
  out.undo = [point](Block* block, double) {
    const std::uint32_t j = block->points.ids.Find(point);
    if (j == IdTable::kNone) return;
    for (std::size_t i = block->looks.offsets[j]; i < block->looks.offsets[j + 1]; ++i) {
      block->looks.flags[i] |= Looks::kRejected;
    }
  };
  out.parameters = 0;
  out.says = [point, looks](const Size&) {
    return "the " + std::to_string(looks) + " looks of point " + point +
           " contradict each other and cannot tell which is wrong";
  };
  out.change = [point](const Size&) {
    return "observations.csv: the rows of " + point + ", or rejected = 1 in them";
  };
  out.screened = true;
  out.local = true;
  return out;
}

/// How late or too high its Doppler and how much too long a look is against the position of the
/// point: the known one, or where its other looks meet on the given paths.
struct LookErrors {
  double late_s = 0.0, higher_hz = 0.0, longer_m = 0.0;
};

LookErrors ErrorsOf(const Block& block, std::uint32_t point, std::size_t look) {
  LookErrors out;
  Eigen::Vector3d p_m = block.points.given_m[point];
  if (block.points.FindKnown(point) == nullptr) {
    Block others = PartOf(block, {point});
    const std::size_t place = look - block.looks.offsets[point];
    others.looks.flags[place] |= Looks::kRejected;
    others.points.given_m[0].setConstant(kNotGiven);
    const Fit fit = SolveSample(others, {}, {.effort = Effort::kQuick}, nullptr);
    if (!fit.solved) return out;
    p_m = fit.state.Position(0);
  }
  const PredictedLook predicted = PredictLook(block, look, p_m);
  if (block.MeasuresDoppler(look)) {
    const Pass& pass = block.passes[block.looks.pass[look]];
    const auto motion = pass.path.At(predicted.time_s);
    if (!motion) return out;
    const Eigen::Vector3d los_m = p_m - motion->position_m;
    const double distance_m = los_m.norm();
    out.higher_hz = block.looks.cone[look] -
                    2.0 * motion->velocity_mps.dot(los_m) / (pass.wavelength_m * distance_m);
    out.longer_m = predicted.range_m - distance_m;
    return out;
  }
  if (std::isnan(predicted.true_time_s)) return out;
  out.late_s = predicted.time_s - predicted.true_time_s;
  out.longer_m = predicted.range_m - predicted.true_range_m;
  return out;
}

/// Points whose residuals are the largest, after the suspects.
std::vector<std::uint32_t> DoubtfulPoints(const Facts& facts, std::size_t most) {
  const Block& block = facts.sample.block;
  std::vector<std::uint32_t> out = facts.sample.suspects;
  std::vector<std::pair<double, std::uint32_t>> sums;
  for (std::uint32_t j = 0; j < block.points.size(); ++j) {
    double sum = 0.0;
    for (std::size_t i = block.looks.offsets[j]; i < block.looks.offsets[j + 1]; ++i) {
      const double square =
          facts.residuals.whitened_errors.row(static_cast<Eigen::Index>(i)).squaredNorm();
      if (std::isfinite(square)) sum += square;
    }
    sums.emplace_back(-sum, j);
  }
  std::sort(sums.begin(), sums.end());
  if (out.size() > most) out.resize(most);
  // To explain the block a point must have a part of v'Pv by itself.
  constexpr double kMinShare = 0.1;
  for (std::size_t k = 0; k < std::min<std::size_t>(2, sums.size()); ++k) {
    if (-sums[k].first < kMinShare * facts.before.square_sum) break;
    if (std::find(out.begin(), out.end(), sums[k].second) == out.end()) {
      out.push_back(sums[k].second);
    }
  }
  return out;
}

}  // namespace

void AddLookMistakes(const Facts& facts, Hypotheses* out) {
  constexpr std::size_t kMaxPoints = 4;
  const Block& block = facts.sample.block;
  const std::vector<std::uint32_t> doubtful = DoubtfulPoints(facts, kMaxPoints);
  if (doubtful.empty() || !facts.may_explain(doubtful)) return;
  for (const std::uint32_t j : doubtful) {
    const std::string point(block.points.ids[j]);
    std::vector<std::size_t> looks;
    for (std::size_t i = block.looks.offsets[j]; i < block.looks.offsets[j + 1]; ++i) {
      if (!block.looks.rejected(i)) looks.push_back(i);
    }
    if (!facts.may_explain({j})) continue;
    const bool known = block.points.FindKnown(j) != nullptr;
    if (!known && looks.size() < 3) {
      if (looks.size() == 2) out->push_back(OnePoint(point, 2));
      continue;
    }
    for (const std::size_t i : looks) {
      const std::uint32_t p = block.looks.pass[i];
      const LookName name{block.passes[p].id, point};
      const LookErrors errors = ErrorsOf(block, j, i);
      const LookSigma sigma = block.SigmaOf(i);
      out->push_back(OneLook(name, Part::kBoth, 0.0, 0.0));
      if (block.MeasuresDoppler(i)) {
        out->push_back(OneLook(name, Part::kDoppler, errors.higher_hz, sigma.azimuth));
      } else {
        const double speed_mps = facts.passes[p].speed_mps;
        const double sigma_s = block.ApproximateAzimuthSigma_m(i, speed_mps) / speed_mps;
        out->push_back(OneLook(name, Part::kTime, errors.late_s, sigma_s));
      }
      out->push_back(OneLook(name, Part::kRange, errors.longer_m, sigma.range_m));
    }
  }
}

namespace {

/// Exchanges what two looks of one pass measured.
void ExchangeValues(std::size_t i, std::size_t j, Looks* looks) {
  std::swap(looks->time_s[i], looks->time_s[j]);
  std::swap(looks->range_m[i], looks->range_m[j]);
  if (!looks->cone.empty()) std::swap(looks->cone[i], looks->cone[j]);
}

/// Looks of a point in a pass.
std::vector<std::size_t> LooksOf(const Block& block, std::uint32_t point, std::uint32_t pass) {
  std::vector<std::size_t> out;
  for (std::size_t i = block.looks.offsets[point]; i < block.looks.offsets[point + 1]; ++i) {
    if (block.looks.pass[i] == pass && !block.looks.rejected(i)) out.push_back(i);
  }
  return out;
}

/// In the first of `passes`; of two, the same as in the other.
Hypothesis ExchangedIn(const std::vector<std::string>& passes,
                       const std::string& a,
                       const std::string& b) {
  const std::string& pass = passes[0];
  Hypothesis out;
  out.kind = MistakeKind::kIds;
  out.cause = "ids.exchanged";
  out.passes = passes;
  out.points = {a, b};
  out.parameters = 0;
  out.undo = [pass, a, b](Block* block, double) {
    const auto p = FindPass(*block, pass);
    const std::uint32_t i = block->points.ids.Find(a), j = block->points.ids.Find(b);
    if (!p || i == IdTable::kNone || j == IdTable::kNone) return;
    const std::vector<std::size_t> of_a = LooksOf(*block, i, *p), of_b = LooksOf(*block, j, *p);
    if (of_a.size() == 1 && of_b.size() == 1) ExchangeValues(of_a[0], of_b[0], &block->looks);
  };
  const std::string where = passes.size() == 1 ? pass : passes[0] + " or in pass " + passes[1];
  out.says = [where, a, b](const Size&) {
    return "points " + a + " and " + b + " are exchanged in pass " + where;
  };
  out.change = [pass, a, b](const Size&) {
    return "observations.csv: exchange the names " + a + " and " + b + " in the rows of " + pass;
  };
  out.screened = true;
  return out;
}

/// The larger contradiction of two points.
double WorstOf(const Block& part, std::uint32_t a, std::uint32_t b) {
  double worst_m = 0.0;
  for (const std::uint32_t point : {a, b}) {
    const double off_m = ContradictionOf(part, point);
    if (!std::isnan(off_m)) worst_m = std::max(worst_m, off_m);
  }
  return worst_m;
}

using RowsOfPoint = std::map<std::string, RowValues, std::less<>>;

Hypothesis Shifted(const std::string& pass, std::shared_ptr<const RowsOfPoint> rows, bool before) {
  Hypothesis out;
  out.kind = MistakeKind::kIds;
  out.cause = "ids.shifted";
  out.parameters = 0;
  out.passes = {pass};
  out.undo = [pass, rows](Block* block, double) {
    const auto p = FindPass(*block, pass);
    if (!p) return;
    Looks& looks = block->looks;
    for (std::uint32_t point = 0; point < block->points.size(); ++point) {
      const auto found = rows->find(block->points.ids[point]);
      if (found == rows->end()) continue;
      for (const std::size_t i : LooksOf(*block, point, *p)) {
        looks.time_s[i] = found->second.time_s;
        looks.range_m[i] = found->second.range_m;
        if (!looks.cone.empty()) looks.cone[i] = found->second.cone;
      }
    }
  };
  const std::string direction = before ? "down" : "up";
  out.says = [pass, direction](const Size&) {
    return "the point ids of pass " + pass + " are shifted " + direction +
           " by one row against its measurements";
  };
  out.change = [pass, direction](const Size&) {
    return "observations.csv: point in the rows of " + pass + ", one row " +
           (direction == "down" ? "up" : "down");
  };
  return out;
}

}  // namespace

void AddExchangedPoints(const Facts& facts, Hypotheses* out) {
  const Block& block = facts.sample.block;
  const std::vector<std::uint32_t>& suspects = facts.sample.suspects;
  std::vector<std::uint32_t> points = suspects;
  std::sort(points.begin(), points.end());
  if (points.size() < 2 || !facts.may_explain(points)) return;
  Block part = PartOf(block, points);
  const auto place = [&](std::uint32_t point) {
    const auto found = std::lower_bound(points.begin(), points.end(), point);
    return static_cast<std::uint32_t>(found - points.begin());
  };
  for (std::size_t i = 0; i < suspects.size(); ++i) {
    for (std::size_t j = i + 1; j < suspects.size(); ++j) {
      const auto [low, high] = std::minmax({place(suspects[i]), place(suspects[j])});
      const double before_m = WorstOf(part, low, high);
      std::vector<std::uint32_t> common;
      for (std::uint32_t p = 0; p < block.passes.size(); ++p) {
        if (LooksOf(part, low, p).size() == 1 && LooksOf(part, high, p).size() == 1) {
          common.push_back(p);
        }
      }
      // Two looks each and no known position: exchanged in one pass or in the other is the same.
      const auto is_tie_of_two = [&](std::uint32_t k) {
        return part.looks.offsets[k + 1] - part.looks.offsets[k] == 2 &&
               part.points.FindKnown(k) == nullptr;
      };
      const bool either = common.size() == 2 && is_tie_of_two(low) && is_tie_of_two(high);
      for (const std::uint32_t p : common) {
        if (either && p != common[0]) break;
        const std::size_t of_low = LooksOf(part, low, p)[0], of_high = LooksOf(part, high, p)[0];
        ExchangeValues(of_low, of_high, &part.looks);
        const double after_m = WorstOf(part, low, high);
        ExchangeValues(of_low, of_high, &part.looks);
        if (!(after_m < 0.3 * before_m)) continue;
        if (!facts.may_explain({points[low], points[high]})) continue;
        std::vector<std::string> passes{block.passes[p].id};
        if (either) passes.push_back(block.passes[common[1]].id);
        out->push_back(ExchangedIn(
            passes, std::string(part.points.ids[low]), std::string(part.points.ids[high])));
      }
    }
  }
}

void AddShiftedIds(const Facts& facts, Hypotheses* out) {
  const Block& block = facts.sample.block;
  for (std::uint32_t p = 0; p < block.passes.size(); ++p) {
    for (std::size_t neighbour = 0; neighbour < 4; ++neighbour) {
      auto rows = std::make_shared<RowsOfPoint>();
      for (std::uint32_t point = 0; point < block.points.size(); ++point) {
        for (const std::size_t i : LooksOf(block, point, p)) {
          (*rows)[std::string(block.points.ids[point])] = facts.sample.neighbours[i][neighbour];
        }
      }
      const bool before = neighbour == Sample::kPointBefore || neighbour == Sample::kTimeBefore;
      out->push_back(Shifted(block.passes[p].id, std::move(rows), before));
      out->back().screened = facts.passes[p].predictions.empty();
    }
  }
}

}  // namespace sarblock
