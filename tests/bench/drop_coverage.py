#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Coverage of the fit's intervals where impacts of one drop depend on each other: many runs of simulated drops, each fitted.

    python3 tests/bench/drop_coverage.py --bin BOUNCELAB [--runs 40] [--drops 400] [--radii uniform constant] [--keep FOLDER] [--jobs N]

Impact times are exact: nothing but the rough ball scatters. For slopes the truth is the mean of all runs, whose own error makes pulls smaller by
1 / (2 runs). eps(v) is judged twice: by that mean, and by the law put in, from which a rough ball's peak differs by a bias of its own (docs/physics.md)
that no interval of one run contains where drops are many. Bar: 95 % intervals of all slopes and of eps by the mean cover .92 to .98. Of 40 runs .95 is good to
.034, so --runs 200 decides where 40 do not. Exit code 1 where a bar is missed. Needs python3-numpy.
"""
import argparse
import concurrent.futures
import json
import os
import subprocess
import sys
import tempfile

import numpy

# of the same mean square offset of the contact, so that both give the same slopes
RADII = {"uniform": ["--asperities", "1000000", "--radius-law", "uniform:5e-4,1.5e-3"], "constant": ["--asperities", "71378", "--radius-law", "constant:1e-3"]}
LAW = {2: (-1.1534488580952884, 0.0467), 4: (0.7982665609447948, 0.1339), 5: (4 / 15, -0.2876)}  # C_i, A_i of the simulation's default
SPEEDS = ["0.3", "0.6", "1.19"]
WINDOWS = ["0.3", "0.6", "1.0"]
QUANTITIES = ["eps(%s)" % v for v in SPEEDS] + ["%s(%s)" % (side, v) for v in WINDOWS for side in ("peak", "rising", "falling", "ratio")]


def law(v):
    return 1 + sum(c * a * v ** (i / 10) for i, (c, a) in LAW.items())


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", required=True, help="the bouncelab program")
    parser.add_argument("--runs", type=int, default=40, help="repetitions of the experiment (%(default)s)")
    parser.add_argument("--drops", type=int, default=400, help="of each run (%(default)s)")
    parser.add_argument("--impacts", type=int, default=97, help="of each drop (%(default)s)")
    parser.add_argument("--radii", nargs="+", choices=list(RADII), default=list(RADII))
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="(%(default)s)")
    parser.add_argument("--keep", metavar="FOLDER", help="keep the samples here, and take them from here again")
    return parser.parse_args()


def call(program, *words):
    subprocess.run([program, *map(str, words), "--quiet", "--force", "--threads", "1"], check=True, stdout=subprocess.DEVNULL)


def samples_of(options, folder, radii, run):
    """Name of the samples of one run: another ball, other drops."""
    name = os.path.join(folder, "%s-%d-%d-%d.csv" % (radii, options.drops, options.impacts, run))
    if not os.path.exists(name):
        impacts = name + ".impacts.csv"
        call(options.bin, "simulate", "--drops", options.drops, "--impacts", options.impacts, *RADII[radii], "--seed", run, "--out", impacts)
        call(options.bin, "restitution", impacts, "--out", name)
        for leftover in (impacts, impacts + ".meta.json"):
            os.remove(leftover)
    return name


def fitted(options, folder, scratch, radii, run):
    """Estimates of one run in the order of QUANTITIES."""
    out = os.path.join(scratch, "%s-%d.json" % (radii, run))
    samples = samples_of(options, folder, radii, run)
    call(options.bin, "fit", samples, "--out", out, "--nodes", *SPEEDS, "--windows", *WINDOWS, "--goodness-replicates", "0")
    with open(out) as file:
        fit = json.load(file)
    estimates = [{"value": node["peak"], "se": node["peak_se"], "ci95": [node["peak"] + k * 1.96 * node["peak_se"] for k in (-1, 1)]}
                 for node in fit["curve"]["nodes"]]
    return estimates + [window[key] for window in fit["histograms"] for key in ("peak_eps", "slope_rising", "slope_falling", "slope_ratio")]


def against(estimates, truth):
    """(bias in mean standard errors, sd of pulls, coverage at 95 %)"""
    value, se = (numpy.array([e[key] for e in estimates]) for key in ("value", "se"))
    covered = numpy.mean([e["ci95"][0] <= truth <= e["ci95"][1] for e in estimates])
    return (value.mean() - truth) / se.mean(), ((value - truth) / se).std(ddof=1), covered


def show(radii, runs):
    """Prints the table; returns the number of bars missed."""
    print("\n%s radii, %d runs\n%-14s %12s %9s %9s %6s %6s" % (radii, len(runs), "", "truth", "spread", "stated", "sd", "c95"))
    missed = 0
    for name, estimates in zip(QUANTITIES, zip(*runs)):
        value = numpy.array([e["value"] for e in estimates])
        stated = numpy.mean([e["se"] for e in estimates])
        _, sd, c95 = against(estimates, value.mean())
        bad = not 0.92 <= c95 <= 0.98 and not name.startswith("peak")
        missed += bad
        print("%-14s %12.6g %9.2e %9.2e %6.2f %6.3f%s" % (name, value.mean(), value.std(ddof=1), stated, sd, c95, " !" if bad else ""))
        if name.startswith(("eps", "peak")):
            truth = law(float(name[name.index("(") + 1:-1]))
            bias, sd, c95 = against(estimates, truth)
            print("%-14s %12.6g %9s %9s %6s %6.3f  bias of the rough ball %+.1e, %+.2f standard errors" % ("  by the law", truth, "", "", "", c95, bias * stated, bias))
    sys.stdout.flush()
    return missed


def main():
    options = arguments()
    missed = 0
    with tempfile.TemporaryDirectory() as scratch, concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        folder = options.keep or scratch
        os.makedirs(folder, exist_ok=True)
        for radii in options.radii:
            missed += show(radii, list(pool.map(lambda run: fitted(options, folder, scratch, radii, run), range(1, options.runs + 1))))
    print("\n%d bars missed" % missed)
    return missed > 0


if __name__ == "__main__":
    sys.exit(main())
