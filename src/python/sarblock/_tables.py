# SPDX-License-Identifier: Apache-2.0
"""Arrays as tables of pandas and data sets of xarray, where these packages are installed."""
from __future__ import annotations

import importlib
from functools import cached_property
from typing import Any, Generic, Mapping, Optional, TypeVar

import numpy as np
from numpy.typing import NDArray

from . import _core

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.uint32]
FlagArray = NDArray[np.bool_]
TextArray = NDArray[np.str_]

#: Ends of names and their units.
UNITS = {"m": "m", "s": "s", "m2": "m2", "mps": "m s-1", "rad": "rad", "hz": "Hz", "1": "1"}
_PARTS = {"enu": ("e", "n", "u"), "correction": ("along", "across", "up"), "": ("x", "y", "z")}


T = TypeVar("T")


class kept(cached_property[T]):
    """A property that is computed once. Arrays of it cannot be written to: whoever asks again would
    get what was written."""

    def __set_name__(self, owner: type[Any], name: str) -> None:
        super().__set_name__(owner, name)
        compute = self.func

        def computed(instance: Any) -> T:
            value = compute(instance)
            if isinstance(value, np.ndarray):
                value.setflags(write=False)
            return value

        self.func = computed


Core = TypeVar("Core", _core.Block, _core.Result)


class Part(Generic[Core]):
    """Part of a block or a result: arrays that the core has by the name GROUP.PROPERTY."""

    _group: str

    def __init__(self, core: Core) -> None:
        self._core: Core = core


class column(kept[T]):
    """The array of its name, of a Part; filled where the core has none."""

    def __init__(self, text: str, fill: float = np.nan, shape: tuple[int, ...] = ()) -> None:
        super().__init__(self._read)
        self.__doc__ = text
        self._fill, self._shape = fill, shape

    def _read(self, part: Any) -> T:
        array = part._core.array(f"{part._group}.{self.attrname}")
        full: T = np.full((len(part), *self._shape), self._fill) if array is None else array
        return full


def unit_of(name: str) -> Optional[str]:
    """The unit that the end of a name says, or None."""
    return UNITS.get(name.rsplit("_", 1)[-1]) if "_" in name else None


def _columns(name: str, array: NDArray[Any]) -> dict[str, NDArray[Any]]:
    """A column, or those of a vector (x_m, y_m, z_m) or matrix (cov_ee_m2, ...) of every row."""
    if array.ndim == 1:
        return {name: array}
    stem, unit = name.rsplit("_", 1)
    kind = "enu" if "_enu" in stem else "correction" if stem.startswith("correction") else ""
    parts = _PARTS[kind]
    stem = stem.replace("_enu", "").replace("covariance", "cov")
    prefix = "" if stem == "position" else stem + "_"
    if array.ndim == 2:
        return {f"{prefix}{part}_{unit}": array[:, i] for i, part in enumerate(parts)}
    return {
        f"{prefix}{parts[i]}{parts[j]}_{unit}": array[:, i, j] for i in range(3) for j in range(i, 3)
    }


def choose(
    tables: Mapping[str, dict[str, Optional[NDArray[Any]]]], name: str
) -> dict[str, Optional[NDArray[Any]]]:
    """The table of this name."""
    if name not in tables:
        raise _core.InputError(f"table: '{name}' is not known, {', '.join(tables)} are allowed")
    return tables[name]


def data_frame(columns: Mapping[str, Optional[NDArray[Any]]]) -> Any:
    """A pandas.DataFrame of the columns that are there."""
    pandas = importlib.import_module("pandas")
    flat: dict[str, NDArray[Any]] = {}
    for name, array in columns.items():
        if array is not None:
            flat.update(_columns(name, array))
    return pandas.DataFrame(flat)


def data_set(groups: Mapping[str, Mapping[str, Optional[NDArray[Any]]]], title: str) -> Any:
    """An xarray.Dataset: one dimension a group, `axis` and `other_axis` for vectors and matrices;
    the variables are named GROUP_COLUMN and have the attribute `units`."""
    xarray = importlib.import_module("xarray")
    variables = {}
    for group, columns in groups.items():
        for name, array in columns.items():
            if array is None:
                continue
            dimensions = (group, "axis", "other_axis")[: array.ndim]
            unit = unit_of(name)
            variables[f"{group}_{name}"] = (dimensions, array, {} if unit is None else {"units": unit})
    return xarray.Dataset(variables, attrs={"title": title})
