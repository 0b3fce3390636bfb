#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""sarblock-mpi among ranks that share the cores of one machine, against sarblock. Run by ctest as mpi/ranks.

Environment: SARBLOCK_PROGRAM and SARBLOCK_MPI_PROGRAM the programs, SARBLOCK_DATASETS the shipped data sets."""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM = os.environ["SARBLOCK_PROGRAM"]
RANKS_PROGRAM = os.environ["SARBLOCK_MPI_PROGRAM"]
SCENES = pathlib.Path(os.environ["SARBLOCK_DATASETS"]) / "scenes"
MPIRUN = ["mpirun", "--oversubscribe"]
# Root and containers: allowed here, and no reading of other processes' memory.
ENVIRONMENT = os.environ | {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
                            "OMPI_MCA_btl_vader_single_copy_mechanism": "none", "OMPI_MCA_rmaps_base_oversubscribe": "1"}
# Far more than any of these jobs takes, far less than one that waits for a rank that does not come.
PATIENCE_S = 240


def children(pid):
    return [int(child) for child in pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def is_alive(pid):
    """False for one that ended and that nobody has asked for its status."""
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


class RanksTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))

    def run_program(self, *arguments, code=0):
        done = subprocess.run([PROGRAM, *map(str, arguments)], cwd=self.folder, capture_output=True, text=True,
                              check=False)
        self.assertEqual(done.returncode, code, done.stderr)
        return done

    def run_ranks(self, *jobs, code=0):
        """Each job: how many ranks, and the command that they run."""
        command = [*MPIRUN]
        for ranks, *arguments in jobs:
            command += [*([":"] if len(command) > len(MPIRUN) else []), "-n", str(ranks), *map(str, arguments)]
        done = subprocess.run(command, cwd=self.folder, capture_output=True, text=True, check=False, env=ENVIRONMENT,
                              timeout=PATIENCE_S)
        self.assertEqual(done.returncode, code, done.stderr)
        return done

    def simulate(self, scene, *sets, name="block"):
        keys = [item for key in sets for item in ("--set", key)]
        self.run_program("simulate", SCENES / f"{scene}.toml", *keys, "-o", name)

    def files(self, name):
        """Every file; of summary.json all but times, memory and the number of threads."""
        files = {file.name: file.read_bytes() for file in (self.folder / name).iterdir()}
        summary = json.loads(files.pop("summary.json"))
        summary["stages"] = list(summary["stages"])
        del summary["configuration"]["threads"]
        return files, json.dumps(summary)

    def expect_the_same(self, *options, code=0, sizes=(2, 4)):
        alone = self.run_program("adjust", "block", "-o", "alone", *options, code=code)
        expected = self.files("alone")
        for ranks in sizes:
            done = self.run_ranks((ranks, RANKS_PROGRAM, "adjust", "block", "-o", "ranks", *options), code=code)
            self.assertEqual(done.stdout.replace("to ranks", "to alone"), alone.stdout)
            self.assertEqual(self.files("ranks"), expected, ranks)
            shutil.rmtree(self.folder / "ranks")

    def refused(self, words, *jobs, code):
        """Ranks that end with these words once; the result of before stays as it was."""
        before = self.files("result")
        done = self.run_ranks(*jobs, code=code)
        self.assertEqual(done.stderr.count(words), 1, done.stderr)
        self.assertEqual(done.stdout, "")
        self.assertEqual(self.files("result"), before)
        self.assertEqual({file.name for file in self.folder.iterdir()}, {"block", "result"})
        return done

    def test_any_number_of_ranks_writes_the_bytes_of_one_process(self):
        self.simulate("block-12-strips", "points.count=700")
        self.expect_the_same("--set", "pairs=neighbours", sizes=(1, 2, 4))

    def test_a_net_whose_factor_is_divided_is_the_same(self):
        sigmas = [10, 5, 1, 1, 1, 1, 1, 1]
        net = SCENES.parent / "benchmarks" / "network"
        self.simulate(net, "points.count=1500", "flight.0.count=11", "flight.1.count=11", "flight.0.segments=10",
                      "flight.1.segments=10", "points.east_m=[500, 50500]", "points.north_m=[13500, 96500]",
                      "adjust.correction.position.degree=7", f"adjust.correction.position.sigma_m={[sigmas] * 3}")
        check = json.loads(self.run_program("check", "block", "--json").stdout)
        self.assertGreater(check["needs"]["factor_operations"], 0.5e9)  # h^2 is a product and a sum
        # The priors of degree 7 are for more than the scene's errors: its tests fail, which is not the question here.
        self.expect_the_same("--set", "diagnose=false")

    def test_recorded_flights_are_the_same(self):
        for scene in ("recorded/airborne-turbulent", "recorded/downlink-orbit"):
            with self.subTest(scene=scene):
                self.simulate(scene)
                self.expect_the_same()
                shutil.rmtree(self.folder / "block")
                shutil.rmtree(self.folder / "alone")

    def test_chosen_corrections_and_blunders_left_out_are_the_same(self):
        self.simulate("block-12-strips", "points.count=300")
        table = self.folder / "block" / "observations.csv"
        lines = table.read_text(encoding="utf-8").splitlines()
        place = lines[0].split(",").index("range_m")
        for number in range(50, len(lines), 190):
            cells = lines[number].split(",")
            cells[place] = str(float(cells[place]) + 23.0)
            lines[number] = ",".join(cells)
        table.write_text("\n".join(lines) + "\n", encoding="utf-8")
        self.expect_the_same("--set", "quality.snooping=iterative")
        self.assertTrue(b"blunder" in self.files("alone")[0]["residuals.csv"])
        self.expect_the_same("--set", "corrections=auto")

    def test_ranks_may_have_any_number_of_threads(self):
        self.simulate("block-12-strips", "points.count=700")
        self.run_program("adjust", "block", "-o", "alone")
        adjust = [RANKS_PROGRAM, "adjust", "block", "-o", "ranks"]
        self.run_ranks((1, *adjust, "--threads", 1), (1, *adjust, "--threads", 3))
        self.assertEqual(self.files("ranks"), self.files("alone"))

    def test_the_first_rank_alone_prints(self):
        self.simulate("earth-asc-desc", "points.count=60")
        done = self.run_ranks((3, RANKS_PROGRAM, "adjust", "block", "-o", "result", "--json"))
        self.assertEqual(json.loads(done.stdout)["status"], "converged")
        self.assertEqual(self.run_ranks((2, RANKS_PROGRAM, "--version")).stdout.count("sarblock-mpi"), 1)
        wrong = self.run_ranks((2, RANKS_PROGRAM, "check", "block"), code=2)
        self.assertEqual(wrong.stderr.count("'check' is no command of sarblock-mpi"), 1, wrong.stderr)

    def test_errors_of_all_ranks_are_told_once(self):
        self.simulate("earth-asc-desc", "points.count=60")
        self.run_program("adjust", "block", "-o", "result")
        adjust = (3, RANKS_PROGRAM, "adjust", "block", "-o", "result")
        self.refused("'ceres' is for a process alone", (*adjust, "--set", "engine=ceres"), code=3)
        table = self.folder / "block" / "observations.csv"
        text = table.read_text(encoding="utf-8")
        table.write_text(text + "no such pass,P1,1,2\n", encoding="utf-8")
        words = self.run_program("adjust", "block", "-o", "other", code=3).stderr.splitlines()[-1]
        self.assertIn("observations.csv", words)
        self.refused(words, adjust, code=3)

    def test_a_block_that_is_not_determined_has_the_words_and_the_code_of_one_process(self):
        self.simulate("earth-asc-desc", "points.count=60")
        self.run_program("adjust", "block", "-o", "result")
        shutil.rmtree(self.folder / "block")
        self.simulate("defective/no-control")
        alone = self.run_program("adjust", "block", "-o", "other", code=4).stderr
        self.assertFalse((self.folder / "other").exists())
        done = self.refused(alone.splitlines()[-1], (3, RANKS_PROGRAM, "adjust", "block", "-o", "result"), code=4)
        self.assertTrue(done.stderr.startswith(alone), done.stderr)

    def test_a_rank_that_fails_alone_ends_all_with_its_words(self):
        self.simulate("earth-asc-desc", "points.count=60")
        self.run_program("adjust", "block", "-o", "result")
        adjust = [RANKS_PROGRAM, "adjust", "block", "-o", "result"]
        little = ["--memory", 0.01]
        words = self.run_program("adjust", "block", "-o", "result", *little, code=3).stderr.splitlines()[-1]
        self.refused(words, (1, *adjust), (1, *adjust, *little), (1, *adjust), code=3)

    def test_a_refused_allocation_ends_all(self):
        self.simulate("earth-asc-desc", "points.count=300000", name="large")
        self.simulate("earth-asc-desc", "points.count=60")
        adjust = [RANKS_PROGRAM, "adjust", "block", "-o", "result"]
        limit = "ulimit -d 250000; exec \"$0\" \"$@\""
        self.run_ranks((1, *adjust), (1, "sh", "-c", limit, *adjust))  # enough for little
        shutil.rmtree(self.folder / "block")
        (self.folder / "large").rename(self.folder / "block")
        self.refused("there is not enough memory", (1, *adjust), (1, "sh", "-c", limit, *adjust), code=3)

    def test_a_killed_rank_ends_the_job_and_the_result_of_before_stays(self):
        self.simulate("block-12-strips", "points.count=700")
        self.run_program("adjust", "block", "-o", "result")
        before = self.files("result")
        with subprocess.Popen([*MPIRUN, "-n", "3", RANKS_PROGRAM, "adjust", "block", "-o", "result"], cwd=self.folder,
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=ENVIRONMENT) as job:
            ranks = []
            while len(ranks) < 3 and job.poll() is None:
                ranks = [pid for pid in children(job.pid) if os.path.realpath(f"/proc/{pid}/exe") == RANKS_PROGRAM]
                time.sleep(0.001)
            self.assertEqual(len(ranks), 3, "the job ended before its ranks were seen")
            os.kill(ranks[0], signal.SIGSTOP)  # so that the job cannot end in the meantime
            os.kill(ranks[2], signal.SIGKILL)
            self.assertNotEqual(job.wait(timeout=PATIENCE_S), 0)
        self.assertFalse([pid for pid in ranks if is_alive(pid)])
        self.assertEqual(self.files("result"), before)


if __name__ == "__main__":
    if shutil.which("mpirun") is None:
        print("skipped: mpirun is not installed")
        sys.exit(77)
    unittest.main()
