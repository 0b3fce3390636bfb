# SPDX-License-Identifier: Apache-2.0
"""Signals and full disks at random moments of a run over an older result or block."""
import collections
import json
import os
import random
import resource
import shutil
import signal
import subprocess
import time

import trials

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGKILL)


class Output:
    """What a command writes: the older folder, and the newer one that an undisturbed run makes."""

    def __init__(self, program, scratch, scenes, command):
        self.program, self.command = program, command
        self.old, self.new, self.out = (scratch / f"{command}-{kind}" for kind in ("old", "new", "out"))
        self.marker = "summary.json" if command == "adjust" else "block.toml"
        scene, blocks = scenes / "earth-same-side.toml", [scratch / "block-1", scratch / "block-2"]
        size = ["--set", "points.count=4000"]
        for folder in (*blocks, self.old, self.new):
            shutil.rmtree(folder, ignore_errors=True)
        for seed, block in enumerate(blocks):
            self.call("simulate", scene, "-o", block, *size, "--set", f"seed={61 + seed}")
        if command == "adjust":
            self.arguments = ["adjust", blocks[1]]
            self.call("adjust", blocks[0], "-o", self.old, "--set", "pairs=neighbours")
        else:
            self.arguments = ["simulate", scene, *size, "--set", "seed=62"]
            self.call("simulate", scene, *size, "-o", self.old, "--gzip")
        start = time.monotonic()
        self.call(*self.arguments, "-o", self.new)
        self.seconds = time.monotonic() - start

    def call(self, *arguments):
        subprocess.run([self.program, *arguments, "-q", "--threads", "1"], check=True, stdout=subprocess.DEVNULL)

    def start(self, out, **options):
        return subprocess.Popen([self.program, *self.arguments, "-o", out, "-q", "--threads", "1"],
                                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                                env=dict(os.environ, OPENBLAS_NUM_THREADS="1"), **options)

    def same(self, folder, other):
        """Whether two folders hold the same files, but for what a run says of its own costs."""
        def content(path):
            files = trials.files_of(path)
            files = {name: data for name, data in files.items() if not name.startswith(".")}
            if "summary.json" in files:
                summary = json.loads(files["summary.json"])
                summary.pop("stages")
                files["summary.json"] = summary
            return files
        return content(folder) == content(other)

    def state(self, out):
        if not (out / self.marker).exists():
            return "none"
        for name, folder in (("old", self.old), ("new", self.new)):
            if self.same(out, folder):
                return name
        return "MIXED"

    def flaws_afterwards(self, out):
        """The next run succeeds and leaves nothing behind."""
        process = self.start(out)
        _, err = process.communicate()
        if process.returncode != 0:
            yield f"the next run ended with {process.returncode}: {err}"
        elif not self.same(out, self.new):
            yield "the next run did not write a whole result"
        hidden = trials.unfinished(out)
        if hidden:
            yield f"{hidden} stay"


def interrupt(output, rng, sent):
    """Sends a signal at a moment that is random over the whole run, over its writing, or as the older
    result is taken away; returns how the run ended."""
    process = output.start(output.out)
    moment = rng.choice(("any", "writing", "marker"))
    if moment == "any":
        time.sleep(rng.uniform(0, 1.05 * output.seconds))
    else:
        def waits():
            if moment == "marker":
                return (output.out / output.marker).exists()
            return not trials.unfinished(output.out)
        while process.poll() is None and waits():
            pass
        time.sleep(rng.uniform(0, 0.1 * output.seconds) if moment == "writing" else rng.uniform(0, 1e-3))
    process.send_signal(sent)
    _, err = process.communicate(timeout=60)
    return process.returncode, err


def signals(output, rng, _scratch):
    sent = rng.choice(SIGNALS)
    shutil.rmtree(output.out, ignore_errors=True)
    shutil.copytree(output.old, output.out)
    code, err = interrupt(output, rng, sent)
    if code not in (0, 1, -sent):  # by the signal: SIGKILL, or before the program has a handler
        yield f"{trials.ended(code)} after {sent.name}: {err}"
    yield sent.name, trials.ended(code), output.state(output.out)
    yield from output.flaws_afterwards(output.out)


def disks(output, rng, scratch):
    """A tmpfs that holds the older result and a random part of the new one; where none can be mounted,
    a largest size of files."""
    disk = scratch / "disk"
    disk.mkdir(exist_ok=True)
    old, new = (sum(-(-len(data) // 4096) * 4096 for data in trials.files_of(folder).values())
                for folder in (output.old, output.new))
    part = rng.uniform(0, 1.2)
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={old + int(part * new) + 65536}", "sarblock-attack",
                              disk], check=False, capture_output=True).returncode == 0
    try:
        out = disk / "out"
        shutil.rmtree(out, ignore_errors=True)
        shutil.copytree(output.old, out)
        largest = int(part * max(file.stat().st_size for file in output.new.iterdir()))
        limit = None if mounted else lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (largest, largest))
        # Without restore_signals SIGXFSZ stays ignored: writing fails, as on a full disk.
        process = output.start(out, preexec_fn=limit, restore_signals=False)
        _, err = process.communicate(timeout=60)
        state = output.state(out)
        yield "full disk" if mounted else "limited files", trials.ended(process.returncode), state
        if (process.returncode, state) not in ((0, "new"), (3, "old")):
            yield f"{trials.ended(process.returncode)} beside the {state} result: {err}"
        if process.returncode == 3 and str(out) not in err:
            yield f"the message names no file: {err}"
        left = trials.unfinished(out)
        if left:
            yield f"{left} stay"
    finally:
        if mounted:
            subprocess.run(["umount", disk], check=True)


def run(program, root, scratch, options):
    attack = signals if options.attack == "signals" else disks
    outputs = [Output(program, scratch, root / "datasets/scenes", command) for command in ("adjust", "simulate")]
    tally, failed = collections.Counter(), 0
    for number in range(options.count or (40 if attack is signals else 20)):
        rng = random.Random(f"{options.seed}:{number}")
        output = outputs[0] if rng.random() < 0.7 else outputs[1]
        flaws = []
        for found in attack(output, rng, scratch):
            if isinstance(found, tuple):
                tally[output.command, *found] += 1
                flaws += ["old and new files are mixed"] if found[-1] == "MIXED" else []
            else:
                flaws.append(found)
        for flaw in flaws:
            print(f"{number}: {output.command}: FAILED: {flaw}", flush=True)
        failed += bool(flaws)
    print("\n| command | attack | run ended with | folder holds | times |\n| --- | --- | --- | --- | --- |")
    for key, times in sorted(tally.items()):
        print("| " + " | ".join(str(cell) for cell in (*key, times)) + " |")
    return failed
