#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Model states of USGSCSM made of adjusted ISDs; run by ctest.

Environment: SARBLOCK_PROGRAM. Two images of a made-up lunar orbiter: ISDs, whose path, clock and range are
off by known amounts, and points measured in them. Evidence: an independent reader of model states
(tests/truth/usgscsm_state.py), the round trip through `import`, and the covariance by dense algebra."""
import json
import math
import pathlib
import random
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "truth"))
import usgscsm_state  # noqa: E402
from measured_images import MeasuredImages, congruence, run, table, write_table  # noqa: E402
from usgscsm_points import combine, cross, dot, unit  # noqa: E402

RADIUS, MU, SPIN = 1737400.0, 4.9028e12, 2.6616995e-6
START, LINE, WIDTH, LINES, SAMPLES = 384109634.25, 0.0101, 15.0, 2400, 1200
HEIGHT = 51300.0


class Flight:
    """A circular orbit in inertial axes, over the place (1, 0, 0) in the middle of the image."""

    def __init__(self, inclination_deg, first_line):
        self.first_line, self.radius = first_line, RADIUS + HEIGHT
        self.rate = math.sqrt(MU / self.radius ** 3)
        self.middle = first_line + 0.5 * LINES * LINE
        i = math.radians(inclination_deg)
        self.north = [0.0, math.cos(i), math.sin(i)]
        # Beside the place, so that it is seen to the right at 45 degrees.
        self.centre = unit(combine((1, [1.0, 0, 0]), (-0.03, cross(self.north, [1.0, 0, 0]))))

    def state(self, time):
        a = self.rate * (time - self.middle)
        c, n = self.centre, self.north
        return (combine((self.radius * math.cos(a), c), (self.radius * math.sin(a), n)),
                combine((-self.radius * self.rate * math.sin(a), c), (self.radius * self.rate * math.cos(a), n)))

    def turn(self, time, vector, back=False):
        """Body-fixed axes turn about z; they are inertial ones in the middle of the image."""
        a = SPIN * (time - self.middle) * (-1 if back else 1)
        c, s = math.cos(a), math.sin(a)
        return [c * vector[0] + s * vector[1], c * vector[1] - s * vector[0], vector[2]]

    def fixed(self, time):
        r, v = self.state(time)
        return self.turn(time, r), self.turn(time, combine((1, v), (-1, cross([0, 0, SPIN], r))))

    def polynomial(self, time):
        """Slant range by ground range, growing more slowly with time."""
        dt = time - self.first_line
        return [73000.0 + 2.0 * math.sin(dt), 0.69 + 1e-4 * math.sin(0.7 * dt), 3.3e-6, -2.4e-11]

    def isd(self, path, sun=True):
        times = [self.first_line - 2.0 + 0.25 * k for k in range(int(4 * (LINES * LINE + 4.0)) + 2)]
        attitudes = [times[0], times[-1]]
        polynomial_times = [self.first_line + 3.1 * k for k in range(9)]

        def quaternion(time):
            a = -0.5 * SPIN * (time - self.middle)
            return [math.cos(a), 0.0, 0.0, math.sin(a)]
        text = {"name_model": "USGS_ASTRO_SAR_SENSOR_MODEL", "name_platform": "Orbiter", "name_sensor": "Radar",
                "image_lines": LINES, "image_samples": SAMPLES, "wavelength": 0.126,
                "starting_ephemeris_time": self.first_line, "line_exposure_duration": LINE,
                "scaled_pixel_width": WIDTH, "look_direction": "right",
                "radii": {"semimajor": RADIUS / 1e3, "semiminor": RADIUS / 1e3, "unit": "km"},
                "range_conversion_times": polynomial_times,
                "range_conversion_coefficients": [self.polynomial(t) for t in polynomial_times],
                "body_rotation": {"ephemeris_times": attitudes, "reference_frame": 1,
                                  "quaternions": [quaternion(t) for t in attitudes],
                                  "angular_velocities": [[0.0, 0.0, SPIN]] * 2},
                "instrument_position": {"ephemeris_times": times, "reference_frame": 1,
                                        "positions": [combine((1e-3, self.state(t)[0])) for t in times],
                                        "velocities": [combine((1e-3, self.state(t)[1])) for t in times]}}
        if sun:
            text["sun_position"] = {"ephemeris_times": [self.middle], "positions": [[1.2e8, 8e7, 3e7]],
                                    "velocities": [[-16.0, 23.0, 10.0]], "reference_frame": 1}
        path.write_text(json.dumps(text), encoding="utf-8")

    def range_at(self, time, ground_range):
        """Polynomials at their times, linear between two."""
        k = max(0, min(7, int((time - self.first_line) / 3.1)))
        f = (time - self.first_line) / 3.1 - k
        c = [(1 - f) * a + f * b for a, b in zip(self.polynomial(self.first_line + 3.1 * k),
                                                 self.polynomial(self.first_line + 3.1 * (k + 1)))]
        return c[0] + ground_range * (c[1] + ground_range * (c[2] + ground_range * c[3]))

    def see(self, point, errors):
        """Line and sample (counted from 0) of a point, where the ISD is wrong by `errors`."""
        def antenna(time):  # at the measured time
            s, v = self.fixed(time + errors["time"])
            x = (time - self.middle) / (0.5 * LINES * LINE)
            delta = combine((1, errors["offset"]), (x, errors["drift"]))
            return combine((1, s), (1, delta)), combine((1, v), (1 / (0.5 * LINES * LINE), errors["drift"]))
        low, high = self.first_line - 1.5, self.first_line + LINES * LINE + 1.5
        for _ in range(60):
            middle = 0.5 * (low + high)
            s, v = antenna(middle)
            if dot(combine((1, point), (-1, s)), v) > 0.0:
                low = middle
            else:
                high = middle
        d = combine((1, point), (-1, antenna(low)[0]))
        measured = math.sqrt(dot(d, d)) * (1 + errors["scale"]) + errors["range"]
        near, far = -1e4, 4e4
        for _ in range(60):
            middle = 0.5 * (near + far)
            if self.range_at(low, middle) < measured:
                near = middle
            else:
                far = middle
        return (low - self.first_line) / LINE, near / WIDTH


ERRORS = {"one": {"offset": [43.0, -25.5, 61.0], "drift": [3.1, -4.2, 2.7], "time": 0.0213, "range": 12.7,
                  "scale": 2e-5},
          "two": {"offset": [-31.0, 55.5, 18.0], "drift": [-2.2, 1.7, 3.9], "time": -0.0172, "range": -8.1,
                  "scale": -3e-5}}
FLIGHTS = {"one": Flight(83.0, START), "two": Flight(131.0, START + 7200.5)}


class ModelStates(MeasuredImages):
    form, ending = "csm", ".adjusted_state.json"
    SIGMAS = ("--range-sigma-m", 4, "--azimuth-sigma-m", 5)

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        draw = random.Random(5)
        cls.points, matches = {}, []
        while len(cls.points) < 60:
            direction = unit([1.0, draw.uniform(-8e-3, 8e-3), draw.uniform(-8e-3, 8e-3)])
            point = combine((RADIUS + draw.uniform(-900, 900), direction))
            places = {name: flight.see(point, ERRORS[name]) for name, flight in FLIGHTS.items()}
            if any(not (0 < line < LINES and 0 < sample < SAMPLES) for line, sample in places.values()):
                continue
            name = f"P{len(cls.points)}"
            cls.points[name] = point
            for image, (line, sample) in places.items():
                matches.append({"point": name, "image": image, "line": line + draw.gauss(0, 0.3),
                                "sample": sample + draw.gauss(0, 0.3)})
        cls.isds = {name: cls.folder / f"{name}.json" for name in FLIGHTS}
        for name, flight in FLIGHTS.items():
            flight.isd(cls.isds[name])
        write_table(cls.folder / "matches.csv", matches)
        cls.matches = matches
        cls.nominal = cls.make_block("nominal", cls.isds, *cls.SIGMAS)

    FULL = ("correction.position.degree=1", "correction.position.axes=frame",
            "correction.position.sigma_m=[[80,10],[80,10],[80,10]]",
            "correction.time.bias_sigma_s=0.05", "correction.range.bias_sigma_m=20",
            "correction.range.scale_sigma_ppm=50")

    def test_states_measure_the_adjusted_points_as_the_result_does(self):
        result = self.adjust(self.nominal, "full", *self.FULL)
        states, report = self.export(result, "full-states", self.isds)
        # Without corrections the looks are off by hundreds of metres.
        self.assertLess(max(self.residuals(result)), 10.0)
        uncarried = [text for text in report["not_carried"] if "range.scale" not in text and "range.bias" not in text]
        self.assertEqual([text for text in uncarried if text.startswith(("one: between", "two: between"))], [])
        self.assert_round_trip(result, states, *self.SIGMAS)

    def test_an_independent_reader_sees_the_adjusted_points_where_they_were_measured(self):
        result = self.adjust(self.nominal, "read", *self.FULL)
        self.assert_read_as_measured(result, self.export(result, "read-states", self.isds)[0])

    def test_a_turned_direction_of_flight_is_in_the_velocities_alone(self):
        result = self.adjust(self.nominal, "turned", *self.FULL, "correction.velocity.sigma=1e-3")
        states, _ = self.export(result, "turned-states", self.isds)
        self.assert_read_as_measured(result, states)
        values = self.parameters(result, "one")
        self.assertGreater(math.hypot(values["velocity.across"], values["velocity.up"]), 1e-5)
        # The importer's path goes through positions and velocities: it takes no such state.
        self.assertIn("velocities that turn the Doppler cone", run(
            "import", "images", *states.values(), "--points", self.folder / "matches.csv", "--id", *FLIGHTS, "-o",
            self.folder / "turned-again", code=3).stderr)

    def assert_read_as_measured(self, result, states):
        points = self.adjusted(result)
        measured = {(row["point"], row["image"]): (row["line"], row["sample"]) for row in self.matches}
        rows = self.rows_of(result)
        for image, path in states.items():
            state = usgscsm_state.State(path)
            for name, point in list(points.items())[:25]:
                line, sample = state.image(point)
                row = rows[(name, image)]
                # Computed less measured, in steps of the image; its first pixel is 0, 0, of USGSCSM 0.5, 0.5.
                self.assertAlmostEqual(line - 0.5 - measured[name, image][0], float(row["line_residual_px"]), 3)
                self.assertAlmostEqual(sample - 0.5 - measured[name, image][1], float(row["pixel_residual_px"]), 3)

    def test_splines_and_the_reading_of_usgscsm_make_the_round_trip(self):
        block = self.make_block("uneven", self.isds, *self.SIGMAS)
        result = self.adjust(block, "spline", "correction.position.basis=spline",
                             "correction.position.knot_spacing_s=6", "correction.position.sigma_m=[80,80,80]",
                             "correction.range.bias_sigma_m=20")
        states, _ = self.export(result, "spline-states", self.isds, "--range-polynomial", "times")
        self.assert_round_trip(result, states, *self.SIGMAS)
        # As USGSCSM spaces them polynomials go as they stand, but for the range bias.
        states, _ = self.export(result, "plain-states", self.isds, "--range-polynomial", "usgscsm")
        state = usgscsm_state.State(states["one"]).state
        bias = self.parameters(result, "one")["range.bias"]
        self.assertEqual(len(state["m_scaleConversionTimes"]), 9)
        for k, time in enumerate(state["m_scaleConversionTimes"]):
            given = FLIGHTS["one"].polynomial(time)
            self.assertAlmostEqual(state["m_scaleConversionCoefficients"][4 * k], given[0] - bias, 8)
            self.assertEqual(state["m_scaleConversionCoefficients"][4 * k + 1], given[1])

    @staticmethod
    def covariance_of(state):
        flat = usgscsm_state.State(state).state["m_covariance"]
        return [flat[6 * i:6 * i + 6] for i in range(6)]

    def test_an_offset_gives_its_own_covariance_back(self):
        result = self.adjust(self.nominal, "offset", "correction.position.degree=0",
                             "correction.position.axes=frame", "correction.position.sigma_m=[80,80,80]")
        states, report = self.export(result, "offset-states", self.isds)
        own = self.covariance(result, "two", [f"position.{axis}.0" for axis in "xyz"])
        expected = [[own[i][j] if max(i, j) < 3 else 0.0 for j in range(6)] for i in range(6)]
        self.assert_matrix(self.covariance_of(states["two"]), expected, 1e-11)
        self.assertEqual([text for text in report["not_carried"] if "about it" in text], [])

    def test_the_covariance_is_that_of_the_mean_antenna_by_dense_algebra(self):
        names = [f"position.{axis}.{k}" for axis in "xyz" for k in (0, 1)]
        result = self.adjust(self.nominal, "drift", *self.FULL[:3])
        states, report = self.export(result, "drift-states", self.isds)
        summary = json.loads((result / "summary.json").read_text(encoding="utf-8"))["passes"][0]
        own = self.covariance(result, "one", names)
        # The strip goes from the first look to the last; the fit over the image.
        half, middle = 0.5 * (summary["end_s"] - summary["start_s"]), 0.5 * (summary["end_s"] + summary["start_s"])
        toml = (self.nominal / "block.toml").read_text(encoding="utf-8")
        first = float(next(line for line in toml.splitlines() if line.startswith("first_line_s")).split("=")[1])
        mean = (first + 0.5 * LINES * LINE - middle) / half
        gain = [[0.0] * 6 for _ in range(6)]
        for axis in range(3):
            gain[axis][2 * axis], gain[axis][2 * axis + 1], gain[axis + 3][2 * axis + 1] = 1.0, mean, 1 / half
        expected = congruence(gain, own)
        self.assert_matrix(self.covariance_of(states["one"]), expected, 1e-8)
        # What is left is the drift about the mean, largest at the ends of the image.
        reported = [float(text.split("up to ")[1].split()[0]) for text in report["not_carried"]
                    if text.startswith("one: m_covariance holds")]
        drift = math.sqrt(sum(own[2 * axis + 1][2 * axis + 1] for axis in range(3)))
        self.assertAlmostEqual(reported[0], drift * 0.5 * LINES * LINE / half, delta=6e-3 * reported[0])

    def test_what_a_state_cannot_hold_is_reported_with_its_size(self):
        result = self.adjust(self.nominal, "uncarried", *self.FULL[:3], "correction.squint.bias_sigma_deg=0.01",
                             "correction.troposphere.zenith_sigma_m=2", "correction.range.bias_sigma_m=20")
        states, report = self.export(result, "uncarried-states", self.isds)
        values = self.parameters(result, "one")
        reported = {text.split(":")[1].strip(): float(text.split(":")[2].split()[0])
                    for text in report["not_carried"] if text.startswith("one: ") and text.count(":") == 2}
        self.assertAlmostEqual(reported["squint.bias"] / (8e4 * values["squint.bias"]), 1.0, delta=0.06)
        # At 45 degrees incidence, or so.
        self.assertAlmostEqual(reported["troposphere.zenith"] / (1.45 * values["troposphere.zenith"]), 1.0, delta=0.1)

    def test_what_is_no_image_of_the_pass_is_refused(self):
        result = self.adjust(self.nominal, "guard", *self.FULL[:3])
        files = self.isds
        for images, message in (
                ({"one": files["two"]}, "two.json: is not the image of pass 'one'"),
                ({"three": files["one"]}, "no pass 'three'"),
                ({"one": self.folder / "matches.csv"}, "matches.csv:1: is not valid JSON")):
            self.assertIn(message, self.export(result, "guard-states", images, code=3))
        self.assertIn("--image PASS=FILE", run("export", result, "--format", "csm", code=3).stderr)
        self.assertIn("is not PASS=FILE", run("export", result, "--format", "csm", "--image", "one", code=3).stderr)
        self.assertFalse((self.folder / "guard-states").exists())
        _, report = self.export(result, "one-state", {"one": files["one"]})
        self.assertIn("two: no --image was given for it", report["not_carried"])

    def test_a_state_can_be_adjusted_again(self):
        """What is left to correct is nothing: the second export is the first, but for its covariance."""
        result = self.adjust(self.nominal, "first", *self.FULL)
        states, _ = self.export(result, "first-states", self.isds)
        again = self.make_block("second-block", states, *self.SIGMAS, points=self.adjusted(result), sigma=1e-6)
        held = self.adjust(again, "second", "correction.position.degree=0", "correction.position.axes=frame",
                           "correction.position.sigma_m=[1e-6,1e-6,1e-6]")
        twice, _ = self.export(held, "second-states", states)
        one, two = (usgscsm_state.State(path["one"]).state for path in (states, twice))
        for key in ("m_t0Ephem", "m_dtEphem", "m_startingEphemerisTime", "m_sunPosition", "m_nLines"):
            self.assertEqual(one[key], two[key], key)
        for a, b in zip(one["m_positions"], two["m_positions"]):
            self.assertAlmostEqual(a, b, delta=2e-5)

    def test_states_of_others_are_read_or_refused_by_key(self):
        result = self.adjust(self.nominal, "others", *self.FULL[:3])
        states, _ = self.export(result, "others-states", self.isds)
        name, text = states["one"].read_text(encoding="utf-8").split("\n", 1)
        points = ("--points", self.folder / "matches.csv", "--id", "one", "two")

        def refusal(change):
            state = json.loads(text)
            change(state)
            path = self.folder / "changed.json"
            path.write_text(name + "\n" + json.dumps(state), encoding="utf-8")
            return run("import", "images", path, states["two"], *points, "-o", self.folder / "no", code=3).stderr

        def shift_velocities(state):
            state["m_velocities"] = [v + 0.01 for v in state["m_velocities"]]
        for change, message in (
                (lambda s: s.pop("m_dtEphem"), "m_dtEphem: is missing"),
                (lambda s: s["m_positions"].pop(), "m_positions: is no list of three coordinates each"),
                (lambda s: s["m_currentParameterValue"].__setitem__(4, 1.0), "parameters of the velocity"),
                (shift_velocities, "m_velocities: differ from the motion of m_positions by 0.01"),
                (lambda s: s.update(m_modelName="USGS_ASTRO_FRAME_SENSOR_MODEL"), "the image of no radar")):
            self.assertIn(message, refusal(change))
        # Parameters of the position move the path; the line of the name may be left out.
        state = json.loads(text)
        state["m_currentParameterValue"] = [100.0, 0, 0, 0, 0, 0]
        path = self.folder / "moved.json"
        path.write_text(json.dumps(state), encoding="utf-8")
        blocks = []
        for block, file in (("plain", states["one"]), ("moved", path)):
            run("import", "images", file, states["two"], *points, "-o", self.folder / block)
            blocks.append(table(self.folder / block / "trajectories.csv"))
        self.assertAlmostEqual(float(blocks[1][7]["x_m"]) - float(blocks[0][7]["x_m"]), 100.0, 8)
        self.assertEqual(blocks[0][7]["y_m"], blocks[1][7]["y_m"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
