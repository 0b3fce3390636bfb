#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Real Sentinel-1 products through the program, as docs/import.md shows them; run by ctest.

Environment: SARBLOCK_PROGRAM, SARBLOCK_SHARED_DATA. Truth is tests/truth/sentinel1_doppler.py, which
shares no code with the program. Skipped where the products are not beside the project.
"""
import json
import os
import pathlib
import shutil
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "truth"))
import sentinel1_doppler  # noqa: E402
from program import run, table  # noqa: E402

PRODUCTS = pathlib.Path(os.environ["SARBLOCK_SHARED_DATA"]) / "sentinel1"


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
