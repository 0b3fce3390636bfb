// SPDX-License-Identifier: Apache-2.0
#include "frames.h"

#include "sarblock/core/error.h"
#include "sarblock/core/id_table.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "core/text.h"
#include "core/utc.h"
#include <proj.h>

namespace sarblock {

using Eigen::Vector3d;

namespace {

struct Destroy {
  void operator()(PJ_CONTEXT* context) const { proj_context_destroy(context); }
  void operator()(PJ* object) const { proj_destroy(object); }
};
using Object = std::unique_ptr<PJ, Destroy>;

std::string Lower(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return lower;
}

constexpr double kWorstAccuracy_m = 0.1;

// Where a frame is used, degrees; from west to east over the date line where west is the larger.
struct Area {
  double west_deg = -180.0, south_deg = -90.0, east_deg = 180.0, north_deg = 90.0;
  std::string name;

  [[nodiscard]] bool Has(const Vector3d& p_m) const {
    const double lat_deg = std::asin(p_m.normalized().z()) * kDegPerRad;
    const double lon_deg = std::atan2(p_m.y(), p_m.x()) * kDegPerRad;
    constexpr double kMargin_deg = 0.5;  // of geocentric latitudes, and of people's boundaries
    const auto east_of = [&](double degrees) { return lon_deg >= degrees - kMargin_deg; };
    const auto west_of = [&](double degrees) { return lon_deg <= degrees + kMargin_deg; };
    const bool between = west_deg <= east_deg ? east_of(west_deg) && west_of(east_deg)
                                              : east_of(west_deg) || west_of(east_deg);
    return between && lat_deg >= south_deg - kMargin_deg && lat_deg <= north_deg + kMargin_deg;
  }
};

struct Geoid {
  const char* name;
  const char* grids;  // by their names in PROJ's data, old and new
};
constexpr std::array<Geoid, 2> kGeoids{{{"egm96", "@us_nga_egm96_15.tif,egm96_15.gtx"},
                                        {"egm2008", "@us_nga_egm08_25.tif,egm08_25.gtx"}}};

}  // namespace

bool IsEarth(const Frame& frame) {
  constexpr double kEarth_m = 6378137.0, kAlike = 1e-3;
  return frame.kind() == FrameKind::kGeocentric &&
         std::abs(frame.ellipsoid().a_m / kEarth_m - 1.0) < kAlike;
}

class ReferenceFrames::Library {
 public:
  Library() : context_(proj_context_create()) {
    proj_log_level(context_.get(), PJ_LOG_NONE);
    proj_context_set_enable_network(context_.get(), 0);
    const std::unique_ptr<PROJ_CRS_LIST_PARAMETERS, decltype(&proj_get_crs_list_parameters_destroy)>
        wanted(proj_get_crs_list_parameters_create(), &proj_get_crs_list_parameters_destroy);
    const PJ_TYPE geocentric = PJ_TYPE_GEOCENTRIC_CRS;
    wanted->types = &geocentric;
    wanted->typesCount = 1;
    wanted->allow_deprecated = 0;
    int count = 0;
    const std::unique_ptr<PROJ_CRS_INFO*, decltype(&proj_crs_info_list_destroy)> list(
        proj_get_crs_info_list_from_database(context_.get(), "EPSG", wanted.get(), &count),
        &proj_crs_info_list_destroy);
    for (int i = 0; i < count; ++i) {
      names_.emplace_back(list.get()[i]->name);
      codes_.emplace(list.get()[i]->name, list.get()[i]->code);
    }
    std::sort(names_.begin(), names_.end());
  }

  [[nodiscard]] PJ_CONTEXT* context() const { return context_.get(); }

  [[nodiscard]] Object System(const std::string& name) const {
    return Object(proj_create_from_database(
        context(), "EPSG", codes_.at(name).c_str(), PJ_CATEGORY_CRS, 0, nullptr));
  }

