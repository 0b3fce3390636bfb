// SPDX-License-Identifier: Apache-2.0
#include "sarblock/tables/output.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "core/text.h"
#include "core/utc.h"
#include "export.h"
#include "files/result_tables.h"
#include "quality/covariance.h"
#include <fmt/core.h>
#include <sqlite3.h>
// GeoPackage 1.3 (OGC 12-128r17) by SQLite alone: three feature tables whose geometries are blobs
// of a short header and well-known binary.
#include "sarblock/core/error.h"

namespace sarblock {
namespace {

struct RoleStyle {
  PointRole role;
  const char* folder;
  const char* colour;  // alpha, blue, green, red
  double scale;
};
constexpr std::array<RoleStyle, 3> kStyles{
    {{PointRole::kControl, "Control points", "ff2020e0", 1.0},
     {PointRole::kCheck, "Check points", "ff20b020", 0.9},
     {PointRole::kTie, "Tie points", "ffe0a020", 0.6}}};

class KmlWriter {
 public:
  KmlWriter(const std::filesystem::path& file, const ExportView& view) : view_(view), out_(file) {}

  void Head() {
    std::string hint;  // Google Earth shows the bodies it knows
    const std::string& body = view_.result.frame.ellipsoid().name;
    if (body == "Moon" || body == "Mars") hint = body == "Moon" ? "target=moon" : "target=mars";
    Add("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!-- written by sarblock -->\n");
    Add("<kml xmlns=\"http://www.opengis.net/kml/2.2\"{}>\n<Document>\n<name>{}</name>\n",
        hint.empty() ? "" : " hint=\"" + hint + "\"",
        XmlText(view_.result.summary.block));
    for (const RoleStyle& style : kStyles) {
      Add("<Style id=\"{0}\"><IconStyle><color>{1}</color><scale>{2}</scale></IconStyle>"
          "<LabelStyle><scale>{2}</scale></LabelStyle></Style>\n",
          files::NameOf(style.role),
          style.colour,
          style.scale);
    }
    Add("<Style id=\"ellipse\"><LineStyle><color>ff00a5ff</color><width>1.5</width></LineStyle>"
        "<PolyStyle><color>4000a5ff</color></PolyStyle></Style>\n"
        "<Style id=\"path\"><LineStyle><color>ffff8000</color><width>2</width></LineStyle>"
        "</Style>\n");
  }

  void Points(const RoleStyle& style) {
    Add("<Folder><name>{}</name>\n", style.folder);
    const files::ResultPoints& points = view_.result.points;
    for (const std::uint32_t point : view_.points) {
      if (points.role[point] != style.role) continue;
      Add("<Placemark><name>{}</name><styleUrl>#{}</styleUrl><ExtendedData>",
          XmlText(points.ids[point]),
          files::NameOf(style.role));
      Add("<Data name=\"role\"><value>{}</value></Data>", files::NameOf(style.role));
      Add("<Data name=\"status\"><value>{}</value></Data>", NameOf(points.results.status[point]));
      Add("<Data name=\"looks\"><value>{}</value></Data>", points.results.looks[point]);
      if (view_.HasCovariance(point)) {
        const SymmetricEnu& c = view_.Covariance_m2(point);
        Datum("sigma_e_m", std::sqrt(c[0]));
        Datum("sigma_n_m", std::sqrt(c[1]));
        Datum("sigma_u_m", std::sqrt(c[2]));
        const ErrorEllipse ellipse = EllipseOf(c, view_.ellipse_scale);
        Datum("ellipse_major_m", ellipse.major_m);
        Datum("ellipse_minor_m", ellipse.minor_m);
        Datum("ellipse_azimuth_deg", ellipse.azimuth_rad * kDegPerRad);
      }
      if (const CheckResult* check = files::FindCheck(points.checks, point)) {
        Datum("error_e_m", check->error_enu_m.x());
        Datum("error_n_m", check->error_enu_m.y());
        Datum("error_u_m", check->error_enu_m.z());
      }
      Add("</ExtendedData><Point><coordinates>");
      Place(view_.result.frame.GeodeticFromFrame(view_.Position_m(point)));
      Add("</coordinates></Point></Placemark>\n");
      Flush();
    }
    Add("</Folder>\n");
  }

