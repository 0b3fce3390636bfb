# SPDX-License-Identifier: Apache-2.0
"""Pictures of a result by matplotlib."""
from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any, Optional

import numpy as np

if TYPE_CHECKING:
    from .result import Result

_MARKS = {"tie": ("o", "0.6", 6.0), "control": ("^", "tab:red", 42.0), "check": ("s", "tab:blue", 22.0)}


def _pyplot() -> Any:
    return importlib.import_module("matplotlib.pyplot")


def draw_map(result: Result, ax: Any, magnify: Optional[float]) -> Any:
    """Points in the plane: x and y of a local frame, else east and north of their middle, in km."""
    collections = importlib.import_module("matplotlib.collections")
    points = result.points
    solved = points.solved
    if result._core.local_frame:
        place = points.position_m[solved, :2].copy()
        names = ("x [km]", "y [km]")
    else:
        latitude, longitude = points.geodetic[solved, 0], points.geodetic[solved, 1]
        radius = float(np.median(np.linalg.norm(points.position_m[solved], axis=1)))
        middle = float(np.median(latitude))
        turned = np.angle(np.exp(1j * (longitude - np.median(longitude))))
        place = np.column_stack([radius * np.cos(middle) * turned, radius * (latitude - middle)])
        names = ("east of the middle [km]", "north of the middle [km]")
    if ax is None:
        ax = _pyplot().subplots(figsize=(8.0, 5.5), layout="constrained")[1]
    large, small, azimuth = (values[solved] for values in points.ellipses())
    roles = points.role[solved]
    drawn = np.isfinite(large)
    if drawn.any():
        if magnify is None:
            extent = float(np.ptp(place, axis=0).max()) or 1.0
            wanted = 0.025 * extent / float(np.median(large[drawn]))
            magnify = _round(wanted)
        ellipses = collections.EllipseCollection(
            2e-3 * magnify * large[drawn],
            2e-3 * magnify * small[drawn],
            90.0 - np.degrees(azimuth[drawn]),
            units="xy",
            offsets=1e-3 * place[drawn],
            transOffset=ax.transData,
            facecolors="none",
            edgecolors="0.3",
            linewidths=0.6,
        )
        ax.add_collection(ellipses)
    for role, (marker, colour, size) in _MARKS.items():
        chosen = roles == role
        if chosen.any():
            ax.scatter(*(1e-3 * place[chosen].T), s=size, marker=marker, c=colour, label=role, zorder=3)
    ax.set_aspect("equal")
    ax.set_xlabel(names[0])
    ax.set_ylabel(names[1])
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    if drawn.any():
        ax.set_title(f"Error ellipses (one sigma), {magnify:g} times as large")
    return ax


def _round(value: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not above the value."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(power * max(step for step in (1.0, 2.0, 5.0) if step * power <= value * (1 + 1e-9)))


def draw_strips(result: Result, ax: Any) -> Any:
    """Corrections along, across and up against strip time, one line per pass."""
    strips = result.strips
    room = {"left": 0.1, "right": 0.86, "bottom": 0.08, "top": 0.94, "hspace": 0.1}
    if ax is None:
        ax = _pyplot().subplots(3, 1, figsize=(8.0, 7.0), sharex=True, gridspec_kw=room)[1]
    axes = np.atleast_1d(ax)
    if len(axes) != 3:
        raise ValueError("ax: three axes are needed, for along, across and up")
    for component, (name, one) in enumerate(zip(("along", "across", "up"), axes)):
        for index, pass_id in enumerate(result.pass_ids):
            of_pass = strips.pass_index == index
            value = strips.correction_m[of_pass, component]
            if not np.isfinite(value).any():
                continue
            sigma = strips.correction_sigma_m[of_pass, component]
            time = strips.strip_time_1[of_pass]
            (line,) = one.plot(time, value, linewidth=1.2, label=str(pass_id))
            one.fill_between(
                time, value - sigma, value + sigma, color=line.get_color(), alpha=0.15, linewidth=0
            )
        one.set_ylabel(f"{name} [m]")
        one.axhline(0.0, color="0.7", linewidth=0.6, zorder=0)
    axes[0].set_title("Corrections of the flight paths with one sigma")
    axes[2].set_xlabel("strip time, -1 start to 1 end")
    if len(axes[0].get_lines()) > 1:
        axes[0].legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize="small", frameon=False)
    return axes
