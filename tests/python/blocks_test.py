# SPDX-License-Identifier: Apache-2.0
"""Blocks from arrays: what was taken apart and put together again is the same block, and small
blocks whose numbers are known by hand."""
import re

import numpy as np
import pytest
import sarblock
from conftest import SCENES, run, tables

FRAME_OF = {"local": "local", "geocentric": "WGS84"}


def parts(block):
    """The arguments of from_arrays that make the block anew, ids as strings."""
    looks, points = block.looks, block.points
    trajectories = {"pass": [], "time_s": [], "position_m": [], "velocity_mps": []}
    for one in block.passes:
        trajectories["pass"] += [one.id] * len(one.states)
        trajectories["time_s"].append(one.states[:, 0])
        trajectories["position_m"].append(one.states[:, 1:4])
        trajectories["velocity_mps"].append(one.states[:, 4:7])
    for key in ("time_s", "position_m", "velocity_mps"):
        trajectories[key] = np.concatenate(trajectories[key])
    sigma = np.full((len(points), 3), np.nan)
    diagonal = np.diagonal(points.known_covariance_enu_m2, axis1=1, axis2=2)
    sigma[points.known_index] = np.where(points.known_held & (diagonal > 0), np.sqrt(diagonal), np.nan)
    return {
        "name": block.name,
        "frame": FRAME_OF[block.frame["kind"]],
        "passes": [
            {
                "id": one.id,
                "look": one.look,
                "wavelength_m": None if np.isnan(one.wavelength_m) else one.wavelength_m,
                "range_sigma_m": one.range_sigma_m,
                "azimuth_sigma_m": one.azimuth_sigma,
                "start_s": one.start_s,
                "end_s": one.end_s,
                "epoch_utc": one.epoch_utc or None,
            }
            for one in block.passes
        ],
        "trajectories": trajectories,
        "observations": {
            "pass": block.pass_ids[looks.pass_index],
            "point": points.ids[looks.point_index],
            "time_s": looks.time_s,
            "range_m": looks.range_m,
            "squint_deg": np.where(looks.squint_rad == 0.0, np.nan, np.degrees(looks.squint_rad)),
        },
        "points": {
            "point": points.ids,
            "role": points.role,
            "position_m": points.given_m,
            "sigma_enu_m": sigma,
        },
    }


@pytest.mark.parametrize("indices", [False, True])
@pytest.mark.parametrize("scene", ["local_block", "earth_block"])
def test_a_block_taken_apart_is_the_same_when_put_together(tmp_path, request, scene, indices):
    block = request.getfixturevalue(scene)
    given = parts(block)
    if indices:
        del given["observations"]["pass"], given["observations"]["point"]
        given["observations"]["pass_index"] = block.looks.pass_index
        given["observations"]["point_index"] = block.looks.point_index
    again = sarblock.Block.from_arrays(**given)
    block.write(tmp_path / "one")
    again.write(tmp_path / "two")
    one, two = tables(tmp_path / "one"), tables(tmp_path / "two")
    for name in ("points.csv", "trajectories.csv", "observations.csv"):
        assert one[name] == two[name], name


def test_a_block_of_arrays_adjusts_to_the_bytes_of_the_command_line(tmp_path, local_block):
    block = sarblock.Block.from_arrays(
        **parts(local_block),
        adjust={"correction": {"position": {"basis": "polynomial", "degree": 1, "sigma_m": [[4, 1.5], [4, 1.5], [3, 1]]}}},
    )
    block.write(tmp_path / "block")
    sarblock.adjust(block).write(tmp_path / "ours")
    run("adjust", tmp_path / "block", "-o", tmp_path / "theirs")
    assert tables(tmp_path / "ours") == tables(tmp_path / "theirs")


@pytest.mark.parametrize("scene", ["local_block", "earth_block"])
def test_to_arrays_gives_what_from_arrays_takes(tmp_path, request, scene):
    block = request.getfixturevalue(scene)
    block.write(tmp_path / "one")
    sarblock.Block.from_arrays(**block.to_arrays()).write(tmp_path / "two")
    one, two = tables(tmp_path / "one"), tables(tmp_path / "two")
    one = {name: text for name, text in one.items() if not name.startswith("truth")}
    assert one == two


