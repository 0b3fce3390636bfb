#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Whether two builds of the program write and say the same.

    tests/golden/golden.py write --program PROGRAM -o FOLDER [--keep] [--data ROOT] [--only WORD] [--mutants 900]
                                 [--blocks OLDER]
    tests/golden/golden.py compare OLD NEW [--most 40]

`write` runs the cases of cases.py (every shipped scene, the Cabeus block, ways to adjust, exports, imports, studies)
and inputs with one mistake each (mutants.py), and writes FOLDER/manifest.json: of each case the command, its exit
code, what it says on standard error, and the checksum of every file and of standard output in a normal form without
times, memory, versions and places (normal.py). --keep leaves these files in FOLDER/files, some 200 MB, so that
`compare` can say by how much numbers differ. One thread, one process after the other. --only runs the cases whose names
WORD begins (what they read must be made by one of them); --mutants 0 runs no mutants.

`compare` takes the two folders, or their manifests, lists the cases that differ and in what, and of every column of a
table that differs the largest difference, also over the value and over the standard deviation that stands beside
it. Exit status 0: all equal; 1: differences; 2: nothing to compare.

A mutant depends on its number and on the block that `simulate` writes. Where the new program writes other blocks,
`compare` says that inputs differ; --blocks mutates those of an older FOLDER, written with --keep, in their place.

