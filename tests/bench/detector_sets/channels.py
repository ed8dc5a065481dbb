# SPDX-License-Identifier: GPL-3.0-or-later
"""Stereo recordings of a real ball, each channel by itself: intervals must differ as the stated errors say. No truth is needed.
A ball that wanders moves the delay between the channels by up to some 30 us."""
import os

import numpy as np

import match
import sound
from bars import Bar
from program import detect

TITLE = "two channels of one ball"
LONGEST_S = 1.0
TOLERANCE_S = 5e-3


def two_sounds(path):
    """Whether the file has two channels that are no copies of each other."""
    header = sound.header_of(path)
    if not header or header[1] != 2:
        return False
    _, samples = sound.read(path)
    left, right = samples.T
    return np.std(left) > 0 and np.std(right) > 0 and np.max(np.abs(left / np.std(left) - right / np.std(right))) > 1e-3


def compared(left, right):
    """Differences of intervals and their stated errors in s, and which are between impacts that neither channel doubts."""
    i, j, _ = match.matched(left.t_s, right.t_s, TOLERANCE_S)
    if len(i) < 2:
        return np.zeros(0), np.zeros(0), np.zeros(0, bool)
    use = (np.diff(i) == 1) & (np.diff(left.t_s[i]) < LONGEST_S)
    difference = np.diff(right.t_s[j] - left.t_s[i])
    variance = left.sigma_t_s[i]**2 + right.sigma_t_s[j]**2
    clear = ~(left.doubtful[i] | right.doubtful[j])
    use &= np.isfinite(variance[1:] + variance[:-1])
    return difference[use], np.sqrt(variance[1:] + variance[:-1])[use], (clear[1:] & clear[:-1])[use]


def measure(program, options):
    for folder in options.channels:
        for path in sound.below(folder):
            if not two_sounds(path):
                continue
            left, right = (detect(program, path, channel, options.timeout_s) for channel in (0, 1))
            differences, sigma, clear = compared(left, right)
            pulls = differences / sigma
            yield {"file": os.path.basename(path), "n_left": len(left.t_s), "n_right": len(right.t_s), "pulls": [float(p) for p in pulls],
                   "clear_pulls": [float(p) for p in pulls[clear]], "difference_us": 1e6 * float(np.median(np.abs(differences))) if len(pulls) else None}


def bars(records):
    pulls = np.abs(np.concatenate([r["pulls"] for r in records]))
    if not len(pulls):
        return []
    worst = max(match.rms(r["pulls"]) for r in records if r["pulls"])
    return [Bar("median pull of intervals", float(np.median(pulls)) / 0.6745, least=0.7, most=1.3), Bar("rms pull of the worst recording", worst, most=5),
            Bar("95th percentile of the pull", float(np.percentile(pulls, 95))), Bar("intervals compared", len(pulls)),
            Bar("recordings", len(records))]


def remarks(records):
    for r in records:
        yield "%s: %d and %d impacts, %d intervals, differ by %s us in the median, pull rms %.2f, clear %d: %.2f" % (
            r["file"], r["n_left"], r["n_right"], len(r["pulls"]), r["difference_us"] and round(r["difference_us"], 2), match.rms(r["pulls"]),
            len(r["clear_pulls"]), match.rms(r["clear_pulls"]))
