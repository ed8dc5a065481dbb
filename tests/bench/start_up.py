#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""How long programs take to start, on the clock: bouncelab, `true`, `python3 -c pass`, and a detection in 12 s of sound.

    start_up.py BOUNCELAB [--runs 200] [--hdf5 /path/of/libhdf5.so]

All take turns; prints the median of each. bouncelab is also started with HDF5 loaded (LD_PRELOAD), which it loads only for
files that need it: that is worth its code while HDF5 at the start takes 1.1 times the time.
"""
import argparse
import ctypes.util
import os
import tempfile
from pathlib import Path

from bench_lines import alternating, cost_of, least_cpu_s, median_wall_s, print_line

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("bouncelab")
parser.add_argument("--runs", type=int, default=200)
parser.add_argument("--hdf5", default=ctypes.util.find_library("hdf5_serial") or ctypes.util.find_library("hdf5"))
arguments = parser.parse_args()

recording = Path(__file__).resolve().parents[2] / "samples" / "clean.flac"
with tempfile.TemporaryDirectory() as folder:
    version = [arguments.bouncelab, "--version"]
    detect = [arguments.bouncelab, "detect", recording, "--out", f"{folder}/onsets.csv", "--force", "--quiet"]
    commands = {"true": (["true"], None), "python3 -c pass": (["/usr/bin/python3", "-c", "pass"], None), "bouncelab --version": (version, None),
                "bouncelab detect, 12 s of sound": (detect, None)}
    if arguments.hdf5:
        loaded = os.environ | {"LD_PRELOAD": arguments.hdf5}
        commands["bouncelab --version, HDF5 loaded"] = (version, loaded)
        commands["bouncelab detect, 12 s of sound, HDF5 loaded"] = (detect, loaded)
    tasks = {name: lambda command=command, environment=environment: cost_of(command, environment=environment)
             for name, (command, environment) in commands.items()}
    for name, costs in alternating(tasks, arguments.runs).items():
        print_line("start-up", name, "wall, median", median_wall_s(costs), "s")
        print_line("start-up", name, "runs", arguments.runs, "1")
        print_line("start-up", name, "processor, least", least_cpu_s(costs), "s")
