#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Content and control fields of the Debian packages; run by ctest as package/deb and by
scripts/deb_test.sh.

Usage: check_deb.py FOLDER                     the packages of a folder
       check_deb.py FOLDER --cpack BUILD       makes them there first, from a complete build
With --python python3-sarblock is among them, with --mpi sarblock-mpi; both at the end."""
import gzip
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

PROGRAM_FILES = [
    "usr/bin/sarblock", "usr/share/man/man1/sarblock.1.gz",
    "usr/share/bash-completion/completions/sarblock", "usr/share/doc/sarblock/copyright",
    "usr/share/doc/sarblock/changelog.Debian.gz", "usr/share/doc/sarblock/docs/tutorial.md",
    "usr/share/sarblock/scenes/block-12-strips.toml",
    "usr/share/sarblock/real/cabeus/block.toml"]
LIBRARY_FILES = [
    "usr/include/sarblock/adjust/adjust.h", "usr/lib/libsarblock_adjust.a",
    "usr/lib/cmake/sarblock/sarblock-config.cmake", "usr/share/doc/libsarblock-dev/copyright",
    "usr/share/doc/libsarblock-dev/docs/api.md", "usr/share/doc/libsarblock-dev/docs/examples/own_problem.cc",
    "usr/share/doc/libsarblock-dev/changelog.Debian.gz"]
PYTHON = "usr/lib/python3/dist-packages/sarblock"
PYTHON_FILES = [
    f"{PYTHON}/__init__.py", f"{PYTHON}/_core.pyi", f"{PYTHON}/py.typed",
    "usr/share/doc/python3-sarblock/copyright", "usr/share/doc/python3-sarblock/changelog.Debian.gz"]
RANKS_FILES = [
    "usr/bin/sarblock-mpi", "usr/share/doc/sarblock-mpi/copyright", "usr/share/doc/sarblock-mpi/changelog.Debian.gz"]
ADJUST = """
import sarblock
block = sarblock.simulate({"format": "sarblock-scene 1", "name": "two-flights", "frame": {"kind": "local"},
    "flight": [{"id": i, "look": "left", "heading_deg": 90, "start_m": [0, y], "height_m": 8000, "length_m": 20000,
                "speed_mps": 150, "swath_ground_m": [g, g + 9000]} for i, y, g in (("A", 0, 9000), ("B", -6000, 15000))],
    "looks": {"range_sigma_m": 0.7, "azimuth_sigma_m": 0.9},
    "points": {"count": 30, "east_m": [2000, 18000], "north_m": [10000, 17000]}})
