#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What the times and ranges of a Sentinel-1 image of bursts hold beyond geometry, computed apart from
the program.

Usage: sentinel1_delays.py ANNOTATION.xml... At every point of the geolocation grid: the whole bistatic
residual, motion within the pulse and the mismatch of the FM rate by the formulas of docs/import.md,
with the acceleration of the antenna by differences of positions from Lagrange's polynomial.
tests/cli/sentinel1_test.py holds the program against it.
"""
import datetime
import math
import statistics
import sys
import xml.etree.ElementTree as ElementTree

from sentinel1_doppler import LIGHT_MPS, combine, dot, ecef, weights


def analyse(name):
    """By grid point: line, pixel, time and range, delays of the raster there, and tau_mid [s]."""
    root = ElementTree.parse(name).getroot()
    first = root.find(".//imageInformation/productFirstLineUtcTime").text

    def seconds(text):
        form = "%Y-%m-%dT%H:%M:%S.%f"
        return (datetime.datetime.strptime(text, form)
                - datetime.datetime.strptime(first, form)) / datetime.timedelta(seconds=1)

    def number(path, element=root):
        return float(element.find(path).text)

    def polynomials(path, name):
        return [(seconds(e.find("azimuthTime").text), number("t0", e),
                 [float(c) for c in e.find(name).text.split()]) for e in root.findall(path)]

    def value(polynomial, tau):
        return sum(c * (tau - polynomial[1]) ** k for k, c in enumerate(polynomial[2]))

    interval = number(".//imageInformation/azimuthTimeInterval")
    near, sampling = number(".//imageInformation/slantRangeTime"), number(".//rangeSamplingRate")
    middle = near + 0.5 * number(".//imageInformation/numberOfSamples") / sampling
    wavelength = LIGHT_MPS / number(".//radarFrequency")
    lines = int(number("swathTiming/linesPerBurst"))
    bursts = [seconds(e.text) for e in root.findall("swathTiming/burstList/burst/azimuthTime")]
    pulses = root.find(".//downlinkInformation/downlinkValues")
    listening = number("rank", pulses) * number("pri", pulses)
    orbit = [(seconds(o.find("time").text), [number(f"position/{c}", o) for c in "xyz"],
              [number(f"velocity/{c}", o) for c in "xyz"]) for o in root.findall(".//orbitList/orbit")]
    centroids = polynomials(".//dcEstimate", "dataDcPolynomial")
    rates = polynomials(".//azimuthFmRate", "azimuthFmRatePolynomial")

    def state(t, what):
        last = max(i for i, s in enumerate(orbit) if s[0] <= t)
        used = orbit[max(0, min(len(orbit) - 8, last - 3)):][:8]
        return combine(weights([s[0] for s in used], t), [s[what] for s in used])

    points = []
    for element in root.findall(".//geolocationGridPoint"):
        line, pixel = int(number("line", element)), int(number("pixel", element))
        lat, lon, height = (number(n, element) for n in ("latitude", "longitude", "height"))
        burst = min(line // lines, len(bursts) - 1)
        points.append({"line": line, "pixel": pixel, "tau_s": near + pixel / sampling, "burst": burst,
                       "raster_s": bursts[burst] + (line - burst * lines) * interval,
                       "grid_s": seconds(element.find("azimuthTime").text),
                       "place_m": ecef(lat, lon, height), "height_m": height,
                       "up": [math.cos(math.radians(lat)) * math.cos(math.radians(lon)),
                              math.cos(math.radians(lat)) * math.sin(math.radians(lon)),
                              math.sin(math.radians(lat))]})
    reference = statistics.median(p["tau_s"] - 2.0 * (p["grid_s"] - p["raster_s"]) for p in points)
    for p in points:
        tau, t = p["tau_s"], p["raster_s"]
        about = bursts[p["burst"]] + 0.5 * (lines - 1) * interval
        centroid = min(centroids, key=lambda e: abs(e[0] - about))
        rate = min(rates, key=lambda e: abs(e[0] - about))
        k_a = value(rate, tau)
        speed = math.sqrt(dot(state(about, 2), state(about, 2)))
        k_s = 2.0 * speed / wavelength * math.radians(number(".//azimuthSteeringRate"))
        k_t = k_a * k_s / (k_a - k_s)
        reference_t = value(centroid, middle) / value(rate, middle) - value(centroid, tau) / k_a
        f = value(centroid, tau) + k_t * (t - about - reference_t)
        step = 2.0
        before, here, after = (state(t + d, 1) for d in (-step, 0.0, step))
        acceleration = [(a - 2.0 * h + b) / step ** 2 for a, h, b in zip(after, here, before)]
        p["pulse_motion_m"] = -f * LIGHT_MPS / (2.0 * number("txPulseRampRate", pulses))
        sight = [s - q for s, q in zip(here, p["place_m"])]
        distance, h = math.sqrt(dot(sight, sight)), p["height_m"]
        # The true distance is less than the annotated one, by the standard atmosphere above all.
        zenith = h * h / 8.55e7 - h / 3411.0 + 2.41
        delay = zenith * distance / dot(sight, p["up"]) + p["pulse_motion_m"]
        sight = [x * (1.0 - delay / distance) for x in sight]
        velocity = state(t, 2)
        k_geo = (-2.0 * (dot(velocity, velocity) + dot(sight, acceleration))
                 / (wavelength * math.sqrt(dot(sight, sight))))
        p["bistatic_s"] = listening - 0.5 * (reference + tau)
        p["fm_rate_s"] = f * (1.0 / k_geo - 1.0 / k_a)
    return points, reference, reference - listening


def main():
    for name in sys.argv[1:]:
        points, reference, constant = analyse(name)
        print(f"{name}\n  tau_mid {1e3 * reference:.6f} ms, tau_mid - rank PRI {1e3 * constant:.6f} ms")
        for key, factor, unit in (("bistatic_s", 1e3, "ms"), ("fm_rate_s", 1e3, "ms"),
                                  ("pulse_motion_m", 1.0, "m")):
            values = [factor * p[key] for p in points]
            print(f"  {key:14} {min(values):8.4f} to {max(values):7.4f} {unit}, "
                  f"mean {statistics.mean(values):7.4f}")


if __name__ == "__main__":
    main()
