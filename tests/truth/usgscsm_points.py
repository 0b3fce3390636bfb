#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Ground points of an ISD after USGSCSM's SAR model, without the program: which point of the sphere a
line and a sample are.

Usage: usgscsm_points.py ISD.json [times|usgscsm] LINE,SAMPLE...    prints x, y, z [m] of each
       usgscsm_points.py ISD.json --network NET.net --serial SERIAL  writes a network of such points

Follows imageToGround() of UsgsAstroSarSensorModel.cpp: the centre of the first pixel is 0.5, 0.5; range
polynomials at the times USGSCSM gives them (`usgscsm`, linear in the first interval) or at their own."""
import argparse
import bisect
import json
import math
import pathlib
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import control_network  # noqa: E402


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def combine(*terms):
    return [sum(factor * vector[k] for factor, vector in terms) for k in range(3)]


def unit(a):
    return [x / math.sqrt(dot(a, a)) for x in a]


def matrix(q):
    w, x, y, z = q
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]


def cubic_state(times, states, time):
    """Position and velocity on the cubic of the two states around a time."""
    k = max(0, min(len(times) - 2, bisect.bisect(times, time) - 1))
    (s0, v0), (s1, v1) = states[k], states[k + 1]
    h = times[k + 1] - times[k]
    u = (time - times[k]) / h
    s = combine((2 * u ** 3 - 3 * u * u + 1, s0), ((u ** 3 - 2 * u * u + u) * h, v0),
                (3 * u * u - 2 * u ** 3, s1), ((u ** 3 - u * u) * h, v1))
    v = combine((6 * (u * u - u) / h, s0), (3 * u * u - 4 * u + 1, v0),
                (6 * (u - u * u) / h, s1), (3 * u * u - 2 * u, v1))
    return s, v


class Model:
    def __init__(self, path):
        with open(path, encoding="utf-8") as stream:
            self.isd = json.load(stream)
        position, body = self.isd["instrument_position"], self.isd["body_rotation"]
        assert position["ephemeris_times"] == body["ephemeris_times"], "states and attitudes differ in times"
        self.times = position["ephemeris_times"]
        c = body["constant_rotation"]
        constant = [c[0:3], c[3:6], c[6:9]]
        self.states = []
        for q, w, r, v in zip(body["quaternions"], body["angular_velocities"],
                              position["positions"], position["velocities"]):
            def turned(vector, q=q):
                inner = [dot(row, vector) for row in matrix(q)]
                return [1e3 * dot(row, inner) for row in constant]
            self.states.append((turned(r), turned(combine((1, v), (-1, cross(w, r))))))
        self.radius = 1e3 * self.isd["radii"]["semimajor"]
        self.sign = 1 if self.isd["look_direction"] == "right" else -1

    def time(self, line):
        return self.isd["starting_ephemeris_time"] + (line - 0.5) * self.isd["line_exposure_duration"]

    def state(self, time):
        return cubic_state(self.times, self.states, time)

    def slant_range(self, line, sample, reading):
        times, sets = self.isd["range_conversion_times"], self.isd["range_conversion_coefficients"]
        time = self.time(line)
        if reading == "usgscsm":
            step = (times[-1] - times[0]) / len(times)
            times = [times[0] + k * step for k in range(len(times))]
            assert time < times[1], "the first interval only: it is linear there"
        k = max(0, min(len(times) - 2, bisect.bisect(times, time) - 1))
        f = (time - times[k]) / (times[k + 1] - times[k])
        if reading == "times":
            f = min(1.0, max(0.0, f))
        c = [a + f * (b - a) for a, b in zip(sets[k], sets[k + 1])]
        g = (sample - 0.5) * self.isd["scaled_pixel_width"]
        return c[0] + g * (c[1] + g * (c[2] + g * c[3]))

    def ground(self, line, sample, reading):
        distance = self.slant_range(line, sample, reading)
        s, v = self.state(self.time(line))
        along = unit(v)
        nadir = unit(combine((1, s), (-dot(s, along), along)))
        right = cross(along, nadir)
        a = (self.radius ** 2 - distance ** 2 - dot(s, s)) / (2 * dot(s, nadir))
        b = self.sign * math.sqrt(distance ** 2 - a * a)
        return combine((1, s), (a, nadir), (b, right))


def write_network(model, path, serial):
    """Five constrained points, 20 m, and two free ones, in the first 700 lines of the image."""
    header = [(1, 2, b"Example"), (2, 2, b"MOON")]
    points = []
    lines, samples = min(model.isd["image_lines"], 700), model.isd["image_samples"]
    for k, (x, y) in enumerate([(.1, .2), (.3, .8), (.5, .4), (.7, .9), (.9, .3), (.2, .5), (.8, .6)]):
        line, sample = round(x * lines, 1), round(y * samples, 1)
        p = model.ground(line, sample, "times")
        fields = [(1, 2, f"G{k + 1}".encode()), (2, 0, 3 if k < 5 else 2)]
        fields += [(16 + i, 1, p[i]) for i in range(3)]
        if k < 5:
            fields.append((19, 2, struct.pack("<6d", 400, 0, 0, 400, 0, 400)))
        measure = [(1, 2, serial.encode()), (2, 0, 2), (3, 1, sample), (4, 1, line)]
        points.append(control_network.message(fields + [(25, 2, control_network.message(measure))]))
    pathlib.Path(path).write_bytes(control_network.network_bytes(header, points, 5, 1024))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("isd")
    parser.add_argument("reading", nargs="?", default="times", choices=("times", "usgscsm"))
    parser.add_argument("places", nargs="*")
    parser.add_argument("--network")
    parser.add_argument("--serial", default="")
    arguments = parser.parse_args()
    model = Model(arguments.isd)
    if arguments.network:
        write_network(model, arguments.network, arguments.serial)
    for place in arguments.places:
        print(*model.ground(*map(float, place.split(",")), arguments.reading))


if __name__ == "__main__":
    main()