result = sarblock.adjust(block)
assert result.points.solved.all(), result
"""


def run(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def control(deb):
    return dict(re.findall(r"^(\S+): (.*)$", run("dpkg-deb", "-f", str(deb)), re.M))


def check(deb, files, fields, others):
    """Findings: files that are missing or that belong to the other package, fields that differ."""
    listed = run("dpkg-deb", "-c", str(deb)).splitlines()
    names = {line.split()[5].removeprefix("./").rstrip("/"): line for line in listed}
    for name in files:
        if name not in names:
            yield f"{name} is missing"
    for name, line in names.items():
        if name and not name.startswith("usr"):
            yield f"{name} is outside /usr"
        if any(re.fullmatch(other, name) for other in others):
            yield f"{name} belongs to the other package"
        if not re.match(r"[-dl]rw[-x]r-[-x]r-[-x] root/root", line):
            yield f"{name}: permissions or owner are wrong: {line.split()[0]} {line.split()[1]}"
    found = control(deb)
    for field, pattern in fields.items():
        if not re.search(pattern, found.get(field, "")):
            yield f"{field}: '{found.get(field, '')}' does not match '{pattern}'"


def check_program(deb):
    yield from check(deb, PROGRAM_FILES, {
        "Package": "^sarblock$", "Version": r"^\d+\.\d+\.\d+-1$", "Section": "^science$",
        "Maintainer": r".+ <\S+@\S+>$", "Description": "stereo block adjustment",
        # Found by dpkg-shlibdeps: the C library with a version, GeographicLib, BLAS.
        "Depends": r"libc6 \(>= .*libgeographiclib.*libopenblas"}, [r"usr/include/.*", r".*\.a", r".*\.cmake"])
    if "libsarblock" in control(deb).get("Depends", ""):
        yield "the program must carry our libraries itself"
    if "mpi" in control(deb).get("Depends", ""):
        yield "the program must not need MPI"
    with tempfile.TemporaryDirectory() as folder:
        run("dpkg-deb", "-x", str(deb), folder)
        page = gzip.open(pathlib.Path(folder) / PROGRAM_FILES[1], "rt", encoding="utf-8").read()
        if not page.startswith('.\\"') or ".SH EXIT STATUS" not in page:
            yield "sarblock.1.gz is no manual page"
        version = run(str(pathlib.Path(folder) / "usr/bin/sarblock"), "--version").split()[1]
        if not control(deb)["Version"].startswith(version + "-"):
            yield f"the program is version {version}, the package {control(deb)['Version']}"


def check_library(deb):
    yield from check(deb, LIBRARY_FILES, {
        "Package": "^libsarblock-dev$", "Section": "^libdevel$",
        "Depends": r"libceres-dev.*libeigen3-dev"}, [r"usr/bin/.*", r"usr/share/man/.*"])


def check_python(deb):
    yield from check(deb, PYTHON_FILES, {
        "Package": "^python3-sarblock$", "Section": "^python$",
        "Depends": r"(?=.*python3 \(<< 3\.\d+\))(?=.*python3-numpy)(?=.*libhdf5)(?=.*libc6)",
        "Suggests": "python3-matplotlib"}, [r"usr/bin/.*", r"usr/include/.*", r".*\.a", r".*/__pycache__/.*"])
    with tempfile.TemporaryDirectory() as folder:
        run("dpkg-deb", "-x", str(deb), folder)
        used = subprocess.run(["/usr/bin/python3", "-B", "-c", ADJUST], capture_output=True, text=True, check=False,
                              env={"PYTHONPATH": f"{folder}/usr/lib/python3/dist-packages"})
        if used.returncode != 0:
            yield f"the package does not adjust a block: {used.stderr}"


def check_ranks(deb):
    yield from check(deb, RANKS_FILES, {
        "Package": "^sarblock-mpi$", "Section": "^science$",
        "Depends": r"(?=.*libopenmpi3)(?=.*openmpi-bin)(?=.*libgeographiclib)"},
        [r"usr/bin/sarblock", r"usr/share/sarblock/.*", r"usr/include/.*", r".*\.a"])


def main():
    folder = pathlib.Path(sys.argv[1])
    if "--cpack" in sys.argv:
        shutil.rmtree(folder, ignore_errors=True)
        # xz, as in a release, takes most of a minute and checks nothing here.
        done = subprocess.run(["cpack", "-G", "DEB", "-B", str(folder), "-D", "CPACK_DEBIAN_COMPRESSION_TYPE=gzip"],
                              cwd=sys.argv[3], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            print(done.stdout + done.stderr)
            return 1
    debs = {control(deb)["Package"]: deb for deb in folder.glob("*.deb")}
    checks = {"sarblock": check_program, "libsarblock-dev": check_library}
    if "--python" in sys.argv:
        checks["python3-sarblock"] = check_python
    if "--mpi" in sys.argv:
        checks["sarblock-mpi"] = check_ranks
    if sorted(debs) != sorted(checks):
        print(f"{folder}: packages {sorted(debs)}, not {sorted(checks)}")
        return 1
    findings = [finding for name, check_one in checks.items() for finding in check_one(debs[name])]
    for finding in findings:
        print(finding)
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
