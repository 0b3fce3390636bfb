# SPDX-License-Identifier: Apache-2.0
"""What is run: commands, each with the files that it writes. Paths are relative to the folder of the run, where
`datasets` and `corpus` are those of the project, so that messages and tables name no place of this computer."""
import dataclasses

SMALL = ("points.count=60", "check.count=8")
TINY = ("points.count=12", "control.count=4", "check.count=3")


@dataclasses.dataclass
class Case:
    name: str
    arguments: list
    output: str = ""     # file or folder that the command writes and that is compared


def sets(values):
    return [word for value in values for word in ("--set", value)]


def simulate(name, scene, values=(), more=()):
    return Case(name, ["simulate", scene, "-o", name, *sets(values), *more], name)


def adjust(name, block, values=(), more=(), command="adjust"):
    return Case(name, [command, block, "-o", name, *sets(values), *more], name)


def scenes(root):
    """Every shipped scene as it is: the block, its adjustment with the report, check, intersect, predict."""
    for scene in sorted((root / "datasets/scenes").rglob("*.toml")):
        path = scene.relative_to(root).as_posix()
        name = path.removeprefix("datasets/").removesuffix(".toml")
        yield simulate(f"{name}/block", path)
        yield Case(f"{name}/check", ["check", f"{name}/block"])
        yield adjust(f"{name}/adjust", f"{name}/block", more=["--report"])
        for command in ("intersect", "predict"):
            yield adjust(f"{name}/{command}", f"{name}/block", command=command)
        if "defective" in name or "recorded" in name:
            yield Case(f"{name}/diagnose", ["diagnose", f"{name}/block"])


def cabeus():
    block = "datasets/real/cabeus"
    yield Case("cabeus/check", ["check", block, "--json"])
    yield Case("cabeus/diagnose", ["diagnose", block, "--json"])
    yield adjust("cabeus/adjust", block, more=["--report"])
    yield adjust("cabeus/tables-gzip", block, more=["--gzip"])
    yield adjust("cabeus/robust", block, ["robust=huber"], ["--report"])
    yield adjust("cabeus/neighbours", block, ["pairs=neighbours"])
    for command in ("intersect", "predict"):
        yield adjust(f"cabeus/{command}", block, command=command)
    yield Case("cabeus/comparison", ["report", "cabeus/adjust", "cabeus/robust", "-o", "cabeus/comparison.html"],
               "cabeus/comparison.html")


WAYS = {
    "huber": ["robust=huber"],
    "cauchy": ["robust=cauchy"],
    "tukey": ["robust=tukey"],
    "snooping": ["quality.snooping=iterative"],
    "snooping-robust": ["quality.snooping=robust"],
    "tau": ["quality.test=tau"],
    "auto": ["corrections=auto"],
    "no-corrections": ["corrections=none"],
    "variance-range-azimuth": ["variance_components=range-azimuth"],
    "variance-per-pass": ["variance_components=per-pass"],
    "covariance-none": ["covariance=none"],
    "covariance-leberl": ["covariance=leberl"],
    "covariance-intersection": ["covariance=intersection"],
    "covariance-ceres": ["covariance_method=ceres"],
    "montecarlo": ["covariance=montecarlo", "montecarlo_runs=30"],
    "pairs-all": ["pairs=all"],
    "inner": ["datum=inner"],
    "posterior": ["scale_by_posterior=true"],
    "ceres": ["engine=ceres"],
    "spline": ['correction={ position = { basis = "spline", knot_spacing_s = 40, sigma_m = [15, 15, 15] } }'],
    "all-corrections": ["correction.range={ bias_sigma_m = 2.0, scale_sigma_ppm = 5 }",
                        "correction.time={ bias_sigma_s = 0.01 }",
                        "correction.squint={ bias_sigma_deg = 0.02, shared = true }",
                        'correction.velocity={ components = ["up"], sigma = 1e-4 }'],
    "refused": ["robust=hubert"],
}


