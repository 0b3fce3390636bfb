#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs a notebook without Jupyter: its code cells in order, in the notebook's folder, pictures by
matplotlib without a screen.

Usage: run_notebook.py NOTEBOOK            what cells print must be what the notebook keeps, and a
                                           cell that draws must keep a picture
       run_notebook.py NOTEBOOK --update   keeps what they print and draw in the notebook"""
import ast
import base64
import contextlib
import io
import json
import os
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  (after the choice of what draws)


def run_cell(source, scope):
    """What the cell prints, its last expression as Jupyter shows it included, and its pictures."""
    tree = ast.parse(source)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, "cell", "exec"), scope)
        if last is not None:
            value = eval(compile(ast.Expression(last.value), "cell", "eval"), scope)
            if value is not None and not source.rstrip().endswith(";"):
                print(repr(value))
    pictures = []
    for number in pyplot.get_fignums():
        file = io.BytesIO()
        pyplot.figure(number).savefig(file, format="png", dpi=72, metadata={"Software": None})
        pictures.append(base64.b64encode(file.getvalue()).decode("ascii"))
    pyplot.close("all")
    return printed.getvalue(), pictures


def outputs_of(printed, pictures):
    outputs = []
    if printed:
        outputs.append({"name": "stdout", "output_type": "stream", "text": printed.splitlines(keepends=True)})
    for picture in pictures:
        outputs.append({"data": {"image/png": picture}, "metadata": {}, "output_type": "display_data"})
    return outputs


def kept_in(cell):
    texts = ["".join(one["text"]) for one in cell["outputs"] if one["output_type"] == "stream"]
    pictures = [one for one in cell["outputs"] if "image/png" in one.get("data", {})]
    return "".join(texts), len(pictures)


def main():
    path = pathlib.Path(sys.argv[1]).resolve()
    update = "--update" in sys.argv
    notebook = json.loads(path.read_text(encoding="utf-8"))
    os.chdir(path.parent)
    scope, findings, number = {"__name__": "__main__"}, [], 0
    for cell in notebook["cells"]:
        if cell["cell_type"] != "code":
            continue
        number += 1
        printed, pictures = run_cell("".join(cell["source"]), scope)
        if update:
            cell["outputs"], cell["execution_count"] = outputs_of(printed, pictures), number
        elif kept_in(cell) != (printed, len(pictures)):
            findings.append(f"cell {number} prints\n{printed}and draws {len(pictures)}; the notebook keeps\n"
                            f"{kept_in(cell)[0]}and {kept_in(cell)[1]}")
    if update:
        path.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    print("\n".join(findings) or f"{number} cells")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
