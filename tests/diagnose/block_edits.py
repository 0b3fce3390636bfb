# SPDX-License-Identifier: Apache-2.0
"""Edits the files of a block as the words of a change say that `sarblock diagnose` proposes.

Only the sentence is read: files, keys, factors, signs, passes and points. Where it names "and 3 more" passes their names
are those of the list beside it."""
import csv
import io
import json
import math
import re
import tomllib

NUMBER = r"(-?[0-9.]+(?:e[-+]?[0-9]+)?)"
ELLIPSOIDS = {"WGS84": (6378137.0, 1 / 298.257223563), "GRS80": (6378137.0, 1 / 298.257222101),
              "Moon": (1737400.0, 0.0), "Venus": (6051800.0, 0.0), "Mars": (3396190.0, 1 / 169.894447223612)}
XYZ, GEODETIC, VELOCITY = ("x_m", "y_m", "z_m"), ("lat_deg", "lon_deg", "h_m"), ("vx_mps", "vy_mps", "vz_mps")


class Unclear(Exception):
    """The words do not say what to write."""


# ---- files

def read_rows(path):
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def write_rows(path, rows):
    columns = list(dict.fromkeys(name for row in rows for name in row))
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    path.write_text(text.getvalue(), encoding="utf-8")


def toml_value(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml_value, value)) + "]"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml_value(one)}" for key, one in value.items()) + " }"
    return json.dumps(value) if isinstance(value, str) else repr(value)


def toml_text(table, name=""):
    def is_tables(value):
        return isinstance(value, list) and value and all(isinstance(one, dict) for one in value)

    lines = [f"{key} = {toml_value(value)}" for key, value in table.items()
             if not isinstance(value, dict) and not is_tables(value)]
    for key, value in table.items():
        full = f"{name}.{key}" if name else key
        if isinstance(value, dict):
            lines.append(f"[{full}]\n" + toml_text(value, full))
        elif is_tables(value):
            lines += [f"[[{full}]]\n" + toml_text(one, full) for one in value]
    return "\n".join(lines) + "\n"


class Block:
    """A block folder as tables, written elsewhere after an edit."""

    def __init__(self, folder):
        self.folder = folder
        self.toml = tomllib.loads((folder / "block.toml").read_text(encoding="utf-8"))
        self.tables = {name: read_rows(folder / f"{name}.csv") for name in ("trajectories", "observations", "points")
                       if (folder / f"{name}.csv").exists()}

    def write(self, folder):
        folder.mkdir(parents=True)
        (folder / "block.toml").write_text(toml_text(self.toml), encoding="utf-8")
        for name, rows in self.tables.items():
            write_rows(folder / f"{name}.csv", rows)
        for name in ("truth.csv", "truth_passes.csv"):
            if (self.folder / name).exists():
                (folder / name).write_bytes((self.folder / name).read_bytes())

    def passes(self):
        return [one["id"] for one in self.toml["pass"]]

    def ellipsoid(self):
        frame = self.toml["frame"]
        if frame["kind"] == "local":
            return None
        named = frame["ellipsoid"]
        return ELLIPSOIDS[named] if isinstance(named, str) else (named["a_m"], named["f"])


# ---- geometry

def to_geodetic(p, ellipsoid):
    a, f = ellipsoid
    e2 = f * (2 - f)
    rho = math.hypot(p[0], p[1])
    lat, h = math.atan2(p[2], rho * (1 - e2)), 0.0
    for _ in range(50):
        n = a / math.sqrt(1 - e2 * math.sin(lat) ** 2)
        h = rho * math.cos(lat) + p[2] * math.sin(lat) - a * math.sqrt(1 - e2 * math.sin(lat) ** 2)
        lat = math.atan2(p[2], rho * (1 - e2 * n / (n + h)))
    return [math.degrees(lat), math.degrees(math.atan2(p[1], p[0])), h]


def from_geodetic(at, ellipsoid):
    a, f = ellipsoid
    e2 = f * (2 - f)
    lat, lon = math.radians(at[0]), math.radians(at[1])
    n = a / math.sqrt(1 - e2 * math.sin(lat) ** 2)
    return [(n + at[2]) * math.cos(lat) * math.cos(lon), (n + at[2]) * math.cos(lat) * math.sin(lon),
            (n * (1 - e2) + at[2]) * math.sin(lat)]


