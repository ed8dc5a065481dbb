# SPDX-License-Identifier: GPL-3.0-or-later
"""Progress of long work: by the caller's function, or by tqdm where that is installed."""
from __future__ import annotations

from typing import Any, Callable, Optional, Union

Callback = Callable[[str, float, float, str], None]


class _Bars:
    """A bar of tqdm for each kind of work."""

    def __init__(self, tqdm: Any):
        self._tqdm: Any = tqdm
        self._bar: Any = None
        self._label = ""

    def __call__(self, label: str, done: float, total: float, unit: str) -> None:
        if label != self._label:
            self.close()
            self._label = label
            total = int(total) if total == int(total) else round(total, 1)
            self._bar = self._tqdm(total=total or None, desc=label, unit=" " + unit, leave=False)
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()
        self._bar = None


class shown:
    """Context that makes a callback of what the user gave: None, True or a function.

    >>> with shown(None) as callback:
    ...     print(callback)
    None
    """

    def __init__(self, progress: Union[None, bool, Callback]):
        self._callback: Optional[Callback] = None
        if progress is True:
            try:
                from tqdm.auto import tqdm
            except ImportError:
                return
            self._callback = _Bars(tqdm)
        elif callable(progress):
            self._callback = progress
        elif progress not in (None, False):
            raise TypeError("progress: None, True or a function (label, done, total, unit)")

    def __enter__(self) -> Optional[Callback]:
        return self._callback

    def __exit__(self, *ignored: object) -> None:
        if isinstance(self._callback, _Bars):
            self._callback.close()
