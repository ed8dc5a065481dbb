#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""`bouncelab detect`, one thread, against aubioonset and NumPy/SciPy's trigger + stack + cross-correlation (trigger_stack.py), in one run.

    detection_bench.py BOUNCELAB [--runs 5] [--minutes 8] [--hour 60]            recordings that are synthesized, channels, threads, sounds without a ball
    detection_bench.py BOUNCELAB [--runs 5] --recording SOUND.wav TRUTH ...      recordings of one's own

TRUTH: TRUTH.csv as `bouncelab synthesize` writes it beside its sound, or a JSON file with impacts[] of t_s and drop. Prints processor time (user and
system, the least of the runs, which take turns; the start of a program counts, that of Python and its imports does not), and recall,
precision and error within 1 ms, the error about the median of each drop. aubioonset: Debian package aubio-tools; left out where it is not installed.
"""
import argparse
import csv
import json
import os
import shutil
import subprocess
import tempfile
import time
import wave

import sounds
from bench_lines import Cost, alternating, cost_of, least_cpu_s, print_line
from trigger_stack import np, trigger_stack_correlate

SCIPY = "SciPy's trigger + stack + correlation"


def in_process(task):
    """@return what the task returns, and its cost"""
    wall_s, cpu_s = time.perf_counter(), time.process_time()
    out = task()
    return out, Cost(time.perf_counter() - wall_s, time.process_time() - cpu_s)


def detect(program, recording, out, threads=1):
    """Nothing found (exit code 1) is an answer too."""
    return cost_of([program, "detect", recording, "--out", out, "--force", "--quiet", "--threads", threads], allowed=(0, 1))


def truth_of(path):
    if path.endswith(".json"):
        with open(path) as file:
            impacts = json.load(file)["impacts"]
        return np.array([i["t_s"] for i in impacts]), np.array([i["drop"] for i in impacts])
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    t_s = np.array([float(r["t_s"]) + float(r.get("travel_time_s") or 0) for r in rows])
    return t_s, np.array([int(r["drop"]) for r in rows])


def times_in(table):
    with open(table, newline="") as file:
        return np.array([float(row["t_s"]) for row in csv.DictReader(file)])


def print_score(case, name, found, truth, drop):
    found = np.sort(found)
    hit, error = np.zeros(len(truth), bool), np.ones(len(truth))
    if len(found):
        nearest = lambda offset: found[np.abs(found[:, None] - offset - truth[None, :]).argmin(0)]
        offset = np.median(nearest(0) - truth)
        error = nearest(offset) - offset - truth
        hit = np.abs(error) < 1e-3
    for d in set(drop):  # a latency that a drop has as a whole is nothing that intervals see
        if (here := hit & (drop == d)).any():
            error[here] -= np.median(error[here])
    print_line("detect", case, name + ", recall", float(hit.mean()), "1")
    print_line("detect", case, name + ", precision", float(hit.sum() / max(1, len(found))), "1")
    if hit.any():
        print_line("detect", case, name + ", median error", float(np.median(np.abs(error[hit]))), "s")


def compare(program, case, recording, truth_file, n_runs, folder):
    found = {}
    with wave.open(recording) as opened:
        print_line("detect", case, "sound", opened.getnframes() / opened.getframerate(), "s")

    def bouncelab():
        cost = detect(program, recording, f"{folder}/onsets.csv")
        found["bouncelab"] = times_in(f"{folder}/onsets.csv")
        return cost

    def scipy():
        found[SCIPY], cost = in_process(lambda: trigger_stack_correlate(recording))
        return cost

    def aubio():
        return cost_of(["aubioonset", "-i", recording])

    print_line("detect", case, "impacts", len(truth_of(truth_file)[0]), "1")
    tasks = {"bouncelab": bouncelab, SCIPY: scipy}
    if shutil.which("aubioonset"):
        tasks["aubioonset"] = aubio
        lines = subprocess.run(["aubioonset", "-i", recording], capture_output=True, text=True, check=True).stdout.split()
        found["aubioonset"] = np.array([float(t) for t in lines])
    for name, costs in alternating(tasks, n_runs).items():
        print_line("detect", case, name, least_cpu_s(costs), "s")
        print_line("detect", case, name + ", runs", n_runs, "1")
        print_score(case, name, found[name], *truth_of(truth_file))


def measure_channels_and_threads(program, length_s, n_runs, folder):
    mono, _ = sounds.drops(program, folder, length_s, 44100)
    stereo, _ = sounds.drops(program, folder, length_s, 44100, channels=2)
    out = f"{folder}/onsets.csv"
    tasks = {"mono, one thread": lambda: detect(program, mono, out), "mono, two threads": lambda: detect(program, mono, out, 2),
             "stereo, one thread": lambda: detect(program, stereo, out), "stereo, two threads": lambda: detect(program, stereo, out, 2)}
    for name, costs in alternating(tasks, n_runs).items():
        print_line("detect", "channels and threads", name + ", processor", least_cpu_s(costs), "s")
        print_line("detect", "channels and threads", name + ", wall", min(cost.wall_s for cost in costs), "s")


def measure_kinds(program, hour_s, folder):
    """No recording of any kind may be slow: 2 minutes of each, and an hour full of sounds."""
    for kind in sounds.KINDS:
        case = f"without a ball: {kind}, 2 minutes"
        recording = sounds.kind_of_sound(folder, kind, 120, 44100)
        costs = alternating({"bouncelab": lambda: detect(program, recording, f"{folder}/onsets.csv")}, 2)["bouncelab"]
        print_line("detect", case, "sound", 120.0, "s")
        print_line("detect", case, "bouncelab", least_cpu_s(costs), "s")
    case = f"without a ball: 5 bursts a second, {hour_s / 60:g} minutes"
    recording = sounds.kind_of_sound(folder, "5 bursts a second", hour_s, 44100)
    print_line("detect", case, "sound", hour_s, "s")
    cost = detect(program, recording, f"{folder}/onsets.csv")
    print_line("detect", case, "bouncelab", cost.cpu_s, "s")
    if shutil.which("aubioonset"):
        print_line("detect", case, "aubioonset", cost_of(["aubioonset", "-i", recording]).cpu_s, "s")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bouncelab")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--minutes", type=float, default=8, help="length of the recordings with drops")
    parser.add_argument("--hour", type=float, default=60, help="minutes of the long recording full of sounds")
    parser.add_argument("--recording", nargs=2, action="append", metavar=("SOUND", "TRUTH"), help="these instead")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for recording, truth in options.recording or []:
            compare(options.bouncelab, os.path.basename(recording), recording, truth, options.runs, folder)
        if options.recording:
            return
        for rate_hz, bits in ((44100, 16), (96000, 24)):
            recording, truth = sounds.drops(options.bouncelab, folder, 60 * options.minutes, rate_hz, bits)
            compare(options.bouncelab, f"drops, {rate_hz} Hz", recording, truth, options.runs, folder)
        measure_channels_and_threads(options.bouncelab, 60 * options.minutes, options.runs, folder)
        measure_kinds(options.bouncelab, 60 * options.hour, folder)


if __name__ == "__main__":
    main()