Python 3.9, nothing else. Not a test: it knows what changed, not what is right."""
import argparse
import hashlib
import json
import os
import pathlib
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import cases
import differences
import mutants
import normal

ROOT = pathlib.Path(__file__).resolve().parents[2]
CPU_S, WALL_S, BYTES = 30, 240, 4 << 30  # of one mutant; no shipped case comes near


class Run:
    """The cases of one program in a folder of their own, and what came of them."""

    def __init__(self, options, work):
        self.program, self.work, self.output = options.program, work, options.output
        self.keep, self.blocks = options.keep, options.blocks
        self.places = [(self.program, "sarblock"), (work, "WORK"), (options.data, "ROOT")]
        (work / "datasets").symlink_to(options.data / "datasets")
        (work / "corpus").symlink_to(options.data / "tests/fuzz/corpus")
        self.environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "LC_ALL": "C.UTF-8", "TZ": "UTC",
                            "COLUMNS": "80"}
        self.cases = {}

    def ended(self, arguments, limited):
        def limits():
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            if limited:
                resource.setrlimit(resource.RLIMIT_CPU, (CPU_S, CPU_S + 5))
                resource.setrlimit(resource.RLIMIT_AS, (BYTES, BYTES))
        process = subprocess.Popen([self.program, *arguments, "--threads", "1"], cwd=self.work, env=self.environment,
                                   stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   preexec_fn=limits)
        try:
            out, err = process.communicate(timeout=WALL_S if limited else None)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            return "beyond the limit", b"", b""
        if process.returncode in (-signal.SIGXCPU, -signal.SIGKILL):
            return "beyond the limit", b"", b""
        return process.returncode, out, err

    def add(self, case, about="", limited=False):
        (self.work / case.name).parent.mkdir(parents=True, exist_ok=True)
        if case.output:
            (self.work / case.output).parent.mkdir(parents=True, exist_ok=True)
        code, out, err = self.ended(case.arguments, limited)
        entry = {"command": " ".join(case.arguments), "exit": code,
                 "says": normal.text(err.decode("utf-8", "backslashreplace"), self.places).splitlines(), "files": {}}
        if about:
            entry["about"] = about
        if out:
            self.note(case, entry, "stdout.json" if "--json" in case.arguments else "stdout", out)
        written = self.work / case.output if case.output else None
        if written is not None and written.is_file():
            self.note(case, entry, written.name, written.read_bytes())
        elif written is not None and written.is_dir():
            for file in sorted(written.rglob("*")):
                if file.is_file():
                    self.note(case, entry, file.relative_to(written).as_posix(), file.read_bytes())
        self.cases[case.name] = entry

    def note(self, case, entry, name, data):
        form = normal.of_file(name, data, self.places)
        entry["files"][name] = hashlib.sha256(form).hexdigest()
        if self.keep:
            file = self.output / "files" / case.name / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(form)

    def mutants(self, count):
        for case in cases.bases():
            self.add(case)
            if self.blocks:
                shutil.rmtree(self.work / case.name, ignore_errors=True)
                shutil.copytree(self.blocks / "files" / case.name, self.work / case.name)
                (self.work / case.name / "stdout").unlink(missing_ok=True)
            for file in (self.work / case.name).glob("summary.json"):  # the same for all runs, so are its mutants
                file.write_bytes(normal.of_file(file.name, file.read_bytes(), self.places))
        for number in range(count):
            file, arguments = self.mutant(random.Random(f"mutant {number}"))
            about = mutants.mutate(file, f"mistake {number}")
            about += f", sha256 {hashlib.sha256(file.read_bytes()).hexdigest()[:16]}"
            for old in self.work.glob("mutated*"):
                shutil.rmtree(old) if old.is_dir() else old.unlink()
            output = next((word for word in arguments if word.startswith("mutated")), "")
            self.add(cases.Case(f"mutants/{number:03}", arguments, output), about, limited=True)

    def mutant(self, rng):
        """A copy of an input in the folder `mutant`: which file of it to change, and the command that reads it."""
        target = rng.choices(list(cases.TARGETS), list(cases.TARGETS.values()))[0]
        folder = self.work / "mutant"
        shutil.rmtree(folder, ignore_errors=True)
        if target == "scene":
            scene = rng.choice(sorted((self.work / "datasets/scenes").glob("*.toml")))
            folder.mkdir()
            shutil.copy(scene, folder / scene.name)
            values = cases.sets(cases.TINY) if rng.random() < 0.5 else []
            return folder / scene.name, ["simulate", f"mutant/{scene.name}", "-o", "mutated", *values]
        if target == "result":
            shutil.copytree(self.work / "mutants" / rng.choice(("result-1", "result-2")), folder)
            file = rng.choice([file for file in sorted(folder.iterdir()) if file.suffix in (".csv", ".json")])
            return file, rng.choice((["report", "mutant", "-o", "mutated"], ["convert", "mutant", "mutated"],
                                     ["export", "mutant", "--format", "gpkg", "-o", "mutated.gpkg"]))
        shutil.copytree(self.work / "mutants" / rng.choice([*cases.BASES, "images"]), folder)
        file = next((file for file in (folder / target, folder / "block.toml") if file.exists()))
        if rng.random() < 0.4:
            return file, ["check", "mutant", "--memory", "2000"]
        values = cases.sets(rng.choice(cases.MUTANT_WAYS))
        return file, ["adjust", "mutant", "-o", "mutated", "--memory", "2000", *values]


def write(options):
    begin, options.program = time.monotonic(), options.program.resolve()
    options.data = options.data.resolve()
    version = subprocess.run([options.program, "--version"], check=True, capture_output=True, text=True).stdout
    if (options.output / "files").exists():
        shutil.rmtree(options.output / "files")
    options.output.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="sarblock-golden-") as folder:
        run = Run(options, pathlib.Path(folder).resolve())
        for case in cases.all_cases(options.data, run.work):
            if case.name.startswith(options.only):
                run.add(case)
        run.mutants(options.mutants)
    manifest = {"format": "sarblock-golden 1", "version": version.strip(), "cases": run.cases}
    with open(options.output / "manifest.json", "w", encoding="utf-8") as file:
        json.dump(manifest, file, indent=1, sort_keys=True, ensure_ascii=False)
        file.write("\n")
    codes = sorted((str(entry["exit"]) for entry in run.cases.values()))
    tally = ", ".join(f"{codes.count(code)} with exit {code}" for code in dict.fromkeys(codes))
    count = sum(len(entry["files"]) for entry in run.cases.values())
    print(f"{len(run.cases)} cases ({tally}), {count} files, {time.monotonic() - begin:.0f} s")
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    one = commands.add_parser("write", help="run all cases of a program")
    one.add_argument("--program", type=pathlib.Path, required=True)
    one.add_argument("--data", type=pathlib.Path, default=ROOT, help="root of the project whose datasets are read")
    one.add_argument("-o", "--output", type=pathlib.Path, required=True)
    one.add_argument("--keep", action="store_true", help="keep the files as well")
    one.add_argument("--only", default="", help="only cases whose name begins so")
    one.add_argument("--mutants", type=int, default=900)
    one.add_argument("--blocks", type=pathlib.Path, help="folder of an older run with --keep: mutate its blocks")
    two = commands.add_parser("compare", help="list what differs")
    two.add_argument("old", type=pathlib.Path)
    two.add_argument("new", type=pathlib.Path)
    two.add_argument("--most", type=int, default=40, help="lines of the lists of cases (default: 40)")
    options = parser.parse_args()
    if options.command == "write":
        return write(options)
    return differences.compare(options.old, options.new, options.most)


if __name__ == "__main__":
    sys.exit(main())