  std::size_t Ellipses() {
    if (!view_.options.ellipses) return 0;
    std::size_t count = 0;
    Add("<Folder><name>Error ellipses</name><description>{}</description>\n",
        view_.options.confidence
            ? fmt::format("{} percent, true size", 100.0 * *view_.options.confidence)
            : std::string("1 sigma, true size"));
    for (const std::uint32_t point : view_.points) {
      if (!view_.HasCovariance(point)) continue;
      const auto ring = EllipseRing(view_.result.frame,
                                    view_.Position_m(point),
                                    EllipseOf(view_.Covariance_m2(point), view_.ellipse_scale));
      Add("<Placemark><name>{}</name><styleUrl>#ellipse</styleUrl><Polygon><outerBoundaryIs>"
          "<LinearRing><coordinates>",
          XmlText(view_.result.points.ids[point]));
      for (const Geodetic& corner : ring) {
        Place({corner.lat_rad, corner.lon_rad, 0.0});
        text_ += ' ';
      }
      Place({ring[0].lat_rad, ring[0].lon_rad, 0.0});
      Add("</coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark>\n");
      ++count;
      Flush();
    }
    Add("</Folder>\n");
    return count;
  }

  void Paths() {
    Add("<Folder><name>Flight paths</name>\n");
    for (const files::ResultPass& pass : view_.result.passes) {
      Add("<Placemark><name>{}</name><styleUrl>#path</styleUrl><LineString>"
          "<altitudeMode>absolute</altitudeMode><coordinates>",
          XmlText(pass.id));
      for (const StateVector& state : pass.path.states()) {
        if (&state != &pass.path.states().front()) text_ += ' ';
        Place(view_.result.frame.GeodeticFromFrame(state.position_m));
      }
      Add("</coordinates></LineString></Placemark>\n");
      Flush();
    }
    Add("</Folder>\n");
  }

  void Finish() {
    Add("</Document>\n</kml>\n");
    Flush();
    out_.Commit();
  }

 private:
  template <typename... Values>
  void Add(fmt::format_string<Values...> format, Values&&... values) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Values>(values)...);
  }
  void Datum(const char* name, double value) {
    if (!std::isnan(value)) Add("<Data name=\"{}\"><value>{}</value></Data>", name, value);
  }
  void Place(const Geodetic& place) {
    Add("{:.12f},{:.12f},{}", place.lon_rad * kDegPerRad, place.lat_rad * kDegPerRad, place.h_m);
  }
  void Flush() {
    out_.Write(text_);
    text_.clear();
  }

  const ExportView& view_;
  AtomicFile out_;
  std::string text_;
};

}  // namespace

void WriteKml(const std::filesystem::path& file, const ExportView& view, ExportReport* report) {
  KmlWriter writer(file, view);
  writer.Head();
  for (const RoleStyle& style : kStyles) writer.Points(style);
  report->ellipses = writer.Ellipses();
  writer.Paths();
  writer.Finish();
  report->paths = view.result.passes.size();
  report->files.push_back(file);
}

namespace {

constexpr int kApplicationId = 0x47504B47;  // "GPKG"
constexpr int kUserVersion = 10300;         // 1.3.0
constexpr int kCartesian = -1;              // undefined Cartesian, of every GeoPackage
constexpr int kWgs84 = 4326;
constexpr int kOwnSystem = 100000;

// A database in memory; SQLite's own failures are our bugs or a lack of memory.
class Database {
 public:
  Database() {
    sqlite3* opened = nullptr;
    const int status = sqlite3_open(":memory:", &opened);
    database_.reset(opened);
    Require(status);
  }
  void Run(const std::string& sql) {
    Require(sqlite3_exec(database_.get(), sql.c_str(), nullptr, nullptr, nullptr));
  }
  [[nodiscard]] sqlite3* get() const { return database_.get(); }
  void Require(int status) const {
    if (status == SQLITE_OK || status == SQLITE_DONE) return;
    throw std::runtime_error(std::string("SQLite: ") + sqlite3_errmsg(database_.get()));
  }
  /// The bytes of the file.
  [[nodiscard]] std::string Bytes() const {
    sqlite3_int64 size = 0;
    const std::unique_ptr<unsigned char, decltype(&sqlite3_free)> bytes(
        sqlite3_serialize(database_.get(), "main", &size, 0), &sqlite3_free);
    if (!bytes) throw std::bad_alloc();
    return {reinterpret_cast<const char*>(bytes.get()), static_cast<std::size_t>(size)};
  }

