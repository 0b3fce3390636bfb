#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Every export of the program read back by readers that share no code with it; run by ctest.

Environment: SARBLOCK_PROGRAM, SARBLOCK_DATASETS, SARBLOCK_SHARED_DATA. Readers are those of Python
(json, xml, sqlite3, csv), check_sinex.py, and where they are installed ogrinfo, ogr2ogr, xmllint.
"""
import csv
import json
import math
import os
import pathlib
import re
import shutil
import sqlite3
import struct
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

import check_sinex

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "cli"))
from program import PROGRAM, run, table  # noqa: E402

DATASETS = pathlib.Path(os.environ["SARBLOCK_DATASETS"])
SENTINEL1 = pathlib.Path(os.environ["SARBLOCK_SHARED_DATA"]) / "sentinel1"
A_M, F = 6378137.0, 1.0 / 298.257223563  # WGS84
KML = "{http://www.opengis.net/kml/2.2}"
IMAGE = """epoch_utc = "2016-12-31T23:59:50Z"
[pass.image]
presentation = "slant"
first_line_s = -3.5
line_interval_s = 0.002
near_range_m = 700000.25
range_spacing_m = 2.5
"""


def below(path, skip):
    """Rows of a table below so many rows of headings."""
    with open(path, encoding="utf-8", newline="") as stream:
        return list(csv.reader(stream))[skip:]


def number(cell):
    return float(cell) if cell != "" else math.nan


def multiply(a, b):
    return [[sum(x * y for x, y in zip(row, column)) for column in zip(*b)] for row in a]


def transposed(a):
    return [list(column) for column in zip(*a)]


def axes(lat, lon):
    """Rows east, north, up."""
    s, c, sl, cl = math.sin(lat), math.cos(lat), math.sin(lon), math.cos(lon)
    return [[-sl, cl, 0.0], [-s * cl, -s * sl, c], [c * cl, c * sl, s]]


def enu_covariance(row):
    e, n, u = (number(row[f"sigma_{k}_m"]) for k in "enu")
    en, eu, nu = (number(row[f"cov_{k}_m2"]) for k in ("en", "eu", "nu"))
    return [[e * e, en, eu], [en, n * n, nu], [eu, nu, u * u]]


def in_frame(row, covariance):
    turn = axes(math.radians(number(row["lat_deg"])), math.radians(number(row["lon_deg"])))
    return multiply(transposed(turn), multiply(covariance, turn))


def tool(name):
    if shutil.which(name) is None:
        raise unittest.SkipTest(f"no {name}")
    return name


def make_block(folder, scene, change, *settings):
    run("simulate", DATASETS / "scenes" / scene, "-o", folder, "--set", "points.count=40",
        "--set", "check.count=6", *settings)
    toml = folder / "block.toml"
    toml.write_text(change(toml.read_text(encoding="utf-8")), encoding="utf-8")


def with_image(text):
    """Every pass gets an epoch ten seconds before a leap second, and a raster."""
    return re.sub(r"(?s)(\[\[pass\]\]\n.*?)(?=\n\[\[pass\]\]|\Z)",
                  lambda m: m.group(1).rstrip() + "\n" + IMAGE, text)


class Exports(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="sarblock-export-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.earth = cls.folder / "earth"
        make_block(cls.folder / "block", "earth-asc-desc.toml", with_image)
        run("adjust", cls.folder / "block", "-o", cls.earth, "--set", "pairs=all")
        cls.points = table(cls.earth / "points.csv")
        cls.paths = table(cls.earth / "trajectories.csv")
        cls.local = cls.folder / "local"
        make_block(cls.folder / "flat", "opposite-side.toml", str)
        run("adjust", cls.folder / "flat", "-o", cls.local)

    def export(self, form, name, *options, result=None, code=0):
        out = self.folder / name
        done = run("export", result or self.earth, "--format", form, "-o", out, *options, code=code)
        return done.stderr if code else out

    def test_every_format_reports_what_it_leaves_out(self):
        reported = {}
        for form in ("geojson", "kml", "gpkg", "isis", "sinex"):
            done = run("export", self.earth, "--format", form, "-o", self.folder / f"left-{form}", "--json")
            reported[form] = json.loads(done.stdout)["not_carried"]
            self.assertIn("  not carried: ", run("export", self.earth, "--format", form, "-o",
                                                 self.folder / f"left-{form}").stdout)
        for form in ("geojson", "kml", "gpkg"):
            self.assertEqual(reported[form], ["residuals, parameters of passes, covariances of different points"])
        self.assertIn("flight paths", reported["isis"][0])
        self.assertIn("antisymmetric", reported["sinex"][1])
        # Of paths alone: a range bias with its size.
        biased = self.folder / "biased"
        run("adjust", self.folder / "block", "-o", biased, "--set", "correction.range.bias_sigma_m=2")
        done = run("export", biased, "--format", "eof", "--mission", "Sentinel-1A", "-o", self.folder / "left-eof", "--json")
        bias = next(row for row in table(biased / "passes.csv") if row["parameter"] == "range.bias")
        line = next(text for text in json.loads(done.stdout)["not_carried"] if text.startswith(bias["pass"]))
        self.assertAlmostEqual(float(line.split()[2]), float(bias["value"]), delta=1e-5)

    def assert_on_ellipse(self, row, corners, square):
        """Corners as longitude, latitude: d' C^-1 d is the square of the scale, 1e-5 of it."""
        lat = math.radians(number(row["lat_deg"]))
        e2 = F * (2.0 - F)
        w = math.sqrt(1.0 - e2 * math.sin(lat) ** 2)
        h = number(row["h_m"])
        c = enu_covariance(row)
        det = c[0][0] * c[1][1] - c[0][1] ** 2
        area = 0.0
        offsets = [(math.radians(lon - number(row["lon_deg"])) * (A_M / w + h) * math.cos(lat),
                    math.radians(p - number(row["lat_deg"])) * (A_M * (1.0 - e2) / w ** 3 + h))
                   for lon, p in corners]
        for e, n in offsets:
            value = (c[1][1] * e * e - 2.0 * c[0][1] * e * n + c[0][0] * n * n) / det
            self.assertAlmostEqual(value / square, 1.0, delta=1e-5)
        for (e0, n0), (e1, n1) in zip(offsets, offsets[1:]):
            area += 0.5 * (e0 * n1 - e1 * n0)
        self.assertAlmostEqual(
            area / (18.0 * math.sin(math.radians(10.0)) * square * math.sqrt(det)), 1.0, delta=1e-5)

    # GeoJSON

    def test_geojson_has_points_ellipses_and_paths(self):
        out = self.export("geojson", "e.geojson", "--confidence", "95")
        features = json.loads(out.read_text(encoding="utf-8"))["features"]
        by_type = {}
        for feature in features:
            by_type.setdefault(feature["geometry"]["type"], []).append(feature)
        self.assertEqual({k: len(v) for k, v in by_type.items()},
                         {"Point": 50, "Polygon": 50, "LineString": 2})
        for row, point, ellipse in zip(self.points, by_type["Point"], by_type["Polygon"]):
            self.assertEqual(point["properties"]["point"], row["point"])
            self.assertEqual(point["properties"]["role"], row["role"])
            lon, lat, h = point["geometry"]["coordinates"]
            self.assertAlmostEqual(lon, number(row["lon_deg"]), delta=1e-12)
            self.assertAlmostEqual(lat, number(row["lat_deg"]), delta=1e-12)
            self.assertAlmostEqual(h, number(row["h_m"]), delta=1e-9)
            for key in ("sigma_e_m", "sigma_n_m", "sigma_u_m"):
                self.assertAlmostEqual(point["properties"][key] / number(row[key]), 1.0, delta=1e-14)
            self.assertEqual("error_u_m" in point["properties"], row["role"] == "check")
            self.assert_on_ellipse(row, ellipse["geometry"]["coordinates"][0],
                                   -2.0 * math.log(0.05))
        states = [row for row in self.paths if row["pass"] == "ASC"]
        self.assertEqual(len(by_type["LineString"][0]["geometry"]["coordinates"]), len(states))

    def test_the_geojson_of_a_result_and_its_export_agree(self):
        out = self.export("geojson", "same.geojson")
        own = json.loads((self.earth / "points.geojson").read_text(encoding="utf-8"))["features"]
        exported = json.loads(out.read_text(encoding="utf-8"))["features"][:len(own)]
        for a, b in zip(own, exported):
            self.assertEqual(a["geometry"]["type"], b["geometry"]["type"])
            self.assertEqual(a["properties"]["point"], b["properties"]["point"])

    def test_ogrinfo_counts_the_features_of_geojson(self):
        out = self.export("geojson", "ogr.geojson", "--no-ellipses")
        said = subprocess.run([tool("ogrinfo"), "-ro", "-so", "-al", out], capture_output=True,
                              text=True, check=True).stdout
        self.assertIn("Feature Count: 52", said)
        self.assertIn("WGS 84", said)

    # KML

    def test_kml_has_a_folder_for_each_role(self):
        root = ElementTree.parse(self.export("kml", "e.kml")).getroot()
        folders = {f.find(KML + "name").text: f.findall(KML + "Placemark")
                   for f in root.iter(KML + "Folder")}
        self.assertEqual({k: len(v) for k, v in folders.items()},
                         {"Control points": 4, "Check points": 6, "Tie points": 40,
                          "Error ellipses": 50, "Flight paths": 2})
        rows = {row["point"]: row for row in self.points}
        styles = {style.get("id") for style in root.iter(KML + "Style")}
        for folder in ("Control points", "Check points", "Tie points"):
            for mark in folders[folder]:
                row = rows[mark.find(KML + "name").text]
                self.assertIn(mark.find(KML + "styleUrl").text[1:], styles)
                data = {d.get("name"): d.find(KML + "value").text
                        for d in mark.iter(KML + "Data")}
                self.assertEqual(data["role"], row["role"])
                self.assertAlmostEqual(float(data["sigma_u_m"]) / number(row["sigma_u_m"]), 1.0,
                                       delta=1e-14)
                lon, lat, h = map(float, mark.find(f"{KML}Point/{KML}coordinates").text.split(","))
                self.assertAlmostEqual(lon, number(row["lon_deg"]), delta=1e-12)
                self.assertAlmostEqual(lat, number(row["lat_deg"]), delta=1e-12)
                self.assertAlmostEqual(h, number(row["h_m"]), delta=1e-9)
        for mark in folders["Error ellipses"]:
            ring = next(mark.iter(KML + "LinearRing")).find(KML + "coordinates").text.split()
            corners = [tuple(map(float, corner.split(",")[:2])) for corner in ring]
            self.assertEqual(corners[0], corners[-1])
            self.assert_on_ellipse(rows[mark.find(KML + "name").text], corners, 1.0)

    def test_xmllint_and_ogrinfo_read_kml(self):
        out = self.export("kml", "ogr.kml")
        subprocess.run([tool("xmllint"), "--noout", out], check=True)
        said = subprocess.run([tool("ogrinfo"), "-ro", "-so", "-al", out], capture_output=True,
                              text=True, check=True).stdout
        self.assertEqual(re.findall(r"Feature Count: (\d+)", said), ["4", "6", "40", "50", "2"])

    # GeoPackage

    def geometry(self, blob, system):
        magic, version, flags, srs = struct.unpack("<2sBBi", blob[:8])
        self.assertEqual((magic, version, flags & 0x0f, srs), (b"GP", 0, 1, system))
        order, kind = struct.unpack("<BI", blob[8:13])
        self.assertEqual(order, 1)
        return kind, blob[13:]

    def read_geopackage(self, out, system):
        with sqlite3.connect(out) as database:
            self.assertEqual(database.execute("PRAGMA integrity_check").fetchone(), ("ok",))
            self.assertEqual(database.execute("PRAGMA foreign_key_check").fetchall(), [])
            self.assertEqual(database.execute("PRAGMA application_id").fetchone(), (0x47504B47,))
            columns = database.execute("SELECT table_name, geometry_type_name, srs_id, z FROM "
                                       "gpkg_geometry_columns ORDER BY table_name").fetchall()
            self.assertEqual(columns, [("ellipses", "POLYGON", system, 0),
                                       ("flight_paths", "LINESTRING", system, 1),
                                       ("points", "POINT", system, 1)])
            database.row_factory = sqlite3.Row
            return {name: database.execute(f"SELECT * FROM {name}").fetchall()
                    for name in ("points", "ellipses", "flight_paths")}

    def test_a_geopackage_holds_three_layers_of_plain_sqlite(self):
        layers = self.read_geopackage(self.export("gpkg", "e.gpkg"), 4326)
        self.assertEqual(len(layers["points"]), 50)
        for row, feature, ellipse in zip(self.points, layers["points"], layers["ellipses"]):
            kind, rest = self.geometry(feature["geom"], 4326)
            self.assertEqual(kind, 1001)
            lon, lat, h = struct.unpack("<3d", rest)
            self.assertAlmostEqual(lon, number(row["lon_deg"]), delta=1e-12)
            self.assertAlmostEqual(lat, number(row["lat_deg"]), delta=1e-12)
            self.assertAlmostEqual(h, number(row["h_m"]), delta=1e-9)
            self.assertEqual((feature["point"], feature["role"], feature["status"]),
                             (row["point"], row["role"], row["status"]))
            self.assertEqual(feature["cov_eu_m2"], number(row["cov_eu_m2"]))
            self.assertEqual(feature["error_n_m"] is None, row["role"] != "check")
            kind, rest = self.geometry(ellipse["geom"], 4326)
            self.assertEqual((kind, *struct.unpack("<2I", rest[:8])), (3, 1, 37))
            flat = struct.unpack("<74d", rest[8:])
            self.assert_on_ellipse(row, list(zip(flat[::2], flat[1::2])), 1.0)
            self.assertAlmostEqual(ellipse["confidence"], 0.3934693402873666, delta=1e-15)

    def test_a_geopackage_holds_a_local_frame_too(self):
        layers = self.read_geopackage(self.export("gpkg", "l.gpkg", result=self.local), -1)
        for row, feature in zip(table(self.local / "points.csv"), layers["points"]):
            _, rest = self.geometry(feature["geom"], -1)
            self.assertEqual(struct.unpack("<3d", rest),
                             tuple(number(row[k]) for k in ("x_m", "y_m", "z_m")))
        states = table(self.local / "trajectories.csv")
        for feature in layers["flight_paths"]:
            own = [row for row in states if row["pass"] == feature["pass"]]
            kind, rest = self.geometry(feature["geom"], -1)
            self.assertEqual((kind, *struct.unpack("<I", rest[:4])), (1002, len(own)))
            self.assertEqual(struct.unpack("<3d", rest[4:28]),
                             tuple(number(own[0][k]) for k in ("x_m", "y_m", "z_m")))

    def test_ogr2ogr_reads_a_geopackage_back_equal(self):
        out = self.export("gpkg", "ogr.gpkg")
        said = subprocess.run([tool("ogr2ogr"), "-f", "CSV", "/vsistdout/", out, "points", "-lco",
                               "GEOMETRY=AS_XYZ"], capture_output=True, text=True, check=True)
        self.assertEqual(said.stderr, "")
        rows = list(csv.DictReader(said.stdout.splitlines()))
        self.assertEqual(len(rows), len(self.points))
        for row, read in zip(self.points, rows):
            self.assertEqual(read["point"], row["point"])
            for key, name in (("X", "lon_deg"), ("Y", "lat_deg"), ("Z", "h_m")):
                self.assertAlmostEqual(float(read[key]), number(row[name]), delta=1e-9)
            self.assertAlmostEqual(float(read["sigma_u_m"]) / number(row["sigma_u_m"]), 1.0,
                                   delta=1e-12)
        said = subprocess.run([tool("ogrinfo"), "-ro", "-so", "-al", out], capture_output=True,
                              text=True, check=True).stdout
        self.assertEqual(re.findall(r"Geometry: (.*)", said),
                         ["3D Point", "Polygon", "3D Line String"])

    # ISIS

    def test_isis_points_are_planetocentric_in_the_columns_of_jigsaw(self):
        out = self.export("isis", "isis")
        with open(out / "bundleout_points.csv", encoding="utf-8", newline="") as stream:
            rows = list(csv.reader(stream))
        self.assertEqual(rows[1][5:8], ["Latitude", "Longitude", "Radius"])
        self.assertEqual(rows[2][8:11], ["(m)"] * 3)
        self.assertEqual({len(row) for row in rows}, {17})
        self.assertEqual(len(rows), 53)
        given = {row["point"]: row for row in table(self.folder / "block" / "points.csv")}
        for row, isis in zip(self.points, rows[3:]):
            self.assertEqual(isis[0], row["point"])
            self.assertEqual(isis[1], "CONSTRAINED" if row["role"] == "control" else "FREE")
            self.assertEqual(isis[2:4], ["2", "0"])
            lat, lon = math.radians(float(isis[5])), math.radians(float(isis[6]))
            turn = axes(lat, lon)
            xyz = [number(row[k]) for k in ("x_m", "y_m", "z_m")]
            for k in range(3):
                self.assertAlmostEqual(1e3 * float(isis[7]) * turn[2][k], xyz[k], delta=1e-8)
                self.assertAlmostEqual(1e3 * float(isis[14 + k]), xyz[k], delta=1e-8)
            c = multiply(turn, multiply(in_frame(row, enu_covariance(row)), transposed(turn)))
            for column, k in ((8, 1), (9, 0), (10, 2)):  # latitude, longitude, radius
                self.assertAlmostEqual(float(isis[column]) / math.sqrt(c[k][k]), 1.0, delta=1e-9)
            if row["role"] == "control":
                # The scene's control stands as x, y, z; to 1e-6 m the axes of both places agree.
                moved = [x - number(given[row["point"]][k])
                         for x, k in zip(xyz, ("x_m", "y_m", "z_m"))]
                for column, k in ((11, 1), (12, 0), (13, 2)):
                    expected = sum(a * b for a, b in zip(turn[k], moved))
                    self.assertAlmostEqual(float(isis[column]), expected, delta=1e-6)
            else:
                self.assertEqual(isis[11:14], ["", "", ""])

    def test_isis_residuals_are_measured_minus_computed_from_pixel_one(self):
        out = self.export("isis", "isis2")
        rows = below(out / "residuals.csv", 3)
        own = table(self.earth / "residuals.csv")
        squares = {}
        self.assertEqual(len(rows), len(own))
        for row, isis in zip(own, rows):
            self.assertEqual(isis[:3], [row["point"], row["pass"], row["pass"]])
            self.assertEqual(isis[3:5], ["", ""])
            self.assertEqual(float(isis[5]), number(row["pixel"]) + 1.0)
            self.assertEqual(float(isis[6]), number(row["line"]) + 1.0)
            self.assertEqual(float(isis[7]), -number(row["pixel_residual_px"]))
            self.assertEqual(float(isis[8]), -number(row["line_residual_px"]))
            self.assertAlmostEqual(float(isis[9]), math.hypot(float(isis[7]), float(isis[8])))
            # The raster of this test: 2.5 m a pixel.
            self.assertAlmostEqual(float(isis[7]), -number(row["range_residual_m"]) / 2.5,
                                   delta=1e-12)
            squares.setdefault(row["point"], []).append(float(isis[9]) ** 2)
        for isis in below(out / "bundleout_points.csv", 3):
            mean = sum(squares[isis[0]]) / len(squares[isis[0]])
            self.assertAlmostEqual(float(isis[4]), math.sqrt(mean), delta=1e-12)

    # SINEX

    def sinex_with(self, *options):
        out = self.export("sinex", "e.snx", *options)
        sites = {row["point"]: row["code"] for row in table(self.folder / "e.sites.csv")}
        return check_sinex.read_sinex(out), sites, out

    def block_of(self, read, a, b):
        i, j = read["index"][a.ljust(4), "STAX"], read["index"][b.ljust(4), "STAX"]
        return [row[j:j + 3] for row in read["matrix"][i:i + 3]]

    def assert_blocks_equal(self, a, b, delta):
        size = math.sqrt(sum(x * x for row in b for x in row))
        for row_a, row_b in zip(a, b):
            for x, y in zip(row_a, row_b):
                self.assertAlmostEqual(x / size, y / size, delta=delta)

    def test_sinex_holds_estimates_and_the_covariance_of_every_pair(self):
        read, sites, _ = self.sinex_with()
        own, rows = {}, {row["point"]: row for row in self.points}
        self.assertEqual(len(sites), len(rows))
        for point, row in rows.items():
            code = sites[point].ljust(4)
            for key in "xyz":
                value = read["values"][read["index"][code, "STA" + key.upper()]]
                self.assertAlmostEqual(value, number(row[key + "_m"]), delta=1e-7)  # 15 digits
            own[point] = self.block_of(read, code, code)
            self.assert_blocks_equal(own[point], in_frame(row, enu_covariance(row)), 1e-12)
        pairs = table(self.earth / "pairs.csv")
        self.assertEqual(len(pairs), 50 * 49 // 2)
        for pair in pairs:
            a, b = pair["point_a"], pair["point_b"]
            cross = self.block_of(read, sites[a].ljust(4), sites[b].ljust(4))
            found = [[x + y - c - d for x, y, c, d in zip(*rows4)]
                     for rows4 in zip(own[a], own[b], cross, transposed(cross))]
            c = {k: number(pair[f"cov_{k}_m2"]) for k in ("ee", "nn", "uu", "en", "eu", "nu")}
            given = in_frame(rows[a], [[c["ee"], c["en"], c["eu"]], [c["en"], c["nn"], c["nu"]],
                                       [c["eu"], c["nu"], c["uu"]]])
            self.assert_blocks_equal(found, given, 1e-11)

    def test_sinex_times_and_sites(self):
        _, _, out = self.sinex_with("--agency", "ABC")
        lines = out.read_text(encoding="ascii").split("\n")
        self.assertRegex(lines[0], r"^%=SNX 2\.02 ABC \d\d:\d{3}:\d{5} ABC ")
        # Strips from 0 to 17.7 s after 23:59:50 on the 366th day of 2016, whose last second is a leap.
        self.assertEqual(lines[0].split()[5:7], ["16:366:86390", "17:001:00006"])

    def test_sinex_without_cross_covariances_is_block_diagonal(self):
        read, _, _ = self.sinex_with("--no-cross")
        for i, row in enumerate(read["matrix"]):
            for j, value in enumerate(row):
                self.assertTrue(i // 3 == j // 3 or value == 0.0)

    def test_the_sinex_checker_finds_what_is_wrong(self):
        _, _, out = self.sinex_with("--no-cross")
        text = out.read_text(encoding="ascii")
        for find, put in ((r"%=SNX 2.02", "%=SNX 2.0"), (r"%ENDSNX\n", ""), (r" STAY ", " STAX "),
                          (r"(\n     2     1 ).\d(.*?E)...", r"\g<1> 9\g<2>+05"),
                          (r"\n     3     1 .*", ""), (r"-SITE/ID\n", "")):
            broken = self.folder / "broken.snx"
            changed = re.sub(find, put, text, count=1)
            self.assertNotEqual(changed, text)
            broken.write_text(changed, encoding="ascii")
            with self.assertRaises((check_sinex.SinexError, ZeroDivisionError), msg=find):
                check_sinex.read_sinex(broken)

    def test_sinex_is_refused_where_it_would_mislead(self):
        said = self.export("sinex", "x.snx", result=self.local, code=3)
        self.assertIn("the frame of this result is local", said)
        bare = self.folder / "bare"
        run("adjust", self.folder / "block", "-o", bare, "--set", "covariance=none")
        self.assertIn("has none (covariance = \"none\")",
                      self.export("sinex", "x.snx", result=bare, code=3))
        self.assertIn("three letters or digits", self.export("sinex", "x.snx", "--agency", "A", code=3))
        self.assertFalse((self.folder / "x.snx").exists())

    def test_pairs_that_leave_gaps_are_refused_or_definite(self):
        some = self.folder / "some"
        run("adjust", self.folder / "block", "-o", some, "--set", "pairs=neighbours")
        done = subprocess.run([PROGRAM, "export", some, "--format", "sinex", "-o",
                               self.folder / "some.snx"], capture_output=True, text=True, check=False)
        if done.returncode == 3:
            self.assertIn("not positive definite, because those of the other pairs", done.stderr)
        else:
            self.assertEqual(done.returncode, 0)
            check_sinex.read_sinex(self.folder / "some.snx")

    # Orbit files

    def states_of(self, file):
        root = ElementTree.parse(file).getroot()
        header = root.find("Earth_Explorer_Header")
        self.assertEqual(header.find("Variable_Header/Ref_Frame").text, "EARTH_FIXED")
        osvs = root.find("Data_Block/List_of_OSVs")
        self.assertEqual(int(osvs.get("count")), len(osvs))
        return header.find("Fixed_Header/Mission").text, list(osvs)

    def test_orbit_files_hold_the_states_across_a_leap_second(self):
        out = self.export("eof", "eof", "--mission", "Sentinel-1A")
        self.assertEqual(sorted(f.name for f in out.iterdir()), ["ASC.EOF", "DSC.EOF"])
        seen = set()
        for name in ("ASC", "DSC"):
            mission, osvs = self.states_of(out / f"{name}.EOF")
            self.assertEqual(mission, "Sentinel-1A")
            own = [row for row in self.paths if row["pass"] == name]
            self.assertEqual(len(own), len(osvs))
            for row, osv in zip(own, osvs):
                utc = re.fullmatch(r"UTC=(\d{4})-(\d\d)-(\d\d)T(\d\d):(\d\d):(\d\d\.\d{6})",
                                   osv.find("UTC").text)
                day = utc.group(1, 2, 3)
                second = 3600 * int(utc.group(4)) + 60 * int(utc.group(5)) + float(utc.group(6))
                # 2016-12-31 has 86401 seconds; the epoch is second 86390.
                since = second - 86390 + (86401 if day == ("2017", "01", "01") else 0)
                seen.add(day)
                self.assertIn(day, (("2016", "12", "31"), ("2017", "01", "01")))
                self.assertAlmostEqual(since, number(row["time_s"]), delta=1.01e-6)
                tai = osv.find("TAI").text[-9:]
                offset = float(tai) - float(utc.group(6))
                self.assertAlmostEqual(offset % 60, 36.0 if day[0] == "2016" else 37.0, delta=1e-6)
                speed = 7600.0 * abs(since - number(row["time_s"])) + 1e-9
                for key in "xyz":
                    self.assertAlmostEqual(float(osv.find(key.upper()).text), number(row[key + "_m"]),
                                           delta=speed)
                    self.assertAlmostEqual(float(osv.find("V" + key.upper()).text),
                                           number(row[f"v{key}_mps"]), delta=1e-5)
        self.assertEqual(len(seen), 2)
        subprocess.run([tool("xmllint"), "--noout", out / "ASC.EOF"], check=True)

    def test_orbit_files_need_utc_and_the_earth(self):
        self.assertIn("--mission names it", self.export("eof", "no", code=3))
        self.assertIn("the frame of this result is local",
                      self.export("eof", "no", result=self.local, code=3))
        make_block(self.folder / "timeless", "earth-asc-desc.toml", str)
        run("adjust", self.folder / "timeless", "-o", self.folder / "timeless-result")
        said = self.export("eof", "no", "--mission", "Sentinel-1A",
                           result=self.folder / "timeless-result", code=3)
        self.assertIn("has no epoch for its time_s = 0", said)
        self.assertFalse((self.folder / "no").exists())

    def test_orbit_files_of_real_products_come_back_through_the_import(self):
        if not SENTINEL1.is_dir():
            self.skipTest(f"no {SENTINEL1}")
        products = sorted(SENTINEL1.glob("s1a-iw2-slc-vv-*.xml"))
        run("import", "sentinel1", *products, "-o", self.folder / "la", "--grid", "control",
            "--grid-sigma-m", "0.01", "--set", "correction.time.bias=true")
        run("adjust", self.folder / "la", "-o", self.folder / "la-result")
        out = self.export("eof", "la-eof", result=self.folder / "la-result")
        run("import", "sentinel1", *products, "-o", self.folder / "again", "--orbit",
            *sorted(out.iterdir()), "--orbit-step-s", "0")
        again = {(row["pass"], round(number(row["time_s"]), 6)): row
                 for row in table(self.folder / "again" / "trajectories.csv")}
        found = 0
        for row in table(self.folder / "la-result" / "trajectories.csv"):
            # A time bias puts the states between microseconds: the path there, 4 mm away at most.
            read = again.get((row["pass"], round(number(row["time_s"]), 6)))
            if read is None:
                continue
            found += 1
            apart = 7600.0 * abs(number(read["time_s"]) - number(row["time_s"])) + 1e-6
            self.assertLess(apart, 5e-3)
            for key in "xyz":
                self.assertAlmostEqual(number(read[key + "_m"]), number(row[key + "_m"]), delta=apart)
        self.assertGreater(found, 200)

    # All

    def test_the_default_place_is_the_folder_of_the_result(self):
        said = json.loads(run("export", self.earth, "--format", "kml", "--json").stdout)
        self.assertEqual(said["files"], [str(self.earth / "export.kml")])
        self.assertEqual((said["points"], said["ellipses"], said["paths"]), (50, 50, 2))

    def test_a_fault_of_a_result_has_one_message_in_export_report_and_comparison(self):
        for file, old, new, message in (
                ("points.csv", ",tie,", ",tye,", "role: 'tye' is not known"),
                ("points.csv", "sigma_u_m", "sigma_up_m", "sigma_u_m: the column is missing"),
                ("points.csv", ",adjusted,", ",adjuster,", "status: 'adjuster' is not known"),
                ("passes.csv", "prior_sigma", "prior", "prior_sigma: the column is missing"),
                ("summary.json", '"verdict": "', '"verdict": 1, "was": "', "verdict: is number"),
                ("summary.json", '"frame"', '"fame"', "has no frame")):
            with self.subTest(file=file, fault=new):
                bad = self.folder / "bad"
                shutil.rmtree(bad, ignore_errors=True)
                shutil.copytree(self.earth, bad)
                text = (bad / file).read_text(encoding="utf-8")
                self.assertIn(old, text)
                (bad / file).write_text(text.replace(old, new), encoding="utf-8")
                reported = {run("export", bad, "--format", "kml", code=3).stderr,
                            run("report", bad, code=3).stderr,
                            run("report", self.earth, bad, "-o", self.folder / "c.html", code=3).stderr,
                            run("report", bad, self.earth, "-o", self.folder / "c.html", code=3).stderr}
                self.assertEqual(len(reported), 1, reported)
                self.assertIn(message, reported.pop())

    def test_wrong_use_has_its_exit_codes(self):
        run("export", self.earth, code=2)
        run("export", self.earth, "--format", "shapefile", code=2)
        run("export", self.earth, "--format", "kml", "--confidence", "100", code=2)
        self.assertIn("does not exist; a result is a folder",
                      self.export("kml", "x.kml", result=self.folder / "none", code=3))
        self.assertIn("needs a place on a body",
                      self.export("geojson", "x.geojson", result=self.local, code=3))


if __name__ == "__main__":
    unittest.main(verbosity=2)