def test_a_recorded_flight_comes_back_from_its_arrays(tmp_path):
    block = sarblock.simulate(SCENES / "recorded" / "sparse-orbit.toml", points={"count": 40})
    block.write(tmp_path / "one")
    sarblock.Block.from_arrays(**block.to_arrays()).write(tmp_path / "two")
    one, two = tables(tmp_path / "one"), tables(tmp_path / "two")
    assert {name for name in two if one[name] != two[name]} == set()


def test_measured_dopplers_come_back_from_their_arrays(tmp_path):
    text = (SCENES / "block-12-strips.toml").read_text(encoding="utf-8")
    text, count = re.subn(r"(?m)^azimuth_sigma_m = .*$", 'doppler_sigma_hz = 0.25\ncone = "doppler"', text)
    assert count == 1
    (tmp_path / "scene.toml").write_text(text, encoding="utf-8")
    block = sarblock.simulate(tmp_path / "scene.toml", points={"count": 40})
    assert {one.azimuth_unit for one in block.passes} == {"hz"}
    again = sarblock.Block.from_arrays(**block.to_arrays())
    block.write(tmp_path / "one")
    again.write(tmp_path / "two")
    one, two = tables(tmp_path / "one"), tables(tmp_path / "two")
    assert {name for name in two if one[name] != two[name]} == set()
    rows = block.to_arrays()["observations"]
    rows["doppler_sigma_hz"] = np.full(len(rows["time_s"]), 0.5)
    given = block.to_arrays() | {"observations": rows}
    looks = sarblock.Block.from_arrays(**given).looks
    assert (looks.doppler_sigma_hz == 0.5).all()
    assert np.isnan(looks.time_sigma_s).all() and np.isnan(looks.azimuth_sigma_m).all()


def hand_block(**changes):
    """Two straight flights along x, 6 km apart at 8 km height; the point T1 at (1000, 10000, 50)."""
    place = np.array([1000.0, 10000.0, 50.0])
    starts = {"A": np.array([-3000.0, 0.0, 8000.0]), "B": np.array([-3000.0, -6000.0, 8000.0])}
    time = (place[0] + 3000.0) / 200.0
    given = {
        "passes": [{"id": "A", "look": "left"}, {"id": "B", "look": "left"}],
        "sigma": {"range_m": 0.7, "azimuth_m": 0.9},
        "trajectories": {
            "pass": ["A", "A", "B", "B"],
            "time_s": [0.0, 40.0, 0.0, 40.0],
            "position_m": [starts["A"], starts["A"] + [8000.0, 0, 0], starts["B"], starts["B"] + [8000.0, 0, 0]],
            "velocity_mps": [[200.0, 0.0, 0.0]] * 4,
        },
        "observations": {
            "pass": ["A", "B"],
            "point": ["T1", "T1"],
            "time_s": [time, time],
            "range_m": [np.hypot(10000.0, 7950.0), np.hypot(16000.0, 7950.0)],
        },
    }
    for key, value in changes.items():
        table, _, column = key.partition("__")
        if column:
            given[table][column] = value
        else:
            given[table] = value
    return given


def test_two_flights_intersect_where_the_arithmetic_puts_the_point():
    result = sarblock.intersect(sarblock.Block.from_arrays(**hand_block()))
    np.testing.assert_allclose(result.points.position_m[0], [1000.0, 10000.0, 50.0], atol=1e-6)
    # Along track two independent looks of 0.9 m: 0.9 / sqrt(2).
    assert result.points.sigma_enu_m[0, 0] == pytest.approx(0.9 / np.sqrt(2.0), rel=1e-6)


@pytest.mark.parametrize("kind", [list, np.array, lambda v: np.array(v, dtype="S"), lambda v: np.array(v, dtype=object)])
def test_ids_may_be_any_kind_of_strings(kind):
    block = sarblock.Block.from_arrays(**hand_block(observations__point=kind(["T1", "T1"])))
    assert list(block.points.ids) == ["T1"]


@pytest.mark.parametrize("name", ["Zürich", "点", "\U0001f6f0 7", "a" * 90])
def test_ids_come_back_as_they_were(name, tmp_path):
    block = sarblock.Block.from_arrays(**hand_block(observations__point=[name, name]))
    assert list(block.points.ids) == [name]
    block.write(tmp_path / "block")
    assert list(sarblock.read_block(tmp_path / "block").points.ids) == [name]


