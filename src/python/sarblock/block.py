# SPDX-License-Identifier: Apache-2.0
"""Blocks: what was measured in the images, the flight paths as recorded, the points known."""
from __future__ import annotations

import os
from typing import Any, Mapping, Optional, Sequence, Union, cast

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._options import block_toml, overrides, toml_value
from ._progress import Progress, reporting
from ._tables import (
    FlagArray, FloatArray, IndexArray, Part, TextArray, choose, column, data_frame, data_set, kept
)

Path = Union[str, "os.PathLike[str]"]
#: Arrays by name of the column: a dictionary, a pandas.DataFrame.
Table = Any

ROLES = np.array(["tie", "control", "check"])
_VECTORS = {
    "position_m": ("x_m", "y_m", "z_m"),
    "velocity_mps": ("vx_mps", "vy_mps", "vz_mps"),
    "sigma_enu_m": ("sigma_e_m", "sigma_n_m", "sigma_u_m"),
}
_REJECTED, _DOPPLER, _SECONDS, _HERTZ = 1, 2, 4, 8
# Key of a pass in block.toml by the unit of its azimuth.
_AZIMUTH_KEYS = {"m": "azimuth_sigma_m", "s": "azimuth_sigma_s", "hz": "doppler_sigma_hz"}


class Pass:
    """One image strip with one flight path."""

    def __init__(self, core: _core.Block, index: int) -> None:
        self._core, self._index = core, index
        self._said = core.describe_pass(index)

    @property
    def id(self) -> str:
        """Its name."""
        return str(self._said["id"])

    @property
    def look(self) -> str:
        """Side of the flight direction the antenna looks to: "left" or "right"."""
        return str(self._said["look"])

    @property
    def wavelength_m(self) -> float:
        """Wavelength [m]; nan: not given."""
        return float(self._said["wavelength_m"])

    @property
    def range_sigma_m(self) -> float:
        """Standard deviation of a range [m] of looks that give none; nan: none."""
        return float(self._said["range_sigma_m"])

    @property
    def azimuth_sigma(self) -> float:
        """The same of azimuth, in `azimuth_unit`."""
        return float(self._said["azimuth_sigma"])

    @property
    def azimuth_unit(self) -> str:
        """"m" along track at the target, "s" of azimuth time, or "hz" of a Doppler at an exact time."""
        return str(self._said["azimuth_unit"])

    @property
    def start_s(self) -> float:
        """Time [s] of strip time -1."""
        return float(self._said["start_s"])

    @property
    def end_s(self) -> float:
        """Time [s] of strip time +1."""
        return float(self._said["end_s"])

    @property
    def squint_deg(self) -> float:
        """Squint [deg] of looks that give no cone, and of looks that `predict` plans."""
        return float(self._said["squint_deg"])

    @property
    def swath(self) -> Optional[tuple[str, float, float]]:
        """What the pass sees: "swath_look_deg", "swath_ground_m" or "swath_range_m", near and far in
        its unit; None: not given."""
        return cast(Optional[tuple[str, float, float]], self._said["swath"])

    @property
    def epoch_utc(self) -> str:
        """What time 0 is; empty: not given."""
        return str(self._said["epoch_utc"])

    @property
    def reduction(self) -> dict[str, object]:
        """What is taken off the measured ranges and times of the pass, by the keys of `[reduction]`;
        empty: nothing."""
        return cast(dict[str, object], self._said["reduction"])

    @kept
    def states(self) -> FloatArray:
        """State vectors as recorded, (states, 7): time [s], position [m], velocity [m/s]."""
        return self._core.states(self._index)

    def _table(self) -> dict[str, object]:
        """The [[pass]] table of block.toml."""
        said = self._said
        trajectory = {
            "through": said["through"],
            "sigma_m": _given_number(said["state_sigma_m"]),
            "sigma_mps": _given_number(said["state_sigma_mps"]),
        }
        swath = {} if self.swath is None else {self.swath[0]: list(self.swath[1:])}
        return {
            **swath,
            "id": self.id,
            "look": self.look,
            "wavelength_m": _given_number(self.wavelength_m),
            "range_sigma_m": _given_number(self.range_sigma_m),
            _AZIMUTH_KEYS[self.azimuth_unit]: _given_number(self.azimuth_sigma),
            "start_s": self.start_s,
            "end_s": self.end_s,
            "squint_deg": self.squint_deg or None,
            "epoch_utc": self.epoch_utc or None,
            "reduction": self.reduction or None,
            "trajectory": trajectory,
        }

    def __repr__(self) -> str:
        return f"<sarblock.Pass {self.id}, looks {self.look}, {len(self.states)} states>"


