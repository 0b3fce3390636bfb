# SPDX-License-Identifier: Apache-2.0
"""Valid inputs of every command, made by the program itself from the scenes of `datasets/`, small
enough that each takes some hundredths of a second."""
import csv
import dataclasses
import math
import pathlib
import re
import shutil
import subprocess

import h5py

SMALL = ("points.count=14", "control.count=4", "check.count=3")

# Every group of corrections, for a block of one look side from the air.
CORRECTIONS = """
[adjust.correction.range]
bias_sigma_m = 2.0
scale_sigma_ppm = 5
[adjust.correction.time]
bias_sigma_s = 0.01
passes = ["A2"]
[adjust.correction.squint]
bias_sigma_deg = 0.02
shared = true
[adjust.correction.troposphere]
zenith_sigma_m = 0.5
scale_height_m = 7000
[adjust.correction.velocity]
components = ["up"]
sigma = 1e-4
"""

IMAGE = """[pass.image]
presentation = "{presentation}"
first_line_s = -10
line_interval_s = 0.004
range_spacing_m = 2.5
{range}
line_sigma_px = 0.5
pixel_sigma_px = 0.5
"""

STUDIES = {
    "densification": """format = "sarblock-study 1"
study = "densification"
name = "small"
scene = "scene.toml"
[[axis]]
name = "flights"
[[axis.case]]
name = "both"
[[axis]]
key = "control.layout"
values = ["corners", "grid"]
labels = ["four corners", "a grid"]
[[axis]]
key = "control.count"
values = [0, 4]
[[case]]
name = "places"
set = ["control.layout=places", "control.count=2", "control.places_m=[[2800, 14400], [17000, 23500]]"]
[[placement]]
name = "next"
set = ["control.layout=none"]
criterion = "worst-point"
count = 2
sigma_m = [1, 1, 2]
[verify]
runs = 2
every = 2
[goal]
sigma_h_m = 4.0
sigma_u_m = 9.0
""",
    "tradeoff": """format = "sarblock-study 1"
study = "tradeoff"
scene = "scene.toml"
repeats = 2
clock = "cpu"
[goal]
position_sigma = 0.1
covariance = 0.05
[[size]]
points = 14
set = ["points.count=14"]
longest_s = 0.05
[[size.skip]]
rows = ["solver.ceres"]
reason = "long"
[[choice]]
stage = "model"
name = "linear"
reference = true
[[choice]]
stage = "model"
name = "two-looks"
run = "two-looks"
[[choice]]
stage = "solver"
name = "reduced"
reference = true
[[choice]]
stage = "solver"
name = "ceres"
set = ["engine=ceres"]
most_points = 1000
reason = "memory"
threads = 1
""",
    "stability": """format = "sarblock-study 1"
study = "stability"
name = "two"
[[family]]
name = "squint"
values = [0, 20]
""",
}

# Where a value of one key stands for all settings of its kind, every setting is tried in its turn.
SETTINGS = ("quality.snooping=iterative", "quality.snooping=robust", "robust=huber", "robust=cauchy",
            "robust=tukey", "corrections=auto", "variance_components=range-azimuth",
            "variance_components=per-pass", "covariance=none", "covariance=leberl",
            "covariance=intersection", "pairs=all", "pairs=neighbours", "engine=ceres",
            "covariance_method=ceres", "datum=inner", "quality.test=tau", "scale_by_posterior=true")


@dataclasses.dataclass
class Input:
    """A command that ends well: `folder` is copied, and of its files those of `targets` are mutated."""
    command: str              # as the table of the attack names it
    arguments: list           # {in}: the copy of the folder, {out}: what is written
    folder: pathlib.Path
    targets: list
    older: pathlib.Path = None    # an older output, which stands at {out} before every second run
    writes: str = ""          # result, block, study, file or nothing


