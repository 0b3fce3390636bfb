# SPDX-License-Identifier: Apache-2.0
"""Blocks that several tests share, and the program beside the module."""
import json
import os
import pathlib
import subprocess

import pytest
import sarblock

PROGRAM = os.environ["SARBLOCK_PROGRAM"]
SCENES = pathlib.Path(os.environ["SARBLOCK_DATASETS"]) / "scenes"
#: What differs from run to run: times, and names of folders.
RUN_KEYS = ("stages",)


def run(*arguments, code=0):
    """Runs the program; returns what it printed on standard error."""
    ended = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, check=False)
    assert ended.returncode == code, ended.stderr
    return ended.stderr.strip()


def tables(folder):
    """Bytes of all files of a folder but its summary and the checksums of a block, which follow from the others."""
    left_out = ("summary.json", ".sarblock-written")
    return {p.name: p.read_bytes() for p in sorted(folder.iterdir()) if p.name not in left_out}


def summary(folder):
    """Its summary without what differs from run to run."""
    said = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    return {key: value for key, value in said.items() if key not in RUN_KEYS}


@pytest.fixture(scope="session")
def local_block():
    return sarblock.simulate(SCENES / "block-12-strips.toml", points={"count": 150})


@pytest.fixture(scope="session")
def earth_block():
    return sarblock.simulate(SCENES / "earth-asc-desc.toml")


@pytest.fixture(scope="session")
def local_result(local_block):
    return sarblock.adjust(local_block)
