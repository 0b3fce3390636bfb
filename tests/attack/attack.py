#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Attacks the built program: mutated inputs, signals, full disks and exchanged points.

    tests/attack/attack.py inputs    PROGRAM [--seed 1] [--count 6000] [--only N]
    tests/attack/attack.py signals   PROGRAM [--seed 1] [--count 40]
    tests/attack/attack.py disks     PROGRAM [--seed 1] [--count 20]
    tests/attack/attack.py exchanges PROGRAM [--seed 1] [--count 200] [--points N]
    tests/attack/attack.py mismatches PROGRAM [--seed 1] [--count 48] [--points N]
    tests/attack/attack.py reads     PROGRAM [--count 100] [--limit 20]
    tests/attack/attack.py outputs   PROGRAM [--count 80]

`inputs`     one to four mistakes in a file that a command reads (mutations.py), over the inputs of
             inputs.py, half of the runs over an older output. Asserted: an exit code of
             docs/formats.md, never 5, no signal; an end within --limit seconds, or by Ctrl-C; without
             success the older output as it was, and a message that names a file given; with success
             whole tables and a summary.json that says `accepted` where the exit code does.
`signals`    SIGINT, SIGTERM and SIGKILL at random moments of a run over an older result.
`disks`      a disk that gets full at a random moment of such a run: a small tmpfs where this user may
             mount one, else a limit of the size of files.
             Asserted of both: the whole old result, the whole new one, or none that says accepted;
             the next run succeeds and leaves nothing behind.
`exchanges`  two points exchanged in one image, over four scenes and six ways to adjust (matching.py):
             no accepted result holds a point off by more than ten of its standard deviations.
`mismatches` thirty per cent of the tie looks of one image off alike, the same scenes and ways; the same.
`reads`      Python processes whose threads read HDF5 files beside others that write one, use h5py or multiply by
             numpy, and Ctrl-C (sharing.py): each ends well; none after three times --limit seconds is a hang. Needs the package
             beside the program, and an interpreter with numpy and h5py.
`outputs`    two runs at once into one folder: plainly, as process 1 of a namespace each, over slow renames. The folder
             is whole, of one run, and read by `report`; the other run says who writes there.

Trial N depends on the seed and N alone; --only N repeats it. What fails is printed and kept in
SCRATCH/failed. Prints a table; exit status 1 if anything failed. Runs one process at a time, with one
thread. Records: docs/validation.md. Python 3.9 and h5py.
"""
import argparse
import pathlib
import sys
import tempfile

import damage
import matching
import sharing
import trials

ROOT = pathlib.Path(__file__).resolve().parents[2]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("attack", choices=("inputs", "signals", "disks", *matching.MISTAKES, *sharing.ATTACKS))
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int)
    parser.add_argument("--limit", type=float, default=20.0, help="seconds of one run (default: 20)")
    parser.add_argument("--only", type=int, help="this trial alone, of inputs")
    parser.add_argument("--points", type=int, help="tie points of the scenes (default: all)")
    parser.add_argument("--scratch", type=pathlib.Path, help="folder to work in (default: a temporary one)")
    options = parser.parse_args()
    program = options.program.resolve()
    with tempfile.TemporaryDirectory(prefix="sarblock-attack-") as folder:
        scratch = options.scratch or pathlib.Path(folder)
        scratch.mkdir(parents=True, exist_ok=True)
        scratch.chmod(0o755)
        if options.attack in matching.MISTAKES:
            count = options.count or (200 if options.attack == "exchanges" else 48)
            failed = matching.run(program, ROOT / "datasets/scenes", scratch, options.attack, options.seed, count,
                                   options.points, sys.stderr)
        elif options.attack in sharing.ATTACKS:
            count = options.count or sharing.ROUNDS[options.attack]
            failed = sharing.run(program, ROOT, scratch, options.attack, count, 3.0 * options.limit, sys.stderr)
        elif options.attack == "inputs":
            failed = trials.run(program, ROOT, scratch, options)
        else:
            failed = damage.run(program, ROOT, scratch, options)
    print(f"{failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
