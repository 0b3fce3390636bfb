# SPDX-License-Identifier: Apache-2.0
"""What `progress=` takes."""
from __future__ import annotations

import importlib
from typing import Any, Callable, Optional, Union

Callback = Callable[[str, int, int, str], object]
Progress = Union[Callback, bool, None]


class _Bar:
    """A bar of tqdm, a new one for every stage."""

    def __init__(self) -> None:
        self._tqdm: Any = importlib.import_module("tqdm.auto").tqdm
        self._bar: Any = None
        self._stage = ""

    def __call__(self, stage: str, done: int, total: int, detail: str) -> None:
        if self._bar is None or stage != self._stage:
            self.close()
            self._bar, self._stage = self._tqdm(desc=stage, total=total or None), stage
        self._bar.total = total or None
        self._bar.n = done
        self._bar.set_postfix_str(detail, refresh=False)
        self._bar.refresh()

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()
            self._bar = None


class reporting:
    """`with reporting(progress) as callback:` gives the callable that the library calls."""

    def __init__(self, progress: Progress) -> None:
        self._bar: Optional[_Bar] = _Bar() if progress is True else None
        self._callback: Optional[Callback] = None if isinstance(progress, bool) else progress

    def __enter__(self) -> Optional[Callback]:
        return self._bar if self._bar is not None else self._callback

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.close()
