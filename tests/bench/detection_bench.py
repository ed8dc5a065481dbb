#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Detector against aubioonset and a NumPy/SciPy trigger + stack + cross-correlation, in one run.

    detection_bench.py BOUNCELAB (RECORDING.wav TRUTH)...

TRUTH: TRUTH.csv as `bouncelab synthesize` writes it beside its sound, or a JSON file with impacts[] of t_s and drop. Prints CPU time (user +
system, the least of five runs taken in turn; the start of a program counts, that of Python and its imports does not), times real time,
and recall, precision and error within 1 ms, the error about the median of each drop. aubioonset: Debian package aubio-tools; left out,
saying so, where it is not installed.
"""
import csv
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np  # noqa: E402
from scipy import fft  # noqa: E402
from scipy.io import wavfile  # noqa: E402

N_RUNS = 5


def samples_of(path):
    rate, x = wavfile.read(path)
    x = x.astype(np.float32)
    if x.ndim > 1:  # the channel with the largest peak over its own level
        x = x[:, np.argmax(np.abs(x).max(0) / (np.median(np.abs(x), 0) + 1e-9))]
    return rate, x / np.abs(x).max()


def triggers(x, rate):
    """Starts of sounds: half a millisecond of differenced sound 2.5 times louder than the quiet and twice louder than 1.5 to 3 ms before."""
    hop = int(rate / 2000)
    y = np.diff(x[:len(x) // hop * hop], prepend=0).reshape(-1, hop)
    level = np.abs(y).max(1)
    before = np.maximum.reduce([np.roll(level, k) for k in (3, 4, 5, 6)])
    over = np.nonzero((level > 2.5 * np.median(level)) & (level > 2 * before))[0]
    starts, last = [], -100
    for k in over:
        if k - last > 0.012 * 2000:
            starts.append(k * hop)
            last = k
    return np.array(starts, int)


def trigger_stack_correlate(path):
    """Triggered sounds of 12 ms are correlated with their template, eight times oversampled and with a parabola on the peak, moved by what
    that says and averaged to the next template; three rounds, from the loudest. What does not sound like it is no impact."""
    rate, x = samples_of(path)
    lead, n, up = int(0.002 * rate), fft.next_fast_len(int(0.012 * rate), True), 8
    starts = triggers(x, rate)
    starts = starts[(starts >= lead) & (starts + n <= len(x))]
    if len(starts) < 3:
        return np.zeros(0)
    rows = x[(starts - lead)[:, None] + np.arange(n)[None, :]]
    spectra = fft.rfft(rows * np.hanning(2 * n)[n:][None, :].astype(np.float32))
    wave = spectra[np.argmax(np.abs(rows).max(1))]
    omega = 2 * np.pi * np.arange(len(wave)) / n
    power = np.sqrt((np.abs(spectra) ** 2).sum(1))
    for _ in range(3):
        c = fft.irfft(spectra * wave.conj()[None, :], up * n)
        c = np.concatenate([c[:, -up * lead:], c[:, :up * lead]], 1)  # within 2 ms
        k = np.clip(c.argmax(1), 1, c.shape[1] - 2)
        i = np.arange(len(k))
        a, b, d = c[i, k - 1], c[i, k], c[i, k + 1]
        shift = (k - up * lead + 0.5 * (a - d) / (a - 2 * b + d + 1e-30)) / up
        moved = spectra * np.exp(1j * omega[None, :] * shift[:, None]).astype(np.complex64)
        alike = (moved * wave.conj()[None, :]).real.sum(1) / (power * np.linalg.norm(wave)) > 0.5
        wave = moved[alike].sum(0)
    return ((starts - lead + shift) / rate)[alike]


def cpu_s(who):
    usage = resource.getrusage(who)
    return usage.ru_utime + usage.ru_stime


def timed(task, who):
    before = cpu_s(who)
    out = task()
    return out, cpu_s(who) - before


def run(command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def bouncelab(program, recording):
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "onsets.csv")
        run([program, "detect", recording, "--out", out, "--quiet", "--threads", "1"])
        return np.array([float(r["t_s"]) for r in csv.DictReader(open(out))])


def truth_of(path):
    if path.endswith(".json"):
        impacts = json.load(open(path))["impacts"]
        return np.array([i["t_s"] for i in impacts]), np.array([i["drop"] for i in impacts])
    rows = list(csv.DictReader(open(path)))
    t_s = np.array([float(r["t_s"]) + float(r.get("travel_time_s") or 0) for r in rows])
    return t_s, np.array([int(r["drop"]) for r in rows])


def report(name, found, truth, drop, seconds, sound_s):
    found = np.sort(found)
    hit = np.zeros(len(truth), bool)
    error = np.ones(len(truth))
    if len(found):
        near = found[np.abs(found[:, None] - truth[None, :]).argmin(0)] - truth
        offset = np.median(near)
        error = found[np.abs(found[:, None] - offset - truth[None, :]).argmin(0)] - offset - truth
        hit = np.abs(error) < 1e-3
    for d in set(drop):  # a latency that a drop has as a whole is nothing that intervals see
        if (here := hit & (drop == d)).any():
            error[here] -= np.median(error[here])
    rms, median = (np.sqrt(np.mean(error[hit] ** 2)) * 1e6, np.median(np.abs(error[hit])) * 1e6) if hit.any() else (np.nan, np.nan)
    print(f"  {name:40s} {seconds:7.3f} s {sound_s / seconds:6.0f} x   recall {hit.mean():.3f}  precision {hit.sum() / max(1, len(found)):.3f}"
          f"  rms {rms:8.3f} us  median {median:8.3f} us")


def compare(program, recording, truth_file):
    truth, drop = truth_of(truth_file)
    rate, x = wavfile.read(recording)
    sound_s = len(x) / rate
    print(f"{recording}: {sound_s:.0f} s at {rate} Hz, {len(truth)} impacts")
    contenders = {"bouncelab detect": (lambda: bouncelab(program, recording), resource.RUSAGE_CHILDREN),
                  "NumPy/SciPy trigger + stack + correlation": (lambda: trigger_stack_correlate(recording), resource.RUSAGE_SELF)}
    if shutil.which("aubioonset"):
        contenders["aubioonset"] = (lambda: np.array([float(t) for t in run(["aubioonset", "-i", recording]).split()]), resource.RUSAGE_CHILDREN)
    else:
        print("  aubioonset is not installed (Debian package aubio-tools)")
    least = dict.fromkeys(contenders, np.inf)
    found = {}
    for _ in range(N_RUNS):
        for name, (task, who) in contenders.items():
            found[name], seconds = timed(task, who)
            least[name] = min(least[name], seconds)
    for name in contenders:
        report(name, found[name], truth, drop, least[name], sound_s)


def main():
    if len(sys.argv) < 4 or len(sys.argv) % 2:
        sys.exit(__doc__)
    for k in range(2, len(sys.argv), 2):
        compare(sys.argv[1], sys.argv[k], sys.argv[k + 1])


if __name__ == "__main__":
    main()
