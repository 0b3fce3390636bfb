# SPDX-License-Identifier: Apache-2.0
"""What a result holds, by what it is about: points, corrections, looks, checks, strips, pairs."""
from __future__ import annotations

from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._tables import FlagArray, FloatArray, IndexArray, TextArray, kept
from .block import ROLES, point_of_look

_STATUS = np.array(
    ["adjusted", "intersected", "predicted", "not-seen", "too-few-looks", "circles-apart", "undetermined"]
)
_REASONS = np.array(["", "given", "no-value", "robust", "blunder", "suspect"])


class ResultPoints:
    """Points of a result, in the order of the block's."""

    def __init__(self, core: _core.Result) -> None:
        self._core = core

    def __len__(self) -> int:
        return len(self.position_m)

    @kept
    def ids(self) -> TextArray:
        """Names, (points,)."""
        ids: TextArray = self._core.array("points.ids")
        return ids

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

    @kept
    def reason(self) -> TextArray:
        """Why a point was not solved, else empty, (points,)."""
        reason: TextArray = self._core.array("points.reason")
        return reason

    @kept
    def looks(self) -> IndexArray:
        """Number of looks that count, (points,)."""
        looks: IndexArray = self._core.array("points.looks")
        return looks

    @kept
    def position_m(self) -> FloatArray:
        """Positions [m], (points, 3), frame axes; nan where not solved."""
        position: FloatArray = self._core.array("points.position_m")
        return position

    @kept
    def geodetic(self) -> FloatArray:
        """Latitude [rad], longitude [rad] and height [m], (points, 3); geocentric frames only."""
        return self._core.geodetic()

    @kept
    def covariance_enu_m2(self) -> FloatArray:
        """Covariances [m2], east, north, up, (points, 3, 3); nan where there is none."""
        return self._covariance("points.covariance_enu_m2")

    @kept
    def fixed_path_covariance_enu_m2(self) -> FloatArray:
        """The same, had the corrections been known exactly [m2], (points, 3, 3); nan without it."""
        return self._covariance("points.fixed_path_covariance_enu_m2")

    @kept
    def sigma_enu_m(self) -> FloatArray:
        """Standard deviations [m], east, north, up, (points, 3)."""
        return np.sqrt(np.diagonal(self.covariance_enu_m2, axis1=1, axis2=2))

    @kept
    def intersection_rad(self) -> FloatArray:
        """Largest intersection angle [rad], (points,); nan below two looks."""
        return self._numbers("points.intersection_rad")

    @kept
    def redundancy_1(self) -> FloatArray:
        """Redundancy of the point's looks, (points,); nan where it was not computed."""
        return self._numbers("points.redundancy_1")

    @kept
    def sigma_leberl_across_m(self) -> FloatArray:
        """Across-track standard deviation [m] by range noise after Leberl (1979), Eq. 25, for the
        best pair of looks, (points,); nan where the paper does not apply."""
        return self._numbers("points.sigma_leberl_across_m")

    @kept
    def sigma_leberl_up_m(self) -> FloatArray:
        """The same of the height [m], (points,)."""
        return self._numbers("points.sigma_leberl_up_m")

    @kept
    def sigma_leberl_path_across_m(self) -> FloatArray:
        """Across-track standard deviation [m] by the priors of corrections, Eq. 14, (points,)."""
        return self._numbers("points.sigma_leberl_path_across_m")

    @kept
    def sigma_leberl_path_up_m(self) -> FloatArray:
        """The same of the height [m], Eq. 15, (points,)."""
        return self._numbers("points.sigma_leberl_path_up_m")

    @kept
    def leberl_across_azimuth_rad(self) -> FloatArray:
        """Direction of across, clockwise from north [rad], (points,)."""
        return self._numbers("points.leberl_across_azimuth_rad")

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

    def _covariance(self, name: str) -> FloatArray:
        covariance: Optional[FloatArray] = self._core.array(name)
        return np.full((len(self), 3, 3), np.nan) if covariance is None else covariance

    def _numbers(self, name: str) -> FloatArray:
        numbers: Optional[FloatArray] = self._core.array(name)
        return np.full(len(self), np.nan) if numbers is None else numbers


