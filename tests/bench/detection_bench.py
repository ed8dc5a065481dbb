#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Detector against aubioonset and a NumPy/SciPy trigger + stack + cross-correlation, in one run.

    detection_bench.py BOUNCELAB RECORDING.wav TRUTH.csv

Prints user time (getrusage of the child, start of the program included), times real time, and recall, precision within 1 ms
and error about the median of each drop. RECORDING and TRUTH as `bouncelab synthesize` writes them. aubioonset: Debian package
aubio-tools; left out, saying so, where it is not installed.
"""
import csv
import os
import resource
import shutil
import subprocess
import sys
import tempfile

import numpy as np


def trigger_stack_correlate(path):
    """Envelope trigger at 8 times the median, dead time 15 ms; average of the triggered sounds; parabola on the peak of
    the cross-correlation."""
    from scipy.io import wavfile
    from scipy.signal import correlate
    rate, x = wavfile.read(path)
    x = x.astype(np.float32) / np.abs(x).max()
    hop = int(rate / 2000)
    level = np.sqrt(np.add.reduceat(x * x, np.arange(0, len(x), hop)))
    over = np.nonzero(level > 8 * np.median(level))[0]
    starts, last = [], -1e9
    for k in over:
        if (k - last) * hop > 0.015 * rate:
            starts.append(k * hop)
        last = k
    n, lead, reach = int(0.006 * rate), int(0.002 * rate), int(0.001 * rate)
    rows = [(s, x[s - lead - reach:s + n + reach]) for s in starts if s > lead + reach and s + n + reach < len(x)]
    if not rows:
        return np.zeros(0)
    wave = max(rows, key=lambda r: np.abs(r[1]).max())[1][reach:-reach]
    for _ in range(2):
        times, total = [], np.zeros_like(wave)
        for s, y in rows:
            c = correlate(y, wave, "valid")
            k = int(np.clip(np.argmax(c), 1, len(c) - 2))
            a, b, d = c[k - 1], c[k], c[k + 1]
            times.append((s + k - reach + 0.5 * (a - d) / (a - 2 * b + d)) / rate)
            total += y[k:k + len(wave)]
        wave = total / np.linalg.norm(total)
    return np.array(times)


def timed(command):
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    out = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return out, resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def report(name, found, truth, drop, seconds, sound_s):
    found = np.sort(found)
    near = np.abs(found[:, None] - truth[None, :]) if len(found) else np.ones((1, len(truth)))
    offset = np.median([found[i] - t for i, t in zip(near.argmin(0), truth)]) if len(found) else 0.0
    error = np.array([found[np.argmin(np.abs(found - offset - t))] - offset - t for t in truth]) if len(found) else near[0]
    hit = np.abs(error) < 1e-3
    for d in set(drop):  # a latency that a drop has as a whole is nothing that intervals see
        if (here := hit & (drop == d)).any():
            error[here] -= np.median(error[here])
    rms = np.sqrt(np.mean(error[hit] ** 2)) * 1e6 if hit.any() else float("nan")
    print(f"{name:38s} {seconds:8.2f} s {sound_s / seconds:8.0f} x   recall {hit.mean():.3f}  "
          f"precision {hit.sum() / max(1, len(found)):.3f}  rms {rms:9.3f} us")


def main():
    program, recording, truth_file = sys.argv[1:4]
    rows = list(csv.DictReader(open(truth_file)))
    truth = np.array([float(r["t_s"]) + float(r.get("travel_time_s") or 0) for r in rows])
    drop = np.array([int(r["drop"]) for r in rows])
    from scipy.io import wavfile
    rate, x = wavfile.read(recording)
    sound_s = len(x) / rate
    print(f"{recording}: {sound_s:.0f} s at {rate} Hz, {len(truth)} impacts; user time, times real time")
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "onsets.csv")
        _, seconds = timed([program, "detect", recording, "--out", out, "--quiet", "--threads", "1"])
        report("bouncelab detect", np.array([float(r["t_s"]) for r in csv.DictReader(open(out))]), truth, drop, seconds, sound_s)
    if shutil.which("aubioonset"):
        out, seconds = timed(["aubioonset", "-i", recording])
        report("aubioonset", np.array([float(t) for t in out.split()]), truth, drop, seconds, sound_s)
    else:
        print("aubioonset is not installed (Debian package aubio-tools)")
    before = resource.getrusage(resource.RUSAGE_SELF).ru_utime
    found = trigger_stack_correlate(recording)
    report("NumPy/SciPy trigger + stack + correlate", found, truth, drop,
           resource.getrusage(resource.RUSAGE_SELF).ru_utime - before, sound_s)


if __name__ == "__main__":
    main()
