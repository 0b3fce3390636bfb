#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The program among other processes: two runs with one output, limits of the system, files that were cut off,
appended to or put together of two runs. Run by ctest as cli/processes.

Environment: SARBLOCK_PROGRAM the program, SARBLOCK_DATASETS the shipped data sets."""
import gzip
import json
import os
import pathlib
import resource
import shutil
import signal
import socket
import subprocess
import tempfile
import time
import unittest

from program import PROGRAM, run, table

SCENES = pathlib.Path(os.environ["SARBLOCK_DATASETS"]) / "scenes"
KIB = 1024


def limited(kind, value, *arguments, timeout=120):
    """Exit code and messages of the program under a limit of the system; None where it does not even start."""
    def limit():
        resource.setrlimit(kind, (value, value))
    starts = subprocess.run([PROGRAM, "--version"], capture_output=True, preexec_fn=limit, check=False)
    if starts.returncode != 0:
        return None
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, preexec_fn=limit,
                          timeout=timeout, check=False)


class ProcessesTest(unittest.TestCase):
    def setUp(self):
        self.home = tempfile.TemporaryDirectory()
        self.addCleanup(self.home.cleanup)
        self.folder = pathlib.Path(self.home.name)

    def simulated(self, name, seed=1, points=40):
        block = self.folder / name
        run("simulate", SCENES / "leberl-aircraft.toml", "-o", block, "-q", "--set", f"seed={seed}",
            "--set", f"points.count={points}")
        return block

    def hidden(self, folder):
        return [name for name in os.listdir(folder) if name.startswith(".")]

    def begun(self, block, output, *options):
        """A run that has begun and holds its output."""
        process = subprocess.Popen([PROGRAM, "adjust", str(block), "-o", str(output), "-q", *options],
                                   stderr=subprocess.PIPE, text=True)
        folder = output.parent if output.suffix == ".h5" else output
        lock = folder / (f".{output.name}.sarblock-lock" if output.suffix == ".h5" else ".sarblock-lock")
        while process.poll() is None and not (lock.exists() and lock.stat().st_size > 0):
            time.sleep(0.001)
        self.assertIsNone(process.poll(), "ended before it was looked at")
        process.send_signal(signal.SIGSTOP)
        return process

    def test_gzip_streams_behind_each_other_are_read_and_other_bytes_are_not(self):
        block = self.simulated("block")
        rows = (block / "observations.csv").read_bytes()
        half = rows.index(b"\n", len(rows) // 2) + 1
        (block / "observations.csv").unlink()
        packed = block / "observations.csv.gz"
        packed.write_bytes(gzip.compress(rows[:half]) + gzip.compress(rows[half:]) + bytes(512))
        run("check", block, "-q")
        packed.write_bytes(gzip.compress(rows[:half]) + rows[half:])
        self.assertIn("the gzip data end here and other bytes follow", run("check", block, "-q", code=3).stderr)
        packed.write_bytes(gzip.compress(rows[:half]) + gzip.compress(rows[half:])[:-9])
        self.assertIn("the gzip data end too early", run("check", block, "-q", code=3).stderr)

    def test_a_last_row_that_may_be_cut_off_is_told(self):
        block = self.simulated("block")
        for name in ("observations", "points", "trajectories"):
            file = block / f"{name}.csv"
            rows = file.read_bytes()
            self.assertNotIn("does not end with a newline", run("check", block).stdout)
            file.write_bytes(rows.rstrip(b"\n"))
            self.assertIn(f"{name}.csv: the last row does not end with a newline",
                          " ".join(run("check", block).stdout.split()))
            packed = block / f"{name}.csv.gz"
            packed.write_bytes(gzip.compress(rows.rstrip(b"\n")))
            file.unlink()
            self.assertIn("the last row does not end", " ".join(run("check", block).stdout.split()))
            packed.unlink()
            file.write_bytes(rows)

    def test_a_full_disk_never_ends_in_a_crash_of_libhdf5(self):
        block, output = self.simulated("block"), self.folder / "result.h5"
        run("adjust", block, "-o", output, "-q")
        for part in range(1, 12):
            ended = limited(resource.RLIMIT_FSIZE, output.stat().st_size * part // 12, "adjust", block, "-o",
                            self.folder / "cut.h5", "-q")
            if ended is None:
                self.skipTest("the program does not start under the limit")
            self.assertEqual(ended.returncode, 3, f"{part}: {ended.stderr}")
            self.assertEqual(self.hidden(self.folder), [])

    def test_changed_bytes_of_a_file_never_crash_a_conversion(self):
        block, whole, damaged = self.simulated("block", points=4), self.folder / "whole.h5", self.folder / "damaged.h5"
        run("convert", block, whole, "-q")
        data = whole.read_bytes()
        # Places where libhdf5 1.10 frees what it never wrote, and some others.
        places = [len(data) - behind for behind in (1400, 1210, 1186, 1029, 16518)] + list(range(700, len(data), 9001))
        for place in places:
            for value in (14, 71, 97, 115, 235):
                damaged.write_bytes(data[:place] + bytes([value]) + data[place + 1:])
                ended = subprocess.run([PROGRAM, "convert", damaged, self.folder / "out.h5", "-q", "--force"],
                                       capture_output=True, check=False)
                self.assertIn(ended.returncode, (0, 3), f"{place} {value}")
        self.assertEqual([name for name in self.hidden(self.folder)], [])

if __name__ == "__main__":
    unittest.main()
