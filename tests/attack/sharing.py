# SPDX-License-Identifier: Apache-2.0
"""Two runs into one folder, and threads of one Python process that read HDF5 files beside others."""
import collections
import os
import shutil
import subprocess
import sys
import textwrap

SLOW_RENAME = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <time.h>
#include <unistd.h>
/* As over a network: 0 to 40 ms. */
int rename(const char* from, const char* to) {
  static int (*real)(const char*, const char*);
  if (!real) *(void**)&real = dlsym(RTLD_NEXT, "rename");
  int result = real(from, to);
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  usleep((now.tv_nsec / 1000 * 7919 + getpid()) % 40000);
  return result;
}
"""
ALONE = ["unshare", "--pid", "--fork", "--mount-proc"]

READS = {
    "a pool of two threads": """
        from concurrent.futures import ThreadPoolExecutor
        with ThreadPoolExecutor(2) as pool:
            list(pool.map(sarblock.read_block, ["in0.h5", "in1.h5"] * 10))
        """,
    "a thread that writes HDF5": """
        block = sarblock.read_block("in0.h5")
        forever(lambda: block.write("out.h5", force=True))
        for _ in range(20):
            sarblock.read_block("in1.h5")
        """,
    "h5py in a thread": """
        import h5py
        def read():
            with h5py.File("in0.h5") as file:
                file["observations"]["range_m"][:]
        forever(read)
        for _ in range(20):
            sarblock.read_block("in1.h5")
        """,
    "numpy in a thread": """
        import numpy
        a = numpy.random.default_rng(1).standard_normal((600, 600))
        forever(lambda: a @ a)
        for _ in range(20):
            sarblock.read_block("in0.h5")
        """,
    "h5py, ended by Ctrl-C": """
        import h5py, signal
        def read():
            with h5py.File("in0.h5") as file:
                file["observations"]["range_m"][:]
        signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs ignore it
        forever(read)
        threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
        try:
            while True:
                sarblock.read_block("in1.h5")
        except KeyboardInterrupt:
            pass
        """,
}
BEGIN = """
import os, threading
import sarblock
def forever(work):
    def loop():
        while True:
            work()
    threading.Thread(target=loop, daemon=True).start()
"""
END = """
print("whole", flush=True)
os._exit(0)
"""


def reads(program, root, scratch, rounds, limit_s, out):
    """Each script so many times, each time a new process; returns how many did not end well within `limit_s`."""
    scene = root / "datasets/scenes/leberl-aircraft.toml"
    for i in range(2):
        subprocess.run([program, "simulate", scene, "-o", scratch / f"in{i}.h5", "-q", "--force", "--set",
                        "points.count=4000"], check=True)
    # program is BUILD/src/cli/sarblock, the package BUILD/python.
    package = program.parents[2] / "python"
    environment = dict(os.environ, PYTHONPATH=str(package))
    tallies = collections.Counter()
    for _ in range(rounds):
        for name, text in READS.items():
            script = BEGIN + textwrap.dedent(text) + END
            try:
                ended = subprocess.run([sys.executable, "-c", script], cwd=scratch, env=environment, capture_output=True,
                                       text=True, timeout=limit_s, check=False)
                outcome = "whole" if ended.stdout == "whole\n" and ended.returncode == 0 else "failed"
                if outcome == "failed":
                    print(name, ended.returncode, ended.stderr[-500:], file=out, flush=True)
            except subprocess.TimeoutExpired:
                outcome = "hang"
            tallies[name, outcome] += 1
    print("| beside it | whole | failed | hang |\n| --- | --- | --- | --- |")
    for name in READS:
        print(f"| {name} | {tallies[name, 'whole']} | {tallies[name, 'failed']} | {tallies[name, 'hang']} |")
    return sum(count for (_, outcome), count in tallies.items() if outcome != "whole")


def tables(folder):
    """The bytes of a result's tables by their names; None where the folder cannot be read."""
    try:
        return {path.name: path.read_bytes() for path in folder.iterdir()
                if path.suffix == ".csv" and not path.name.startswith(".")}
    except OSError:
        return None


