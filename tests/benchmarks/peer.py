#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The adjustment of this library beside a plain program on Ceres (plain_ceres.cc), run by scripts/bench.sh peer.

    peer.py PROGRAM PLAIN WORK [[SCENE:]POINTS]...

Simulates leberl-aircraft with each number of points (300, 3,000 and 30,000 if none is given) and, if none is given,
block-12-strips and earth-same-side with 30,000, and runs in turn, on one thread, plain_ceres, `adjust` with
engine = "ceres" and `adjust`. The times are user times of whole processes, the least of SARBLOCK_ROUNDS (5); plain_ceres
reads, starts and solves, `adjust` also tests every look and writes its tables. Each block first without covariances, then
with those of all points. Beyond 3,000 points ceres::Covariance is asked for 100 of them only.

A second table has the looks as three programs would write them, each solved by Ceres alike: automatic derivatives of the
cone's form (what one writes first) and of the time's (the library's equations), and the library's cost functions: the time of an evaluation with
Jacobians and of a solution, the least of SARBLOCK_ROUNDS, and the farthest position from `adjust`, in its standard deviations.

The ratios are plain_ceres and engine = "ceres" over the default engine. The last columns are the largest difference of a
position from the default engine, in its standard deviations: of plain_ceres as it was timed, and with the equations of
the library (--form time), which must be below 1e-3."""
import json
import os
import resource
import subprocess
import sys

SCENES = "datasets/scenes"
MOST_COVARIANCES, SOME = 3000, 100
MOST_SIGMAS = 1e-3


def user_s(*command):
    """User seconds and standard output of a command."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False,
                          env={**os.environ, "OPENBLAS_NUM_THREADS": "1"})
    if done.returncode not in (0, 1):
        sys.exit(f"peer.py: {' '.join(command)} ended with status {done.returncode}")
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before, done.stdout


def rows(program, plain, work, scene, points):
    block, result = f"{work}/{scene}-{points}", f"{work}/{scene}-{points}-result"
    subprocess.run([program, "simulate", f"{SCENES}/{scene}.toml", "--set", f"points.count={points}", "-o", block, "-q"],
                   check=True)
    adjust = [program, "adjust", block, "--threads", "1", "--json"]
    user_s(*adjust, "-o", result)  # with covariances, to compare with
    same = {form: json.loads(user_s(plain, block, "--result", result, "--form", form)[1]) for form in ("cone", "time")}
    if same["time"]["points_sigmas"] > MOST_SIGMAS:
        sys.exit(f"peer.py: {scene} with {points} points: other solutions, {same['time']['points_sigmas']} sigmas apart")
    for level in ("none", "block"):
        count = 0 if level == "none" else points if points <= MOST_COVARIANCES else SOME
        other = ["-o", f"{work}/other", "--set", f"covariance={level}"]
        commands = {"plain": [plain, block, "--covariance", str(count)],
                    "ceres": [*adjust, *other, "--set", "engine=ceres"],
                    "default": [*adjust, *other]}
        least, said = {}, {}
        for _ in range(int(os.environ.get("SARBLOCK_ROUNDS", "5"))):
            for name, command in commands.items():
                seconds, text = user_s(*command)
                least[name] = min(seconds, least.get(name, seconds))
                said[name] = json.loads(text)
        yield [scene, points, said["plain"]["looks"], "none" if not count else "all" if count == points else count,
               *(said[name]["iterations"] for name in commands), *(f"{least[name]:.3f}" for name in commands),
               f"{least['plain'] / least['default']:.2f}", f"{least['ceres'] / least['default']:.2f}",
               *(f"{same[form]['points_sigmas']:.1e}" for form in same)]


def forms(program, plain, work, scene, points):
    block, result = f"{work}/{scene}-{points}", f"{work}/{scene}-{points}-result"
    said = {}
    for _ in range(int(os.environ.get("SARBLOCK_ROUNDS", "5"))):
        for form in ("cone", "time", "library"):
            now = json.loads(user_s(plain, block, "--result", result, "--form", form)[1])
            before = said.setdefault(form, now)
            for key in ("evaluate_ns", "solve_s"):
                before[key] = min(before[key], now[key])
    for form, now in said.items():
        yield [scene, points, form, f"{now['evaluate_ns']:.0f}", now["iterations"], f"{now['solve_s']:.3f}",
               f"{now['points_sigmas']:.1e}"]


def main():
    program, plain, work, *sizes = sys.argv[1:]
    print("scene,points,looks,covariances,iterations_plain,iterations_ceres,iterations,plain_s,ceres_s,default_s,"
          "plain_over_default,ceres_over_default,difference_sigmas,difference_same_form_sigmas")
    named = [size if ":" in size else f"leberl-aircraft:{size}" for size in sizes or ("300", "3000", "30000")]
    blocks = [(scene, int(points)) for scene, points in (name.split(":") for name in named)]
    if not sizes:
        blocks += [("block-12-strips", 30000), ("earth-same-side", 30000)]
    for scene, points in blocks:
        for row in rows(program, plain, work, scene, points):
            print(",".join(str(cell) for cell in row), flush=True)
    print("\nscene,points,form,evaluate_ns,iterations,solve_s,difference_sigmas")
    for scene, points in blocks:
        for row in forms(program, plain, work, scene, points):
            print(",".join(str(cell) for cell in row), flush=True)


if __name__ == "__main__":
    main()
