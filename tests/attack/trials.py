# SPDX-License-Identifier: Apache-2.0
"""One run of the program on a mutated input, and what must hold afterwards."""
import collections
import csv
import gzip
import json
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import time

import inputs
import mutations

MEMORY_BYTES = 4 << 30
NOBODY = 65534
NOTE = ".sarblock-written"  # checksums of the files of a block (docs/formats.md)


def ended(code):
    return f"signal {-code}" if code < 0 else f"exit {code}"


def files_of(path):
    """Bytes of a file or of all files of a folder, by name."""
    if path.is_file():
        return {"": path.read_bytes()}
    return {str(file.relative_to(path)): file.read_bytes()
            for file in sorted(path.rglob("*")) if file.is_file()}


def unfinished(folder):
    """Hidden files of a folder: what a run writes before it has its name."""
    return [name for name in os.listdir(folder) if name.startswith(".") and name != NOTE]


def strict_json(text):
    def refuse(constant):
        raise ValueError(f"{constant} in JSON")
    return json.loads(text, parse_constant=refuse)


def flaws_of_tables(folder):
    """What is not whole in the tables of a folder."""
    for name, data in files_of(folder).items():
        base = os.path.basename(name)
        if base.startswith(".") and base != NOTE or ".tmp" in name:
            yield f"{name} was left behind"
        if name.endswith(".gz"):
            data = gzip.decompress(data)
        if not name.endswith((".csv", ".csv.gz")):
            continue
        text = data.decode("utf-8", "surrogateescape")
        rows = list(csv.reader(text.splitlines()))
        if not text.endswith("\n") or any(len(row) != len(rows[0]) for row in rows):
            yield f"{name} is not whole"
        names = {i for i, column in enumerate(rows[0]) if re.match(r"(point|pass|parameter)(_[ab])?$", column)}
        for row in rows[1:]:  # a name may be any word
            numbers = [cell for i, cell in enumerate(row) if i not in names]
            if any(re.fullmatch(r"[-+]?(nan|inf|infinity)", cell, re.IGNORECASE) for cell in numbers):
                yield f"{name} holds {row}"
                break


def run_limited(command, limit, user=None, **options):
    """(exit code, stdout, stderr, seconds, whether it had to be interrupted)."""
    def limits():
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        if user is not None:
            os.setgid(user)
            os.setuid(user)
    start = time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL,
                               preexec_fn=limits, env=dict(os.environ, OPENBLAS_NUM_THREADS="1"), **options)
    long = False
    try:
        out, err = process.communicate(timeout=limit)
    except subprocess.TimeoutExpired:
        long = True
        process.send_signal(signal.SIGINT)
        try:
            out, err = process.communicate(timeout=limit)
        except subprocess.TimeoutExpired:
            process.kill()
            out, err = process.communicate()
            return "hangs", out.decode(errors="replace"), err.decode(errors="replace"), 2 * limit, True
    return (process.returncode, out.decode(errors="replace"), err.decode(errors="replace"),
            time.monotonic() - start, long)


