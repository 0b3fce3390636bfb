#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes a block of straight passes around one reflector that all of them see.

    passes_of_one_point.py PASSES POINTS FOLDER [FEW]

POINTS tie points a pass are seen by it and by the next three. With FEW there is no reflector: every
pass sees two of FEW points, drawn at random, every tenth of them known to 0.5 m. Errors of the paths and of the
measurements have the standard deviations that block.toml states.
"""
import math
import os
import random
import sys

SPEED_MPS, MIDDLE_S = 180.0, 30.0
PATH_SIGMA_M = (2.1, 3.3, 1.7)  # along, across, up
RANGE_SIGMA_M, AZIMUTH_SIGMA_M = 0.7, 0.9


class Pass:
    """A level straight flight that has the middle of the area on its right."""

    def __init__(self, draw):
        heading = 2.0 * math.pi * draw.random()
        self.height_m = 8000.0 + 2000.0 * draw.random()
        self.distance_m = 9000.0 + 6000.0 * draw.random()
        self.along = (math.cos(heading), math.sin(heading), 0.0)
        self.right = (math.sin(heading), -math.cos(heading), 0.0)
        self.error_m = [draw.gauss(0.0, sigma) for sigma in PATH_SIGMA_M]

    def place(self, time_s, error_m=(0.0, 0.0, 0.0)):
        along_m = SPEED_MPS * (time_s - MIDDLE_S) + error_m[0]
        left_m = self.distance_m + error_m[1]
        up_m = self.height_m + error_m[2]
        return [along_m * a - left_m * r + up_m * u
                for a, r, u in zip(self.along, self.right, (0.0, 0.0, 1.0))]

    def look(self, point_m):
        """Time at which the true antenna has the point abeam, and its range."""
        along_m = sum(p * a for p, a in zip(point_m, self.along))
        time_s = MIDDLE_S + (along_m - self.error_m[0]) / SPEED_MPS
        return time_s, math.dist(self.place(time_s, self.error_m), point_m)


def main():
    count, points, folder = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
    few = int(sys.argv[4]) if len(sys.argv) > 4 else 0
    draw = random.Random(5)
    passes = [Pass(draw) for _ in range(count)]
    names = [f"P{i}" for i in range(count)]
    if few > 0:
        by = [[] for _ in range(few)]
        for i in range(count):
            for k in draw.sample(range(few), 2):
                by[k].append(i)
        seen = [(f"T{k}", (draw.uniform(-3000, 3000), draw.uniform(-3000, 3000), draw.uniform(-50, 50)), by[k])
                for k in range(few)]
    else:
        seen = [("R", (0.0, 0.0, 0.0), range(count))]
    for i in range(count):
        for k in range(points):
            place_m = (draw.uniform(-3000, 3000), draw.uniform(-3000, 3000), draw.uniform(-50, 50))
            seen.append((f"T{i}_{k}", place_m, [(i + j) % count for j in range(4)]))
    tables = {
        "block.toml": [
            'format = "sarblock-block 1"', 'name = "passes-of-one-point"', "[frame]", 'kind = "local"',
            "[sigma]", f"range_m = {RANGE_SIGMA_M}", f"azimuth_m = {AZIMUTH_SIGMA_M}",
            "[adjust.correction.position]", "degree = 0", 'axes = "track"',
            f"sigma_m = {list(PATH_SIGMA_M)}"],
        "points.csv": ["point,role,x_m,y_m,z_m,sigma_e_m,sigma_n_m,sigma_u_m"],
        "trajectories.csv": ["pass,time_s,x_m,y_m,z_m,vx_mps,vy_mps,vz_mps"],
        "observations.csv": ["pass,point,time_s,range_m"],
    }
    for name, one in zip(names, passes):
        tables["block.toml"] += ["[[pass]]", f'id = "{name}"', 'look = "right"', "start_s = 0", "end_s = 60"]
        velocity = ",".join(repr(SPEED_MPS * a) for a in one.along)
        for time_s in (-5.0, 65.0):
            place = ",".join(repr(x) for x in one.place(time_s))
            tables["trajectories.csv"].append(f"{name},{time_s},{place},{velocity}")
    for number, (point, place_m, by) in enumerate(seen):
        known = few > 0 and number % 10 == 0
        start = ",".join(f"{x + draw.gauss(0.0, 0.5 if known else 5.0):.3f}" for x in place_m)
        tables["points.csv"].append(f"{point},control,{start},0.5,0.5,0.5" if known else f"{point},tie,{start},,,")
        for i in by:
            time_s, range_m = passes[i].look(place_m)
            time_s += draw.gauss(0.0, AZIMUTH_SIGMA_M) / SPEED_MPS
            range_m += draw.gauss(0.0, RANGE_SIGMA_M)
            tables["observations.csv"].append(f"{names[i]},{point},{time_s:.9f},{range_m:.6f}")
    os.makedirs(folder, exist_ok=True)
    for name, lines in tables.items():
        with open(os.path.join(folder, name), "w", encoding="utf-8") as out:
            out.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
