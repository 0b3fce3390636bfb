# SPDX-License-Identifier: Apache-2.0
"""Mistakes that are made in a file, from a flipped byte to a folder of the file's name."""
import functools
import io
import re
import shutil

import h5py

NUMBERS = ("0", "-0", "nan", "inf", "-inf", "1e308", "-1e308", "1e-308", "-1", "", "1e12", "1e999",
           "9223372036854775808", "0x10", "1,5", "1e5", "3", "text", "\u00e9", "\u0661")
TOML_VALUES = ("0", "-1", "1.5", "nan", "inf", "1e308", "true", '""', '"text"', "[]", "[1, 2]", "[[1], 2]",
               "{ a = 1 }", "1979-05-27", '["A1", "A1"]', "9223372036854775807", "'none'", "[nan, 1, 1]")
JSON_VALUES = ("0", "-1", "1e308", "1e999", "true", "null", '""', '"text"', "[]", "{}", "[1]", "NaN",
               "18446744073709551616", "-0.5")
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
GARBAGE = (b"\x00", b"\xff", b"\xef\xbb\xbf", b"\"", b",", b"\n", b"\r", b"[", b"]", b"=", b"<", b"&", b"#",
           b"\xf0\x9f\x92\xa5", b"9" * 400, b"-", b"'", b"{", b"\\u0000", b";")


# Of bytes.

def flip(data, rng):
    data = bytearray(data or b"\x00")
    for _ in range(rng.choice((1, 1, 2, 8))):
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    return bytes(data)


def truncate(data, rng):
    return data[:rng.randrange(len(data) + 1)]


def insert(data, rng):
    at = rng.randrange(len(data) + 1)
    return data[:at] + rng.choice(GARBAGE) + data[at:]


def repeat(data, rng):
    start = rng.randrange(len(data) + 1)
    return data[:start] + data[start:start + rng.randrange(1, 2000)] * 2 + data[start:]


def empty(_data, _rng):
    return b""


# Of lines.

def on_lines(change):
    @functools.wraps(change)
    def mutate(data, rng):
        lines = data.decode("utf-8", "surrogateescape").splitlines(keepends=True)
        return "".join(change(lines or [""], rng)).encode("utf-8", "surrogateescape")
    return mutate


@on_lines
def drop_lines(lines, rng):
    at = rng.randrange(len(lines))
    return lines[:at] + lines[at + rng.choice((1, 1, 1, 5, len(lines))):]


@on_lines
def double_line(lines, rng):
    at = rng.randrange(len(lines))
    return lines[:at] + [lines[at]] * rng.choice((2, 2, 3)) + lines[at + 1:]


@on_lines
def move_line(lines, rng):
    line = lines.pop(rng.randrange(len(lines)))
    lines.insert(rng.randrange(len(lines) + 1), line)
    return lines


@on_lines
def header_alone(lines, _rng):
    return lines[:1]


# Of cells, values and elements.

def on_cells(change):
    """A row (the header too) split at its commas."""
    @functools.wraps(change)
    def mutate(lines, rng):
        at = rng.randrange(len(lines)) if rng.random() < 0.8 else 0
        cells = lines[at].rstrip("\r\n").split(",")
        change(cells, rng)
        lines[at] = ",".join(cells) + "\n"
        return lines
    return on_lines(mutate)


@on_cells
def replace_cell(cells, rng):
    cells[rng.randrange(len(cells))] = rng.choice(NUMBERS)


@on_cells
def swap_cells(cells, rng):
    i, j = rng.randrange(len(cells)), rng.randrange(len(cells))
    cells[i], cells[j] = cells[j], cells[i]


@on_cells
def drop_cell(cells, rng):
    del cells[rng.randrange(len(cells))]


@on_cells
def rename_cell(cells, rng):
    i = rng.randrange(len(cells))
    cells[i] = rng.choice((cells[i] + "x", cells[i].upper(), cells[i][:-1], cells[0], " " + cells[i]))


@on_lines
def replace_column(lines, rng):
    column, value = rng.randrange(max(1, lines[0].count(",") + 1)), rng.choice(NUMBERS)
    for i in range(1, len(lines)):
        cells = lines[i].rstrip("\r\n").split(",")
        if column < len(cells):
            cells[column] = value
            lines[i] = ",".join(cells) + "\n"
    return lines


@on_lines
def scale_column(lines, rng):
    column, factor = rng.randrange(max(1, lines[0].count(",") + 1)), rng.choice((0, -1, 1e-9, 1e9, 1.001, 2))
    for i in range(1, len(lines)):
        cells = lines[i].rstrip("\r\n").split(",")
        if column < len(cells) and NUMBER.fullmatch(cells[column]):
            cells[column] = repr(float(cells[column]) * factor)
            lines[i] = ",".join(cells) + "\n"
    return lines


def replace_number(values):
    def replace(data, rng):
        text = data.decode("utf-8", "surrogateescape")
        found = list(NUMBER.finditer(text))
        if not found:
            return data
        match = rng.choice(found)
        text = text[:match.start()] + rng.choice(values) + text[match.end():]
        return text.encode("utf-8", "surrogateescape")
    return replace


@on_lines
def replace_toml_value(lines, rng):
    at = rng.choice([i for i, line in enumerate(lines) if "=" in line] or [0])
    key = lines[at].split("=")[0]
    lines[at] = f"{key}= {rng.choice(TOML_VALUES)}\n"
    return lines


@on_lines
def rename_toml_key(lines, rng):
    at = rng.randrange(len(lines))
    lines[at] = re.sub(r"\w+", lambda m: rng.choice((m[0] + "x", m[0][:-1], m[0].upper())), lines[at], count=1)
    return lines


