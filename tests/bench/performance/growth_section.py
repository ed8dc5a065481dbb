# SPDX-License-Identifier: GPL-3.0-or-later
"""Section of the page: how cost grows, as slopes of straight lines through logarithms."""
import math

from bench_lines import slope
from measured import seconds, table

EXPECTED = {"detect against length [min]": "1", "detect against rate [Hz]": "1", "detect against channels": "below 1",
            "detect in bursts against length [min]": "1", "synthesize against rate [Hz]": "1", "synthesize against length [min]": "1",
            "restitution against impacts": "1", "fit, impacts independent, against impacts": "1", "fit with memory against impacts": "1",
            "simulate against drops, smooth ball": "1"}


def row(name, x, y, expected):
    by, error = slope(x, y)
    return (name, f"{x[0]:,.0f} to {x[-1]:,.0f}", len(x), f"{seconds(y[0])} to {seconds(y[-1])}",
            f"{by:.3f} ± {error:.3f}" if math.isfinite(error) else f"{by:.3f}", expected)


def simulation_rows(measured):
    laws = dict.fromkeys(case.rsplit(", N = ", 1)[0] for case in measured.cases("simulate"))
    for law in laws:
        cases = measured.cases("simulate", law + ", N = ")
        n = [int(case.rsplit(" ", 1)[1]) for case in cases]
        if len(n) > 2:
            for what, expected in (("impact", "0, and what caches miss"), ("envelope", "1")):
                yield row(f"simulate: {what} against N, `{law}`", n, [measured.get("simulate", case, what) for case in cases], expected)


def growth(measured):
    rows = []
    for case in measured.cases("growth"):
        points = [(float(x), measured.get("growth", case, x)) for x in measured.names("growth", case)]
        x, y = zip(*[(a, b) for a, b in points if b > 0])
        if len(x) > 1:
            rows.append(row(case, x, y, EXPECTED.get(case, "")))
    fits = [(case, points) for case in ("fit, impacts independent, against impacts", "fit with memory against impacts")
            if (points := [(f"{int(x):,}", seconds(measured.get("growth", case, x))) for x in measured.names("growth", case)])]
    text = """## How cost grows

Processor time of whole commands, one thread, without what `bouncelab --version` takes; the least of two runs (fits with memory: one). Slope of the least-squares line through the logarithms of cost and size, with its standard error
from the scatter about the line: 1 means twice the work in twice the time, 2 four times, 0 that size does not matter.

""" + table(("", "range", "points", "cost", "slope", "expected"), rows + list(simulation_rows(measured)))
    for case, points in fits:
        text += f"\n{case[0].upper()}{case[1:]}, in full:\n\n" + table(("impacts", "processor"), points)
    return text