def ways():
    """The ways to adjust, of a pair from the air, a pair with squint and three orbits."""
    for scene in ("leberl-aircraft", "convergent-squint", "earth-same-side"):
        block = f"ways/{scene}/block"
        yield simulate(block, f"datasets/scenes/{scene}.toml", SMALL)
        for way, values in WAYS.items():
            yield adjust(f"ways/{scene}/{way}", block, values, ["--report"] if way in ("auto", "montecarlo") else [])


def files():
    """One result in every format of other programs; blocks and results as one file and back."""
    result = "ways/earth-same-side/all-corrections"
    for form, ending in (("geojson", "geojson"), ("kml", "kml"), ("gpkg", "gpkg"), ("sinex", "snx"), ("isis", ""),
                         ("eof", "")):
        output = f"files/{form}" + (f".{ending}" if ending else "")
        yield Case(f"files/export-{form}", ["export", result, "--format", form, "-o", output], output)
    yield Case("files/export-cabeus-isis",
               ["export", "cabeus/adjust", "--format", "isis", "-o", "files/cabeus-isis"], "files/cabeus-isis")
    yield Case("files/export-pairs", ["export", "cabeus/neighbours", "--format", "gpkg", "-o", "files/pairs.gpkg",
                                      "--confidence", "95"], "files/pairs.gpkg")
    for name, folder in (("block", "ways/earth-same-side/block"), ("result", result),
                         ("auto", "ways/leberl-aircraft/auto"), ("cabeus", "datasets/real/cabeus")):
        yield Case(f"files/convert-{name}", ["convert", folder, f"files/{name}.h5"])
        yield Case(f"files/convert-{name}-back", ["convert", f"files/{name}.h5", f"files/{name}"], f"files/{name}")
    yield Case("files/check-h5", ["check", "files/block.h5"])
    yield adjust("files/adjust-h5", "files/block.h5")
    yield Case("files/report-h5", ["report", "files/result.h5", "-o", "files/result.html"], "files/result.html")
    yield simulate("files/block-gzip", "datasets/scenes/convergent-squint.toml", SMALL, ["--gzip"])
    yield adjust("files/rejections", "ways/convergent-squint/block",
                 more=["--rejections", "ways/convergent-squint/snooping/residuals.csv"])
    for command in (["leberl", "table1"], ["leberl", "examples"],
                    ["leberl", "single-flight", "--height-m", "10000", "--ground-range-m", "13000", "--squint-1-deg",
                     "-10", "--squint-2-deg", "12"],
                    ["leberl", "errors", "--base-m", "8000", "--height-m", "10000", "--ground-range-m", "13000",
                     "--dr-2", "10"]):
        yield Case(f"files/{command[0]}-{command[1]}", command)
    yield Case("files/manual", ["--dump-manual", "markdown"])
    yield Case("files/dump-block", ["check", "ways/earth-same-side/block", "--dump-config"])
    yield Case("files/dump-scene", ["simulate", "datasets/scenes/moon-alse.toml", "-o", "x", "--dump-config"])


def products():
    """Images of others, from what the fuzz targets were grown from; their paths back into their formats."""
    sigma = ["--range-sigma-m", "4", "--azimuth-sigma-m", "6"]
    given = "corpus/product/"
    for name in ("ground", "slant", "bursts_leap"):
        yield Case(f"products/{name}", ["import", "sentinel1", f"{given}{name}.xml", "-o", f"products/{name}"],
                   f"products/{name}")
    yield Case("products/control", ["import", "sentinel1", f"{given}slant.xml", "--grid", "control", "--grid-sigma-m",
                                    "1", "-o", "products/control"], "products/control")
    yield adjust("products/control-adjust", "products/control")
    yield Case("products/control-eof", ["export", "products/control-adjust", "--format", "eof", "-o", "products/eof"],
               "products/eof")
    yield Case("products/orbit", ["import", "sentinel1", f"{given}slant.xml", "--orbit", f"{given}orbit.xml", "--grid",
                                  "control", "--grid-sigma-m", "1", "-o", "products/orbit"], "products/orbit")
    for kind, one, two in (("isis", "cube/one.cub", "cube/two.cub"), ("csm", "isd/one.json", "isd/two.json")):
        yield Case(f"products/{kind}", ["import", kind, "corpus/network/moon.net", f"corpus/{one}", f"corpus/{two}",
                                        *sigma, "-o", f"products/{kind}"], f"products/{kind}")
        yield adjust(f"products/{kind}-adjust", f"products/{kind}")
    yield Case("products/csm-export", ["export", "products/csm-adjust", "--format", "csm", "-o", "products/csm-states",
                                       "--image", "one=corpus/isd/one.json", "--image", "two=corpus/isd/two.json"],
               "products/csm-states")
    for name in ("plain", "pfa", "azimuth_compression", "plane"):
        yield Case(f"products/sicd-{name}", ["import", "sicd", f"corpus/sicd/{name}.xml", "--grid", "check", "-o",
                                             f"products/sicd-{name}"], f"products/sicd-{name}")