def replace_json_value(data, rng):
    text = data.decode("utf-8", "surrogateescape")
    found = list(re.finditer(r'(?<=": )(?:"[^"]*"|[-\d.e+]+|true|false|null|\[\]|\{)', text))
    if not found:
        return data
    match = rng.choice(found)
    return (text[:match.start()] + rng.choice(JSON_VALUES) + text[match.end():]).encode("utf-8", "surrogateescape")


def change_element(data, rng):
    text = data.decode("utf-8", "surrogateescape")
    found = list(re.finditer(r"<(\w+)[^<>]*>([^<>]*)</\1>", text))
    if not found:
        return data
    match = rng.choice(found)
    new = rng.choice(("", match[0] * 2, match[0].replace(match[1], match[1] + "x"),
                      f"<{match[1]}>{rng.choice(NUMBERS)}</{match[1]}>"))
    return (text[:match.start()] + new + text[match.end():]).encode("utf-8", "surrogateescape")


OF_BYTES = (flip, truncate, insert, repeat, empty)
OF_LINES = (drop_lines, double_line, move_line)
OF_ENDING = {
    ".csv": (replace_cell, replace_cell, swap_cells, drop_cell, rename_cell, replace_column, scale_column,
             header_alone),
    ".toml": (replace_toml_value, replace_toml_value, replace_number(NUMBERS), rename_toml_key),
    ".json": (replace_json_value, replace_json_value, replace_number(JSON_VALUES)),
    ".xml": (change_element, change_element, replace_number(NUMBERS)),
}


# Of an HDF5 file: what it holds, and its bytes as of every file.

def within_container(change):
    """A mutation of the bytes that changes one dataset of the file in place."""
    @functools.wraps(change)
    def mutate(data, rng):
        image = io.BytesIO(data)
        with h5py.File(image, "r+") as file:
            names = []
            file.visititems(lambda name, node: names.append(name) if isinstance(node, h5py.Dataset) else None)
            if names:
                change(file, rng.choice(sorted(names)), rng)
        return image.getvalue()
    return mutate


def replace_values(file, name, rng):
    """One value, or all of a column, by one that its type can hold."""
    dataset = file[name]
    if not dataset.size:
        return
    text = h5py.check_string_dtype(dataset.dtype)
    if text or dataset.dtype.kind == "S":
        value = rng.choice([text for text in NUMBERS if "n" not in text.lower()])  # a name, no number
    elif dataset.dtype.kind == "f":
        value = rng.choice((0.0, -1.0, float("nan"), float("inf"), 1e308, 1e12, -1e-308))
    else:
        value = rng.choice((0, 1, 2, 255, 2**31 - 1, 2**32 - 1)) & (256**dataset.dtype.itemsize // 2 - 1)
    where = ... if rng.random() < 0.2 else tuple(rng.randrange(n) for n in dataset.shape)
    dataset[where] = value


def drop_dataset(file, name, _rng):
    del file[name]


def rename_dataset(file, name, rng):
    file.move(name, name + rng.choice(("s", "_m", "2")))


def cut_dataset(file, name, rng):
    """Another number of rows."""
    values = file[name][...]
    del file[name]
    file[name] = values[:rng.randrange(len(values))] if values.ndim and len(values) else [1.5]


def other_type(file, name, rng):
    shape = file[name].shape
    del file[name]
    file.create_dataset(name, shape, dtype=rng.choice(("f4", "i8", "u1", "f8", "S3")))


def change_attribute(file, name, rng):
    """An attribute of a dataset or of the file: dropped, a word or a number."""
    node = rng.choice((file, file[name]))
    if not node.attrs:
        return
    key = rng.choice(sorted(key for key in node.attrs))
    if rng.random() < 0.3:
        del node.attrs[key]
    else:
        node.attrs[key] = rng.choice(("", "text", "m", 1.5, -1, "[adjust]\nrobust = 3\n"))


OF_CONTAINERS = tuple(within_container(change) for change in (
    replace_values, replace_values, drop_dataset, rename_dataset, cut_dataset, other_type, change_attribute))


# Of the file as a whole.

def as_folder(path, _other, _rng):
    path.unlink()
    path.mkdir()


def as_link_to_nothing(path, _other, _rng):
    path.unlink()
    path.symlink_to("nothing")


def as_loop(path, _other, _rng):
    path.unlink()
    path.symlink_to(path.name)


def missing(path, _other, _rng):
    path.unlink()


def unreadable(path, _other, _rng):
    path.chmod(0)


def as_other(path, other, _rng):
    path.unlink()
    shutil.copy(other, path)


def as_device(path, _other, _rng):
    path.unlink()
    path.symlink_to("/dev/null")


OF_FILES = (as_folder, as_link_to_nothing, as_loop, missing, unreadable, as_other, as_device)


def mutate(path, rng):
    """Changes one file of a copy; returns the name of the mistake."""
    if rng.random() < 0.08:
        other = rng.choice(sorted(file for file in path.parent.iterdir() if file.is_file()))
        change = rng.choice(OF_FILES)
        change(path, other, rng) if other != path or change is not as_other else missing(path, other, rng)
        return change.__name__
    if path.suffix == ".h5":
        change = rng.choice(rng.choice((OF_BYTES, OF_CONTAINERS, OF_CONTAINERS)))
    else:
        special = OF_ENDING.get(path.suffix, OF_BYTES)
        change = rng.choice(rng.choice((OF_BYTES, OF_LINES, special, special, special)))
    data = path.read_bytes()
    for _ in range(rng.choice((1, 1, 1, 2, 4)) if change not in (truncate, empty) else 1):
        data = change(data, rng)
    path.write_bytes(data)
    return change.__name__