class Corrections:
    """The estimated parameters of the flight paths and measurements."""

    def __init__(self, core: _core.Result) -> None:
        self._core = core

    def __len__(self) -> int:
        return len(self.value)

    @kept
    def owner(self) -> TextArray:
        """The pass, or the name of the group that shares the parameter, (parameters,)."""
        owner: TextArray = self._core.array("corrections.owner")
        return owner

    @kept
    def name(self) -> TextArray:
        """"position.along.0", "range.bias", ..., (parameters,)."""
        name: TextArray = self._core.array("corrections.name")
        return name

    @kept
    def unit(self) -> TextArray:
        """Unit of value and standard deviations: "m", "s", "rad" or "1", (parameters,)."""
        unit: TextArray = self._core.array("corrections.unit")
        return unit

    @kept
    def value(self) -> FloatArray:
        """Values, each in its `unit`, (parameters,)."""
        value: FloatArray = self._core.array("corrections.value")
        return value

    @kept
    def sigma(self) -> FloatArray:
        """Standard deviations, each in its `unit`, (parameters,); nan where not computed."""
        sigma: FloatArray = self._core.array("corrections.sigma")
        return sigma

    @kept
    def prior_sigma(self) -> FloatArray:
        """Standard deviations before the adjustment, each in its `unit`, (parameters,); nan: no
        prior."""
        prior: FloatArray = self._core.array("corrections.prior_sigma")
        return prior

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


class ResultLooks:
    """Residuals and tests of the looks, in the order of the block's looks."""

    def __init__(self, core: _core.Result) -> None:
        self._core = core

    def __len__(self) -> int:
        return len(self.pass_index)

    @kept
    def pass_index(self) -> IndexArray:
        """Index of the pass, (looks,)."""
        index: IndexArray = self._core.array("looks.pass_index")
        return index

    @kept
    def point_index(self) -> IndexArray:
        """Index of the point, (looks,)."""
        index: Optional[IndexArray] = self._core.array("looks.point_index")
        return point_of_look(self._core.array("looks.offsets")) if index is None else index

    @kept
    def range_residual_m(self) -> FloatArray:
        """Computed minus measured range [m], (looks,); nan where the look took no part."""
        return self._numbers("looks.range_residual_m")

    @kept
    def azimuth_residual_m(self) -> FloatArray:
        """Residual along track at the target [m], (looks,)."""
        return self._numbers("looks.azimuth_residual_m")

    @kept
    def reduction_range_m(self) -> FloatArray:
        """What was taken off the measured range [m], (looks,); nan where nothing was in the block."""
        return self._numbers("looks.reduction_range_m")

    @kept
    def reduction_time_s(self) -> FloatArray:
        """What was taken off the measured time [s], (looks,); nan where nothing was in the block."""
        return self._numbers("looks.reduction_time_s")

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

    @kept
    def range_redundancy_1(self) -> NDArray[np.floating[Any]]:
        """Part of an error of the range that its residual shows, 0 to 1, (looks,)."""
        return self._quality("looks.range_redundancy_1")

    @kept
    def azimuth_redundancy_1(self) -> NDArray[np.floating[Any]]:
        """The same of azimuth, (looks,)."""
        return self._quality("looks.azimuth_redundancy_1")

    @kept
    def range_w_1(self) -> NDArray[np.floating[Any]]:
        """Standardised residual of the range, (looks,)."""
        return self._quality("looks.range_w_1")

    @kept
    def azimuth_w_1(self) -> NDArray[np.floating[Any]]:
        """The same of azimuth, (looks,)."""
        return self._quality("looks.azimuth_w_1")

    def _numbers(self, name: str) -> FloatArray:
        numbers: Optional[FloatArray] = self._core.array(name)
        return np.full(len(self), np.nan) if numbers is None else numbers

    def _quality(self, name: str) -> NDArray[np.floating[Any]]:
        numbers: Optional[NDArray[np.floating[Any]]] = self._core.array(name)
        return np.full(len(self), np.nan) if numbers is None else numbers