def _given_number(value: float) -> Optional[float]:
    return None if np.isnan(value) else float(value)


class BlockPoints(Part[_core.Block]):
    """Points of a block; their order is the index that looks and results use."""

    _group = "points"

    def __len__(self) -> int:
        return len(self.given_m)

    ids = column[TextArray]("Names, (points,).")

    @kept
    def role(self) -> TextArray:
        """"tie", "control" or "check", (points,)."""
        role: TextArray = ROLES[self._core.array("points.role")]
        return role

    given_m = column[FloatArray](
        "Coordinates given [m], (points, 3), frame axes; nan: none. Of tie points start values."
    )
    known_index = column[IndexArray]("Indices of control and check points, (known,).")
    known_held = column[FlagArray]("Which of east, north, up of them are known, (known, 3).")
    known_covariance_enu_m2 = column[FloatArray](
        "Covariance of their known positions [m2], east, north, up, (known, 3, 3)."
    )
    known_velocity_mpy = column[FloatArray](
        "Velocities of their positions in the frame [m a year], frame axes, (known, 3); 0: at rest."
    )


class BlockLooks(Part[_core.Block]):
    """Looks in flat arrays, sorted by point and, within a point, by pass. A look is one observation
    of a point in one image."""

    _group = "looks"

    def __len__(self) -> int:
        return len(self.range_m)

    def _flagged(self, flag: int) -> FlagArray:
        flagged: FlagArray = (self._core.array("looks.flags") & flag) != 0
        return flagged

    def _or_filled(self, name: str, value: float) -> FloatArray:
        given: Optional[FloatArray] = self._core.array(name)
        return np.full(len(self), value) if given is None else given

    offsets = column[NDArray[np.uint64]](
        "Looks of point j are offsets[j] to offsets[j + 1] - 1, (points + 1,)."
    )
    pass_index = column[IndexArray]("Index of the pass, (looks,).")

    @kept
    def point_index(self) -> IndexArray:
        """Index of the point, (looks,)."""
        return point_of_look(self.offsets)

    time_s = column[FloatArray](
        "Azimuth time less time_shift_s [s], (looks,); nan in a plan that gives none."
    )
    range_m = column[FloatArray](
        "One-way slant range less range_delay_m [m], (looks,); nan in a plan that gives none."
    )
    range_delay_m = column[FloatArray](
        "What the look gives as taken off its measured range [m], (looks,).", fill=0.0
    )
    time_shift_s = column[FloatArray](
        "What the look gives as taken off its measured time [s], (looks,).", fill=0.0
    )

    @kept
    def squint_rad(self) -> FloatArray:
        """Squint angle [rad], (looks,); nan where a Doppler centroid is given."""
        return np.where(self._flagged(_DOPPLER), np.nan, self._or_filled("looks.cone", 0.0))

    @kept
    def doppler_hz(self) -> FloatArray:
        """Doppler centroid [Hz], (looks,); nan where a squint angle is given, or neither."""
        return np.where(self._flagged(_DOPPLER), self._or_filled("looks.cone", 0.0), np.nan)

    range_sigma_m = column[FloatArray]("Standard deviation of the range [m], (looks,); nan: the pass's.")

    @kept
    def azimuth_sigma_m(self) -> FloatArray:
        """Standard deviation of azimuth along track [m], (looks,); nan: in another unit, or the pass's."""
        given = self._or_filled("looks.azimuth_sigma", np.nan)
        return np.where(self._flagged(_SECONDS | _HERTZ), np.nan, given)

    @kept
    def time_sigma_s(self) -> FloatArray:
        """Standard deviation of azimuth time [s], (looks,); nan: in another unit, or the pass's."""
        given = self._or_filled("looks.azimuth_sigma", np.nan)
        return np.where(self._flagged(_SECONDS), given, np.nan)

    @kept
    def doppler_sigma_hz(self) -> FloatArray:
        """Standard deviation of a measured Doppler [Hz], whose time is exact, (looks,); nan: the time
        is measured, or the pass's."""
        given = self._or_filled("looks.azimuth_sigma", np.nan)
        return np.where(self._flagged(_HERTZ), given, np.nan)

    @kept
    def rejected(self) -> FlagArray:
        """Kept in the file, left out of the adjustment, (looks,)."""
        return self._flagged(_REJECTED)


