// SPDX-License-Identifier: Apache-2.0
#include "sarblock/geometry/frame.h"

#include "sarblock/core/error.h"
#include "sarblock/core/id_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <vector>

#include <GeographicLib/Geocentric.hpp>

namespace sarblock {
namespace {

const std::vector<Ellipsoid>& Known() {
  static const std::vector<Ellipsoid> known = {
      {"WGS84", 6378137.0, 1.0 / 298.257223563},  // NGA.STND.0036, 2014
      {"GRS80", 6378137.0, 1.0 / 298.257222101},  // Moritz, 1980
      {"Moon", 1737400.0, 0.0},                   // IAU/IAG working group
      {"Venus", 6051800.0, 0.0},                  // IAU/IAG working group
      {"Mars", 3396190.0, 19990.0 / 3396190.0},   // IAU 2000, polar radius 3376.20 km
  };
  return known;
}

bool SameName(std::string_view a, std::string_view b) {
  const auto lower = [](char c) {
    return 'A' <= c && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [&lower](char x, char y) {
    return lower(x) == lower(y);
  });
}

}  // namespace

Ellipsoid NamedEllipsoid(const std::string& name) {
  for (const Ellipsoid& known : Known()) {
    if (SameName(known.name, name)) return known;
  }
  std::string allowed;
  for (const std::string& known : EllipsoidNames())
    allowed += (allowed.empty() ? "" : ", ") + known;
  throw InputError("ellipsoid",
                   "'" + name + "' is not known, allowed are " + allowed +
                       DidYouMean(NearestName(name, EllipsoidNames())));
}

const std::vector<std::string>& EllipsoidNames() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const Ellipsoid& known : Known()) list.push_back(known.name);
    return list;
  }();
  return names;
}

void Validate(const Ellipsoid& ellipsoid) {
  if (!(std::isfinite(ellipsoid.a_m) && ellipsoid.a_m > 0.0)) {
    throw InputError("ellipsoid.a_m",
                     std::to_string(ellipsoid.a_m) + " must be finite and greater than 0");
  }
  if (!(ellipsoid.flattening >= 0.0 && ellipsoid.flattening < 1.0)) {
    throw InputError("ellipsoid.flattening",
                     std::to_string(ellipsoid.flattening) + " must be at least 0 and less than 1");
  }
}

namespace {

constexpr std::array<Body, 5> kBodies = {{{"WGS84", 3.986004418e14, 7.292115e-5},
                                          {"GRS80", 3.986005e14, 7.292115e-5},
                                          {"Moon", 4.9028e12, 2.6616995e-6},
                                          {"Venus", 3.24858592e14, -2.9924e-7},
                                          {"Mars", 4.282837e13, 7.088218e-5}}};

}  // namespace

const Body* FindBody(const std::string& ellipsoid) {
  const auto* found = std::find_if(
      kBodies.begin(), kBodies.end(), [&](const Body& body) { return body.name == ellipsoid; });
  return found == kBodies.end() ? nullptr : found;
}

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Geodetic coordinates of p in degrees and the axes there, by GeographicLib.
struct Place {
  double lat_deg = 0.0;
  double lon_deg = 0.0;
  double h_m = 0.0;
  Matrix3d enu_from_frame;
};

Place PlaceOf(const Ellipsoid& ellipsoid, const Vector3d& p_m) {
  // Setting one up is ten operations and keeps the library out of the header.
  const GeographicLib::Geocentric earth(ellipsoid.a_m, ellipsoid.flattening);
  Place place;
  // Nine numbers by rows, columns east, north, up: read by columns it is the transpose.
  static thread_local std::vector<double> rotation(9);
  earth.Reverse(p_m.x(), p_m.y(), p_m.z(), place.lat_deg, place.lon_deg, place.h_m, rotation);
  place.enu_from_frame = Eigen::Map<const Matrix3d>(rotation.data());
  return place;
}

// Vertical, with both principal radii of curvature of the ellipsoid: the vertical turns by
// 1/(N + h) for a step east and by 1/(M + h) for a step north.
Vertical VerticalOf(const Ellipsoid& ellipsoid, const Vector3d& p_m) {
  const Place place = PlaceOf(ellipsoid, p_m);
  const double e2 = ellipsoid.flattening * (2.0 - ellipsoid.flattening);
  const Vector3d east = place.enu_from_frame.row(0);
  const Vector3d north = place.enu_from_frame.row(1);
  Vertical vertical;
  vertical.up = place.enu_from_frame.row(2);
  vertical.height_m = place.h_m;
  const double q = 1.0 - e2 * vertical.up.z() * vertical.up.z();
  const double prime_vertical_m = ellipsoid.a_m / std::sqrt(q);
  const double meridian_m = prime_vertical_m * (1.0 - e2) / q;
  vertical.dup_dp = east * east.transpose() / (prime_vertical_m + place.h_m) +
                    north * north.transpose() / (meridian_m + place.h_m);
  return vertical;
}

void RequireGeocentric(FrameKind kind) {
  if (kind != FrameKind::kGeocentric) {
    throw InputError("frame", "'local' has no geodetic coordinates; allowed: 'geocentric'");
  }
}

/// Above, Bowring's formula is no longer good to 1e-8.
constexpr double kMaxFlattening = 0.01;

}  // namespace

Frame Frame::Local() { return Frame(); }

