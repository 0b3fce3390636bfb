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
    try:
        if subprocess.run([PROGRAM, "--version"], capture_output=True, preexec_fn=limit, timeout=20,
                          check=False).returncode != 0:
            return None
    except subprocess.TimeoutExpired:  # in a library, before the program begins
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

    def test_a_second_run_into_one_output_is_refused_before_its_work(self):
        one, two = self.simulated("one", points=3000), self.simulated("two", seed=2)
        for name in ("result", "result.h5"):
            output = self.folder / name
            first = self.begun(one, output)
            second = run("adjust", two, "-o", output, "-q", code=3)
            self.assertIn(f"{name}: is being written by another run (process {first.pid} on {socket.gethostname()} "
                          "since 20", second.stderr)
            first.send_signal(signal.SIGCONT)
            self.assertEqual(first.wait(), 0, first.stderr.read())
            first.stderr.close()
            run("report", output, "-q")
        self.assertEqual(self.hidden(self.folder / "result"), [])
        self.assertGreaterEqual(len(table(self.folder / "result/points.csv")), 3000)
        self.assertEqual(self.hidden(self.folder), [])

    def test_a_killed_run_keeps_nobody_out(self):
        block, output = self.simulated("block", points=3000), self.folder / "result"
        process = self.begun(block, output)
        process.kill()
        process.wait()
        process.stderr.close()
        run("adjust", block, "-o", output, "-q", "--set", "covariance=none")
        self.assertEqual(self.hidden(output), [])

    def test_a_run_that_fails_leaves_no_folder(self):
        run("adjust", self.simulated("block"), "-o", self.folder / "new/result", "-q", "--rejections",
            self.folder / "none.csv", code=3)
        self.assertFalse((self.folder / "new").exists())

    def test_tables_of_two_runs_are_no_result(self):
        for seed in (1, 2):
            run("adjust", self.simulated(f"block{seed}", seed), "-o", self.folder / f"result{seed}", "-q")
        one, two = self.folder / "result1", self.folder / "result2"
        listed = {sum_of["table"]: sum_of for sum_of in json.loads((one / "summary.json").read_text())["tables"]}
        self.assertEqual(listed["points"]["bytes"], (one / "points.csv").stat().st_size)
        for name in ("points", "residuals", "passes", "trajectories"):
            mixed = self.folder / f"mixed_{name}"
            shutil.copytree(one, mixed)
            shutil.copy(two / f"{name}.csv", mixed)
            refused = run("convert", mixed, self.folder / "mixed.h5", "-q", code=3).stderr
            self.assertIn(f"{mixed}/{name}.csv", refused)
            self.assertIn("is not the table that summary.json was written with", refused)
            if name != "trajectories":  # which a report does not read
                run("report", mixed, "-q", code=3)
        (one / "strips.csv").unlink()
        self.assertIn("strips.csv: is missing", run("report", one, "-q", code=3).stderr)
        (two / "pairs.csv").write_text("point_a,point_b\n")
        self.assertIn("pairs.csv: is not among the tables that summary.json lists",
                      run("convert", two, self.folder / "more.h5", "-q", code=3).stderr)

    def test_checksums_are_those_of_the_text_however_it_is_kept(self):
        block, plain = self.simulated("block"), self.folder / "plain"
        run("adjust", block, "-o", plain, "-q")
        subprocess.run(["gzip", plain / "points.csv"], check=True)
        run("report", plain, "-q")
        subprocess.run(["gzip", "-d", plain / "points.csv.gz"], check=True)
        run("convert", plain, self.folder / "packed", "--gzip", "-q")
        run("convert", self.folder / "packed", self.folder / "one.h5", "-q")
        run("convert", self.folder / "one.h5", self.folder / "back", "-q")
        for name in ("summary.json", "points.csv", "residuals.csv"):
            self.assertEqual((plain / name).read_bytes(), (self.folder / "back" / name).read_bytes(), name)
        run("adjust", block, "-o", self.folder / "direct.h5", "-q")
        run("convert", self.folder / "direct.h5", self.folder / "made", "-q")
        tables = json.loads((self.folder / "made/summary.json").read_text())["tables"]
        self.assertIn("residuals", [sum_of["table"] for sum_of in tables])
        run("report", self.folder / "made", "-q")

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

    def test_a_last_row_that_may_be_cut_off_is_named(self):
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

    def test_a_limit_on_files_is_a_write_that_fails(self):
        block = self.simulated("block", points=400)
        (self.folder / "out").mkdir()
        for name, part in (("result", "points.csv"), ("result.h5", "result.h5")):
            ended = limited(resource.RLIMIT_FSIZE, 60 * KIB, "adjust", block, "-o", self.folder / "out" / name, "-q")
            if ended is None:
                self.skipTest("the program does not start under the limit")
            self.assertEqual(ended.returncode, 3, ended.stderr)
            self.assertIn("File too large", ended.stderr)
            self.assertIn(part, ended.stderr)
        self.assertEqual(os.listdir(self.folder / "out"), [])

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

    def test_a_limit_on_addresses_ends_with_a_result_or_words(self):
        block = self.simulated("block")
        codes = set()
        for mib in (220, 300, 420, 4000):
            ended = limited(resource.RLIMIT_AS, mib * KIB * KIB, "adjust", block, "-o", self.folder / "result", "-q",
                            "--threads", "2", timeout=60)
            if ended is None:
                continue
            self.assertIn(ended.returncode, (0, 3), f"{mib} MiB: {ended.stderr}")
            self.assertTrue(ended.returncode == 0 or ended.stderr.startswith("sarblock: "), ended.stderr)
            codes.add(ended.returncode)
        if not codes:
            self.skipTest("the program does not start under any limit")
        self.assertEqual(codes, {0, 3})

    def test_control_under_another_name_is_named_and_not_accepted(self):
        block = self.simulated("block")
        points = (block / "points.csv").read_text()
        control = [row["point"] for row in table(block / "points.csv") if row["role"] == "control"]
        self.assertGreater(len(control), 1)
        run("adjust", block, "-o", self.folder / "good", "-q", "--strict", "--set", "covariance=none")
        no_break = "\u00a0"
        names = {"zeros": (lambda name: name[0] + "0" + name[1:], "are they the same points"),
                 "blanks": (lambda name: name + no_break, "<no-break space>"),
                 "quoted": (lambda name: f'"{name} "', "are they the same points")}
        for change, (other, words) in names.items():
            renamed = points
            for name in control:
                renamed = renamed.replace(f"\n{name},", f"\n{other(name)},")
            (block / "points.csv").write_text(renamed)
            self.assertIn(words, " ".join(run("check", block).stdout.split()), change)
            run("adjust", block, "-o", self.folder / "bad", "-q", "--strict", code=1)
            summary = json.loads((self.folder / "bad/summary.json").read_text())
            self.assertEqual(summary["verdict"], "converged, tests failed")
            self.assertIn(f"none of {len(control)} control points has a look", summary["verdict_reasons"][0])
        for name in control:
            points = points.replace(f"\n{name},", f"\n#{name},")
        (block / "points.csv").write_text(points)
        said = " ".join(run("check", block).stdout.split())
        self.assertIn(f"{len(control)} lines that begin with # have as many cells as the header", said)

    def test_rejected_looks_do_not_act(self):
        block, deleted = self.simulated("block"), self.folder / "deleted"
        rows = table(block / "observations.csv")
        first = rows[0]["pass"]
        times = sorted(float(row["time_s"]) for row in rows if row["pass"] == first)
        late = times[len(times) // 2]
        shutil.copytree(block, deleted)
        with open(block / "observations.csv", "w", encoding="utf-8") as kept, \
                open(deleted / "observations.csv", "w", encoding="utf-8") as left:
            kept.write("pass,point,time_s,range_m,rejected\n")
            left.write("pass,point,time_s,range_m\n")
            for row in rows:
                rejected = row["pass"] == first and float(row["time_s"]) > late
                line = f"{row['pass']},{row['point']},{row['time_s']},{row['range_m']}"
                kept.write(f"{line},{int(rejected)}\n")
                left.write("" if rejected else f"{line}\n")
        for name, folder in (("rejected", block), ("deleted", deleted)):
            run("adjust", folder, "-o", self.folder / f"of_{name}", "-q", "--force")
        one, two = (json.loads((self.folder / f"of_{name}/summary.json").read_text())["passes"]
                    for name in ("rejected", "deleted"))
        self.assertEqual(one, two)
        for a, b in zip(table(self.folder / "of_rejected/points.csv"), table(self.folder / "of_deleted/points.csv")):
            if a["status"] == "adjusted":
                self.assertAlmostEqual(float(a["x_m"]), float(b["x_m"]), delta=1e-4, msg=a["point"])
        counts = [run("check", folder).stdout.split("looks per point:")[1].split("pass")[0] for folder in (block, deleted)]
        self.assertEqual(*counts)
        text = (block / "observations.csv").read_text().splitlines()
        text[1] = text[1].rsplit(",", 1)[0].split(",")
        text[1][2] = "99999"
        text[1] = ",".join(text[1]) + ",1"
        (block / "observations.csv").write_text("\n".join(text) + "\n")
        run("adjust", block, "-o", self.folder / "of_rejected", "-q")
        text = [line if not line.startswith(first) else line.rsplit(",", 1)[0] + ",1" for line in text]
        (block / "observations.csv").write_text("\n".join(text) + "\n")
        self.assertIn("looks are rejected, so it takes no part", " ".join(run("check", block).stdout.split()))

    def test_an_edited_block_is_not_written_over(self):
        block = self.simulated("block")
        again = ["simulate", SCENES / "leberl-aircraft.toml", "-o", block, "-q"]
        run(*again)  # as it was written
        subprocess.run(["sha256sum", "--quiet", "-c", ".sarblock-written"], cwd=block, check=True)
        for name in ("block.toml", "observations.csv", "points.csv"):
            whole = (block / name).read_text()
            (block / name).write_text(whole + "# mine\n")
            self.assertIn(f"changed since sarblock wrote it ({name})", run(*again, code=3).stderr)
            self.assertEqual((block / name).read_text(), whole + "# mine\n")
            run(*again, "--force")
        run("convert", block, self.folder / "block.h5", "-q")
        run("convert", self.folder / "block.h5", self.folder / "back", "-q")
        (self.folder / "back/points.csv").unlink()
        self.assertIn("(points.csv)", run("convert", block, self.folder / "back", "-q", code=3).stderr)

    def test_what_cannot_be_written_is_reported_before_the_work(self):
        block = self.simulated("block")
        with open(block / "observations.csv", "a", encoding="utf-8") as stream:
            stream.write("no,such,1,pass\n")
        (self.folder / "file").write_text("mine")
        for output in ("file/result", "file/result.h5"):
            refused = run("convert", self.simulated("whole"), self.folder / output, "-q", code=3).stderr
            self.assertNotIn("/.", refused.replace(str(self.folder), ""))
        if os.getuid() == 0:  # to whom no permission is refused
            return
        (self.folder / "closed").mkdir(mode=0o500)
        for output in ("closed/result", "closed/result.h5"):
            refused = run("convert", block, self.folder / output, "-q", code=3).stderr
            self.assertIn("cannot be", refused)
            self.assertIn("Permission denied", refused)

    def test_links_and_permissions_of_an_output_stay(self):
        block = self.simulated("block")
        (self.folder / "there").mkdir()
        (self.folder / "result.h5").symlink_to("there/kept.h5")
        run("adjust", block, "-o", self.folder / "result.h5", "-q")
        self.assertTrue((self.folder / "result.h5").is_symlink())
        kept = self.folder / "there/kept.h5"
        kept.chmod(0o640)
        run("adjust", block, "-o", self.folder / "result.h5", "-q")
        self.assertEqual(kept.stat().st_mode & 0o777, 0o640)
        self.assertEqual(self.hidden(self.folder / "there"), [])
        output = self.folder / "result"
        run("adjust", block, "-o", output, "-q")
        (output / "points.csv").chmod(0o600)
        run("adjust", block, "-o", output, "-q")
        self.assertEqual((output / "points.csv").stat().st_mode & 0o777, 0o600)

    def test_changed_bytes_of_a_file_never_crash_a_conversion(self):
        block, whole, damaged = self.simulated("block", points=4), self.folder / "whole.h5", self.folder / "damaged.h5"
        run("convert", block, whole, "-q")
        data = whole.read_bytes()
        # Places where libhdf5 1.10 frees what it never wrote, and some others.
        changes = [(len(data) - behind, value) for behind in (1400, 1210, 1186, 1029, 16518)
                   for value in (14, 71, 97, 115, 235)]
        changes += [(place, value) for place in range(700, len(data), 9001) for value in (14, 115)]
        # What libhdf5 itself forgets to free of a damaged file is no fault of the program.
        environment = {**os.environ, "ASAN_OPTIONS": "detect_leaks=0"}
        for place, value in changes:
            damaged.write_bytes(data[:place] + bytes([value]) + data[place + 1:])
            ended = subprocess.run([PROGRAM, "convert", damaged, self.folder / "out.h5", "-q", "--force"],
                                   capture_output=True, check=False, env=environment)
            self.assertIn(ended.returncode, (0, 3), f"{place} {value}")
        self.assertEqual([name for name in self.hidden(self.folder)], [])

    def test_texts_nested_without_end_are_refused(self):
        block, result = self.simulated("block"), self.folder / "result"
        run("adjust", block, "-o", result, "-q")
        (result / "summary.json").write_text("[" * 100000 + "]" * 100000)
        self.assertIn("summary.json:1: has more than 200 levels", run("report", result, "-q", code=3).stderr)
        toml = (block / "block.toml").read_text()
        deep = ".".join(["a"] * 40000)
        for text in (f"[{deep}]\n", f"{deep} = 1\n", f"[x]\ny = {{{deep} = 1}}\n", f"[[{deep}]]\n"):
            (block / "block.toml").write_text(toml + text)
            self.assertIn("a key has more than 100 parts", run("check", block, "-q", code=3).stderr)
        (block / "block.toml").write_text(toml)
        self.assertIn("a key has more than 100 parts",
                      run("check", block, "-q", "--set", f"{deep}=1", code=3).stderr)
        self.assertIn("a key has more than 100 parts",
                      run("simulate", SCENES / "leberl-aircraft.toml", "-o", self.folder / "deep", "-q", "--set",
                          f"{deep}=1", code=3).stderr)


if __name__ == "__main__":
    unittest.main()
