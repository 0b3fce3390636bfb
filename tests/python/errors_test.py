# SPDX-License-Identifier: Apache-2.0
"""What cannot be used is refused in the words of the command line."""
import numpy as np
import pytest
import sarblock
from blocks_test import hand_block
from conftest import SCENES, run


def refusal(**changes):
    with pytest.raises(sarblock.InputError) as raised:
        sarblock.Block.from_arrays(**hand_block(**changes))
    return str(raised.value)


@pytest.mark.parametrize(
    "options, flags",
    [
        ({"robustt": "huber"}, ["robustt=huber"]),
        ({"robust": "hubert"}, ["robust=hubert"]),
        ({"quality": {"alpha": -0.5}}, ["quality.alpha=-0.5"]),
        ({"test_level": float("nan")}, ["test_level=nan"]),
        ({"max_iterations": 2.5}, ["max_iterations=2.5"]),
        ({"scale_by_posterior": "yes"}, ["scale_by_posterior=yes"]),
        ({"quality.alfa": 0.1}, ["quality.alfa=0.1"]),
        ({"pairs": "missing.csv"}, ["pairs=missing.csv"]),
        ({"robust": {"scale": 2}}, ["robust.scale=2"]),
    ],
)
def test_an_option_is_refused_in_the_words_of_the_command_line(tmp_path, options, flags):
    sarblock.simulate(SCENES / "leberl-aircraft.toml", points={"count": 20}).write(tmp_path / "block")
    arguments = [text for flag in flags for text in ("--set", flag)]
    theirs = run("adjust", tmp_path / "block", "-o", tmp_path / "result", *arguments, code=3)
    block = sarblock.read_block(tmp_path / "block")
    with pytest.raises(sarblock.InputError) as raised:
        sarblock.adjust(block, **options)
    assert "sarblock: " + str(raised.value) == theirs


@pytest.mark.parametrize("change", [("range_m = ", "range_mm = "), ("format", "formt")])
def test_a_file_is_refused_in_the_words_of_the_command_line(tmp_path, change):
    sarblock.simulate(SCENES / "leberl-aircraft.toml", points={"count": 20}).write(tmp_path / "block")
    file = tmp_path / "block" / "block.toml"
    file.write_text(file.read_text(encoding="utf-8").replace(*change, 1), encoding="utf-8")
    theirs = run("check", tmp_path / "block", code=3)
    with pytest.raises(sarblock.InputError) as raised:
        sarblock.read_block(tmp_path / "block")
    assert "sarblock: " + str(raised.value) == theirs


def negative_range(tmp_path):
    """The table of looks of a block in tmp_path, whose second look has a range of -5 m."""
    sarblock.Block.from_arrays(**hand_block()).write(tmp_path / "block")
    file = tmp_path / "block" / "observations.csv"
    lines = file.read_text(encoding="utf-8").splitlines()
    cells = lines[2].split(",")
    cells[lines[0].split(",").index("range_m")] = "-5"
    file.write_text("\n".join([*lines[:2], ",".join(cells)]) + "\n", encoding="utf-8")
    return file


def test_a_refusal_keeps_its_place(tmp_path):
    file = negative_range(tmp_path)
    with pytest.raises(sarblock.InputError) as raised:
        sarblock.read_block(tmp_path / "block")
    error = raised.value
    assert (error.file, error.line, error.field) == (str(file), 3, "range_m")
    assert str(error) == f"{file}:3: range_m: {error.problem}"
    with pytest.raises(sarblock.InputError) as raised:
        sarblock.adjust(sarblock.Block.from_arrays(**hand_block()), robust=[None])
    assert raised.value.file == "" and raised.value.line == 0


def test_a_value_is_refused_in_the_words_of_a_file(tmp_path):
    negative_range(tmp_path)
    theirs = run("check", tmp_path / "block", code=3)
    ours = refusal(observations__range_m=[12000.0, -5.0])
    assert ours == "observations.range_m[1]: must be a number above 0, got -5"
    assert theirs.split("range_m: ", 1)[1] == ours.split(": ", 1)[1]


def test_nan_where_a_number_is_needed_is_an_empty_cell():
    assert refusal(observations__time_s=[20.0, np.nan]) == "observations.time_s[1]: is empty, a number is needed"


def test_infinite_numbers_are_refused():
    assert refusal(observations__time_s=[np.inf, 20.0]) == "observations.time_s[0]: must be a finite number, got inf"


def test_ragged_columns_are_refused():
    assert refusal(observations__point=["T1", "T1", "T1"]) == (
        "observations.point: has 3 rows where observations.pass has 2, as many are needed"
    )


@pytest.mark.parametrize(
    "cells, words",
    [
        (np.zeros((2, 2)), "has 2 dimensions, one is needed"),
        (np.float64(3.0), "has 0 dimensions, one is needed"),
        (np.array([1 + 2j, 3]), "is an array of complex128, numbers or strings are needed"),
        (np.array(["2020-01-01", "2020-01-02"], dtype="M8[s]"), "is an array of datetime64[s], numbers or strings are needed"),
        (np.array([1.0, None], dtype=object), "is a float, a text is needed"),
    ],
)
def test_wrong_shapes_and_types_are_refused(cells, words):
    assert words in refusal(observations__time_s=cells)


