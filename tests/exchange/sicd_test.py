#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""SICD images with the offsets of an adjustment; run by ctest.

Environment: SARBLOCK_PROGRAM, SARBLOCK_SHARED_DATA. Two made-up images of range and zero-Doppler time whose
paths and ranges are off by known amounts. Evidence: the equations of NGA.STND.0024-3 written out here, the
round trip through `import`, covariances by dense algebra, and the schema of version 1.4.0 by xmllint with
real files, where these are beside the project."""
import json
import math
import os
import pathlib
import random
import re
import shutil
import subprocess
import sys
import unittest
import xml.etree.ElementTree as ElementTree

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "truth"))
from measured_images import MeasuredImages, congruence, table, write_table  # noqa: E402
from usgscsm_points import combine, dot, unit  # noqa: E402

SICD = pathlib.Path(os.environ["SARBLOCK_SHARED_DATA"]) / "sicd"
C = 299792458.0
ROWS, COLUMNS, ROW_M, COLUMN_M, FIRST_ROW, FIRST_COLUMN, SCP_ROW, SCP_COLUMN = 2400, 3000, 2.0, 1.5, 10, 20, 1210, 1520
CLOSEST = (2.1, 1.4e-4)  # TimeCAPoly
DURATION = 4.0


def evaluate(polynomial, t):
    return sum(c * t ** k for k, c in enumerate(polynomial))


class Image:
    """An antenna on a parabola, ARPPoly; `errors` are what the file does not know."""

    def __init__(self, name, start, velocity, errors):
        self.name, self.errors = name, errors
        # Down by 8 m/s2 towards the Earth's centre, as in an orbit.
        down = unit(start)
        self.path = [[start[k] - CLOSEST[0] * velocity[k] - 4.0 * CLOSEST[0] ** 2 * down[k],
                      velocity[k] + 8.0 * CLOSEST[0] * down[k], -4.0 * down[k]] for k in range(3)]
        self.scp = [6371000.0, 0.0, 0.0]  # at right angles to the flight, to the right
        self.closest_range = math.sqrt(dot(*[combine((1, start), (-1, self.scp))] * 2))

    def motion(self, t, offsets=None):
        s, v = ([evaluate(c, t) for c in self.path],
                [sum(k * c * t ** (k - 1) for k, c in enumerate(axis) if k) for axis in self.path])
        if offsets:
            s = combine((1, s), (1, offsets["position"]), (t - CLOSEST[0], offsets["velocity"]))
            v = combine((1, v), (1, offsets["velocity"]))
        return s, v

    def see(self, point):
        """Row and column in the file."""
        low, high = -1.0, 6.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            s, v = self.motion(middle, self.errors)
            if dot(combine((1, point), (-1, s)), v) > 0.0:
                low = middle
            else:
                high = middle
        d = combine((1, point), (-1, self.motion(low, self.errors)[0]))
        x = math.sqrt(dot(d, d)) + self.errors["range"] - self.closest_range
        y = (low - CLOSEST[0]) / CLOSEST[1]
        return x / ROW_M + SCP_ROW - FIRST_ROW, y / COLUMN_M + SCP_COLUMN - FIRST_COLUMN

    def xml(self, extra="", version="1.3.0", type_="MONOSTATIC", position=""):
        def coefficients(c, two=False):
            return "".join(f'<Coef exponent1="{0 if two else k}"{f" exponent2={chr(34)}{k}{chr(34)}" if two else ""}>'
                           f"{value!r}</Coef>" for k, value in enumerate(c))

        def vector(v):
            return "".join(f"<{axis}>{value!r}</{axis}>" for axis, value in zip("XYZ", v))
        path = "".join(f'<{axis} order1="2">{coefficients(c)}</{axis}>' for axis, c in zip("XYZ", self.path))
        time = coefficients(CLOSEST)
        return f"""<?xml version="1.0"?>
