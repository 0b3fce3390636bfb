#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The report in a real browser; run by ctest as report/browser.

Usage: browser_test.py PROGRAM SCENES [--keep FOLDER]

Simulates and adjusts shipped scenes, writes their reports and loads them in headless Chromium without
a network: every chart that a page describes is drawn with its data, no script fails and the console
stays silent, at the width of a phone and of a desk, and on paper. Exit status 77 (skipped) where there
is no Chromium. With --keep the pages, screenshots and PDFs stay in FOLDER.
"""
import argparse
import html
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

FLAGS = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
         "--disable-background-networking", "--disable-component-update", "--disable-sync",
         "--disable-dev-shm-usage", "--hide-scrollbars", "--enable-logging=stderr", "--v=0",
         # A page that asked for anything outside would fail loudly.
         "--host-resolver-rules=MAP * ~NOTFOUND"]
WIDTHS = {"phone": (390, 844), "desk": (1280, 900)}
CONSOLE = re.compile(r"CONSOLE[^\]]*\]\s*(.*)")
SELF_CHECK = re.compile(r'<pre id="selfcheck"[^>]*>(.*?)</pre>', re.S)
DATA = re.compile(r'<script type="application/json" id="data">(.*?)</script>', re.S)


class Failure(Exception):
    pass


def require(condition, what):
    if not condition:
        raise Failure(what)


def browse(browser, page, *flags):
    """Runs the browser on a page; returns its standard output. Console messages are failures."""
    with tempfile.TemporaryDirectory(prefix="sarblock-browser-") as profile:
        run = subprocess.run(
            [browser, *FLAGS, f"--user-data-dir={profile}", *flags, page.resolve().as_uri()],
            capture_output=True, text=True, timeout=120)
    require(run.returncode == 0, f"{browser} failed on {page}:\n{run.stderr[-2000:]}")
    messages = CONSOLE.findall(run.stderr)
    require(not messages, f"{page}: the console says {messages}")
    return run.stdout


def check_page(browser, page, width):
    """The charts drawn are those described, each with data; returns them by id."""
    size = WIDTHS[width]
    text = browse(browser, page, f"--window-size={size[0]},{size[1]}", "--virtual-time-budget=4000",
                  "--dump-dom")
    found = SELF_CHECK.search(text)
    require(found, f"{page} ({width}): no self-check, the script did not run")
    report = json.loads(html.unescape(found.group(1)))
    require(not report["errors"], f"{page} ({width}): {report['errors']}")
    described = json.loads(DATA.search(page.read_text(encoding="utf-8")).group(1))["charts"]
    drawn = {chart["id"]: chart["data"] for chart in report["charts"]}
    require([c["id"] for c in described] == list(drawn), f"{page}: {drawn} of {len(described)} drawn")
    for chart, count in drawn.items():
        require(count > 0, f"{page}: chart {chart} has no data")
    return drawn


def check_layout(browser, page, folder, width):
    """A picture of the width asked for, and not empty (a blank page packs into a few kB)."""
    size = WIDTHS[width]
    picture = folder / f"{page.stem}-{width}.png"
    browse(browser, page, f"--window-size={size[0]},{size[1]}", "--virtual-time-budget=4000",
           f"--screenshot={picture}")
    data = picture.read_bytes()
    require(int.from_bytes(data[16:20], "big") == size[0], f"{picture}: wrong width")
    require(len(data) > 20000, f"{picture}: hardly anything to see")


def check_paper(browser, page, folder):
    document = folder / f"{page.stem}.pdf"
    browse(browser, page, "--virtual-time-budget=4000", "--no-pdf-header-footer",
           f"--print-to-pdf={document}")
    data = document.read_bytes()
    require(data.startswith(b"%PDF"), f"{document}: no PDF")
    require(len(data) > 50000, f"{document}: hardly anything on it")


def sarblock(program, *arguments):
    run = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, timeout=120)
    require(run.returncode == 0, f"sarblock {arguments}: {run.stderr}")


def run(program, scenes, browser, folder):
    block, result = folder / "block", folder / "result"
    sarblock(program, "simulate", scenes / "block-12-strips.toml", "-o", block)
    sarblock(program, "adjust", block, "-o", result, "--report")
    page = shutil.copy(result / "report.html", folder / "block-12-strips.html")
    drawn = check_page(browser, page, "desk")
    for chart in ("map-chart", "checks-2", "profile-up", "histogram-range", "quantiles-azimuth"):
        require(chart in drawn, f"{page}: no chart {chart}")
    require(drawn["map-chart"] == 1229, f"{page}: {drawn['map-chart']} points on the map")
    require(sum(chart.startswith("strip-") for chart in drawn) == 14, f"{page}: strips {drawn}")
    check_page(browser, page, "phone")
    for width in WIDTHS:
        check_layout(browser, page, folder, width)
    check_paper(browser, page, folder)

    other = folder / "huber"
    sarblock(program, "adjust", block, "-o", other, "--set", "robust=\"huber\"")
    comparison = folder / "comparison.html"
    sarblock(program, "report", result, other, "-o", comparison)
    require("sigma-2" in check_page(browser, comparison, "desk"), "no comparison of sigmas")

    orbit, intersected = folder / "orbit", folder / "intersected"
    sarblock(program, "simulate", scenes / "earth-asc-desc.toml", "-o", orbit)
    sarblock(program, "intersect", orbit, "-o", intersected, "--report")
    page = shutil.copy(intersected / "report.html", folder / "intersected.html")
    require("map-chart" in check_page(browser, page, "phone"), "no map of the intersection")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("scenes", type=pathlib.Path)
    parser.add_argument("--keep", type=pathlib.Path)
    arguments = parser.parse_args()
    browser = shutil.which("chromium") or shutil.which("chromium-browser")
    if browser is None:
        print("skipped: there is no chromium on this machine")
        return 77
    try:
        if arguments.keep:
            arguments.keep.mkdir(parents=True, exist_ok=True)
            run(arguments.program, arguments.scenes, browser, arguments.keep)
        else:
            with tempfile.TemporaryDirectory(prefix="sarblock-report-") as folder:
                run(arguments.program, arguments.scenes, browser, pathlib.Path(folder))
    except Failure as failure:
        print(f"failed: {failure}")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