def test_texts_where_numbers_are_needed_are_refused():
    assert "observations.time_s" in refusal(observations__time_s=["soon", "later"])


def test_numbers_where_names_are_needed_are_refused():
    assert refusal(observations__point=[1, 1]) == "observations.point: holds numbers, texts are needed"


def test_ragged_ids_are_refused():
    assert "a text is needed" in refusal(observations__point=["T1", ["T1", "T2"]])


def test_vectors_of_two_are_refused():
    assert refusal(trajectories__position_m=np.zeros((4, 2))) == (
        "trajectories.position_m: has the shape (4, 2), (rows, 3) is needed"
    )


@pytest.mark.parametrize(
    "index, words",
    [
        ([0, 2], "observations.pass_index[1]: must be an index from 0 to below 2, got 2"),
        ([-1, 0], "observations.pass_index[0]: must be an index from 0 to below 2, got -1"),
        ([0.0, 1.0], "observations.pass_index: is an array of float64, integers are needed"),
    ],
)
def test_an_index_without_a_pass_is_refused(index, words):
    given = hand_block()
    del given["observations"]["pass"]
    given["observations"]["pass_index"] = np.array(index)
    with pytest.raises(sarblock.InputError) as raised:
        sarblock.Block.from_arrays(**given)
    assert str(raised.value) == words


def test_a_pass_is_not_both_named_and_counted():
    assert refusal(observations__pass_index=[0, 1]) == "observations.pass: is given twice; one column only"


def test_a_pass_that_is_not_known_gets_the_nearest():
    assert "did you mean A?" in refusal(observations__pass=["a", "B"])


def test_a_point_seen_twice_by_a_pass_is_refused():
    assert "twice, first on row 0" in refusal(observations__pass=["A", "A"])


def test_a_missing_column_is_named_with_those_there():
    given = hand_block()
    del given["observations"]["range_m"]
    with pytest.raises(sarblock.InputError, match="observations.range_m: the column is missing; there are pass,point,time_s"):
        sarblock.Block.from_arrays(**given)


def test_a_value_that_is_no_option_is_refused(local_block):
    with pytest.raises(sarblock.InputError, match="is no value of an option"):
        sarblock.adjust(local_block, robust=object())


def test_how_paths_are_read_is_said_when_they_are_read(local_block):
    with pytest.raises(sarblock.InputError, match="says how a block is read, which read_block does"):
        sarblock.adjust(local_block, trajectory={"through": "orbit"})


def test_positions_of_another_shape_are_refused(local_block):
    with pytest.raises(sarblock.InputError, match=r"positions_m: has the shape \(2, 3\)"):
        sarblock.predict(local_block, np.zeros((2, 3)))


def test_what_is_not_determined_is_named_in_a_list(tmp_path):
    block = sarblock.Block.from_arrays(
        **hand_block(), adjust={"correction": {"range": {"bias": True}, "position": {"degree": 0}}, "diagnose": False}
    )
    block.write(tmp_path / "block")
    theirs = run("adjust", tmp_path / "block", "-o", tmp_path / "result", code=4)
    with pytest.raises(sarblock.UndeterminedError) as raised:
        sarblock.adjust(block)
    assert "sarblock: " + str(raised.value) == theirs
    assert isinstance(raised.value.names, list) and raised.value.names
    assert all(isinstance(name, str) for name in raised.value.names)


def test_a_refusal_says_its_likely_cause(tmp_path):
    """The sentences of the command line, on the exception and in its notes."""
    run("simulate", SCENES / "opposite-side.toml", "-o", tmp_path / "block", "--quiet")
    toml = tmp_path / "block" / "block.toml"
    text = toml.read_text(encoding="utf-8")
    assert 'look = "left"' in text
    toml.write_text(text.replace('look = "left"', 'look = "RIGHT"').replace('look = "right"', 'look = "left"')
                    .replace("RIGHT", "right"), encoding="utf-8")
    theirs = run("adjust", tmp_path / "block", "-o", tmp_path / "result", code=4)
    with pytest.raises(sarblock.UndeterminedError) as raised:
        sarblock.adjust(sarblock.read_block(tmp_path / "block"))
    assert raised.value.diagnosis and raised.value.diagnosis == raised.value.__notes__
    for sentence in raised.value.diagnosis:
        assert f"sarblock: {sentence}" in theirs


def test_files_of_others_are_not_written_over(tmp_path, local_block):
    (tmp_path / "notes.txt").write_text("mine", encoding="utf-8")
    with pytest.raises(sarblock.InputError):
        local_block.write(tmp_path)
    local_block.write(tmp_path, force=True)
    assert (tmp_path / "notes.txt").read_text(encoding="utf-8") == "mine"


def test_a_result_is_not_written_over_its_block(tmp_path, local_block):
    local_block.write(tmp_path / "block")
    block = sarblock.read_block(tmp_path / "block")
    with pytest.raises(sarblock.InputError, match="is the block, whose tables the result would overwrite"):
        sarblock.intersect(block).write(tmp_path / "block", force=True)
