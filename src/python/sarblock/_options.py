# SPDX-License-Identifier: Apache-2.0
"""Values of Python as TOML, and options as the KEY=VALUE texts of the command line's --set."""
from __future__ import annotations

import json
import os
from typing import Any, Iterator, Mapping, NamedTuple, Sequence

import numpy as np

from . import _core


class Option(NamedTuple):
    """A key of the [adjust] table."""

    key: str
    type: str
    allowed: str
    standard: str
    help: str


def option_table() -> list[Option]:
    """Every key that `adjust` takes, as in docs/adjust_options.md."""
    return [Option(*row) for row in _core.option_table()]


def toml_value(value: object) -> str:
    """The value as TOML: texts, numbers, True and False, lists, arrays and dictionaries."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, os.PathLike):
        value = os.fspath(value)
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{toml_key(k)} = {toml_value(v)}" for k, v in given(value)) + " }"
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(toml_value, value)) + "]"
    raise _core.InputError(f"{value!r} is no value of an option: a text, a number, True, False, a list or a "
                           "dictionary is allowed")


def toml_key(key: object) -> str:
    """A key, in quotes where it needs them."""
    text = str(key)
    plain = text.isascii() and text.replace("_", "").replace("-", "").isalnum()
    return text if plain else toml_value(text)


def given(table: Mapping[Any, object]) -> Iterator[tuple[Any, object]]:
    """The entries whose value is not None."""
    return ((key, value) for key, value in table.items() if value is not None)


def overrides(options: Mapping[str, object]) -> list[str]:
    """`KEY=VALUE` for every option that is not None. A dictionary sets the keys in it."""
    texts = []
    for key, value in given(options):
        if isinstance(value, Mapping):
            texts += [f"{key}.{inner}" for inner in overrides(value)]
        else:
            texts.append(f"{key}={toml_value(value)}")
    return texts


def block_toml(
    name: str,
    frame: str | Mapping[str, object],
    passes: Sequence[Mapping[str, object]],
    sections: Mapping[str, Mapping[str, object] | None],
) -> str:
    """The content of a block.toml."""
    if isinstance(frame, str):
        frame = {"kind": "local"} if frame == "local" else {"kind": "geocentric", "ellipsoid": frame}
    top: dict[str, object] = {"format": "sarblock-block 1", "name": name, "frame": frame, **sections}
    lines = [f"{key} = {toml_value(value)}" for key, value in given(top)]
    for one in passes:
        lines.append("[[pass]]")
        lines += [f"{toml_key(key)} = {toml_value(value)}" for key, value in given(one)]
    return "\n".join(lines) + "\n"
