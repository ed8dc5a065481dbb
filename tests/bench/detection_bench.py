# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows of the page of tools/bench: `bouncelab detect` on one thread and the whole chain, against aubioonset and NumPy/SciPy's trigger, stack
and cross-correlation (trigger_stack.py). aubioonset: Debian package aubio-tools."""
import csv
import json
import subprocess
import time

import sounds
from bench_lines import Cost, Row, alternating, cost_of, least_cpu_s, seconds
from trigger_stack import np, trigger_stack_correlate


def in_process(task):
    """@return what the task returns, and its cost"""
    wall_s, cpu_s = time.perf_counter(), time.process_time()
    result = task()
    return result, Cost(time.perf_counter() - wall_s, time.process_time() - cpu_s)


def recall_and_precision(found_s, truth):
    """Within 1 ms about the median offset of a detector."""
    with open(truth, newline="") as file:
        truth_s = np.array([float(row["t_s"]) + float(row["travel_time_s"] or 0) for row in csv.DictReader(file)])
    found_s = np.array(found_s)
    error_s = found_s[np.abs(found_s[:, None] - truth_s).argmin(0)] - truth_s
    n_hit = np.sum(np.abs(error_s - np.median(error_s)) < 1e-3)
    return f"{n_hit / len(truth_s):.2f} / {n_hit / len(found_s):.2f}"


def contenders(bench, rate_hz, bits, least):
    """bouncelab, aubioonset and SciPy in turn on the paper's drops in noise."""
    length_s = 120 if bench.quick else 480
    recording, truth = sounds.drops(bench.program, bench.folder, length_s, rate_hz, bits)
    scores = {}

    def scipy():
        found_s, cost = in_process(lambda: trigger_stack_correlate(recording))
        scores["SciPy"] = recall_and_precision(found_s, truth)
        return cost

    tasks = {"bouncelab": lambda: bench.detect(recording), "aubioonset": lambda: cost_of(["aubioonset", "-i", recording]), "SciPy": scipy}
    cost_s = {name: least_cpu_s(costs) for name, costs in alternating(tasks, 2 if bench.quick else 7).items()}
    with open(bench.folder / "onsets.csv", newline="") as file:
        scores["bouncelab"] = recall_and_precision([float(row["t_s"]) for row in csv.DictReader(file)], truth)
    printed = subprocess.run(["aubioonset", "-i", recording], capture_output=True, text=True, check=True).stdout
    scores["aubioonset"] = recall_and_precision([float(t) for t in printed.split()], truth)
    ours = f"{length_s / 60:g} min of drops, WAV of {bits} bits: {seconds(cost_s['bouncelab'])}, {scores['bouncelab']}"
    for name, bar in (("aubioonset", least), ("SciPy", 1.5)):
        yield Row(f"detect, {rate_hz / 1000:g} kHz: {name} over bouncelab", cost_s[name] / cost_s["bouncelab"], ("at least", bar),
                  f"{ours}; {name} {seconds(cost_s[name])}, {scores[name]}")


def stereo(bench):
    tasks = {}
    for channels in (1, 2):
        recording, _ = sounds.drops(bench.program, bench.folder, 120 if bench.quick else 480, 44100, channels=channels)
        tasks[channels] = lambda recording=recording: bench.detect(recording)
    mono_s, stereo_s = [least_cpu_s(costs) for costs in alternating(tasks, 2 if bench.quick else 7).values()]
    yield Row("detect, 44.1 kHz: stereo over mono", stereo_s / mono_s, ("at most", 1.7), f"the same drops by two sensors: {seconds(stereo_s)}; by one: {seconds(mono_s)}")


def slowest_without_a_ball(bench):
    cost_s = {}
    for kind, minutes in [(kind, 2) for kind in sounds.KINDS] + ([] if bench.quick else [("5 bursts a second", 20)]):
        recording = sounds.kind_of_sound(bench.folder, kind, 60 * minutes, 44100)
        tasks = {"ours": lambda: bench.detect(recording), "aubio": lambda: cost_of(["aubioonset", "-i", recording])}
        cost_s[f"{kind}, {minutes} min"] = [least_cpu_s(costs) for costs in alternating(tasks, 2).values()]
    kind, (ours_s, aubio_s) = min(cost_s.items(), key=lambda item: item[1][1] / item[1][0])
    yield Row("detect, the slowest sound without a ball: aubioonset over bouncelab", aubio_s / ours_s, ("at least", 1),
              f"of {len(cost_s)} sounds at 44.1 kHz the slowest is {kind}: {seconds(ours_s)}; aubioonset {seconds(aubio_s)}")


def chain(bench):
    """aubioonset would take minutes for the whole, so it is measured on a part; it goes through a file at constant speed."""
    part, _ = sounds.drops(bench.program, bench.folder, 480, 96000, 24)
    part_s = sounds.length_s(part)
    command = [bench.program, "loop", "--preset", "paper", "--no-memory", "--out", bench.folder / "loop", "--force", "--quiet"]
    tasks = {"ours": lambda: cost_of(command + (["--drops", 20] if bench.quick else [])), "aubio": lambda: cost_of(["aubioonset", "-i", part])}
    ours_s, aubio_s = [least_cpu_s(costs) for costs in alternating(tasks, 2).values()]
    summary = json.loads((bench.folder / "loop" / "summary.json").read_text())
    yield Row("the paper's experiment (simulate, synthesize, detect, fit) over aubioonset alone", ours_s / (aubio_s / part_s * summary["sound_s"]), None if bench.quick else ("at most", 0.6),
              f"`loop --preset paper --no-memory`, {summary['score']['n_true']:,} impacts in {summary['sound_s'] / 3600:.2f} h at 96 kHz, all cores: {seconds(ours_s)}; "
              f"aubioonset {seconds(aubio_s)} for {part_s / 60:.1f} min of it, scaled")


def rows(bench):
    yield from chain(bench)
    yield from contenders(bench, 44100, 16, 2.5)
    yield from contenders(bench, 96000, 24, 3)
    yield from stereo(bench)
    yield from slowest_without_a_ball(bench)
