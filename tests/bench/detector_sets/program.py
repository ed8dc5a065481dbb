# SPDX-License-Identifier: GPL-3.0-or-later
"""One run of `bouncelab detect`: what it found and the processor time it took."""
import csv
import dataclasses
import json
import os
import resource
import subprocess
import tempfile

import numpy as np


@dataclasses.dataclass(frozen=True)
class Found:
    """Impacts in the order of time; `failure` says why there are none where the program did not do its work."""
    t_s: np.ndarray
    sigma_t_s: np.ndarray
    drop: np.ndarray
    doubtful: np.ndarray
    duration_s: float
    cpu_s: float
    failure: str = ""

    @property
    def n_drops(self):
        return len(set(self.drop))


def children_cpu_s():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def rows_of(table):
    if not os.path.exists(table):
        return []
    with open(table, newline="") as file:
        return [row for row in csv.DictReader(file) if row["t_s"]]


def duration_of(summary):
    try:
        return float(json.loads(summary)["recordings"][0]["duration_s"] or 0)
    except (ValueError, LookupError):
        return 0.0


def detect(program, recording, channel=None, timeout_s=600):
    """Exit code 1 (nothing usable) is an answer like 0; any other, and no end within the time, is a failure."""
    with tempfile.TemporaryDirectory() as folder:
        table = os.path.join(folder, "onsets.csv")
        command = [*([program] if isinstance(program, str) else program), "detect", recording, "--out", table, "--json", "--threads", "1"]
        command += [] if channel is None else ["--channel", str(channel)]
        before = children_cpu_s()
        try:
            run = subprocess.run(command, capture_output=True, text=True, timeout=timeout_s, check=False)
            failure = "" if run.returncode in (0, 1) else run.stderr.strip().splitlines()[-1:] or ["exit code %d" % run.returncode]
            summary = run.stdout
        except subprocess.TimeoutExpired:
            failure, summary = ["no end within %g s" % timeout_s], ""
        cpu_s = children_cpu_s() - before
        rows = sorted(rows_of(table), key=lambda row: float(row["t_s"]))
    return Found(t_s=np.array([float(row["t_s"]) for row in rows]), sigma_t_s=np.array([float(row["sigma_t_s"] or "nan") for row in rows]),
                 drop=np.array([int(row["drop"]) for row in rows], int), doubtful=np.array(["doubtful" in row["flags"] for row in rows], bool),
                 duration_s=duration_of(summary), cpu_s=cpu_s, failure="".join(failure))
