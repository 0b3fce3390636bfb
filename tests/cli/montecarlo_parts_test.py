#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The runs of covariance = "montecarlo" in parts, as job arrays and GNU parallel compute them. Run by ctest as
cli/montecarlo_parts.

Environment: SARBLOCK_PROGRAM the program, SARBLOCK_DATASETS the shipped data sets."""
import json
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

PROGRAM = os.environ["SARBLOCK_PROGRAM"]
SCENES = pathlib.Path(os.environ["SARBLOCK_DATASETS"]) / "scenes"
RUNS = 34
DRAWN = ["--set", "covariance=montecarlo", "--set", f"montecarlo_runs={RUNS}"]


class MonteCarloPartsTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.run_program("simulate", SCENES / "earth-asc-desc.toml", "--set", "points.count=40", "-o", "block")

    def run_program(self, *arguments, code=0):
        done = subprocess.run([PROGRAM, *map(str, arguments)], cwd=self.folder, capture_output=True, text=True,
                              check=False)
        self.assertEqual(done.returncode, code, done.stderr)
        return done

    def adjust(self, *arguments, code=0):
        return self.run_program("adjust", "block", *DRAWN, *arguments, code=code)

    def parts(self, count, *more):
        for i in range(1, count + 1):
            self.adjust("--part", f"{i}/{count}", "-o", f"part{i}", *more)
        return [f"part{i}" for i in range(1, count + 1)]

    def files(self, name):
        """Every file; of summary.json all but times, memory and how much faster simplifications are, which is timed."""
        files = {file.name: file.read_bytes() for file in (self.folder / name).iterdir()}
        summary = json.loads(files.pop("summary.json"))
        summary["stages"] = list(summary["stages"])
        selection = summary.get("selection", {})
        for timed in (selection, *selection.get("simplifications", ())):
            for key in ("gain", "simplified_gain"):
                timed.pop(key, None)
        return files, json.dumps(summary)

    def refused(self, words, *arguments):
        self.assertIn(words, self.adjust(*arguments, "-o", "out", code=3).stderr)
        self.assertFalse((self.folder / "out").exists())

    def test_four_parts_by_gnu_parallel_are_one_run_byte_for_byte(self):
        whole = self.adjust("-o", "whole").stdout
        subprocess.run(["parallel", "--will-cite", "-j2", PROGRAM, "adjust", "block", *DRAWN, "--part", "{}/4", "-o",
                        "part{}", "--threads", "1", "-q", ":::", "1", "2", "3", "4"], cwd=self.folder, check=True)
        joined = self.adjust("--join", *(f"part{i}" for i in (3, 1, 4, 2)), "-o", "joined").stdout
        self.assertEqual(joined.replace("joined", "whole"), whole)
        self.assertEqual(self.files("joined"), self.files("whole"))
        # The comparison would see another seed.
        self.adjust("-o", "other", "--set", "montecarlo_seed=2")
        self.assertNotEqual(self.files("other")[0]["montecarlo.csv"], self.files("whole")[0]["montecarlo.csv"])

    def test_any_number_of_parts_in_any_order_and_kind_of_file(self):
        self.adjust("-o", "whole")
        for count, more in ((1, []), (3, ["--gzip"]), (RUNS + 2, [])):
            parts = self.parts(count, *more)
            self.adjust("--join", *reversed(parts), "-o", "joined")
            self.assertEqual(self.files("joined"), self.files("whole"), count)
        self.adjust("--join", *parts, "-o", "joined.h5")
        self.run_program("convert", "joined.h5", "from_h5")
        self.assertEqual(self.files("from_h5")[0]["montecarlo.csv"], self.files("whole")[0]["montecarlo.csv"])

    def test_jobs_may_be_counted_from_zero(self):
        self.adjust("--part", "0/2", "-o", "part0")
        self.assertEqual(self.adjust("--part", "2/2", "-o", "part2").stdout.split(";")[0],
                         f"part 2/2: {RUNS // 2} of {RUNS} runs written to part2")
        self.assertEqual({file.name: file.read_bytes() for file in (self.folder / "part0").iterdir()},
                         {file.name: file.read_bytes() for file in (self.folder / "part2").iterdir()})
        said = json.loads(self.adjust("--part", "1/2", "-o", "part1", "--json").stdout)
        self.assertEqual((said["part"], said["runs"], said["failed"]), ("1/2", RUNS // 2, 0))
        self.assertEqual(said, json.loads((self.folder / "part1" / "part.json").read_text(encoding="utf-8")))
        self.adjust("--join", "part0", "part1", "-o", "joined")

    def test_selected_corrections_and_failed_tests_are_joined_likewise(self):
        block = self.folder / "block" / "block.toml"
        text = block.read_text(encoding="utf-8")
        for name in ("range_m", "azimuth_m"):  # looks twice as noisy as stated
            text, count = re.subn(rf"(?m)^{name} = (\S+)$", lambda found: f"{name} = {float(found[1]) / 2}", text)
            self.assertEqual(count, 1, name)
        block.write_text(text, encoding="utf-8")
        wrong = ["--set", "corrections=auto", "--set", "diagnose=false"]
        verdict = json.loads(self.adjust("-o", "whole", "--json", *wrong).stdout)["verdict"]
        self.assertEqual(verdict, "converged, tests failed")
        parts = self.parts(2, *wrong)
        self.adjust("--join", *parts, "-o", "joined", *wrong)
        self.assertEqual(self.files("joined"), self.files("whole"))
        self.adjust("--part", "1/2", "-o", "part1", *wrong, "--strict", code=1)
        self.adjust("--join", *parts, "-o", "joined", *wrong, "--strict", code=1)

    def test_missing_doubled_and_foreign_parts_are_named(self):
        self.parts(3)
        self.adjust("--part", "1/4", "-o", "of4")
        self.adjust("--part", "3/3", "-o", "other", "--set", "montecarlo_seed=2")
        self.adjust("--part", "3/3", "-o", "more", "--set", "montecarlo_runs=40")
        (self.folder / "empty").mkdir()
        for folders, words in (
                (["part1", "part3"], "part1: is one of several parts; missing to join: part 2/3"),
                (["part1", "part2", "part1"], "part1: holds part 1/3, as does part1"),
                (["part1", "of4"], "of4: holds part 1/4, but part1 one of 3 parts"),
                (["part1", "part2", "other"],
                 "other: was drawn with other options: montecarlo_seed is 2, here it is 1"),
                (["more", "part1"], f"more: was drawn with other options: montecarlo_runs is 40, here it is {RUNS}"),
                (["part1", "empty"], "empty: holds no part of an adjustment: there is no file part.json"),
                (["nosuch"], "nosuch: holds no part of an adjustment"),
                (["block"], "block: holds no part of an adjustment")):
            self.refused(words, "--join", *folders)
        self.refused("was drawn with other options: tolerance", "--join", "part1", "part2", "part3", "--set",
                     "tolerance=1e-7")
        observations = self.folder / "block" / "observations.csv"
        text = observations.read_text(encoding="utf-8")
        observations.write_text("# checked\n" + text, encoding="utf-8")
        self.refused("part1: belongs to another block: observations.csv is not the same", "--join", "part1")
        observations.write_text(text, encoding="utf-8")
        self.assertIn("is one of the parts to join",
                      self.adjust("--join", "part1", "part2", "part3", "-o", "part1", "--force", code=3).stderr)
        self.adjust("--join", "part1", "part2", "part3", "-o", "out")

    def test_damaged_parts_and_those_of_other_programs_are_named(self):
        self.parts(2)
        sums = self.folder / "part2" / "sums.csv"
        text = sums.read_text(encoding="utf-8")
        at = text.index(",", text.index("\n")) + 3   # a digit of the first sum
        sums.write_text(text[:at] + str((int(text[at]) + 1) % 10) + text[at + 1:], encoding="utf-8")
        self.refused("part2: is damaged: sums.csv has another checksum", "--join", "part1", "part2")
        sums.unlink()
        self.refused("part2: has no table sums.csv", "--join", "part1", "part2")
        sums.write_text(text, encoding="utf-8")
        origin = self.folder / "part2" / "part.json"
        said = json.loads(origin.read_text(encoding="utf-8"))
        for changed, words in (({"solution": "0" * 16}, "part2: its draws are about a solution with other last digits"),
                               ({"version": "0.0.1"}, "part2: was drawn by sarblock 0.0.1, this is "),
                               ({"format": "sarblock-part 9"}, 'part.json:2: format: "sarblock-part 1" is allowed'),
                               ({"part": "3/2"}, "part: is no part I/N")):
            origin.write_text(json.dumps(said | changed, indent=2), encoding="utf-8")
            self.refused(words, "--join", "part1", "part2")

    def test_an_output_of_others_and_a_file_are_refused(self):
        self.adjust("-o", "result")
        before = self.files("result")
        self.assertIn("no part of an adjustment that sarblock wrote",
                      self.adjust("--part", "1/2", "-o", "result", code=3).stderr)
        self.assertEqual(self.files("result"), before)
        self.assertIn("is the name of a file", self.adjust("--part", "1/2", "-o", "part.h5", code=3).stderr)
        self.adjust("--part", "1/2", "-o", "part", "--gzip")
        self.adjust("--part", "2/2", "-o", "part")   # replaces it: no table of the other compression stays
        self.assertEqual(sorted(os.listdir(self.folder / "part")), ["draws.csv", "part.json", "sums.csv"])
        self.assertIn("no result that sarblock wrote", self.adjust("-o", "part", code=3).stderr)

    def test_what_draws_nothing_has_no_parts(self):
        for more in (["--part", "1/2"], ["--join", "part1"]):
            run = self.run_program("adjust", "block", "-o", "out", *more, code=3)
            self.assertIn('adjust.covariance: only the runs of "montecarlo" have parts', run.stderr)
        for text in ("5/4", "1", "1/0", "-1/4", "a/b", ""):
            self.adjust("-o", "out", f"--part={text}", code=2)
        self.adjust("-o", "out", "--part", "1/2", "--join", "part1", code=2)
        self.adjust("-o", "out", "--part", "1/2", "--report", code=2)
        self.run_program("predict", "block", "-o", "out", "--part", "1/2", code=2)
        self.assertFalse((self.folder / "out").exists())

    def edit_block(self, before, after):
        file = self.folder / "block" / "block.toml"
        text = file.read_text(encoding="utf-8")
        self.assertIn(before, text)
        file.write_text(text.replace(before, after), encoding="utf-8")

    def test_parts_of_an_adjustment_that_is_not_accepted_end_as_it_does(self):
        self.edit_block("range_m = 0.5\nazimuth_m = 1\n", "range_m = 0.05\nazimuth_m = 0.1\n")
        self.adjust("-o", "whole", code=1)
        for i in (1, 2):
            said = self.adjust("--part", f"{i}/2", "-o", f"part{i}", code=1).stderr
            self.assertIn("the adjustment is not accepted: s0^2", said)
        self.adjust("--join", "part1", "part2", "-o", "joined", code=1)
        self.assertEqual(self.files("joined"), self.files("whole"))

    def test_an_undetermined_block_has_no_parts(self):
        self.parts(1)
        self.edit_block("sigma_m = [[3, 0.5], [2, 0.4], [2, 0.3]]\n", "")
        points = self.folder / "block" / "points.csv"
        points.write_text(points.read_text(encoding="utf-8").replace(",control,", ",check,"), encoding="utf-8")
        plain = self.adjust("-o", "out", code=4).stderr
        self.assertEqual(self.adjust("--part", "1/2", "-o", "out", code=4).stderr, plain)
        self.refused("belongs to another block: block.toml is not the same", "--join", "part1")


if __name__ == "__main__":
    unittest.main()
