# SPDX-License-Identifier: Apache-2.0
"""Results: positions, corrections of the flight paths, residuals, and the covariance of all."""
from __future__ import annotations

import copy
import json
from typing import Any, Mapping, Optional

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, _plot
from ._options import overrides
from ._progress import Progress, reporting
from ._result_parts import Checks, Corrections, Pairs, ResultLooks, ResultPoints, Strips
from ._tables import FloatArray, TextArray, choose, data_frame, data_set, kept
from .block import ROLES, Block, Path


class Result:
    """What `adjust`, `intersect`, `predict` and `read_result` return; never changed. Covariances
    are scaled by the posterior variance factor where `scale_by_posterior` asked for it."""

    def __init__(self, core: _core.Result) -> None:
        self._core = core

    @kept
    def _summary(self) -> dict[str, Any]:
        summary: dict[str, Any] = json.loads(self._core.summary())
        return summary

    @property
    def summary(self) -> dict[str, Any]:
        """The content of summary.json (docs/formats.md), a copy of one's own."""
        return copy.deepcopy(self._summary)

    @property
    def verdict(self) -> str:
        """"accepted", "converged, tests failed" or "not accepted"."""
        return str(self._summary["verdict"])

    @property
    def accepted(self) -> bool:
        """Converged and determined: positions and standard deviations may be used."""
        return self.verdict != "not accepted"

    @property
    def reasons(self) -> list[str]:
        """Why the verdict is not "accepted", the gravest first."""
        return [str(reason) for reason in self._summary.get("verdict_reasons", [])]

    @property
    def warnings(self) -> list[str]:
        """Warnings of reading the block and of solving it."""
        return [str(warning) for warning in self._summary.get("warnings", [])]

    @property
    def sigma0_squared(self) -> float:
        """Variance factor v'Pv / redundancy; nan where there is none."""
        value = self._summary.get("sigma0_squared")
        return float("nan") if value is None else float(value)

    @property
    def pass_ids(self) -> TextArray:
        """Names of the passes, (passes,)."""
        return np.array(self._core.pass_ids)

    @kept
    def points(self) -> ResultPoints:
        """The points."""
        return ResultPoints(self._core)

    @kept
    def corrections(self) -> Corrections:
        """The estimated corrections."""
        return Corrections(self._core)

    @kept
    def looks(self) -> ResultLooks:
        """Residuals and tests of the looks."""
        return ResultLooks(self._core)

    @kept
    def checks(self) -> Checks:
        """Errors of the check points."""
        return Checks(self._core)

    @kept
    def strips(self) -> Strips:
        """Corrections along the strips."""
        return Strips(self._core)

    @kept
    def pairs(self) -> Pairs:
        """Differences of points."""
        return Pairs(self._core)

    def states(self, index: int) -> FloatArray:
        """Corrected state vectors of a pass, (states, 7): time [s], position [m], velocity [m/s]."""
        return self._core.states(index)

    def write(
        self, path: Path, *, gzip: bool = False, force: bool = False, progress: Progress = None
    ) -> None:
        """Writes a result folder, or an HDF5 file where the name ends in ".h5": the bytes that the
        command line writes. `gzip` compresses the tables; `force` writes into a folder that holds
        other files. Of a result that was read the tables are copied from where it was read; it must
        are still there, unchanged."""
        with reporting(progress) as callback:
            self._core.write(path, gzip, force, callback)

    def _tables(self) -> dict[str, dict[str, Optional[NDArray[Any]]]]:
        points, looks, checks, strips = self.points, self.looks, self.checks, self.strips
        corrections, pairs, passes = self.corrections, self.pairs, self.pass_ids
        return {
            "points": {
                "point": points.ids,
                "role": points.role,
                "status": points.status,
                "looks": points.looks,
                "position_m": points.position_m,
                "sigma_enu_m": points.sigma_enu_m,
                "covariance_enu_m2": points.covariance_enu_m2,
                "intersection_rad": points.intersection_rad,
                "redundancy_1": points.redundancy_1,
            },
            "corrections": {
                "owner": corrections.owner,
                "parameter": corrections.name,
                "unit": corrections.unit,
                "value": corrections.value,
                "sigma": corrections.sigma,
                "prior_sigma": corrections.prior_sigma,
            },
            "looks": {
                "pass": passes[looks.pass_index],
                "point": points.ids[looks.point_index],
                "range_residual_m": looks.range_residual_m,
                "azimuth_residual_m": looks.azimuth_residual_m,
                "range_w_1": looks.range_w_1,
                "azimuth_w_1": looks.azimuth_w_1,
                "rejected": looks.rejected,
                "reason": looks.reason,
            },
            "checks": {
                "point": points.ids[checks.point_index],
                "error_enu_m": checks.error_enu_m,
                "sigma_enu_m": checks.sigma_enu_m,
                "chi_square_1": checks.chi_square_1,
            },
            "strips": {
                "pass": passes[strips.pass_index],
                "time_s": strips.time_s,
                "strip_time_1": strips.strip_time_1,
                "correction_m": strips.correction_m,
                "correction_sigma_m": strips.correction_sigma_m,
            },
            "pairs": {
                "first": points.ids[pairs.first_index],
                "second": points.ids[pairs.second_index],
                "difference_enu_m": pairs.difference_enu_m,
                "covariance_enu_m2": pairs.covariance_enu_m2,
            },
        }

    def to_dataframe(self, table: str = "points") -> Any:
        """A pandas.DataFrame of "points", "corrections", "looks", "checks", "strips" or "pairs".
        Vectors and matrices are taken apart: x_m, sigma_e_m, cov_en_m2."""
        return data_frame(choose(self._tables(), table))

    def to_xarray(self) -> Any:
        """An xarray.Dataset of all tables, with units."""
        return data_set(self._tables(), str(self._summary["block"]))

    def plot(self, kind: str = "map", *, ax: Any = None, magnify: Optional[float] = None) -> Any:
        """Draws with matplotlib and returns the axes. "map": the points by role with their error
        ellipses (one sigma), `magnify` times as large; "strips": the corrections of every pass along
        its strip with one sigma to both sides."""
        if kind == "map":
            return _plot.draw_map(self, ax, magnify)
        if kind == "strips":
            return _plot.draw_strips(self, ax)
        raise _core.InputError(f"kind: '{kind}' is not known, map or strips is allowed")

    def __repr__(self) -> str:
        return (
            f"<sarblock.Result of {self._summary['block']}: {self.verdict}, "
            f"{int(self.points.solved.sum())} of {len(self.points)} points, "
            f"{len(self.corrections)} corrections>"
        )


