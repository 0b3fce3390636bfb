# SPDX-License-Identifier: Apache-2.0
"""Views: no copies, not to be written to, alive as long as they are needed."""
import gc
import re

import numpy as np
import pytest
import sarblock
from conftest import SCENES


def address(array):
    return array.__array_interface__["data"][0]


BLOCK_VIEWS = ["looks.time_s", "looks.range_m", "looks.pass_index", "looks.offsets", "points.given_m"]
RESULT_VIEWS = [
    "points.position_m",
    "points.intersection_rad",
    "looks.range_residual_m",
    "looks.azimuth_w_1",
    "corrections.value",
    "corrections.sigma",
    "strips.correction_m",
]


def get(owner, name):
    for part in name.split("."):
        owner = getattr(owner, part)
    return owner


@pytest.mark.parametrize("name", BLOCK_VIEWS)
def test_arrays_of_a_block_are_views_of_one_memory(local_block, name):
    view = get(local_block, name)
    assert address(local_block._core.array(name)) == address(view)
    assert not view.flags.owndata and not view.flags.writeable


@pytest.mark.parametrize("name", RESULT_VIEWS)
def test_arrays_of_a_result_are_views_of_one_memory(local_result, name):
    view = get(local_result, name)
    assert address(local_result._core.array(name)) == address(view)
    assert not view.flags.owndata and not view.flags.writeable


def test_a_view_cannot_be_written_to(local_block):
    with pytest.raises(ValueError, match="read-only"):
        local_block.looks.range_m[0] = 1.0


def test_a_view_keeps_what_it_looks_at():
    ranges = sarblock.simulate(SCENES / "leberl-aircraft.toml").looks.range_m
    kept = ranges.copy()
    gc.collect()
    filler = [np.random.default_rng(i).random(len(kept)) for i in range(50)]
    np.testing.assert_array_equal(ranges, kept)
    assert len(filler) == 50


def test_ids_are_made_once(local_block, local_result):
    assert local_block.points.ids is local_block.points.ids
    assert local_result.points.ids is local_result.points.ids
    assert local_block.points.ids.dtype.kind == "U"


def test_looks_are_sorted_by_point_and_within_it_by_pass(local_block):
    looks = local_block.looks
    order = np.lexsort((looks.pass_index, looks.point_index))
    np.testing.assert_array_equal(order, np.arange(len(looks)))
    counts = np.bincount(looks.point_index, minlength=len(local_block.points))
    np.testing.assert_array_equal(np.diff(looks.offsets.astype(int)), counts)


def test_a_block_without_control_has_empty_arrays_of_known_positions():
    block = sarblock.simulate(SCENES / "leberl-aircraft.toml", control={"count": 0}, check={"count": 0})
    assert block.points.known_index.shape == (0,)
    assert block.points.known_covariance_enu_m2.shape == (0, 3, 3)
    assert len(sarblock.intersect(block).pairs) == 0


def test_shapes_are_those_that_the_docstrings_say(local_block, local_result):
    sizes = {
        "points": len(local_block.points),
        "looks": len(local_block.looks),
        "passes": len(local_block.passes),
        "parameters": len(local_result.corrections),
        "checks": len(local_result.checks),
        "stations": len(local_result.strips),
        "pairs": len(local_result.pairs),
        "known": len(local_block.points.known_index),
        "states": len(local_block.passes[0].states),
    }
    tested = 0
    groups = [local_block.points, local_block.looks, local_block.passes[0], local_result.points,
              local_result.corrections, local_result.looks, local_result.checks, local_result.strips,
              local_result.pairs]
    for group in groups:
        for name in [n for n in dir(type(group)) if not n.startswith("_")]:
            text = getattr(type(group), name).__doc__ or ""
            said = re.search(r"\((%s)(?: \+ 1)?,((?: (?:\d|parameters),?)*)\)" % "|".join(sizes), text)
            if said is None or name in ("geodetic", "ellipses"):
                continue
            rest = [int(sizes.get(s, s)) for s in said.group(2).replace(",", " ").split()]
            first = sizes[said.group(1)] + (1 if "+ 1" in said.group(0) else 0)
            assert getattr(group, name).shape == (first, *rest), f"{type(group).__name__}.{name}"
            tested += 1
    assert tested > 50
