#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Corner reflectors in an RSLC of NISAR: where they are seen, and where they should be. Shares no code with
the program; needs Debian's python3-h5py (which brings numpy).

Usage: nisar_peaks.py PRODUCT.h5 REFLECTORS.csv [POINTS.csv]
Prints a row a reflector and, with a third argument, writes point,image,line,sample,line_sigma_px,
sample_sigma_px: lines and samples counted from 0 at the middle of the first pixel.

Predicted: the zero-Doppler time and range of the surveyed position, with the cubic of two states (of states
1 s apart in a low orbit it is right to 0.1 micrometre).

Measured: a chip of 64 x 64 pixels is moved to zero frequency by the phase from pixel to pixel, weighted by power, and
its Fourier series is evaluated at fractions of a pixel: the place of the largest magnitude, to 1e-4 pixel.

Standard deviation of a peak: that of the maximum of a band-limited signal in white noise,
sigma = sqrt(3/2) / (pi b sqrt(SNR)) pixels, b the bandwidth in cycles a pixel, SNR the peak's power over the median
power of the chip's corners / ln 2 (the median of exponentially distributed powers)."""
import csv
import datetime
import math
import sys

import h5py
import numpy as np

A_M, F = 6378137.0, 1.0 / 298.257223563
HALF = 32


def ecef(lat_deg, lon_deg, h):
    lat, lon, e2 = math.radians(lat_deg), math.radians(lon_deg), F * (2.0 - F)
    n = A_M / math.sqrt(1.0 - e2 * math.sin(lat) ** 2)
    return np.array([(n + h) * math.cos(lat) * math.cos(lon), (n + h) * math.cos(lat) * math.sin(lon),
                     (n * (1.0 - e2) + h) * math.sin(lat)])


def seconds(dataset):
    """Seconds of a day that the product's datasets share, and the day."""
    units = dataset.attrs["units"].decode()
    epoch = datetime.datetime.fromisoformat(units.removeprefix("seconds since ").replace(" ", "T")[:19])
    return dataset[()], epoch


class Product:
    def __init__(self, name):
        self.file = h5py.File(name)
        lsar = self.file["science/LSAR"]
        root = lsar["RSLC" if "RSLC" in lsar else "SLC"]
        self.lines, epoch = seconds(root["swaths/zeroDopplerTime"])
        self.ranges = root["swaths/frequencyA/slantRange"][()]
        times, orbit_epoch = seconds(root["metadata/orbit/time"])
        self.times = times + (orbit_epoch - epoch).total_seconds()
        self.position = root["metadata/orbit/position"][()]
        self.velocity = root["metadata/orbit/velocity"][()]
        self.pixels = root["swaths/frequencyA/HH"]
        self.side = lsar["identification/lookDirection"][()].decode().lower()
        frequency = root["swaths/frequencyA"]
        self.band_az = frequency["processedAzimuthBandwidth"][()] * (self.lines[1] - self.lines[0])
        self.band_rg = (frequency["processedRangeBandwidth"][()] * 2.0 *
                        (self.ranges[1] - self.ranges[0]) / 299792458.0)

    def state(self, t):
        k = min(max(int(np.searchsorted(self.times, t)) - 1, 0), len(self.times) - 2)
        h = self.times[k + 1] - self.times[k]
        u = (t - self.times[k]) / h
        p0, p1, v0, v1 = (self.position[k], self.position[k + 1], self.velocity[k], self.velocity[k + 1])
        p = ((2 * u**3 - 3 * u**2 + 1) * p0 + (u**3 - 2 * u**2 + u) * h * v0
             + (3 * u**2 - 2 * u**3) * p1 + (u**3 - u**2) * h * v1)
        v = ((6 * u**2 - 6 * u) * (p0 - p1) / h + (3 * u**2 - 4 * u + 1) * v0 + (3 * u**2 - 2 * u) * v1)
        return p, v

    def predict(self, point):
        """Line and sample of a position, and the speed of its footprint's Doppler equation."""
        t = 0.5 * (self.lines[0] + self.lines[-1])
        for _ in range(30):
            p, v = self.state(t)
            t += float(np.dot(point - p, v) / np.dot(v, v))
        p, v = self.state(t)
        return ((t - self.lines[0]) / (self.lines[1] - self.lines[0]),
                (np.linalg.norm(point - p) - self.ranges[0]) / (self.ranges[1] - self.ranges[0]))

    def chip(self, line, sample):
        """Complex pixels around a place: pairs of halves, which numpy has no complex type for."""
        kind = np.dtype([("r", "<f2"), ("i", "<f2")])
        first = [min(max(int(round(x)) - HALF, 0), n - 2 * HALF)
                 for x, n in ((line, self.pixels.shape[0]), (sample, self.pixels.shape[1]))]
        space = self.pixels.id.get_space()
        space.select_hyperslab(tuple(first), (2 * HALF, 2 * HALF))
        out = np.empty((2 * HALF, 2 * HALF), kind)
        memory = h5py.h5s.create_simple(out.shape)
        self.pixels.id.read(memory, space, out, h5py.h5t.py_create(kind))
        return first, out["r"].astype(float) + 1j * out["i"].astype(float)


