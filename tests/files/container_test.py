#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""HDF5 files of blocks and results opened by h5py and by xarray (h5netcdf), which share no code with
the program: the same numbers as the folder's, with names and units. Ends with 77 (skipped) where
Debian's python3-h5py, python3-h5netcdf and python3-xarray are absent."""
import csv
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

try:
    import h5netcdf  # noqa: F401  (the engine of xarray)
    import h5py
    import numpy as np
    import xarray
except ImportError as missing:
    print(f"skipped: {missing}")
    sys.exit(77)

PROGRAM = os.environ["SARBLOCK_PROGRAM"]
SCENES = pathlib.Path(os.environ["SARBLOCK_DATASETS"]) / "scenes"


def run(*arguments, code=0):
    ended = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True)
    if ended.returncode != code:
        raise AssertionError(f"{arguments}: {ended.returncode}\n{ended.stderr}")
    return ended


def table(file):
    with open(file, newline="") as rows:
        read = list(csv.DictReader(rows))
    return {name: [row[name] for row in read] for name in read[0]}


def numbers(cells):
    return np.array([float(cell) if cell else np.nan for cell in cells])


class ContainerTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.kept = tempfile.TemporaryDirectory()
        cls.folder = folder = pathlib.Path(cls.kept.name)
        scene = SCENES / "earth-asc-desc.toml"
        run("simulate", scene, "-o", folder / "block")
        run("simulate", scene, "-o", folder / "block.h5")
        run("adjust", folder / "block", "-o", folder / "result", "--threads", "1")
        run("adjust", folder / "block.h5", "-o", folder / "result.h5", "--threads", "1")

    @classmethod
    def tearDownClass(cls):
        cls.kept.cleanup()

    def test_h5py_reads_the_numbers_names_and_units_of_the_folder(self):
        for name, tables in (("block", ("trajectories", "observations", "points", "truth")),
                             ("result", ("points", "passes", "residuals", "strips"))):
            with h5py.File(self.folder / f"{name}.h5") as file:
                ids = {"/pass_id": file["pass_id"].asstr()[:], "/point_id": file["point_id"].asstr()[:]}
                for group in tables:
                    cells = table(self.folder / name / f"{group}.csv")
                    for column, expected in cells.items():
                        data = file[group][column]
                        if "index_of" in data.attrs:
                            texts = data.attrs["index_of"]
                            texts = ids[texts] if texts in ids else file[group][texts].asstr()[:]
                            self.assertEqual(list(texts[data[:]]), expected, column)
                        else:
                            read = data[:].astype(float)
                            if data.dtype.kind == "i":
                                read[read == -1] = np.nan
                            np.testing.assert_array_equal(read, numbers(expected), column)
                self.assertEqual(file[tables[0]]["x_m" if "x_m" in file[tables[0]] else "time_s"]
                                 .attrs["units"], "m")
                observed = file.get("observations")
                if observed is not None:
                    self.assertEqual(observed["time_s"].attrs["units"], "s")
                    self.assertIn('format = "sarblock-block 1"', file.attrs["block_toml"])

    def test_xarray_opens_groups_with_dimensions_and_units(self):
        looks = xarray.open_dataset(self.folder / "block.h5", group="observations", engine="h5netcdf")
        ids = xarray.open_dataset(self.folder / "block.h5", engine="h5netcdf")
        cells = table(self.folder / "block" / "observations.csv")
        self.assertEqual(looks["range_m"].dims, ("row",))
        self.assertEqual(looks["range_m"].attrs["units"], "m")
        self.assertEqual(looks.sizes["row"], len(cells["pass"]))
        np.testing.assert_array_equal(looks["range_m"].values, numbers(cells["range_m"]))
        points = ids["point_id"].values.astype(str)[looks["point"].values]
        self.assertEqual(list(points), cells["point"])
        adjusted = xarray.open_dataset(self.folder / "result.h5", group="points", engine="h5netcdf")
        self.assertEqual(adjusted["sigma_u_m"].attrs["units"], "m")
        self.assertEqual(adjusted["lat_deg"].attrs["units"], "degree")
        self.assertEqual(adjusted["redundancy"].attrs["units"], "1")

    def test_commands_take_a_file_and_say_the_same(self):
        folder = self.folder
        for command in ("check", "diagnose"):
            said = run(command, folder / "block", "--json").stdout
            self.assertEqual(run(command, folder / "block.h5", "--json").stdout, said)
        run("convert", folder / "result.h5", folder / "back")
        for file in sorted((folder / "result").glob("*.csv")):
            self.assertEqual(file.read_bytes(), (folder / "back" / file.name).read_bytes(), file.name)
        run("predict", folder / "block.h5", "-o", folder / "predicted.h5")
        run("report", folder / "result.h5")
        self.assertTrue((folder / "result.report.html").exists())
        run("export", folder / "result.h5", "--format", "geojson")
        self.assertTrue((folder / "result.export.geojson").exists())

    def test_what_h5py_changed_is_read_or_refused(self):
        file = self.folder / "changed.h5"
        file.write_bytes((self.folder / "block.h5").read_bytes())
        with h5py.File(file, "a") as opened:
            ranges = opened["observations/range_m"][:]
            del opened["observations/range_m"]
            opened["observations/range_m"] = ranges  # contiguous
        run("check", file)
        with h5py.File(file, "a") as opened:
            opened["observations/range_m"][7] = np.inf
        said = run("check", file, code=3).stderr
        self.assertIn("changed.h5: /observations/range_m[7]: must be a finite number, got inf",
                      said)


if __name__ == "__main__":
    unittest.main()