def outputs(program, root, scratch, rounds, out):
    """Two runs at once into one folder: plainly, each as process 1 of a namespace of its own (where this user may
    make one), and over renames that take up to 40 ms. Asserted: one run ends with 0 and the folder holds all its
    tables, which `report` reads; the other says who writes there, or wrote after it. Returns the failures."""
    scene = root / "datasets/scenes/leberl-aircraft.toml"
    blocks, references = [], []
    for seed in (1, 2):
        block, reference = scratch / f"block{seed}", scratch / f"reference{seed}"
        subprocess.run([program, "simulate", scene, "-o", block, "-q", "--force", "--set", "points.count=4000", "--set",
                        f"seed={seed}"], check=True)
        subprocess.run([program, "adjust", block, "-o", reference, "-q", "--force", "--threads", "1"], check=True)
        blocks.append(block)
        references.append(tables(reference))
    source, library = scratch / "slow_rename.c", scratch / "slow_rename.so"
    source.write_text(SLOW_RENAME)
    slow = dict(os.environ)
    if subprocess.run(["cc", "-shared", "-fPIC", source, "-o", library, "-ldl"], check=False).returncode == 0:
        slow["LD_PRELOAD"] = str(library)
    ways = {"plain": ([], dict(os.environ)), "slow renames": ([], slow)}
    if subprocess.run([*ALONE, "true"], capture_output=True, check=False).returncode == 0:
        ways["process 1 of two namespaces"] = (ALONE, dict(os.environ))
        ways["namespaces, slow renames"] = (ALONE, slow)
    tallies, failures = collections.Counter(), 0
    folder = scratch / "result"
    for number in range(rounds):
        for way, (begin, environment) in ways.items():
            if number % 2 == 0:
                shutil.rmtree(folder, ignore_errors=True)  # every other round over an older result
            runs = [subprocess.Popen([*begin, program, "adjust", block, "-o", folder, "-q", "--force", "--threads", "1"],
                                     stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=environment)
                    for block in blocks]
            said = [run.communicate()[1] for run in runs]
            codes = [run.returncode for run in runs]
            held = tables(folder)
            whose = [k for k in range(2) if held == references[k]]
            told = all(code == 0 or (code == 3 and "another run" in text) for code, text in zip(codes, said))
            read = subprocess.run([program, "report", folder, "-o", scratch / "report.html", "-q", "--force"],
                                  capture_output=True, text=True, check=False)
            # Where both ended with 0 one came after the other.
            good = len(whose) == 1 and codes[whose[0]] == 0 and told and read.returncode == 0
            outcome = "both, one after the other" if codes == [0, 0] else "one, the other told"
            tallies[way, outcome if good else "wrong"] += 1
            if not good:
                failures += 1
                print(way, number, codes, whose, sorted(held or ()), said, read.stderr[-300:], file=out, flush=True)
            hidden = [path.name for path in folder.iterdir() if path.name.startswith(".")]
            if hidden:
                print(way, number, "left behind:", hidden, file=out, flush=True)
                failures += 1
    print("| runs | one ends with 0, the other told | one after the other | wrong |\n| --- | --- | --- | --- |")
    for way in ways:
        print(f"| {way} | {tallies[way, 'one, the other told']} | {tallies[way, 'both, one after the other']} | "
              f"{tallies[way, 'wrong']} |")
    return failures


def run(program, root, scratch, attack, rounds, limit_s, out):
    if attack == "reads":
        return reads(program, root, scratch, rounds, limit_s, out)
    return outputs(program, root, scratch, rounds, out)


ATTACKS = ("reads", "outputs")
ROUNDS = {"reads": 100, "outputs": 80}
