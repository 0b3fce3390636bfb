# SPDX-License-Identifier: Apache-2.0
"""The closed forms of Leberl (1979), "Accuracy Analysis of Stereo Side-Looking Radar", on arrays.

Stations ' and '' are at (x, 0, H) and (x, B, H), the point at (x, y, 0): `base_m` is B, `height_m`
H, `ground_range_m` y. Every number may be an array; they are broadcast against each other, and what
is returned has their common shape. `arrangement` is "same-side" or "opposite-side", `presentation`
"ground" or "slant", `signs` "derived", or "printed" for those of the paper where they differ
(docs/theory/leberl.md). A configuration that cannot be raises InputError.
"""
from __future__ import annotations

from typing import Any, Mapping, NamedTuple, Optional

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from ._tables import FloatArray


class PointErrors(NamedTuple):
    """Error of a point along, across and up [m]."""

    dx_m: FloatArray
    dy_m: FloatArray
    dz_m: FloatArray


class Difference(NamedTuple):
    """Error of a coordinate difference across and up [m]."""

    dy_m: FloatArray
    dz_m: FloatArray


class Warp(NamedTuple):
    """d(Dy) = a Dy + f Dz, d(Dz) = c Dy + d Dz; dimensionless."""

    a_1: FloatArray
    f_1: FloatArray
    c_1: FloatArray
    d_1: FloatArray


class RangeNoise(NamedTuple):
    """Standard deviations across and up [m]."""

    sigma_y_m: FloatArray
    sigma_z_m: FloatArray


_STATION = ("dx0_m", "dy0_m", "dz0_m", "dr_m", "dydot0_1", "dzdot0_1")


def _word(name: str, value: str, allowed: tuple[str, str]) -> bool:
    """Whether the second word was given."""
    if value not in allowed:
        raise _core.InputError(f"{name}: '{value}' is not known, {allowed[0]} or {allowed[1]} is allowed")
    return value == allowed[1]


def _evaluate(
    name: str,
    *numbers: ArrayLike,
    arrangement: str = "same-side",
    presentation: str = "ground",
    signs: str = "derived",
) -> tuple[FloatArray, ...]:
    arrays = np.broadcast_arrays(*(np.asarray(number, dtype=np.float64) for number in numbers))
    inputs = np.column_stack([array.ravel() for array in arrays])
    outputs = _core.leberl(
        name,
        inputs,
        _word("arrangement", arrangement, ("same-side", "opposite-side")),
        _word("presentation", presentation, ("ground", "slant")),
        _word("signs", signs, ("derived", "printed")),
    )
    return tuple(output.reshape(arrays[0].shape) for output in outputs)


def first_look_angle(
    base_m: ArrayLike, height_m: ArrayLike, ground_range_m: ArrayLike, *, arrangement: str = "same-side"
) -> FloatArray:
    """Signed look angle of station ' off nadir [rad]: tan = y/H."""
    return _evaluate("first_look_angle", base_m, height_m, ground_range_m, arrangement=arrangement)[0]


def second_look_angle(
    base_m: ArrayLike, height_m: ArrayLike, ground_range_m: ArrayLike, *, arrangement: str = "same-side"
) -> FloatArray:
    """Signed look angle of station '' off nadir [rad]: tan = (y - B)/H."""
    return _evaluate("second_look_angle", base_m, height_m, ground_range_m, arrangement=arrangement)[0]


def intersection_angle(
    base_m: ArrayLike, height_m: ArrayLike, ground_range_m: ArrayLike, *, arrangement: str = "same-side"
) -> FloatArray:
    """Intersection angle [rad], between 0 and pi."""
    return _evaluate("intersection_angle", base_m, height_m, ground_range_m, arrangement=arrangement)[0]


def first_slant_range(
    base_m: ArrayLike, height_m: ArrayLike, ground_range_m: ArrayLike, *, arrangement: str = "same-side"
) -> FloatArray:
    """Slant range from station ' [m]."""
    return _evaluate("first_slant_range", base_m, height_m, ground_range_m, arrangement=arrangement)[0]


def second_slant_range(
    base_m: ArrayLike, height_m: ArrayLike, ground_range_m: ArrayLike, *, arrangement: str = "same-side"
) -> FloatArray:
    """Slant range from station '' [m]."""
    return _evaluate("second_slant_range", base_m, height_m, ground_range_m, arrangement=arrangement)[0]


