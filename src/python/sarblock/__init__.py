# SPDX-License-Identifier: Apache-2.0
"""Least-squares stereo block adjustment for side-looking radar, with the exact covariance of
everything it solves.

>>> import sarblock
>>> block = sarblock.read_block("block")            # doctest: +SKIP
>>> result = sarblock.adjust(block)                 # doctest: +SKIP
>>> result.points.covariance_enu_m2.shape           # doctest: +SKIP
(1272, 3, 3)

Units are SI: metres, seconds, radians; the end of a name says which (`_m`, `_s`, `_rad`, `_m2`, `_1`
for none). Arrays over numbers of a block or a result are views that cannot be written to.
docs/python.md is the manual.
"""
from . import leberl
from ._core import InputError, Interrupted, UndeterminedError, __version__
from ._options import option_table
from .block import Block, Pass, read_block, simulate
from .reduction import solid_earth_tide, zenith_delay
from .result import Result, adjust, check, intersect, predict, read_result

__all__ = [
    "Block",
    "InputError",
    "Interrupted",
    "Pass",
    "Result",
    "UndeterminedError",
    "__version__",
    "adjust",
    "check",
    "intersect",
    "leberl",
    "option_table",
    "predict",
    "read_block",
    "read_result",
    "simulate",
    "solid_earth_tide",
    "zenith_delay",
]
