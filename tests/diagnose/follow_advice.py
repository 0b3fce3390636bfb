#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Follows the first advice of `sarblock diagnose` in blocks with a mistake and tells whether they are good then.

    diagnosis_table --seed 1 --write FOLDER > FOLDER.list
    tests/diagnose/follow_advice.py PROGRAM FOLDER [--jobs 2] [--keep FOLDER] [--check PERCENT]

FOLDER.list has a line for each block of FOLDER. A block is diagnosed, its files are edited as the words of the first
explanation say (block_edits.py), and the new block is adjusted. Where it is not accepted its own first advice is followed
once more. Cured is a block whose verdict is "accepted". NEES is the mean of d'C^-1 d / 3 of the points' errors d against
truth.csv with their covariance C: 1 is expected.

Printed are a table by mistake and the blocks that are not cured or accepted with a NEES above 2. With --check the exit
code is 1 where fewer than that part of what was told is cured by the first advice or the second, or where any block is
accepted with a NEES above 2. Python 3.11."""
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
    """(verdict, s0^2 of looks and control, NEES)"""
    done = run(program, "adjust", folder, "-o", result, "--set", "diagnose=false", "--quiet")
    if not (result / "summary.json").exists():
        return "refused: " + done.stderr.strip()[-200:], None, None
    summary = json.loads((result / "summary.json").read_text(encoding="utf-8"))
    return summary["verdict"], summary["chi_square"].get("value", math.nan) / max(
        1.0, summary["chi_square"].get("redundancy", 1.0)), nees_of(result, folder / "truth.csv")


def follow(program, folder, scratch):
    """By step: what is said, what came of it."""
    steps = []
    while len(steps) < 2:
        told = first_advice(program, folder)
        if told is None:
            break
        step = {"cause": told["cause"], "sentence": told["sentence"], "verdict": "", "s0_squared": None, "nees": None}
        steps.append(step)
        new = scratch / f"step{len(steps)}"
        try:
            block = block_edits.Block(folder)
            block_edits.apply(block, told)
            block.write(new)
        except block_edits.Unclear as words:
            step["verdict"] = f"not followed: {words}"
            break
        step["verdict"], step["s0_squared"], step["nees"] = adjust(program, new, scratch / f"result{len(steps)}")
        if step["verdict"] == "accepted":
            break
        folder = new
    return steps


class Counts:
    def __init__(self):
        self.blocks = self.told = self.first = self.second = self.unclear = self.wrong = 0

    def add(self, steps):
        self.blocks += 1
        self.told += bool(steps)
        cured = bool(steps) and steps[-1]["verdict"] == "accepted"
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
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--keep", type=pathlib.Path, help="folder for the edited blocks and their results")
    parser.add_argument("--only", default="", help="part of the name of the mistake")
    parser.add_argument("--check", type=float)
    arguments = parser.parse_args()
    lines = pathlib.Path(str(arguments.folder) + ".list").read_text(encoding="utf-8").splitlines()
    blocks = [one for one in (line.split("\t") for line in lines) if arguments.only in one[2]]

    def trial(block):
        scratch = pathlib.Path(tempfile.mkdtemp())
        if arguments.keep:
            scratch = arguments.keep / block[0]
            shutil.rmtree(scratch, ignore_errors=True)
            scratch.mkdir(parents=True)
        steps = follow(arguments.program, arguments.folder / block[0], scratch)
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
    for block, steps in zip(blocks, followed):
        if steps and (steps[-1]["verdict"] != "accepted" or is_wrong(steps)):
            print("\n" + " / ".join(block))
            print("\n".join(map(describe, steps)))
    if arguments.check is None:
        return 0
    return 0 if everything.cured() >= 0.01 * arguments.check * everything.told and not everything.wrong else 1


if __name__ == "__main__":
    sys.exit(main())