 private:
  std::unique_ptr<sqlite3, decltype(&sqlite3_close)> database_{nullptr, &sqlite3_close};
};

// INSERT with its values one by one; NaN is NULL. Texts and blobs are not copied: they must live
// until Row().
class Insert {
 public:
  Insert(const Database& database, const std::string& sql)
      : database_(database), statement_(nullptr, &sqlite3_finalize) {
    sqlite3_stmt* prepared = nullptr;
    database.Require(sqlite3_prepare_v2(database.get(), sql.c_str(), -1, &prepared, nullptr));
    statement_.reset(prepared);
  }
  Insert& Text(std::string_view text) {
    database_.Require(sqlite3_bind_text(
        statement_.get(), ++column_, text.data(), static_cast<int>(text.size()), nullptr));
    return *this;
  }
  Insert& Number(double value) {
    database_.Require(sqlite3_bind_double(statement_.get(), ++column_, value));
    return *this;
  }
  Insert& Integer(std::int64_t value) {
    database_.Require(sqlite3_bind_int64(statement_.get(), ++column_, value));
    return *this;
  }
  Insert& Blob(const std::string& bytes) {
    database_.Require(sqlite3_bind_blob(
        statement_.get(), ++column_, bytes.data(), static_cast<int>(bytes.size()), nullptr));
    return *this;
  }
  void Row() {
    database_.Require(sqlite3_step(statement_.get()));
    database_.Require(sqlite3_reset(statement_.get()));
    database_.Require(sqlite3_clear_bindings(statement_.get()));
    column_ = 0;
  }

 private:
  const Database& database_;
  std::unique_ptr<sqlite3_stmt, decltype(&sqlite3_finalize)> statement_;
  int column_ = 0;
};

// GeoPackageBinary without an envelope, in the byte order of this machine.
class Geometry {
 public:
  enum Type : std::uint32_t { kPolygon = 3, kPointZ = 1001, kLineStringZ = 1002 };
  Geometry(std::int32_t system, Type type) : bytes_("GP") {
    const char order = std::endian::native == std::endian::little ? '\1' : '\0';
    bytes_ += '\0';   // version 1
    bytes_ += order;  // flags: byte order, no envelope, not empty
    Append(system);
    bytes_ += order;
    Append(static_cast<std::uint32_t>(type));
  }
  template <typename Value>
  void Append(Value value) {
    const auto raw = std::bit_cast<std::array<char, sizeof(Value)>>(value);
    bytes_.append(raw.data(), raw.size());
  }
  void Count(std::size_t count) { Append(static_cast<std::uint32_t>(count)); }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

class GeopackageWriter {
 public:
  explicit GeopackageWriter(const ExportView& view)
      : view_(view), local_(view.result.frame.kind() == FrameKind::kLocal) {
    const Frame& frame = view.result.frame;
    system_ = kCartesian;
    if (!local_) {
      const Ellipsoid wgs84 = NamedEllipsoid("WGS84");
      const bool earth =
          frame.ellipsoid().a_m == wgs84.a_m && frame.ellipsoid().flattening == wgs84.flattening;
      system_ = earth ? kWgs84 : kOwnSystem;
    }
  }

  void Begin() {
    database_.Run(fmt::format("PRAGMA application_id = {}", kApplicationId));
    database_.Run(fmt::format("PRAGMA user_version = {}", kUserVersion));
    database_.Run(
        "BEGIN;"
        "CREATE TABLE gpkg_spatial_ref_sys (srs_name TEXT NOT NULL, srs_id INTEGER NOT NULL "
        "PRIMARY KEY, organization TEXT NOT NULL, organization_coordsys_id INTEGER NOT NULL, "
        "definition TEXT NOT NULL, description TEXT);"
        "CREATE TABLE gpkg_contents (table_name TEXT NOT NULL PRIMARY KEY, data_type TEXT NOT "
        "NULL, identifier TEXT UNIQUE, description TEXT DEFAULT '', last_change DATETIME NOT NULL "
        "DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ','now')), min_x DOUBLE, min_y DOUBLE, max_x DOUBLE, "
        "max_y DOUBLE, srs_id INTEGER, CONSTRAINT fk_gc_r_srs_id FOREIGN KEY (srs_id) REFERENCES "
        "gpkg_spatial_ref_sys(srs_id));"
        "CREATE TABLE gpkg_geometry_columns (table_name TEXT NOT NULL, column_name TEXT NOT NULL, "
        "geometry_type_name TEXT NOT NULL, srs_id INTEGER NOT NULL, z TINYINT NOT NULL, m TINYINT "
        "NOT NULL, CONSTRAINT pk_geom_cols PRIMARY KEY (table_name, column_name), CONSTRAINT "
        "uk_gc_table_name UNIQUE (table_name), CONSTRAINT fk_gc_tn FOREIGN KEY (table_name) "
        "REFERENCES gpkg_contents(table_name), CONSTRAINT fk_gc_srs FOREIGN KEY (srs_id) "
        "REFERENCES gpkg_spatial_ref_sys (srs_id));");
    AddSystem("Undefined Cartesian", -1, "NONE", "undefined");
    AddSystem("Undefined geographic", 0, "NONE", "undefined");
    AddSystem("WGS 84 geodetic", kWgs84, "EPSG", GeographicText("WGS 84", NamedEllipsoid("WGS84")));
    if (system_ == kOwnSystem) {
      const Ellipsoid& body = view_.result.frame.ellipsoid();
      AddSystem(body.name, kOwnSystem, "NONE", GeographicText(body.name, body));
    }
  }