def enu_axes(lat_deg, lon_deg):
    lat, lon = math.radians(lat_deg), math.radians(lon_deg)
    return ([-math.sin(lon), math.cos(lon), 0.0],
            [-math.sin(lat) * math.cos(lon), -math.sin(lat) * math.sin(lon), math.cos(lat)],
            [math.cos(lat) * math.cos(lon), math.cos(lat) * math.sin(lon), math.sin(lat)])


def position(row, block):
    if row.get("x_m"):
        return [float(row[name]) for name in XYZ]
    return from_geodetic([float(row[name]) for name in GEODETIC], block.ellipsoid())


def put(row, p):
    for name in GEODETIC:
        row.pop(name, None)
    row.update(zip(XYZ, map(repr, p)))


# ---- words

def named_passes(words, block, told):
    """The passes of "of all passes", "pass A", "passes A and B", "of A, B, C, D and 2 more"."""
    words = re.sub(r"^(of |passes |pass )", "", words.strip())
    if words == "all passes":
        return block.passes()
    if re.search(r" and \d+ more$", words):
        return told["passes"]
    names = re.split(r", | and ", words)
    unknown = set(names) - set(block.passes())
    if unknown:
        raise Unclear(f"no such pass: {', '.join(unknown)}")
    return names


def named_known_points(words, block):
    """Rows of "of all known points", "of the control points", "of the check points", "of point C1"."""
    rows = [row for row in block.tables["points"] if row["role"] in ("control", "check")]
    words = words.strip()
    role = re.fullmatch(r"of the (control|check) points", words)
    point = re.fullmatch(r"of point (\S+)", words)
    if role:
        rows = [row for row in rows if row["role"] == role[1]]
    elif point:
        rows = [row for row in rows if row["point"] == point[1]]
    elif words != "of all known points":
        raise Unclear(words)
    return [row for row in rows if row.get("x_m") or row.get("lat_deg")]


def look_rows(words, block, told):
    names = set(named_passes(words, block, told))
    return [row for row in block.tables["observations"] if row["pass"] in names]


def state_rows(words, block, told):
    names = set(named_passes(words, block, told))
    return [row for row in block.tables["trajectories"] if row["pass"] in names]


def edit_number(row, column, edit):
    if row.get(column):
        row[column] = repr(edit(float(row[column])))


EDITS = []


def edit(pattern):
    def add(function):
        EDITS.append((re.compile(pattern), function))
        return function
    return add


# ---- observations.csv

@edit(rf"observations\.csv: (time_s|range_m) (of .+?) (minus|plus) {NUMBER}(?:, or correction\..*)?")
def shift_column(block, told, column, of, sign, size):
    by = float(size) * (1 if sign == "plus" else -1)
    for row in look_rows(of, block, told):
        edit_number(row, column, lambda value: value + by)


def squints(block, rows):
    given = {one["id"]: one.get("squint_deg", 0.0) for one in block.toml["pass"]}
    return [float(row["squint_deg"]) if row.get("squint_deg") else given[row["pass"]] for row in rows]


@edit(rf"observations\.csv: squint_deg (of .+?) (minus|plus) {NUMBER}(?:, or correction\..*)?")
def shift_squint(block, told, of, sign, size):
    rows = look_rows(of, block, told)
    for row, squint in zip(rows, squints(block, rows)):
        if not row.get("doppler_hz"):
            row["squint_deg"] = repr(squint + float(size) * (1 if sign == "plus" else -1))


@edit(rf"observations\.csv: .* known points show squint_deg (of .+?) plus {NUMBER} \+ {NUMBER} \* range_m")
def native_squint(block, told, of, constant, slope):
    rows = look_rows(of, block, told)
    for row, squint in zip(rows, squints(block, rows)):
        if not row.get("doppler_hz"):
            row["squint_deg"] = repr(squint + float(constant) + float(slope) * float(row["range_m"]))


@edit(rf"observations\.csv: time_s (of .+?) is {NUMBER} minus what it is")
def mirror_times(block, told, of, total):
    for row in look_rows(of, block, told):
        edit_number(row, "time_s", lambda value: float(total) - value)


