// SPDX-License-Identifier: Apache-2.0
#include "sarblock/core/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/text.h"
#include "mistakes.h"
#include "model/parameters.h"
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

/// All known points; where there are control and check points, also each of both kinds.
std::vector<PointSelection> ScopesOf(const Block& block) {
  bool control = false, check = false;
  for (const KnownPosition& known : block.points.known) {
    control = control || block.points.role[known.point] == PointRole::kControl;
    check = check || block.points.role[known.point] == PointRole::kCheck;
  }
  if (block.points.known.empty()) return {};
  std::vector<PointSelection> scopes{{std::nullopt, ""}};
  if (control && check) {
    scopes.push_back({PointRole::kControl, ""});
    scopes.push_back({PointRole::kCheck, ""});
  }
  return scopes;
}

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
               "lat_deg and lon_deg times 180/pi, to degrees,"));
  out->push_back(Replaced(selection,
                          "control.longitude_sign",
                          Geodetically([](Geodetic at) {
                            return Geodetic{at.lat_rad, -at.lon_rad, at.h_m};
                          }),
                          "have longitudes of the wrong sign",
                          "the other sign of lon_deg, positive east,"));
  out->push_back(Replaced(selection,
                          "control.latitude_sign",
                          Geodetically([](Geodetic at) {
                            return Geodetic{-at.lat_rad, at.lon_rad, at.h_m};
                          }),
                          "have latitudes of the wrong sign",
                          "the other sign of lat_deg, positive north,"));
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
                          "h_m times 1000, to metres,"));
  const Ellipsoid own = frame.ellipsoid();
  if (own.flattening > 0.0) {
    const double ratio = (1.0 - own.flattening) * (1.0 - own.flattening);
    out->push_back(
        Replaced(selection,
                 "control.planetocentric",
                 Geodetically([ratio](Geodetic at) {
                   at.lat_rad = std::atan(std::tan(at.lat_rad) / ratio);
                   return at;
                 }),
                 "have planetocentric latitudes",
                 "planetographic (geodetic) latitudes, their tangents over (1 - f)^2, in lat_deg"));
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
        "x_m, y_m, z_m of lat_deg, lon_deg and h_m on the ellipsoid of a = " +
            Digits(body.a_m, 10) + " m, f = " + Digits(body.flattening, 12)));
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
  out.change = [selection, step_m](const Size& size) {
    const std::string by =
        (size.value > 0.0 ? "minus " : "plus ") + InFiles(std::abs(size.value), size.sigma);
    // By flights alone the heights of all known points are known no better than the flights
    // themselves.
    if (!selection.role && size.sigma > step_m) {
      return "points.csv: role = tie " + selection.Words() + " until their heights are right; " +
             by + " they fit the flights, within " + InFiles(size.sigma, size.sigma) + " m";
    }
    return "points.csv: heights " + selection.Words() + " " + by +
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

/// The name of the correction that all paths share.
constexpr const char* kShiftGroup = "diagnose.control";

/// With a constant of all paths together, in the axes of the frame.
CorrectionModel WithCommonShift(CorrectionModel model) {
  PositionCorrection shift;
  shift.axes = PositionCorrection::Axes::kFrame;
  model.groups.push_back({kShiftGroup, shift, {}, true});
  return model;
}

/// The control's shift that a solution with that constant found, east, north, up at a known point;
/// NaN where it has none.
Eigen::Vector3d ShiftIn(const Block& block, const CorrectionModel& model, const Fit& fit) {
  Eigen::Vector3d shift_m = Eigen::Vector3d::Constant(kNotGiven);
  const CorrectionModel with = WithCommonShift(model);
  const ParameterLayout layout = MakeParameterLayout(block, with.groups, with.priors);
  if (!fit.solved || fit.state.corrections.size() != layout.size()) return shift_m;
  int axis = 0;
  for (int i = 0; i < layout.size() && axis < 3; ++i) {
    if (layout.parameters[static_cast<std::size_t>(i)].owner != kShiftGroup) continue;
    shift_m[axis++] = fit.state.corrections[i];
  }
  for (const KnownPosition& known : block.points.known) {
    const Eigen::Vector3d& p_m = block.points.given_m[known.point];
    if (p_m.allFinite()) return block.frame.EnuFromFrame(p_m) * shift_m;
  }
  return Eigen::Vector3d::Constant(kNotGiven);
}

}  // namespace

void AddShiftedControl(const Facts& facts, Hypotheses* out) {
  const Block& block = facts.sample.block;
  if (block.points.known.size() < 3 || facts.corrections.groups.empty()) return;
  Hypothesis hypothesis;
  hypothesis.kind = MistakeKind::kControl;
  hypothesis.cause = "control.shift";
  hypothesis.parameters = 3;
  hypothesis.undo = [](Block*, double) {};
  hypothesis.remodel = [](CorrectionModel* model, double) {
    *model = WithCommonShift(std::move(*model));
  };
  hypothesis.says = [](const Size&) {
    return std::string("the coordinates of all known points are shifted by one vector");
  };
  hypothesis.detail = [&block, model = facts.corrections](const Fit& fit) {
    const Eigen::Vector3d enu_m = ShiftIn(block, model, fit);
    if (!enu_m.allFinite()) return std::string();
    return Digits(enu_m.x(), 7) + ", " + Digits(enu_m.y(), 7) + ", " + Digits(enu_m.z(), 7) +
           " m east, north, up at the first of them (another datum, or another realisation of it)";
  };
  hypothesis.change = [](const Size&) {
    return std::string(
        "points.csv: role = tie of all known points until they have coordinates of the frame, if "
        "the flights are those of these images; minus this vector they fit the flights, no better "
        "than these are known");
  };
  hypothesis.screened = true;
  hypothesis.local = true;
  // Near a solution, or where looks have no place, single rows come first: a shift loses none.
  const bool of_all = !facts.near() && facts.before.lost == 0;
  hypothesis.order = of_all ? Hypothesis::kReported : Hypothesis::kGuessed;
  out->push_back(std::move(hypothesis));
}

void AddControlMistakes(const Facts& facts, Hypotheses* out) {
  const Block& block = facts.sample.block;
  if (block.points.known.empty()) return;
  double sigma_m = 1.0;
  for (const KnownPosition& known : block.points.known) {
    if (known.fixed[2]) sigma_m = std::sqrt(known.covariance_enu_m2(2, 2));
  }
  const bool geocentric = block.frame.kind() == FrameKind::kGeocentric;
  for (const PointSelection& selection : ScopesOf(block)) {
    out->push_back(ConstantHeight(selection, sigma_m, facts.before));
    out->push_back(Replaced(
        selection,
        "control.km",
        [](const Frame&, const Eigen::Vector3d& p_m) { return Eigen::Vector3d(1e3 * p_m); },
        "are in kilometres",
        "x_m, y_m, z_m times 1000, to metres,"));
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

}  // namespace sarblock