  void Points() {
    AddTable("points",
             "POINT",
             1,
             "point TEXT, role TEXT, status TEXT, looks INTEGER, sigma_e_m DOUBLE, sigma_n_m "
             "DOUBLE, sigma_u_m DOUBLE, cov_en_m2 DOUBLE, cov_eu_m2 DOUBLE, cov_nu_m2 DOUBLE, "
             "ellipse_major_m DOUBLE, ellipse_minor_m DOUBLE, ellipse_azimuth_deg DOUBLE, "
             "error_e_m DOUBLE, error_n_m DOUBLE, error_u_m DOUBLE");
    Insert insert(database_, "INSERT INTO points VALUES (NULL,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)");
    const files::ResultPoints& points = view_.result.points;
    for (const std::uint32_t point : view_.points) {
      Geometry geometry(system_, Geometry::kPointZ);
      for (const double coordinate : Coordinates(view_.Position_m(point))) {
        geometry.Append(coordinate);
      }
      insert.Blob(geometry.bytes()).Text(points.ids[point]).Text(files::NameOf(points.role[point]));
      insert.Text(NameOf(points.results.status[point])).Integer(points.results.looks[point]);
      SymmetricEnu c;
      c.fill(kNotGiven);
      ErrorEllipse ellipse{kNotGiven, kNotGiven, kNotGiven};
      if (view_.HasCovariance(point)) {
        c = view_.Covariance_m2(point);
        ellipse = EllipseOf(c, view_.ellipse_scale);
      }
      for (std::size_t k = 0; k < 3; ++k) insert.Number(std::sqrt(c[k]));
      for (std::size_t k = 3; k < 6; ++k) insert.Number(c[k]);
      insert.Number(ellipse.major_m).Number(ellipse.minor_m);
      insert.Number(ellipse.azimuth_rad * kDegPerRad);
      const CheckResult* check = files::FindCheck(points.checks, point);
      for (Eigen::Index k = 0; k < 3; ++k) {
        insert.Number(check != nullptr ? check->error_enu_m[k] : kNotGiven);
      }
      insert.Row();
    }
  }

  std::size_t Ellipses() {
    if (!view_.options.ellipses) return 0;
    AddTable("ellipses", "POLYGON", 0, "point TEXT, confidence DOUBLE");
    Insert insert(database_, "INSERT INTO ellipses VALUES (NULL,?,?,?)");
    std::size_t count = 0;
    for (const std::uint32_t point : view_.points) {
      if (!view_.HasCovariance(point)) continue;
      Geometry geometry(system_, Geometry::kPolygon);
      geometry.Count(1);
      geometry.Count(kEllipseCorners + 1);
      const auto ring = Ring(point);
      for (const Eigen::Vector2d& corner : ring) AppendCorner(corner, &geometry);
      AppendCorner(ring[0], &geometry);
      insert.Blob(geometry.bytes()).Text(view_.result.points.ids[point]);
      insert.Number(view_.options.confidence.value_or(-std::expm1(-0.5))).Row();
      ++count;
    }
    return count;
  }