def peak(chip):
    """Row, column and power of the largest magnitude."""
    rows, columns = np.indices(chip.shape)
    for axis, index in ((0, rows), (1, columns)):
        turn = np.angle(np.sum(np.take(chip, range(1, chip.shape[axis]), axis)
                               * np.conj(np.take(chip, range(chip.shape[axis] - 1), axis))))
        chip = chip * np.exp(-1j * turn * index)
    n, m = chip.shape
    series = np.fft.fft2(chip) / (n * m)
    kn, km = np.fft.fftfreq(n) * 2j * np.pi, np.fft.fftfreq(m) * 2j * np.pi
    power = lambda y, x: abs(np.exp(kn * y) @ series @ np.exp(km * x)) ** 2
    y, x = np.unravel_index(np.argmax(abs(chip)), chip.shape)
    for step in (0.3, 0.1, 0.03, 0.01, 3e-3, 1e-3, 3e-4, 1e-4):
        for _ in range(20):
            near = [(power(y + i * step, x + j * step), y + i * step, x + j * step)
                    for i in (-1, 0, 1) for j in (-1, 0, 1)]
            best = max(near)
            if best == near[4]:
                break
            _, y, x = best
    return y, x, power(y, x)


def measure(product, csv_name):
    """One dictionary a reflector."""
    found = []
    with open(csv_name, encoding="utf-8", newline="") as stream:
        for row in csv.reader(stream):
            if row[0].startswith(("#", "Corner")):
                continue
            at = ecef(*(float(cell) for cell in row[1:4]))
            line, sample = product.predict(at)
            first, chip = product.chip(line, sample)
            y, x, power = peak(chip)
            edge = HALF // 2
            corners = np.concatenate([abs(chip[i, j]).ravel() ** 2
                                      for i in (slice(0, edge), slice(-edge, None))
                                      for j in (slice(0, edge), slice(-edge, None))])
            snr = power / (np.median(corners) / math.log(2.0))
            sigma = [math.sqrt(1.5 / snr) / (math.pi * band) for band in (product.band_az, product.band_rg)]
            found.append({"point": row[0].strip(), "line": first[0] + y, "sample": first[1] + x,
                          "predicted_line": line, "predicted_sample": sample, "snr": snr,
                          "line_sigma_px": sigma[0], "sample_sigma_px": sigma[1], "position": at})
    return found


def write_points(found, name, image):
    with open(name, "w", encoding="utf-8", newline="") as stream:
        stream.write("point,image,line,sample,line_sigma_px,sample_sigma_px\n")
        for row in found:
            stream.write(",".join([row["point"], image] + [repr(float(row[key])) for key in (
                "line", "sample", "line_sigma_px", "sample_sigma_px")]) + "\n")


def main(arguments):
    product = Product(arguments[0])
    found = measure(product, arguments[1])
    spacing = product.ranges[1] - product.ranges[0]
    print("point   line      sample     minus predicted: line [px]  range [mm]   sigma [px, mm]      SNR [dB]")
    for row in found:
        print(f"{row['point']:6} {row['line']:9.4f} {row['sample']:10.4f}  {row['line'] - row['predicted_line']:20.5f}"
              f" {1e3 * spacing * (row['sample'] - row['predicted_sample']):12.1f}"
              f"   {row['line_sigma_px']:.5f} {1e3 * spacing * row['sample_sigma_px']:6.1f}"
              f" {10.0 * math.log10(row['snr']):14.1f}")
    if len(arguments) > 2:
        write_points(found, arguments[2], arguments[0].rsplit("/", 1)[-1])


if __name__ == "__main__":
    main(sys.argv[1:])
