# SPDX-License-Identifier: Apache-2.0
"""Pictures: what is drawn, read from the axes. How they look is seen in docs/notebooks."""
import matplotlib
import numpy as np
import pytest
import sarblock

matplotlib.use("Agg")


def test_the_map_has_an_ellipse_a_point_and_a_mark_a_role(local_result):
    axes = local_result.plot(magnify=100.0)
    ellipses = [one for one in axes.collections if type(one).__name__ == "EllipseCollection"]
    assert len(ellipses) == 1
    assert len(ellipses[0].get_offsets()) == local_result.points.solved.sum()
    large = local_result.points.ellipses()[0]
    # Diameters in the units of the axes, km.
    np.testing.assert_allclose(2.0 * ellipses[0]._widths, 2e-3 * 100.0 * large)
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["tie", "control", "check"]
    assert "100 times" in axes.get_title()


def test_ellipses_are_not_larger_than_a_fortieth_of_the_map(local_result):
    axes = local_result.plot()
    ellipses = [one for one in axes.collections if type(one).__name__ == "EllipseCollection"][0]
    extent = np.ptp(1e-3 * local_result.points.position_m[:, :2], axis=0).max()
    assert 0.008 * extent < np.median(2.0 * ellipses._widths) < 0.08 * extent


def test_the_map_of_the_earth_is_in_kilometres_about_its_middle(earth_block):
    result = sarblock.adjust(earth_block)
    axes = result.plot()
    offsets = np.concatenate([one.get_offsets() for one in axes.collections if type(one).__name__ == "PathCollection"])
    assert axes.get_xlabel() == "east of the middle [km]"
    # The distance of the farthest points, measured without maps.
    places = result.points.position_m[result.points.solved]
    true_km = 1e-3 * max(np.linalg.norm(places - one, axis=1).max() for one in places)
    drawn_km = max(np.linalg.norm(offsets - one, axis=1).max() for one in offsets)
    assert drawn_km == pytest.approx(true_km, rel=0.01)


def test_strips_have_a_line_a_pass(local_block, local_result):
    axes = local_result.plot("strips")
    assert len(axes) == 3
    labels = [line.get_label() for line in axes[0].get_lines() if not line.get_label().startswith("_")]
    assert labels == list(local_block.pass_ids)


def test_a_picture_that_is_not_known_is_refused(local_result):
    with pytest.raises(sarblock.InputError, match="map or strips is allowed"):
        local_result.plot("chart")
