#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""How much longer the program would take to start if it were linked with HDF5, which it loads only for files that need it.

    start_up.py BOUNCELAB [--runs 200] [--hdf5 /path/of/libhdf5.so]

Runs `bouncelab --version` and `bouncelab detect` on samples/clean.flac (12 s of sound) as they are and with HDF5 loaded at the
start (LD_PRELOAD), in turn, and prints medians and their ratio. The module is worth its code while a ratio is above 1.1.
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
parser.add_argument("--runs", type=int, default=200)
parser.add_argument("--hdf5", default=ctypes.util.find_library("hdf5_serial") or ctypes.util.find_library("hdf5"))
arguments = parser.parse_args()
if not arguments.hdf5:
    sys.exit("libhdf5 was not found; name it with --hdf5")

recording = Path(__file__).resolve().parents[2] / "samples" / "clean.flac"
with tempfile.TemporaryDirectory() as folder:
    commands = {"--version": ["--version"],
                "detect": ["detect", str(recording), "--out", f"{folder}/onsets.csv", "--force", "--quiet"]}
    for name, command in commands.items():
        seconds = {"": [], arguments.hdf5: []}
        for _ in range(arguments.runs):
            for library, times in seconds.items():
                environment = os.environ | ({"LD_PRELOAD": library} if library else {})
                start = time.perf_counter()
                subprocess.run([arguments.bouncelab, *command], env=environment, stdout=subprocess.DEVNULL, check=True)
                times.append(time.perf_counter() - start)
        alone, loaded = (statistics.median(times) for times in seconds.values())
        print(f"{name}: {1e3 * alone:.1f} ms, with HDF5 {1e3 * loaded:.1f} ms, ratio {loaded / alone:.2f}")
