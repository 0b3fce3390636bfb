# SPDX-License-Identifier: Apache-2.0
"""Mistakes of a matcher: two points exchanged in one image, or a repeated pattern taken for the next."""
import collections
import csv
import json
import math
import random
import shutil
import subprocess

SCENES = ("block-12-strips", "earth-same-side", "venus-magellan", "moon-alse")
WAYS = ("quality.snooping=none", "quality.snooping=iterative", "quality.snooping=robust",
        "robust=huber", "robust=cauchy", "robust=tukey")
LIMIT_SIGMA = 10.0


def read_table(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def write_table(path, rows):
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def exchange(looks, ties, rng):
    """The ids of two points exchanged in one image."""
    image = rng.choice(sorted({look["pass"] for look in looks}))
    first, second = rng.sample([look["point"] for look in looks if look["pass"] == image], 2)
    other = {first: second, second: first}
    return [dict(look, point=other[look["point"]])
            if look["pass"] == image and look["point"] in other else look for look in looks], (image, first, second)


def shift(looks, ties, rng):
    """Thirty per cent of the tie looks of one image off alike, by up to 100 m in range and, in every second
    trial, 10 ms in time."""
    image = rng.choice(sorted({look["pass"] for look in looks}))
    mine = [k for k, look in enumerate(looks) if look["pass"] == image and look["point"] in ties]
    shifted = set(rng.sample(mine, int(0.3 * len(mine))))
    range_m = rng.choice((-1, 1)) * rng.uniform(20.0, 100.0)
    time_s = rng.choice((-1, 1)) * rng.choice((0.0, rng.uniform(2e-3, 1e-2)))
    return [dict(look, range_m=float(look["range_m"]) + range_m, time_s=float(look["time_s"]) + time_s)
            if k in shifted else look for k, look in enumerate(looks)], (image, round(range_m, 1), round(time_s, 4))


MISTAKES = {"exchanges": exchange, "mismatches": shift}


def east_north_up(point):
    """Axes of the covariance: those of the frame where it is local, else at the ellipsoid's normal."""
    if not point["lat_deg"]:
        return ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    lat, lon = math.radians(float(point["lat_deg"])), math.radians(float(point["lon_deg"]))
    return ((-math.sin(lon), math.cos(lon), 0),
            (-math.sin(lat) * math.cos(lon), -math.sin(lat) * math.sin(lon), math.cos(lat)),
            (math.cos(lat) * math.cos(lon), math.cos(lat) * math.sin(lon), math.sin(lat)))


def sigmas_off(point, truth):
    """sqrt(e' C^-1 e) of a point of points.csv; None where it has no covariance."""
    if not point["sigma_e_m"] or not point["x_m"]:
        return None
    difference = [float(point[c]) - float(truth[c]) for c in ("x_m", "y_m", "z_m")]
    e = [sum(a * d for a, d in zip(axis, difference)) for axis in east_north_up(point)]
    s = [float(point[f"sigma_{axis}_m"]) for axis in "enu"]
    c = [[s[0]**2, float(point["cov_en_m2"]), float(point["cov_eu_m2"])],
         [float(point["cov_en_m2"]), s[1]**2, float(point["cov_nu_m2"])],
         [float(point["cov_eu_m2"]), float(point["cov_nu_m2"]), s[2]**2]]
    # Cholesky of a 3 x 3, forward substitution.
    factor = [[0.0] * 3 for _ in range(3)]
    z = [0.0] * 3
    for i in range(3):
        for j in range(i):
            factor[i][j] = (c[i][j] - sum(factor[i][k] * factor[j][k] for k in range(j))) / factor[j][j]
        factor[i][i] = math.sqrt(c[i][i] - sum(factor[i][k]**2 for k in range(i)))
        z[i] = (e[i] - sum(factor[i][k] * z[k] for k in range(i))) / factor[i][i]
    return math.sqrt(sum(x * x for x in z))


def run(program, scenes, scratch, mistake, seed, trials, points, out):
    """`trials` mistakes over four scenes (of `points` tie points, where given), each adjusted in every
    way; returns the number of accepted results that hold a point off by more than ten of its standard
    deviations."""
    thinned = ["--set", f"points.count={points}"] if points else []
    if mistake == "exchanges":
        thinned += ["--set", "check.count=0"]
    rng = random.Random(seed)
    tallies = collections.Counter()
    worst = collections.defaultdict(float)
    wrong = 0
    for number, scene in enumerate(SCENES):
        clean, block, result = (scratch / f"{scene}-{kind}" for kind in ("clean", "wrong", "result"))
        subprocess.run([program, "simulate", scenes / f"{scene}.toml", "-o", clean, "-q", "--force",
                        *thinned], check=True, stdout=subprocess.DEVNULL)
        truth = {row["point"]: row for row in read_table(clean / "truth.csv")}
        looks = read_table(clean / "observations.csv")
        ties = {row["point"] for row in read_table(clean / "points.csv") if row["role"] == "tie"}
        shutil.rmtree(block, ignore_errors=True)
        shutil.copytree(clean, block)
        for _ in range((trials + len(SCENES) - 1 - number) // len(SCENES)):
            wrong_looks, what = MISTAKES[mistake](looks, ties, rng)
            write_table(block / "observations.csv", wrong_looks)
            for way in WAYS:
                shutil.rmtree(result, ignore_errors=True)
                ended = subprocess.run([program, "adjust", block, "-o", result, "--json", "--strict", "-q",
                                        "--threads", "1", "--set", way],
                                       capture_output=True, text=True, check=False)
                off = {}
                if (result / "points.csv").exists():
                    for point in read_table(result / "points.csv"):
                        sigmas = sigmas_off(point, truth[point["point"]])
                        if sigmas is not None and sigmas > LIMIT_SIGMA:
                            off[point["point"]] = round(sigmas, 1)
                outcome = {0: "accepted", 1: "not accepted"}.get(ended.returncode, f"exit {ended.returncode}")
                tallies[scene, way, outcome] += 1
                if ended.returncode == 0:
                    tallies[scene, way, "accepted, wrong"] += bool(off)
                    worst[scene, way] = max(worst[scene, way], *off.values(), 0.0)
                    wrong += bool(off)
                summary = json.loads(ended.stdout) if ended.stdout.startswith("{") else {}
                print(scene, *what, way, outcome, summary.get("sigma0_squared"), len(off),
                      "WRONG" if off and ended.returncode == 0 else "",
                      dict(sorted(off.items(), key=lambda x: -x[1])[:4]), ended.stderr.strip()[:200],
                      file=out, flush=True)
    print("\n| scene | way | accepted | not accepted | refused | accepted with a point off by more than "
          f"{LIMIT_SIGMA:.0f} sigma |\n| --- | --- | --- | --- | --- | --- |")
    for scene in SCENES:
        for way in WAYS:
            refused = sum(count for (s, w, outcome), count in tallies.items()
                          if (s, w) == (scene, way) and outcome.startswith("exit"))
            print(f"| {scene} | `{way}` | {tallies[scene, way, 'accepted']} | "
                  f"{tallies[scene, way, 'not accepted']} | {refused} | "
                  f"{tallies[scene, way, 'accepted, wrong']} |")
    return wrong
