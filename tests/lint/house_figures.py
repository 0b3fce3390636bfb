#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Figures of the sources of one or more clones side by side, as the table of docs/decisions.md 20.

    tests/lint/house_figures.py ROOT...

Files and lines are those of .h and .cc in src and include, rooms their folders by today's names. An exported function
is one that a header declares outside of classes; its users are the units (header and source of one name) beside its
own that call it, tests left out. The files that name a figure are those of src and include, Python and JavaScript
too."""
import collections
import pathlib
import re
import statistics
import sys

DECLARED = re.compile(r"^(?:\[\[nodiscard\]\] )?(?:inline |constexpr |template .*> )?"
                      r"[A-Za-z_][\w:<>,&* ]*[ &*>]([A-Z]\w+)\(", re.M)
TODAY = {"sparse": "linear", "geodesy": "geometry", "flight": "geometry", "paper": "leberl", "determinacy": "solve",
         "covariance": "quality", "testing": "quality", "io": "tables and files", "tables": "tables and files",
         "files": "tables and files", "product": "products", "study": "studies", "study_io": "studies"}
NAMED = ["sigma_leberl_path_across_m", "remaining_step", "factor_sigma", "square_sum", "curvatures"]


def figures(root):
    """Names of the figures of a clone and their values."""
    texts = {path: path.read_text(encoding="utf-8") for folder in ("src", "include")
             for path in sorted((root / folder).rglob("*")) if path.suffix in {".h", ".cc", ".py", ".js"}}
    code = {path: text for path, text in texts.items() if path.suffix in {".h", ".cc"}}
    out = {"files": len(code), "median lines": int(statistics.median(text.count("\n") for text in code.values())),
           "public headers": sum(path.is_relative_to(root / "include") for path in code), "lines": 0}
    rooms, users, homes = collections.Counter(), collections.defaultdict(set), {}
    for path, text in code.items():
        base = root / ("include/sarblock" if path.is_relative_to(root / "include") else "src")
        room = path.relative_to(base).parts[0]
        unit = f"{room}/{path.stem}"
        rooms[TODAY.get(room, room)] += text.count("\n")
        for name in set(re.findall(r"\b([A-Z]\w+)\(", text)):
            users[name].add(unit)
        if path.suffix == ".h":
            for name in DECLARED.findall(text):
                homes.setdefault(name, unit)
    out["lines"] = sum(rooms.values())
    out["exported functions"] = len(homes)
    out["... with one user at most"] = sum(len(users[name] - {home}) <= 1 for name, home in homes.items())
    for name in NAMED:
        out[f"files that name {name}"] = sum(re.search(rf"\b{name}\b", text) is not None for text in texts.values())
    for room, lines in sorted(rooms.items(), key=lambda item: -item[1]):
        out[f"lines of {room}"] = lines
    return out


def main():
    columns = [figures(pathlib.Path(root).resolve()) for root in sys.argv[1:] or ["."]]
    names = list(dict.fromkeys(name for column in columns for name in column))
    for name in names:
        print(f"| {name} | " + " | ".join(f"{column[name]:,}" if name in column else "" for column in columns) + " |")


if __name__ == "__main__":
    main()
