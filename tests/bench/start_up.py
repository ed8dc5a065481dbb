#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""How long the program takes to start, beside a program that does nothing, an older one, and itself linked with HDF5.

    start_up.py BOUNCELAB [--old BOUNCELAB] [--runs 200] [--hdf5 /path/of/libhdf5.so]

Runs `--version`, `balls`, `fit --help` and `detect` on samples/clean.flac (12 s of sound) in turn with the others: /bin/true;
--old; the program with HDF5 loaded at the start (LD_PRELOAD). Prints medians of wall time and of processor time, which
neighbours on the machine disturb less, ratios to the program as it is, and how many libraries it loads. The HDF5 module is
worth its code while its ratio is above 1.1.
"""
import argparse
import ctypes.util
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("bouncelab")
parser.add_argument("--old")
parser.add_argument("--runs", type=int, default=200)
parser.add_argument("--hdf5", default=ctypes.util.find_library("hdf5_serial") or ctypes.util.find_library("hdf5"))
arguments = parser.parse_args()
if not arguments.hdf5:
    sys.exit("libhdf5 was not found; name it with --hdf5")


def run(command, environment):
    """Wall and processor seconds of one run."""
    start = time.perf_counter()
    child = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(child.pid, 0)
    wall = time.perf_counter() - start
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode:
        sys.exit(f"{' '.join(command)} ended with {child.returncode}")
    return wall, usage.ru_utime + usage.ru_stime


def libraries(program):
    return sum("=>" in line for line in subprocess.run(["ldd", program], capture_output=True, text=True, check=True).stdout.splitlines())


programs = {"as it is": ([arguments.bouncelab], {}), "/bin/true": (["/bin/true"], {}),
            "with HDF5": ([arguments.bouncelab], {"LD_PRELOAD": arguments.hdf5})}
if arguments.old:
    programs["old"] = ([arguments.old], {})
for name in (arguments.bouncelab, arguments.old):
    if name:
        print(f"{name}: {libraries(name)} shared libraries")
recording = Path(__file__).resolve().parents[2] / "samples" / "clean.flac"
with tempfile.TemporaryDirectory() as folder:
    commands = {"--version": ["--version"], "balls": ["balls"], "fit --help": ["fit", "--help"],
                "detect": ["detect", str(recording), "--out", f"{folder}/onsets.csv", "--force", "--quiet"]}
    for name, command in commands.items():
        times = {program: [] for program in programs}
        for _ in range(arguments.runs):
            for program, (line, environment) in programs.items():
                times[program].append(run(line + command, os.environ | environment))
        medians = {program: [statistics.median(column) for column in zip(*rows)] for program, rows in times.items()}
        for program, (wall, processor) in medians.items():
            print(f"{name}, {program}: {1e3 * wall:.1f} ms, of the processor {1e3 * processor:.1f} ms, "
                  f"ratio {processor / medians['as it is'][1]:.2f}")