  void Paths() {
    AddTable("flight_paths", "LINESTRING", 1, "pass TEXT, start_s DOUBLE, end_s DOUBLE");
    Insert insert(database_, "INSERT INTO flight_paths VALUES (NULL,?,?,?,?)");
    for (const files::ResultPass& pass : view_.result.passes) {
      Geometry geometry(system_, Geometry::kLineStringZ);
      geometry.Count(pass.path.states().size());
      for (const StateVector& state : pass.path.states()) {
        for (const double coordinate : Coordinates(state.position_m)) geometry.Append(coordinate);
      }
      insert.Blob(geometry.bytes())
          .Text(pass.id)
          .Number(pass.path.start_s())
          .Number(pass.path.end_s())
          .Row();
    }
  }

  [[nodiscard]] std::string Bytes() {
    database_.Run("COMMIT");
    return database_.Bytes();
  }

 private:
  static std::string GeographicText(const std::string& name, const Ellipsoid& e) {
    return fmt::format(
        "GEOGCS[\"{}\",DATUM[\"{}\",SPHEROID[\"{}\",{},{}]],PRIMEM[\"{}\",0],"
        "UNIT[\"degree\",0.0174532925199433]]",
        name,
        e.name,
        e.name,
        e.a_m,
        e.flattening > 0.0 ? 1.0 / e.flattening : 0.0,
        e.name == "WGS84" || e.name == "GRS80" ? "Greenwich" : "Reference_Meridian");
  }
  void AddSystem(const std::string& name, int id, const char* by, const std::string& definition) {
    Insert insert(database_, "INSERT INTO gpkg_spatial_ref_sys VALUES (?,?,?,?,?,NULL)");
    insert.Text(name).Integer(id).Text(by).Integer(id).Text(definition).Row();
  }
  void AddTable(const char* name, const char* type, int z, const char* columns) {
    database_.Run(
        fmt::format("CREATE TABLE {} (fid INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, geom {}, {})",
                    name,
                    type,
                    columns));
    const auto created = ParseUtc(view_.options.created_utc);
    std::string when = created ? UtcText(*created) : "1970-01-01T00:00:00Z";
    when.insert(when.size() - 1, ".000");
    Insert contents(database_,
                    "INSERT INTO gpkg_contents (table_name, data_type, identifier, description, "
                    "last_change, srs_id) VALUES (?,'features',?,?,?,?)");
    const std::string realization = view_.Realization();
    contents.Text(name)
        .Text(name)
        .Text("written by sarblock" + (realization.empty() ? "" : "; positions in " + realization))
        .Text(when)
        .Integer(system_)
        .Row();
    Insert column(database_, "INSERT INTO gpkg_geometry_columns VALUES (?,'geom',?,?,?,0)");
    column.Text(name).Text(type).Integer(system_).Integer(z).Row();
  }
  [[nodiscard]] Eigen::Vector3d Coordinates(const Eigen::Vector3d& p_m) const {
    if (local_) return p_m;
    const Geodetic place = view_.result.frame.GeodeticFromFrame(p_m);
    return {place.lon_rad * kDegPerRad, place.lat_rad * kDegPerRad, place.h_m};
  }
  [[nodiscard]] std::array<Eigen::Vector2d, kEllipseCorners> Ring(std::uint32_t point) const {
    const ErrorEllipse ellipse = EllipseOf(view_.Covariance_m2(point), view_.ellipse_scale);
    const Eigen::Vector3d& p_m = view_.Position_m(point);
    std::array<Eigen::Vector2d, kEllipseCorners> ring = EllipseCorners(ellipse);
    if (local_) {
      for (Eigen::Vector2d& corner : ring) corner += p_m.head<2>();
      return ring;
    }
    const auto geodetic = EllipseRing(view_.result.frame, p_m, ellipse);
    for (std::size_t i = 0; i < ring.size(); ++i) {
      ring[i] = {geodetic[i].lon_rad * kDegPerRad, geodetic[i].lat_rad * kDegPerRad};
    }
    return ring;
  }
  static void AppendCorner(const Eigen::Vector2d& corner, Geometry* geometry) {
    geometry->Append(corner.x());
    geometry->Append(corner.y());
  }

  const ExportView& view_;
  bool local_;
  std::int32_t system_ = kCartesian;
  Database database_;
};

}  // namespace

void WriteGeoPackage(const std::filesystem::path& file,
                     const ExportView& view,
                     ExportReport* report) {
  GeopackageWriter writer(view);
  writer.Begin();
  writer.Points();
  report->ellipses = writer.Ellipses();
  writer.Paths();
  AtomicFile out(file);
  out.Write(writer.Bytes());
  out.Commit();
  report->paths = view.result.passes.size();
  report->files.push_back(file);
}

}  // namespace sarblock