class Maker:
    def __init__(self, program, root, scratch):
        self.program, self.root, self.folder = program, root, scratch / "inputs"
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True)
        self.inputs = []

    def run(self, *arguments):
        subprocess.run([self.program, *arguments, "-q"], check=True, stdout=subprocess.DEVNULL)

    def simulated(self, scene, name, *options):
        sets = [word for key in SMALL for word in ("--set", key)]
        self.run("simulate", self.root / f"datasets/scenes/{scene}.toml", "-o", self.folder / name,
                 *sets, *options)
        return self.folder / name

    def blocks(self):
        """A local, a geocentric and a compressed block, one with every column and correction, one of
        lines and pixels; the name of an older result beside each."""
        local = self.simulated("leberl-aircraft", "local")
        orbits = self.simulated("earth-same-side", "orbits")
        text = (orbits / "block.toml").read_text(encoding="utf-8")
        text = text.replace('look = "', 'epoch_utc = "2022-10-16T01:50:44Z"\nlook = "')
        (orbits / "block.toml").write_text(text, encoding="utf-8")
        packed = self.simulated("convergent-squint", "packed", "--gzip")
        rich = self.simulated("leberl-aircraft", "rich")
        with open(rich / "block.toml", encoding="utf-8") as file:
            head, passes = file.read().split("[[pass]]", 1)
        (rich / "block.toml").write_text(head + CORRECTIONS.lstrip() + "[[pass]]" + passes, encoding="utf-8")
        self.rewrite(rich / "observations.csv", lambda row: dict(
            row, squint_deg="0", range_sigma_m="0.9", time_sigma_s="0.006", rejected="0"))
        images = self.simulated("leberl-aircraft", "images")
        head, first, second = (images / "block.toml").read_text(encoding="utf-8").split("[[pass]]")
        first += IMAGE.format(presentation="slant", range="near_range_m = 8000")
        second += IMAGE.format(presentation="ground", range="ground_range = [8000, 1.0, 1e-7]")
        (images / "block.toml").write_text("[[pass]]".join((head, first, second)), encoding="utf-8")
        self.rewrite(images / "observations.csv", in_lines_and_pixels)
        for block in (local, orbits, packed, rich, images):
            self.run("adjust", block, "-o", f"{block}-result")
            yield block

    def rewrite(self, table, change):
        with open(table, newline="", encoding="utf-8") as file:
            rows = [change(row) for row in csv.DictReader(file)]
        with open(table, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)

    def add(self, command, arguments, folder, targets, older=None, writes=""):
        self.inputs.append(Input(command, arguments, folder, targets, older, writes))

    def make(self):
        for block in self.blocks():
            self.of_block(block)
        self.of_result()
        self.of_scenes()
        self.of_studies()
        self.of_products()
        parallax = self.folder / "parallax"
        parallax.mkdir()
        (parallax / "table.csv").write_text("point,ground_range_m,point_height_m,parallax_m\n"
                                            "P1,15000,120.5,\nP2,18000,,14.25\n", encoding="utf-8")
        self.add("leberl", ["leberl", "parallax", "{in}/table.csv", "--base-m", "8000", "--height-m",
                            "10000", "--presentation", "ground"], parallax, ["table.csv"])
        return self.inputs

    def of_block(self, block):
        older = self.folder / f"{block.name}-result"
        targets = [file.name for file in sorted(block.iterdir())]
        self.add("check", ["check", "{in}", "--json"], block, targets)
        for command in ("intersect", "predict"):
            self.add(command, [command, "{in}", "-o", "{out}", "--json"], block, targets, older, "result")
        self.add("adjust", ["adjust", "{in}", "-o", "{out}", "--json", "--gzip"], block, targets, older,
                 "result")
        for setting in SETTINGS if block.name in ("local", "orbits") else ():
            self.add("adjust", ["adjust", "{in}", "-o", "{out}", "--json", "--set", setting], block,
                     targets, older, "result")
        self.add("adjust", ["adjust", "{in}", "-o", "{out}", "--report", "--set", "covariance=montecarlo",
                            "--set", "montecarlo_runs=30"], block, targets, older, "result")
        self.add("diagnose", ["diagnose", "{in}", "--json"], block, targets)
        self.add("convert", ["convert", "{in}", "{out}", "--gzip"], block, targets, block, "block")
        result = [file.name for file in sorted(older.iterdir())]
        self.add("convert", ["convert", "{in}", "{out}"], older, result, older, "result")
        self.of_containers(block, older)
        if block.name == "local":
            tables = self.folder / "tables"
            shutil.copytree(block, tables)
            shutil.copy(older / "residuals.csv", tables / "rejections.csv")
            (tables / "wanted.csv").write_text("point_a,point_b\nT1,T2\nT3,C1\n", encoding="utf-8")
            for target in ("rejections.csv", "wanted.csv"):
                options = ["--rejections", "{in}/rejections.csv", "--set", "pairs=wanted.csv"]
                self.add("adjust", ["adjust", "{in}", "-o", "{out}", *options], tables, [target], older,
                         "result")
                self.add("check", ["check", "{in}", *options], tables, [target])

    def of_containers(self, block, result):
        """The same block and its result as one file each."""
        files = self.folder / f"{block.name}-files"
        files.mkdir()
        for folder, name in ((block, "block.h5"), (result, "result.h5")):
            self.run("convert", folder, files / name)
        self.add("check", ["check", "{in}/block.h5", "--json"], files, ["block.h5"])
        self.add("adjust", ["adjust", "{in}/block.h5", "-o", "{out}", "--json"], files, ["block.h5"], result,
                 "result")
        self.add("convert", ["convert", "{in}/block.h5", "{out}"], files, ["block.h5"], block, "block")
        self.add("convert", ["convert", "{in}/result.h5", "{out}"], files, ["result.h5"], result, "result")
        self.add("report", ["report", "{in}/result.h5", "-o", "{out}"], files, ["result.h5"], writes="file")

    def of_result(self):
        pair = self.folder / "results"
        pair.mkdir()
        for name, block in (("a", "local"), ("b", "rich")):
            self.run("adjust", self.folder / block, "-o", pair / name, "--set", "pairs=neighbours", "--set",
                     "quality.snooping=iterative")
        self.run("adjust", self.folder / "orbits", "-o", pair / "c", "--set", "variance_components=range-azimuth",
                 "--set", "covariance=montecarlo", "--set", "montecarlo_runs=30")
        for name in "abc":
            targets = [f"{name}/{file.name}" for file in sorted((pair / name).iterdir())]
            self.add("report", ["report", f"{{in}}/{name}", "-o", "{out}"], pair, targets, writes="file")
            for form in ("geojson", "kml", "gpkg", "sinex", "isis", "eof") if name == "c" else ("gpkg",):
                options = ["--mission", "Sentinel-1A"] if form == "eof" else []
                self.add("export", ["export", f"{{in}}/{name}", "--format", form, "-o", "{out}", *options],
                         pair, targets, writes="file")
        self.add("report", ["report", "{in}/a", "{in}/b", "-o", "{out}"], pair,
                 [f"b/{file.name}" for file in sorted((pair / "b").iterdir())], writes="file")

    def of_scenes(self):
        scenes = self.folder / "scenes"
        scenes.mkdir()
        for file in sorted((self.root / "datasets/scenes").glob("*.toml")):
            text = file.read_text(encoding="utf-8")
            text = re.sub(r"(\[points\]\ncount = )\d+", r"\g<1>14", text)
            text = re.sub(r"(\[check\]\ncount = )\d+", r"\g<1>3", text)
            (scenes / file.name).write_text(text, encoding="utf-8")
            self.add("simulate", ["simulate", f"{{in}}/{file.name}", "-o", "{out}"], scenes, [file.name],
                     self.folder / "local", "block")

    def of_studies(self):
        for kind, text in STUDIES.items():
            folder = self.folder / f"study-{kind}"
            folder.mkdir()
            (folder / "study.toml").write_text(text, encoding="utf-8")
            shutil.copy(self.folder / "scenes/leberl-aircraft.toml", folder / "scene.toml")
            self.run("study", kind, folder / "study.toml", "-o", folder / "rows")
            self.add("study", ["study", kind, "{in}/study.toml", "-o", "{out}"], folder,
                     ["study.toml"] + (["scene.toml"] if kind != "stability" else []), writes="study")
            rows = [f"rows/{kind}.csv", f"rows/{kind}.progress"]
            self.add("study", ["study", kind, "{in}/study.toml", "-o", "{in}/rows"], folder,
                     [row for row in rows if (folder / row).exists()])
            self.add("report", ["report", "{in}/rows", "-o", "{out}"], folder, rows[:1], writes="file")

        parts = self.folder / "study-parts"
        parts.mkdir()
        for part in (1, 2):
            self.run("study", "densification", self.folder / "study-densification/study.toml", "--part", f"{part}/2",
                     "-o", parts / f"part{part}")
        self.add("study", ["study", "join", "{in}/part1", "{in}/part2", "-o", "{out}"], parts,
                 [f"part{part}/densification.{file}" for part in (1, 2) for file in ("progress", "study.toml")],
                 writes="study")

    def of_products(self):
        """Annotations and an orbit file that the fuzz targets were grown from."""
        products = self.folder / "products"
        corpus = self.root / "tests/fuzz/corpus/product"
        products.mkdir()
        for name in ("ground.xml", "slant.xml", "bursts_leap.xml", "orbit.xml"):
            shutil.copy(corpus / name, products / name)
        for name in ("ground.xml", "slant.xml", "bursts_leap.xml"):
            self.add("import", ["import", "sentinel1", f"{{in}}/{name}", "-o", "{out}"], products, [name],
                     self.folder / "local", "block")
        self.add("import", ["import", "sentinel1", "{in}/slant.xml", "--orbit", "{in}/orbit.xml", "-o",
                            "{out}", "--grid", "control", "--grid-sigma-m", "1"], products,
                 ["orbit.xml", "slant.xml"], self.folder / "local", "block")
        networks = self.folder / "networks"
        networks.mkdir()
        for name in ("network/moon.net", "cube/one.cub", "cube/two.cub", "isd/one.json", "isd/two.json"):
            shutil.copy(self.root / "tests/fuzz/corpus" / name, networks / name.replace("/", "_"))
        sigmas = ["--range-sigma-m", "4", "--azimuth-sigma-m", "6"]
        for kind, images in (("isis", ["cube_one.cub", "cube_two.cub"]), ("csm", ["isd_one.json", "isd_two.json"])):
            self.add("import", ["import", kind, "{in}/network_moon.net", *(f"{{in}}/{name}" for name in images),
                                "-o", "{out}", *sigmas], networks, ["network_moon.net", *images],
                     self.folder / "local", "block")
        (networks / "points.csv").write_text("point,image,line,sample,line_sigma_px,sample_sigma_px\n"
                                             "T1,isd_one,10,20,0.2,0.3\nT1,isd_two,11,21,,\nT2,isd_one.json,30,5,,\n")
        self.add("import", ["import", "images", "{in}/isd_one.json", "{in}/isd_two.json", "--points",
                            "{in}/points.csv", "-o", "{out}"], networks, ["points.csv", "points.csv", "isd_one.json"],
                 self.folder / "local", "block")
        sicd = [f"sicd_{name}.xml" for name in ("plain", "pfa", "azimuth_compression", "plane")]
        for name in sicd:
            shutil.copy(self.root / "tests/fuzz/corpus" / name.replace("_", "/", 1), networks / name)
        for name in sicd:
            self.add("import", ["import", "sicd", f"{{in}}/{name}", "-o", "{out}", "--grid", "check"], networks, [name],
                     self.folder / "local", "block")
        shutil.copy(self.root / "tests/fuzz/corpus/terrasarx/annotation.xml", networks / "terrasarx.xml")
        shutil.copy(self.root / "tests/fuzz/corpus/iceye/plain.xml", networks / "iceye.xml")
        self.add("import", ["import", "iceye", "{in}/iceye.xml", "-o", "{out}"], networks, ["iceye.xml"],
                 self.folder / "local", "block")
        self.add("import", ["import", "terrasarx", "{in}/terrasarx.xml", "-o", "{out}"], networks, ["terrasarx.xml"],
                 self.folder / "local", "block")
        write_nisar(networks / "rslc.h5")
        self.add("import", ["import", "nisar", "{in}/rslc.h5", "-o", "{out}"], networks, ["rslc.h5"],
                 self.folder / "local", "block")