<SICD xmlns="urn:SICD:{version}">
  <!-- made up -->
  <CollectionInfo><CoreName>{self.name}</CoreName><CollectType>{type_}</CollectType></CollectionInfo>
  <ImageData><NumRows>{ROWS}</NumRows><NumCols>{COLUMNS}</NumCols><FirstRow>{FIRST_ROW}</FirstRow>
    <FirstCol>{FIRST_COLUMN}</FirstCol><SCPPixel><Row>{SCP_ROW}</Row><Col>{SCP_COLUMN}</Col></SCPPixel></ImageData>
  <GeoData><SCP><ECF>{vector(self.scp)}</ECF></SCP>{extra}</GeoData>
  <Grid><Type>RGZERO</Type><TimeCOAPoly order1="0" order2="1">{coefficients(CLOSEST, True)}</TimeCOAPoly>
    <Row><SS>{ROW_M}</SS></Row><Col><SS>{COLUMN_M}</SS></Col></Grid>
  <Timeline><CollectStart>2021-05-04T03:02:01.250000Z</CollectStart><CollectDuration>{DURATION}</CollectDuration></Timeline>
  <Position><ARPPoly>{path}</ARPPoly>{position}</Position>
  <SCPCOA><SCPTime>{CLOSEST[0]}</SCPTime><SideOfTrack>R</SideOfTrack></SCPCOA>
  <Vendor quality="good">keeps &amp; its <b>own</b>
    words</Vendor>
  <RMA><ImageType>INCA</ImageType><INCA><TimeCAPoly order1="1">{time}</TimeCAPoly>
    <R_CA_SCP>{self.closest_range!r}</R_CA_SCP><FreqZero>9.6e9</FreqZero>
    <DRateSFPoly order1="0" order2="0"><Coef exponent1="0" exponent2="0">1</Coef></DRateSFPoly></INCA></RMA>