def point_of_look(offsets: NDArray[np.uint64]) -> IndexArray:
    """The point of every look from the points' offsets."""
    counts = np.diff(offsets.astype(np.int64))
    return np.repeat(np.arange(len(counts), dtype=np.uint32), counts)


class Block:
    """Radar images of one area: passes, points and looks. Made by `read_block`, `simulate` or
    `Block.from_arrays`, and never changed."""

    def __init__(self, core: _core.Block) -> None:
        self._core = core

    @property
    def name(self) -> str:
        """Its name."""
        return self._core.name

    @property
    def frame(self) -> dict[str, Any]:
        """The [frame] table: `kind`, "local" or "geocentric", and of the latter `ellipsoid`, its name
        or its axis `a_m` [m] and flattening `f`; `realization` and `epoch` [year] where given."""
        return self._core.frame

    @property
    def warnings(self) -> list[str]:
        """What reading it found."""
        return self._core.warnings

    @kept
    def passes(self) -> tuple[Pass, ...]:
        """The passes; `pass_index` counts in them."""
        return tuple(Pass(self._core, index) for index in range(self._core.pass_count))

    @kept
    def pass_ids(self) -> TextArray:
        """Names of the passes, (passes,)."""
        return np.array([one.id for one in self.passes])

    @kept
    def points(self) -> BlockPoints:
        """The points."""
        return BlockPoints(self._core)

    @kept
    def looks(self) -> BlockLooks:
        """The looks."""
        return BlockLooks(self._core)

    @kept
    def truth_m(self) -> Optional[FloatArray]:
        """True positions [m], (points, 3), of a simulated block; None where they are not known."""
        return self._core.truth_m()

    def options(self, **options: object) -> str:
        """The [adjust] table of the block as TOML, with these options over it."""
        return self._core.options(overrides(options))

    def write(
        self, path: Path, *, gzip: bool = False, force: bool = False, progress: Progress = None
    ) -> None:
        """Writes a block folder, or an HDF5 file where the name ends in ".h5". `gzip` compresses
        the tables; `force` writes into a folder that holds other files."""
        with reporting(progress) as callback:
            self._core.write(path, gzip, force, callback)

    def to_arrays(self) -> dict[str, Any]:
        """The arguments of `from_arrays` that make this block, to be changed before it is made
        again. Passes and points are counted, not named: `pass_index`, `point_index`."""
        points, looks = self.points, self.looks
        states = [one.states for one in self.passes]
        counted = [np.full(len(rows), index) for index, rows in enumerate(states)]
        flight = np.concatenate(states)
        known = {"sigma_e_m": (0, 0), "sigma_n_m": (1, 1), "sigma_u_m": (2, 2)}
        known.update({"cov_en_m2": (0, 1), "cov_eu_m2": (0, 2), "cov_nu_m2": (1, 2)})
        columns = {}
        for name, (row, column) in known.items():
            values = points.known_covariance_enu_m2[:, row, column]
            values = np.sqrt(values) if row == column else values
            columns[name] = np.full(len(points), np.nan)
            columns[name][points.known_index] = np.where(values != 0.0, values, np.nan)
        if points.known_velocity_mpy.any():
            for axis, name in enumerate(("vx_mpy", "vy_mpy", "vz_mpy")):
                columns[name] = np.full(len(points), np.nan)
                columns[name][points.known_index] = points.known_velocity_mpy[:, axis]
        of_pass = np.array([one.squint_deg for one in self.passes])[looks.pass_index]
        own = (looks.squint_rad != 0.0) | ((of_pass != 0.0) & np.isnan(looks.doppler_hz))
        optional = {
            "squint_deg": np.where(own, np.degrees(looks.squint_rad), np.nan),
            "doppler_hz": looks.doppler_hz,
            "range_sigma_m": looks.range_sigma_m,
            "azimuth_sigma_m": looks.azimuth_sigma_m,
            "time_sigma_s": looks.time_sigma_s,
            "doppler_sigma_hz": looks.doppler_sigma_hz,
        }
        optional = {name: values for name, values in optional.items() if not np.isnan(values).all()}
        if looks.rejected.any():
            optional["rejected"] = looks.rejected.astype(np.float64)
        for name, values in {"range_delay_m": looks.range_delay_m, "time_shift_s": looks.time_shift_s}.items():
            if values.any():
                optional[name] = values
        return {
            "name": self.name,
            "frame": self.frame,
            "passes": [one._table() for one in self.passes],
            "trajectories": {
                "pass_index": np.concatenate(counted),
                "time_s": flight[:, 0],
                "position_m": flight[:, 1:4],
                "velocity_mps": flight[:, 4:7],
            },
            "observations": {
                "pass_index": looks.pass_index,
                "point_index": looks.point_index,
                "time_s": looks.time_s + looks.time_shift_s,
                "range_m": looks.range_m + looks.range_delay_m,
                **optional,
            },
            "points": {
                "point": points.ids,
                "role": points.role,
                "position_m": points.given_m,
                **columns,
            },
            "adjust": self.options(),
        }

    def _tables(self) -> dict[str, dict[str, Optional[NDArray[Any]]]]:
        points, looks = self.points, self.looks
        return {
            "points": {"point": points.ids, "role": points.role, "position_m": points.given_m},
            "looks": {
                "pass": self.pass_ids[looks.pass_index],
                "point": points.ids[looks.point_index],
                "time_s": looks.time_s,
                "range_m": looks.range_m,
                "squint_rad": looks.squint_rad,
                "doppler_hz": looks.doppler_hz,
                "range_sigma_m": looks.range_sigma_m,
                "azimuth_sigma_m": looks.azimuth_sigma_m,
                "time_sigma_s": looks.time_sigma_s,
                "doppler_sigma_hz": looks.doppler_sigma_hz,
                "range_delay_m": looks.range_delay_m,
                "time_shift_s": looks.time_shift_s,
                "rejected": looks.rejected,
            },
        }

    def to_dataframe(self, table: str = "looks") -> Any:
        """A pandas.DataFrame of "looks" or "points", one row each."""
        return data_frame(choose(self._tables(), table))

    def to_xarray(self) -> Any:
        """An xarray.Dataset of points and looks, with units."""
        return data_set(self._tables(), self.name)

    def __repr__(self) -> str:
        return (
            f"<sarblock.Block {self.name}: {len(self.passes)} passes, {len(self.points)} points, "
            f"{len(self.looks)} looks>"
        )

    @classmethod
    def from_arrays(
        cls,
        *,
        passes: Sequence[Mapping[str, object]],
        trajectories: Table,
        observations: Table,
        points: Optional[Table] = None,
        frame: Union[str, Mapping[str, object]] = "local",
        sigma: Optional[Mapping[str, object]] = None,
        trajectory: Optional[Mapping[str, object]] = None,
        reduction: Optional[Mapping[str, object]] = None,
        adjust: Union[Mapping[str, object], str, None] = None,
        name: str = "block",
        plan: bool = False,
        progress: Progress = None,
    ) -> Block:
        """A block from arrays, checked like one of files and by the same code.

        `passes` are the [[pass]] tables of block.toml: `id`, `look` and what else docs/formats.md
        has. `trajectories`, `observations` and `points` are tables: arrays of one length by the
        names that the columns have in the files (`time_s`, `range_m`, ...), nan for an empty cell. A
        pass or point is named (`pass`, `point`: strings) or counted from 0 (`pass_index` in
        `passes`, `point_index` in `points`), which is faster. `position_m` (n, 3) replaces x_m,
        y_m, z_m, `velocity_mps` (n, 3) for vx_mps, vy_mps, vz_mps, `sigma_enu_m` (n, 3) for
        sigma_e_m, sigma_n_m, sigma_u_m. `frame` is "local", the name of an ellipsoid ("WGS84") or
        the [frame] table; `sigma`, `trajectory`, `reduction` and `adjust` are those of block.toml,
        `adjust` also as its text. `plan` allows looks without measured values, for `predict`.
        """
        text = adjust if isinstance(adjust, str) else ""
        table = None if isinstance(adjust, str) else adjust
        sections = {"sigma": sigma, "trajectory": trajectory, "reduction": reduction, "adjust": table}
        tables = {
            "trajectories": _table("trajectories", trajectories),
            "observations": _table("observations", observations),
        }
        if points is not None:
            tables["points"] = _table("points", points)
        ids = [str(one.get("id", "")) for one in passes]
        with reporting(progress) as callback:
            return cls(
                _core.from_arrays(
                    block_toml(name, frame, passes, sections) + text, ids, tables, plan, callback
                )
            )