@edit(rf"observations\.csv: (time_s|range_m|squint_deg|doppler_hz) (of .+?) divided by {NUMBER}")
def divide_column(block, told, column, of, by):
    for row in look_rows(of, block, told):
        edit_number(row, column, lambda value: value / float(by))


@edit(rf"observations\.csv: {NUMBER} \+ \(time_s - {NUMBER}\) / {NUMBER} for time_s (of .+)")
def stretch_times(block, told, first, second, rate, of):
    for row in look_rows(of, block, told):
        edit_number(row, "time_s", lambda value: float(first) + (value - float(second)) / float(rate))


@edit(r"observations\.csv: time_s off the path of (pass .+?) plus or minus a day \((\d+) s\) or a week \((\d+) s\), so that it is on it")
def unwrap_times(block, told, of, day, week):
    for name in named_passes(of, block, told):
        times = [float(row["time_s"]) for row in state_rows(name, block, told)]
        for row in look_rows(name, block, told):
            time = float(row["time_s"])
            if times[0] <= time <= times[-1]:
                continue
            for by in (int(day), -int(day), int(week), -int(week)):
                if times[0] <= time + by <= times[-1]:
                    row["time_s"] = repr(time + by)


@edit(r"observations\.csv: slant ranges in range_m (of .+?) as the product converts them; known points show for ground ranges r (.+)")
def slant_ranges(block, told, of, formulas):
    for flat, sphere, name in re.findall(
            rf"(?:sqrt\(r\^2 \+ {NUMBER}\^2\)|sqrt\((\S+\^2 \+ .+?) \* cos\(.+?\)\)) of pass (\S+?)(?:,|$)", formulas):
        for row in look_rows(name, block, told):
            r = float(row["range_m"])
            if flat:
                row["range_m"] = repr(math.hypot(r, float(flat)))
                continue
            antenna, ground = (float(one) for one in re.findall(rf"{NUMBER}\^2", sphere))
            row["range_m"] = repr(math.sqrt(antenna**2 + ground**2 - 2 * antenna * ground * math.cos(r / ground)))


@edit(r"observations\.csv: the right values in the row of point (.+?) in pass (.+?), or rejected = 1 there")
def reject_row(block, told, point, name):
    for row in look_rows(name, block, told):
        if row["point"] == point:
            row["rejected"] = "1"


@edit(r"observations\.csv: the right values in the rows of (.+?), or rejected = 1 in them")
def reject_rows(block, told, point):
    for row in block.tables["observations"]:
        if row["point"] == point:
            row["rejected"] = "1"


@edit(r"observations\.csv: exchange the names .+? and .+? in the rows of .+? or in those of .+?, which the looks do not tell: "
      r"else rejected = 1 in the rows of (.+?) and (.+)")
def reject_points(block, told, a, b):
    reject_rows(block, told, a)
    reject_rows(block, told, b)


@edit(r"observations\.csv: rejected = 1 in the rows of (.+?), whose looks do not tell which of them is wrong")
def reject_doubtful(block, told, point):
    reject_rows(block, told, point)


@edit(r"observations\.csv: exchange the names (.+?) and (.+?) in the rows of (.+)")
def exchange_points_of_pass(block, told, a, b, of):
    for row in look_rows(of, block, told):
        row["point"] = {a: b, b: a}.get(row["point"], row["point"])


@edit(r"observations\.csv: each row of (.+?) takes what the row (before|after) it measured, in the order of their "
      r"(times|points), and the (?:first|last) one what the (?:first|last) one did")
def shift_rows(block, told, name, side, order):
    rows = look_rows(name, block, told)
    if order == "times":
        rows.sort(key=lambda row: float(row["time_s"]))
    measured = [{key: row.get(key, "") for key in ("time_s", "range_m", "squint_deg", "doppler_hz")} for row in rows]
    step = -1 if side == "before" else 1
    for i, row in enumerate(rows):
        row.update({key: value for key, value in measured[(i + step) % len(rows)].items() if key in row})


# ---- trajectories.csv

@edit(rf"trajectories\.csv: (positions and velocities|positions|velocities) (of .+?) divided by {NUMBER}")
def divide_states(block, told, what, of, by):
    columns = (XYZ if "positions" in what else ()) + (VELOCITY if "velocities" in what else ())
    for row in state_rows(of, block, told):
        for column in columns:
            edit_number(row, column, lambda value: value / float(by))


