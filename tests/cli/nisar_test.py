#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""An RSLC of NISAR with three corner reflectors through the program, as docs/import_nisar.md shows it; run by
ctest. Ends with 77 (skipped) where Debian's python3-h5py or the product are absent.

Environment: SARBLOCK_PROGRAM, SARBLOCK_SHARED_DATA. Truth: tests/truth/nisar_peaks.py, which measures the peaks in
the pixels and predicts them from the orbit, and shares no code with the program.

What the reflectors say of the image calib_slc_pass1_20mhz.h5, simulated by others:
- range: they are seen -13, 1 and 8 mm from where they should be, with standard deviations of 11, 6 and 8 mm of
  their peaks. That is the noise of the peaks: chi-square 2.4 of three, and the range bias is 0.5 +- 4.6 mm, none;
- azimuth: 5, 4 and 21 mm late, with 8, 5 and 6 mm. Their noise does not explain it (chi-square 12.6 of three,
  exceeded in 6 of 1000 images without a bias); a time bias of 1.4 +- 0.5 us, 1 cm on the ground, does, to chi-square 5 of two."""
import json
import math
import os
import pathlib
import shutil
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "truth"))
from program import run, table  # noqa: E402

try:
    import nisar_peaks
    import numpy as np
except ImportError as missing:
    print(f"skipped: {missing}")
    sys.exit(77)

DATA = pathlib.Path(os.environ["SARBLOCK_SHARED_DATA"]) / "nisar"
IMAGE = DATA / "calib_slc_pass1_20mhz.h5"
REFLECTORS = DATA / "REE_CORNER_REFLECTORS_INFO.csv"
if not IMAGE.is_file():
    print(f"skipped: no {IMAGE}")
    sys.exit(77)
GROUND_MPS = 6753.9  # metadata/geolocationGrid/groundTrackVelocity


class Reflectors(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.product = nisar_peaks.Product(IMAGE)
        cls.found = nisar_peaks.measure(cls.product, REFLECTORS)
        cls.line_m = GROUND_MPS * (cls.product.lines[1] - cls.product.lines[0])
        cls.sample_m = cls.product.ranges[1] - cls.product.ranges[0]

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="sarblock-nisar-"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.points = self.folder / "peaks.csv"
        nisar_peaks.write_points(self.found, self.points, IMAGE.name)

    def import_image(self, *options):
        return run("import", "nisar", IMAGE, "-o", self.folder / "block", "--reflectors", REFLECTORS,
                   "--points", self.points, "--reflector-sigma-m", "1e-4", "--json", *options)

    def differences(self):
        """Measured minus predicted of each reflector and their standard deviations [m]: range, azimuth."""
        return [(self.sample_m * (r["sample"] - r["predicted_sample"]), self.sample_m * r["sample_sigma_px"],
                 self.line_m * (r["line"] - r["predicted_line"]), self.line_m * r["line_sigma_px"])
                for r in self.found]

    def test_the_script_finds_the_peak_of_a_known_signal(self):
        # Flat spectra as wide as those of the image, shifted to the peak, on a carrier in both directions.
        n, row, column = 2 * nisar_peaks.HALF, 30.3712, 33.8427
        k = np.fft.fftfreq(n)
        rows = np.where(abs(k) < 0.5 * self.product.band_az, np.exp(-2j * np.pi * k * row), 0.0)
        columns = np.where(abs(k) < 0.5 * self.product.band_rg, np.exp(-2j * np.pi * k * column), 0.0)
        i = np.arange(n)
        chip = (np.outer(np.fft.ifft(rows), np.fft.ifft(columns))
                * np.exp(2j * np.pi * (0.13 * i[:, None] - 0.21 * i[None, :])))
        y, x, _ = nisar_peaks.peak(chip)
        self.assertAlmostEqual(y, row, delta=2e-4)  # 0.7 mm
        self.assertAlmostEqual(x, column, delta=2e-4)  # 1.2 mm

    def test_the_program_predicts_the_reflectors_where_the_script_does(self):
        said = json.loads(self.import_image().stdout)
        self.assertEqual([r["point"] for r in said["reflectors"]], ["CR1", "CR2", "CR3"])
        for ours, theirs in zip(said["reflectors"], self.found):
            # 0.1 mm: the script's positions are those of another formula, its path another polynomial.
            self.assertAlmostEqual(ours["line"], theirs["predicted_line"], delta=1e-4 / self.line_m)
            self.assertAlmostEqual(ours["sample"], theirs["predicted_sample"], delta=1e-4 / self.sample_m)

    def test_noise_explains_the_differences_in_range_and_a_time_bias_those_in_azimuth(self):
        differences = self.differences()
        chi_range = sum((d[0] / d[1]) ** 2 for d in differences)
        chi_azimuth = sum((d[2] / d[3]) ** 2 for d in differences)
        self.assertLess(chi_range, 7.81)       # 95 % of three
        self.assertGreater(chi_azimuth, 11.3)  # 99 % of three
        weights = [1.0 / d[3] ** 2 for d in differences]
        mean = sum(w * d[2] for w, d in zip(weights, differences)) / sum(weights)
        self.assertLess(sum(w * (d[2] - mean) ** 2 for w, d in zip(weights, differences)), 5.99)  # 95 % of two
        self.assertAlmostEqual(mean, 0.010, delta=0.002)

    def test_the_biases_are_the_weighted_means_of_the_differences(self):
        self.import_image()
        done = run("adjust", self.folder / "block", "-o", self.folder / "result", "--json",
                   "--set", "correction.range.bias=true", "--set", "correction.time.bias=true")
        said = json.loads(done.stdout)
        self.assertEqual(said["counts"]["redundancy"], 4)
        self.assertTrue(said["chi_square"]["passed"])
        found = {row["parameter"]: row for row in table(self.folder / "result" / "passes.csv")}
        differences = self.differences()
        for parameter, k, metres in (("range.bias", 0, 1.0), ("time.bias", 2, -GROUND_MPS)):
            # Points are held to 0.1 mm. The range bias is in the measured range, the time bias takes it out of the time.
            weights = [1.0 / d[k + 1] ** 2 for d in differences]
            mean = sum(w * d[k] for w, d in zip(weights, differences)) / sum(weights)
            sigma = math.sqrt(1.0 / sum(weights))
            self.assertAlmostEqual(float(found[parameter]["value"]) * metres, mean, delta=0.05 * sigma)
            self.assertAlmostEqual(float(found[parameter]["sigma"]) * abs(metres), sigma, delta=0.01 * sigma)
        self.assertLess(float(found["range.bias"]["significance"]), 1.0)
        self.assertGreater(float(found["time.bias"]["significance"]), 2.5)

    def test_another_origin_of_pixels_shifts_every_peak(self):
        said = json.loads(self.import_image("--points-origin", "0.5").stdout)
        offset = said["products"][0]["offset"]
        self.assertEqual(offset["looks"], 3)
        self.assertAlmostEqual(offset["line_px"], -0.5, delta=0.01)
        self.assertAlmostEqual(offset["sample_px"], -0.5, delta=0.01)

    def test_reflectors_as_check_points_show_the_errors_of_the_image(self):
        self.import_image("--reflector-role", "check")
        roles = {row["role"] for row in table(self.folder / "block" / "points.csv")}
        self.assertEqual(roles, {"check"})

    def test_the_faulty_row_of_the_grid_is_named(self):
        done = self.import_image()
        self.assertIn("geolocationGrid line 0 (row 2): 480 of 480 points do not fit the orbit", done.stderr)
        self.assertIn("its azimuth time is that of the row before", done.stderr)
        row = json.loads(done.stdout)["faulty_rows"][0]
        self.assertEqual((row["same_time"], row["fault"]), (True, "position"))


if __name__ == "__main__":
    unittest.main(verbosity=2)
