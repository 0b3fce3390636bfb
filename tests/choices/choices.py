#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What the program says of good blocks under the corrections that users choose.

    tests/choices/choices.py PROGRAM -o FOLDER [--seeds 0,1] [--scenes uav,moon-alse] [--only REGEX] [--biases all]
                             [--processes] [--engines] [--points 40] [--knots 16] [--jobs 2]

Ten ideal and four recorded scenes of datasets/scenes with 400 to 600 points, none of them with a mistake. Each is
adjusted with 22 choices: no corrections; polynomials of degree 0, 1, 2 and 4 and splines of eight knots in the longest
strip, with priors of 10, 100 and 1,000 m on each axis; degree 1 and splines with a range and a time bias too, with
--biases all every choice but none; with --processes splines whose priors are a Gauss-Markov process of five knots and a
random walk too. --points and --knots ask for other numbers of points and of knots. With --engines each is adjusted by
engine=ceres as well, and the largest difference of a point is printed, in its standard deviations along an axis.

What is so is known from truth_passes.csv, apart from the program: the errors of the recorded paths in track axes,
fitted by least squares in the terms of the choice.

    missing  no corrections
    tight    an error above three of its priors
    degree   0.3 m (rms) and more are left by the terms
    holds    none of these: a good block that is to be accepted