</SICD>
"""


IMAGES = {
    "one": Image("one", [6860000.0, -330000.0, 0.0], [0.0, 0.0, 7500.0],
                 {"position": [4.3, -2.5, 6.1], "velocity": [0.031, -0.042, 0.027], "range": 3.7}),
    "two": Image("two", [6861000.0, 0.0, 330000.0], [0.0, 7500.0, 0.0],
                 {"position": [-3.1, 5.5, 1.8], "velocity": [-0.022, 0.017, 0.039], "range": -2.9})}
DRIFT = ("correction.position.degree=1", "correction.position.axes=frame",
         "correction.position.sigma_m=[[20,0.5],[20,0.5],[20,0.5]]", "correction.range.bias_sigma_m=10")
APO = "ErrorStatistics/AdjustableParameterOffsets"


def offsets_of(path):
    root = ElementTree.parse(path).getroot()
    space = {"": root.tag[1:root.tag.index("}")]}
    given = root.find(APO, space)

    def vector(name):
        return [float(given.find(f"{name}/{axis}", space).text) for axis in "XYZ"]
    found = {"position": vector("ARPPosSCPCOA"), "velocity": vector("ARPVel"),
             "range": 0.5 * C * (float(given.find("RcvTimeSCPCOA", space).text) -
                                 float(given.find("TxTimeSCPCOA", space).text))}
    if given.find("APOError", space) is not None:
        found["covariance"] = [[0.0] * 8 for _ in range(8)]
        for entry in given.findall("APOError/Entry", space):
            found["covariance"][int(entry.get("index1")) - 1][int(entry.get("index2")) - 1] = float(entry.text)
        found["composite"] = [float(given.find(f"CompositeSCP/{name}", space).text) for name in ("Rg", "Az", "RgAz")]
    return found


class Offsets(MeasuredImages):
    form, ending = "sicd", ".xml"
    SIGMAS = ("--range-sigma-m", 0.5, "--azimuth-sigma-m", 0.5)

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        draw = random.Random(11)
        cls.files = {}
        for name, image in IMAGES.items():
            cls.files[name] = cls.folder / f"{name}.xml"
            cls.files[name].write_text(image.xml(), encoding="utf-8")
        cls.points, cls.matches = {}, []
        for _ in range(50):
            d = unit([6371000.0, draw.uniform(-1500, 1500), draw.uniform(-1500, 1500)])
            point = combine((6371000.0 + draw.uniform(-200, 200), d))
            places = {name: image.see(point) for name, image in IMAGES.items()}
            assert all(0 < row < ROWS - 1 and 0 < column < COLUMNS - 1 for row, column in places.values()), places
            name = f"P{len(cls.points)}"
            cls.points[name] = point
            cls.matches += [{"point": name, "image": image, "line": row + draw.gauss(0, 0.2),
                             "sample": column + draw.gauss(0, 0.2)} for image, (row, column) in places.items()]
        write_table(cls.folder / "matches.csv", cls.matches)

    def strip(self, result, image):
        summary = json.loads((result / "summary.json").read_text(encoding="utf-8"))
        entry = next(entry for entry in summary["passes"] if entry["id"] == image)
        # The epoch is the whole second before the earliest column, 0.25 s or 1.25 s before the start.
        first = min(evaluate(CLOSEST, (column + FIRST_COLUMN - SCP_COLUMN) * COLUMN_M) for column in (0, COLUMNS - 1))
        shift = (0.25 + first) - math.floor(0.25 + first) - first
        return entry["start_s"] - shift, entry["end_s"] - shift

    def test_offset_and_drift_are_those_of_the_result_and_the_round_trip_holds(self):
        result = self.adjust(self.make_block("block", self.files, *self.SIGMAS), "result", *DRIFT)
        images, report = self.export(result, "out", self.files)
        self.assertEqual([text for text in report["not_carried"] if text.startswith(("one", "two"))], [])
        self.assertEqual(len(report["warnings"]), 2)
        for name in IMAGES:
            found, values = offsets_of(images[name]), self.parameters(result, name)
            start, end = self.strip(result, name)
            half, middle = 0.5 * (end - start), 0.5 * (start + end)
            for k, axis in enumerate("xyz"):
                c0, c1 = (values[f"position.{axis}.{degree}"] for degree in (0, 1))
                self.assertAlmostEqual(found["position"][k], c0 + c1 * (CLOSEST[0] - middle) / half, 7)
                self.assertAlmostEqual(found["velocity"][k], c1 / half, 7)
            self.assertAlmostEqual(found["range"], -values["range.bias"], 10)
        self.assert_round_trip(result, images, *self.SIGMAS)
        # Without the offsets the looks are metres off.
        result = self.adjust(self.make_block("plain", self.files, *self.SIGMAS), "plain-result", *DRIFT)
        self.assertGreater(min(self.residuals(self.hold(result, self.files, *self.SIGMAS, code=1))), 2.0)

    def test_the_standards_own_equations_see_the_adjusted_points(self):
        result = self.adjust(self.make_block("own", self.files, *self.SIGMAS), "own-result", *DRIFT)
        images, _ = self.export(result, "own-out", self.files)
        rows = self.rows_of(result)
        points = self.adjusted(result)
        for match in self.matches:
            image, offsets = IMAGES[match["image"]], offsets_of(images[match["image"]])
            x = (match["line"] + FIRST_ROW - SCP_ROW) * ROW_M
            y = (match["sample"] + FIRST_COLUMN - SCP_COLUMN) * COLUMN_M
            t = evaluate(CLOSEST, y)  # of the aperture's centre too: the range rate there is 0
            s, v = image.motion(t, offsets)
            d = combine((1, points[match["point"]]), (-1, s))
            row = rows[match["point"], match["image"]]
            distance = math.sqrt(dot(d, d))
            seen = distance - (image.closest_range + x + offsets["range"])
            # At the time of the look; the result holds the range where the cone holds the point.
            self.assertAlmostEqual(seen, float(row["range_residual_m"]), 6)
            self.assertAlmostEqual(dot(d, v) / math.sqrt(dot(v, v)), float(row["azimuth_residual_m"]), 3)

    def test_covariance_and_composite_error_are_those_of_dense_algebra(self):
        result = self.adjust(self.make_block("cov", self.files, *self.SIGMAS), "cov-result", *DRIFT)
        images, _ = self.export(result, "cov-out", self.files)
        names = [f"position.{axis}.{k}" for axis in "xyz" for k in (0, 1)] + ["range.bias"]
        for name, image in IMAGES.items():
            start, end = self.strip(result, name)
            half, middle = 0.5 * (end - start), 0.5 * (start + end)
            gain = [[0.0] * 7 for _ in range(8)]
            for k in range(3):
                gain[k][2 * k], gain[k][2 * k + 1] = 1.0, (CLOSEST[0] - middle) / half
                gain[k + 3][2 * k + 1] = 1.0 / half
            gain[7][6] = -2.0 / C
            expected = congruence(gain, self.covariance(result, name, names))
            found = offsets_of(images[name])
            self.assert_matrix(found["covariance"], expected, 1e-9)
            # At the scene centre, which lies at right angles to the right: the slant plane's second axis
            # is against the flight.
            s, v = image.motion(CLOSEST[0], found)
            u = unit(combine((1, s), (-1, image.scp)))
            distance = math.sqrt(dot(*[combine((1, s), (-1, image.scp))] * 2))
            across = combine((1, v), (-dot(v, u), u))
            scale = -distance / math.sqrt(dot(across, across))
            partials = [[-x for x in u] + [0.0] * 3 + [-C / 2, C / 2],
                        [-scale * x / distance for x in across] + [-scale * x for x in u] + [0.0, 0.0]]
            plane = congruence(partials, expected)
            range_, azimuth, correlation = found["composite"]
            self.assertAlmostEqual(range_, math.sqrt(plane[0][0]), 7)
            self.assertAlmostEqual(azimuth, math.sqrt(plane[1][1]), 7)
            self.assertAlmostEqual(correlation, plane[0][1] / (range_ * azimuth), 6)

    def test_time_biases_and_track_axes_go_into_offset_and_drift_and_the_rest_is_reported(self):
        result = self.adjust(self.make_block("track", self.files, *self.SIGMAS), "track-result", "correction.position.degree=1",
                             "correction.position.sigma_m=[[20,0.5],[20,0.5],[20,0.5]]",
                             "correction.time.bias_sigma_s=0.001", "correction.range.bias_sigma_m=10")
        images, report = self.export(result, "track-out", self.files)
        held = self.hold(result, images, *self.SIGMAS)
        # Axes that turn make of an offset a velocity that is not constant: 80 s of it count along the track.
        reported = {text[:3]: float(re.search(r"up to (\S+) m", text).group(1)) for text in report["not_carried"]
                    if "of the path from an offset and a drift" in text}
        rows = [self.rows_of(folder) for folder in (result, held)]
        for name in IMAGES:
            apart = [max(abs(float(rows[0][key][axis]) - float(rows[1][key][axis])) for key in rows[0] if key[1] == name)
                     for axis in ("range_residual_m", "azimuth_residual_m")]
            self.assertLess(apart[0], 1e-4)
            self.assertLess(apart[1], reported[name])
            self.assertGreater(apart[1], 0.2 * reported[name])
            self.assertLess(reported[name], 0.05)

    def test_offsets_of_the_file_are_replaced_by_their_sum_with_the_result(self):
        result = self.adjust(self.make_block("first", self.files, *self.SIGMAS), "first-result", *DRIFT)
        images, _ = self.export(result, "first-out", self.files)
        again = self.make_block("second", images, *self.SIGMAS)
        second = self.adjust(again, "second-result", *DRIFT)
        twice, report = self.export(second, "second-out", images)
        self.assertEqual(report["warnings"], [])
        for name in IMAGES:
            a, b = offsets_of(images[name]), offsets_of(twice[name])
            values = self.parameters(second, name)
            self.assertAlmostEqual(b["range"], a["range"] - values["range.bias"], 9)
            text = twice[name].read_text(encoding="utf-8")
            self.assertEqual(text.count("<AdjustableParameterOffsets>"), 1)
            self.assertEqual(text.count("written by sarblock"), 1)

    def test_all_else_of_the_file_stays_as_it_is(self):
        result = self.adjust(self.make_block("same", self.files, *self.SIGMAS), "same-result", *DRIFT)
        images, _ = self.export(result, "same-out", self.files)
        text = images["one"].read_text(encoding="utf-8")
        plain = re.sub(r"<ErrorStatistics>.*</ErrorStatistics>", "", text)
        plain = re.sub(r"<!-- written by sarblock \S+ -->", "", plain).replace("urn:SICD:1.4.0", "urn:SICD:1.3.0")
        given = self.files["one"].read_text(encoding="utf-8")
        self.assertEqual(re.sub(r">\s+<", "><", plain).strip(), re.sub(r">\s+<", "><", given).strip())
        self.assertIn(">keeps &amp; its <b>own</b>\n    words</Vendor>\n", text)
        # The order of the schema.
        inner = re.search(r"<ErrorStatistics>(.*)</ErrorStatistics><RMA>", text)
        self.assertIsNotNone(inner)
        names = [child.tag for child in ElementTree.fromstring(inner.group(1))]
        self.assertEqual(names, ["ARPPosSCPCOA", "ARPVel", "TxTimeSCPCOA", "RcvTimeSCPCOA", "APOError", "CompositeSCP"])

    def test_statistics_of_the_file_come_before_the_offsets(self):
        file = self.folder / "statistics.xml"
        statistics = "<ErrorStatistics><CompositeSCP><Rg>1</Rg><Az>2</Az><RgAz>0</RgAz></CompositeSCP></ErrorStatistics>"
        file.write_text(IMAGES["one"].xml().replace("  <RMA>", f"  {statistics}\n  <MatchInfo/><RMA>"), encoding="utf-8")
        images = {"one": file, "two": self.files["two"]}
        result = self.adjust(self.make_block("stats", images, *self.SIGMAS), "stats-result", *DRIFT)
        text = self.export(result, "stats-out", images)[0]["one"].read_text(encoding="utf-8")
        self.assertRegex(text, r"<RgAz>0</RgAz></CompositeSCP><AdjustableParameterOffsets>.*</ErrorStatistics>\s*<MatchInfo")

    def test_what_offsets_cannot_hold_is_refused_by_name(self):
        block = self.make_block("refuse", self.files, *self.SIGMAS)
        for number, (settings, named) in enumerate((
                (("correction.position.degree=2",), "has position.along.2, position.across.2, position.up.2 besides"),
                (("correction.position.basis=spline", "correction.position.knot_spacing_s=2"), "has position (spline)"),
                (("correction.range.scale_sigma_ppm=5", "correction.squint.bias_sigma_deg=0.01"),
                 "has range.scale, squint.bias besides"))):
            if "position" in settings[0]:
                settings += ("correction.position.sigma_m=[5,5,5]",)
            result = self.adjust(block, f"refuse-{number}", *settings)
            message = self.export(result, f"refuse-out-{number}", self.files, code=3)
            self.assertIn(named, message)
            self.assertFalse((self.folder / f"refuse-out-{number}").exists())

    def test_versions_before_1_0_and_files_of_others_are_refused(self):
        result = self.adjust(self.make_block("old", self.files, *self.SIGMAS), "old-result", *DRIFT)
        old = self.folder / "old.xml"
        old.write_text(IMAGES["one"].xml(version="0.4.0"), encoding="utf-8")
        self.assertIn("old.xml:2: SICD: its namespace xmlns is 'urn:SICD:0.4.0', urn:SICD:1.0.0 or later is needed",
                      self.export(result, "old-out", {"one": old}, code=3))
        self.assertIn("is not the image of pass 'one'", self.export(result, "old-out", {"one": self.files["two"]}, code=3))

    def test_looks_that_the_aperture_sees_otherwise_are_reported_with_the_size(self):
        """The aperture's centre half a second after closest approach: a drift moves it on by as much."""
        late = {}
        for name, image in IMAGES.items():
            late[name] = self.folder / f"late-{name}.xml"
            text = image.xml().replace('<Coef exponent1="0" exponent2="0">2.1</Coef>', '<Coef exponent1="0" exponent2="0">2.6</Coef>')
            late[name].write_text(text, encoding="utf-8")
        result = self.adjust(self.make_block("late", late, *self.SIGMAS), "late-result", *DRIFT)
        images, report = self.export(result, "late-out", late)
        reported = {name: [float(re.search(pattern, text).group(1)) for text in report["not_carried"]
                           if text.startswith(name) for pattern in (r"up to (\S+) m in range", r"and (\S+) m along")]
                    for name in IMAGES}
        for name, image in IMAGES.items():
            s, v = image.motion(CLOSEST[0])
            drift = offsets_of(images[name])["velocity"]
            # Half a second of v'v/R is the range rate there: twice the drift along the track is missing.
            self.assertAlmostEqual(reported[name][1], abs(2 * 0.5 * dot(drift, unit(v))), delta=0.1 * reported[name][1] + 5e-3)