  // Throws InputError where there is no such system.
  const std::string& Named(std::string_view name) {
    const auto found = named_.find(name);
    return found != named_.end() ? found->second
                                 : named_.emplace(std::string(name), FindName(name)).first->second;
  }
  bool MovesWithPlate(const std::string& name) {
    const auto [found, added] = moves_with_plate_.try_emplace(name);
    if (added) {
      const Object datum(proj_crs_get_datum(context(), System(name).get()));
      found->second = proj_get_type(datum.get()) != PJ_TYPE_DYNAMIC_GEODETIC_REFERENCE_FRAME;
    }
    return found->second;
  }
  const Area& AreaOf(const std::string& name) {
    const auto [found, added] = areas_.try_emplace(name);
    Area& area = found->second;
    const char* text = nullptr;
    if (added && proj_get_area_of_use(context(),
                                      System(name).get(),
                                      &area.west_deg,
                                      &area.south_deg,
                                      &area.east_deg,
                                      &area.north_deg,
                                      &text) != 0) {
      area.name = text;
    }
    return area;
  }
  PJ* Between(const std::string& from, const std::string& to) {
    const auto [found, added] = transformations_.try_emplace({from, to});
    if (added) found->second = Create(from, to);
    return found->second.get();
  }
  PJ* GeoidGrid(const Geoid& geoid) {
    const auto [found, added] = grids_.try_emplace(geoid.name);
    if (added) {
      const std::string definition = std::string("+proj=vgridshift +grids=") + geoid.grids;
      found->second.reset(proj_create(context(), definition.c_str()));
    }
    return found->second.get();
  }

 private:
  [[nodiscard]] std::string FindName(std::string_view name) const {
    if (names_.empty()) {
      throw InputError("realization", "needs the data of PROJ (proj.db), which are not found");
    }
    const auto found = std::find_if(names_.begin(), names_.end(), [&](const std::string& known) {
      return Lower(known) == Lower(name);
    });
    if (found == names_.end()) {
      std::vector<std::string> international;
      std::copy_if(names_.begin(),
                   names_.end(),
                   std::back_inserter(international),
                   [](const std::string& known) { return known.starts_with("ITRF"); });
      throw InputError("realization",
                       "'" + std::string(name) + "' is not known; allowed are " +
                           ListNames(international, 0, international.size()) +
                           " and EPSG's other geocentric frames, like GDA2020, NAD83(2011) and "
                           "WGS 84 (G2139)" +
                           DidYouMean(NearestName(name, names_)));
    }
    const Object system = System(*found);
    if (Object(proj_crs_get_datum_ensemble(context(), system.get()))) {
      throw InputError("realization",
                       "'" + *found + "' stands for several realizations that are up to " +
                           "metres apart; name one of them");
    }
    return *found;
  }
  Object Create(const std::string& from, const std::string& to) {
    const std::string accuracy = "ACCURACY=" + NumberText(kWorstAccuracy_m);
    const std::array<const char*, 3> options{"ALLOW_BALLPARK=NO", accuracy.c_str(), nullptr};
    return Object(proj_create_crs_to_crs_from_pj(
        context(), System(from).get(), System(to).get(), nullptr, options.data()));
  }

