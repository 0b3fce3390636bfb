#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Follows the first advice of `sarblock diagnose` in blocks with a mistake and tells whether they are good then.

    tests/diagnose/follow_advice.py PROGRAM DIAGNOSIS_TABLE [--scenes A,B] [--draws N] [--seed S] [--only TEXT]
        [--jobs 2] [--keep FOLDER] [--check PERCENT]

DIAGNOSIS_TABLE is the program that plants the mistakes, in all of its scenes or in A and B. A block is diagnosed, its files are edited as the words of the first
explanation say (block_edits.py), and the new block is adjusted. Where it is not good its own first advice is followed
once more. Good is a block whose verdict is "accepted", or that of the block without a mistake where that is not accepted
either, with a global test that passes. NEES is the mean of d'C^-1 d / 3 of the points' errors d against
truth.csv with their covariance C: 1 is expected.

Printed are a table by mistake and the blocks that are not cured or accepted with a NEES above 2. With --check the exit
code is 1 where fewer than that part of what an edit of these files can follow is cured by the first advice or the
second, or where any block is accepted with a NEES above 2. Python 3.11."""
import argparse
import collections
import concurrent.futures
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
try:
    import tomllib  # noqa: F401, of Python 3.11
except ModuleNotFoundError:
    print("left out: Python has no tomllib")
    sys.exit(77)
import block_edits  # noqa: E402

MAX_NEES = 2.0
ENVIRONMENT = dict(os.environ, OPENBLAS_NUM_THREADS="1")


def run(program, *arguments):
    return subprocess.run([program, *map(str, arguments), "--threads", "1"], capture_output=True, text=True,
                          timeout=300, env=ENVIRONMENT)


def first_advice(program, folder):
    """The first explanation, or the first remark of a copy as one; None where nothing is told."""
    done = run(program, "diagnose", folder, "--json")
    if not done.stdout.startswith("{"):
        return None
    told = json.loads(done.stdout)
    for remark in told["remarks"]:
        if "is a copy" in remark or "under two ids" in remark:
            return {"cause": "copy", "passes": [], "change": remark, "sentence": remark}
    return told["diagnosis"][0] if told["diagnosis"] else None


def normalised_square(d, s, c):
    """d'C^-1 d by Cholesky; None where C is not positive definite."""
    matrix = [[s[0]**2, c[0], c[1]], [c[0], s[1]**2, c[2]], [c[1], c[2], s[2]**2]]
    lower = [[0.0] * 3 for _ in range(3)]
    whitened = []
    for i in range(3):
        for j in range(i + 1):
            left = matrix[i][j] - sum(lower[i][k] * lower[j][k] for k in range(j))
            if i == j and left <= 0.0:
                return None
            lower[i][j] = math.sqrt(left) if i == j else left / lower[j][j]
        whitened.append((d[i] - sum(lower[i][k] * whitened[k] for k in range(i))) / lower[i][i])
    return sum(one * one for one in whitened)


def nees_of(result, truth):
    """Mean over the adjusted points; None without a truth."""
    if not truth.exists():
        return None
    true = {row["point"]: [float(row[name]) for name in block_edits.XYZ] for row in block_edits.read_rows(truth)}
    squares = []
    for row in block_edits.read_rows(result / "points.csv"):
        if row["status"] != "adjusted" or not row.get("sigma_u_m") or row["point"] not in true:
            continue
        d = [float(row[name]) - one for name, one in zip(block_edits.XYZ, true[row["point"]])]
        if row.get("lat_deg"):
            axes = block_edits.enu_axes(float(row["lat_deg"]), float(row["lon_deg"]))
            d = [sum(a * b for a, b in zip(axis, d)) for axis in axes]
        square = normalised_square(d, [float(row[name]) for name in ("sigma_e_m", "sigma_n_m", "sigma_u_m")],
                                   [float(row[name]) for name in ("cov_en_m2", "cov_eu_m2", "cov_nu_m2")])
        if square is not None:
            squares.append(square / 3.0)
    return sum(squares) / len(squares) if squares else None


def adjust(program, folder, result):
    """Verdict, s0_squared of looks and control, whether its test passed, NEES."""
    done = run(program, "adjust", folder, "-o", result, "--set", "diagnose=false", "--quiet")
    if not (result / "summary.json").exists():
        return {"verdict": "refused: " + done.stderr.strip()[-200:], "s0_squared": None, "passed": False, "nees": None}
    summary = json.loads((result / "summary.json").read_text(encoding="utf-8"))
    test = summary["chi_square"]
    return {"verdict": summary["verdict"], "s0_squared": test["value"] / max(1.0, test["redundancy"]),
            "passed": test["passed"], "nees": nees_of(result, folder / "truth.csv")}


def is_good(step, usual):
    """`usual`: the verdict of the block without a mistake."""
    return step["verdict"] == "accepted" or (step["verdict"] == usual != "not accepted" and step["passed"])


