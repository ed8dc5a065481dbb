# SPDX-License-Identifier: GPL-3.0-or-later
"""Laws and closed forms (docs/physics.md)."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from . import _core

if TYPE_CHECKING:
    import numpy.typing as npt


class Sides(NamedTuple):
    """Mean distances of the two exponentials below and above eps(v)."""

    below: Any
    above: Any


def eps_of_law(law: str, v: npt.ArrayLike) -> Any:
    """The coefficient of restitution by a law.

    Parameters
    ----------
    law : str
        As `simulate` takes it: ``series:A2=...,A4=...``, ``viscoelastic:GAMMA``, ``constant:EPS``.
    v : array_like
        Normal impact speeds [m/s], > 0.

    Returns
    -------
    ndarray
        The law at these speeds, of the shape of `v`.

    Examples
    --------
    >>> import bouncelab as bl
    >>> bl.eps_of_law("series:A2=0.0467,A4=0.1339,A5=-0.2876", [0.25, 1.0]).round(4)
    array([0.9822, 0.9763])
    """
    from .results import _speeds

    if not isinstance(law, str):
        raise TypeError(f"law: {type(law).__name__} given; a text is needed, \"constant:0.9\"")
    return _core.restitution_of_law(law, _speeds(v))


def fluctuation_sides(q: float, v: npt.ArrayLike, eps: npt.ArrayLike, path: npt.ArrayLike,
                      eps_slope: npt.ArrayLike = 0.0) -> Sides:
    """The scatter of a rough ball's coefficient of restitution in closed form: two exponentials about eps(v).

    Parameters
    ----------
    q : float
        Roughness, c s2 (docs/physics.md, 7); up to 0.1. Uniform radii of width w in a ball of N asperities, no slip:
        5/7 sqrt(pi w/N)/2.
    v : array_like
        Normal impact speeds [m/s], > 0.
    eps : array_like
        The law eps(v) there.
    path : array_like
        Sum of (1 + eps)^2 v^2 over the drop's earlier impacts [m^2/s^2]; 0 for the first impact.
    eps_slope : array_like, default 0
        The derivative d eps/dv there [s/m].

    Returns
    -------
    Sides
        Mean distances below and above eps(v), of the shape that the arguments broadcast to. The standard deviation is
        sqrt(below**2 + above**2), the mean eps + above - below.

    Examples
    --------
    >>> import bouncelab as bl
    >>> sides = bl.fluctuation_sides(1e-4, v=1.0, eps=0.97, path=[0.0, 4.0])
    >>> (sides.below * 1e4).round(3), (sides.above * 1e4).round(3)
    (array([3.94 , 6.374]), array([0.   , 2.435]))
    """
    import numpy as np

    arrays = np.broadcast_arrays(*(np.asarray(x, dtype=float) for x in (v, eps, eps_slope, path)))
    below, above = _core.sides_of_fluctuation(q, *(np.ascontiguousarray(x).ravel() for x in arrays))
    return Sides(below.reshape(arrays[0].shape), above.reshape(arrays[0].shape))
