# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures by Matplotlib. Each draws into `ax`, or into a new figure, and returns the axes."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MOST_POINTS = 2000


def _axes(ax: Optional[Axes]) -> Axes:
    if ax is not None:
        return ax
    import matplotlib.pyplot as plt

    return plt.subplots(layout="constrained")[1]


def restitution(fit: Any, ax: Optional[Axes] = None) -> Axes:
    """The curve eps(v) with its 95 % band, and the bounces: up to 400 without what drag and contact time did to them, with
    the errors of their times as bars; more of them as measured.

    Parameters
    ----------
    fit : Fit or Analysis
        As `bouncelab.fit` and `bouncelab.analyze` give it.
    ax : matplotlib.axes.Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        Where it was drawn.
    """
    ax = _axes(ax)
    fit = getattr(fit, "fit", fit)
    curve = fit.results["curve"]
    if curve is None:
        raise ValueError(f"the fit has no curve to draw: {fit._why()}")
    v = np.array([p["v_mps"] for p in curve["points"] or curve["nodes"]])
    shown = fit.shown_samples() if fit.samples is not None else None
    if shown is not None:
        ax.errorbar(shown["v_mps"], shown["eps"], shown["sigma_eps"], fmt=".", ms=4, lw=0.8, color="0.55",
                    label="bounces, with the errors of their times", zorder=1)
    elif fit.samples is not None:
        points = slice(None, None, max(1, -(-len(fit.samples) // _MOST_POINTS)))
        ax.plot(fit.samples.v[points], fit.samples.eps[points], ".", ms=3, color="0.65", label="bounces as measured", zorder=1)
    band = fit.eps(v)
    ax.fill_between(v, band.lo95, band.hi95, color="C0", alpha=0.3, lw=0, label="95 %", zorder=2)
    ax.plot(v, band.value, color="C0", label="ε(v)", zorder=3)
    if fit.samples is not None and len(fit.samples) > 20:
        low, high = np.nanpercentile(fit.samples.eps, [1, 99])  # lost bounces lie far off
        low, high = min(low, band.value.min()), max(high, band.value.max())
        ax.set_ylim(low - 0.15 * (high - low), high + 0.15 * (high - low))
    ax.set_xlabel("impact speed v (m/s)")
    ax.set_ylabel("coefficient of restitution ε")
    ax.legend(frameon=False)
    return ax


def density(fit: Any, window: Optional[int] = None, ax: Optional[Axes] = None) -> Axes:
    """The distribution of eps in one window of speeds, with the fitted density.

    Parameters
    ----------
    fit : Fit or Analysis
        As `bouncelab.fit` and `bouncelab.analyze` give it.
    window : int, optional
        Number of the window, in the order of ``fit.results["histograms"]``; that of the most impacts where absent.
    ax : matplotlib.axes.Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        Where it was drawn.
    """
    windows = getattr(fit, "fit", fit).results["histograms"]
    if not windows:
        raise ValueError("no window of speed has as many bounces as a density needs: some 30")
    if window is None:
        window = max(range(len(windows)), key=lambda k: windows[k]["n"], default=0)
    if not 0 <= window < len(windows):
        raise ValueError(f"window {window}: the fit has windows 0 to {len(windows) - 1} of speed")
    found = windows[window]
    ax = _axes(ax)
    edges, counts = np.array(found["bins"]["eps_edges"]), np.array(found["bins"]["counts"])
    ax.stairs(counts / (found["n"] * np.diff(edges)), edges, fill=True, color="0.8", label=f"{found['n']} bounces")
    ax.plot(found["curve"]["eps"], found["curve"]["density"], color="C0", label="two exponentials, fitted")
    ax.set_title(f"impact speeds from {found['v_lo_mps']:.3g} to {found['v_hi_mps']:.3g} m/s")
    ax.set_xlabel("coefficient of restitution ε")
    ax.set_ylabel("probability density p(ε)")
    ax.legend(frameon=False)
    return ax


def sound(samples: Any, rate: Optional[float] = None, onsets: Optional[Any] = None, ax: Optional[Axes] = None) -> Axes:
    """Sound as the extremes of 2,000 stretches of time, with a mark for each impact.

    Parameters
    ----------
    samples : array or Recording
        (frames,) or (frames, channels), of which the first is drawn.
    rate : float
        Sampling rate [Hz]; a Recording has its own.
    onsets : Onsets, optional
        Impacts to mark.
    ax : matplotlib.axes.Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        Where it was drawn.
    """
    rate = getattr(samples, "rate", rate)
    samples = np.asarray(getattr(samples, "samples", samples))
    if samples.dtype.kind not in "fi" or samples.ndim not in (1, 2) or len(samples) == 0 or rate is None:
        raise ValueError("samples and their rate are needed: sound(samples, rate)")
    ax = _axes(ax)
    samples = samples[:, 0] if samples.ndim == 2 else samples
    if samples.dtype.kind == "i":
        samples = samples / -float(np.iinfo(samples.dtype).min)
    starts = np.linspace(0, len(samples), min(2000, len(samples)), endpoint=False).astype(int)
    ax.fill_between(starts / rate, np.minimum.reduceat(samples, starts), np.maximum.reduceat(samples, starts),
                    color="C0", lw=0.5, step="post")
    if onsets is not None and len(onsets) > 0:
        ax.plot(onsets.t, np.full(len(onsets), samples.max() * 1.08), "|", color="C3", label=f"{len(onsets)} impacts")
        ax.legend(frameon=False, loc="lower right")
    ax.set_xlabel("time (s)")
    ax.set_ylabel("sound (full scale = 1)")
    return ax