Frame Frame::Geocentric(const Ellipsoid& ellipsoid) {
  Validate(ellipsoid);
  Frame frame;
  frame.kind_ = FrameKind::kGeocentric;
  frame.ellipsoid_ = ellipsoid;
  return frame;
}

Matrix3d Frame::EnuFromFrame(const Vector3d& p_m) const {
  if (kind_ == FrameKind::kLocal) return Matrix3d::Identity();
  return PlaceOf(ellipsoid_, p_m).enu_from_frame;
}

Vertical Frame::VerticalAt(const Vector3d& p_m) const {
  if (kind_ == FrameKind::kGeocentric) return VerticalOf(ellipsoid_, p_m);
  Vertical vertical;
  vertical.height_m = p_m.z();
  return vertical;
}

Vector3d Frame::UpAt(const Vector3d& p_m) const {
  if (kind_ == FrameKind::kLocal) return Vector3d::UnitZ();
  const double f = ellipsoid_.flattening, a_m = ellipsoid_.a_m;
  const double axial_m = std::hypot(p_m.x(), p_m.y()), r_m = p_m.norm();
  const bool usual = std::abs(f) < kMaxFlattening && r_m > 0.9 * a_m && axial_m > 1e-6 * a_m;
  if (!usual) return VerticalAt(p_m).up;
  const double b_m = a_m * (1.0 - f), e2 = f * (2.0 - f), second_e2 = e2 / ((1.0 - f) * (1.0 - f));
  const double sine = b_m * p_m.z() * (1.0 + second_e2 * b_m / r_m), cosine = a_m * axial_m;
  const double inverse = 1.0 / std::sqrt(sine * sine + cosine * cosine);
  const double s = sine * inverse, c = cosine * inverse;
  const double outward = (1.0 - e2 * a_m * c * c * c / axial_m);
  return Vector3d(outward * p_m.x(), outward * p_m.y(), p_m.z() + second_e2 * b_m * s * s * s)
      .normalized();
}

// With n the vertical, G = diag(a^2, a^2, b^2) and w = sqrt(n'Gn), the point is
//     s = G n / w + h n.
// Differentiated once and twice (docs/theory/conventions.md, eqs. (5) to (8)):
//     s'  = K n' + h' n,    K = G/w - Gn (Gn)'/w^3 + h I,    h' = n.s'
//     s'' = K n'' + K' n' + h'' n + h' n'.
// K maps the tangent plane onto itself and is inverted there by d up / d p, which also removes
// everything along n. So n' = (d up / d p) s', and the tangential part of n'' in the same way; its
// normal part is -|n'|^2 n because n stays a unit vector.
VerticalMotion Frame::VerticalAlong(const Vector3d& p_m,
                                    const Vector3d& velocity_mps,
                                    const Vector3d& acceleration_mps2) const {
  VerticalMotion motion;
  if (kind_ == FrameKind::kLocal) return motion;
  const Vertical vertical = VerticalOf(ellipsoid_, p_m);
  const Vector3d& n = vertical.up;
  const Vector3d n1 = vertical.dup_dp * velocity_mps;
  const double a_m = ellipsoid_.a_m;
  const double b_m = a_m * (1.0 - ellipsoid_.flattening);
  const Vector3d axes_m2(a_m * a_m, a_m * a_m, b_m * b_m);  // diagonal of G
  const Vector3d gn = axes_m2.cwiseProduct(n);
  const Vector3d gn1 = axes_m2.cwiseProduct(n1);
  const double w = std::sqrt(n.dot(gn));
  const double w1 = n1.dot(gn) / w;
  const double h1 = n.dot(velocity_mps);
  // K' n' term by term, without forming K'. (Gn').n' and (Gn).n' = w w' appear as scalars.
  const double gn_n1 = w * w1;
  const double gn1_n1 = gn1.dot(n1);
  const Vector3d turned = -gn1 * (w1 / (w * w)) - (gn1 * gn_n1 + gn * gn1_n1) / (w * w * w) +
                          gn * (3.0 * gn_n1 * w1 / (w * w * w * w)) + h1 * n1;
  motion.up = n;
  motion.rate = n1;
  motion.acceleration =
      vertical.dup_dp * (acceleration_mps2 - turned - h1 * n1) - n1.squaredNorm() * n;
  return motion;
}

Geodetic Frame::GeodeticFromFrame(const Vector3d& p_m) const {
  RequireGeocentric(kind_);
  const Place place = PlaceOf(ellipsoid_, p_m);
  return {.lat_rad = place.lat_deg * kRadPerDeg,
          .lon_rad = place.lon_deg * kRadPerDeg,
          .h_m = place.h_m};
}

Vector3d Frame::FrameFromGeodetic(const Geodetic& geodetic) const {
  RequireGeocentric(kind_);
  const GeographicLib::Geocentric earth(ellipsoid_.a_m, ellipsoid_.flattening);
  Vector3d p_m;
  earth.Forward(geodetic.lat_rad * kDegPerRad,
                geodetic.lon_rad * kDegPerRad,
                geodetic.h_m,
                p_m.x(),
                p_m.y(),
                p_m.z());
  return p_m;
}

Vector3d Frame::AtHeight(const Vector3d& p_m, double height_m) const {
  const Vertical vertical = VerticalAt(p_m);
  return p_m + (height_m - vertical.height_m) * vertical.up;
}

}  // namespace sarblock
