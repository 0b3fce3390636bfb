#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How a Sentinel-1 geolocation grid fits its orbit, computed apart from the program.

Usage: sentinel1_doppler.py ANNOTATION.xml... For each product: the Doppler equation e_d = v (p - s)
/ |v| and the range equation e_r = |p - s| - R at every grid point, with the position s from eight
states by Lagrange's polynomial and the velocity v once as the derivative of that polynomial, once
from the given velocities by the same polynomial; and the given velocities minus the derivative, in
track axes at the state nearest to the middle of the grid. docs/import.md quotes these numbers,
tests/cli/sentinel1_test.py holds the program against them.
"""
import datetime
import math
import sys
import xml.etree.ElementTree as ElementTree

LIGHT_MPS = 299792458.0
A_M, F = 6378137.0, 1.0 / 298.257223563


def dot(u, v):
    return sum(x * y for x, y in zip(u, v))


def cross(u, v):
    return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]


def unit(v):
    return [x / math.sqrt(dot(v, v)) for x in v]


def ecef(lat_deg, lon_deg, h):
    lat, lon, e2 = math.radians(lat_deg), math.radians(lon_deg), F * (2.0 - F)
    n = A_M / math.sqrt(1.0 - e2 * math.sin(lat) ** 2)
    return [(n + h) * math.cos(lat) * math.cos(lon), (n + h) * math.cos(lat) * math.sin(lon),
            (n * (1.0 - e2) + h) * math.sin(lat)]


def weights(times, x):
    return [math.prod((x - tj) / (ti - tj) for tj in times if tj != ti) for ti in times]


def slopes(times, x):
    return [sum(math.prod((x - tj) / (ti - tj) for tj in times if tj not in (ti, tk)) / (ti - tk)
                for tk in times if tk != ti) for ti in times]


def combine(factors, vectors):
    return [sum(f * v[c] for f, v in zip(factors, vectors)) for c in range(3)]


def analyse(name):
    """Misfits by grid point [m], and the excess of the given velocity along, across, up [m/s]."""
    root = ElementTree.parse(name).getroot()
    first = root.find(".//imageInformation/productFirstLineUtcTime").text

    def seconds(text):
        form = "%Y-%m-%dT%H:%M:%S.%f"
        return (datetime.datetime.strptime(text, form)
                - datetime.datetime.strptime(first, form)) / datetime.timedelta(seconds=1)

    def numbers(element, *names):
        return [float(element.find(n).text) for n in names]

    orbit = [(seconds(o.find("time").text), numbers(o.find("position"), "x", "y", "z"),
              numbers(o.find("velocity"), "x", "y", "z")) for o in root.findall(".//orbitList/orbit")]
    derived, given, ranges, grid_times = [], [], [], []
    for point in root.findall(".//geolocationGridPoint"):
        t = seconds(point.find("azimuthTime").text)
        place = ecef(*numbers(point, "latitude", "longitude", "height"))
        last = max(i for i, state in enumerate(orbit) if state[0] <= t)
        near = orbit[max(0, min(len(orbit) - 8, last - 3)):][:8]
        times = [state[0] for state in near]
        at = weights(times, t)
        line = [p - s for p, s in zip(place, combine(at, [state[1] for state in near]))]
        derived.append(dot(unit(combine(slopes(times, t), [state[1] for state in near])), line))
        given.append(dot(unit(combine(at, [state[2] for state in near])), line))
        ranges.append(math.sqrt(dot(line, line))
                      - 0.5 * LIGHT_MPS * float(point.find("slantRangeTime").text))
        grid_times.append(t)
    middle = 0.5 * (min(grid_times) + max(grid_times))
    k = min(range(4, len(orbit) - 4), key=lambda i: abs(orbit[i][0] - middle))
    near = orbit[k - 4:k + 5]
    t, position, velocity = orbit[k]
    motion = combine(slopes([state[0] for state in near], t), [state[1] for state in near])
    excess = [v - m for v, m in zip(velocity, motion)]
    along = unit(velocity)
    up = unit([p - dot(position, along) * a for p, a in zip(position, along)])
    return {"derived_m": derived, "given_m": given, "range_m": ranges,
            "excess_mps": [dot(excess, axis) for axis in (along, cross(up, along), up)],
            "speed_mps": math.sqrt(dot(velocity, velocity))}


def report(name):
    found = analyse(name)
    print(name)
    for what, key in (("e_d, velocity from positions", "derived_m"),
                      ("e_d, velocities as given", "given_m"), ("e_r", "range_m")):
        values = found[key]
        print(f"  {what:30} {1e3 * min(values):8.2f} to {1e3 * max(values):7.2f} mm, "
              f"mean {1e3 * sum(values) / len(values):7.2f} mm")
    along, across, up = (1e3 * x for x in found["excess_mps"])
    print(f"  given velocity minus motion of the positions: along {along:.2f}, across {across:.2f}, "
          f"up {up:.2f} mm/s")


def main():
    for name in sys.argv[1:]:
        report(name)


if __name__ == "__main__":
    main()