class RealFiles(MeasuredImages):
    """Metadata of TerraSAR-X and of an example in polar format, held by their scene centre."""
    form, ending = "sicd", ".xml"

    def setUp(self):
        if not SICD.exists():
            raise unittest.SkipTest(f"no {SICD}")

    def test_they_are_valid_by_the_schema_of_1_4_0_and_come_back(self):
        schema = SICD / "SICD_schema_V1.4.0_2024_05_01.xsd"
        if not schema.exists() or shutil.which("xmllint") is None:
            raise unittest.SkipTest("no schema or no xmllint")
        for name in ("cropped_sicd_110.nitf", "example-sicd-1.3.0.xml"):
            with self.subTest(name):
                images = {"pass": SICD / name}
                block = self.import_images(f"block-{name}", images, "--grid", "control", "--grid-sigma-m", 0.2)
                result = self.adjust(block, f"result-{name}", *DRIFT[:3], "correction.range.bias_sigma_m=1",
                                     "correction.time.bias_sigma_s=1e-4")
                written, _ = self.export(result, f"out-{name}", images)
                done = subprocess.run(["xmllint", "--noout", "--schema", schema, written["pass"]],
                                      capture_output=True, text=True, check=False)
                self.assertEqual(done.returncode, 0, done.stderr)
                again = self.import_images(f"again-{name}", written, "--grid", "check")
                paths = [table(folder / "trajectories.csv") for folder in (result, again)]
                for a, b in zip(*paths):
                    self.assertAlmostEqual(float(a["x_m"]), float(b["x_m"]), 4)


if __name__ == "__main__":
    unittest.main(verbosity=2)
