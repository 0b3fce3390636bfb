#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Digits of the covariance against the condition, by method, as SVG.

Usage: plot_stability.py stability.csv > stability_methods.svg
"""
import csv
import math
import sys

WIDTH, HEIGHT, LEFT, TOP, RIGHT, BOTTOM = 760, 480, 60, 40, 230, 50
DECADES, DIGITS = 9, 16
METHODS = [("covariance_digits", "production: QR, reduced", "#4477aa", "circle"),
           ("normal_digits", "all normals, double", "#ee6677", "square"),
           ("ceres_digits", "Ceres, sparse QR", "#228833", "triangle"),
           ("single_digits", "all normals, single", "#ccbb44", "cross")]
LAWS = [(16.0, 1, "16 - log k"), (16.0, 2, "16 - 2 log k"), (7.2, 2, "7 - 2 log k")]


def at(condition, digits):
    x = LEFT + (WIDTH - LEFT - RIGHT) * min(max(math.log10(condition), 0.0), DECADES) / DECADES
    y = HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * digits / DIGITS
    return x, y


def marker(kind, x, y, colour):
    if kind == "circle":
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2.5" fill="none" stroke="{colour}"/>'
    path = {"square": "m-2.5 -2.5h5v5h-5z", "triangle": "m0 -3l3 5h-6z",
            "cross": "m-2.5 -2.5l5 5m0 -5l-5 5"}[kind]
    return f'<path d="M{x:.1f} {y:.1f}{path}" fill="none" stroke="{colour}"/>'


def main():
    with open(sys.argv[1], newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["condition"]]
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
           'font-family="sans-serif" font-size="12">',
           f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/>',
           f'<text x="{LEFT}" y="22" font-size="15">Digits of the covariance by method</text>']
    for decade in range(DECADES + 1):
        x, y = at(10.0 ** decade, 0)
        out.append(f'<path d="M{x:.1f} {y:.1f}V{TOP}" stroke="#ddd"/>'
                   f'<text x="{x:.1f}" y="{y + 16:.1f}" text-anchor="middle">1e{decade}</text>')
    for digits in range(0, DIGITS + 1, 2):
        x, y = at(1.0, digits)
        out.append(f'<path d="M{x:.1f} {y:.1f}H{WIDTH - RIGHT}" stroke="#ddd"/>'
                   f'<text x="{x - 6:.1f}" y="{y + 4:.1f}" text-anchor="end">{digits}</text>')
    out.append(f'<text x="{LEFT}" y="{HEIGHT - 12}">condition k of the column-scaled Jacobian; '
               'upwards: correct digits of the worst 3 x 3 block</text>')
    for digits, power, name in LAWS:
        (x0, y0), (x1, y1) = at(1.0, digits), at(10.0 ** min(DECADES, digits / power),
                                                 max(0.0, digits - power * DECADES))
        out.append(f'<path d="M{x0:.1f} {y0:.1f}L{x1:.1f} {y1:.1f}" stroke="#000" '
                   f'stroke-dasharray="{4 * power} {power}"/>')
    for k, (column, name, colour, kind) in enumerate(METHODS):
        for row in rows:
            if row[column]:
                out.append(marker(kind, *at(float(row["condition"]), float(row[column])), colour))
        y = TOP + 20 + 20 * k
        out.append(marker(kind, WIDTH - RIGHT + 20, y - 4, colour) +
                   f'<text x="{WIDTH - RIGHT + 32}" y="{y}">{name}</text>')
    for k, (_, power, name) in enumerate(LAWS):
        y = TOP + 110 + 20 * k
        out.append(f'<path d="M{WIDTH - RIGHT + 8} {y - 4}h20" stroke="#000" '
                   f'stroke-dasharray="{4 * power} {power}"/>'
                   f'<text x="{WIDTH - RIGHT + 32}" y="{y}">{name}</text>')
    print("\n".join(out + ["</svg>"]))


if __name__ == "__main__":
    main()
