#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""How well impacts are timed, over signal-to-noise ratio and sample rate, on the project's own synthesizer at its hardest.

    timing_table.py BOUNCELAB [--seeds 3] [--snr 0,10,20,30,40] [--rates 16000,44100,48000,96000,192000]

Each recording is one drop of 80 impacts of the paper's ball on glass, struck at a place drawn at random, with 1/f noise below
300 Hz, hum, drift, clicks, knocks of a second object, a tenth of the impacts followed by a knock within 12 ms, a robot, and
mode amplitudes that wander by 0.2 from impact to impact. One line for each rate and ratio, medians over the seeds:

recall, precision  one-to-one matches within 1 ms; `least` is the worst seed's recall
error_us           rms after a constant and a multiple of v^(-1/5) (where in the contact an onset is) are taken off
ratio              that over the rms Cramer-Rao bound of the truth (known waveform, no wander); `worst` over the seeds
eps                rms error of T_{k+1} / T_k
pull, pull_law     rms of error over sigma_t_s, about the mean and after the same line is taken off

The truth is t_s + travel_time_s, the time at which the sound begins at the sensor. Needs python3-numpy.
"""
import argparse
import csv
import os
import subprocess
import sys
import tempfile

import numpy as np

HARDEST = ("--positions drawn --noise-corner 300 --hum 0.5 --drift 0.5 --clicks 0.3 --knocks 0.1 --double-hits 0.1 "
           "--timbre-wander 0.2 --robot --pause 2.5 --bits 24").split()
TOLERANCE_S = 1e-3


def column(rows, name):
    return np.array([float(row[name]) for row in rows])


def read(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def matches(truth, found):
    """Pairs (true, found) within the tolerance about the best offset, nearest first, one to one."""
    offset = 0.0
    for tolerance in (5e-3, TOLERANCE_S, TOLERANCE_S):
        pairs = [(abs(found[j] - offset - truth[i]), i, j) for i in range(len(truth)) for j in
                 range(np.searchsorted(found, truth[i] + offset - tolerance),
                       np.searchsorted(found, truth[i] + offset + tolerance, side="right"))]
        used_i, used_j, kept = set(), set(), []
        for _, i, j in sorted(pairs):
            if i not in used_i and j not in used_j:
                used_i.add(i), used_j.add(j), kept.append((i, j))
        if not kept:
            break
        offset = float(np.median([found[j] - truth[i] for i, j in kept]))
    return sorted(kept)


def without_contact(error, speed):
    """What is left after a + b v^(-1/5), far-off errors counting less."""
    base = np.stack([np.ones(len(error)), speed**-0.2], 1)
    weight = np.ones(len(error))
    for _ in range(20):
        fit = np.linalg.lstsq(base * weight[:, None], error * weight, rcond=None)[0]
        rest = error - base @ fit
        weight = 1 / np.sqrt(1 + (rest / (2e-9 + 3 * np.median(np.abs(rest))))**2)
    return rest


def score(truth_rows, found_rows):
    truth = column(truth_rows, "t_s") + column(truth_rows, "travel_time_s")
    found = column(found_rows, "t_s")
    pairs = matches(truth, found) if len(found) else []
    result = {"recall": len(pairs) / len(truth), "precision": len(pairs) / max(1, len(found))}
    if len(pairs) < 5:
        return result
    i, j = np.array(pairs).T
    error = found[j] - truth[i]
    rest = without_contact(error, column(truth_rows, "v_mps")[i])
    sigma = column(found_rows, "sigma_t_s")[j]
    error -= np.average(error, weights=sigma**-2)
    bound = np.sqrt(np.mean(column(truth_rows, "sigma_t_s")[i]**2))
    three = [k for k in range(len(i) - 2) if i[k + 2] == i[k] + 2]
    ratio = lambda t, k: (t[k + 2] - t[k + 1]) / (t[k + 1] - t[k])
    eps = np.array([ratio(found[j], k) - ratio(truth[i], k) for k in three])
    result.update(error_us=1e6 * np.sqrt(np.mean(rest**2)), ratio=np.sqrt(np.mean(rest**2)) / bound,
                  eps=np.sqrt(np.mean(eps**2)) if len(eps) else np.nan,
                  pull=np.sqrt(np.mean((error / sigma)**2)), pull_law=np.sqrt(np.mean((rest / sigma)**2)))
    return result


def run(program, impacts, rate, snr_db, seed, folder):
    sound, truth, onsets = (os.path.join(folder, name) for name in ("sound.wav", "truth.csv", "onsets.csv"))
    subprocess.run([program, "synthesize", impacts, "--rate", str(rate), "--snr-db", str(snr_db), "--seed", str(seed), "--out",
                    sound, "--truth", truth, "--force", "--quiet", *HARDEST], check=True)
    if os.path.exists(onsets):
        os.remove(onsets)
    subprocess.run([program, "detect", sound, "--out", onsets, "--force", "--quiet"], stderr=subprocess.DEVNULL, check=False)
    return score(read(truth), read(onsets) if os.path.exists(onsets) else [])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--snr", default="0,10,20,30,40")
    parser.add_argument("--rates", default="16000,44100,48000,96000,192000")
    options = parser.parse_args()
    names = ["recall", "least", "precision", "error_us", "ratio", "worst", "eps", "pull", "pull_law"]
    print("%8s %5s" % ("rate_hz", "snr"), " ".join("%9s" % name for name in names))
    with tempfile.TemporaryDirectory() as folder:
        impacts = [os.path.join(folder, "impacts%d.csv" % seed) for seed in range(options.seeds)]
        for seed, path in enumerate(impacts):
            subprocess.run([options.program, "simulate", "--drops", "1", "--impacts", "80", "--seed", str(100 + seed), "--out",
                            path, "--quiet"], check=True)
        for rate in options.rates.split(","):
            for snr_db in options.snr.split(","):
                scores = [run(options.program, path, rate, snr_db, 100 + seed, folder) for seed, path in enumerate(impacts)]
                values = {name: np.array([s.get(name, np.nan) for s in scores]) for name in names}
                values["least"], values["worst"] = values["recall"], values["ratio"]
                pick = {"least": np.nanmin, "worst": np.nanmax}
                line = [pick.get(name, np.nanmedian)(values[name]) if np.isfinite(values[name]).any() else np.nan
                        for name in names]
                print("%8s %5s" % (rate, snr_db), " ".join("%9.3g" % value for value in line), flush=True)


if __name__ == "__main__":
    sys.exit(main())
