#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The closed loop, by stage: what the program itself writes into summary.json.

    loop_bench.py BOUNCELAB [--drops N]      --drops: of the paper's 2,320, for a quick look
"""
import argparse
import json
import tempfile

from bench_lines import cost_of, print_line

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("bouncelab")
parser.add_argument("--drops", type=int)
arguments = parser.parse_args()

with tempfile.TemporaryDirectory() as folder:
    command = [arguments.bouncelab, "loop", "--preset", "paper", "--no-memory", "--out", f"{folder}/loop", "--quiet"]
    cost = cost_of(command + (["--drops", arguments.drops] if arguments.drops else []))
    with open(f"{folder}/loop/summary.json") as file:
        summary = json.load(file)
case = "paper" if not arguments.drops else f"{arguments.drops} drops"
print_line("loop", case, "whole command, wall", cost.wall_s, "s")
print_line("loop", case, "whole command, processor", cost.cpu_s, "s")
print_line("loop", case, "impacts", summary["n_impacts"], "1")
print_line("loop", case, "sound", summary["sound_s"], "s")
print_line("loop", case, "peak memory", summary["peak_memory_bytes"], "B")
for clock, seconds in (("wall", summary["seconds"]), ("processor", summary["processor_seconds"])):
    for stage, value in seconds.items():
        print_line("loop", case, f"{stage}, {clock}", value, "s")
