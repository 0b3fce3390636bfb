#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The report in a real browser; run by ctest as report/browser.

Usage: browser_test.py PROGRAM SCENES [--keep FOLDER]

Simulates and adjusts shipped scenes, runs small studies, writes their reports and loads them in
headless Chromium without a network: every chart that a page describes is drawn with its data, the map
zooms, tables sort and none is cut, no script fails and the console stays silent, at the width of a
phone and of a desk, and no printed sheet is blank. Exit status 77 (skipped) where there is no
Chromium. With --keep the pages, screenshots and PDFs stay in FOLDER.
"""
import argparse
import csv
import html
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import zlib

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


def check_page(browser, page, width, folder=None):
    """The charts drawn are those described, each with data; returns them by id. With a folder a picture of
    the width asked for is taken of the same page and is not empty."""
    size = WIDTHS[width]
    flags = [f"--window-size={size[0]},{size[1]}", "--virtual-time-budget=4000", "--dump-dom"]
    if folder is not None:
        picture = folder / f"{page.stem}-{width}.png"
        flags.append(f"--screenshot={picture}")
    text = browse(browser, page, *flags)
    found = SELF_CHECK.search(text)
    require(found, f"{page} ({width}): no self-check, the script did not run")
    report = json.loads(html.unescape(found.group(1)))
    require(not report["errors"], f"{page} ({width}): {report['errors']}")
    described = described_charts(page)
    drawn = {chart["id"]: chart for chart in report["charts"]}
    require([c["id"] for c in described] == list(drawn), f"{page}: {list(drawn)} of {len(described)} drawn")
    for chart, seen in drawn.items():
        require(seen["data"] > 0, f"{page}: chart {chart} has no data")
        require(seen.get("series", 0) <= 5, f"{page}: chart {chart} has {seen.get('series')} series")
    check_tables(f"{page} ({width})", report["tables"])
    if folder is not None:
        data = picture.read_bytes()
        require(int.from_bytes(data[16:20], "big") == size[0], f"{picture}: wrong width")
        require(len(data) > 20000, f"{picture}: hardly anything to see")  # a blank page packs into a few kB
    return drawn


def described_charts(page):
    return json.loads(DATA.search(page.read_text(encoding="utf-8")).group(1))["charts"]


def check_tables(where, tables):
    """None is cut, ten rows are shown at first, a click on a heading sorts."""
    require(tables["cut"] == 0 and tables["beyond"] <= 0, f"{where}: cut or too wide: {tables}")
    require(tables["shown"] <= 10, f"{where}: {tables['shown']} rows are shown at first")
    trial = tables["sorted"]
    if trial is None:
        return
    require(0 < trial["left"] < trial["of"], f"{where}: the filter keeps the wrong rows: {trial}")
    ends = [list(map(float, trial[way])) for way in ("up", "down")
            if all(re.fullmatch(r"-?[0-9.]+", text) for text in trial[way])]
    for (first, last), sign in zip(ends, (1, -1)):
        require(sign * (last - first) >= 0, f"{where}: not sorted: {trial}")


def percentile(values, part):
    values = sorted(values)
    at = part * (len(values) - 1)
    low = int(at)
    return values[low] + (at - low) * (values[min(low + 1, len(values) - 1)] - values[low])


def check_map(page, result, drawn, graticule):
    """Colours from the 2nd to the 98th percentile of what is not control; zoom, names, keys."""
    (spec,) = [c for c in described_charts(page) if c["id"] == "map-chart"]
    with open(result / "points.csv", newline="", encoding="utf-8") as file:
        rows = [r for r in csv.DictReader(file) if r["role"] != "control" and r["sigma_u_m"]]
    sigmas = [float(r["sigma_u_m"]) for r in rows]
    for end, part in (("low", 0.02), ("high", 0.98)):
        want = percentile(sigmas, part)
        require(abs(spec["values"][2][end] - want) < 1e-3 * want,
                f"{page}: colours end at {spec['values'][2][end]}, not {want}")
    require(len(spec["ellipses"]) == 5 * len(rows), f"{page}: ellipses of {len(spec['ellipses']) / 5}")
    require(bool(spec["graticule"]) == graticule, f"{page}: graticule {len(spec['graticule'])}")
    seen = drawn["map-chart"]
    whole, near, again = seen["whole"], seen["near"], seen["again"]
    require(whole["ellipses"] > 0 and whole["bar"].endswith("m"), f"{page}: keys of the map: {whole}")
    require(abs(near["width"] / whole["width"] - 0.25) < 0.02, f"{page}: no zoom: {seen}")
    require(near["names"] > 0 and whole["names"] == 0, f"{page}: names only on demand: {seen}")
    require(near["enlarged"] < whole["enlarged"], f"{page}: ellipses grow with the zoom: {seen}")
    require(abs(again["width"] / whole["width"] - 1) < 0.05, f"{page}: not back at the block: {seen}")


def check_paper(browser, page, folder):
    """Every sheet holds text: none is blank, none holds a line or two left over."""
    document = folder / f"{page.stem}.pdf"
    browse(browser, page, "--virtual-time-budget=4000", "--no-pdf-header-footer",
           f"--print-to-pdf={document}")
    data = document.read_bytes()
    require(data.startswith(b"%PDF"), f"{document}: no PDF")
    objects = {int(m.group(1)): m.group(2)
               for m in re.finditer(rb"(\d+) 0 obj(.*?)endobj", data, re.S)}
    sheets = [body for body in objects.values() if re.search(rb"/Type\s*/Page\b", body)]
    require(0 < len(sheets) < 40, f"{document}: {len(sheets)} sheets")
    for number, sheet in enumerate(sheets, 1):
        body = objects[int(re.search(rb"/Contents (\d+) 0 R", sheet).group(1))]
        stream = body[body.index(b"stream") + 6:].lstrip(b"\r\n")
        drawn = zlib.decompressobj().decompress(stream)
        texts = drawn.count(b"Tj") + drawn.count(b"TJ") + 10 * drawn.count(b" Do")
        require(texts > 5, f"{document}: sheet {number} of {len(sheets)} is blank")


def sarblock(program, *arguments):
    run = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, timeout=120)
    require(run.returncode == 0, f"sarblock {arguments}: {run.stderr}")


DENSIFICATION = """format = "sarblock-study 1"
study = "densification"
name = "corners or a grid"
purpose = "What the fourth corner is worth."
scene = "{scene}"
[[axis]]
key = "control.layout"
values = ["corners", "grid"]
[[axis]]
key = "control.count"
values = [1, 2, 4]
[goal]
sigma_u_m = 9.0
sigma_h_m = 4.0
"""


def check_studies(program, scenes, browser, folder):
    """Name, goal and the answer of the text file; panels with named points."""
    file = folder / "control.toml"
    file.write_text(DENSIFICATION.format(scene=(scenes / "block-12-strips.toml").resolve()))
    studies = scenes.parent / "studies"
    for kind, study, options in (
            ("densification", file, []),
            ("tradeoff", studies / "tradeoff.toml",
             ["--set", "only_points=[100]", "--set", "only=[\"model\"]", "--set", "repeats=1"]),
            ("stability", studies / "stability.toml", ["--set", "families=[\"base\"]"])):
        out = folder / kind
        sarblock(program, "study", kind, study, "-o", out, *options)
        page = folder / f"{kind}.html"
        sarblock(program, "report", out, "-o", page)
        text = html.unescape(page.read_text(encoding="utf-8"))
        answer = (out / f"{kind}.txt").read_text(encoding="utf-8").splitlines()[0]
        require(answer[1:] in text, f"{page}: the answer is missing: {answer}")
        if kind == "densification":
            require("<h1>corners or a grid</h1>" in text and "Goal: What the fourth corner is worth." in text,
                    f"{page}: no name and goal")
        # Pages of the three kinds are laid out by the same code: one at each width and on paper.
        for width in WIDTHS if kind == "densification" else ["phone"]:
            drawn = check_page(browser, page, width, folder)
            require(any(chart["labels"] > 0 for chart in drawn.values()), f"{page}: no point is named")
        if kind == "densification":
            check_paper(browser, page, folder)


def run(program, scenes, browser, folder):
    block, result = folder / "block", folder / "result"
    sarblock(program, "simulate", scenes / "block-12-strips.toml", "-o", block)
    sarblock(program, "adjust", block, "-o", result, "--report")
    page = shutil.copy(result / "report.html", folder / "block-12-strips.html")
    drawn = check_page(browser, page, "desk", folder)
    for chart in ("map-chart", "checks-2", "profile-up-2", "profile-across-4", "histogram-range",
                  "quantiles-azimuth"):
        require(chart in drawn, f"{page}: no chart {chart}")
    require(drawn["map-chart"]["data"] == 1229, f"{page}: {drawn['map-chart']} points on the map")
    for name in ("strip-", "along-"):
        require(sum(chart.startswith(name) for chart in drawn) == 14, f"{page}: {name} {list(drawn)}")
    check_map(page, result, drawn, graticule=False)
    check_page(browser, page, "phone", folder)
    check_paper(browser, page, folder)

    other = folder / "huber"
    sarblock(program, "adjust", block, "-o", other, "--set", "robust=\"huber\"")
    comparison = folder / "comparison.html"
    sarblock(program, "report", result, other, "-o", comparison)
    for width in WIDTHS:
        require("sigma-2" in check_page(browser, comparison, width, folder), "no comparison of sigmas")
    check_paper(browser, comparison, folder)

    orbit, adjusted, intersected = folder / "orbit", folder / "adjusted", folder / "intersected"
    sarblock(program, "simulate", scenes / "earth-asc-desc.toml", "-o", orbit)
    sarblock(program, "adjust", orbit, "-o", adjusted, "--report")
    page = shutil.copy(adjusted / "report.html", folder / "earth-asc-desc.html")
    text = page.read_text(encoding="utf-8")
    require("north (along track)" in text and "more accurate azimuths" in text,
            f"{page}: north, along track, is weakest, and azimuths are not advised")
    drawn = check_page(browser, page, "desk", folder)
    check_map(page, adjusted, drawn, graticule=True)
    check_page(browser, page, "phone", folder)
    check_paper(browser, page, folder)
    sarblock(program, "intersect", orbit, "-o", intersected, "--report")
    page = shutil.copy(intersected / "report.html", folder / "intersected.html")
    require("map-chart" in check_page(browser, page, "phone"), "no map of the intersection")

    check_studies(program, scenes, browser, folder)


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
