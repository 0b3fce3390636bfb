# SPDX-License-Identifier: Apache-2.0
"""Tables of messages as text (the form: messages.py): sections with rows, and what a row does to the files of its section."""
import dataclasses
import pathlib
import re

MARKS = ("  ", "- ", "+ ", "= ")


class Mistake(Exception):
    """A table that cannot be used."""


@dataclasses.dataclass
class Hunk:
    """Consecutive lines of a file: those that must be there, and those in their place; `whole` gives the whole file."""
    file: str
    before: list = dataclasses.field(default_factory=list)
    after: list = dataclasses.field(default_factory=list)
    whole: bool = False

    def apply(self, folder):
        path = folder / self.file
        if self.whole or not self.before:
            path.parent.mkdir(parents=True, exist_ok=True)
            old = "" if self.whole or not path.exists() else path.read_text(encoding="utf-8")
            path.write_text(old + "".join(f"{line}\n" for line in self.after), encoding="utf-8")
            return
        lines = path.read_text(encoding="utf-8").split("\n")
        count = len(self.before)
        places = [at for at in range(len(lines) - count + 1) if lines[at:at + count] == self.before]
        if len(places) != 1:
            raise Mistake(f"{self.file} has these lines {len(places)} times, once is needed:\n" + "\n".join(self.before))
        lines[places[0]:places[0] + count] = self.after
        path.write_text("\n".join(lines), encoding="utf-8")


@dataclasses.dataclass
class Row:
    line: int
    hunks: list = dataclasses.field(default_factory=list)
    removed: list = dataclasses.field(default_factory=list)
    commands: list = dataclasses.field(default_factory=list)
    code: int = None
    message: str = None
    answer_line: int = 0
    answer_end: int = 0
    place_free: bool = False  # the message names no place in a file

    def apply(self, folder):
        for file in self.removed:
            (folder / file).unlink()
        for hunk in self.hunks:
            hunk.apply(folder)


@dataclasses.dataclass
class Section:
    title: str
    line: int
    good: str = None
    makes: list = dataclasses.field(default_factory=list)
    commands: list = dataclasses.field(default_factory=list)
    rows: list = dataclasses.field(default_factory=list)


class Reader:
    """Reads one table line by line."""

    def __init__(self, path):
        self.path = path
        self.sections = []
        self.in_head = False  # between the title of a section and the next empty line
        self.row = self.file = self.hunk = None

    def fail(self, number, problem):
        raise Mistake(f"{self.path.name}:{number}: {problem}")

    def current(self, number):
        if self.row is None:
            self.row = Row(number)
            self.sections[-1].rows.append(self.row)
            self.file = self.hunk = None
        elif self.row.code is not None:
            self.fail(number, "an empty line is needed between two rows")
        return self.row

    def change(self, mark, text, number):
        row = self.current(number)
        if self.file is None:
            self.fail(number, "the file is to be named before its lines")
        if self.hunk is None:
            self.hunk = Hunk(self.file, whole=mark == "=")
            row.hunks.append(self.hunk)
        if (mark == "=") != self.hunk.whole:
            self.fail(number, "lines of = give a whole file, without other marks")
        if mark in "- ":
            self.hunk.before.append(text)
        if mark in "+ =":
            self.hunk.after.append(text)

    def take(self, text, number):
        if text.startswith("# "):
            return
        if not text:
            if self.row is not None and self.row.code is None:
                self.fail(number, "the row has no answer: the exit code and what is said")
            self.row, self.in_head = None, False
        elif text.startswith("== "):
            self.row, self.in_head = None, True
            self.sections.append(Section(text[3:], number))
        elif not self.sections:
            self.fail(number, "a section is needed before: == TITLE")
        elif text.startswith("| "):
            if self.row is None or self.row.code is None:
                self.fail(number, "a further line of a message follows its first")
            self.row.message += "\n" + text[2:]
            self.row.answer_end = number
        elif text[:2] in MARKS or text in ("-", "+", "="):
            self.change(text[0], text[2:], number)
        elif answer := re.fullmatch(r"([0-9])(~?)(?: (.*))?", text):
            row = self.current(number)
            row.code, row.place_free, row.message = int(answer[1]), bool(answer[2]), answer[3] or ""
            row.answer_line = row.answer_end = number
        elif text == "$" or text.startswith("$ "):
            (self.sections[-1] if self.in_head else self.current(number)).commands.append(text[2:])
        elif text.startswith("good "):
            self.sections[-1].good = text[5:]
        elif text.startswith("make "):
            self.sections[-1].makes.append(text[5:])
        elif text.startswith("without "):
            self.current(number).removed.append(text[8:])
        elif " " not in text:
            self.current(number)
            self.file, self.hunk = text, None
        else:
            self.fail(number, f"is no line of a table: {text}")

    def read(self):
        for number, text in enumerate(self.path.read_text(encoding="utf-8").split("\n"), 1):
            self.take(text, number)
        return self.sections


def read(path):
    """The sections of a table."""
    return Reader(pathlib.Path(path)).read()
