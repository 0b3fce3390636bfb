#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Real Sentinel-1 products through the program, as docs/import.md shows them; run by ctest.

Environment: SARBLOCK_PROGRAM, SARBLOCK_SHARED_DATA. Truth is tests/truth/sentinel1_doppler.py, which
shares no code with the program. Skipped where the products are not beside the project.
"""
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "truth"))
import sentinel1_delays  # noqa: E402
import sentinel1_doppler  # noqa: E402
from program import run, table  # noqa: E402

PRODUCTS = pathlib.Path(os.environ["SARBLOCK_SHARED_DATA"]) / "sentinel1"


def geodetic(row):
    """Latitude, longitude [degrees] and height of a row with x_m, y_m, z_m."""
    x, y, z = (float(row[name]) for name in ("x_m", "y_m", "z_m"))
    e2 = sentinel1_doppler.F * (2.0 - sentinel1_doppler.F)
    p, lat, h = math.hypot(x, y), math.atan2(z, math.hypot(x, y)), 0.0
    for _ in range(30):
        n = sentinel1_doppler.A_M / math.sqrt(1.0 - e2 * math.sin(lat) ** 2)
        h = p / math.cos(lat) - n
        lat = math.atan2(z, p * (1.0 - e2 * n / (n + h)))
    return math.degrees(lat), math.degrees(math.atan2(y, x)), h


@unittest.skipUnless(PRODUCTS.is_dir(), f"no {PRODUCTS}")
class RealProducts(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="sarblock-sentinel1-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def corrections(self, block, *settings):
        options = [word for setting in settings for word in ("--set", setting)]
        run("adjust", self.folder / block, "-o", self.folder / "result", *options)
        return {(row["pass"], row["parameter"]): (float(row["value"]), float(row["sigma"]))
                for row in table(self.folder / "result" / "passes.csv")}

    def test_every_grid_point_of_los_angeles_is_a_check_point_that_fits_the_orbits(self):
        files = sorted(PRODUCTS.glob("s1a-iw2-slc-vv-*.xml"))
        said = json.loads(run("import", "sentinel1", *files, "-o", self.folder / "la", "--json").stdout)
        self.assertEqual((said["passes"], said["points"], said["looks"]), (2, 420, 420))
        self.assertEqual((said["faulty_rows"], said["warnings"]), ([], []))
        self.assertEqual({row["role"] for row in table(self.folder / "la" / "points.csv")}, {"check"})
        for file, product in zip(files, said["products"]):
            self.assertEqual((product["good"], product["grid_points"]), (210, 210))
            self.assertLess(product["largest_range_misfit_m"], 1e-3)
            self.assertLess(product["largest_along_misfit_m"], 15e-3)
            # The truth takes positions alone; states a minute before differ by 2 mm in Doppler.
            truth = sentinel1_doppler.analyse(file)
            mean = sum(truth["derived_m"]) / 210
            self.assertAlmostEqual(product["mean_along_misfit_m"], mean, delta=2e-3)
            self.assertLess(max(map(abs, truth["range_m"])), 1e-3)

    def test_raster_and_grid_are_one_when_both_are_reduced(self):
        """Truth is tests/truth/sentinel1_delays.py. IW1, IW2 and IW3."""
        for file in sorted(PRODUCTS.glob("s1a-iw2-slc-vv-*.xml")) + sorted(
                PRODUCTS.glob("S1A_IW_SLC__1SDV_2021*.xml")):
            truth, _, constant = sentinel1_delays.analyse(file)
            rows = "".join(f"R:{p['line']}:{p['pixel']},A,{p['line']},{p['pixel']}\n" for p in truth)
            points = self.folder / "points.csv"
            points.write_text("point,image,line,sample\n" + rows, encoding="utf-8")
            # The grid's lines are the first of their bursts, which have no valid sample.
            image = self.folder / "image.xml"
            image.write_text(re.sub("<(first|last)ValidSample.*?ValidSample>", "",
                                    file.read_text("utf-8"), flags=re.S), encoding="utf-8")
            said = json.loads(run("import", "sentinel1", image, "-o", self.folder / "block", "--id", "A",
                                  "--points", points, "--orbit-through", "positions", "--json",
                                  "--quiet").stdout)
            self.assertEqual(set(said["products"][0]["taken_off"]),
                             {"bistatic_s", "fm_rate_s", "pulse_motion_m", "troposphere_m"})
            looks = {row["point"]: row for row in table(self.folder / "block" / "observations.csv")}
            last = max(p["line"] for p in truth)
            for p in truth:
                place = f":{p['line']}:{p['pixel']}"
                grid, raster = ({name: float(looks[kind + place][name]) for name in
                                 ("time_s", "time_shift_s", "range_m", "range_delay_m")}
                                for kind in ("A", "R"))
                self.assertAlmostEqual(raster["range_delay_m"], p["pulse_motion_m"], delta=1e-6)
                # Velocities given and of the path differ by up to 8 mm/s, 2e-6 of the FM rate.
                self.assertAlmostEqual(raster["time_shift_s"], p["bistatic_s"] + p["fm_rate_s"],
                                       delta=3e-6)
                self.assertAlmostEqual(grid["time_s"] - grid["time_shift_s"],
                                       raster["time_s"] - raster["time_shift_s"], delta=2e-6)
                self.assertAlmostEqual(grid["range_m"] - grid["range_delay_m"],
                                       raster["range_m"] - raster["range_delay_m"], delta=0.01)
                # By the grid alone; the last row of two products is 11 us off.
                fm_rate_s = raster["time_shift_s"] - p["bistatic_s"]
                self.assertAlmostEqual(grid["time_shift_s"], fm_rate_s - constant,
                                       delta=1.3e-5 if p["line"] == last else 2e-6)
            # As annotated they differ by half the travel time over the swath.
            self.assertGreater(max(abs(p["grid_s"] - p["raster_s"]) for p in truth), 9e-5)

    def variance_factors(self, files, *options):
        """s0^2 of places of the grid predicted in both images with their delays, by the way in which
        their looks are measured: by raster, by grid, mixed. Of a look by grid the other one is
        predicted where its own orbit sees the place, as far from the grid's line as the grid
        contradicts its orbit."""
        whole = []
        for file in files:
            whole.append(self.folder / file.name)
            whole[-1].write_text(re.sub("<(first|last)ValidSample.*?ValidSample>", "",
                                        file.read_text("utf-8"), flags=re.S), encoding="utf-8")
        common = (*whole, *options, "--id", "A", "B", "--quiet", "--force")
        run("import", "sentinel1", *common, "-o", self.folder / "grid")
        points = {row["point"]: row for row in table(self.folder / "grid" / "points.csv")}
        reflectors = self.folder / "reflectors.csv"
        names = sorted(points)
        reflectors.write_text(
            "Corner reflector ID,Latitude (deg),Longitude (deg),Height above ellipsoid (m)\n" + "".join(
                "P{},{!r},{!r},{!r}\n".format(k, *geodetic(points[name]))
                for k, name in enumerate(names)), encoding="utf-8")
        said = json.loads(run("import", "sentinel1", *common, "-o", self.folder / "seen", "--grid", "none",
                              "--reflectors", reflectors, "--reflector-role", "check",
                              "--json").stdout)
        seen = {}
        for place in said["reflectors"]:
            seen.setdefault(place["point"], {})[place["pass"]] = place
        both = {name: places for name, places in seen.items() if len(places) == 2}
        self.assertGreater(len(both), 30)
        factors = {}
        for way in ("raster", "grid", "mixed"):
            rows = ""
            for k, (name, places) in enumerate(sorted(both.items())):
                grid = names[int(name[1:])]
                if way == "raster" or (way == "mixed" and k % 2 == 0):
                    rows += "".join(f"{name},{image},{at['line']},{at['sample']}\n"
                                    for image, at in places.items())
                    continue
                own, line = grid.split(":")[:2]
                off = int(line) - places[own]["line"]
                other = "B" if own == "A" else "A"
                if abs(off) < 1:  # else a pixel of the burst before or after
                    rows += f"{grid},{other},{places[other]['line'] + off},{places[other]['sample']}\n"
            matches = self.folder / "matches.csv"
            matches.write_text("point,image,line,sample\n" + rows, encoding="utf-8")
            for reduce in ("all", "none"):
                run("import", "sentinel1", *common, "-o", self.folder / "mix", "--grid", "tie", "--points",
                    matches, "--range-sigma-m", "0.1", "--azimuth-sigma-m", "0.1", "--reduce", reduce)
                subprocess.run([os.environ["SARBLOCK_PROGRAM"], "adjust", self.folder / "mix", "-o",
                                self.folder / "mixed", "--quiet", "--force"], check=False,
                               capture_output=True)
                summary = json.loads((self.folder / "mixed" / "summary.json").read_text("utf-8"))
                factors[way, reduce] = summary["sigma0_squared"]
        return factors

    def test_predicted_places_meet_however_they_are_measured(self):
        """Los Angeles from both sides, and Bougainville with on-board orbits. Left in, the delays make
        s0^2 hundreds."""
        for name, options in (("s1a-iw2-slc-vv-*.xml", ()),
                              ("S1A_IW_SLC__1SDV_2021*.xml", ("--orbit-through", "positions"))):
            factors = self.variance_factors(sorted(PRODUCTS.glob(name)), *options)
            for (way, reduce), factor in factors.items():
                with self.subTest(name, way=way, reduce=reduce, factor=factor):
                    if reduce == "all":
                        self.assertLess(factor, 0.01)
                    else:
                        self.assertGreater(factor, 50.0)

    def test_what_stays_when_nothing_is_reduced(self):
        file = sorted(PRODUCTS.glob("s1a-iw2-slc-vv-*.xml"))[0]
        said = json.loads(run("import", "sentinel1", file, "-o", self.folder / "plain", "--reduce",
                              "none", "--json").stdout)
        self.assertEqual(said["products"][0]["taken_off"], {})
        self.assertNotIn("time_shift_s", table(self.folder / "plain" / "observations.csv")[0])
        self.assertNotIn("standard", (self.folder / "plain" / "block.toml").read_text("utf-8"))

    def test_the_time_biases_of_bougainville_are_the_mean_doppler_misfit(self):
        files = sorted(PRODUCTS.glob("S1A_IW_SLC__1SDV_2021*.xml"))
        run("import", "sentinel1", *files, "-o", self.folder / "b", "--grid", "control",
            "--grid-sigma-m", "1e-6", "--sigma-range-m", "0.01", "--sigma-azimuth-m", "0.05",
            "--orbit-through", "positions", "--id", "A", "B", "--quiet")
        biases = self.corrections("b", "correction.time.bias=true")
        velocities = self.corrections("b", 'correction.velocity.components=["across","up"]')
        for name, file, mean_m in (("A", files[0], 0.739), ("B", files[1], 0.502)):
            truth = sentinel1_doppler.analyse(file)
            # 0.74 and 0.50 m, not the metre and a half that bounds single points.
            self.assertAlmostEqual(sum(truth["derived_m"]) / 210, mean_m, delta=5e-4)
            value_s, sigma_s = biases[name, "time.bias"]
            # The Doppler error runs at 6.8 km/s with time: the speed over the ground.
            self.assertAlmostEqual(value_s, mean_m / 6.83e3, delta=3.0 * sigma_s)
            self.assertAlmostEqual(sigma_s, 0.05 / 6.83e3 / 210 ** 0.5, delta=0.01 * sigma_s)
            # Why: the processor took the velocities as they stand in the annotation. With them the
            # grid fits as Los Angeles does; they are not the motion of the positions, and the
            # corrections of the velocity's direction find by how much.
            self.assertLess(max(map(abs, truth["given_m"])), 8e-3)
            for k, component in ((1, "across"), (2, "up")):
                value, sigma = velocities[name, f"velocity.{component}"]
                self.assertAlmostEqual(value, truth["excess_mps"][k] / truth["speed_mps"],
                                       delta=2.0 * sigma)
                self.assertGreater(value, 2.0 * sigma)


if __name__ == "__main__":
    unittest.main(verbosity=2)
