# SPDX-License-Identifier: GPL-3.0-or-later
"""The coefficient of restitution of a bouncing ball, from simulated and recorded sound.

    import bouncelab as bl

    analysis = bl.analyze("drop.wav")     # all at once: analysis.fit.answer, analysis.report

    onsets = bl.detect("drop.wav")        # or an array and its rate; onsets.t, onsets.sigma
    samples = bl.restitution(onsets)      # samples.v, samples.eps, samples.sigma
    fit = bl.fit(samples)
    print(fit.answer)
    fit.eps(0.5)                          # value and 95 % interval at 0.5 m/s
    fit.report("drop.html")

The functions are the commands of the command line with their options as keywords: the same names, units, ranges and
numbers. Times are in seconds, speeds in m/s; full scale of sound is 1.
"""
from __future__ import annotations

from typing import TYPE_CHECKING, Any, List

from . import _core
from ._functions import analyze, compare, dem, detect, fit, loop, restitution, roughness, simulate, synthesize, validate
from .results import (Analysis, BouncelabWarning, Comparison, Fit, Impacts, Loop, Onsets, Recording, Roughness, Samples,
                      Validation)
from .theory import eps_of_law, fluctuation_sides

if TYPE_CHECKING:
    from . import plot

__version__: str = _core.version()
__all__ = [
    "Analysis", "BouncelabWarning", "Comparison", "Fit", "Impacts", "Loop", "Onsets", "Recording", "Roughness", "Samples",
    "Validation", "analyze", "balls", "compare", "dem", "detect", "eps_of_law", "fit", "fluctuation_sides", "loop", "plot", "restitution", "roughness", "simulate", "synthesize", "validate",
]


def balls() -> dict:
    """The balls, materials and plates that have names, with their numbers and sources.

    Returns
    -------
    dict
        What ``bouncelab balls --json`` prints.

    Examples
    --------
    >>> import bouncelab as bl
    >>> bl.balls()["balls"][0]["name"]
    'table-tennis'
    """
    import json

    return json.loads(_core.balls())


def __getattr__(name: str) -> Any:
    if name == "plot":  # with Matplotlib only where it is wanted
        import importlib

        return importlib.import_module(".plot", __name__)
    raise AttributeError(f"module 'bouncelab' has no attribute '{name}'")


def __dir__() -> List[str]:
    return sorted([*__all__, "__version__"])
