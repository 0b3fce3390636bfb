# SPDX-License-Identifier: Apache-2.0
"""Inputs with one mistake each, the same for the same number on every machine: in bytes, lines, cells, columns and
values of TOML files. Plain functions of the file's bytes and a random generator; each also says what it did."""
import random
import re

VALUES = ("", "nan", "inf", "-inf", "1e400", "1e-320", "1e70", "0", "-0", "-1", "1", "2", "0.5", "1e3", "x", "0x10",
          "1,5", "+3", "  7 ", "\u00e9", '"1"', '"1', "#1")
TOML_VALUES = ("nan", "inf", "1e400", "0", "-1", "0.5", "1e6", "true", '""', '"x"', "[]", "[1, 2]", "[nan, 1, 1]",
               "[[1], 2]", "{}", "{ a = 1 }", "2022-10-16", "9223372036854775808", "'none'")
COLUMNS = ("squint_deg", "doppler_hz", "range_sigma_m", "azimuth_sigma_m", "time_sigma_s", "doppler_sigma_hz",
           "rejected", "line", "pixel", "line_sigma_px", "sigma_e_m", "lat_deg", "role", "cov_en_m2", "unknown")
NUMERIC = re.compile(r"(?<== |.\[|, )-?\d+(?:\.\d+)?(?=$|\]|,)")
BYTES = (b"\x00", b"\x01", b"\xff", b'"', b",", b"\n", b"\r", b"#", b"=", b"[", b"]", b".", b"-", b"9", b" ", b"e")


# Of any file.

def change_byte(data, rng):
    at, new = rng.randrange(len(data)), rng.choice(BYTES)
    return data[:at] + new + data[at + 1:], f"byte {at} becomes {new!r}"


def insert_byte(data, rng):
    at, new = rng.randrange(len(data) + 1), rng.choice(BYTES)
    return data[:at] + new + data[at:], f"{new!r} before byte {at}"


def truncate(data, rng):
    length = rng.randrange(len(data))
    return data[:length], f"the first {length} bytes"


def add_mark(data, _rng):
    return b"\xef\xbb\xbf" + data, "begins with a byte order mark"


def end_lines(data, _rng):
    return data.replace(b"\n", b"\r\n"), "lines end with CR LF"


def lines_of(data):
    return data.decode("utf-8").split("\n")[:-1]


def joined(lines):
    return ("\n".join(lines) + "\n").encode("utf-8")


def delete_line(data, rng):
    lines = lines_of(data)
    at = rng.randrange(len(lines))
    del lines[at]
    return joined(lines), f"without line {at + 1}"


def repeat_line(data, rng):
    lines = lines_of(data)
    line, at = rng.randrange(len(lines)), rng.randrange(len(lines))
    lines.insert(at, lines[line])
    return joined(lines), f"line {line + 1} again at {at + 1}"


def exchange_lines(data, rng):
    lines = lines_of(data)
    a, b = rng.randrange(len(lines)), rng.randrange(len(lines))
    lines[a], lines[b] = lines[b], lines[a]
    return joined(lines), f"lines {a + 1} and {b + 1} exchanged"


# Of tables.

def row_of(lines, rng):
    """Number and cells of a line, in one of ten cases of the header."""
    at = 0 if rng.random() < 0.1 else rng.randrange(len(lines))
    return at, lines[at].split(",")


def with_row(lines, at, cells):
    return joined(lines[:at] + [",".join(cells)] + lines[at + 1:])


def replace_cell(data, rng):
    lines = lines_of(data)
    at, cells = row_of(lines, rng)
    column, value = rng.randrange(len(cells)), rng.choice(VALUES)
    cells[column] = value
    return with_row(lines, at, cells), f"line {at + 1}, cell {column + 1} becomes {value!r}"


def change_cell(data, rng):
    """A number that stays one: little beside its sigma, or much."""
    lines = lines_of(data)
    at, cells = row_of(lines, rng)
    column, factor = rng.randrange(len(cells)), rng.choice((1 + 1e-9, 1 + 1e-6, 1.0003, 1.01, -1))
    try:
        cells[column] = repr(float(cells[column]) * factor)
    except ValueError:
        pass  # not a number
    return with_row(lines, at, cells), f"line {at + 1}, cell {column + 1} times {factor}"


def delete_cell(data, rng):
    lines = lines_of(data)
    at, cells = row_of(lines, rng)
    column = rng.randrange(len(cells))
    del cells[column]
    return with_row(lines, at, cells), f"line {at + 1} without cell {column + 1}"


