#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A study in parts, as job arrays and GNU parallel run it. Run by ctest as cli/study_parts.

Environment: SARBLOCK_PROGRAM the program, SARBLOCK_DATASETS the shipped data sets."""
import os
import pathlib
import subprocess
import tempfile
import unittest

PROGRAM = os.environ["SARBLOCK_PROGRAM"]
SCENES = pathlib.Path(os.environ["SARBLOCK_DATASETS"]) / "scenes"
DENSIFICATION = f"""format = "sarblock-study 1"
study = "densification"
name = "six"
scene = "{SCENES}/cross-wise.toml"
set = ["points.count=60"]
[[axis]]
key = "control.layout"
values = ["perimeter"]
[[axis]]
key = "control.count"
values = [0, 3, 4, 5, 6, 8]
[verify]
runs = 2
[goal]
sigma_u_m = 100
"""
DESIGN = f"""format = "sarblock-study 1"
study = "design"
scene = "{SCENES}/leberl-aircraft.toml"
set = ["points.count=40", "check.count=0"]
[[axis]]
key = "looks.range_sigma_m"
values = [0.5, 1, 2]
[[axis]]
key = "control.count"
values = [2, 4]
[goal]
max_sigma_up_m = 10
[cost]
control_point = 900
"""
STABILITY = """format = "sarblock-study 1"
study = "stability"
[[family]]
name = "squint"
values = [0, 10, 20, 30]
"""


class StudyPartsTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        (self.folder / "densification.toml").write_text(DENSIFICATION, encoding="utf-8")
        (self.folder / "design.toml").write_text(DESIGN, encoding="utf-8")
        (self.folder / "stability.toml").write_text(STABILITY, encoding="utf-8")

    def study(self, *arguments, code=0):
        done = subprocess.run([PROGRAM, "study", *arguments], cwd=self.folder, capture_output=True, text=True,
                              check=False)
        self.assertEqual(done.returncode, code, done.stderr)
        return done

    def files(self, name):
        """Table, words, plots and the study: all but the record, which is in the order of finishing."""
        return {file.name: file.read_bytes() for file in (self.folder / name).iterdir()
                if file.suffix != ".progress"}

    def test_four_parts_by_gnu_parallel_are_the_study_byte_for_byte(self):
        for kind in ("densification", "design", "stability"):
            self.study(kind, f"{kind}.toml", "-o", f"{kind}-whole")
            subprocess.run(["parallel", "--will-cite", "-j2", PROGRAM, "study", kind, f"{kind}.toml", "--part",
                            "{}/4", "-o", f"{kind}-{{}}", "-q", ":::", "1", "2", "3", "4"],
                           cwd=self.folder, check=True)
            (self.folder / f"{kind}.toml").unlink()   # the parts carry what they need
            self.study("join", *(f"{kind}-{i}" for i in (3, 1, 4, 2)), "-o", f"{kind}-joined")
            self.assertGreater(len(self.files(f"{kind}-whole")), 3)  # table, study, words and a plot
            self.assertEqual(self.files(f"{kind}-joined"), self.files(f"{kind}-whole"))

    def test_a_part_holds_its_tasks_in_their_order_and_goes_on(self):
        self.study("densification", "densification.toml", "-o", "whole")
        part = ["densification", "densification.toml", "--part", "2/3", "-o", "part"]
        self.study(*part)
        rows = (self.folder / "whole" / "densification.csv").read_text(encoding="utf-8").splitlines()
        table = self.folder / "part" / "densification.csv"
        self.assertEqual(table.read_text(encoding="utf-8").splitlines(), [rows[0], rows[3], rows[6]])
        record = self.folder / "part" / "densification.progress"
        text = record.read_text(encoding="utf-8")
        record.write_text(text[:text.rindex("task ")], encoding="utf-8")
        self.assertIn("1 of 6 tasks", self.study(*part).stderr)
        self.assertEqual(table.read_text(encoding="utf-8").splitlines(), [rows[0], rows[3], rows[6]])

    def test_jobs_may_be_counted_from_zero(self):
        for i in range(2):
            self.study("densification", "densification.toml", "--part", f"{i}/2", "-o", f"part{i}")
        self.study("densification", "densification.toml", "--part", "2/2", "-o", "again")
        self.study("join", "part0", "part1", "-o", "joined")
        self.assertEqual(self.files("again"), self.files("part0"))

    def test_more_parts_than_tasks_leave_some_empty(self):
        for i in range(1, 9):
            self.study("densification", "densification.toml", "--part", f"{i}/8", "-o", f"part{i}")
        self.study("join", *(f"part{i}" for i in range(1, 9)), "-o", "joined")
        self.assertEqual(len((self.folder / "part7" / "densification.csv").read_text().splitlines()), 1)
        self.assertEqual(len((self.folder / "joined" / "densification.csv").read_text().splitlines()), 7)

    def test_missing_doubled_unfinished_and_foreign_parts_are_named(self):
        run = ["densification", "densification.toml", "-o"]
        for i in (1, 2):
            self.study(*run, f"part{i}", "--part", f"{i}/3")
        self.study(*run, "of4", "--part", "1/4")
        self.study(*run, "whole")
        self.study(*run, "other", "--part", "3/3", "--set", "seed=2")
        self.study("stability", "stability.toml", "--part", "1/2", "-o", "stability")
        (self.folder / "empty").mkdir()
        (self.folder / "odd" / "densification.progress").mkdir(parents=True)
        for folders, words in ((["part1", "part2"], "part1: is one of several parts; missing to join: part 3/3"),
                               (["part1", "part2", "part1"], "part1: holds part 1/3, as does part1"),
                               (["part1", "of4"], "of4: holds part 1/4, but part1 one of 3 parts"),
                               (["part1", "whole"], "whole: holds a whole study, no part to join"),
                               (["part1", "other"], "other: belongs to another study than part1"),
                               (["part1", "stability"], "stability: holds no part of a study densification"),
                               (["part1", "nosuch"], "nosuch: holds no part of a study densification"),
                               (["part1", "odd"], "odd: holds no part of a study densification"),
                               (["empty"], "empty: holds no part of a study")):
            self.assertIn(words, self.study("join", *folders, "-o", "out", code=3).stderr)
            self.assertFalse((self.folder / "out").exists())
        record = self.folder / "part2" / "densification.progress"
        text = record.read_text(encoding="utf-8")
        record.write_text(text[:text.rindex("end ")], encoding="utf-8")
        self.assertIn("part2: part 2/3 is not finished, 1 of 2 tasks are there",
                      self.study("join", "part1", "part2", "-o", "out", code=3).stderr)
        self.assertIn("is one of the parts to join", self.study("join", "part1", "part2", "-o", "part1", code=3).stderr)
        self.assertIn("holds part 1/3, not part 2/3", self.study(*run, "part1", "--part", "2/3", code=3).stderr)
        self.assertIn("holds part 1/3, not a whole study", self.study(*run, "part1", code=3).stderr)
        self.assertIn("holds a whole study, not part 1/3", self.study(*run, "whole", "--part", "1/3", code=3).stderr)

    def test_what_is_no_part_is_wrong_usage(self):
        for text in ("5/4", "1", "1/0", "-1/4", "a/b", "1/4/2", ""):
            self.study("densification", "densification.toml", "-o", "x", f"--part={text}", code=2)
        # Its rows are timed beside each other.
        self.study("tradeoff", "densification.toml", "-o", "x", "--part", "1/2", code=2)
        self.assertFalse((self.folder / "x").exists())


if __name__ == "__main__":
    unittest.main()
