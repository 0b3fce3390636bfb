#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs tables of messages: each row is an input with a mistake, and the whole message of the program.

    tests/messages/messages.py --program PROGRAM tests/messages/block.txt...
    tests/messages/messages.py --program PROGRAM --update tests/messages/block.txt
    tests/messages/messages.py --program PROGRAM --every 4 tests/messages/block.txt

A table is a text of sections, a section a title and rows with an empty line between them:

    == Standard deviations
    good local
    $ check block

    0

    block/block.toml
      [sigma]
    - range_m = 1.25
    + range_m = 0
    3 block/block.toml:6: sigma.range_m: must be a number above 0, got 0

`== TITLE`      begins a section.
`good NAME`     every row of the section has a copy of tests/messages/good/NAME, in which the program runs.
`make COMMAND`  what the program makes of that, once for the section, such as a block of a scene or a result.
`$ COMMAND`     what the program is called with; of a row, or of all rows of the section that have none of their own.
                Of several the answer is the same. SCENES is the folder of the shipped scenes.
`FILE`          the lines below change this file. Like a patch: `-` marks a line that is taken out, `+` one that is put in, two
                spaces one that stays; those that are there must be there once. Lines of `+` alone go to the end of
                the file, lines of `=` are the whole file.
`without FILE`  the file is removed.
`3 MESSAGE`     ends the row: the exit code, and all that is written to standard error, without `sarblock: `; further
                lines begin with `| `.
`# `            begins a remark.

The first row of a section with a good input has exit code 0, and its changes hold for all rows: what a row changes is
what is refused. A row that is refused writes nothing: no file, none changed, nothing
on standard output. Its message begins with the place: file, line and field (an option with --set), unless the exit code
is followed by `~`: nothing in a file can be named.

The messages are records: they show a change, and are right because someone read them. A new refusal is a row that ends
in its exit code alone; --update writes down what the program says. Read it before it is committed. Python 3.9.
"""
import argparse
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

import rows

HERE = pathlib.Path(__file__).resolve().parent
SCENES = HERE.parents[1] / "datasets/scenes"
PLACE = re.compile(r"[^\s:]+:\d+: [^:]*[^\s:]: |--[a-z][a-z0-9-]*( \S+)?: ")  # file, line and field; an option
LIMIT_S = 60


def contents(folder):
    """Every file of a folder and what it holds."""
    return {str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None
            for path in sorted(folder.rglob("*"))}


def run(program, command, folder):
    """Exit code, standard output, and messages without the program's name and the folder of the scenes."""
    words = [word.replace("SCENES", str(SCENES)) for word in shlex.split(command)]
    done = subprocess.run([program, *words], cwd=folder, capture_output=True, stdin=subprocess.DEVNULL, timeout=LIMIT_S,
                          check=False)
    said = done.stderr.decode("utf-8", "replace").replace(str(SCENES), "SCENES").replace(f"{folder}/", "").rstrip("\n")
    return done.returncode, done.stdout, re.sub("^sarblock: ", "", said, flags=re.MULTILINE)


def make_good(program, section, folder):
    """The input of a section, as all rows have it."""
    if section.good is not None:
        shutil.copytree(HERE / "good" / section.good, folder, dirs_exist_ok=True)
    for command in section.makes:
        code, _, said = run(program, command, folder)
        if code != 0:
            raise rows.Mistake(f"{section.title}: {command}: exit code {code}: {said}")


def prepare(section, row, good, folder):
    shutil.copytree(good, folder, dirs_exist_ok=True)
    first = section.rows[0]
    if first is not row and first.code == 0:
        first.apply(folder)
    row.apply(folder)


def differences(program, section, row, good):
    """What is wrong with a row, and the answer of the program."""
    wrong = []
    answers = set()
    for command in row.commands or section.commands:
        with tempfile.TemporaryDirectory(prefix="sarblock-messages-") as scratch:
            folder = pathlib.Path(scratch)
            prepare(section, row, good, folder)
            before = contents(folder)
            code, out, said = run(program, command, folder)
            answers.add((code, said))
            if (code, said) != (row.code, row.message):
                wrong.append(f"$ {command}\n  expected {row.code} {row.message}\n  got      {code} {said}")
            if code != 0 and contents(folder) != before:
                wrong.append(f"$ {command}\n  is refused, and changed files")
            if code != 0 and out:
                wrong.append(f"$ {command}\n  is refused, and wrote to standard output: {out[:200]!r}")
            if code == 3 and not row.place_free and not PLACE.match(said):
                wrong.append(f"$ {command}\n  the message begins with no place: {said}")
    if not answers:
        wrong.append("has no command")
    return wrong, answers


def update(path, answered):
    """Writes what the program says in place of the answers of a table."""
    lines = path.read_text(encoding="utf-8").split("\n")
    for row, (code, said) in reversed(answered):
        answer = f"{code}{'~' if row.place_free else ''} {said}".rstrip().split("\n")
        lines[row.answer_line - 1:row.answer_end] = [answer[0], *[f"| {line}" for line in answer[1:]]]
    path.write_text("\n".join(lines), encoding="utf-8")


def check_section(program, section, every):
    """Rows of a section, the first and each `every`-th, with what is wrong with each and how the program answers."""
    with tempfile.TemporaryDirectory(prefix="sarblock-messages-") as good:
        make_good(program, section, pathlib.Path(good))
        for row in section.rows[::every]:
            try:
                yield (row, *differences(program, section, row, good))
            except rows.Mistake as mistake:
                yield row, [str(mistake)], set()


def check(program, path, write, every=1):
    """Runs a table; the number of rows that were run and of those that failed."""
    count, failed, answered = 0, 0, []
    for section in rows.read(path):
        if (section.good or section.makes) and section.rows and section.rows[0].code != 0:
            raise rows.Mistake(f"{path.name}:{section.line}: the first row needs exit code 0: the input is good")
        for row, wrong, answers in check_section(program, section, every):
            count += 1
            failed += bool(wrong)
            if len(answers) == 1:
                answered.append((row, answers.pop()))
            if wrong:
                print(f"{path.name}:{row.line}: {section.title}", *wrong, sep="\n", flush=True)
    if write:
        update(path, answered)
    return count, failed


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=pathlib.Path, required=True)
    parser.add_argument("--update", action="store_true", help="write down what the program says")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="of each section the first row and each N-th")
    parser.add_argument("tables", type=pathlib.Path, nargs="+")
    options = parser.parse_args()
    if options.every < 1:
        parser.error("argument --every: 1 or more is allowed")
    total = wrong = 0
    for path in options.tables:
        count, failed = check(options.program.resolve(), path, options.update, options.every)
        total, wrong = total + count, wrong + failed
    print(f"{total} rows, {wrong} failed")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
