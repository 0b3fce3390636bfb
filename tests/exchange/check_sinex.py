#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Reads a SINEX 2.02 file by the columns of its format description, independent of the writer.

Usage: check_sinex.py FILE.snx. Prints the counts, or the first thing that is wrong (exit status 1).
As a module, read_sinex() returns the estimates and the full covariance matrix.

Checked: header and footer, lines of printable ASCII of at most 80 characters, blocks that open and
close, fields in their columns, indices without gaps, a matrix that stores the lower triangle once,
standard deviations that are the roots of its diagonal, and positive definiteness (Cholesky).
"""
import math
import re
import sys

TIME = r"\d\d:\d{3}:\d{5}"
HEADER = re.compile(rf"%=SNX 2\.02 [A-Z0-9]{{3}} {TIME} [A-Z0-9]{{3}} {TIME} {TIME} "
                    r"[CDLMPRS] (\d{5}) ([012])( [SOETCABVG]){1,6}$")
SITE = re.compile(r" (.{4}) (.{2}) (.{9}) ([CDLMPRS]) (.{22}) ([ \d-]{3}) ([ \d]{2}) ([ \d.]{4}) "
                  r"([ \d-]{3}) ([ \d]{2}) ([ \d.]{4}) ([ \d.-]{7})$")
EPOCH = re.compile(rf" (.{{4}}) (.{{2}}) (.{{4}}) ([CDLMPRS]) ({TIME}) ({TIME}) ({TIME})$")
REAL21 = r"[ -]\d\.\d{14}E[+-]\d\d"
ESTIMATE = re.compile(rf" ([ \d]{{5}}) (STA[XYZ]  ) (.{{4}}) (.{{2}}) (.{{4}}) ({TIME}) (m   ) "
                      rf"([012]) ({REAL21}) (\d\.\d{{5}}E[+-]\d\d)$")
ELEMENTS = re.compile(rf" ([ \d]{{5}}) ([ \d]{{5}})((?: {REAL21}){{1,3}})$")
BLOCKS = ["FILE/REFERENCE", "FILE/COMMENT", "SOLUTION/STATISTICS", "SITE/ID", "SOLUTION/EPOCHS",
          "SOLUTION/ESTIMATE", "SOLUTION/MATRIX_ESTIMATE L COVA"]


class SinexError(Exception):
    pass


def fail(number, problem):
    raise SinexError(f"line {number}: {problem}")


def split_blocks(lines):
    blocks, current = {}, None
    for number, line in enumerate(lines[1:-1], 2):
        if len(line) > 80 or any(not 0x20 <= ord(c) <= 0x7e for c in line):
            fail(number, "more than 80 characters, or not printable ASCII")
        if line.startswith("+"):
            if current is not None or line[1:] in blocks:
                fail(number, "a block inside another one, or twice")
            current = line[1:]
            blocks[current] = []
        elif line.startswith("-"):
            if line[1:] != current:
                fail(number, "closes a block that is not open")
            current = None
        elif line.startswith(" "):
            if current is None:
                fail(number, "data outside a block")
            blocks[current].append((number, line))
        elif not line.startswith("*"):
            fail(number, "the first character must be one of '%*+- '")
    if current is not None:
        fail(len(lines), f"{current} is not closed")
    return blocks


def matched(pattern, entry):
    match = pattern.match(entry[1])
    if not match:
        fail(entry[0], f"columns differ from the format: {entry[1]!r}")
    return match


def read_matrix(entries, size):
    matrix = [[None] * size for _ in range(size)]
    for entry in entries:
        match = matched(ELEMENTS, entry)
        row, column = int(match.group(1)), int(match.group(2))
        for offset, text in enumerate(match.group(3).split()):
            i, j = row - 1, column - 1 + offset
            if not 0 <= j <= i < size or matrix[i][j] is not None:
                fail(entry[0], f"element ({i + 1}, {j + 1}) is outside the lower triangle or twice")
            matrix[i][j] = matrix[j][i] = float(text)
    return [[0.0 if x is None else x for x in row] for row in matrix]


def require_positive_definite(matrix):
    size = len(matrix)
    scale = [1.0 / math.sqrt(matrix[i][i]) for i in range(size)]
    factor = [[0.0] * size for _ in range(size)]
    for i in range(size):
        for j in range(i + 1):
            left = matrix[i][j] * scale[i] * scale[j]
            left -= sum(a * b for a, b in zip(factor[i][:j], factor[j][:j]))
            if i == j:
                if not left > 0.0:
                    raise SinexError(f"the matrix is not positive definite at row {i + 1}")
                factor[i][i] = math.sqrt(left)
            else:
                factor[i][j] = left / factor[j][j]


def read_sinex(path):
    """Sites by code, estimates and standard deviations by (code, type), indices, matrix."""
    with open(path, encoding="ascii", newline="") as stream:
        text = stream.read()
    if not text.endswith("\n") or "\r" in text:
        raise SinexError("lines do not end in a line feed")
    lines = text[:-1].split("\n")
    header = HEADER.match(lines[0])
    if not header:
        fail(1, f"no SINEX 2.02 header: {lines[0]!r}")
    if lines[-1] != "%ENDSNX":
        fail(len(lines), "the last line is not %ENDSNX")
    blocks = split_blocks(lines)
    if list(blocks) != BLOCKS:
        raise SinexError(f"blocks are {list(blocks)}")
    sites = {}
    for entry in blocks["SITE/ID"]:
        match = matched(SITE, entry)
        if match.group(1) in sites:
            fail(entry[0], "a site twice")
        for minutes, seconds in ((7, 8), (10, 11)):
            if not (int(match.group(minutes)) < 60 and float(match.group(seconds)) < 60.0):
                fail(entry[0], "minutes or seconds of 60")
        sites[match.group(1)] = match
    if [matched(EPOCH, entry).group(1) for entry in blocks["SOLUTION/EPOCHS"]] != list(sites):
        raise SinexError("SOLUTION/EPOCHS has other sites than SITE/ID")
    index, values, sigmas = {}, [], []
    for entry in blocks["SOLUTION/ESTIMATE"]:
        match = matched(ESTIMATE, entry)
        if int(match.group(1)) != len(values) + 1 or match.group(3) not in sites:
            fail(entry[0], "index out of order or unknown site")
        index[match.group(3), match.group(2).strip()] = len(values)
        values.append(float(match.group(9)))
        sigmas.append(float(match.group(10)))
    if not len(values) == int(header.group(1)) == 3 * len(sites) == len(index):
        raise SinexError("header, sites and estimates disagree about their number")
    matrix = read_matrix(blocks["SOLUTION/MATRIX_ESTIMATE L COVA"], len(values))
    for i, sigma in enumerate(sigmas):
        if not matrix[i][i] > 0.0 or abs(math.sqrt(matrix[i][i]) / sigma - 1.0) > 6e-6:
            raise SinexError(f"standard deviation {i + 1} is not the root of the diagonal")
    require_positive_definite(matrix)
    return {"sites": sites, "index": index, "values": values, "matrix": matrix}


def main():
    try:
        read = read_sinex(sys.argv[1])
    except (SinexError, UnicodeDecodeError) as error:
        print(f"{sys.argv[1]}: {error}")
        return 1
    print(f"{len(read['sites'])} sites, {len(read['values'])} estimates, positive definite")
    return 0


if __name__ == "__main__":
    sys.exit(main())
