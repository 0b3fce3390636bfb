// SPDX-License-Identifier: Apache-2.0
#include "reflector_points.h"

#include "sarblock/core/error.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/core.h>

namespace sarblock {
namespace {

/// What the images say of one reflector.
struct Sightings {
  std::vector<Eigen::Vector3d> positions_m;
  std::vector<std::pair<std::size_t, ImageCoordinates>> places;
  std::size_t file_line = 0;
};

Eigen::Vector3d MeanPosition_m(const std::string& file,
                               const std::string& id,
                               const Sightings& sightings,
                               std::vector<std::string>* warnings) {
  Eigen::Vector3d mean_m = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p_m : sightings.positions_m) mean_m += p_m;
  mean_m /= static_cast<double>(sightings.positions_m.size());
  double farthest_m = 0.0;
  for (const Eigen::Vector3d& p_m : sightings.positions_m) {
    farthest_m = std::max(farthest_m, (p_m - mean_m).norm());
  }
  constexpr double kNamed_m = 1e-3, kMoved_m = 1.0;
  if (farthest_m > kMoved_m) {
    throw InputError(FilePlace{file, sightings.file_line, id},
                     fmt::format("was moved between the images, {:.1f} m from the mean of its "
                                 "positions: a block holds a point once; import the images apart, "
                                 "or give it another name for one of them",
                                 farthest_m));
  }
  if (farthest_m > kNamed_m) {
    warnings->push_back(fmt::format(
        "{}: {} is up to {:.1f} mm from the mean of its positions at the dates of the images, "
        "which is taken for all of them",
        file,
        id,
        1e3 * farthest_m));
  }
  return mean_m;
}

}  // namespace

SeenReflectors ReflectorsInImages(const Reflectors& reflectors,
                                  const std::vector<UtcTime>& first_lines,
                                  const BlockBuilder& builder,
                                  std::vector<std::string>* warnings) {
  const double earth_m = NamedEllipsoid("WGS84").a_m;
  if (std::abs(builder.frame().ellipsoid().a_m - earth_m) > kSameRadius * earth_m) {
    throw InputError(FilePlace{reflectors.file, 0, ""},
                     "holds places on the Earth, the images are of another body");
  }
  std::map<std::string, Sightings> seen;
  std::map<std::string, std::string> why;
  for (const ReflectorSurvey& survey : reflectors.surveys) {
    why[survey.id] = "it was surveyed only after the images, or is not valid for geometry";
  }
  for (std::size_t pass = 0; pass < first_lines.size(); ++pass) {
    for (const ReflectorPosition& at :
         ReflectorsAt(reflectors, first_lines[pass], builder.frame())) {
      why[at.id] = "by its position it is in none of the images";
      const auto place = builder.Locate(pass, at.position_m);
      if (!place) continue;
      Sightings& sightings = seen[at.id];
      sightings.positions_m.push_back(at.position_m);
      sightings.places.emplace_back(pass, *place);
      sightings.file_line = at.file_line;
    }
  }
  SeenReflectors result;
  for (const auto& [id, sightings] : seen) {
    result.reflectors.push_back(
        {id, MeanPosition_m(reflectors.file, id, sightings, warnings), sightings.places});
    why.erase(id);
  }
  result.left_out.assign(why.begin(), why.end());
  return result;
}

}  // namespace sarblock
