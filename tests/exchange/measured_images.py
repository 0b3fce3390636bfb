# SPDX-License-Identifier: Apache-2.0
"""What the tests of adjusted sensors share: blocks of images with matched points, adjusted, exported, and held
against their points again."""
import csv
import json
import math
import pathlib
import shutil
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "cli"))
from program import run, table  # noqa: E402


def write_table(path, rows):
    with open(path, "w", encoding="utf-8", newline="") as stream:
        writer = csv.DictWriter(stream, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def rms(values):
    values = list(values)
    return math.sqrt(sum(x * x for x in values) / len(values))


def congruence(a, c):
    """a c a'."""
    half = [[sum(x * y for x, y in zip(row, column)) for column in zip(*c)] for row in a]
    return [[sum(x * y for x, y in zip(row, other)) for other in a] for row in half]


class MeasuredImages(unittest.TestCase):
    """Images by pass, `points` (name: position) and `matches.csv` beside them."""
    form = ending = ""
    points = {}

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="sarblock-images-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)

    @classmethod
    def import_images(cls, name, images, *options):
        run("import", "images", *images.values(), "--id", *images, "-o", cls.folder / name, *options)
        return cls.folder / name

    @classmethod
    def make_block(cls, name, images, *options, points=None, sigma=0.05):
        """Known points: every third, or all those given."""
        block = cls.import_images(name, images, "--points", cls.folder / "matches.csv", *options)
        known = points or {name: p for k, (name, p) in enumerate(cls.points.items()) if k % 3 == 0}
        rows = []
        for row in table(block / "points.csv"):
            row = {key: row.get(key, "") for key in ("point", "role", "x_m", "y_m", "z_m")}
            row.update({f"sigma_{axis}_m": sigma if row["point"] in known else "" for axis in "enu"})
            if row["point"] in known:
                row.update(zip(("x_m", "y_m", "z_m"), known[row["point"]]), role="control")
            rows.append(row)
        write_table(block / "points.csv", rows)
        return block

    def adjust(self, block, name, *settings, code=0):
        result = self.folder / name
        run("adjust", block, "-o", result, "--quiet", "--set", "diagnose=false",
            *sum((["--set", s] for s in settings), []), code=code)
        return result

    def export(self, result, name, images, *options, code=0):
        """Files by pass and the report; of a refusal its message."""
        given = sum((["--image", f"{image}={file}"] for image, file in images.items()), [])
        done = run("export", result, "--format", self.form, "-o", self.folder / name, *given, "--json", *options,
                   code=code)
        if code:
            return done.stderr
        return {image: self.folder / name / (image + self.ending) for image in images}, json.loads(done.stdout)

    @staticmethod
    def residuals(result):
        rows = table(result / "residuals.csv")
        return [rms(float(row[f"{axis}_residual_m"]) for row in rows) for axis in ("range", "azimuth")]

    @staticmethod
    def rows_of(result):
        return {(row["point"], row["pass"]): row for row in table(result / "residuals.csv")}

    @staticmethod
    def adjusted(result):
        return {row["point"]: [float(row[f"{axis}_m"]) for axis in "xyz"] for row in table(result / "points.csv")}

    @staticmethod
    def parameters(result, image):
        return {row["parameter"]: float(row["value"]) for row in table(result / "passes.csv") if row["pass"] == image}

    @staticmethod
    def covariance(result, image, names):
        stored = {}
        for row in table(result / "passes_covariance.csv"):
            if row["pass_a"] == row["pass_b"] == image:
                value = float(row["covariance"])
                stored[row["parameter_a"], row["parameter_b"]] = stored[row["parameter_b"], row["parameter_a"]] = value
        return [[stored[a, b] for b in names] for a in names]

    def hold(self, result, images, *options, code=0):
        """The images against the adjusted points, without any correction."""
        block = self.make_block(f"{result.name}-again", images, *options, points=self.adjusted(result), sigma=1e-6)
        return self.adjust(block, f"{result.name}-held", "corrections=none", code=code)

    def assert_round_trip(self, result, images, *options):
        held = self.hold(result, images, *options)
        for before, after in zip(self.residuals(result), self.residuals(held)):
            self.assertGreater(before, 0.1)
            self.assertLess(abs(after - before), 1e-3 * before)

    def assert_matrix(self, found, expected, relative):
        scale = [math.sqrt(expected[i][i]) for i in range(len(expected))]
        for i, row in enumerate(expected):
            for j, value in enumerate(row):
                size = scale[i] * scale[j] or 1.0
                self.assertAlmostEqual(found[i][j] / size, value / size, delta=relative)