STUDIES = {
    "voir-strips": ["set=['flight.0.count=3', 'flight.0.spacing_m=25000', 'flight.0.swath_ground_m=[340000, 430000]', "
                    "'points.north_m=[370000, 465000]', 'points.count=60']", "verify.runs=2"],
    "earth-pair": ["set=['points.count=40', 'check.count=5']", "verify.runs=2"],
}
STABILITY = """format = "sarblock-study 1"
study = "stability"
name = "small"
[[family]]
name = "squint"
values = [0, 30]
[[family]]
name = "sigma-level"
values = [1e-4, 1e-5]
"""


def studies(folder):
    (folder / "stability.toml").write_text(STABILITY, encoding="utf-8")
    for name, values in STUDIES.items():
        yield Case(f"studies/{name}", ["study", "densification", f"datasets/studies/{name}.toml", "-o",
                                       f"studies/{name}", *sets(values)], f"studies/{name}")
        yield Case(f"studies/{name}-report", ["report", f"studies/{name}", "-o", f"studies/{name}.html"],
                   f"studies/{name}.html")
    yield Case("studies/stability", ["study", "stability", "stability.toml", "-o", "studies/stability"],
               "studies/stability")


def all_cases(root, folder):
    for group in (scenes(root), cabeus(), ways(), files(), products(), studies(folder)):
        yield from group


# Scenes of the blocks whose copies are mutated, with what is set beside TINY.
BASES = {
    "leberl-aircraft": ("leberl-aircraft", []),
    "convergent-squint": ("convergent-squint", []),
    "block-12-strips": ("block-12-strips",
                        ["flight.0.count=3", "points.north_m=[16000, 36000]", "control.layout=corners"]),
    "earth-same-side": ("earth-same-side", []),
    "sparse-orbit": ("recorded/sparse-orbit", []),
    "corrections": ("leberl-aircraft", [f"adjust.{value}" for value in WAYS["all-corrections"]]),
}
# How mutated blocks are adjusted.
MUTANT_WAYS = ([], [], ["quality.snooping=iterative"], ["robust=tukey"], ["corrections=auto"])
# What is mutated, and how often of 20: a file of a block, a scene, a file of a result.
TARGETS = {"observations.csv": 6, "block.toml": 5, "points.csv": 3, "trajectories.csv": 2, "scene": 2, "result": 2}


def bases():
    """Blocks of the kinds of BASES and one with images, and of some a result."""
    for name, (scene, values) in BASES.items():
        yield simulate(f"mutants/{name}", f"datasets/scenes/{scene}.toml", [*TINY, *values])
    yield Case("mutants/images", ["import", "isis", "corpus/network/moon.net", "corpus/cube/one.cub",
                                  "corpus/cube/two.cub", "--range-sigma-m", "4", "--azimuth-sigma-m", "6", "-o",
                                  "mutants/images"], "mutants/images")
    yield adjust("mutants/result-1", "mutants/block-12-strips", ["pairs=neighbours"])
    yield adjust("mutants/result-2", "mutants/corrections", ["quality.snooping=iterative"])