def _solve(
    task: str,
    block: Block,
    options: Mapping[str, object],
    threads: int,
    progress: Progress,
    positions_m: Optional[ArrayLike] = None,
) -> Result:
    positions = None if positions_m is None else np.asarray(positions_m, dtype=np.float64)
    with reporting(progress) as callback:
        core = _core.solve(task, block._core, overrides(options), threads, positions, callback)
    return Result(core)


def adjust(block: Block, *, threads: int = 0, progress: Progress = None, **options: object) -> Result:
    """Adjusts a block: positions, corrections of the flight paths, exact covariances.

    Options are the keys of [adjust] (docs/adjust_options.md) over those that the block has:
    `adjust(block, robust="huber", quality={"snooping": "iterative"})`. `threads` 0 takes all cores.
    `progress` is a callable (stage, done, total, detail), or True for a bar of tqdm. Other Python
    threads run meanwhile; Ctrl-C raises Interrupted.
    Raises InputError, and UndeterminedError for what the looks do not determine.
    """
    return _solve("adjust", block, options, threads, progress)


def intersect(
    block: Block, *, threads: int = 0, progress: Progress = None, **options: object
) -> Result:
    """Intersects every point alone, flight paths fixed, with its covariance. Arguments as `adjust`."""
    return _solve("intersect", block, options, threads, progress)


def predict(
    block: Block,
    positions_m: Optional[ArrayLike] = None,
    *,
    threads: int = 0,
    progress: Progress = None,
    **options: object,
) -> Result:
    """The covariance that an adjustment of the block would have, from geometry and weights alone.

    `positions_m` are the points' positions [m], (points, 3), frame axes, nan where not known;
    without them the truth of the block, where it has one. Other arguments as `adjust`.
    """
    return _solve("predict", block, options, threads, progress, positions_m)


def check(
    block: Block, *, threads: int = 0, progress: Progress = None, **options: object
) -> dict[str, Any]:
    """What an adjustment would say of a block before it forms an equation: counts of `passes`,
    `points`, `tie`, `control`, `check`, `looks` and `corrections`, and the list `warnings`."""
    with reporting(progress) as callback:
        said = block._core.check(overrides(options), threads, callback)
    roles = block.points.role
    counts = {str(role): int((roles == role).sum()) for role in ROLES}
    return {
        "block": block.name,
        "passes": len(block.passes),
        "points": len(block.points),
        **counts,
        "looks": len(block.looks),
        **said,
    }


def read_result(path: Path, *, progress: Progress = None) -> Result:
    """Reads a result folder or an HDF5 file. Raises InputError."""
    with reporting(progress) as callback:
        return Result(_core.read_result(path, callback))
