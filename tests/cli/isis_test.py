#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Real control networks, cubes and ISDs through the program, as docs/import_isis.md and
docs/import_csm.md show them; run by ctest.

Environment: SARBLOCK_PROGRAM, SARBLOCK_SHARED_DATA, SARBLOCK_DATASETS. Truth: ISIS jigsaw's published
answer, blocks that others decoded from the same files, USGSCSM's own test point, and scripts in
tests/truth that share no code with the program. Skipped where the files are not beside the project."""
import csv
import json
import math
import os
import pathlib
import shutil
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "truth"))
import control_network  # noqa: E402
import usgscsm_points  # noqa: E402
from program import run, table  # noqa: E402

SHARED = pathlib.Path(os.environ["SARBLOCK_SHARED_DATA"])
DATASETS = pathlib.Path(os.environ["SARBLOCK_DATASETS"])
NETWORK = SHARED / "isis-minirf" / "Cabeus_Orbit400_withSS_AprioriPts.net"
CUBES = [next(iter(sorted((SHARED / "isis-minirf").glob(f"LSZ_{orbit}_*.cub"))), None)
         for orbit in ("00455", "00457", "00459")]
IDS = ("--id", "LSZ_00455", "LSZ_00457", "LSZ_00459")
SHIFTS = ("--set", "correction.position.degree=0", "--set", "correction.position.axes=frame")
XYZ = ("x_m", "y_m", "z_m")


def numbers(row, names):
    return [float(row[name]) for name in names]


class Folder(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="sarblock-isis-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def import_cabeus(self, name, *options, network=NETWORK):
        run("import", "isis", network, *CUBES, "-o", self.folder / name, *IDS, *SHIFTS, *options)
        return self.folder / name

    def positions(self, block):
        run("adjust", block, "-o", self.folder / "result", "--quiet")
        return {row["point"]: numbers(row, XYZ)
                for row in table(self.folder / "result" / "points.csv") if row["status"] == "adjusted"}


@unittest.skipUnless(NETWORK.is_file(), f"no {NETWORK}")
class Cabeus(Folder):
    def test_the_raw_files_with_the_weights_of_jigsaw_give_its_answer(self):
        block = self.import_cabeus("jigsaw", "--jigsaw-weights", "--set", "scale_by_posterior=true")
        # The heights that jigsaw holds are those of its elevation model, which no cube holds.
        heights = {row["point"]: row for row in table(SHARED / "cabeus-minirf-jigsaw" / "points.csv")
                   if not row["sigma_e_m"]}
        rows = table(block / "points.csv")
        for row in rows:
            if row["point"] in heights:
                row.update(role="control", sigma_u_m="0.1",
                           **{name: heights[row["point"]][name] for name in XYZ})
        with open(block / "points.csv", "w", encoding="utf-8", newline="") as stream:
            writer = csv.DictWriter(stream, rows[0].keys())
            writer.writeheader()
            writer.writerows(rows)
        said = json.loads(run("adjust", block, "-o", self.folder / "answer", "--json").stdout)
        self.assertEqual(said["counts"]["redundancy"], 427)
        value, covariance = {}, {}
        for row in table(self.folder / "answer" / "passes.csv"):
            value[row["pass"], row["parameter"]] = float(row["value"])
        for row in table(self.folder / "answer" / "passes_covariance.csv"):
            a, b = (row["pass_a"], row["parameter_a"]), (row["pass_b"], row["parameter_b"])
            covariance[a, b] = covariance[b, a] = float(row["covariance"])
        for row in table(DATASETS / "real" / "cabeus" / "jigsaw.csv"):
            name = row["pass"]
            parameters = [(name, f"position.{axis}.0") for axis in "xyz"]
            for k, axis in enumerate("xyz"):
                column = [float(row[f"r{i}{k}"]) for i in range(3)]  # of x_j2000 = R' x_fixed
                offset = sum(c * value[p] for c, p in zip(column, parameters))
                variance = sum(a * b * covariance[p, q] for a, p in zip(column, parameters)
                               for b, q in zip(column, parameters))
                sigma = float(row[f"sigma_{axis}_m"])
                self.assertAlmostEqual(offset, float(row[f"{axis}_j2000_m"]), delta=0.15 * sigma)
                # scale_by_posterior: the covariance has sigma0 in it, as that of jigsaw.
                self.assertAlmostEqual(math.sqrt(variance), sigma, delta=0.01 * sigma)

    def test_the_weights_of_cabeus_minirf_give_its_result(self):
        ours = self.positions(
            self.import_cabeus("ours", "--range-sigma-m", "7", "--azimuth-sigma-m", "7"))
        reference = self.folder / "reference"
        shutil.copytree(SHARED / "cabeus-minirf", reference)
        reference.chmod(0o755)
        # Times of its states end at a microsecond, 0.8 mm of flight, the last one of a path with
        # another rounding: 13 mm in two points that parallel strips hardly determine. With our
        # states, which are the table's own times, everything else of that block is held to 1 cm.
        theirs = self.positions(reference)
        self.assertEqual(len(theirs), 118)
        distances = {name: math.dist(ours[name], p) for name, p in theirs.items()}
        self.assertLess(max(distances.values()), 0.015)
        self.assertLessEqual(sum(d > 0.01 for d in distances.values()), 2)
        epochs = {"LSZ_00455": 0.545532, "LSZ_00457": 0.418642, "LSZ_00459": 0.529377}
        rows = table(self.folder / "ours" / "trajectories.csv")
        for row in rows:
            row["time_s"] = repr(float(row["time_s"]) - epochs[row["pass"]])
        (reference / "trajectories.csv").unlink()
        with open(reference / "trajectories.csv", "w", encoding="utf-8", newline="") as stream:
            writer = csv.DictWriter(stream, rows[0].keys())
            writer.writeheader()
            writer.writerows(rows)
        theirs = self.positions(reference)
        self.assertLess(max(math.dist(ours[name], p) for name, p in theirs.items()), 0.01)

    def test_the_shipped_block_is_what_the_importer_writes(self):
        block = self.import_cabeus("cabeus", "--range-sigma-m", "7", "--azimuth-sigma-m", "7")
        for name in ("block.toml", "observations.csv", "points.csv", "trajectories.csv"):
            self.assertEqual((block / name).read_bytes(),
                             (DATASETS / "real" / "cabeus" / name).read_bytes(), name)

    def test_version_two_of_the_network_gives_the_same_bytes(self):
        header, points = control_network.read(NETWORK)
        two = self.folder / "two.net"
        two.write_bytes(control_network.network_bytes(header, points, 2))
        options = ("--range-sigma-m", "7", "--azimuth-sigma-m", "7", "--name", "same")
        block5 = self.import_cabeus("five", *options)
        block2 = self.import_cabeus("two", *options, network=two)
        for file in sorted(block5.iterdir()):
            self.assertEqual(file.read_bytes(), (block2 / file.name).read_bytes(), file.name)

    def test_a_cube_that_nobody_measured_in_and_a_network_without_sigmas_are_named(self):
        other = next((SHARED / "isis-minirf").glob("LSZ_04866_*.cub"))
        done = run("import", "isis", NETWORK, *CUBES, other, "-o", self.folder / "a",
                   "--range-sigma-m", "7", "--azimuth-sigma-m", "7")
        self.assertIn("LSZ_04866_1CD_XKU_89N109_V1_lev1.crop.cub: no measure of the network", done.stderr)
        done = run("import", "isis", NETWORK, *CUBES, "-o", self.folder / "b", code=3)
        self.assertIn("--range-sigma-m gives one", done.stderr)
        done = run("import", "isis", NETWORK, CUBES[0], "-o", self.folder / "c",
                   "--range-sigma-m", "7", "--azimuth-sigma-m", "7", code=3)
        self.assertIn("2 of 3 have no image", done.stderr)


@unittest.skipUnless((SHARED / "csm-sar").is_dir(), f"no {SHARED / 'csm-sar'}")
class LroIsd(Folder):
    ISD = SHARED / "csm-sar" / "orbitalSar.json"
    # SarTests.cpp of USGSCSM, SarSensorModel.Center: line 500, sample 500 at height 0.
    POINT = (-1520427.2924246688, -450240.98096817418, 710030.04690435971)

    def import_point(self, position, *options):
        measure = [(1, 2, b"x"), (2, 0, 2), (3, 1, 500.0), (4, 1, 500.0)]
        fields = [(1, 2, b"P"), (2, 0, 4)] + [(16 + k, 1, position[k]) for k in range(3)]
        point = control_network.message(fields + [(25, 2, control_network.message(measure))])
        net = self.folder / "point.net"
        net.write_bytes(control_network.network_bytes([(2, 2, b"MOON")], [point], 5, 1024))
        run("import", "csm", net, self.ISD, "-o", self.folder / "block", "--serial", f"x={self.ISD}",
            "--range-sigma-m", "5", "--azimuth-sigma-m", "5", *options)
        look = table(self.folder / "block" / "observations.csv")[0]
        time, distance = numbers(look, ("time_s", "range_m"))
        states = [numbers(row, ("time_s", *XYZ, "vx_mps", "vy_mps", "vz_mps"))
                  for row in table(self.folder / "block" / "trajectories.csv")]
        s, v = usgscsm_points.cubic_state([state[0] for state in states],
                                          [(state[1:4], state[4:]) for state in states], time)
        d = [a - b for a, b in zip(position, s)]
        return (math.hypot(*d) - distance, sum(a * b for a, b in zip(d, v)) / math.hypot(*v))

    def test_line_500_sample_500_is_the_test_point_of_usgscsm(self):
        range_error, along_error = self.import_point(self.POINT, "--range-polynomial", "usgscsm")
        self.assertLess(abs(range_error), 1e-3)
        self.assertLess(abs(along_error), 0.02)

    def test_with_their_own_times_the_polynomials_are_what_the_script_says(self):
        model = usgscsm_points.Model(self.ISD)
        point = model.ground(500.0, 500.0, "times")
        range_error, along_error = self.import_point(point)
        self.assertLess(abs(range_error), 1e-4)
        self.assertLess(abs(along_error), 1e-3)
        # The two readings are a quarter of a metre apart here.
        apart = model.slant_range(500.0, 500.0, "usgscsm") - model.slant_range(500.0, 500.0, "times")
        self.assertGreater(abs(apart), 0.2)
        self.assertAlmostEqual(self.import_point(self.POINT)[0], apart, delta=0.002)

    def test_two_isds_of_one_image_are_reported_a_line_apart(self):
        network = DATASETS / "networks" / "lro-03821.net"
        sigmas = ("--range-sigma-m", "5", "--azimuth-sigma-m", "5")
        done = run("import", "csm", network, self.ISD, "-o", self.folder / "one", *sigmas)
        self.assertEqual(done.stderr, "")
        other = SHARED / "csm-sar" / "lrominirf_isd.json"
        done = run("import", "csm", network, other, "-o", self.folder / "two", *sigmas)
        self.assertIn("starts one line (4.704 ms) earlier than serial number", done.stderr)
        self.assertIn("measures lie one line before", done.stderr)
        done = run("import", "csm", network, other, "-o", self.folder / "three", *sigmas,
                   "--pixel-origin", "-0.5,0.5")
        self.assertNotIn("measures lie", done.stderr)
        # The shipped network is what the script writes.
        usgscsm_points.write_network(usgscsm_points.Model(self.ISD), self.folder / "again.net",
                                     "LRO/MRFLRO/2010-04-25T04:22:31.244874")
        self.assertEqual((self.folder / "again.net").read_bytes(), network.read_bytes())


if __name__ == "__main__":
    unittest.main(verbosity=2)