def less_rotation(row, rate):
    x, y, vx, vy = (float(row[name]) for name in ("x_m", "y_m", "vx_mps", "vy_mps"))
    row["vx_mps"], row["vy_mps"] = repr(vx + rate * y), repr(vy - rate * x)


@edit(rf"trajectories\.csv: body-fixed positions and velocities (of .+?): both turned about z by -w \* \(time_s - "
      rf"{NUMBER}\) rad, then velocities minus w \* \(-y_m, x_m, 0\), w = {NUMBER} rad/s")
def body_fixed(block, told, of, at, rate):
    for row in state_rows(of, block, told):
        angle = -float(rate) * (float(row["time_s"]) - float(at))
        for u, v in (("x_m", "y_m"), ("vx_mps", "vy_mps")):
            x, y = float(row[u]), float(row[v])
            row[u], row[v] = (repr(x * math.cos(angle) - y * math.sin(angle)),
                              repr(x * math.sin(angle) + y * math.cos(angle)))
        less_rotation(row, float(rate))


@edit(rf"trajectories\.csv: velocities (of .+?) minus w \* \(-y_m, x_m, 0\), w = {NUMBER} rad/s, or .*")
def turning_velocities(block, told, of, rate):
    for row in state_rows(of, block, told):
        less_rotation(row, float(rate))


@edit(r"trajectories\.csv: exchange the names (.+?) and (.+)")
def exchange_paths(block, told, a, b):
    rows = block.tables["trajectories"]
    for row in rows:
        row["pass"] = {a: b, b: a}.get(row["pass"], row["pass"])
    rows.sort(key=lambda row: block.passes().index(row["pass"]))


# ---- points.csv

def edit_geodetic(block, of, change):
    for row in named_known_points(of, block):
        put(row, from_geodetic(change(to_geodetic(position(row, block), block.ellipsoid())), block.ellipsoid()))


@edit(r"points\.csv: exchange lat_deg and lon_deg (of .+)")
def exchange_lat_lon(block, told, of):
    edit_geodetic(block, of, lambda at: [at[1], at[0], at[2]])


@edit(r"points\.csv: lat_deg and lon_deg times 180/pi, to degrees, (of .+)")
def radians(block, told, of):
    edit_geodetic(block, of, lambda at: [math.degrees(at[0]), math.degrees(at[1]), at[2]])


@edit(r"points\.csv: the other sign of (lat|lon)_deg, positive (?:north|east), (of .+)")
def sign_of_angle(block, told, which, of):
    edit_geodetic(block, of, lambda at: [-at[0], at[1], at[2]] if which == "lat" else [at[0], -at[1], at[2]])


@edit(r"points\.csv: lon_deg plus or minus 180 (of .+)")
def half_turn(block, told, of):
    edit_geodetic(block, of, lambda at: [at[0], at[1] + 180.0, at[2]])


@edit(r"points\.csv: h_m times 1000, to metres, (of .+)")
def height_km(block, told, of):
    edit_geodetic(block, of, lambda at: [at[0], at[1], 1000.0 * at[2]])


@edit(r"points\.csv: planetographic \(geodetic\) latitudes, their tangents over \(1 - f\)\^2, in lat_deg (of .+)")
def planetographic(block, told, of):
    ratio = (1 - block.ellipsoid()[1]) ** 2
    edit_geodetic(block, of, lambda at: [math.degrees(math.atan(math.tan(math.radians(at[0])) / ratio)), at[1], at[2]])


@edit(rf"points\.csv: x_m, y_m, z_m of lat_deg, lon_deg and h_m on the ellipsoid of a = {NUMBER} m, f = {NUMBER} (of .+)")
def other_ellipsoid(block, told, a, f, of):
    for row in named_known_points(of, block):
        put(row, from_geodetic(to_geodetic(position(row, block), block.ellipsoid()), (float(a), float(f))))


@edit(r"points\.csv: x_m, y_m, z_m times 1000, to metres, (of .+)")
def known_km(block, told, of):
    for row in named_known_points(of, block):
        put(row, [1000.0 * x for x in position(row, block)])


