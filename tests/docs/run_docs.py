#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs every command of the documentation; run by ctest as docs/commands.

Usage: run_docs.py --program SARBLOCK [--root ROOT] [--scratch FOLDER] [--build BUILD]
                   [--examples FOLDER] [--update] [PAGE...]
Prints `page:line: finding` and a summary; exit status 1 if there is a finding. --update writes
docs/commands.md and the blocks marked `run: output` from what the program prints.

A page's `sarblock` lines in code blocks run in order, in a folder of the page's own in which
`datasets` and `../shared` are the project's, and must end with 0. Nothing else is in it: a page makes
what it uses (tests/lint/prerequisites.py). So do inline commands that are
complete, at their place. A comment on a line of its own says otherwise for the block, or for the
inline commands of the paragraph or table, that follows it:

    <!-- run: exit 4 -->             they end with this code
    <!-- run: long -->               not run; options and keys are still held to the program
    <!-- run: form -->               a synopsis, in which BLOCK, [OPTION]... and a|b stand for others
    <!-- run: shared sentinel1/*.xml -->   links files of ../shared/data into the folder
    <!-- run: file NAME -->          the block is written to a file
    <!-- run: output -->             the block is what the command before printed on standard output;
                                     `...` stands for any lines or for the rest of one, numbers
                                     agree to one percent
    <!-- run: messages -->           the same for standard error

What names ../shared is left out where there is no such folder, and what needs its results. Lines
of other programs (cmake, ctest, scripts/...) are not run: the script, the preset, the tests they
name must exist. Programs of docs/examples are run where --examples says where they were built
(ctest: docs/examples). Options in inline code, keys of `--set`, the keys in docs/scenes.md and all of
docs/commands.md are held to what the program knows."""
import argparse
import fnmatch
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import pages as markdown  # noqa: E402
from definitions import Definitions, scene_keys  # noqa: E402

HARMLESS = {"awk", "cat", "cp", "cut", "echo", "grep", "gzip", "head", "ls", "mkdir", "mv", "sed", "sort",
            "tail", "wc", "zcat"}
OTHERS = {"apt-get", "apt", "cd", "clang-format", "cmake", "cpack", "ctest", "dpkg", "dpkg-deb", "doxygen",
          "git", "man", "mandoc", "ninja", "python3", "source", "sudo", "unzip"}
OTHERS_OPTIONS = {"--preset", "--workflow", "--target", "--prefix", "--gtest_filter", "--update",
                  "--program", "--install", "--build", "--recurse"}
KINDS = {"exit", "long", "form", "shared", "file", "output", "messages"}
SHELL_LANGUAGES = {"", "sh", "bash", "console"}
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?(?![\w])")


class Tests:
    """The tests that ctest knows, for commands that name some by a regular expression."""

    def __init__(self, build):
        self.names = []
        if build and (build / "CTestTestfile.cmake").exists():
            done = subprocess.run(["ctest", "-N"], cwd=build, capture_output=True, text=True,
                                  check=False)
            self.names = re.findall(r"^ +Test +#\d+: (\S+)", done.stdout, re.M)
        self.known = bool(self.names) and not any("NOT_BUILT" in name for name in self.names)

    def match(self, regex):
        return not self.known or any(re.search(regex, name) for name in self.names)

    def match_filter(self, pattern):
        short = [name.partition("/")[2] for name in self.names]
        return not self.known or any(fnmatch.fnmatchcase(name, one)
                                     for one in pattern.split(":") for name in short)


def same_line(expected, printed):
    """Words equal, numbers within one percent; differences of rounding errors are not compared. A
    line that ends in `...` is the beginning of the one printed."""
    if expected.endswith("..."):
        words = expected[:-3].split()
        expected, printed = " ".join(words), " ".join(printed.split()[:len(words)])
    if NUMBER.sub("#", " ".join(expected.split())) != NUMBER.sub("#", " ".join(printed.split())):
        return False
    for a, b in zip(NUMBER.findall(expected), NUMBER.findall(printed)):
        a, b = float(a), float(b)
        if abs(a - b) > 0.01 * max(abs(a), abs(b)) + 1e-6:
            return False
    return True


def same_output(expected, printed):
    """True where `printed` is `expected`, whose lines `...` stand for any number of lines."""
    if not expected:
        return not printed
    if expected[0].strip() == "...":
        return any(same_output(expected[1:], printed[n:]) for n in range(len(printed) + 1))
    return bool(printed) and same_line(expected[0], printed[0]) \
        and same_output(expected[1:], printed[1:])


class Runner:
    def __init__(self, arguments):
        self.root, self.scratch = arguments.root.resolve(), arguments.scratch.resolve()
        self.program = arguments.program.resolve()
        self.definitions = Definitions(self.program)
        self.tests = Tests(arguments.build)
        self.update = arguments.update
        self.shared = self.root.parent / "shared"
        self.examples = arguments.examples.resolve() if arguments.examples else None
        self.example_names = {path.stem for path in (self.root / "docs/examples").glob("*.cc")}
        self.counts = dict.fromkeys(("run", "long", "form", "without shared data", "examples not built",
                                     "others"), 0)
        self.findings = []
        self.environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1",
                            "PATH": ":".join(str(folder) for folder in (
                                self.program.parent, self.examples, os.environ["PATH"]) if folder)}

    def find(self, page, line, message):
        self.findings.append(f"{page.name}:{line}: {message}")

    # --- one page ---

    def folder_of(self, page):
        above = self.scratch / page.name.replace("/", "_").removesuffix(".md")
        shutil.rmtree(above, ignore_errors=True)
        work = above / "work"
        work.mkdir(parents=True)
        (work / "datasets").symlink_to(self.root / "datasets")
        (work / "docs").symlink_to(self.root / "docs")
        if self.shared.is_dir():
            (above / "shared").symlink_to(self.shared)
        return work

    def run_page(self, path):
        page = markdown.parse(str(path.relative_to(self.root)), path.read_text(encoding="utf-8"))
        self.work, self.missing = self.folder_of(page), set()
        self.output = self.messages = None
        for annotation in page.annotations:
            if annotation.kind not in KINDS:
                self.find(page, annotation.line, f"'{annotation.kind}' is no annotation of a run")
        edits = []
        for item in page.items:
            self.prepare(page, item)
            if isinstance(item, markdown.Span):
                self.span(page, item)
            else:
                self.block(page, item, edits)
        if edits and self.update:
            for first, last, text in reversed(edits):
                page.lines[first - 1:last] = text
            path.write_text("\n".join(page.lines) + "\n", encoding="utf-8")

    def prepare(self, page, item):
        """Files of ../shared/data, once for each annotation."""
        for annotation in [a for a in item.annotations if not a.done]:
            annotation.done = True
            if annotation.kind == "shared":
                names = list((self.shared / "data").glob(annotation.argument))
                if not names and self.shared.is_dir():
                    self.find(page, annotation.line, f"no {annotation.argument} in ../shared/data")
                if not self.shared.is_dir():
                    self.missing.add(pathlib.PurePath(annotation.argument).name)
                for name in names:
                    if not (self.work / name.name).exists():
                        (self.work / name.name).symlink_to(name)

    def span(self, page, span):
        kinds = {a.kind: a.argument for a in span.annotations}
        if span.text.startswith("sarblock "):
            if "form" in kinds or ("long" not in kinds and self.definitions.is_form(span.text)):
                self.check(page, span.line, span.text, "form")
            else:
                self.command(page, span.line, span.text, kinds)
        elif re.match(r"--\w", span.text):
            words = span.text.split()
            name = words[0].partition("=")[0].removesuffix("...").removesuffix(",")  # "--a, --b X"
            if name not in self.definitions.every_option and name not in OTHERS_OPTIONS:
                self.find(page, span.line, f"'{name}' is an option of no command")
            if name == "--set" and len(words) > 1 and not words[1].startswith("KEY"):
                key = words[1].partition("=")[0]
                if not self.definitions.key_is_known(key, self.definitions.every_key):
                    self.find(page, span.line, f"'{key}' is no key of --set")
        elif re.match(r"(?:\w+=\S+ )*(?:ctest|build/\S+_tests|scripts/\S+)(?: |$)", span.text):
            self.other(page, span.line, span.text)

    def block(self, page, block, edits):
        kinds = {a.kind: a.argument for a in block.annotations}
        if "file" in kinds:
            target = self.work / kinds["file"]
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text("\n".join(block.lines) + "\n", encoding="utf-8")
        elif "output" in kinds:
            self.compare(page, block, self.output, edits)
        elif "messages" in kinds:
            self.compare(page, block, self.messages, edits)
        elif block.language in SHELL_LANGUAGES:
            for line, text in markdown.logical_lines(block):
                self.shell_line(page, line, text, kinds)

    def shell_line(self, page, line, text, kinds):
        text = text.removeprefix("$ ")
        words = [word for word in text.split() if not re.match(r"^\w+=", word)]
        if not words or text.startswith("#"):
            return
        if words[0] == "sarblock":
            if "form" in kinds:
                self.check(page, line, re.split(r"\s{3,}", text)[0], "form")
            else:
                self.command(page, line, text, kinds)
        elif words[0] in HARMLESS and "form" not in kinds:
            self.command(page, line, text, kinds)
        elif words[0] in self.example_names and self.examples:
            self.command(page, line, text, kinds)
        elif words[0] in self.example_names:
            self.counts["examples not built"] += 1
            self.output = self.messages = None
        elif words[0] in OTHERS or re.match(r"(?:scripts|build)/", words[0]):
            self.other(page, line, text)

    # --- one command ---

    def check(self, page, line, text, count):
        self.counts[count] += 1
        for fault in self.definitions.faults(text, form=count == "form"):
            self.find(page, line, fault)

    def needs_what_is_missing(self, text):
        return ("../shared" in text and not self.shared.is_dir()) or \
            any("/" not in word and fnmatch.fnmatch(word, name) or word.startswith(name + "/")
                for word in text.split() for name in self.missing)

    def command(self, page, line, text, kinds):
        begins = re.sub(r"^(?:\w+=\S+ )+", "", text).startswith("sarblock")
        if "long" in kinds or self.needs_what_is_missing(text):
            self.output = self.messages = None
            if begins:
                self.check(page, line, text, "long" if "long" in kinds else "without shared data")
                made = re.search(r"(?:-o|--output)[ =](\S+)", text)
                if made:
                    self.missing.add(made.group(1))
            return
        if begins:
            faults = self.definitions.faults(text, form=False)
            for fault in faults if "exit" not in kinds else []:
                self.find(page, line, fault)
        expected = int(kinds.get("exit", "0"))
        self.counts["run"] += 1
        done = subprocess.run(["bash", "-c", text], cwd=self.work, env=self.environment,
                              stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
        self.output, self.messages = done.stdout, done.stderr
        if done.returncode != expected:
            said = (done.stderr.strip() or done.stdout.strip()).splitlines()
            self.find(page, line, f"ends with {done.returncode}, not {expected}: {text}\n    "
                      + "\n    ".join(said[-5:]))

    def compare(self, page, block, text, edits):
        if text is None:
            return  # it was not run
        printed = text.rstrip("\n").splitlines()
        if same_output(block.lines, printed):
            return
        self.find(page, block.first, "the command before prints something else:\n    "
                  + "\n    ".join(printed[:40]))
        if "..." not in [line.strip() for line in block.lines]:
            edits.append((block.first, block.last, printed))

    def other(self, page, line, text):
        """Commands of other programs: what they name must exist."""
        self.counts["others"] += 1
        text = text.replace(r"\|", "|")
        for script in re.findall(r"(?<![\w./])scripts/[\w./-]+", text):
            if not (self.root / script).is_file():
                self.find(page, line, f"there is no {script}")
        bench = re.search(r"scripts/bench\.sh (\w+)", text)
        if bench and not re.search(rf"\b{bench.group(1)}\b",
                                   (self.root / "scripts/bench.sh").read_text(encoding="utf-8")):
            self.find(page, line, f"scripts/bench.sh knows no '{bench.group(1)}'")
        for preset in re.findall(r"--preset (\w+)", text):
            if f'"name": "{preset}"' not in (self.root / "CMakePresets.json").read_text("utf-8"):
                self.find(page, line, f"there is no preset '{preset}'")
        try:
            words = shlex.split(text, comments=True)
        except ValueError as error:
            self.find(page, line, str(error))
            return
        for number, word in enumerate(words[:-1]):
            if word == "-R" and words[number + 1] != "REGEX" \
                    and not self.tests.match(words[number + 1]):
                self.find(page, line, f"no test matches '{words[number + 1]}'")
        for word in words:
            if word.startswith("--gtest_filter=") \
                    and not self.tests.match_filter(word.partition("=")[2]):
                self.find(page, line, f"no test matches '{word.partition('=')[2]}'")

    # --- pages against what the program prints ---

    def check_commands_page(self):
        path = self.root / "docs/commands.md"
        text = subprocess.run([self.program, "--dump-manual", "markdown"], check=True,
                              capture_output=True, text=True).stdout
        if path.exists() and path.read_text(encoding="utf-8") == text:
            return
        if self.update:
            path.write_text(text, encoding="utf-8")
        else:
            self.findings.append("docs/commands.md:1: the options changed; write it again with\n"
                                 "    sarblock --dump-manual markdown > docs/commands.md")

    def check_scene_keys(self):
        documented = scene_keys(self.root)
        taken = {key for key in self.definitions.commands["simulate"]["set_keys"]
                 if "." in key and not key.startswith("adjust.")}
        for key in sorted(taken - documented):
            self.findings.append(f"docs/scenes.md:1: the key {key} is missing")
        for key in sorted(documented - taken):
            self.findings.append(f"docs/scenes.md:1: no scene has a key {key}")

    def check_regexes(self, path):
        """Tables with a column REGEX: tests that `ctest -R` would run."""
        column = None
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", line)]
            if not line.startswith("|"):
                column = None
            elif "REGEX" in cells:
                column = cells.index("REGEX")
            elif column is not None and column < len(cells):
                for regex in re.findall(r"`([^`]+)`", cells[column]):
                    if not self.tests.match(regex):
                        self.findings.append(f"{path.relative_to(self.root)}:{number}: "
                                             f"no test matches '{regex}'")


def main(argv=None):
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", type=pathlib.Path, required=True)
    parser.add_argument("--root", type=pathlib.Path,
                        default=pathlib.Path(__file__).resolve().parents[2])
    parser.add_argument("--scratch", type=pathlib.Path, default=pathlib.Path("build/docs"))
    parser.add_argument("--build", type=pathlib.Path)
    parser.add_argument("--examples", type=pathlib.Path)
    parser.add_argument("--update", action="store_true",
                        default="SARBLOCK_UPDATE_DOCS" in os.environ)
    parser.add_argument("--seconds", action="store_true", help="print what each page takes")
    parser.add_argument("pages", nargs="*", type=pathlib.Path)
    arguments = parser.parse_args(argv)
    runner = Runner(arguments)
    root = runner.root
    pages = [p.resolve() for p in arguments.pages]
    if not pages:
        runner.check_commands_page()
        runner.check_scene_keys()  # the whole book
        pages = sorted([*root.glob("*.md"), *(root / "docs").rglob("*.md")])
    for page in pages:
        begin = time.monotonic()
        runner.run_page(page)
        runner.check_regexes(page)
        if arguments.seconds:
            print(f"{time.monotonic() - begin:6.1f} s {page.relative_to(root)}")
    for finding in runner.findings:
        print(finding)
    if not runner.tests.known:
        print("tests named by regular expressions were not looked for: no complete build")
    print(", ".join(f"{number} {name}" for name, number in runner.counts.items()))
    return 1 if runner.findings else 0


if __name__ == "__main__":
    sys.exit(main())