def follow(program, folder, scratch, usual):
    """By step: what is said, what came of it."""
    steps = []
    while len(steps) < 2:
        told = first_advice(program, folder)
        if told is None:
            break
        step = {"cause": told["cause"], "sentence": told["sentence"], "s0_squared": None, "nees": None, "good": False}
        steps.append(step)
        new = scratch / f"step{len(steps)}"
        try:
            block = block_edits.Block(folder)
            block_edits.apply(block, told)
            block.write(new)
        except block_edits.Unclear as words:
            step["verdict"] = f"not followed: {words}"
            break
        step.update(adjust(program, new, scratch / f"result{len(steps)}"))
        step["good"] = is_good(step, usual)
        if step["good"]:
            break
        folder = new
    return steps


class Counts:
    def __init__(self):
        self.blocks = self.told = self.first = self.second = self.unclear = self.wrong = 0

    def add(self, steps):
        self.blocks += 1
        self.told += bool(steps)
        cured = bool(steps) and steps[-1]["good"]
        self.first += cured and len(steps) == 1
        self.second += cured and len(steps) == 2
        self.unclear += bool(steps) and steps[0]["verdict"].startswith("not followed")
        self.wrong += is_wrong(steps)

    def cured(self):
        return self.first + self.second

    def row(self, name):
        part = f"{100.0 * self.cured() / self.told:.0f} %" if self.told else ""
        return (f"| {name} | {self.blocks} | {self.told} | {self.first} | {self.second} | "
                f"{self.told - self.cured() - self.unclear} | {self.unclear} | {self.wrong} | {part} |")


def is_wrong(steps):
    return bool(steps) and steps[-1]["verdict"] == "accepted" and (steps[-1]["nees"] or 0.0) > MAX_NEES


def describe(step):
    numbers = "".join(f", {name} {value:.3g}" for name, value in (("s0^2", step["s0_squared"]), ("NEES", step["nees"]))
                      if value is not None)
    return f"    {step['verdict']}{numbers}: {step['cause']}: {step['sentence']}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("table")
    parser.add_argument("--scenes", default="", help="parts of their names; all")
    parser.add_argument("--draws", default="1")
    parser.add_argument("--seed", default="1")
    parser.add_argument("--only", default="", help="part of the name of the mistake")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--keep", type=pathlib.Path, help="folder for the blocks, the edited ones and their results")
    parser.add_argument("--check", type=float)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = arguments.keep or pathlib.Path(scratch)
        shutil.rmtree(folder, ignore_errors=True)
        return measure(arguments, folder)


def write_blocks(arguments, folder):
    """(folder, scene, mistake or "none", seed) of each block."""
    blocks = []
    for scene in arguments.scenes.split(","):
        target = folder / (scene or "all").replace("/", "-")
        done = subprocess.run([arguments.table, "--block", scene, "--plant", arguments.only, "--draws", arguments.draws,
                               "--seed", arguments.seed, "--write", target], capture_output=True, text=True, check=True)
        for line in done.stdout.splitlines():
            number, *names = line.split("\t")
            blocks.append((target / number, *names))
    return blocks


def measure(arguments, folder):
    blocks = write_blocks(arguments, folder)

    def good_block(block):
        return adjust(arguments.program, block[0], block[0].with_name(block[0].name + "-result"))

    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        without = [one for one in blocks if one[2] == "none"]
        usual = {(one[1], one[3]): of for one, of in zip(without, pool.map(good_block, without))}
    blocks = [one for one in blocks if one[2] != "none"]

    def trial(block):
        scratch = block[0].with_name(block[0].name + "-followed")
        scratch.mkdir()
        steps = follow(arguments.program, block[0], scratch, usual[block[1], block[3]]["verdict"])
        if not arguments.keep:
            shutil.rmtree(scratch)
        return steps

    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        followed = list(pool.map(trial, blocks))
    counts, everything = collections.defaultdict(Counts), Counts()
    for (_, _, mistake, _), steps in zip(blocks, followed):
        counts[mistake].add(steps)
        everything.add(steps)
    print("| mistake | blocks | told | cured by the first | by the second | not | no plain edit | accepted, NEES above 2 | cured of told |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for mistake, of in counts.items():
        print(of.row(mistake))
    print(everything.row("**all**"))
    for (name, seed), of in usual.items():
        if of["verdict"] != "accepted" or (of["nees"] or 0.0) > MAX_NEES:
            print(f"\n{name} / none / {seed}: {of}")
    for block, steps in zip(blocks, followed):
        if steps and (not steps[-1]["good"] or is_wrong(steps)):
            print("\n" + " / ".join(map(str, block)))
            print("\n".join(map(describe, steps)))
    if arguments.check is None:
        return 0
    edited = everything.told - everything.unclear
    return 0 if everything.cured() >= 0.01 * arguments.check * edited and not everything.wrong else 1


if __name__ == "__main__":
    sys.exit(main())