@edit(r"points\.csv: exchange x_m and y_m (of .+)")
def exchange_x_y(block, told, of):
    for row in named_known_points(of, block):
        x, y, z = position(row, block)
        put(row, [y, x, z])


def edit_heights(block, of, change):
    if block.ellipsoid():
        edit_geodetic(block, of, lambda at: [at[0], at[1], change(at[2])])
        return
    for row in named_known_points(of, block):
        x, y, z = position(row, block)
        put(row, [x, y, change(z)])


@edit(rf"points\.csv: heights (of .+?) (minus|plus) {NUMBER}; check points .*")
def shift_heights(block, told, of, sign, size):
    edit_heights(block, of, lambda h: h + float(size) * (1 if sign == "plus" else -1))


@edit(r"points\.csv: the other sign of the heights (of .+)")
def sign_of_heights(block, told, of):
    edit_heights(block, of, lambda h: -h)


@edit(rf"points\.csv: heights in metres, times {NUMBER}, (of .+)")
def heights_in_feet(block, told, by, of):
    edit_heights(block, of, lambda h: float(by) * h)


@edit(r"points\.csv: role = tie (of .+?) until (?:they|their) .*")
def release_known(block, told, of):
    for row in named_known_points(of, block):
        row["role"] = "tie"


@edit(r"points\.csv: the coordinates of (.+?), or role = tie")
def release(block, told, point):
    for row in block.tables["points"]:
        if row["point"] == point:
            row["role"] = "tie"


@edit(r"points\.csv: exchange the coordinates of (.+?) and (.+)")
def exchange_known(block, told, a, b):
    rows = {row["point"]: row for row in block.tables["points"]}
    for name in XYZ:
        rows[a][name], rows[b][name] = rows[b][name], rows[a][name]


@edit(rf"points\.csv: the standard deviations of the known points times {NUMBER}")
def known_sigmas(block, told, by):
    for row in named_known_points("of all known points", block):
        for name in ("sigma_e_m", "sigma_n_m", "sigma_u_m"):
            edit_number(row, name, lambda value: value * float(by))
        for name in ("cov_en_m2", "cov_eu_m2", "cov_nu_m2"):
            edit_number(row, name, lambda value: value * float(by) ** 2)


# ---- block.toml

@edit(r"block\.toml: the other value of `look` (of .+)")
def other_side(block, told, of):
    for one in block.toml["pass"]:
        if one["id"] in named_passes(of, block, told):
            one["look"] = {"left": "right", "right": "left"}[one["look"]]


@edit(rf"block\.toml: wavelength_m (of .+?) divided by {NUMBER}")
def divide_wavelength(block, told, of, by):
    for one in block.toml["pass"]:
        if one["id"] in named_passes(of, block, told):
            one["wavelength_m"] /= float(by)


@edit(r"block\.toml: \[trajectory\] through = \"auto\", or other states (of .+?) in trajectories\.csv")
def through_auto(block, told, of):
    for one in block.toml["pass"]:
        if one["id"] in named_passes(of, block, told):
            one["trajectory"] = one.get("trajectory", {}) | {"through": "auto"}


SIGMAS = {"ranges": ("range_m",), "azimuths": ("azimuth_m", "azimuth_s", "doppler_hz")}
SIGMA_COLUMNS = {"ranges": ("range_sigma_m",), "azimuths": ("azimuth_sigma_m", "time_sigma_s", "doppler_sigma_hz")}


def edit_sigmas(block, told, what, of, change):
    """In [sigma] and the columns for all passes; for some the value of [sigma] is written in their tables."""
    kinds = re.split(" and ", what)
    names = named_passes(of, block, told)
    keys = [key for kind in kinds for key in SIGMAS[kind]]
    common = block.toml.get("sigma", {})
    for one in block.toml["pass"]:
        for key in keys:
            own = re.sub(r"_(m|s|hz)$", r"_sigma_\1", key)
            if one["id"] in names and own in one:
                one[own] = change(one[own])
            elif one["id"] in names and key in common and len(names) < len(block.passes()):
                one[own] = change(common[key])
    if len(names) == len(block.passes()):
        common.update({key: change(value) for key, value in common.items() if key in keys})
    for row in look_rows(of, block, told):
        for column in (column for kind in kinds for column in SIGMA_COLUMNS[kind]):
            edit_number(row, column, change)