def height_displacement(
    look_rad: ArrayLike, point_height_m: ArrayLike, *, presentation: str = "ground"
) -> FloatArray:
    """Displacement of a point of this height in one image [m], Eq. 6 and 7."""
    return _evaluate("height_displacement", look_rad, point_height_m, presentation=presentation)[0]


def parallax_from_height(
    base_m: ArrayLike,
    height_m: ArrayLike,
    ground_range_m: ArrayLike,
    point_height_m: ArrayLike,
    *,
    arrangement: str = "same-side",
    presentation: str = "ground",
) -> FloatArray:
    """Parallax difference of two points that differ by this height [m], Eq. 6 and 7."""
    return _evaluate(
        "parallax_from_height",
        base_m,
        height_m,
        ground_range_m,
        point_height_m,
        arrangement=arrangement,
        presentation=presentation,
    )[0]


def height_from_parallax(
    base_m: ArrayLike,
    height_m: ArrayLike,
    ground_range_m: ArrayLike,
    parallax_m: ArrayLike,
    *,
    arrangement: str = "same-side",
    presentation: str = "ground",
) -> FloatArray:
    """Height difference of two points of this parallax difference [m], Eq. 6 and 7."""
    return _evaluate(
        "height_from_parallax",
        base_m,
        height_m,
        ground_range_m,
        parallax_m,
        arrangement=arrangement,
        presentation=presentation,
    )[0]


def absolute_parallax(
    base_m: ArrayLike,
    height_m: ArrayLike,
    ground_range_m: ArrayLike,
    *,
    arrangement: str = "same-side",
    presentation: str = "slant",
) -> FloatArray:
    """Absolute parallax [m]: in slant range Eq. 8, in ground range the base."""
    return _evaluate(
        "absolute_parallax",
        base_m,
        height_m,
        ground_range_m,
        arrangement=arrangement,
        presentation=presentation,
    )[0]


def camera_exaggeration(base_m: ArrayLike, height_m: ArrayLike) -> FloatArray:
    """Vertical exaggeration of a camera's stereo model, dimensionless, Eq. 9."""
    return _evaluate("camera_exaggeration", base_m, height_m)[0]


def exaggeration_from_angles(
    first_look_rad: ArrayLike, second_look_rad: ArrayLike, *, arrangement: str = "same-side"
) -> FloatArray:
    """Vertical exaggeration of a radar's stereo model, dimensionless, Eq. 10; angles are magnitudes."""
    return _evaluate(
        "exaggeration_from_angles", first_look_rad, second_look_rad, arrangement=arrangement
    )[0]


def exaggeration(
    base_m: ArrayLike, height_m: ArrayLike, ground_range_m: ArrayLike, *, arrangement: str = "same-side"
) -> FloatArray:
    """The same from the configuration, dimensionless, Eq. 11."""
    return _evaluate("exaggeration", base_m, height_m, ground_range_m, arrangement=arrangement)[0]


def across_error_of_second_across(
    base_m: ArrayLike,
    height_m: ArrayLike,
    ground_range_m: ArrayLike,
    dy0_second_m: ArrayLike,
    *,
    arrangement: str = "same-side",
) -> FloatArray:
    """Across-track error by that of station '' [m], Eq. 12."""
    return _evaluate(
        "across_error_of_second_across",
        base_m,
        height_m,
        ground_range_m,
        dy0_second_m,
        arrangement=arrangement,
    )[0]


def _station(errors: Optional[Mapping[str, ArrayLike]], name: str) -> list[Any]:
    errors = {} if errors is None else errors
    for key in errors:
        if key not in _STATION:
            raise _core.InputError(f"{name}: '{key}' is not known, {', '.join(_STATION)} are allowed")
    return [errors.get(key, 0.0) for key in _STATION]


def point_errors(
    base_m: ArrayLike,
    height_m: ArrayLike,
    ground_range_m: ArrayLike,
    first: Optional[Mapping[str, ArrayLike]] = None,
    second: Optional[Mapping[str, ArrayLike]] = None,
    *,
    arrangement: str = "same-side",
    signs: str = "derived",
) -> PointErrors:
    """Error of a point [m] by errors of the stations ' (`first`) and '' (`second`), Eq. 13 to 15.
    Their keys: dx0_m, dy0_m, dz0_m, dr_m, and dydot0_1, dzdot0_1 of the direction of flight."""
    return PointErrors(
        *_evaluate(
            "point_errors",
            base_m,
            height_m,
            ground_range_m,
            *_station(first, "first"),
            *_station(second, "second"),
            arrangement=arrangement,
            signs=signs,
        )
    )


