#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Measures and prints a CSV:  scripts/bench.sh NAME
#   commands   wall time and peak memory of simulate, check and adjust for 1e3, 1e4 and 1e5 points
#   stages     stages of adjust for 1e3 to 1e6 points on the block of strips
#   reading    size of observations.csv, rate and peak memory of check for 1e5 and 1e6 points
#   engines    reduced engine against Ceres on the same blocks, interleaved
# Needs a Release build (scripts/demo.sh makes one). Machines are noisy: compare rows of one run.
set -euo pipefail
cd "$(dirname "$0")/.."
program=build/release/src/cli/sarblock
[ -x "$program" ] || { echo "bench.sh: build first: scripts/demo.sh" >&2; exit 2; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

exec python3 - "$program" "$work" "${1:-}" <<'PY'
import json, os, subprocess, sys, time

program, work, name = sys.argv[1:4]


def run(*arguments):
    """Wall seconds, peak MiB and standard output of one command."""
    begin = time.perf_counter()
    with open(f"{work}/out", "w") as out:
        process = subprocess.Popen([program, *arguments], stdout=out)
        _, status, usage = os.wait4(process.pid, 0)
    wall = time.perf_counter() - begin
    if status != 0:
        sys.exit(f"bench.sh: {' '.join(arguments)} ended with status {status}")
    return wall, usage.ru_maxrss / 1024, open(f"{work}/out").read()


def strips(points):
    """Overrides of the benchmark scene: one strip a side for every 2000 points, 5 to 150."""
    count = min(150, max(5, points // 2000))
    north = 13000 + 4800 * (count - 1) + 12000
    return [f"points.count={points}", f"flight.0.count={count}", f"flight.1.count={count}",
            f"points.north_m=[13000, {north}]"]


def block(points):
    folder = f"{work}/block{points}"
    sets = [item for key in strips(points) for item in ("--set", key)]
    simulated = run("simulate", "datasets/benchmarks/strips.toml", "-o", folder, *sets)
    return folder, simulated


def stages(folder, *extra):
    _, _, text = run("adjust", folder, "-o", f"{work}/result", "--json", *extra)
    return json.loads(text)


if name == "commands":
    print("points,looks,command,wall_s,peak_mib")
    for points in (1000, 10000, 100000):
        folder, (wall, peak, _) = block(points)
        looks = json.loads(run("check", folder, "--json")[2])["looks"]
        print(f"{points},{looks},simulate,{wall:.3f},{peak:.0f}")
        for command in ("check", "adjust"):
            extra = ["-o", f"{work}/result"] if command == "adjust" else []
            wall, peak, _ = run(command, folder, *extra)
            print(f"{points},{looks},{command},{wall:.3f},{peak:.0f}")
elif name == "stages":
    print("points,looks,passes,iterations,stage,wall_s,peak_mib")
    for points in (1000, 10000, 100000, 1000000):
        folder, _ = block(points)
        result = stages(folder)
        counts = result["counts"]
        for stage, cost in result["stages"].items():
            print(f"{points},{counts['looks']},{counts['passes']},{result['iterations']},{stage},"
                  f"{cost['wall_s']:.3f},{cost['peak_mib']:.0f}")
elif name == "reading":
    print("points,looks,observations_mb,check_wall_s,mb_per_s,peak_mib")
    for points in (100000, 1000000):
        folder, _ = block(points)
        size = os.path.getsize(f"{folder}/observations.csv") / 1e6
        wall, peak, text = run("check", folder, "--json")
        print(f"{points},{json.loads(text)['looks']},{size:.0f},{wall:.2f},{size / wall:.0f},{peak:.0f}")
elif name == "engines":
    print("points,engine,iterations,solve_s,s_per_iteration,peak_mib,sigma0_squared")
    for points in (1000, 10000, 100000):
        folder, _ = block(points)
        for _ in range(3):
            for engine in ("ceres", "reduced"):
                result = stages(folder, "--set", f"engine={engine}")
                solve = result["stages"]["solve"]
                print(f"{points},{engine},{result['iterations']},{solve['wall_s']:.4f},"
                      f"{solve['wall_s'] / result['iterations']:.5f},{solve['peak_mib']:.0f},"
                      f"{result['sigma0_squared']:.12f}")
else:
    sys.exit("bench.sh: NAME is commands, stages, reading or engines")
PY