@edit(rf"block\.toml: \[sigma\] \(or the columns of observations\.csv\) of the (ranges and azimuths|ranges|azimuths) (of .+?) divided by {NUMBER}")
def divide_sigmas(block, told, what, of, by):
    edit_sigmas(block, told, what, of, lambda value: value / float(by))


@edit(rf"block\.toml: {NUMBER} (m|s) more, by squares, in the standard deviations of the (ranges|azimuths) (of .+?)(?: \(some .*\))?")
def add_to_sigmas(block, told, size, unit, what, of):
    edit_sigmas(block, told, what, of, lambda value: math.hypot(value, float(size)))


@edit(r"block\.toml: in \[sigma\] \(or the columns of observations\.csv\) the square roots of the standard deviations")
def square_roots(block, told):
    edit_sigmas(block, told, "ranges and azimuths", "of all passes", math.sqrt)


# ---- corrections of block.toml

def corrections(block):
    return block.toml["adjust"].setdefault("correction", {})


def tables_of(block, kind):
    """The tables of a kind of correction, as an array from now on."""
    tables = corrections(block).get(kind, [])
    corrections(block)[kind] = tables if isinstance(tables, list) else [tables]
    return corrections(block)[kind]


def table_of(block, number, kind):
    tables = tables_of(block, kind)
    if not number and len(tables) != 1:
        raise Unclear("which table?")
    return tables[int(number or 1) - 1]


def correct(block, kind, table):
    tables_of(block, kind).append(table)
    if block.toml["adjust"].get("corrections") == "none":
        block.toml["adjust"]["corrections"] = "given"


def map_sigmas(sigma_m, of_axis):
    """sigma_m is a number of all axes, or a list by axis of numbers or of numbers by degree."""
    if sigma_m == "none":
        return sigma_m
    return [of_axis(one) for one in sigma_m] if isinstance(sigma_m, list) else of_axis(sigma_m)


def largest(sigma_m):
    return max(sigma_m) if isinstance(sigma_m, list) else sigma_m


TABLE = r"(?:number (\d+) of )?\[?\[adjust\.correction\.(\w+)\]\]?"


@edit(rf"block\.toml: {TABLE} with degree = (\d+) and a prior for its terms \(tried: {NUMBER} times the largest of the axis\)")
def raise_degree(block, told, number, kind, degree, times):
    table = table_of(block, number, kind)
    before = table.get("degree", 0)

    def of_axis(one):
        terms = one if isinstance(one, list) else [one] * (before + 1)
        return terms if "none" in terms else terms + [float(times) * max(terms)] * (int(degree) - before)

    table["degree"] = int(degree)
    if "sigma_m" in table:
        axes = len(table.get("components", "aaa"))
        sigma_m = table["sigma_m"] if isinstance(table["sigma_m"], list) else [table["sigma_m"]] * axes
        table["sigma_m"] = map_sigmas(sigma_m, of_axis)


@edit(rf"block\.toml: {TABLE} with basis = \"spline\", knot_spacing_s = {NUMBER} and of the priors of an axis the largest")
def spline_for_degree(block, told, number, kind, spacing):
    table = table_of(block, number, kind)
    table.pop("degree", None)
    table.update(basis="spline", knot_spacing_s=float(spacing))
    if "sigma_m" in table:
        table["sigma_m"] = map_sigmas(table["sigma_m"], largest)


@edit(rf"block\.toml: {TABLE} with knot_spacing_s = {NUMBER}")
def finer_knots(block, told, number, kind, spacing):
    table_of(block, number, kind)["knot_spacing_s"] = float(spacing)


@edit(rf"block\.toml: \[adjust\.correction\.position\] with degree = (\d+) and sigma_m as the flights are known \(tried: {NUMBER}\)")
def missing_polynomial(block, told, degree, sigma_m):
    correct(block, "position", {"degree": int(degree), "sigma_m": float(sigma_m)})


@edit(rf"block\.toml: \[adjust\.correction\.position\] with basis = \"spline\", knot_spacing_s = {NUMBER} and sigma_m as the flights are known \(tried: {NUMBER}\)")
def missing_spline(block, told, spacing, sigma_m):
    correct(block, "position", {"basis": "spline", "knot_spacing_s": float(spacing), "sigma_m": float(sigma_m)})


