#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Two radar images of a made-up orbit around the Moon with a control network, as cubes of ISIS and
as ISDs. Shares no code with the program: the truth of its importers.

Usage: moon_images.py FOLDER    writes one.cub, two.cub, one.json, two.json, moon.net, moon2.net

Circular orbits in inertial axes, a Moon that turns evenly about its z axis and then by a constant
rotation. Points lie on circles of zero Doppler and given range of the first image; line and sample
in both are solved for by bisection."""
import datetime
import json
import math
import pathlib
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import control_network  # noqa: E402

RADIUS = 1737400.0
MU = 4.9028e12
SPIN, SPIN0 = 2.6616995e-6, 0.7
TILT = [[0.9999998, -0.0006, 0.0002], [0.0006, 0.9999998, 0.0001], [-0.0002, -0.0001, 0.99999997]]
LIGHT = 299792458.0
LEAP = 34  # TAI - UTC of 2012-03-04


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def times(matrix, vector):
    return [dot(row, vector) for row in matrix]


def add(a, b, scale=1.0):
    return [x + scale * y for x, y in zip(a, b)]


def scaled(a, factor):
    return [factor * x for x in a]


def norm(a):
    return math.sqrt(dot(a, a))


def orthonormal(rows):
    """Gram-Schmidt: the constant rotation to the last digit."""
    first = scaled(rows[0], 1.0 / norm(rows[0]))
    second = add(rows[1], first, -dot(rows[1], first))
    second = scaled(second, 1.0 / norm(second))
    return [first, second, cross(first, second)]


CONSTANT = orthonormal(TILT)


def ephemeris_time(day_second):
    """Of a UTC second of 2012-03-04, by the formula of SPICE."""
    days = (datetime.date(2012, 3, 4) - datetime.date(2000, 1, 1)).days
    terrestrial = days * 86400.0 - 43200.0 + day_second + LEAP + 32.184
    mean = 6.239996 + 1.99096871e-7 * terrestrial
    return terrestrial + 1.657e-3 * math.sin(mean + 1.671e-2 * math.sin(mean))


class Image:
    def __init__(self, name, serial_time, day_second, height, node, coefficients):
        self.name, self.start_text, self.start = name, serial_time, ephemeris_time(day_second)
        self.day_second = day_second
        self.radius, self.node = RADIUS + height, node
        self.motion = math.sqrt(MU / self.radius ** 3)
        self.interval, self.pixel, self.lines, self.samples = 0.0100012, 15.0, 4000, 1200
        self.coefficients = coefficients  # (seconds after the start, a0 .. a3)
        self.serial = "LRO/MRFLRO/" + serial_time
        # Over longitude 0 of the body at the middle of the image.
        self.middle = self.start + 0.5 * self.lines * self.interval

    def inertial(self, time):
        u = self.motion * (time - self.middle) + 0.02
        w = SPIN0 + SPIN * (self.middle - ephemeris_time(0.0)) + self.node
        r = scaled([math.cos(u) * math.cos(w), math.cos(u) * math.sin(w), math.sin(u)], self.radius)
        v = scaled([-math.sin(u) * math.cos(w), -math.sin(u) * math.sin(w), math.cos(u)],
                   self.radius * self.motion)
        return r, v

    def state(self, time):
        w = SPIN0 + SPIN * (time - ephemeris_time(0.0))
        turn = [[math.cos(w), math.sin(w), 0], [-math.sin(w), math.cos(w), 0], [0, 0, 1]]
        r, v = self.inertial(time)
        relative = add(v, cross([0, 0, SPIN], r), -1.0)
        return times(CONSTANT, times(turn, r)), times(CONSTANT, times(turn, relative))

    def quaternion(self, time):
        w = SPIN0 + SPIN * (time - ephemeris_time(0.0))
        return [math.cos(w / 2), 0.0, 0.0, -math.sin(w / 2)]

    def slant(self, time, ground):
        sets = [(self.start + row[0], row[1:]) for row in self.coefficients]
        if time <= sets[0][0]:
            c = sets[0][1]
        elif time >= sets[-1][0]:
            c = sets[-1][1]
        else:
            k = max(i for i, one in enumerate(sets) if one[0] <= time)
            f = (time - sets[k][0]) / (sets[k + 1][0] - sets[k][0])
            c = [a + f * (b - a) for a, b in zip(sets[k][1], sets[k + 1][1])]
        return c[0] + ground * (c[1] + ground * (c[2] + ground * c[3]))

    def point(self, line, sample, height):
        """Where line and sample (first centre 1) see the sphere at this height, on the right."""
        time = self.start + (line - 1) * self.interval
        distance = self.slant(time, (sample - 1) * self.pixel)
        s, v = self.state(time)
        along = scaled(v, 1.0 / norm(v))
        nadir = add(s, along, -dot(s, along))
        nadir = scaled(nadir, 1.0 / norm(nadir))
        right = cross(along, nadir)
        a = ((RADIUS + height) ** 2 - distance ** 2 - dot(s, s)) / (2 * dot(s, nadir))
        b = math.sqrt(distance ** 2 - a * a)
        return add(add(s, nadir, a), right, b)

    def place(self, p):
        """Line and sample (first centre 1) of a point."""
        def behind(time):
            s, v = self.state(time)
            return dot(add(p, s, -1.0), v)
        time = bisect(behind, self.start - 30.0, self.start + 90.0)
        distance = norm(add(p, self.state(time)[0], -1.0))
        ground = bisect(lambda g: distance - self.slant(time, g), -20000.0, 60000.0)
        return (time - self.start) / self.interval + 1, ground / self.pixel + 1

    def label(self):
        sets = ",\n".join(
            '  ("2012-03-04T%02d:%02d:%09.6f", %r, %r, %r, %r)' % (
                (self.day_second + row[0]) // 3600, (self.day_second + row[0]) // 60 % 60,
                (self.day_second + row[0]) % 60, *row[1:]) for row in self.coefficients)
        return f"""Object = IsisCube
  Object = Core
    StartByte = 1
    Format = Tile
    Group = Dimensions
      Samples = {self.samples}
      Lines = {self.lines}
      Bands = 1
    End_Group
  End_Object
  Group = Instrument
    SpacecraftName = "LUNAR RECONNAISSANCE ORBITER"
    InstrumentHostId = LRO
    InstrumentId = MRFLRO
    TargetName = MOON
    StartTime = {self.start_text}
    IncidenceAngle = 50.5 <deg>
    LookDirection = RIGHT
    ScaledPixelHeight = {self.pixel}
    ScaledPixelWidth = {self.pixel}
    LineExposureDuration = {self.interval!r}
    AzimuthResolution = 30.5
    RangeResolution = 31.5
    RangeCoefficientSet = (
{sets})
    Frequency = 2380.0 <GHz>
  End_Group
  Group = Kernels
    InstrumentPosition = (Table, $lro/kernels/spk/a-
                          b.bsp)
  End_Group
