#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Links and citations; run by ctest as lint/check_docs.

Usage: check_docs.py [ROOT]. Prints `file:line: finding`; exit status 1 if there is one.

Links      a relative link of a Markdown page names a file of the project.
Citations  a page cited in a source (`docs/theory/observations.md, eq. (7)`) exists, and so do the
           equations cited, each numbered at the end of a line: `... (7)`.
"""
import pathlib
import re
import sys

LINK = re.compile(r"\]\((?!https?:|mailto:|#)([^)#\s]+)(?:#[^)]*)?\)")
CITATION = re.compile(r"(docs/[\w/]+\.md)((?:,?\s+eqs?\.\s*(?:\(\d+\)(?:\s*(?:-|to|and|,)\s*)?)+)?)")
NUMBER = re.compile(r"\((\d+)\)")
NUMBERED = re.compile(r"\((\d+)\)\s*$", re.M)
COMMENT_BREAK = re.compile(r"[ \t]*\n[ \t]*(?:///?|#)[ \t]*")


def line_of(text, position):
    return text.count("\n", 0, position) + 1


def pages(root):
    return sorted([*root.glob("*.md"), *(root / "docs").rglob("*.md")])


def check_links(path, root):
    text = path.read_text(encoding="utf-8")
    for match in LINK.finditer(text):
        if not (path.parent / match.group(1)).exists():
            yield line_of(text, match.start()), f"'{match.group(1)}' does not exist"


def check_citations(path, root):
    # Comments joined across lines by a blank of the same length: line numbers stay right to within
    # the citation.
    text = path.read_text(encoding="utf-8")
    joined = COMMENT_BREAK.sub(lambda m: " " * len(m.group(0)), text)
    for match in CITATION.finditer(joined):
        line, page = line_of(text, match.start()), root / match.group(1)
        if not page.exists():
            yield line, f"{match.group(1)} does not exist"
            continue
        numbered = set(NUMBERED.findall(page.read_text(encoding="utf-8")))
        for number in NUMBER.findall(match.group(2)):
            if number not in numbered:
                yield line, f"{match.group(1)} has no equation ({number})"


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()
    if not (root / "docs").is_dir():
        print(f"{root} has no folder docs: give the project's root")
        return 2
    sources = sorted(p for folder in ("include", "src", "tests")
                     for pattern in ("*.h", "*.cc") for p in (root / folder).rglob(pattern))
    found = [(p, *f) for p in pages(root) for f in check_links(p, root)]
    found += [(p, *f) for p in sources for f in check_citations(p, root)]
    for path, line, message in found:
        print(f"{path.relative_to(root)}:{line}: {message}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
