# SPDX-License-Identifier: GPL-3.0-or-later
"""What the benchmarks share: one number a line as JSON, which tools/bench collects; the cost of a command; rows of the page."""
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path


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


def cost_of(command, allowed=(0,)):
    """Runs a command, its output thrown away. Ends this program with the command's message where it fails."""
    with tempfile.TemporaryFile() as message:
        actions = [(os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0), (os.POSIX_SPAWN_DUP2, message.fileno(), 2)]
        begin = time.perf_counter()
        try:
            process = os.posix_spawnp(command[0], [str(word) for word in command], os.environ, file_actions=actions)
        except OSError as error:
            sys.exit(f"{command[0]}: {error.strerror}; tools/setup --bench installs what is compared with")
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


@dataclass(frozen=True)
class Row:
    """A line of the table. @var bar  ("at least" or "at most", a number); None: stated, not judged"""
    what: str
    ratio: float
    bar: tuple | None
    measured: str

    def cells(self):
        judged = ""
        if self.bar:
            met = self.ratio >= self.bar[1] if self.bar[0] == "at least" else self.ratio <= self.bar[1]
            judged = f"{self.bar[0]} {self.bar[1]:g}: {'met' if met else '**missed**'}"
        return self.what, f"{number(self.ratio)} ×", judged, self.measured


def number(value):
    """Three significant digits, thousands separated."""
    digits = f"{value:.2e}"
    return f"{float(digits):,.{max(0, 2 - int(digits.split('e')[1]))}f}"


def seconds(value):
    unit, size = next((u for u in (("s", 1), ("ms", 1e-3), ("µs", 1e-6)) if value >= u[1]), ("ns", 1e-9))
    return f"{number(value / size)} {unit}"


@dataclass(frozen=True)
class Bench:
    """What every part needs: the build folder, a folder for its files, whether the run is a quick try."""
    build: Path
    folder: Path
    quick: bool

    @property
    def program(self):
        return self.build / "tools" / "bouncelab" / "bouncelab"

    def detect(self, recording):
        """On one thread. That nothing is found (exit code 1) is an answer too."""
        return cost_of([self.program, "detect", recording, "--out", self.folder / "onsets.csv", "--force", "--quiet", "--threads", 1], allowed=(0, 1))

    def values(self, *command):
        """{case: {what: value}} of what a benchmark prints, one number a line as JSON."""
        words = [str(word) for word in command]
        run = subprocess.run(words, stdout=subprocess.PIPE, text=True, check=False, env=os.environ | {"OMP_NUM_THREADS": "1"})
        if run.returncode != 0:
            sys.exit(f"tools/bench: failed: {' '.join(words)}")
        values = {}
        for line in map(json.loads, run.stdout.splitlines()):
            values.setdefault(line["case"], {})[line["what"]] = line["value"]
        return values

    def compiled(self, name, *arguments):
        return self.values(self.build / "tests" / "bench" / name, *arguments)
