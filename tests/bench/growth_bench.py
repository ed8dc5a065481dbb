#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""How cost grows: processor time of whole commands, one thread, against length, rate, channels, drops and samples.

    growth_bench.py BOUNCELAB [--runs 3] [--quick]

The least of the runs; the cases of a series take turns; fits with memory run once. What a command costs before it has read anything is taken off.
"""
import argparse
import tempfile

import sounds
from bench_lines import alternating, cost_of, least_cpu_s, print_line

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("bouncelab")
parser.add_argument("--runs", type=int, default=2)
parser.add_argument("--quick", action="store_true", help="short series")
arguments = parser.parse_args()
bouncelab = arguments.bouncelab
start_s = least_cpu_s(alternating({"": lambda: cost_of([bouncelab, "--version"])}, 10)[""])


def series(name, commands, n_runs=arguments.runs):
    """@param commands  {abscissa: command}"""
    tasks = {x: lambda command=command: cost_of([bouncelab, *command, "--threads", 1, "--force", "--quiet"], allowed=(0, 1))
             for x, command in commands.items()}
    for x, costs in alternating(tasks, n_runs).items():
        print_line("growth", name, f"{x:g}", least_cpu_s(costs) - start_s, "s")


def detections(folder, cases):
    """@param cases  {abscissa: arguments of sounds.drops}"""
    return {x: ["detect", sounds.drops(bouncelab, folder, **case)[0], "--out", f"{folder}/onsets.csv"] for x, case in cases.items()}


def measure_sounds(folder):
    minutes = (1, 2, 4) if arguments.quick else (1, 2, 4, 8, 16, 32)
    rates = (22050, 44100, 88200) if arguments.quick else (16000, 22050, 44100, 48000, 88200, 96000, 192000)
    channels = (1, 2, 4) if arguments.quick else (1, 2, 4, 6, 8)
    series("detect against length [min]", detections(folder, {m: {"length_s": 60 * m, "rate_hz": 44100} for m in minutes}))
    series("detect against rate [Hz]", detections(folder, {r: {"length_s": 120, "rate_hz": r} for r in rates}))
    series("detect against channels", detections(folder, {c: {"length_s": 120, "rate_hz": 44100, "channels": c} for c in channels}))
    series("detect in bursts against length [min]", {
        m: ["detect", sounds.kind_of_sound(folder, "5 bursts a second", 60 * m, 44100), "--out", f"{folder}/onsets.csv"] for m in minutes[:5]})
    impacts = f"{folder}/drops_120s.csv"
    series("synthesize against rate [Hz]", {r: ["synthesize", impacts, "--rate", r, "--out", f"{folder}/again.wav"] for r in rates})
    series("synthesize against length [min]", {
        m: ["synthesize", f"{folder}/drops_{60 * m:g}s.csv", "--rate", 44100, "--out", f"{folder}/again.wav"] for m in minutes})


def measure_fits(folder):
    drops = (4, 8, 16) if arguments.quick else (8, 16, 32, 64, 128, 256, 512)
    fits, with_memory, tables = {}, {}, {}
    for n in drops:
        impacts, samples = f"{folder}/{n}.impacts.csv", f"{folder}/{n}.samples.csv"
        cost_of([bouncelab, "simulate", "--drops", n, "--impacts", 95, "--asperities", 100000, "--out", impacts, "--quiet"])
        tables[95 * n] = ["restitution", impacts, "--out", samples]
        cost_of([bouncelab, *tables[95 * n], "--quiet"])
        fits[95 * n] = ["fit", samples, "--out", f"{folder}/fit.json", "--method", "asymmetric-laplace"]
        if n <= 64:  # a minute for the longest
            with_memory[95 * n] = ["fit", samples, "--out", f"{folder}/fit.json", "--method", "memory"]
    series("restitution against impacts", tables)
    series("fit, impacts independent, against impacts", fits)
    series("fit with memory against impacts", with_memory, 1)


def measure_simulation(folder):
    drops = (400, 800, 1600) if arguments.quick else (400, 800, 1600, 3200, 6400, 12800)
    series("simulate against drops, smooth ball", {
        n: ["simulate", "--drops", n, "--impacts", 95, "--asperities", 1, "--out", f"{folder}/impacts.csv"] for n in drops})


with tempfile.TemporaryDirectory() as work:
    measure_sounds(work)
    measure_fits(work)
    measure_simulation(work)
