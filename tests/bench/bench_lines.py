# SPDX-License-Identifier: GPL-3.0-or-later
"""What every benchmark here shares: one number a line, as JSON, which tools/bench collects; the cost of a command; slopes."""
import json
import math
import os
import statistics
import sys
import tempfile
import time
from dataclasses import dataclass


def print_line(part, case, what, value, unit):
    """The same line as bench_lines.hpp prints. Numbers that are not finite are left out: they are not known."""
    if isinstance(value, float) and not math.isfinite(value):
        return
    print(json.dumps({"part": part, "case": case, "what": what, "value": value, "unit": unit}, ensure_ascii=False), flush=True)


@dataclass(frozen=True)
class Cost:
    """Of one run of a command: on the clock; of processors, user and system."""
    wall_s: float
    cpu_s: float


def cost_of(command, allowed=(0,), environment=None):
    """Runs a command, its output thrown away. Ends this program with the command's message where it fails."""
    with tempfile.TemporaryFile() as message:
        actions = [(os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0), (os.POSIX_SPAWN_DUP2, message.fileno(), 2)]
        begin = time.perf_counter()
        process = os.posix_spawnp(command[0], [str(word) for word in command], environment or os.environ, file_actions=actions)
        _, status, usage = os.wait4(process, 0)
        wall_s = time.perf_counter() - begin
        code = os.waitstatus_to_exitcode(status)
        if code not in allowed:
            message.seek(0)
            sys.exit(f"{' '.join(map(str, command))}: exit code {code}: {message.read().decode(errors='replace').strip()}")
    return Cost(wall_s, usage.ru_utime + usage.ru_stime)


def alternating(tasks, n_rounds):
    """Each task of {name: call that returns Cost} in turn, n_rounds times, so that all meet the same machine."""
    costs = {name: [] for name in tasks}
    for _ in range(n_rounds):
        for name, task in tasks.items():
            costs[name].append(task())
    return costs


def least_cpu_s(costs):
    return min(cost.cpu_s for cost in costs)


def median_wall_s(costs):
    return statistics.median(cost.wall_s for cost in costs)


def slope(x, y):
    """Slope of log y against log x by least squares, and its standard error from what the line leaves: (slope, error)."""
    x, y = [math.log(v) for v in x], [math.log(v) for v in y]
    mean_x, mean_y = statistics.fmean(x), statistics.fmean(y)
    square = sum((a - mean_x) ** 2 for a in x)
    by = sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y)) / square
    left = sum((b - mean_y - by * (a - mean_x)) ** 2 for a, b in zip(x, y))
    return by, math.sqrt(left / (len(x) - 2) / square) if len(x) > 2 else math.nan