  std::unique_ptr<PJ_CONTEXT, Destroy> context_;
  std::vector<std::string> names_;
  std::map<std::string, std::string> codes_;  // of EPSG, by name
  std::map<std::string, std::string, std::less<>> named_;
  std::map<std::string, Area> areas_;
  std::map<std::string, bool> moves_with_plate_;
  std::map<std::pair<std::string, std::string>, Object> transformations_;
  std::map<std::string, Object> grids_;
};

ReferenceFrames::ReferenceFrames() : library_(std::make_unique<Library>()) {}
ReferenceFrames::~ReferenceFrames() = default;

std::string ReferenceFrames::Named(std::string_view name) { return library_->Named(name); }

bool ReferenceFrames::MovesWithPlate(const std::string& name) {
  return library_->MovesWithPlate(name);
}

MovingPoint ReferenceFrames::Transform(const std::string& from,
                                       const std::string& to,
                                       double epoch_year,
                                       const MovingPoint& point) {
  if (from == to) return point;
  for (const std::string& name : {from, to}) {
    if (const Area& area = library_->AreaOf(name); !area.Has(point.position_m)) {
      throw InputError("frame", name + " is not used at this place, but in: " + area.name);
    }
  }
  PJ* const operation = library_->Between(from, to);
  const auto transformed = [&](double after_years) -> Vector3d {
    const Vector3d p_m = point.After(after_years).position_m;
    if (operation != nullptr) {
      const PJ_COORD out = proj_trans(
          operation, PJ_FWD, proj_coord(p_m.x(), p_m.y(), p_m.z(), epoch_year + after_years));
      if (std::isfinite(out.xyz.x)) return {out.xyz.x, out.xyz.y, out.xyz.z};
    }
    throw InputError("frame",
                     "PROJ's data have no transformation from " + from + " to " + to + " of " +
                         NumberText(kWorstAccuracy_m) + " m or better at this place");
  };
  // Parameters change linearly in time, and so does the point: the product is a parabola, of which
  // central differences are exact.
  constexpr double kHalf_years = 5.0;
  return {transformed(0.0),
          (transformed(kHalf_years) - transformed(-kHalf_years)) / (2.0 * kHalf_years)};
}

double ReferenceFrames::GeoidHeight_m(std::string_view geoid, double lat_rad, double lon_rad) {
  const auto* const found = std::find_if(kGeoids.begin(), kGeoids.end(), [&](const Geoid& known) {
    return known.name == Lower(geoid);
  });
  if (found == kGeoids.end()) {
    throw InputError("geoid",
                     "'" + std::string(geoid) + "' is not known, egm96 or egm2008 is allowed");
  }
  PJ* const grid = library_->GeoidGrid(*found);
  // The inverse leads from heights above the geoid to heights above the ellipsoid.
  const double height_m =
      grid == nullptr ? kNaN
                      : proj_trans(grid, PJ_INV, proj_coord(lon_rad, lat_rad, 0.0, 0.0)).xyz.z;
  if (!std::isfinite(height_m)) {
    throw InputError("geoid",
                     std::string("the grid of ") + found->name +
                         " is not among the data of PROJ; its file is one of " +
                         (found->grids + 1));
  }
  return height_m;
}

std::string DoubtOfPlates(const Block& block) {
  constexpr double kSlow_mpy = 0.02, kFast_mpy = 0.07;
  if (!IsEarth(block.frame)) return "";
  double least_m = std::numeric_limits<double>::infinity();
  for (const KnownPosition& known : block.points.known) {
    if (!known.velocity_mpy.isZero(0.0)) return "";
    for (std::size_t i = 0; i < 3; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      if (known.fixed[i]) least_m = std::min(least_m, std::sqrt(known.covariance_enu_m2(k, k)));
    }
  }
  std::vector<double> years;
  for (const Pass& pass : block.passes) {
    if (const auto epoch = ParseUtc(pass.epoch_utc)) {
      years.push_back(JulianYear(AddSeconds(*epoch, pass.start_s)));
    }
  }
  if (years.empty()) return "";
  const bool dated = !std::isnan(block.epoch_year);
  if (dated) years.push_back(block.epoch_year);
  const auto [first, last] = std::minmax_element(years.begin(), years.end());
  const double span = *last - *first;
  if (!(kFast_mpy * span > least_m)) return "";
  return "known points are good to " + Digits(least_m, 2) + " m and do not move, but images" +
         (dated ? " and the epoch of the frame are " : " are ") + Digits(span, 2) +
         " years apart: plates move by " + Digits(kSlow_mpy * span, 2) + " to " +
         Digits(kFast_mpy * span, 2) + " m in that time; give " +
         (dated ? "" : "realization and epoch of [frame], and ") +
         "velocities of known points (vx_mpy, vy_mpy, vz_mpy), or the frame of their plate (frame)";
}

void RequireEpoch(double epoch_year) {
  if (epoch_year >= 1980.0 && epoch_year <= 2100.0) return;
  throw InputError("epoch",
                   "must be a year like 2022.79, from 1980 to 2100, got " + NumberText(epoch_year));
}

}  // namespace sarblock