@edit(rf"block\.toml: passes of {TABLE} with (pass.+)")
def held_passes(block, told, number, kind, of):
    table_of(block, number, kind)["passes"] += named_passes(of, block, told)


@edit(rf"block\.toml: \[\[adjust\.correction\.position\]\] with basis = \"spline\", knot_spacing_s = {NUMBER}, components = (\[.+?\]), "
      rf"sigma_m = {NUMBER}, passes = (\[.+?\]), shared = true \(beside what the pass has(?:; a table each for (.+?))?\) if .*")
def spline_of_pass(block, told, spacing, components, sigma_m, first, others):
    for name in json.loads(first) + (named_passes(others, block, told) if others else []):
        correct(block, "position", {"basis": "spline", "knot_spacing_s": float(spacing), "passes": [name],
                                    "components": json.loads(components), "sigma_m": float(sigma_m), "shared": True})


@edit(rf"block\.toml: standard deviations of these corrections times {NUMBER} in \[adjust\.correction\] or \[adjust\.prior\], if .*")
def wider_priors(block, told, by):
    names = re.search(r"the priors of (.+?) are ", told["sentence"])
    if not names:
        raise Unclear("no names of priors")
    names = re.split(r", | and ", names[1])
    times = float(by)
    for kind in list(corrections(block)):
        for table in tables_of(block, kind):
            widen(table, kind, names, times)
    for prior in block.toml["adjust"].get("prior", {}).values():
        if set(prior["parameters"]) & set(names):
            if "covariance" in prior:
                prior["covariance"] = [[times**2 * one for one in row] for row in prior["covariance"]]
            if "sigma" in prior:
                prior["sigma"] = [times * one for one in prior["sigma"]]


def widen(table, kind, names, times):
    if kind == "position" and "sigma_m" in table:
        axes = table.get("components", ["x", "y", "z"] if table.get("axes") == "frame" else ["along", "across", "up"])
        sigma_m = table["sigma_m"] if isinstance(table["sigma_m"], list) else [table["sigma_m"]] * len(axes)
        for i, axis in enumerate(axes):
            if table.get("basis") == "spline":
                if f"position.{axis}" in names and sigma_m[i] != "none":
                    sigma_m[i] = times * largest(sigma_m[i])
                continue
            terms = sigma_m[i] if isinstance(sigma_m[i], list) else [sigma_m[i]] * (table.get("degree", 0) + 1)
            sigma_m[i] = [times * one if one != "none" and f"position.{axis}.{k}" in names else one
                          for k, one in enumerate(terms)]
        table["sigma_m"] = sigma_m
        return
    if kind == "velocity" and "sigma" in table:
        axes = table.get("components", ["across", "up"])
        sigma = table["sigma"] if isinstance(table["sigma"], list) else [table["sigma"]] * len(axes)
        table["sigma"] = [times * one if f"velocity.{axis}" in names else one for axis, one in zip(axes, sigma)]
        return
    for key in table:
        term = re.fullmatch(r"(bias|scale|zenith)_sigma_\w+", key)
        if term and f"{kind}.{term[1]}" in names:
            table[key] *= times


# ---- remarks

@edit(r"pass (.+?): \d+ of its \d+ looks equal those of pass (.+?): one is a copy; .* remove one of the passes")
def remove_pass(block, told, copy, original):
    block.toml["pass"] = [one for one in block.toml["pass"] if one["id"] != copy]
    for name in ("observations", "trajectories"):
        block.tables[name] = [row for row in block.tables[name] if row["pass"] != copy]


@edit(r"the same point under two ids, with equal looks: (\S+) and (\S+); .*")
def remove_point(block, told, a, b):
    for name in ("observations", "points"):
        block.tables[name] = [row for row in block.tables[name] if row["point"] != b]


def apply(block, told):
    """Edits `block` as told["change"] says; Unclear where the words do not say how."""
    for pattern, function in EDITS:
        found = pattern.fullmatch(told["change"])
        if found:
            function(block, told, *found.groups())
            return
    raise Unclear("no plain edit")