Printed are a line per adjustment (verdict, largest error over its prior, what the terms leave, s0^2, mean normalised
square of the points' true errors, iterations, first cause), a table of the four kinds, how many solutions that did not
converge name a look without a value as the reason, and how far points and time biases are off
where the program warns of curvature and where it does not; FOLDER/choices.json has the same. Seed 0 is that of the
scene. Python 3.9 and numpy. Not a test of its own: it measures how often, in minutes;
tests/diagnose/choices_test.cc holds a part of it."""
import argparse
import collections
import concurrent.futures
import csv
import gzip
import json
import math
import pathlib
import re
import subprocess

import numpy as np

SCENES = pathlib.Path(__file__).resolve().parents[2] / "datasets" / "scenes"
IDEAL = ("block-12-strips convergent-squint cross-wise different-altitudes earth-asc-desc earth-same-side leberl-aircraft "
         "leberl-voir moon-alse venus-magellan").split()
TERMS = (0, 1, 2, 4, "spline")
PROCESSES = ("markov", "walk")
SPLINES = ("spline", *PROCESSES)
BIASES = {"some": (1, *SPLINES), "all": TERMS + PROCESSES}
RECORDED = "airborne-turbulent downlink-orbit sparse-orbit uav".split()
PRIORS_M = (10, 100, 1000)
TIGHT, LEFT_M = 3.0, 0.3
CURVATURE_WARNED = 0.1  # from which on the program warns
CAUSES = {"missing": {"model.missing"}, "tight": {"model.priors"}, "degree": {"model.degree", "model.knots"}, "holds": set()}


def choices(biases_of, processes):
    """(name, terms, prior in metres, whether range and time have a bias); terms: None, a degree or one of SPLINES."""
    yield "none", None, 0, False
    for terms in TERMS + (PROCESSES if processes else ()):
        for prior_m in PRIORS_M:
            for biases in (False, True) if terms in biases_of else (False,):
                yield f"{terms}-{prior_m}" + ("-biases" if biases else ""), terms, prior_m, biases


def rows(path):
    path = path if path.exists() else path.with_name(path.name + ".gz")
    with (gzip.open if path.suffix == ".gz" else open)(path, "rt", encoding="utf-8") as file:
        yield from csv.DictReader(line for line in file if not line.startswith("#"))


def simulate(program, scene, seed, points, folder):
    path = SCENES / ("recorded" if scene in RECORDED else "") / f"{scene}.toml"
    shipped = int(re.search(r"\[points\]\s*\ncount = (\d+)", path.read_text(encoding="utf-8"))[1])
    values = [f"points.count={points or min(max(shipped, 400), 600)}"] + ([f"seed={seed}"] if seed else [])
    folder.parent.mkdir(parents=True, exist_ok=True)
    subprocess.run([program, "simulate", path, "-o", folder, "--quiet", *(word for value in values for word in ("--set", value))],
                   check=True, capture_output=True)


def states(path):
    out = collections.defaultdict(list)
    for row in rows(path):
        out[row["pass"]].append([float(row[name]) for name in ("time_s", "x_m", "y_m", "z_m", "vx_mps", "vy_mps", "vz_mps")])
    return {name: np.array(of) for name, of in out.items()}


def path_errors(block):
    """By pass: first and last time of its looks, its speed, and what its recorded path lacks of the true one along,
    across and up at the true states within the strip, whose times go from -1 to 1."""
    times = collections.defaultdict(list)
    for row in rows(block / "observations.csv"):
        times[row["pass"]].append(float(row["time_s"]))
    given, true = states(block / "trajectories.csv"), states(block / "truth_passes.csv")
    out = {}
    for name, of in times.items():
        first_s, last_s = min(of), max(of)
        at, g = true[name], given[name]
        at = at[(at[:, 0] >= g[0, 0]) & (at[:, 0] <= g[-1, 0] + 1e-9)]
        i = np.clip(np.searchsorted(g[:, 0], at[:, 0], side="right") - 1, 0, len(g) - 2)
        h = (g[i + 1, 0] - g[i, 0])[:, None]
        q = (at[:, :1] - g[i, :1]) / h
        recorded = ((1 + 2 * q) * (1 - q) ** 2 * g[i, 1:4] + q ** 2 * (3 - 2 * q) * g[i + 1, 1:4]
                    + h * (q * (1 - q) ** 2 * g[i, 4:] - q ** 2 * (1 - q) * g[i + 1, 4:]))
        along = at[:, 4:] / np.linalg.norm(at[:, 4:], axis=1, keepdims=True)
        up = at[:, 1:4] if np.linalg.norm(at[0, 1:4]) > 1e6 else np.tile([0.0, 0.0, 1.0], (len(at), 1))
        up = up - np.sum(up * along, axis=1, keepdims=True) * along
        up /= np.linalg.norm(up, axis=1, keepdims=True)
        error_m = at[:, 1:4] - recorded
        axes = [np.sum(error_m * axis, axis=1) for axis in (along, np.cross(up, along), up)]
        s = 2 * (at[:, 0] - first_s) / (last_s - first_s) - 1
        inside = np.abs(s) <= 1.05
        if inside.sum() < 4:
            inside = np.argsort(np.abs(s))[:4]
        out[name] = {"first_s": first_s, "last_s": last_s, "speed_mps": float(np.linalg.norm(at[0, 4:])),
                     "s": s[inside], "errors_m": np.stack(axes, axis=1)[inside]}
    return out


def compared_with_truth(errors, terms, prior_m):
    """Largest error over its prior, and the largest root mean square that the terms leave of the errors of a pass."""
    largest, left_m = 0.0, 0.0
    for of in errors.values():
        if terms is None:
            left_m = max(left_m, float(np.abs(of["errors_m"]).max()))
            continue
        degree = min(6 if terms in SPLINES else terms, len(of["s"]) - 1)
        legendre = np.polynomial.legendre.legvander(of["s"], degree)
        coefficients = np.linalg.lstsq(legendre, of["errors_m"], rcond=None)[0]
        rest = of["errors_m"] - legendre @ coefficients
        left_m = max(left_m, float(np.sqrt(np.mean(rest ** 2, axis=0)).max()))
        largest = max(largest, float(np.abs(of["errors_m"] if terms in SPLINES else coefficients).max()) / prior_m)
    return largest, left_m


def kind_of(terms, largest, left_m):
    if terms is None:
        return "missing"
    return "tight" if largest > TIGHT else "degree" if left_m >= LEFT_M else "holds"


def block_text(block, errors, terms, prior_m, biases, knots):
    """block.toml with other corrections."""
    text, kept = [], True
    for line in (block / "block.toml").read_text(encoding="utf-8").splitlines():
        if line.startswith("["):
            kept = not line.startswith(("[adjust", "[[adjust"))
        if kept:
            text.append(line)
    if terms is None:
        return "\n".join([*text, "[adjust]", 'corrections = "none"', ""])
    spacing_s = max(of["last_s"] - of["first_s"] for of in errors.values()) / (knots - 1)
    text += ["[adjust]", 'corrections = "given"', "[adjust.correction.position]", 'axes = "track"',
             *(['basis = "spline"', f"knot_spacing_s = {spacing_s!r}"] if terms in SPLINES
               else ['basis = "polynomial"', f"degree = {terms}"]),
             f"sigma_m = [{prior_m}, {prior_m}, {prior_m}]",
             *([f'process = "gauss-markov"\ncorrelation_time_s = {5 * spacing_s!r}'] if terms == "markov"
               else [f'process = "random-walk"\nstart_sigma_m = {prior_m}'] if terms == "walk" else [])]
    if biases:
        speed_mps = max(of["speed_mps"] for of in errors.values())
        text += ["[adjust.correction.range]", f"bias_sigma_m = {prior_m}",
                 "[adjust.correction.time]", f"bias_sigma_s = {prior_m / speed_mps!r}"]
    return "\n".join([*text, ""])


def enu_from_frame(row):
    """The rotation to the axes of a point's standard deviations."""
    if not row.get("lat_deg"):
        return np.eye(3)
    lat, lon = math.radians(float(row["lat_deg"])), math.radians(float(row["lon_deg"]))
    return np.array([[-math.sin(lon), math.cos(lon), 0],
                     [-math.sin(lat) * math.cos(lon), -math.sin(lat) * math.sin(lon), math.cos(lat)],
                     [math.cos(lat) * math.cos(lon), math.cos(lat) * math.sin(lon), math.sin(lat)]])


def positions(table):
    return {row["point"]: [float(row[name] or "nan") for name in ("x_m", "y_m", "z_m")] for row in table}


def apart(result, other):
    """Largest difference of a point between two results, in its standard deviations along an axis."""
    there, largest = positions(rows(other / "points.csv")), 0.0
    for row in rows(result / "points.csv"):
        if not row["sigma_e_m"]:
            continue
        here = np.array([float(row[name]) for name in ("x_m", "y_m", "z_m")])
        off = enu_from_frame(row) @ (here - there[row["point"]])
        sigmas = [float(row[f"sigma_{axis}_m"]) for axis in "enu"]
        largest = max(largest, float(np.nan_to_num(np.abs(off) / sigmas, nan=np.inf).max()))
    return largest


def mean_normalised_square(block, result):
    """e'C^-1 e / 3 of the points that are no control, by truth.csv."""
    truth = positions(rows(block / "truth.csv"))
    squares = []
    for row in rows(result / "points.csv"):
        if row["role"] == "control" or row["status"] != "adjusted" or row["point"] not in truth or not row["sigma_e_m"]:
            continue
        error_m = np.array([float(row[name]) for name in ("x_m", "y_m", "z_m")]) - truth[row["point"]]
        error_m = enu_from_frame(row) @ error_m
        c = np.diag([float(row[f"sigma_{axis}_m"]) ** 2 for axis in "enu"])
        for i, j, name in ((0, 1, "en"), (0, 2, "eu"), (1, 2, "nu")):
            c[i, j] = c[j, i] = float(row[f"cov_{name}_m2"])
        squares.append(error_m @ np.linalg.solve(c, error_m) / 3)
    return float(np.mean(squares)) if squares else math.nan


def time_biases(result):
    """Estimated time biases over their standard deviations; those of the scenes are zero."""
    return [float(row["value"]) / float(row["sigma"]) for row in rows(result / "passes.csv")
            if row["parameter"] == "time.bias" and row["sigma"]]


def run(program, folder, result, *options):
    ended = subprocess.run([program, "adjust", folder, "-o", result, "--quiet", "--force", "--threads", "1", *options],
                           capture_output=True, text=True, check=False)
    if ended.returncode > 1:
        return {"verdict": "refused", "cause": "", "reason": ended.stderr.strip().split("\n")[0]}
    summary = json.loads((result / "summary.json").read_text(encoding="utf-8"))
    explanations = summary.get("diagnosis") or []
    reasons = summary["verdict_reasons"]
    cause = explanations[0]["cause"] if explanations else ""
    if not cause and reasons and reasons[0].startswith("priors: the observations contradict"):
        cause = "model.priors"
    return {"verdict": summary["verdict"], "cause": cause, "reason": reasons[0] if reasons else "",
            "curvature": max((abs(of["curvature"]) for of in summary.get("curvatures", [])), default=0.0),
            "sigma0_squared": summary["sigma0_squared"], "iterations": summary["iterations"],
            "converged": not any(reason.startswith("not converged") for reason in reasons),
            "held": any("has no value: " in reason for reason in reasons)}


def adjust(options, block, errors, choice, folder):
    name, terms, prior_m, biases = choice
    folder = folder / name
    folder.mkdir(parents=True, exist_ok=True)
    for file in block.iterdir():
        if file.name not in ("block.toml", ".sarblock-written") and not (folder / file.name).exists():
            (folder / file.name).symlink_to(file.resolve())
    (folder / "block.toml").write_text(block_text(block, errors, terms, prior_m, biases, options.knots), encoding="utf-8")
    result = folder / "result"
    largest, left_m = compared_with_truth(errors, terms, prior_m)
    out = {"choice": name, "kind": kind_of(terms, largest, left_m), "error_over_prior": largest, "left_m": left_m,
           **run(options.program, folder, result)}
    if out["verdict"] != "refused":
        out["normalised_square"] = mean_normalised_square(block, result)
        if biases:
            out["time_biases"] = time_biases(result)
    if options.engines:
        out["ceres"] = run(options.program, folder, folder / "ceres", "--set", "engine=ceres")
        if "refused" not in (out["verdict"], out["ceres"]["verdict"]):
            out["apart_sigmas"] = apart(result, folder / "ceres")
    return out


def report(results):
    print(f"{'kind':9}{'blocks':>7}{'accepted':>10}{'not converged':>15}{'first cause right':>19}{'above 12 iterations':>21}{'most':>6}")
    for kind, causes in CAUSES.items():
        of = [result for result in results if result["kind"] == kind]
        accepted = sum(result["verdict"] == "accepted" for result in of)
        right = sum(result["verdict"] != "accepted" and result["cause"] in causes for result in of)
        iterations = [result["iterations"] for result in of if "iterations" in result]
        print(f"{kind:9}{len(of):7}{accepted:10}{sum(not result.get('converged', True) for result in of):15}{right:19}"
              f"{sum(n > 12 for n in iterations):21}{max(iterations, default=0):6}")
    ended = [result for result in results if not result.get("converged", True)]
    print(f"not converged: {len(ended)}, {sum(result['held'] for result in ended)} of them name a look without a value")
    for scene in dict.fromkeys(result["scene"] for result in results):
        for warned in (False, True):
            of = [result for result in results if result["scene"] == scene and result["kind"] == "holds"
                  and "normalised_square" in result and (result["curvature"] >= CURVATURE_WARNED) == warned]
            if not of:
                continue
            squares = [result["normalised_square"] for result in of]
            biases = np.array([bias for result in of for bias in result.get("time_biases", [])])
            print(f"{scene}, {'warned of' if warned else 'without a warning of'} curvature: {len(of)} good blocks, normalised square "
                  f"{np.mean(squares):.2f}, {max(squares):.2f} at most, {sum(result['iterations'] > 12 for result in of)} above 12 iterations"
                  + (f"; {len(biases)} time biases, {np.sqrt(np.mean(biases ** 2)):.2f} of their standard deviations off (rms), "
                     f"{np.abs(biases).max():.2f} at most" if len(biases) else ""))
    compared = [result for result in results if "ceres" in result]
    for engine, of in (("default engine", compared), ("engine=ceres", [result["ceres"] for result in compared])):
        iterations = [result["iterations"] for result in of if "iterations" in result]
        if iterations:
            print(f"{engine:15}{len(of):4} blocks, {sum(not result.get('converged', True) for result in of)} not converged, "
                  f"{sum(n > 12 for n in iterations)} above 12 iterations, {sum(iterations)} in all, {max(iterations)} at most")
    differences = [result["apart_sigmas"] for result in compared if "apart_sigmas" in result]
    if differences:
        print(f"engines apart by more than 1e-6 sigma: {sum(d > 1e-6 for d in differences)} of {len(differences)}, "
              f"at most {max(differences):.1e}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("program")
    parser.add_argument("-o", dest="folder", type=pathlib.Path, required=True)
    parser.add_argument("--seeds", default="0")
    parser.add_argument("--scenes", default=",".join(IDEAL + RECORDED))
    parser.add_argument("--only", default="")
    parser.add_argument("--biases", choices=BIASES, default="some")
    parser.add_argument("--engines", action="store_true")
    parser.add_argument("--processes", action="store_true")
    parser.add_argument("--points", type=int, default=0)
    parser.add_argument("--knots", type=int, default=8)
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    results = []
    for seed in map(int, options.seeds.split(",")):
        for scene in options.scenes.split(","):
            block = options.folder / "blocks" / f"{scene}-{seed}"
            if not block.exists():
                simulate(options.program, scene, seed, options.points, block)
            errors = path_errors(block)
            asked = [choice for choice in choices(BIASES[options.biases], options.processes) if re.match(options.only, choice[0])]
            folder = options.folder / "adjusted" / f"{scene}-{seed}"
            with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
                done = pool.map(lambda choice: adjust(options, block, errors, choice, folder), asked)
                for result in done:
                    result.update(scene=scene, seed=seed)
                    results.append(result)
                    print(f"{scene:19} {seed} {result['choice']:19} {result['kind']:8} {result['verdict']:24} "
                          f"{result['error_over_prior']:8.2f} {result['left_m']:8.2f} m  s0^2 {result.get('sigma0_squared', math.nan):8.3f}  "
                          f"{result.get('normalised_square', math.nan):8.2f} {result.get('iterations', 0):4} "
                          + (f"{result['ceres'].get('iterations', 0):4} {result.get('apart_sigmas', math.nan):8.1e} "
                             if options.engines else "") + result["cause"], flush=True)
    (options.folder / "choices.json").write_text(json.dumps(results, indent=1), encoding="utf-8")
    report(results)


if __name__ == "__main__":
    main()
