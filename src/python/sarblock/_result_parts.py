# SPDX-License-Identifier: Apache-2.0
"""What a result holds, by what it is about: points, corrections, looks, checks, strips, pairs."""
from __future__ import annotations

from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._tables import FlagArray, FloatArray, IndexArray, Part, TextArray, column, kept
from .block import ROLES, point_of_look

_STATUS = np.array(
    ["adjusted", "intersected", "predicted", "not-seen", "too-few-looks", "circles-apart", "undetermined"]
)
_REASONS = np.array(["", "given", "no-value", "robust", "blunder", "suspect"])


class ResultPoints(Part[_core.Result]):
    """Points of a result, in the order of the block's."""

    _group = "points"

    def __len__(self) -> int:
        return len(self.position_m)

    ids = column[TextArray]("Names, (points,).")

    @kept
    def role(self) -> TextArray:
        """"tie", "control" or "check", (points,)."""
        role: TextArray = ROLES[self._core.array("points.role")]
        return role

    @kept
    def status(self) -> TextArray:
        """What became of each: "adjusted", "intersected", "predicted", or why it was left out:
        "not-seen", "too-few-looks", "circles-apart", "undetermined", (points,)."""
        status: TextArray = _STATUS[self._core.array("points.status")]
        return status

    @kept
    def solved(self) -> FlagArray:
        """True where position and covariance may be used, (points,)."""
        solved: FlagArray = self._core.array("points.status") <= 2
        return solved

    reason = column[TextArray]("Why a point was not solved, else empty, (points,).")
    looks = column[IndexArray]("Number of looks that count, (points,).")
    position_m = column[FloatArray]("Positions [m], (points, 3), frame axes; nan where not solved.")

    @kept
    def geodetic(self) -> FloatArray:
        """Latitude [rad], longitude [rad] and height [m], (points, 3); geocentric frames only."""
        return self._core.geodetic()

    covariance_enu_m2 = column[FloatArray](
        "Covariances [m2], east, north, up, (points, 3, 3); nan where there is none.", shape=(3, 3)
    )
    fixed_path_covariance_enu_m2 = column[FloatArray](
        "The same, had the corrections been known exactly [m2], (points, 3, 3); nan without it.", shape=(3, 3)
    )

    @kept
    def sigma_enu_m(self) -> FloatArray:
        """Standard deviations [m], east, north, up, (points, 3)."""
        return np.sqrt(np.diagonal(self.covariance_enu_m2, axis1=1, axis2=2))

    intersection_rad = column[FloatArray]("Largest intersection angle [rad], (points,); nan below two looks.")
    redundancy_1 = column[FloatArray](
        "Redundancy of the point's looks, (points,); nan where it was not computed."
    )
    sigma_leberl_across_m = column[FloatArray](
        """Across-track standard deviation [m] by range noise after Leberl (1979), Eq. 25, for the
        best pair of looks, (points,); nan where the paper does not apply."""
    )
    sigma_leberl_up_m = column[FloatArray]("The same of the height [m], (points,).")
    sigma_leberl_path_across_m = column[FloatArray](
        "Across-track standard deviation [m] by the priors of corrections, Eq. 14, (points,)."
    )
    sigma_leberl_path_up_m = column[FloatArray]("The same of the height [m], Eq. 15, (points,).")
    leberl_across_azimuth_rad = column[FloatArray](
        "Direction of across, clockwise from north [rad], (points,)."
    )

    def ellipses(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Horizontal error ellipses at one sigma: semi-axes [m], large and small, and the azimuth
        of the large one, clockwise from north [rad], each (points,)."""
        horizontal = self.covariance_enu_m2[:, :2, :2]
        half = 0.5 * (horizontal[:, 0, 0] + horizontal[:, 1, 1])
        difference = 0.5 * (horizontal[:, 1, 1] - horizontal[:, 0, 0])
        root = np.hypot(difference, horizontal[:, 0, 1])
        azimuth = 0.5 * np.arctan2(horizontal[:, 0, 1], difference)
        return np.sqrt(half + root), np.sqrt(np.maximum(half - root, 0.0)), azimuth

    def index(self, name: str) -> int:
        """Index of the point of this name."""
        return self._index[name]

    @kept
    def _index(self) -> dict[str, int]:
        return {str(name): index for index, name in enumerate(self.ids)}


class Corrections(Part[_core.Result]):
    """The estimated parameters of the flight paths and measurements."""

    _group = "corrections"

    def __len__(self) -> int:
        return len(self.value)

    owner = column[TextArray]("The pass, or the name of the group that shares the parameter, (parameters,).")
    name = column[TextArray]('''"position.along.0", "range.bias", ..., (parameters,).''')
    unit = column[TextArray](
        """Unit of value and standard deviations: "m", "s", "rad" or "1", (parameters,)."""
    )
    value = column[FloatArray]("Values, each in its `unit`, (parameters,).")
    sigma = column[FloatArray](
        "Standard deviations, each in its `unit`, (parameters,); nan where not computed."
    )
    prior_sigma = column[FloatArray](
        """Standard deviations before the adjustment, each in its `unit`, (parameters,); nan: no
        prior."""
    )

    @kept
    def covariance(self) -> FloatArray:
        """Covariances, units the products of two `unit`, (parameters, parameters); nan for pairs
        whose covariance the result does not hold, such as those of different passes."""
        rows = self._core.array("corrections.covariance_row")
        columns = self._core.array("corrections.covariance_column")
        values = self._core.array("corrections.covariance_value")
        matrix = np.full((len(self), len(self)), np.nan)
        np.fill_diagonal(matrix, self.sigma**2)
        matrix[rows, columns] = values
        matrix[columns, rows] = values
        return matrix


class ResultLooks(Part[_core.Result]):
    """Residuals and tests of the looks, in the order of the block's looks."""

    _group = "looks"

    def __len__(self) -> int:
        return len(self.pass_index)

    pass_index = column[IndexArray]("Index of the pass, (looks,).")

    @kept
    def point_index(self) -> IndexArray:
        """Index of the point, (looks,)."""
        index: Optional[IndexArray] = self._core.array("looks.point_index")
        return point_of_look(self._core.array("looks.offsets")) if index is None else index

    range_residual_m = column[FloatArray](
        "Computed minus measured range [m], (looks,); nan where the look took no part."
    )
    azimuth_residual_m = column[FloatArray]("Residual along track at the target [m], (looks,).")
    reduction_range_m = column[FloatArray](
        "What was taken off the measured range [m], (looks,); nan where nothing was in the block."
    )
    reduction_time_s = column[FloatArray](
        "What was taken off the measured time [s], (looks,); nan where nothing was in the block."
    )

    @kept
    def weight_1(self) -> NDArray[np.floating[Any]]:
        """Weight of a robust loss, 1 without one, (looks,)."""
        weight: Optional[NDArray[np.floating[Any]]] = self._core.array("looks.weight")
        return np.ones(len(self)) if weight is None else weight

    @kept
    def rejected(self) -> FlagArray:
        """True for looks that were left out, (looks,)."""
        rejected = self._core.array("looks.rejected")
        if rejected is None:
            flags = self._core.array("looks.flags")
            rejected = np.zeros(len(self), np.uint8) if flags is None else flags & 1
        left_out: FlagArray = rejected != 0
        return left_out

    @kept
    def reason(self) -> TextArray:
        """Why: "given", "no-value", "robust", "blunder", "suspect", or empty, (looks,)."""
        codes = self._core.array("looks.reason")
        reason: TextArray = np.full(len(self), "") if codes is None else _REASONS[codes]
        return reason

    range_redundancy_1 = column[NDArray[np.floating[Any]]](
        "Part of an error of the range that its residual shows, 0 to 1, (looks,)."
    )
    azimuth_redundancy_1 = column[NDArray[np.floating[Any]]]("The same of azimuth, (looks,).")
    range_w_1 = column[NDArray[np.floating[Any]]]("Standardised residual of the range, (looks,).")
    azimuth_w_1 = column[NDArray[np.floating[Any]]]("The same of azimuth, (looks,).")


class Checks(Part[_core.Result]):
    """Errors of the check points against their known positions."""

    _group = "checks"

    def __len__(self) -> int:
        return len(self.point_index)

    point_index = column[IndexArray]("Index of the point, (checks,).")
    error_enu_m = column[FloatArray](
        "Adjusted minus known [m], east, north, up, (checks, 3); nan where not known."
    )
    sigma_enu_m = column[FloatArray]("Predicted standard deviation of the error [m], (checks, 3).")
    chi_square_1 = column[FloatArray]("Weighted square of the error, (checks,).")


class Strips(Part[_core.Result]):
    """Flight paths at some places of their strips, by pass and time."""

    _group = "strips"

    def __len__(self) -> int:
        return len(self.time_s)

    pass_index = column[IndexArray]("Index of the pass, (stations,).")
    time_s = column[FloatArray]("Time [s], (stations,).")
    strip_time_1 = column[FloatArray]("Strip time, -1 at the start to 1 at the end, (stations,).")
    antenna_m = column[FloatArray]("Antenna on the nominal path [m], (stations, 3), frame axes.")
    correction_m = column[FloatArray](
        "Correction of the position [m], along, across, up, (stations, 3); nan: none."
    )
    correction_sigma_m = column[FloatArray](
        "Its standard deviations [m], (stations, 3); nan where not computed."
    )


class Pairs(Part[_core.Result]):
    """Differences of two points, second minus first, where `pairs` asked for them."""

    _group = "pairs"

    def __len__(self) -> int:
        return len(self.first_index)

    first_index = column[IndexArray]("Index of the first point, (pairs,).")
    second_index = column[IndexArray]("Index of the second point, (pairs,).")
    difference_enu_m = column[FloatArray]("Difference [m], east, north, up at the first point, (pairs, 3).")
    covariance_enu_m2 = column[FloatArray]("Its covariance [m2], (pairs, 3, 3).")