def _table(name: str, table: Table) -> dict[str, NDArray[Any]]:
    """The columns of a table as arrays, vectors taken apart."""
    columns: dict[str, NDArray[Any]] = {}
    for key in table.keys():
        array = _array_of(table[key])
        if key not in _VECTORS:
            columns[str(key)] = array
            continue
        if array.ndim != 2 or array.shape[1] != 3:
            raise _core.InputError(f"{name}.{key}: has the shape {array.shape}, (rows, 3) is needed")
        columns.update({part: array[:, i] for i, part in enumerate(_VECTORS[key])})
    return columns


def _array_of(column: Any) -> NDArray[Any]:
    """The column as an array of the machine's own byte order; what is masked is not given. Rows of
    different lengths make an array of objects, which is refused."""
    if isinstance(column, np.ma.MaskedArray):
        masked = np.ma.getmaskarray(column)  # type: ignore[no-untyped-call]
        cells = np.asarray(column)
        return np.where(masked, "" if cells.dtype.kind in "US" else np.nan, cells)
    if isinstance(column, (list, tuple)) and len({np.ndim(cell) for cell in column}) > 1:
        return np.array(column, dtype=object)
    array = np.asarray(column)
    return array.astype(array.dtype.newbyteorder("="), copy=False)


def read_block(
    path: Path, *, plan: bool = False, progress: Progress = None, **options: object
) -> Block:
    """Reads a block folder or an HDF5 file (docs/formats.md, docs/container.md).

    Options are the keys of [adjust], as `--set` of the command line has them, and those of
    [trajectory] as `trajectory={"through": "auto"}`. `plan` allows looks without measured values,
    for `predict`. `progress` is a callable (stage, done, total, detail), or True for a bar of tqdm.
    Raises InputError.
    """
    with reporting(progress) as callback:
        return Block(_core.read_block(path, overrides(options), plan, callback))


def simulate(
    scene: Union[Path, Mapping[str, object]],
    *,
    threads: int = 0,
    progress: Progress = None,
    **options: object,
) -> Block:
    """A block with known truth from a scene: a TOML file (docs/scenes.md), or its content as a
    dictionary. Options are keys of the scene, as `--set` of the command line has them:
    `points={"count": 50}`. Raises InputError."""
    name, text = "scene", None
    if isinstance(scene, Mapping):
        text = "".join(f"{key} = {toml_value(value)}\n" for key, value in scene.items())
    else:
        name = os.fspath(scene)
    with reporting(progress) as callback:
        return Block(_core.simulate(name, text, overrides(options), threads, callback))