def write_nisar(path):
    """An RSLC without pixels and grid: a circle about the Earth, seconds from 2022-10-16T23:59:00."""
    def times(file, name, values):
        file[name] = values
        file[name].attrs["units"] = "seconds since 2022-10-16T23:59:00"
    radius_m, rate, root = 7121234.5, 1.0508e-3, "/science/LSAR/RSLC"
    with h5py.File(path, "w") as file:
        file["/science/LSAR/identification/lookDirection"] = "Left"
        times(file, f"{root}/swaths/zeroDopplerTime", [50.25 + 0.01 * i for i in range(150)])
        file[f"{root}/swaths/frequencyA/slantRange"] = [850123.5 + 5.25 * i for i in range(200)]
        file[f"{root}/swaths/frequencyA/processedCenterFrequency"] = 1.2575e9
        orbit = [10.0 * i for i in range(13)]
        angles = [0.5 + rate * s for s in orbit]
        times(file, f"{root}/metadata/orbit/time", orbit)
        file[f"{root}/metadata/orbit/position"] = [
            [radius_m * math.cos(a), 0.04 * radius_m, radius_m * math.sin(a)] for a in angles]
        file[f"{root}/metadata/orbit/velocity"] = [
            [-radius_m * rate * math.sin(a), 0.0, radius_m * rate * math.cos(a)] for a in angles]


def in_lines_and_pixels(row):
    """The look of a row of time and range by the rasters of IMAGE: a slant one in A1, ground in A2."""
    line = (float(row["time_s"]) + 10) / 0.004
    ground = float(row["range_m"]) - 8000
    if row["pass"] == "A2":   # c0 + g + 1e-7 g^2
        ground = 2 * ground / (1 + (1 + 4e-7 * ground)**0.5)
    return {"pass": row["pass"], "point": row["point"], "line": repr(line), "pixel": repr(ground / 2.5)}
