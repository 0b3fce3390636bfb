# SPDX-License-Identifier: Apache-2.0
"""What delays ranges and moves points (docs/theory/reductions.md), on arrays that are broadcast
against each other."""
from __future__ import annotations

from typing import Optional

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from ._tables import FloatArray


def zenith_delay(
    height_m: ArrayLike,
    *,
    pressure_hpa: Optional[ArrayLike] = None,
    temperature_k: Optional[ArrayLike] = None,
    humidity_1: Optional[ArrayLike] = None,
    lat_deg: Optional[ArrayLike] = None,
    weather_height_m: ArrayLike = 0.0,
) -> FloatArray:
    """Delay of a vertical ray from a height above the ellipsoid to space in the atmosphere [m].

    Without weather that of the mean atmosphere. With weather (pressure, temperature and relative
    humidity from 0 to 1 at `weather_height_m`, and the latitude) after Saastamoinen, carried to
    the height. Over the cosine of the incidence it is the delay of a slant range.
    """
    weather = {
        "pressure_hpa": pressure_hpa,
        "temperature_k": temperature_k,
        "humidity_1": humidity_1,
        "lat_deg": lat_deg,
    }
    given = {name: value for name, value in weather.items() if value is not None}
    if given and len(given) < len(weather):
        missing = [name for name in weather if name not in given]
        raise _core.InputError(f"{missing[0]}: is needed with {next(iter(given))}")
    numbers = (height_m, *given.values(), weather_height_m) if given else (height_m,)
    arrays = np.broadcast_arrays(*(np.asarray(number, dtype=np.float64) for number in numbers))
    inputs = np.column_stack([array.ravel() for array in arrays])
    return _core.zenith_delay(inputs).reshape(arrays[0].shape)


def solid_earth_tide(lat_deg: ArrayLike, lon_deg: ArrayLike, height_m: ArrayLike, utc: ArrayLike) -> FloatArray:
    """Displacement of points of the Earth by the solid Earth tide [m]: (..., 3), east, north, up.

    `utc` is a text like "2022-10-16T01:50:44Z" or a datetime64, or an array of either, from 1972
    to 2034. Coordinates are those of WGS84. Positions less the displacement are tide free in the
    sense of the IERS Conventions (2010).
    """
    times = np.asarray(utc)
    if times.dtype.kind == "M":
        times = np.datetime_as_string(times.astype("datetime64[us]"))
    numbers = (np.asarray(number, dtype=np.float64) for number in (lat_deg, lon_deg, height_m))
    *places, texts = np.broadcast_arrays(*numbers, times.astype(str))
    inputs = np.column_stack([array.ravel() for array in places])
    moments, of_row = np.unique(texts.ravel(), return_inverse=True)
    displacement_m = np.empty((len(inputs), 3))
    for moment, text in enumerate(moments):
        rows = of_row == moment
        displacement_m[rows] = _core.solid_earth_tide(str(text), inputs[rows])
    return displacement_m.reshape(texts.shape + (3,))
