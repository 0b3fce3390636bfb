#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Links, citations, prerequisites; run by ctest as lint/check_docs.

Usage: check_docs.py [ROOT] [--update]. Prints `file:line: finding`; exit status 1 if there is one.

Links      a relative link of a Markdown page names a file of the project, and its anchor a heading.
Code       a block after `<!-- code: FILE PART -->` is the part of FILE (below docs) between two lines
           `// [PART]`, so that the page shows what the tests compile. --update writes the blocks.
Index      every page of docs stands in docs/README.md, or with the theory in docs/theory/README.md.
Glossary   terms in alphabetical order, and each name in code stands in a page of reference too.
Citation   CITATION.cff has the version and the date of CMakeLists.txt.
Sources    what a page of theory, or architecture.md, names as `ROOM/FILE` is a file of src, include or tests.
Commands   use only what a reader of this page alone has (prerequisites.py).
Citations  a page cited in a source (`docs/theory/observations.md, eq. (7)`) exists, and so do the
           equations cited, each numbered at the end of a line: `... (7)`.
"""
import pathlib
import re
import sys
import textwrap

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from prerequisites import hidden  # noqa: E402

LINK = re.compile(r"\]\((?!https?:|mailto:)([^)#\s]*)(?:#([^)\s]*))?\)")
HEADING = re.compile(r"^#{1,6} +(.+?) *#*$", re.M)
FENCED = re.compile(r"^```.*?^```", re.M | re.S)
CODE = re.compile(r"^<!-- code: (\S+) (\S+) -->\n+```\w*\n(.*?)^```", re.M | re.S)
CITATION = re.compile(r"(docs/[\w/]+\.md)((?:,?\s+eqs?\.\s*(?:\(\d+\)(?:\s*(?:-|to|and|,)\s*)?)+)?)")
NUMBER = re.compile(r"\((\d+)\)")
NUMBERED = re.compile(r"\((\d+)\)\s*$", re.M)
COMMENT_BREAK = re.compile(r"[ \t]*\n[ \t]*(?:///?|#)[ \t]*")
SOURCE = re.compile(r"`((?:\w+/)+\w+(?:\.\w+)?)`")


def line_of(text, position):
    return text.count("\n", 0, position) + 1


def pages(root):
    return sorted([*root.glob("*.md"), *(root / "docs").rglob("*.md")])


def anchors(path):
    """The anchors of a page's headings, as GitHub makes them."""
    found = set()
    for heading in HEADING.findall(FENCED.sub("", path.read_text(encoding="utf-8"))):
        heading = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
        slug = re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        number = 0
        while slug + (f"-{number}" if number else "") in found:
            number += 1
        found.add(slug + (f"-{number}" if number else ""))
    return found


def check_links(path, root):
    text = path.read_text(encoding="utf-8")
    for match in LINK.finditer(text):
        target = path.parent / match.group(1) if match.group(1) else path
        if not target.exists():
            yield line_of(text, match.start()), f"'{match.group(1)}' does not exist"
        elif match.group(2) and target.suffix == ".md" and match.group(2) not in anchors(target):
            yield line_of(text, match.start()), f"{target.name} has no heading '#{match.group(2)}'"


def part_of(path, name):
    """The lines of a source between two markers, less their common indentation; None without."""
    if not path.exists():
        return None
    parts = re.split(rf"^[ ]*// \[{re.escape(name)}\]\n", path.read_text(encoding="utf-8"), flags=re.M)
    return textwrap.dedent(parts[1]) if len(parts) == 3 else None


def check_code(path, root, update):
    text = path.read_text(encoding="utf-8")
    for match in reversed(list(CODE.finditer(text))):
        part = part_of(root / "docs" / match.group(1), match.group(2))
        if part is None:
            yield line_of(text, match.start()), f"no part [{match.group(2)}] in {match.group(1)}"
        elif part != match.group(3) and update:
            path.write_text(text := text[:match.start(3)] + part + text[match.end(3):], "utf-8")
        elif part != match.group(3):
            yield line_of(text, match.start()), f"differs from [{match.group(2)}] in {match.group(1)}"


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


def check_sources(path, root):
    text = path.read_text(encoding="utf-8")
    for match in SOURCE.finditer(text):
        name = match.group(1)
        if not any((root / folder / (name + end)).exists()
                   for folder in ("", "src", "include/sarblock", "tests") for end in ("", ".h", ".cc")):
            yield line_of(text, match.start()), f"no source is '{name}'"


def check_index(root):
    if not (root / "docs/README.md").exists():
        return
    indexes = [root / "docs/README.md", *(root / "docs/theory").glob("README.md")]
    listed = {(index.parent / target).resolve() for index in indexes
              for target, _ in LINK.findall(index.read_text(encoding="utf-8"))}
    for path in sorted((root / "docs").rglob("*.md")):
        if path not in listed and path != indexes[0]:
            yield path, 1, "stands neither in docs/README.md nor in docs/theory/README.md"


def check_glossary(root):
    path = root / "docs/glossary.md"
    if not path.exists():
        return
    reference = "".join((root / "docs" / name).read_text(encoding="utf-8")
                        for name in ("formats.md", "adjust_options.md", "commands.md"))
    last = ""
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        term = re.match(r"\| (?!term |---)([^|]+) \|", line)
        if not term:
            continue
        if term.group(1).lower() <= last:
            yield path, number, f"'{term.group(1)}' stands after '{last}'"
        last = term.group(1).lower()
        for name in re.findall(r"`([^`]+)`", line):
            if not re.search(rf"(?<!\w){re.escape(name)}(?!\w)", reference):
                yield path, number, f"'{name}' stands in no page of reference"


def check_citation_file(root):
    path = root / "CITATION.cff"
    if not path.exists():
        return
    cmake = (root / "CMakeLists.txt").read_text(encoding="utf-8")
    for key, pattern in (("version", r"project\(sarblock VERSION ([^\s)]+)"),
                         ("date-released", r"set\(SARBLOCK_RELEASE_DATE (\S+)\)")):
        value = re.search(pattern, cmake).group(1)
        if f"\n{key}: {value}\n" not in path.read_text(encoding="utf-8"):
            yield path, 1, f"the {key} is not {value}, that of CMakeLists.txt"


def main():
    update = "--update" in sys.argv
    arguments = [argument for argument in sys.argv[1:] if argument != "--update"]
    root = pathlib.Path(arguments[0] if arguments else ".").resolve()
    if not (root / "docs").is_dir():
        print(f"{root} has no folder docs: give the project's root")
        return 2
    sources = sorted(p for folder in ("include", "src", "tests", "docs")
                     for pattern in ("*.h", "*.cc") for p in (root / folder).rglob(pattern))
    found = [(p, *f) for p in pages(root) for f in check_links(p, root)]
    found += [(p, *f) for p in pages(root) for f in check_code(p, root, update)]
    found += [(p, *f) for p in pages(root) for f in hidden(root, p)]
    found += [(p, *f) for p in pages(root) for f in check_sources(p, root)
              if p.parent.name == "theory" or p.name == "architecture.md"]
    found += [*check_index(root), *check_glossary(root), *check_citation_file(root)]
    found += [(p, *f) for p in sources for f in check_citations(p, root)]
    for path, line, message in found:
        print(f"{path.relative_to(root)}:{line}: {message}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
