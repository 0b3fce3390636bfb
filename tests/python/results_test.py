# SPDX-License-Identifier: Apache-2.0
"""Results against the command line, whose files another route writes, and against hand values."""
import json
import subprocess

import numpy as np
import pytest
import sarblock
from conftest import PROGRAM, SCENES, run, summary, tables


@pytest.mark.parametrize(
    "command, options, flags",
    [
        ("adjust", {}, []),
        ("adjust", {"robust": "huber", "quality": {"alpha": 0.01}}, ["--set", "robust=huber", "--set", "quality.alpha=0.01"]),
        ("adjust", {"scale_by_posterior": True, "pairs": "neighbours"}, ["--set", "scale_by_posterior=true", "--set", "pairs=neighbours"]),
        ("intersect", {}, []),
        ("predict", {}, []),
    ],
)
@pytest.mark.parametrize("scene", ["block-12-strips", "earth-asc-desc"])
def test_writes_the_bytes_of_the_command_line(tmp_path, scene, command, options, flags):
    run("simulate", SCENES / f"{scene}.toml", "-o", tmp_path / "block", "--set", "points.count=80")
    block = sarblock.read_block(tmp_path / "block")
    getattr(sarblock, command)(block, **options).write(tmp_path / "ours")
    run(command, tmp_path / "block", "-o", tmp_path / "theirs", *flags)
    assert tables(tmp_path / "ours") == tables(tmp_path / "theirs")
    assert summary(tmp_path / "ours") == summary(tmp_path / "theirs")


def test_a_simulated_block_is_that_of_the_command_line(tmp_path):
    scene = SCENES / "block-12-strips.toml"
    sarblock.simulate(scene, seed=7).write(tmp_path / "ours")
    run("simulate", scene, "-o", tmp_path / "theirs", "--set", "seed=7")
    assert tables(tmp_path / "ours") == tables(tmp_path / "theirs")


def test_explains_a_failing_block_like_the_command_line(tmp_path):
    block = sarblock.simulate(SCENES / "block-12-strips.toml", points={"count": 80})
    block.write(tmp_path / "block")
    text = (tmp_path / "block" / "block.toml").read_text(encoding="utf-8")
    assert text.count('look = "right"') == 1
    text = text.replace("range_m = 0.5", "range_m = 0.05", 1)
    (tmp_path / "block" / "block.toml").write_text(text, encoding="utf-8")
    result = sarblock.adjust(sarblock.read_block(tmp_path / "block"))
    result.write(tmp_path / "ours")
    run("adjust", tmp_path / "block", "-o", tmp_path / "theirs", code=1 if not result.accepted else 0)
    assert result.verdict != "accepted"
    assert result.reasons[0].startswith("most likely: ")
    assert summary(tmp_path / "ours") == summary(tmp_path / "theirs")


def test_a_result_that_was_read_has_the_numbers_of_the_one_written(tmp_path, local_block, local_result):
    local_result.write(tmp_path / "result.h5")
    read = sarblock.read_result(tmp_path / "result.h5")
    assert list(read.points.ids) == list(local_result.points.ids)
    assert list(read.points.status) == list(local_result.points.status)
    np.testing.assert_array_equal(read.points.position_m, local_result.points.position_m)
    # The file has standard deviations: a root and a square on the way.
    np.testing.assert_allclose(
        read.points.covariance_enu_m2, local_result.points.covariance_enu_m2, rtol=1e-15, atol=0.0
    )
    np.testing.assert_array_equal(read.corrections.value, local_result.corrections.value)
    np.testing.assert_array_equal(read.corrections.covariance, local_result.corrections.covariance)
    np.testing.assert_array_equal(read.looks.range_residual_m, local_result.looks.range_residual_m)
    np.testing.assert_array_equal(read.looks.point_index, local_result.looks.point_index)
    np.testing.assert_array_equal(read.strips.correction_m, local_result.strips.correction_m)
    np.testing.assert_array_equal(read.checks.error_enu_m, local_result.checks.error_enu_m)
    assert read.verdict == local_result.verdict


def test_a_result_that_was_read_is_written_with_the_same_tables(tmp_path, local_result):
    local_result.write(tmp_path / "result")
    tables = sorted(file.name for file in (tmp_path / "result").iterdir() if file.suffix in (".csv", ".json"))
    assert len(tables) >= 6
    sarblock.read_result(tmp_path / "result").write(tmp_path / "copied.h5")
    sarblock.read_result(tmp_path / "copied.h5").write(tmp_path / "again.h5")
    sarblock.read_result(tmp_path / "again.h5").write(tmp_path / "back")
    for name in tables:
        assert (tmp_path / "back" / name).read_bytes() == (tmp_path / "result" / name).read_bytes(), name


def test_a_result_that_was_read_is_not_written_from_another(tmp_path, local_result):
    local_result.write(tmp_path / "result")
    read = sarblock.read_result(tmp_path / "result")
    summary = tmp_path / "result" / "summary.json"
    summary.write_text(summary.read_text(encoding="utf-8") + "\n", encoding="utf-8")
    with pytest.raises(sarblock.InputError, match="is another result now than the one that was read"):
        read.write(tmp_path / "copied.h5")
    summary.unlink()
    with pytest.raises(sarblock.InputError, match="summary.json: is missing"):
        read.write(tmp_path / "copied.h5")
    assert not (tmp_path / "copied.h5").exists()