End_Object
"""

    def tables(self):
        first, last = self.start - 40.0, self.start + 90.0
        steps = [first + 10.0 * k for k in range(14)]
        position = b"".join(
            struct.pack("<7d", *scaled(r, 1e-3), *scaled(v, 1e-3), t)
            for t in steps for r, v in [self.inertial(t)])
        rotation = b"".join(
            struct.pack("<8d", *self.quaternion(t), 0.0, 0.0, SPIN, t) for t in (first, last))
        return steps, position, (first, last), rotation

    def cube(self, start=4096):
        steps, position, ends, rotation = self.tables()

        def table(name, begin, data, records, fields, more=""):
            groups = "".join(f"  Group = Field\n    Name = {field}\n    Type = Double\n"
                             "    Size = 1\n  End_Group\n" for field in fields)
            return (f"Object = Table\n  Name = {name}\n  StartByte = {begin + 1}\n"
                    f"  Bytes = {len(data)}\n  Records = {records}\n  ByteOrder = Lsb\n{more}"
                    f"{groups}End_Object\n")
        constant = ", ".join(repr(x) for row in CONSTANT for x in row)
        label = self.label() + table(
            "InstrumentPosition", start, position, len(steps),
            ["J2000X", "J2000Y", "J2000Z", "J2000XV", "J2000YV", "J2000ZV", "ET"],
            "  CacheType = HermiteSpline\n") + table(
            "BodyRotation", start + len(position), rotation, len(ends),
            ["J2000Q0", "J2000Q1", "J2000Q2", "J2000Q3", "AV1", "AV2", "AV3", "ET"],
            f"  ConstantRotation = ({constant})\n") + (
            "Object = NaifKeywords\n  BODY301_RADII = (1737.4, 1737.4, 1737.4)\nEnd_Object\nEnd\n")
        label = label.encode()
        assert len(label) <= start, len(label)
        return label + b"\0" * (start - len(label)) + position + rotation

    def isd(self):
        steps, _, ends, _ = self.tables()
        states = [self.inertial(t) for t in steps]
        return {
            "name_model": "USGS_ASTRO_SAR_SENSOR_MODEL",
            "image_lines": self.lines, "image_samples": self.samples,
            "name_platform": "LUNAR RECONNAISSANCE ORBITER",
            "starting_ephemeris_time": self.start,
            "center_ephemeris_time": self.middle,
            "wavelength": LIGHT / 2.38e9,
            "line_exposure_duration": self.interval, "scaled_pixel_width": self.pixel,
            "range_conversion_times": [self.start + row[0] for row in self.coefficients],
            "range_conversion_coefficients": [list(row[1:]) for row in self.coefficients],
            "look_direction": "right",
            "radii": {"semimajor": 1737.4, "semiminor": 1737.4, "unit": "km"},
            "body_rotation": {
                "ephemeris_times": list(ends),
                "quaternions": [self.quaternion(t) for t in ends],
                "angular_velocities": [[0.0, 0.0, SPIN] for _ in ends],
                "constant_rotation": [x for row in CONSTANT for x in row], "reference_frame": 1},
            "instrument_position": {
                "ephemeris_times": steps,
                "positions": [scaled(r, 1e-3) for r, _ in states],
                "velocities": [scaled(v, 1e-3) for _, v in states], "reference_frame": 1}}


def bisect(function, low, high):
    """The zero of a function that falls."""
    assert function(low) > 0.0 > function(high)
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if function(middle) > 0.0 else (low, middle)
    return 0.5 * (low + high)


IMAGES = [
    Image("one", "2012-03-04T05:06:07.890123", 5 * 3600 + 6 * 60 + 7.890123, 50000.0, 0.0,
          [(0.01, 61000.0, 0.70, 4.1e-6, -3.9e-11), (11.0, 61001.5, 0.701, 4.12e-6, -3.9e-11),
           (25.3, 61004.0, 0.7005, 4.15e-6, -3.95e-11), (39.9, 61003.0, 0.699, 4.2e-6, -4e-11)]),
    Image("two", "2012-03-04T07:01:02.500000", 7 * 3600 + 60 + 2.5, 58000.0, -0.0100,
          [(0.0, 74000.0, 0.70, 4.1e-6, -3.9e-11), (20.0, 74003.0, 0.702, 4.0e-6, -3.9e-11),
           (40.0, 74001.0, 0.701, 4.05e-6, -3.8e-11)]),
]


def point_message(name, kind, position, measures, ignored=False, covariance=None):
    fields = [(1, 2, name.encode()), (2, 0, kind)]
    if ignored:
        fields.append((6, 0, 1))
    if position:
        fields += [(16 + k, 1, position[k]) for k in range(3)]
    if covariance:
        fields.append((19, 2, struct.pack("<6d", *covariance)))
    for serial, line, sample, unused, sigmas in measures:
        measure = [(1, 2, serial.encode()), (2, 0, 2), (3, 1, sample), (4, 1, line)]
        if unused:
            measure.append((10, 0, 1))
        if sigmas:
            measure += [(15, 1, sigmas[1]), (16, 1, sigmas[0])]
        fields.append((25, 2, control_network.message(measure)))
    return control_network.message(fields)


def network(sigmas=None, covariance=(400.0, 30.0, 0.0, 900.0, 0.0, 2500.0)):
    """Twelve points in both images: two fixed, three constrained, one ignored, one measure ignored."""
    header = [(1, 2, b"Test"), (2, 2, b"MOON")]
    points = []
    for k in range(12):
        line, sample, height = 400.0 + 271.25 * k, 150.0 + 83.5 * (k * 5 % 12), 40.0 * k - 200.0
        p = IMAGES[0].point(line, sample, height)
        measures = [(image.serial, *image.place(p), k == 7 and image is IMAGES[1], sigmas)
                    for image in IMAGES]
        kind = 4 if k < 2 else 3 if k < 5 else 2
        points.append(point_message(f"P{k}", kind, p if k != 6 else None, measures, k == 8,
                                    covariance if kind == 3 else None))
    return header, points


def main():
    folder = pathlib.Path(sys.argv[1])
    for image in IMAGES:
        (folder / f"{image.name}.cub").write_bytes(image.cube())
        (folder / f"{image.name}.json").write_text(json.dumps(image.isd(), indent=0), encoding="utf-8")
    header, points = network()
    (folder / "moon.net").write_bytes(control_network.network_bytes(header, points, 5, 1024))
    (folder / "moon2.net").write_bytes(control_network.network_bytes(header, points, 2, 1024))


if __name__ == "__main__":
    main()
