# SPDX-License-Identifier: Apache-2.0
"""Delays and tides on arrays: docs/theory/reductions.md."""
import numpy as np
import pytest
import sarblock
from conftest import SCENES


def test_delay_of_the_mean_atmosphere():
    heights_m = np.array([[0.0, 1000.0], [4000.0, -430.0]])
    expected_m = heights_m**2 / 8.55e7 - heights_m / 3411 + 2.41
    np.testing.assert_allclose(sarblock.zenith_delay(heights_m), expected_m, atol=1e-12)
    assert sarblock.zenith_delay(0.0).shape == ()


def test_delay_in_weather():
    delays_m = sarblock.zenith_delay(
        0.0, pressure_hpa=[1013.25, 980.0], temperature_k=288.15, humidity_1=0.0, lat_deg=45.0)
    np.testing.assert_allclose(delays_m, [0.0022768 * 1013.25, 0.0022768 * 980.0], atol=1e-9)
    with pytest.raises(sarblock.InputError, match="lat_deg: is needed with pressure_hpa"):
        sarblock.zenith_delay(0.0, pressure_hpa=1000.0, temperature_k=288.0, humidity_1=0.5)
    with pytest.raises(sarblock.InputError, match="pressure_hpa: must be between 200 and 1100 hPa, got 101325"):
        sarblock.zenith_delay(0.0, pressure_hpa=101325.0, temperature_k=288.0, humidity_1=0.5, lat_deg=0.0)


def test_tide_of_places_and_times():
    # by PySolid 9ac869b
    tide_m = sarblock.solid_earth_tide(
        [20.8933, 75.3706, -37.4880],
        [87.0433, 53.6308, 149.8843],
        0.0,
        ["2024-01-27T14:49:00Z", "2013-02-12T15:55:00Z", "2020-03-25T02:08:00Z"],
    )
    expected_m = [
        [0.044274, 0.008163, -0.063159], [0.006616, -0.003935, -0.152833], [0.008758, 0.058608, 0.115528]]
    np.testing.assert_allclose(tide_m, expected_m, atol=1e-3)
    one_m = sarblock.solid_earth_tide(20.8933, 87.0433, 0.0, np.datetime64("2024-01-27T14:49"))
    np.testing.assert_array_equal(one_m, tide_m[0])


def test_tide_refuses_what_has_none():
    with pytest.raises(sarblock.InputError, match="from 1972 to 2034"):
        sarblock.solid_earth_tide(0.0, 0.0, 0.0, "2040-01-01T00:00:00Z")
    with pytest.raises(sarblock.InputError, match="lat_deg: must be between -90 and 90, got 95"):
        sarblock.solid_earth_tide(95.0, 0.0, 0.0, "2020-01-01T00:00:00Z")


def planted(taken_off):
    delays = {"troposphere": "standard", "ionosphere": {"tec_tecu": 30.0, "share_1": 0.9}, "time_s": 1e-4}
    options = {"points.count": 60, "looks.noise_scale": 0, "control.noise_scale": 0}
    for table in ["truth.delay", "reduction"] if taken_off else ["truth.delay"]:
        options |= {f"{table}.{key}": value for key, value in delays.items()}
    return sarblock.simulate(SCENES / "earth-same-side.toml", **options), delays


def test_a_block_says_and_keeps_what_is_taken_off(tmp_path):
    block, delays = planted(taken_off=True)
    assert block.passes[0].reduction == delays
    assert not block.looks.range_delay_m.any()
    result = sarblock.adjust(block)
    taken_m = result.looks.reduction_range_m
    assert 2.5 < taken_m.min() < taken_m.max() < 5.0
    assert (result.looks.reduction_time_s == 1e-4).all()
    result.write(tmp_path / "result")
    read = sarblock.read_result(tmp_path / "result")
    np.testing.assert_array_equal(read.looks.reduction_range_m, taken_m)
    again = sarblock.Block.from_arrays(**block.to_arrays())
    assert again.passes[0].reduction == delays
    np.testing.assert_array_equal(sarblock.adjust(again).points.position_m, result.points.position_m)
    with pytest.raises(sarblock.InputError, match="how a block is read"):
        sarblock.adjust(block, **{"reduction.troposphere": "none"})


def test_columns_are_taken_off_once():
    block, _ = planted(taken_off=False)
    looks = block.looks
    states = [one.states for one in block.passes]
    given = {
        "passes": [
            {"id": one.id, "look": one.look, "range_sigma_m": 0.5, "azimuth_sigma_m": 1.0, "epoch_utc": None}
            for one in block.passes
        ],
        "trajectories": {
            "pass_index": np.repeat(np.arange(len(states)), [len(one) for one in states]),
            "time_s": np.concatenate(states)[:, 0],
            "position_m": np.concatenate(states)[:, 1:4],
            "velocity_mps": np.concatenate(states)[:, 4:7],
        },
        "points": {"point": block.points.ids, "role": np.full(len(block.points), "tie")},
        "frame": "WGS84",
    }
    columns = {
        "pass_index": looks.pass_index,
        "point_index": looks.point_index,
        "time_s": looks.time_s + 2e-4,
        "range_m": looks.range_m + 3.0,
        "time_shift_s": np.full(len(looks), 2e-4),
        "range_delay_m": np.full(len(looks), 3.0),
    }
    shifted = sarblock.Block.from_arrays(observations=columns, **given)
    np.testing.assert_allclose(shifted.looks.range_m, looks.range_m, rtol=0, atol=1e-9)
    np.testing.assert_allclose(shifted.looks.time_s, looks.time_s, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(shifted.looks.range_delay_m, 3.0)
    again = sarblock.Block.from_arrays(**shifted.to_arrays())
    np.testing.assert_allclose(again.looks.range_m, shifted.looks.range_m, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(again.looks.range_delay_m, 3.0)


def test_realization_epoch_and_velocities_are_kept():
    block, _ = planted(taken_off=False)
    given = block.to_arrays()
    given["frame"] = {"kind": "geocentric", "ellipsoid": "WGS84", "realization": "ITRF2014", "epoch": 2015.0}
    velocities = np.where(block.points.role == "control", 0.02, np.nan)
    given["points"] |= {"vx_mpy": velocities, "vy_mpy": -velocities, "vz_mpy": 0.5 * velocities}
    for one in given["passes"]:
        one["epoch_utc"] = "2022-06-15T10:40:00Z"
    moving = sarblock.Block.from_arrays(**given)
    assert moving.frame["realization"] == "ITRF2014"
    assert moving.frame["epoch"] == 2015.0
    np.testing.assert_array_equal(moving.points.known_velocity_mpy[0], [0.02, -0.02, 0.01])
    again = sarblock.Block.from_arrays(**moving.to_arrays())
    np.testing.assert_array_equal(again.points.known_velocity_mpy, moving.points.known_velocity_mpy)
    result = sarblock.adjust(again)
    # Only looks at the control hold a motion, of some 7.5 years at 3 cm.
    control = block.points.role[again.looks.point_index] == "control"
    assert (np.abs(result.looks.reduction_range_m[control]) > 1e-3).any()
    assert np.abs(result.looks.reduction_range_m[control]).max() < 0.25
    assert not result.looks.reduction_range_m[~control].any()
