#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Every row of docs/paper.md: its command runs, the number is the one in the row, and so is the verdict.

    paper_test.py PROGRAM

A verdict is computed here: "agrees" if the program's number rounds to the digits that the paper printed (ties either
way; trailing zeros of an integer are no digits), "slip" if not. Rows without a printed number have none.
"""

import functools
import json
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import unittest

PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs" / "paper.md"
PROGRAM = ""
COLUMNS = ["printed", "here", "verdict", "command", "key"]  # after the first
DATUM = re.search(r"<!-- run: file datum\.csv -->\n\n((?:    .*\n)+)", PAGE.read_text()).group(1)


def rows():
    for line in PAGE.read_text().splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if line.startswith("|") and len(cells) == 6 and cells[5].startswith("`"):
            yield dict(zip(["item", *COLUMNS], cells))


@functools.cache
def answer(command):
    """What a command prints with --json."""
    words = shlex.split(command)
    assert words[0] == "sarblock", command
    with tempfile.TemporaryDirectory() as folder:
        (pathlib.Path(folder) / "datum.csv").write_text(re.sub("^    ", "", DATUM, flags=re.M))
        run = subprocess.run([PROGRAM, *words[1:], "--json"], cwd=folder, capture_output=True, text=True, check=True)
    return json.loads(run.stdout)


def value_of(row):
    value = answer(row["command"].strip("`"))
    for step in row["key"].strip("`").split("."):
        value = value[int(step)] if isinstance(value, list) else value[step]
    return value


def unit(text):
    """Of the last digit that counts."""
    if "." in text:
        return 10.0 ** -len(text.split(".")[1])
    zeros = len(text) - len(text.rstrip("0")) if text.strip("-0") else 0
    return 10.0 ** zeros


def rounds_to(value, text):
    return abs(value - float(text)) <= unit(text) * (0.5 + 1e-9)


class PaperPage(unittest.TestCase):
    def test_rounding(self):
        for value, text, same in [(-62.5, "-63", True), (1876.0, "1900", True), (0.049, "0", True),
                                  (1.25, "1.2", True), (9.7, "10", True), (3.6, "10", False), (-11.6, "-11", False)]:
            self.assertEqual(rounds_to(value, text), same, (value, text))

    def test_numbers_are_those_of_the_program(self):
        for row in rows():
            with self.subTest(row["item"]):
                self.assertTrue(rounds_to(value_of(row), row["here"]), (row["here"], value_of(row)))

    def test_verdicts_follow_from_the_numbers(self):
        for row in rows():
            with self.subTest(row["item"]):
                verdict = row["verdict"].split(":")[0]
                if not row["printed"]:
                    self.assertNotIn(verdict, ("agrees", "slip"))
                else:
                    agrees = rounds_to(value_of(row), row["printed"])
                    self.assertEqual(verdict, "agrees" if agrees else "slip", value_of(row))

    def test_every_equation_figure_and_quoted_number_has_a_row(self):
        items = "\n".join(row["item"] for row in rows())
        equations, figures = set(range(1, 5)), set()
        self.assertIn("Eq. 1 to 4", items)
        equations |= {int(number) for number in re.findall(r"Eq\. (\d+)", items)}
        self.assertEqual(equations, set(range(1, 26)) - {5})  # Eq. 5 is in none of our notes of the paper
        for found in re.findall(r"Fig\. (\d+)(?: and (\d+))?", items):
            figures |= {int(number) for number in found if number}
        self.assertEqual(figures, {2, 3, 4, 5, 6, 8, 9})
        quoted = {row["key"].strip("`").split(".")[0] for row in rows()
                  if row["command"] == "`sarblock leberl examples`"}
        self.assertEqual(quoted, {str(i) for i in range(len(answer("sarblock leberl examples")))})

    def test_cells_of_table_1_are_counted(self):
        count = {}
        for cell in answer("sarblock leberl table1"):
            count[cell["verdict"]] = count.get(cell["verdict"], 0) + 1
        self.assertIn(f"{count['agrees']} agree, {count['truncation']} truncation, {count['slip']} slips, "
                      f"{count['illegible']} illegible", PAGE.read_text())
        self.assertEqual(sum(count.values()), 72)


if __name__ == "__main__":
    PROGRAM = sys.argv.pop(1)
    unittest.main()