def test_covariances_are_symmetric_and_hold_the_squares_of_the_sigmas(local_result):
    points = local_result.points
    covariance = points.covariance_enu_m2[points.solved]
    assert covariance.shape == (points.solved.sum(), 3, 3)
    np.testing.assert_array_equal(covariance, covariance.transpose(0, 2, 1))
    assert (np.linalg.eigvalsh(covariance) > 0.0).all()
    np.testing.assert_array_equal(points.sigma_enu_m[points.solved, 2], np.sqrt(covariance[:, 2, 2]))


def test_the_ellipse_of_a_point_has_the_axes_of_its_covariance(local_result):
    points = local_result.points
    large, small, azimuth = points.ellipses()
    values, vectors = np.linalg.eigh(points.covariance_enu_m2[:, :2, :2])
    np.testing.assert_allclose(large, np.sqrt(values[:, 1]), rtol=1e-12)
    np.testing.assert_allclose(small, np.sqrt(values[:, 0]), rtol=1e-9)
    along = np.abs(vectors[:, 0, 1] * np.sin(azimuth) + vectors[:, 1, 1] * np.cos(azimuth))
    np.testing.assert_allclose(along, 1.0, atol=1e-9)


def test_the_posterior_factor_scales_every_covariance(local_block, local_result):
    scaled = sarblock.adjust(local_block, scale_by_posterior=True)
    factor = scaled.sigma0_squared
    np.testing.assert_allclose(
        scaled.points.covariance_enu_m2, factor * local_result.points.covariance_enu_m2, rtol=1e-14
    )
    np.testing.assert_allclose(scaled.corrections.sigma**2, factor * local_result.corrections.sigma**2, rtol=1e-14)
    np.testing.assert_allclose(
        scaled.corrections.covariance, factor * local_result.corrections.covariance, rtol=1e-14
    )
    np.testing.assert_allclose(
        scaled.strips.correction_sigma_m**2, factor * local_result.strips.correction_sigma_m**2, rtol=1e-13
    )


def test_positions_are_within_their_standard_deviations_of_the_truth(local_block, local_result):
    # Chi-square of three degrees a point; the points share paths, so five standard deviations.
    error = local_result.points.position_m - local_block.truth_m
    weight = np.linalg.inv(local_result.points.covariance_enu_m2)
    mean = np.einsum("ni,nij,nj->n", error, weight, error).mean() / 3.0
    assert 0.6 < mean < 1.5


def test_predict_takes_positions_from_an_array(local_block):
    known = sarblock.predict(local_block)
    given = sarblock.predict(local_block, local_block.truth_m)
    np.testing.assert_array_equal(known.points.covariance_enu_m2, given.points.covariance_enu_m2)
    moved = sarblock.predict(local_block, local_block.truth_m + np.array([0.0, 900.0, 0.0]))
    assert not np.allclose(known.points.sigma_enu_m, moved.points.sigma_enu_m, rtol=1e-4)


def test_check_counts_what_the_command_counts(tmp_path, local_block):
    local_block.write(tmp_path / "block")
    said = sarblock.check(local_block)
    printed = subprocess.run(
        [PROGRAM, "check", str(tmp_path / "block"), "--json"], capture_output=True, text=True, check=True
    )
    theirs = json.loads(printed.stdout)
    for key in ("passes", "points", "tie", "control", "check", "looks", "corrections", "warnings"):
        assert said[key] == theirs[key], key


def test_states_of_a_result_are_the_corrected_paths(local_block, local_result):
    given = local_block.passes[0].states
    corrected = local_result.states(0)
    np.testing.assert_array_equal(corrected[:, 0], given[:, 0])
    moved = np.linalg.norm(corrected[:, 1:4] - given[:, 1:4], axis=1)
    assert 0.1 < moved.max() < 30.0  # drawn with 4 m a component


def test_tables_have_a_row_a_point_and_units(local_block, local_result):
    frame = local_result.to_dataframe()
    assert len(frame) == len(local_block.points)
    assert {"point", "role", "x_m", "sigma_u_m", "cov_en_m2"} <= set(frame.columns)
    np.testing.assert_array_equal(frame["sigma_u_m"].to_numpy(), local_result.points.sigma_enu_m[:, 2])
    np.testing.assert_array_equal(frame["cov_en_m2"].to_numpy(), local_result.points.covariance_enu_m2[:, 0, 1])
    strips = local_result.to_dataframe("strips")
    np.testing.assert_array_equal(strips["correction_up_m"].to_numpy(), local_result.strips.correction_m[:, 2])
    data = local_result.to_xarray()
    assert data["points_position_m"].attrs["units"] == "m"
    assert data["points_covariance_enu_m2"].dims == ("points", "axis", "other_axis")
    assert local_block.to_xarray()["looks_time_s"].attrs["units"] == "s"
    assert len(local_block.to_dataframe()) == len(local_block.looks)
