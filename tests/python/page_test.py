# SPDX-License-Identifier: Apache-2.0
"""docs/python.md and the notebooks run as they stand."""
import os
import pathlib
import re
import subprocess
import sys

import matplotlib
import numpy as np
import pytest

matplotlib.use("Agg")
DOCS = pathlib.Path(os.environ["SARBLOCK_DATASETS"]).parent / "docs"


def test_the_blocks_of_the_page_run_in_their_order(tmp_path, monkeypatch, capsys):
    text = (DOCS / "python.md").read_text(encoding="utf-8")
    (tmp_path / "datasets").symlink_to(os.environ["SARBLOCK_DATASETS"])
    monkeypatch.chdir(tmp_path)
    scope = {}
    blocks = re.findall(r"^```python\n(.*?)^```", text, re.M | re.S)
    assert len(blocks) >= 5
    for block in blocks:
        exec(compile(block, "docs/python.md", "exec"), scope)
    said = capsys.readouterr().out
    assert "did you mean robust?" in said
    assert "1000" in said.splitlines()[-1]
    np.testing.assert_allclose(scope["sarblock"].intersect(scope["made"]).points.position_m, [[1000, 10000, 50]], atol=1e-6)


@pytest.mark.parametrize("notebook", sorted((DOCS / "notebooks").glob("*.ipynb")), ids=lambda path: path.stem)
def test_a_notebook_prints_what_it_keeps(notebook):
    script = pathlib.Path(__file__).parent / "run_notebook.py"
    ended = subprocess.run([sys.executable, script, notebook], capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stdout + ended.stderr


def test_a_changed_output_of_a_notebook_is_found(tmp_path):
    notebook = next((DOCS / "notebooks").glob("*.ipynb"))
    text = notebook.read_text(encoding="utf-8").replace("accepted, 550 of", "accepted, 551 of")
    (tmp_path / "a" / "b").mkdir(parents=True)
    (tmp_path / "datasets").symlink_to(os.environ["SARBLOCK_DATASETS"])
    (tmp_path / "a" / "b" / "changed.ipynb").write_text(text, encoding="utf-8")
    script = pathlib.Path(__file__).parent / "run_notebook.py"
    ended = subprocess.run(
        [sys.executable, script, tmp_path / "a" / "b" / "changed.ipynb"], capture_output=True, text=True, check=False
    )
    assert ended.returncode == 1 and "cell 2 prints" in ended.stdout
