# SPDX-License-Identifier: Apache-2.0
"""What differs between two manifests, and by how much where the files were kept."""
import collections
import csv
import io
import json
import math
import pathlib
import re

# What does not make another message: numbers, names of files, what is quoted.
NAMES = re.compile(r"[\w./-]+\.(?:csv|toml|json|xml|h5)\b|'[^']*'")
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")


def number(cell):
    try:
        return float(cell)
    except ValueError:
        return None


def sigma_of(row, column):
    """The standard deviation that stands in the same row for a column, or nothing."""
    if column in ("x_m", "y_m", "z_m"):
        names = ("sigma_e_m", "sigma_n_m", "sigma_u_m")
    else:
        names = next(([name] for name in (f"sigma_{column}", column.replace("error_", "error_sigma_", 1),
                                          column.replace("correction_", "sigma_", 1), column.replace("value", "sigma"))
                      if name in row and name != column), ())
    parts = [number(row.get(name) or "") for name in names]
    return math.hypot(*parts) if parts and None not in parts else None


class Difference:
    """The largest of a column, over any number of tables."""

    def __init__(self):
        self.absolute = self.relative = self.sigmas = 0.0
        self.words = 0      # cells that are not numbers in both
        self.cases = set()
        self.worst = ""     # case of the largest relative difference

    def add(self, case, a, b, sigma):
        x, y = number(a), number(b)
        self.cases.add(case)
        if x is None or y is None or not math.isfinite(x - y):
            self.words += 1
            return
        self.absolute = max(self.absolute, abs(x - y))
        if abs(x - y) > self.relative * max(abs(x), abs(y)):
            self.relative, self.worst = abs(x - y) / max(abs(x), abs(y)), case
        if sigma:
            self.sigmas = max(self.sigmas, abs(x - y) / sigma)

    def merge(self, other):
        if other.relative > self.relative:
            self.worst = other.worst
        for name in ("absolute", "relative", "sigmas"):
            setattr(self, name, max(getattr(self, name), getattr(other, name)))
        self.words += other.words
        self.cases |= other.cases

    def __str__(self):
        says = f"{self.absolute:.2g}, relative {self.relative:.2g}" if self.absolute else ""
        says += f", {self.sigmas:.2g} sigma" if self.sigmas else ""
        says += f"{', ' if says else ''}{self.words} cells of text or empty in one" if self.words else ""
        return says


def of_tables(case, old, new, columns):
    """Adds the columns that differ; yields what else does."""
    rows = [list(csv.reader(line for line in io.StringIO(data) if not line.startswith("#"))) for data in (old, new)]
    if not all(rows):
        yield "empty in one"
        return
    (before, *old_rows), (after, *new_rows) = rows
    if before != after:
        gone, come = [c for c in before if c not in after], [c for c in after if c not in before]
        yield f"columns: without {gone}, with {come}" if gone or come else "columns in another order"
    if len(old_rows) != len(new_rows):
        yield f"{len(new_rows)} rows, {len(old_rows)} before"
    shared = [(c, before.index(c), after.index(c)) for c in before if c in after]
    for a, b in zip(old_rows, new_rows):
        if a == b and before == after:
            continue
        row = dict(zip(before, a))
        for column, i, j in shared:
            if i < len(a) and j < len(b) and a[i] != b[j]:
                columns[column].add(case, a[i], b[j], sigma_of(row, column))


def leaves(value, path=""):
    if isinstance(value, dict):
        for key, item in value.items():
            yield from leaves(item, f"{path}.{key}" if path else key)
    elif isinstance(value, list):
        for i, item in enumerate(value):
            yield from leaves(item, f"{path}.{i}")
    else:
        yield path, value


def of_trees(case, old, new, columns):
    """JSON, value by value; numbers of lists do not count in the name."""
    a, b = dict(leaves(json.loads(old))), dict(leaves(json.loads(new)))
    for word, names in (("without", a.keys() - b.keys()), ("with", b.keys() - a.keys())):
        if names:
            shown = sorted({re.sub(r"\.\d+", "", name) for name in names})
            yield f"{word} {', '.join(shown[:8])}" + (", ..." if len(shown) > 8 else "")
    for name in a.keys() & b.keys():
        if a[name] != b[name]:
            columns[re.sub(r"\.\d+", "", name)].add(case, str(a[name]), str(b[name]), None)


def of_texts(case, old, new, columns):
    """Lines in turn; a line whose numbers alone differ counts with the numbers."""
    a, b = old.splitlines(), new.splitlines()
    if len(a) != len(b):
        yield f"{len(b)} lines, {len(a)} before"
    other = 0
    for before, after in zip(a, b):
        if before == after:
            continue
        x, y = NUMBER.findall(before), NUMBER.findall(after)
        if len(x) == len(y) and NUMBER.sub("#", before) == NUMBER.sub("#", after):
            for p, q in zip(x, y):
                if p != q:
                    columns["numbers"].add(case, p, q, None)
        else:
            other += 1
            if other == 1:
                yield f"`{before[:100]}` became `{after[:100]}`"
    if other > 1:
        yield f"{other} lines with other words"