def test_bytes_of_an_id_that_are_no_utf8_come_back(tmp_path):
    block = sarblock.Block.from_arrays(**hand_block(observations__point=np.array([b"T\xff1", b"T\xff1"])))
    assert list(block.points.ids) == ["T\udcff1"]
    again = sarblock.Block.from_arrays(**hand_block(observations__point=block.points.ids[[0, 0]]))
    again.write(tmp_path / "block")
    assert b",T\xff1," in (tmp_path / "block" / "observations.csv").read_bytes()


def test_arrays_of_the_other_byte_order_are_read():
    given = hand_block()
    given["observations"] = {
        "pass": np.array(["A", "B"]).astype(">U1"),
        "point": np.array(["T1", "T1"]).astype(">U2"),
        "time_s": np.array(given["observations"]["time_s"], dtype=">f8"),
        "range_m": np.array(given["observations"]["range_m"], dtype=">f8"),
    }
    result = sarblock.intersect(sarblock.Block.from_arrays(**given))
    assert list(result.points.ids) == ["T1"]
    np.testing.assert_allclose(result.points.position_m[0], [1000.0, 10000.0, 50.0], atol=1e-6)


def test_every_second_row_of_an_array_is_read():
    both = np.array([hand_block()["observations"]["range_m"], [1.0, 2.0]]).T.ravel()
    block = sarblock.Block.from_arrays(**hand_block(observations__range_m=both[::2]))
    np.testing.assert_array_equal(block.looks.range_m, hand_block()["observations"]["range_m"])


def test_what_is_masked_is_not_given():
    masked = np.ma.array([0.3, 0.4], mask=[False, True])
    block = sarblock.Block.from_arrays(**hand_block(observations__range_sigma_m=masked))
    np.testing.assert_array_equal(block.looks.range_sigma_m, [0.3, np.nan])


def test_a_message_may_hold_bytes_that_are_no_utf8():
    given = hand_block(observations__point=np.array([b"T\xff1", b"T\xff1"]), observations__pass=["A", "A"])
    with pytest.raises(sarblock.InputError, match="sees point .*T\udcff1.* twice"):
        sarblock.Block.from_arrays(**given)


def test_a_table_of_pandas_is_taken():
    import pandas

    given = hand_block()
    given["observations"] = pandas.DataFrame(given["observations"])
    assert len(sarblock.Block.from_arrays(**given).looks) == 2


def test_a_plan_needs_no_measurements_to_be_predicted():
    nothing = [np.nan, np.nan]
    given = hand_block(observations__time_s=nothing, observations__range_m=nothing)
    with pytest.raises(sarblock.InputError, match=r"observations.time_s\[0\]: is empty, a number is needed"):
        sarblock.Block.from_arrays(**given)
    plan = sarblock.Block.from_arrays(**given, plan=True)
    result = sarblock.predict(plan, [[1000.0, 10000.0, 50.0]])
    assert result.points.sigma_enu_m[0, 0] == pytest.approx(0.9 / np.sqrt(2.0), rel=1e-6)
    with pytest.raises(sarblock.InputError, match="adjust needs; predict needs none"):
        sarblock.adjust(plan)


def test_a_scene_may_be_a_dictionary():
    import tomllib

    scene = tomllib.loads((SCENES / "leberl-aircraft.toml").read_text(encoding="utf-8"))
    assert len(sarblock.simulate(scene).looks) == len(sarblock.simulate(SCENES / "leberl-aircraft.toml").looks)


def test_options_show_what_holds():
    block = sarblock.Block.from_arrays(**hand_block(), adjust={"robust": "huber"})
    assert 'robust = "huber"' in block.options()
    assert 'robust = "cauchy"' in block.options(robust="cauchy")
    assert "alpha = 0.02" in block.options(quality={"alpha": 0.02})


def test_passes_carry_their_swath_and_squint():
    block = sarblock.simulate(SCENES / "single-flight-squint.toml", points={"count": 20})
    assert block.passes[0].swath == ("swath_ground_m", 13000.0, 25000.0)
    assert block.passes[0].squint_deg == pytest.approx(15.0, abs=1e-12)
    again = sarblock.Block.from_arrays(**block.to_arrays())
    for one, two in zip(block.passes, again.passes):
        assert one.swath == two.swath and one.squint_deg == two.squint_deg
    np.testing.assert_allclose(again.looks.squint_rad, block.looks.squint_rad, rtol=1e-15)
