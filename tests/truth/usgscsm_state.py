#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Lines and samples of ground points in a model state of USGSCSM's SAR model, without the program.

Usage: usgscsm_state.py STATE.json X,Y,Z...    prints line and sample of each

Follows groundToImage() of UsgsAstroSarSensorModel.cpp and lagrangeInterp() of Utilities.cpp: the time at
which the Doppler vanishes, positions and velocities by Lagrange's polynomial of up to eight evenly spaced
states, each with its parameters added; range polynomials likewise, spaced by their span over their number;
the centre of the first pixel is 0.5, 0.5."""
import json
import math
import sys


def interpolate(values, width, first, step, time):
    """Row of a flat table of evenly spaced rows."""
    count = len(values) // width
    if count == 1:
        return values[:width]
    place = (time - first) / step
    k = min(max(int(math.floor(place)), 0), count - 2)
    half = 1
    for order, low, high in ((4, 3, 4), (3, 2, 3), (2, 1, 2)):
        if low <= k < count - high:
            half = order
            break
    row = [0.0] * width
    for i in range(k - half + 1, k + half + 1):
        weight = 1.0
        for j in range(k - half + 1, k + half + 1):
            if j != i:
                weight *= (place - j) / (i - j)
        for m in range(width):
            row[m] += weight * values[width * i + m]
    return row


class State:
    def __init__(self, path):
        with open(path, encoding="utf-8") as stream:
            name, text = stream.read().split("\n", 1)
        self.state = json.loads(text)
        assert name == self.state["m_modelName"] == "USGS_ASTRO_SAR_SENSOR_MODEL"
        for key in ("m_imageIdentifier", "m_platformIdentifier", "m_sensorIdentifier", "m_sensorName"):
            assert isinstance(self.state[key], str), key
        for key, count in (("m_covariance", 36), ("m_currentParameterValue", 6), ("m_referencePointXyz", 3)):
            assert len(self.state[key]) == count, key

    def antenna(self, time, key, parameters):
        s = self.state
        row = interpolate(s[key], 3, s["m_t0Ephem"], s["m_dtEphem"], time)
        return [a + b for a, b in zip(row, s["m_currentParameterValue"][parameters:parameters + 3])]

    def closing(self, time, point):
        s, v = self.antenna(time, "m_positions", 0), self.antenna(time, "m_velocities", 3)
        d = [a - b for a, b in zip(s, point)]
        return sum(a * b for a, b in zip(d, v)), math.sqrt(sum(a * a for a in d))

    def slant_range(self, ground_range, time):
        s = self.state
        times, values = s["m_scaleConversionTimes"], s["m_scaleConversionCoefficients"]
        step = (times[-1] - times[0]) / (len(values) // 4)
        c = interpolate(values, 4, times[0], step, time)
        return c[0] + ground_range * (c[1] + ground_range * (c[2] + ground_range * c[3]))

    def image(self, point):
        s = self.state
        low, high = s["m_startingEphemerisTime"], s["m_endingEphemerisTime"]
        sign = self.closing(low, point)[0]
        assert sign * self.closing(high, point)[0] < 0.0, "the Doppler does not vanish in the image"
        while high - low > 1e-7:
            middle = 0.5 * (low + high)
            if self.closing(middle, point)[0] * sign > 0.0:
                low = middle
            else:
                high = middle
        # Straight through the last interval: a double of ephemeris time steps by 0.06 us.
        a, b = self.closing(low, point)[0], self.closing(high, point)[0]
        part = a / (a - b)
        distance = (1 - part) * self.closing(low, point)[1] + part * self.closing(high, point)[1]
        line = ((low - s["m_startingEphemerisTime"]) + part * (high - low)) / s["m_exposureDuration"] + 0.5
        near, far = -s["m_nSamples"] * s["m_scaledPixelWidth"], 2 * s["m_nSamples"] * s["m_scaledPixelWidth"]
        while far - near > 1e-7:
            middle = 0.5 * (near + far)
            if self.slant_range(middle, low) < distance:
                near = middle
            else:
                far = middle
        return line, 0.5 * (near + far) / s["m_scaledPixelWidth"] + 0.5


def main():
    state = State(sys.argv[1])
    for place in sys.argv[2:]:
        print(*state.image([float(x) for x in place.split(",")]))


if __name__ == "__main__":
    main()
