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
import base64
import csv
import html
import json
import os
import pathlib
import re
import select
import shutil
import subprocess
import sys
import tempfile
import time
import zlib

FLAGS = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
         "--disable-background-networking", "--disable-component-update", "--disable-sync",
         "--disable-dev-shm-usage", "--hide-scrollbars",
         # A page that asked for anything outside would fail loudly.
         "--host-resolver-rules=MAP * ~NOTFOUND"]
PATIENCE_S = 120  # for one answer
WIDTHS = {"phone": (390, 844), "desk": (1280, 900)}
DATA = re.compile(r'<script type="application/json" id="data">(.*?)</script>', re.S)


class Failure(Exception):
    pass


def require(condition, what):
    if not condition:
        raise Failure(what)


class Browser:
    """One headless Chromium for all pages, spoken to by its DevTools protocol: JSON messages that end in a
    zero byte, to its descriptor 3 and from its descriptor 4."""

    def __init__(self, program, profile):
        hears, self.write_to = os.pipe()
        self.read_from, says = os.pipe()
        # The shell gives the ends the numbers that Chromium expects, whatever they are here.
        command = f'exec "$@" 3<&{hears} 4>&{says}'
        self.log = open(pathlib.Path(profile) / "log", "w+b")
        self.process = subprocess.Popen(
            ["bash", "-c", command, "bash", program, *FLAGS, "--remote-debugging-pipe",
             f"--user-data-dir={profile}", "about:blank"],
            pass_fds=(hears, says), stdout=self.log, stderr=self.log)
        os.close(hears)
        os.close(says)
        self.calls = 0
        self.received = b""
        self.messages = []  # of the console of the page at hand
        self.loaded = set()  # loaders of pages, as the protocol names them
        self.session = None
        (target,) = [t for t in self.call("Target.getTargets")["targetInfos"] if t["type"] == "page"]
        self.session = self.call("Target.attachToTarget", targetId=target["targetId"], flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log"):
            self.call(f"{domain}.enable")
        self.call("Page.setLifecycleEventsEnabled", enabled=True)

    def close(self):
        try:
            self.session = None
            self.call("Browser.close")
            self.process.wait(timeout=PATIENCE_S)
        finally:
            self.process.kill()
            self.process.wait()
        os.close(self.write_to)
        os.close(self.read_from)
        self.log.close()

    def next_message(self, deadline):
        while b"\0" not in self.received:
            ready, _, _ = select.select([self.read_from], [], [], max(0.0, deadline - time.monotonic()))
            more = os.read(self.read_from, 1 << 20) if ready else b""
            if not more:
                self.log.seek(0)
                words = self.log.read().decode(errors="replace")[-2000:]
                raise Failure(f"the browser {'ended' if ready else 'does not answer'}:\n{words}")
            self.received += more
        message, _, self.received = self.received.partition(b"\0")
        message = json.loads(message)
        kind, told = message.get("method"), message.get("params")
        if kind == "Page.lifecycleEvent" and told["name"] == "load":
            self.loaded.add(told["loaderId"])
        elif kind == "Runtime.consoleAPICalled":
            self.messages.append(" ".join(str(a.get("value", a.get("description"))) for a in told["args"]))
        elif kind == "Runtime.exceptionThrown":
            self.messages.append(told["exceptionDetails"].get("exception", {}).get("description", "exception"))
        elif kind == "Log.entryAdded":
            self.messages.append(f"{told['entry']['text']} {told['entry'].get('url', '')}")
        return message

    def call(self, method, **parameters):
        self.calls += 1
        request = {"id": self.calls, "method": method, "params": parameters}
        if self.session is not None:
            request["sessionId"] = self.session
        os.write(self.write_to, json.dumps(request).encode() + b"\0")
        deadline = time.monotonic() + PATIENCE_S
        while True:
            answer = self.next_message(deadline)
            if answer.get("id") == self.calls:
                require("error" not in answer, f"{method}: {answer.get('error')}")
                return answer["result"]

    def load(self, page, width):
        """The page anew in a window of this width, until all of it is loaded, its scripts have run and it is painted:
        what is not painted is refused by the printer."""
        columns, rows = WIDTHS[width]
        self.call("Emulation.setDeviceMetricsOverride", width=columns, height=rows, deviceScaleFactor=1, mobile=False)
        self.messages.clear()
        loading = self.call("Page.navigate", url=page.resolve().as_uri())
        require("errorText" not in loading, f"{page}: {loading}")
        deadline = time.monotonic() + PATIENCE_S
        while loading["loaderId"] not in self.loaded:
            self.next_message(deadline)
        self.value("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")

    def value(self, expression):
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        require("exceptionDetails" not in answer, f"{expression}: {answer}")
        return answer["result"].get("value")

    def picture(self):
        return base64.b64decode(self.call("Page.captureScreenshot")["data"])

    def paper(self):
        printed = self.call("Page.printToPDF", printBackground=True, preferCSSPageSize=True)
        return base64.b64decode(printed["data"])

    def expect_silence(self, page):
        # Messages of the console arrive before the answer to a later question.
        self.value("1")
        require(not self.messages, f"{page}: the console says {self.messages}")


def check_page(browser, page, width, folder=None):
    """The charts drawn are those described, each with data; returns them by id. With a folder a picture of
    the width asked for is taken of the same page and is not empty."""
    browser.load(page, width)
    told = browser.value("document.getElementById('selfcheck').textContent")
    require(told, f"{page} ({width}): no self-check, the script did not run")
    report = json.loads(told)
    require(not report["errors"], f"{page} ({width}): {report['errors']}")
    described = described_charts(page)
    drawn = {chart["id"]: chart for chart in report["charts"]}
    require([c["id"] for c in described] == list(drawn), f"{page}: {list(drawn)} of {len(described)} drawn")
    for chart, seen in drawn.items():
        require(seen["data"] > 0, f"{page}: chart {chart} has no data")
        require(seen.get("series", 0) <= 5, f"{page}: chart {chart} has {seen.get('series')} series")
    check_tables(f"{page} ({width})", report["tables"])
    if folder is not None:
        picture = folder / f"{page.stem}-{width}.png"
        data = browser.picture()
        picture.write_bytes(data)
        require(int.from_bytes(data[16:20], "big") == WIDTHS[width][0], f"{picture}: wrong width")
        require(len(data) > 20000, f"{picture}: hardly anything to see")  # a blank page packs into a few kB
    browser.expect_silence(page)
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
    browser.load(page, "desk")
    data = browser.paper()
    document.write_bytes(data)
    browser.expect_silence(page)
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
    with open(result / "points.csv", newline="", encoding="utf-8") as file:
        placed = sum(bool(row["x_m"]) for row in csv.DictReader(file))
    require(drawn["map-chart"]["data"] == placed, f"{page}: {drawn['map-chart']} points on the map, not {placed}")
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
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None:
        print("skipped: there is no chromium on this machine")
        return 77
    with tempfile.TemporaryDirectory(prefix="sarblock-report-") as scratch:
        folder = arguments.keep or pathlib.Path(scratch) / "pages"
        folder.mkdir(parents=True, exist_ok=True)
        try:
            browser = Browser(program, pathlib.Path(scratch))
            try:
                run(arguments.program, arguments.scenes, browser, folder)
            finally:
                browser.close()
        except Failure as failure:
            print(f"failed: {failure}")
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