def across_error_of_base(
    base_m: ArrayLike,
    height_m: ArrayLike,
    ground_range_m: ArrayLike,
    base_error_m: ArrayLike,
    *,
    arrangement: str = "same-side",
) -> FloatArray:
    """Across-track error by one of the base [m], Eq. 16."""
    return _evaluate(
        "across_error_of_base", base_m, height_m, ground_range_m, base_error_m, arrangement=arrangement
    )[0]


def height_error_of_base(
    base_m: ArrayLike,
    height_m: ArrayLike,
    ground_range_m: ArrayLike,
    base_error_m: ArrayLike,
    *,
    arrangement: str = "same-side",
) -> FloatArray:
    """Height error by one of the base [m], Eq. 17."""
    return _evaluate(
        "height_error_of_base", base_m, height_m, ground_range_m, base_error_m, arrangement=arrangement
    )[0]


def across_error_of_height(
    base_m: ArrayLike,
    height_m: ArrayLike,
    ground_range_m: ArrayLike,
    height_error_m: ArrayLike,
    *,
    arrangement: str = "same-side",
) -> FloatArray:
    """Across-track error by one of the stations' height difference [m], Eq. 20."""
    return _evaluate(
        "across_error_of_height",
        base_m,
        height_m,
        ground_range_m,
        height_error_m,
        arrangement=arrangement,
    )[0]


def height_error_of_height(
    base_m: ArrayLike,
    height_m: ArrayLike,
    ground_range_m: ArrayLike,
    height_error_m: ArrayLike,
    *,
    arrangement: str = "same-side",
) -> FloatArray:
    """Height error by one of the stations' height difference [m], Eq. 21."""
    return _evaluate(
        "height_error_of_height",
        base_m,
        height_m,
        ground_range_m,
        height_error_m,
        arrangement=arrangement,
    )[0]


def difference_error_of_base(
    base_m: ArrayLike,
    height_m: ArrayLike,
    ground_range_m: ArrayLike,
    dy_m: ArrayLike,
    dz_m: ArrayLike,
    base_error_m: ArrayLike,
    *,
    arrangement: str = "same-side",
    signs: str = "derived",
) -> Difference:
    """Error of a coordinate difference (dy, dz) by one of the base [m], Eq. 18 and 19."""
    return Difference(
        *_evaluate(
            "difference_error_of_base",
            base_m,
            height_m,
            ground_range_m,
            dy_m,
            dz_m,
            base_error_m,
            arrangement=arrangement,
            signs=signs,
        )
    )


def difference_error_of_height(
    base_m: ArrayLike,
    height_m: ArrayLike,
    ground_range_m: ArrayLike,
    dy_m: ArrayLike,
    dz_m: ArrayLike,
    height_error_m: ArrayLike,
    *,
    arrangement: str = "same-side",
    signs: str = "derived",
) -> Difference:
    """The same by one of the stations' height difference [m], Eq. 22 and 23."""
    return Difference(
        *_evaluate(
            "difference_error_of_height",
            base_m,
            height_m,
            ground_range_m,
            dy_m,
            dz_m,
            height_error_m,
            arrangement=arrangement,
            signs=signs,
        )
    )


def range_warp(
    base_m: ArrayLike,
    height_m: ArrayLike,
    ground_range_m: ArrayLike,
    range_error_first_m: ArrayLike,
    range_error_second_m: ArrayLike,
    *,
    arrangement: str = "same-side",
    signs: str = "derived",
) -> Warp:
    """How systematic range errors [m] warp the model, dimensionless, Eq. 24."""
    return Warp(
        *_evaluate(
            "range_warp",
            base_m,
            height_m,
            ground_range_m,
            range_error_first_m,
            range_error_second_m,
            arrangement=arrangement,
            signs=signs,
        )
    )


def noise_of_range(
    base_m: ArrayLike,
    height_m: ArrayLike,
    ground_range_m: ArrayLike,
    range_sigma_m: ArrayLike,
    second_range_sigma_m: Optional[ArrayLike] = None,
    *,
    arrangement: str = "same-side",
) -> RangeNoise:
    """Standard deviations of a point [m] by those of the ranges, Eq. 25; the second range has that
    of the first unless it is given its own."""
    second = range_sigma_m if second_range_sigma_m is None else second_range_sigma_m
    return RangeNoise(
        *_evaluate(
            "noise_of_range",
            base_m,
            height_m,
            ground_range_m,
            range_sigma_m,
            second,
            arrangement=arrangement,
        )
    )
