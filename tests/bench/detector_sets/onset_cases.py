# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings with exact truth (NAME.json with impacts[] of t_s, drop, v and crb_us, beside NAME.wav): recall, precision, the ratio of the
error to the Cramer-Rao bound after a + b v^(-1/5) (where in the contact an onset is), and the pull of eps."""
import glob
import json
import os

import numpy as np

import match
from bars import Bar, ratio, total
from program import detect

TITLE = "onset cases"
TOLERANCE_S = 1e-3
REACH_S = 30e-3
HARD = ("c09", "c13")  # long ringing; chatter until intervals are 2 ms


def cases_in(folder):
    for path in sorted(glob.glob(os.path.join(folder, "*.json"))):
        if os.path.exists(path[:-5] + ".wav"):
            yield path, path[:-5] + ".wav"


def truth_of(path):
    """t_s, drop, speed in m/s, bound in s, ordered by time."""
    with open(path) as file:
        impacts = sorted(json.load(file)["impacts"], key=lambda impact: impact["t_s"])
    column = lambda name: np.array([impact[name] for impact in impacts], float)
    return column("t_s"), column("drop").astype(int), column("v"), column("crb_us") * 1e-6


def without_contact(error, speed):
    """What is left after a + b v^(-1/5), far-off errors counting less."""
    base = np.stack([np.ones(len(error)), speed**-0.2], 1)
    weight = np.ones(len(error))
    rest = error
    for _ in range(20):
        rest = error - base @ np.linalg.lstsq(base * weight[:, None], error * weight, rcond=None)[0]
        weight = 1 / np.sqrt(1 + (rest / (2e-15 + 3 * np.median(np.abs(rest))))**2)
    return rest


def measure(program, options):
    for folder in options.onset_cases:
        for path, recording in cases_in(folder):
            truth, drop, speed, bound_s = truth_of(path)
            found = detect(program, recording, None, options.timeout_s)
            i, j, offset = match.matched(truth, found.t_s, TOLERANCE_S, REACH_S)
            rest = without_contact(found.t_s[j] - truth[i] - offset, speed[i]) if len(i) > 3 else np.zeros(0)
            yield {"file": os.path.basename(recording), "n_true": len(truth), "n_found": len(i), "n_all": len(found.t_s),
                   "ratio": match.rms(rest) / match.rms(bound_s[i]) if len(rest) else float("nan"),
                   "eps_pull": match.rms(match.eps_pulls(truth, drop, found.t_s, found.sigma_t_s, i, j)),
                   "duration_s": found.duration_s, "cpu_s": found.cpu_s, "failure": found.failure}


def hard(record):
    return record["file"].startswith(HARD)


def bars(records):
    others = [r["n_found"] / r["n_true"] for r in records if not r["file"].startswith("c13")]
    chatter = [r["n_found"] / r["n_true"] for r in records if r["file"].startswith("c13")]
    out = [Bar("recall of the worst file but chatter", min(others, default=float("nan")), least=1),
           Bar("recall of chatter", min(chatter, default=float("nan")), least=0.99),
           Bar("precision of the worst file", min(ratio(r["n_found"], r["n_all"]) for r in records), least=0.99),
           Bar("precision", ratio(total(records, "n_found"), total(records, "n_all")), least=1),
           Bar("ratio to the bound, median", float(np.median([r["ratio"] for r in records])), most=1.35),
           Bar("ratio to the bound, ringing and chatter", max((r["ratio"] for r in records if hard(r)), default=float("nan")), most=5),
           Bar("pull of eps, least", min(r["eps_pull"] for r in records), least=0.8),
           Bar("pull of eps, most", max(r["eps_pull"] for r in records), most=1.25)]
    return out + [Bar("x real time", ratio(total(records, "duration_s"), total(records, "cpu_s")))]


def remarks(records):
    for r in records:
        yield "%s: recall %.3f, precision %.3f, ratio %.2f, pull of eps %.2f %s" % (
            r["file"], r["n_found"] / r["n_true"], ratio(r["n_found"], r["n_all"]), r["ratio"], r["eps_pull"], r["failure"])