class Checks:
    """Errors of the check points against their known positions."""

    def __init__(self, core: _core.Result) -> None:
        self._core = core

    def __len__(self) -> int:
        return len(self.point_index)

    @kept
    def point_index(self) -> IndexArray:
        """Index of the point, (checks,)."""
        index: IndexArray = self._core.array("checks.point_index")
        return index

    @kept
    def error_enu_m(self) -> FloatArray:
        """Adjusted minus known [m], east, north, up, (checks, 3); nan where not known."""
        error: FloatArray = self._core.array("checks.error_enu_m")
        return error

    @kept
    def sigma_enu_m(self) -> FloatArray:
        """Predicted standard deviation of the error [m], (checks, 3)."""
        sigma: FloatArray = self._core.array("checks.sigma_enu_m")
        return sigma

    @kept
    def chi_square_1(self) -> FloatArray:
        """Weighted square of the error, (checks,)."""
        chi_square: FloatArray = self._core.array("checks.chi_square_1")
        return chi_square


class Strips:
    """Flight paths at some places of their strips, by pass and time."""

    def __init__(self, core: _core.Result) -> None:
        self._core = core

    def __len__(self) -> int:
        return len(self.time_s)

    @kept
    def pass_index(self) -> IndexArray:
        """Index of the pass, (stations,)."""
        index: IndexArray = self._core.array("strips.pass_index")
        return index

    @kept
    def time_s(self) -> FloatArray:
        """Time [s], (stations,)."""
        time: FloatArray = self._core.array("strips.time_s")
        return time

    @kept
    def strip_time_1(self) -> FloatArray:
        """Strip time, -1 at the start to 1 at the end, (stations,)."""
        time: FloatArray = self._core.array("strips.strip_time_1")
        return time

    @kept
    def antenna_m(self) -> FloatArray:
        """Antenna on the nominal path [m], (stations, 3), frame axes."""
        antenna: FloatArray = self._core.array("strips.antenna_m")
        return antenna

    @kept
    def correction_m(self) -> FloatArray:
        """Correction of the position [m], along, across, up, (stations, 3); nan: none."""
        correction: FloatArray = self._core.array("strips.correction_m")
        return correction

    @kept
    def correction_sigma_m(self) -> FloatArray:
        """Its standard deviations [m], (stations, 3); nan where not computed."""
        sigma: FloatArray = self._core.array("strips.correction_sigma_m")
        return sigma


class Pairs:
    """Differences of two points, second minus first, where `pairs` asked for them."""

    def __init__(self, core: _core.Result) -> None:
        self._core = core

    def __len__(self) -> int:
        return len(self.first_index)

    @kept
    def first_index(self) -> IndexArray:
        """Index of the first point, (pairs,)."""
        index: IndexArray = self._core.array("pairs.first_index")
        return index

    @kept
    def second_index(self) -> IndexArray:
        """Index of the second point, (pairs,)."""
        index: IndexArray = self._core.array("pairs.second_index")
        return index

    @kept
    def difference_enu_m(self) -> FloatArray:
        """Difference [m], east, north, up at the first point, (pairs, 3)."""
        difference: FloatArray = self._core.array("pairs.difference_enu_m")
        return difference

    @kept
    def covariance_enu_m2(self) -> FloatArray:
        """Its covariance [m2], (pairs, 3, 3)."""
        covariance: FloatArray = self._core.array("pairs.covariance_enu_m2")
        return covariance
