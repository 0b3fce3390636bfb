#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The walk of an engineer who follows RunSolve and reads each function where it is called for the first time.

    scripts/walk.py [--build BUILD] [--scene SCENE] [--list]

Simulates SCENE and adjusts it with one thread under gdb, with the program of the release build BUILD, which stops
once at each function of the project (half a minute). The object files of BUILD say which room a function is of. What
the compiler has inlined is part of its caller, and what several rooms have copies of (functions of headers) is left
out.
Counted from RunSolve on are

  rooms     changes of room from one step of docs/architecture.md, "The way of one observation", to the next, and those
            of them that return to a room; a step is the function that it names first
  climbs    calls of a function of a room by one of a room below it (src/CMakeLists.txt has the order). Loops of `core`
            and `tables` run what they are given; a climb counts where that is of another room than who gave it

and it says whether the functions of the steps are called in the order of the steps. Exit status 1: they are not.
--list prints all functions, each with its room and the room of its caller."""
import argparse
import bisect
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
GIVEN_TO = {"core", "tables"}  # rooms whose loops run functions of others


def record():
    """Within gdb: the stack at the first call of each function, as addresses of the file."""
    import gdb  # pylint: disable=import-error

    for setting in ("pagination off", "confirm off", "breakpoint always-inserted on", "print thread-events off"):
        gdb.execute(f"set {setting}")
    with open(os.environ["WALK_ADDRESSES"], encoding="ascii") as file:
        addresses = json.load(file)
    gdb.execute("starti", to_string=True)
    maps = gdb.execute("info proc mappings", to_string=True).splitlines()
    base = min(int(line.split()[0], 16) for line in maps if os.environ["WALK_PROGRAM"] in line)
    stacks = []

    class Once(gdb.Breakpoint):
        def stop(self):
            self.enabled = False
            frame, stack = gdb.newest_frame(), []
            while frame is not None:
                stack.append(frame.pc() - base)
                frame = frame.older()
            stacks.append(stack)
            return False

    for address in addresses:
        Once(f"*{base + address:#x}", internal=True)
    gdb.execute("continue", to_string=True)
    with open(os.environ["WALK_STACKS"], "w", encoding="ascii") as file:
        json.dump(stacks, file)


def symbols(files):
    """Name and address of each function that the files define."""
    lines = subprocess.run(["nm", "-n", "--defined-only", *files], stdout=subprocess.PIPE, text=True, check=True).stdout
    return [(name, int(address, 16)) for address, name in re.findall(r"^(\w+) [tTwW] (\S+)$", lines, re.M)]


def first_calls(build, scene):
    """Functions in the order of their first call: (name, room) of each, then of its callers."""
    program = build / "src/cli/sarblock"
    homes = {}
    for place in (build / "src").rglob("*.o"):
        for name, _ in symbols([place]):
            homes.setdefault(name, set()).add(place.relative_to(build / "src").parts[0])
    table = symbols([program])
    plain = subprocess.run(["c++filt"], input="\n".join(name for name, _ in table), stdout=subprocess.PIPE, text=True,
                           check=True).stdout.splitlines()
    known = {}
    for (name, address), text in zip(table, plain):
        rooms = homes.get(name, set()) - {"mpi", "python"}
        if "sarblock" in name and ".cold" not in name and len(rooms) == 1:
            known[address] = (text, *rooms)
    starts = [address for _, address in table]
    with tempfile.TemporaryDirectory() as work:
        subprocess.run([program, "simulate", scene, "-o", f"{work}/block"], check=True, stdout=subprocess.DEVNULL)
        places = {"WALK_ADDRESSES": f"{work}/addresses", "WALK_STACKS": f"{work}/stacks", "WALK_PROGRAM": str(program)}
        with open(places["WALK_ADDRESSES"], "w", encoding="ascii") as file:
            json.dump(sorted(known), file)
        subprocess.run(["gdb", "-q", "-batch", "-x", __file__, "--args", program, "--threads", "1", "adjust",
                        f"{work}/block", "-o", f"{work}/result"], check=True, stdout=subprocess.DEVNULL,
                       env={**os.environ, **places, "OPENBLAS_NUM_THREADS": "1"})
        with open(places["WALK_STACKS"], encoding="ascii") as file:
            stacks = json.load(file)

    def function(address):
        return known.get(starts[bisect.bisect_right(starts, address) - 1])

    # The address to which a callee returns is behind the call, perhaps at the function that follows.
    walk = [[function(address - (k > 0)) for k, address in enumerate(stack) if address >= 0] for stack in stacks]
    walk = [[call for call in stack if call is not None] for stack in walk]
    begin = next(k for k, stack in enumerate(walk) if "files::ReadBlock(" in stack[0][0])  # RunSolve's first call
    return walk[begin:]


def steps():
    """Of each numbered step of the page: its number, the first function or class that it names, its files."""
    page = (ROOT / "docs/architecture.md").read_text(encoding="utf-8")
    table = page.split("## The way of one observation", 1)[1].split("\n## ", 1)[0]
    for number, text, files in re.findall(r"^\| (\d+) \| (.*) \| ([^|]*) \|$", table, re.M):
        yield int(number), re.search(r"`([A-Z]\w+)`", text).group(1), re.findall(r"`([^`]+)`", files)


def sources(file):
    return "".join(path.read_text(encoding="utf-8") for base in ("src", "include/sarblock")
                   for path in ROOT.glob(f"{base}/{file}.*"))


def climbs(walk, rank):
    """Callee and caller of each call of a room above."""
    for stack in walk:
        (_, room), callers = stack[0], stack[1:]
        callers = [call for call in callers if call[1] not in GIVEN_TO or rank[call[1]] >= rank[room]]
        if callers and rank[room] > rank[callers[0][1]]:
            yield stack[0], callers[0]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    parser.add_argument("--scene", type=pathlib.Path, default=ROOT / "datasets/scenes/leberl-aircraft.toml")
    parser.add_argument("--list", action="store_true")
    options = parser.parse_args()
    walk = first_calls(options.build.resolve(), options.scene)
    order = re.search(r"set\(modules ([^)]*)\)", (ROOT / "src/CMakeLists.txt").read_text(encoding="utf-8")).group(1)
    rank = {room: k for k, room in enumerate(order.split())}
    if options.list:
        for stack in walk:
            print(f"{stack[0][1]:<10} {stack[1][1] if len(stack) > 1 else '':<10} {stack[0][0][:150]}")
    scope = r"(\w+::|\(anonymous namespace\)::)*"
    wrong, rooms, last = [], [], -1
    for number, step, files in steps():
        wrong += [f"step {number}: there is no {file}" for file in files if not sources(file)]
        if not re.search(rf"\b{step}\b", sources(files[0])):
            wrong.append(f"step {number}: {step} is not in {files[0]}")
        for k, stack in enumerate(walk):
            name, room = stack[0]
            if files[0].startswith(f"{room}/") and re.match(rf"{scope}{step}(::|\(|\[)", name):
                break
        else:
            wrong.append(f"step {number}: {step} is not called")
            continue
        print(f"  {number:>2} {room:<10} call {k:>4}: {name[:80]}")
        if k < last:
            wrong.append(f"step {number} is called before the step above it")
        last = k
        if not rooms or rooms[-1] != room:
            rooms.append(room)
    up = list(climbs(walk, rank))
    for (name, room), (caller, below) in up:
        print(f"  climb from {below} to {room}: {caller[:60]} calls {name[:60]}")
    print(f"{len(walk)} functions of {len({stack[0][1] for stack in walk})} rooms; the steps change rooms "
          f"{len(rooms) - 1} times, {len(rooms) - len(set(rooms))} of these to a room passed before; {len(up)} climbs")
    print("\n".join(wrong) or "the functions of the steps are called in their order")
    return 1 if wrong else 0


if "WALK_STACKS" in os.environ:
    record()
elif __name__ == "__main__":
    sys.exit(main())