class Comparison:
    def __init__(self, old, new, most):
        self.folders = [path.parent if path.is_file() else path for path in (old, new)]
        paths = [path if path.is_file() else path / "manifest.json" for path in (old, new)]
        self.old, self.new = ({name: entry for name, entry in json.loads(path.read_text("utf-8"))["cases"].items()}
                              for path in paths)
        self.most = most
        self.words = collections.defaultdict(list)     # (before, after): cases
        self.columns = {}                              # (file, column): Difference
        self.different = set()

    def show(self, title, lines, most=None):
        lines, most = list(lines), most or self.most
        if lines:
            print(f"\n{title}: {len(lines)}")
            for line in lines[:most]:
                print(f"  {line}")
            if len(lines) > most:
                print(f"  ... {len(lines) - most} more (--most)")

    def text(self, side, case, name):
        path = pathlib.Path(self.folders[side]) / "files" / case / name
        try:
            return path.read_text(encoding="utf-8") if path.is_file() else None
        except UnicodeDecodeError:
            return None

    def files_of(self, case):
        """What differs in the files of a case, a line each."""
        a, b = self.old[case]["files"], self.new[case]["files"]
        for name in sorted(a.keys() - b.keys()):
            yield f"{case}: no {name} any more"
        for name in sorted(b.keys() - a.keys()):
            yield f"{case}: {name} is new"
        for name in sorted(a.keys() & b.keys()):
            if a[name] == b[name]:
                continue
            old, new = self.text(0, case, name), self.text(1, case, name)
            if old is None or new is None:
                yield f"{case}: {name} (not kept in both, or not text)"
                continue
            columns = collections.defaultdict(Difference)
            bare = name.removesuffix(".gz")
            kind = of_tables if bare.endswith(".csv") else of_trees if bare.endswith("json") else of_texts
            for says in kind(case, old, new, columns):
                yield f"{case}: {name}: {says}"
            for column, difference in columns.items():
                self.columns.setdefault((pathlib.PurePath(bare).name, column), Difference()).merge(difference)
            if columns:
                worst = max(columns, key=lambda c: (columns[c].sigmas, columns[c].relative))
                yield f"{case}: {name}: {len(columns)} of its columns or values, the most {worst} by {columns[worst]}"

    def messages_of(self, case):
        """Lines that only one says, paired in order, in groups of the same words."""
        a, b = self.old[case]["says"], self.new[case]["says"]
        gone, come = [line for line in a if line not in b], [line for line in b if line not in a]
        for i in range(max(len(gone), len(come))):
            before, after = (lines[i] if i < len(lines) else "nothing" for lines in (gone, come))
            alike = tuple(NUMBER.sub("#", NAMES.sub("NAME", line)) for line in (before, after))
            self.words[alike].append((case, before, after))

    def report(self):
        shared = sorted(self.old.keys() & self.new.keys())
        if not shared:
            print("no case stands in both")
            return 2
        self.show("cases that are gone", sorted(self.old.keys() - self.new.keys()))
        self.show("new cases", sorted(self.new.keys() - self.old.keys()))
        commands, inputs, codes, files = [], [], [], []
        for case in shared:
            a, b = self.old[case], self.new[case]
            if a == b:
                continue
            self.different.add(case)
            if a["command"] != b["command"]:
                commands.append(f"{case}: `{a['command']}` became `{b['command']}`")
            if a.get("about") != b.get("about"):
                inputs.append(f"{case}: {b.get('about')}")
            if a["exit"] != b["exit"]:
                codes.append(f"{case}: exit {b['exit']}, {a['exit']} before ({b.get('about') or b['command']})")
            if a["says"] != b["says"]:
                self.messages_of(case)
            files += self.files_of(case)
        self.show("other commands", commands)
        self.show("other inputs: the blocks that are mutated differ", inputs)
        self.show("other exit codes", codes)
        self.show("other messages, with how many cases and one of them", (
            f"{len(said)} cases, {said[0][0]}:\n    - {said[0][1][:300]}\n    + {said[0][2][:300]}"
            for said in sorted(self.words.values(), key=len, reverse=True)))
        self.show("other files", files)
        self.show("largest differences by column", (
            f"{name}: {column}: {difference} ({len(difference.cases)} cases" +
            (f", relative most in {difference.worst})" if difference.worst else ")")
            for (name, column), difference in sorted(self.columns.items())), most=len(self.columns))
        alone = self.old.keys() ^ self.new.keys()
        print(f"\n{len(shared)} cases in both, {len(self.different)} differ; {len(alone)} in one alone")
        return 1 if self.different or alone else 0


def compare(old, new, most):
    return Comparison(old, new, most).report()