class Trial:
    def __init__(self, program, chosen, folder, number, seed):
        self.program, self.chosen, self.folder = program, chosen, folder
        self.rng = random.Random(f"{seed}:{number}")
        self.copy, self.out = folder / "in", folder / "out"
        self.mistakes, self.user = [], None

    def prepare(self):
        shutil.rmtree(self.folder, ignore_errors=True)
        shutil.copytree(self.chosen.folder, self.copy, symlinks=True)
        if self.chosen.older and self.rng.random() < 0.5:
            shutil.copytree(self.chosen.older, self.out)
        for target in self.rng.sample(self.chosen.targets, 1):
            self.target = target
            self.mistakes.append(mutations.mutate(self.copy / target, self.rng))
        if "unreadable" in self.mistakes and os.geteuid() == 0:
            self.user = NOBODY
        self.before = files_of(self.out) if self.out.exists() else None

    def command(self):
        words = [word.replace("{in}", str(self.copy)).replace("{out}", str(self.out))
                 for word in self.chosen.arguments]
        return [str(self.program), *words, "-q", "--threads", "1"]

    def flaws(self, limit):
        code, out, err, self.seconds, long = run_limited(self.command(), limit, self.user)
        self.outcome, self.err = ended(code) if isinstance(code, int) else code, err
        if long and code == 1:
            self.outcome = "interrupted"
        if self.outcome not in ("exit 0", "exit 1", "exit 3", "exit 4", "interrupted"):
            yield self.outcome
        after = files_of(self.out) if self.out.exists() else None
        if self.outcome in ("exit 3", "exit 4", "interrupted"):
            # Studies keep the rows that were finished.
            if after != self.before and not (self.chosen.writes == "study" or not after and not self.before):
                yield f"{self.outcome} left another output: {sorted(after or ())}"
            if not err.strip():
                yield "no message"
            given = (str(self.copy), str(self.out), "--set")
            if self.outcome == "exit 3" and not any(name in err for name in given):
                yield "the message names no file that was given"
        if self.outcome in ("exit 0", "exit 1"):
            yield from self.flaws_of_output(out)

    def flaws_of_output(self, out):
        try:
            if "--json" in self.chosen.arguments and out:
                strict_json(out)
            if self.chosen.writes in ("result", "block"):
                yield from flaws_of_tables(self.out)
            if self.chosen.writes == "result":
                summary = strict_json((self.out / "summary.json").read_text(encoding="utf-8"))
                if summary["accepted"] != (self.outcome == "exit 0"):
                    yield f"{self.outcome} beside accepted {summary['accepted']}"
            elif self.chosen.writes and not self.out.exists():
                yield "no output"
        except (ValueError, OSError, KeyError) as error:
            yield f"output: {error!r}"


def run(program, root, scratch, options):
    made = inputs.Maker(program, root, scratch).make()
    kinds = sorted({chosen.command for chosen in made})
    weights = {kind: 1 + sum(chosen.command == kind for chosen in made)**0.5 for kind in kinds}
    tally, slowest, failed = collections.Counter(), collections.defaultdict(float), 0
    numbers = range(options.count or 6000) if options.only is None else [options.only]
    for number in numbers:
        rng = random.Random(f"{options.seed}/{number}")
        kind = rng.choices(kinds, [weights[k] for k in kinds])[0]
        chosen = rng.choice([one for one in made if one.command == kind])
        trial = Trial(program, chosen, scratch / "trial", number, options.seed)
        trial.prepare()
        flaws = list(trial.flaws(options.limit))
        tally[kind, trial.outcome] += 1
        slowest[kind] = max(slowest[kind], trial.seconds)
        if flaws or options.only is not None or trial.outcome == "interrupted":
            words = " ".join(trial.command())
            print(f"{number}: {trial.mistakes} in {trial.target}: {words}\n  {trial.err.strip()[:400]}", flush=True)
            for flaw in flaws:
                print(f"  FAILED: {flaw}", flush=True)
            kept = scratch / "failed" / str(number)
            shutil.rmtree(kept, ignore_errors=True)
            kept.parent.mkdir(exist_ok=True)
            shutil.copytree(trial.folder, kept, symlinks=True, ignore_dangling_symlinks=True)
            failed += bool(flaws)
    print("\n| command | inputs | accepted | not accepted | refused (3) | undetermined (4) | "
          "ended by Ctrl-C | other | longest, s |\n" + "| --- " * 9 + "|")
    for kind in kinds:
        counts = [tally[kind, outcome] for outcome in ("exit 0", "exit 1", "exit 3", "exit 4", "interrupted")]
        total = sum(count for (k, _), count in tally.items() if k == kind)
        cells = [kind, total, *counts, total - sum(counts), f"{slowest[kind]:.1f}"]
        print("| " + " | ".join(str(cell) for cell in cells) + " |")
    return failed
