# SPDX-License-Identifier: Apache-2.0
"""The program under test, SARBLOCK_PROGRAM, and the tables it writes."""
import csv
import os
import subprocess

PROGRAM = os.environ["SARBLOCK_PROGRAM"]


def run(*arguments, code=0):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, check=False)
    assert done.returncode == code, f"{arguments}: exit {done.returncode}\n{done.stderr}"
    return done


def table(path):
    with open(path, encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(line for line in stream if not line.startswith("#")))