def add_cell(data, rng):
    lines = lines_of(data)
    at, cells = row_of(lines, rng)
    return with_row(lines, at, cells + ["9"]), f"line {at + 1} with a cell more"


def copy_cell(data, rng):
    """A value of another row: an id that stands twice, a time or a place of another point."""
    lines = lines_of(data)
    at, cells = row_of(lines, rng)
    column, other = rng.randrange(len(cells)), rng.randrange(len(lines))
    cells[column] = (lines[other].split(",") + [""] * len(cells))[column]
    return with_row(lines, at, cells), f"line {at + 1}, cell {column + 1} as in line {other + 1}"


def on_columns(lines, change):
    rows = [line.split(",") for line in lines]
    width = len(rows[0])
    return joined([",".join(change(row, number)) if len(row) == width else ",".join(row)
                   for number, row in enumerate(rows)])


def exchange_columns(data, rng):
    lines = lines_of(data)
    width = lines[0].count(",") + 1
    a, b = rng.randrange(width), rng.randrange(width)
    keep_header = rng.random() < 0.5

    def change(row, number):
        if number > 0 or not keep_header:
            row[a], row[b] = row[b], row[a]
        return row
    return on_columns(lines, change), (f"columns {a + 1} and {b + 1} exchanged" +
                                       (" below their header" if keep_header else ""))


def delete_column(data, rng):
    lines = lines_of(data)
    at = rng.randrange(lines[0].count(",") + 1)
    return on_columns(lines, lambda row, _: row[:at] + row[at + 1:]), f"without column {at + 1}"


def add_column(data, rng):
    name, values = rng.choice(COLUMNS), [rng.choice(("", "1", "0.1")) for _ in range(7)]
    return (on_columns(lines_of(data), lambda row, n: row + [name if n == 0 else values[n % 7]]),
            f"with a column {name}: {values}")


def scale_column(data, rng):
    lines = lines_of(data)
    at, factor = rng.randrange(lines[0].count(",") + 1), rng.choice((0, -1, 1e-9, 1e9, 1.001))

    def change(row, number):
        try:
            row[at] = row[at] if number == 0 else repr(float(row[at]) * factor)
        except ValueError:
            pass  # not a number
        return row
    return on_columns(lines, change), f"column {at + 1} times {factor}"


# Of TOML.

def assignment(lines, rng):
    return rng.choice([i for i, line in enumerate(lines) if "=" in line and not line.startswith("#")])


def replace_value(data, rng):
    lines = lines_of(data)
    at, value = assignment(lines, rng), rng.choice(TOML_VALUES)
    key = lines[at].split("=")[0].strip()
    lines[at] = f"{key} = {value}"
    return joined(lines), f"line {at + 1}: {key} = {value}"


def scale_value(data, rng):
    lines, factor = lines_of(data), rng.choice((0.1, 0.5, 2, 10, 1e3))
    at = rng.choice([i for i, line in enumerate(lines) if NUMERIC.search(line)])
    lines[at] = NUMERIC.sub(lambda match: repr(float(match[0]) * factor), lines[at])
    return joined(lines), f"line {at + 1} times {factor}"


def rename_key(data, rng):
    lines = lines_of(data)
    at = assignment(lines, rng)
    key, value = lines[at].split("=", 1)
    key = key.strip()
    new = rng.choice((key + "x", key[:-1], key.upper(), "sigma_m", "id"))
    lines[at] = f"{new} ={value}"
    return joined(lines), f"line {at + 1}: {key} is called {new}"


def replace_digit(data, rng):
    at = rng.choice([i for i, byte in enumerate(data) if chr(byte).isdigit()])
    new = rng.choice("0123456789").encode()
    return data[:at] + new + data[at + 1:], f"byte {at}: the digit {new.decode()}"


OF_BYTES = (change_byte, change_byte, insert_byte, truncate, delete_line, repeat_line, exchange_lines, replace_digit)
OF_TABLES = OF_BYTES + (end_lines, add_mark, exchange_columns, delete_column, scale_column, delete_cell, add_cell,
                        *[replace_cell] * 5, *[change_cell] * 5, *[copy_cell] * 3, *[add_column] * 2)
OF_TOML = OF_BYTES + (*[replace_value] * 3, *[scale_value] * 3, rename_key)


def mutate(path, seed):
    """Makes one mistake in the file and says which."""
    rng = random.Random(seed)
    mistake = rng.choice({".toml": OF_TOML, ".csv": OF_TABLES}.get(path.suffix, OF_BYTES))
    data, says = mistake(path.read_bytes(), rng)
    path.write_bytes(data)
    return f"{path.name}: {says}"
