# SPDX-License-Identifier: Apache-2.0
"""The paper's functions on arrays: hand arithmetic, and the command line element by element."""
import json
import subprocess

import numpy as np
import pytest
import sarblock
from conftest import PROGRAM
from sarblock import leberl

BASE_M, HEIGHT_M, GROUND_M = 7000.0, 9000.0, 16000.0


def test_angles_and_ranges_are_those_of_the_triangles():
    assert leberl.first_look_angle(BASE_M, HEIGHT_M, GROUND_M) == pytest.approx(np.arctan2(16.0, 9.0), abs=1e-15)
    assert leberl.second_look_angle(BASE_M, HEIGHT_M, GROUND_M) == pytest.approx(np.pi / 4.0, abs=1e-15)
    assert leberl.second_slant_range(BASE_M, HEIGHT_M, GROUND_M) == pytest.approx(9000.0 * np.sqrt(2.0), rel=1e-15)
    assert leberl.absolute_parallax(BASE_M, HEIGHT_M, GROUND_M) == pytest.approx(
        np.hypot(9000.0, 16000.0) - np.hypot(9000.0, 9000.0), rel=1e-14
    )
    assert leberl.absolute_parallax(BASE_M, HEIGHT_M, GROUND_M, presentation="ground") == BASE_M


def test_range_noise_is_equation_25():
    ground = np.array([[14000.0, 16000.0], [18000.0, 21000.0]])
    noise = leberl.noise_of_range(BASE_M, HEIGHT_M, ground, 0.6)
    first, second = HEIGHT_M**2 + ground**2, HEIGHT_M**2 + (ground - BASE_M) ** 2
    np.testing.assert_allclose(noise.sigma_y_m, 0.6 * np.sqrt(first + second) / BASE_M, rtol=1e-14)
    np.testing.assert_allclose(
        noise.sigma_z_m,
        0.6 * np.sqrt(first * (ground - BASE_M) ** 2 + second * ground**2) / (BASE_M * HEIGHT_M),
        rtol=1e-14,
    )
    assert noise.sigma_y_m.shape == (2, 2)


def test_numbers_are_broadcast():
    angle = leberl.intersection_angle(np.array([[5000.0], [7000.0]]), HEIGHT_M, [14000.0, 16000.0, 18000.0])
    assert angle.shape == (2, 3)
    assert angle[1, 1] == leberl.intersection_angle(7000.0, HEIGHT_M, 16000.0)


def test_point_errors_are_those_of_the_command_line():
    ended = subprocess.run(
        [PROGRAM, "leberl", "errors", "--json", "--base-m", "7000", "--height-m", "9000", "--ground-range-m", "16000",
         "--dx0-1", "1.5", "--dy0-2", "-2.25", "--dz0-1", "0.75", "--dr-2", "1.1", "--dydot-1", "0.0003"],
        capture_output=True, text=True, check=True,
    )
    theirs = json.loads(ended.stdout)
    first = {"dx0_m": 1.5, "dz0_m": 0.75, "dydot0_1": 3e-4}
    second = {"dy0_m": -2.25, "dr_m": 1.1}
    for signs, key in (("printed", "formula"), ("derived", "formula_derived_signs")):
        ours = leberl.point_errors(BASE_M, HEIGHT_M, GROUND_M, first, second, signs=signs)
        assert [float(value) for value in ours] == [theirs[key][name] for name in ("dx_m", "dy_m", "dz_m")]


def test_height_and_parallax_are_inverse():
    for presentation in ("ground", "slant"):
        parallax = leberl.parallax_from_height(BASE_M, HEIGHT_M, GROUND_M, [3.0, 70.0], presentation=presentation)
        height = leberl.height_from_parallax(BASE_M, HEIGHT_M, GROUND_M, parallax, presentation=presentation)
        np.testing.assert_allclose(height, [3.0, 70.0], rtol=1e-14)


def test_the_parts_of_the_differences_are_equations_18_to_24():
    dy, dz, error = 830.0, 120.0, 2.5
    base = leberl.difference_error_of_base(BASE_M, HEIGHT_M, GROUND_M, dy, dz, error)
    assert base.dy_m == pytest.approx(-dy / BASE_M * error, rel=1e-14)
    height = leberl.difference_error_of_height(BASE_M, HEIGHT_M, GROUND_M, dy, dz, error)
    assert height.dy_m == pytest.approx(-error / BASE_M * dz, rel=1e-14)
    assert height.dz_m == pytest.approx(error / BASE_M * dy, rel=1e-14)
    printed = leberl.difference_error_of_height(BASE_M, HEIGHT_M, GROUND_M, dy, dz, error, signs="printed")
    assert printed.dy_m == pytest.approx(error / BASE_M * dz, rel=1e-14)
    derived = leberl.range_warp(BASE_M, HEIGHT_M, GROUND_M, 1.0, -2.0)
    warp = leberl.range_warp(BASE_M, HEIGHT_M, GROUND_M, 1.0, -2.0, signs="printed")
    assert (warp.f_1, warp.d_1) == (-derived.f_1, -derived.d_1)


def test_what_cannot_be_is_refused():
    with pytest.raises(sarblock.InputError, match="base_m: 0 is given, a finite number but 0 is allowed"):
        leberl.exaggeration([7000.0, 0.0], HEIGHT_M, GROUND_M)
    with pytest.raises(sarblock.InputError, match="a finite number is allowed"):
        leberl.exaggeration(BASE_M, np.nan, GROUND_M)
    with pytest.raises(sarblock.InputError, match="arrangement: 'same' is not known"):
        leberl.exaggeration(BASE_M, HEIGHT_M, GROUND_M, arrangement="same")
    with pytest.raises(sarblock.InputError, match="first: 'dx_m' is not known"):
        leberl.point_errors(BASE_M, HEIGHT_M, GROUND_M, {"dx_m": 1.0})
